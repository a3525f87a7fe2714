//! How walls and clamps move; names are put in place of what they stand for.

use crate::case::findings::Findings;
use crate::case::keys::Case;
use crate::case::motion::{Motion, Moving};
use crate::case::nearest::remedy_for_name;
use std::collections::BTreeMap;

/// A law that is farther than this from zero at the start (m or rad) begins with a jump.
const AT_START: f64 = 1e-9;
/// Components of a direction whose squares are numbers.
const LEAST_DIRECTION: f64 = 1e-100;

/// Checks all motions, and puts each where its name is: afterwards a wall or clamp with a motion has one of
/// its own, but for names that are none.
pub(super) fn resolve(file: &mut Case, findings: &mut Findings) {
    for (name, motion) in &file.motions {
        let letters = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
        if name.is_empty() || !letters {
            findings.add(format!("motion.{name}"), "is no name", "take letters, digits, \"-\" and \"_\"");
        }
        check_motion(&format!("motion.{name}"), motion, findings);
    }
    let mut walls = Vec::new();
    for (i, wall) in file.fluid.iter_mut().flat_map(|fluid| &mut fluid.walls).enumerate() {
        let key = format!("fluid.wall.{i}.motion");
        put(&key, &mut wall.motion, &file.motions, findings);
        if wall.moves().and_then(Motion::law).is_some_and(|law| law.at(0.0).abs() > AT_START) {
            let problem = "does not begin at zero, and the wall would not stand where the case puts it";
            findings.add(key, problem, "let its law begin at 0, or add a ramp");
        }
        walls.push((wall.name.clone(), wall.motion.clone()));
    }
    for (i, clamp) in file.structure.iter_mut().flat_map(|structure| &mut structure.clamps).enumerate() {
        let key = format!("structure.clamp.{i}");
        let mut of_motion = "motion";
        if let Some(with) = &clamp.with_wall {
            if clamp.motion.is_some() {
                findings.add(&key, "has both motion and with_wall", "leave one of them out");
                continue;
            }
            of_motion = "with_wall";
            match walls.iter().find(|(name, _)| name == with) {
                Some((_, motion)) => {
                    clamp.motion.clone_from(motion);
                    clamp.with_wall = None;
                }
                None => {
                    let names: Vec<&str> = walls.iter().map(|(name, _)| name.as_str()).collect();
                    let remedy = remedy_for_name(with, &names, "[[fluid.wall]]");
                    findings.add(format!("{key}.with_wall"), "is no wall", remedy);
                }
            }
        } else {
            put(&format!("{key}.motion"), &mut clamp.motion, &file.motions, findings);
        }
        let law = clamp.moves().and_then(Motion::law);
        if law.is_some_and(|law| law.at(0.0).abs() > AT_START) {
            findings.add(
                format!("{key}.{of_motion}"),
                "does not begin at zero, and would tear what is clamped",
                "let its law begin at 0, or add a ramp",
            );
        }
    }
}

/// The motion in place of its name; one of its own is checked.
fn put(key: &str, moving: &mut Option<Moving>, motions: &BTreeMap<String, Motion>, findings: &mut Findings) {
    match moving {
        None => {}
        Some(Moving::Own(motion)) => check_motion(key, motion, findings),
        Some(Moving::Named(name)) => match motions.get(name) {
            Some(motion) => *moving = Some(Moving::Own(motion.clone())),
            None => {
                let names: Vec<&str> = motions.keys().map(String::as_str).collect();
                findings.add(key, "is no motion", remedy_for_name(name, &names, "[motion.NAME]"));
            }
        },
    }
}

fn check_motion(key: &str, motion: &Motion, findings: &mut Findings) {
    match (&motion.direction, &motion.pivot) {
        (Some(_), Some(_)) => findings.add(key, "has both direction and pivot", "leave one of them out"),
        (None, None) => findings.add(key, "leads nowhere", "add direction or pivot"),
        (Some(direction), None) if direction.iter().all(|x| x.abs() < LEAST_DIRECTION) => {
            findings.add(format!("{key}.direction"), "is zero", "give a vector with a direction");
        }
        _ => {}
    }
    let sine = motion.amplitude.is_some() || motion.period.is_some() || motion.phase.is_some();
    let kinds = [(motion.table.is_some(), "a table"), (sine, "a sine"), (motion.speed.is_some(), "a speed")];
    let there: Vec<_> = kinds.iter().filter(|(is_there, _)| *is_there).map(|(_, name)| *name).collect();
    match there[..] {
        [] => findings.add(key, "has no law over time", "add table, amplitude and period, or speed"),
        [one, other, ..] => {
            findings.add(key, format!("has both {one} and {other}"), "leave one of them out");
        }
        ["a sine"] if motion.amplitude.is_none() || motion.period.is_none() => {
            findings.add(key, "has no law over time", "add amplitude and period");
        }
        _ => {}
    }
    let Some(table) = &motion.table else { return };
    if table.len() < 2 {
        findings.add(format!("{key}.table"), "has fewer than two rows", "write [[t, value], ...]");
    }
    if let Some(k) = table.windows(2).position(|pair| pair[0][0] >= pair[1][0]) {
        findings.add(format!("{key}.table.{}", k + 1), "is not later than the row before", "let times grow");
    }
}
