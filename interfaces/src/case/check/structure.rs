//! The structure by itself.

use super::is_own;
use super::parts::{check_box, check_face, check_filled_box, check_names, check_participant};
use crate::case::findings::Findings;
use crate::case::keys::General;
use crate::case::nearest::remedy_for_name;
use crate::case::structure::{Body, Clamp, Load, Structure};
use crate::case::velocity::InitialVelocity;

pub(super) fn check(structure: &Structure, case: &General, findings: &mut Findings) {
    check_names("structure.body", structure.bodies.iter().map(|body| body.name.as_str()), findings);
    check_names("structure.clamp", structure.clamps.iter().map(|clamp| clamp.name.as_str()), findings);
    check_names("structure.load", structure.loads.iter().map(|load| load.name.as_str()), findings);
    check_participant("structure", &structure.participant, findings);
    if structure.bodies.is_empty() && is_own(&structure.participant) {
        findings.add("structure", "there is no body in it", "add a [[structure.body]]");
    }
    for (i, body) in structure.bodies.iter().enumerate() {
        check_filled_box(
            &format!("structure.body.{i}.box"),
            &body.bounds,
            structure.particle_spacing,
            findings,
        );
        if case.dimension != 2 && body.is_off_lattice(&[]) {
            let remedy = "leave lattice_angle, jitter and relaxation out";
            findings.add(
                format!("structure.body.{i}"),
                "particles off the lattice are for two dimensions",
                remedy,
            );
        }
        if let InitialVelocity::Mode(mode) = &body.velocity {
            let key = format!("structure.body.{i}.velocity.clamped_face");
            check_face(&key, Some(mode.clamped_face), case.dimension, findings);
        }
    }
    for (i, clamp) in structure.clamps.iter().enumerate() {
        check_clamp(&format!("structure.clamp.{i}"), clamp, structure, case.dimension, findings);
        let same = |other: &&Clamp| other.body == clamp.body && other.face == clamp.face;
        if let Some(other) = structure.clamps[..i].iter().find(same).filter(|_| clamp.face.is_some()) {
            let problem = format!("holds the face that \"{}\" holds", other.name);
            findings.add(format!("structure.clamp.{i}.face"), problem, "leave one of them out");
        }
    }
    for (i, load) in structure.loads.iter().enumerate() {
        check_load(&format!("structure.load.{i}"), load, structure, case, findings);
    }
}

/// The body of that name; says so where there is none.
fn body_named<'a>(
    key: &str,
    name: &str,
    structure: &'a Structure,
    findings: &mut Findings,
) -> Option<&'a Body> {
    let found = structure.bodies.iter().find(|body| body.name == name);
    if found.is_none() {
        findings.add(
            format!("{key}.body"),
            "is no body",
            remedy_for_name(name, &names(structure), "[[structure.body]]"),
        );
    }
    found
}

fn names(structure: &Structure) -> Vec<&str> {
    structure.bodies.iter().map(|body| body.name.as_str()).collect()
}

fn check_clamp(key: &str, clamp: &Clamp, structure: &Structure, dimension: usize, findings: &mut Findings) {
    let body = body_named(key, &clamp.body, structure, findings);
    check_face(&format!("{key}.face"), clamp.face, dimension, findings);
    let kinds =
        [(clamp.face.is_some(), "face"), (clamp.bounds.is_some(), "box"), (clamp.circle.is_some(), "circle")];
    let there: Vec<_> = kinds.iter().filter(|(is_there, _)| *is_there).map(|(_, name)| *name).collect();
    match there[..] {
        [one, other, ..] => {
            findings.add(key, format!("has both {one} and {other}"), "make two clamps of it");
            return;
        }
        [] => findings.add(key, "holds nothing", "add face, box or circle"),
        [_] => {}
    }
    if clamp.face.is_none() && clamp.rows.is_some() {
        findings.add(format!("{key}.rows"), "is for a clamped face", "leave it out");
    }
    if clamp.circle.is_some() && dimension != 2 {
        findings.add(format!("{key}.circle"), "is for two dimensions", "take face or box");
    }
    match &clamp.bounds {
        None => {}
        Some(bounds) => {
            let is_box = check_box(&format!("{key}.box"), bounds, findings);
            let misses = |body: &Body| {
                let sides =
                    bounds.low.iter().zip(&bounds.high).zip(body.bounds.low.iter().zip(&body.bounds.high));
                sides
                    .into_iter()
                    .any(|((low, high), (body_low, body_high))| low >= body_high || high <= body_low)
            };
            if is_box && body.is_some_and(misses) {
                let problem = format!("holds nothing of \"{}\"", clamp.body);
                findings.add(format!("{key}.box"), problem, "let it reach into the body");
            }
        }
    }
}

fn check_load(key: &str, load: &Load, structure: &Structure, case: &General, findings: &mut Findings) {
    let body = body_named(key, &load.body, structure, findings);
    check_face(&format!("{key}.face"), load.face, case.dimension, findings);
    if load.face.is_some() && load.at.is_some() {
        findings.add(key, "has both face and at", "make two loads of it");
    }
    if let (Some(at), Some(body)) = (&load.at, body)
        && body.bounds.is_clear_of(at, 0.5 * structure.particle_spacing)
    {
        let problem = format!("is outside of \"{}\"", load.body);
        findings.add(format!("{key}.at"), problem, "take a point of the body");
    }
    if load.ramp.is_empty() {
        findings.add(format!("{key}.ramp"), "is empty", "write [[time, factor], ...], or leave it out");
    }
    if let Some(k) = load.ramp.windows(2).position(|pair| pair[0][0] >= pair[1][0]) {
        let key = format!("{key}.ramp.{}", k + 1);
        findings.add(key, "is not later than the pair before", "let times grow");
    }
}
