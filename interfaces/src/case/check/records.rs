//! Probes and references.

use super::is_own;
use super::measured::{self, is_off_wall};
use super::parts::{check_box, check_names};
use crate::case::findings::Findings;
use crate::case::keys::Case;
use crate::case::nearest::{nearest, remedy_for_name};
use crate::case::probe::{Probe, ProbeSide, Reference};
use words::probe::ProbeQuantity;

pub(super) fn check(file: &Case, findings: &mut Findings) {
    check_names("probe", file.probes.iter().map(|probe| probe.name.as_str()), findings);
    for (i, probe) in file.probes.iter().enumerate() {
        check_probe(&format!("probe.{i}"), probe, file, findings);
    }
    let dimension = file.general.dimension;
    let columns: Vec<_> =
        file.probes.iter().flat_map(|probe| probe.all_columns(dimension).concat()).collect();
    for (i, reference) in file.references.iter().enumerate() {
        check_reference(&format!("reference.{i}"), reference, &columns, findings);
    }
}

fn check_probe(key: &str, probe: &Probe, file: &Case, findings: &mut Findings) {
    let (side, quantities) = quantities(probe.on);
    let force = probe.quantity == ProbeQuantity::Force;
    let of_a_box = probe.quantity.is_of_a_box();
    if !quantities.contains(&probe.quantity) {
        let there: Vec<_> = quantities.iter().map(|quantity| format!("\"{quantity}\"")).collect();
        let problem = format!("is not recorded on {side}");
        findings.add(format!("{key}.quantity"), problem, format!("there is {}", there.join(", ")));
    } else if force && probe.at.is_some() {
        findings.add(
            format!("{key}.at"),
            "is not for a force, which is the sum over the whole",
            "leave it out",
        );
    } else if of_a_box && probe.at.is_some() {
        findings.add(
            format!("{key}.at"),
            "is not for what is taken of all the fluid in a box",
            "leave it out, or write the box",
        );
    } else if !force && !of_a_box && probe.at.is_none() {
        findings.add(format!("{key}.at"), "is missing", "add the point (m)");
    }
    if let Some(bounds) = &probe.bounds {
        if of_a_box {
            check_box(&format!("{key}.box"), bounds, findings);
        } else {
            let remedy = "leave it out; there are boxes for \"extent\", \"centroid\", \"spread\"";
            findings.add(format!("{key}.box"), "does not go with the quantity", remedy);
        }
    }
    for (name, given, on) in
        [("body", &probe.body, ProbeSide::Structure), ("wall", &probe.wall, ProbeSide::Wall)]
    {
        if given.is_some() && probe.on != on {
            findings.add(
                format!("{key}.{name}"),
                format!("does not go with a probe on {side}"),
                "leave it out",
            );
        }
    }
    check_frame(key, probe, file, findings);
    measured::check(key, probe, file, findings);
    match probe.on {
        ProbeSide::Structure => check_on_structure(key, probe, file, findings),
        ProbeSide::Fluid => check_on_fluid(key, probe, file, findings),
        ProbeSide::Wall => check_on_wall(key, probe, file, findings),
    }
}

/// What a probe looks at, in words, and what there is to record of it.
fn quantities(side: ProbeSide) -> (&'static str, &'static [ProbeQuantity]) {
    match side {
        ProbeSide::Structure => (
            "the structure",
            &[
                ProbeQuantity::Displacement,
                ProbeQuantity::Position,
                ProbeQuantity::Velocity,
                ProbeQuantity::Stress,
                ProbeQuantity::Strain,
                ProbeQuantity::VonMisesStress,
                ProbeQuantity::Force,
                ProbeQuantity::Moment,
            ],
        ),
        ProbeSide::Fluid => (
            "the fluid",
            &[
                ProbeQuantity::Pressure,
                ProbeQuantity::Velocity,
                ProbeQuantity::Extent,
                ProbeQuantity::Centroid,
                ProbeQuantity::Spread,
                ProbeQuantity::HydrostaticError,
                ProbeQuantity::SurfaceHeight,
                ProbeQuantity::Flux,
            ],
        ),
        ProbeSide::Wall => {
            ("a wall", &[ProbeQuantity::Pressure, ProbeQuantity::Force, ProbeQuantity::Moment])
        }
    }
}

/// What the probe goes with is there, and is one thing.
fn check_frame(key: &str, probe: &Probe, file: &Case, findings: &mut Findings) {
    let Some(name) = &probe.relative_to else { return };
    let key = format!("{key}.relative_to");
    let frames = file.frames();
    let mut moves = frames.iter().filter(|(frame, _)| frame == name).map(|(_, motion)| motion);
    match moves.next() {
        None => {
            let names: Vec<&str> = frames.iter().map(|(frame, _)| *frame).collect();
            let remedy =
                remedy_for_name(name, &names, "[[fluid.wall]], [[structure.clamp]] or [motion.NAME]");
            findings.add(key, "is no wall, clamp or motion", remedy);
        }
        Some(first) if moves.any(|other| other != first) => {
            findings.add(key, "is the name of two that move differently", "give each its own name");
        }
        Some(_) if probe.quantity == ProbeQuantity::HydrostaticError => {
            findings.add(key, "is not for what is taken from rest", "leave it out");
        }
        Some(_) if matches!(probe.quantity, ProbeQuantity::Strain | ProbeQuantity::VonMisesStress) => {
            findings.add(key, "is not for what is the same in every frame", "leave it out");
        }
        Some(_) => {}
    }
}

/// The thing that a probe names, or the only one there is.
fn chosen<'a, T>(
    key: &str,
    (what, section): (&str, &str),
    name: Option<&String>,
    things: &'a [T],
    name_of: impl Fn(&T) -> &str,
    findings: &mut Findings,
) -> Option<&'a T> {
    let names: Vec<_> = things.iter().map(&name_of).collect();
    match (name, things) {
        (Some(name), _) => {
            let found = things.iter().find(|thing| name_of(thing) == name);
            if found.is_none() {
                let remedy = remedy_for_name(name, &names, section);
                findings.add(format!("{key}.{what}"), format!("is no {what}"), remedy);
            }
            found
        }
        (None, [only]) => Some(only),
        (None, []) => {
            findings.add(format!("{key}.on"), format!("there is no {what}"), format!("add a {section}"));
            None
        }
        (None, _) => {
            let names: Vec<_> = names.iter().map(|name| format!("\"{name}\"")).collect();
            let problem = format!("is missing, and there is more than one {what}");
            findings.add(format!("{key}.{what}"), problem, format!("add one of {}", names.join(", ")));
            None
        }
    }
}

fn check_on_structure(key: &str, probe: &Probe, file: &Case, findings: &mut Findings) {
    let Some(structure) = &file.structure else {
        findings.add(format!("{key}.on"), "there is no [structure]", "add one, or leave the probe out");
        return;
    };
    let of_fluid = matches!(probe.quantity, ProbeQuantity::Force | ProbeQuantity::Moment);
    if of_fluid && file.fluid.is_none() {
        findings.add(
            format!("{key}.quantity"),
            "there is no fluid whose force it were",
            "leave the probe out",
        );
    }
    // Another program's structure may have no bodies in the case; which probes it has, it says itself.
    if structure.bodies.is_empty() && !is_own(&structure.participant) {
        return;
    }
    let section = ("body", "[[structure.body]]");
    let body = chosen(key, section, probe.body.as_ref(), &structure.bodies, |body| &body.name, findings);
    if let (Some(body), Some(at)) = (body, &probe.at)
        && probe.quantity != ProbeQuantity::Moment
        && body.bounds.is_clear_of(at, structure.particle_spacing)
    {
        let problem = format!("is farther than one particle spacing from the body \"{}\"", body.name);
        findings.add(format!("{key}.at"), problem, "take a point of its reference configuration");
    }
}

fn check_on_fluid(key: &str, probe: &Probe, file: &Case, findings: &mut Findings) {
    let Some(fluid) = &file.fluid else {
        findings.add(format!("{key}.on"), "there is no [fluid]", "add one, or leave the probe out");
        return;
    };
    if probe.at.as_ref().is_some_and(|at| fluid.domain.is_clear_of(at, 0.0)) {
        findings.add(format!("{key}.at"), "is outside of fluid.domain", "take a point inside");
    }
}

fn check_on_wall(key: &str, probe: &Probe, file: &Case, findings: &mut Findings) {
    let Some(fluid) = &file.fluid else {
        findings.add(
            format!("{key}.on"),
            "there is no [fluid], whose walls these are",
            "leave the probe out",
        );
        return;
    };
    let section = ("wall", "[[fluid.wall]]");
    let wall = chosen(key, section, probe.wall.as_ref(), &fluid.walls, |wall| &wall.name, findings);
    let spacing = fluid.particle_spacing;
    if let (Some(wall), Some(at)) = (wall, &probe.at)
        && probe.quantity != ProbeQuantity::Moment
        && is_off_wall(at, wall, spacing)
    {
        let problem = format!("is farther than one particle spacing from the wall \"{}\"", wall.name);
        findings.add(format!("{key}.at"), problem, "take a point of its surface");
    }
}

fn check_reference(key: &str, reference: &Reference, columns: &[String], findings: &mut Findings) {
    if !columns.contains(&reference.probe) {
        let remedy = match nearest(&reference.probe, columns.iter().map(String::as_str)) {
            Some(meant) => format!("did you mean \"{meant}\"?"),
            None if columns.is_empty() => "add a [[probe]]".to_owned(),
            None => format!("there is {}", columns.join(", ")),
        };
        findings.add(format!("{key}.probe"), "is no column of a probe", remedy);
    }
    if reference.time.is_empty() {
        findings.add(format!("{key}.time"), "is empty", "give at least one time (s)");
    }
    // Borders that were left out are the values.
    let borders = [("low", &reference.low), ("high", &reference.high)];
    let borders = borders.into_iter().filter(|(_, border)| **border != reference.value);
    for (name, list) in std::iter::once(("value", &reference.value)).chain(borders) {
        if list.len() == reference.time.len() {
            continue;
        }
        let problem = format!("has length {}, and time has {}", list.len(), reference.time.len());
        findings.add(format!("{key}.{name}"), problem, "give one number for each time");
    }
    if let Some(k) = reference.time.windows(2).position(|pair| pair[0] >= pair[1]) {
        findings.add(format!("{key}.time.{}", k + 1), "is not later than the time before", "let times grow");
    }
    let below = |low: &[f64], high: &[f64]| low.iter().zip(high).position(|(low, high)| low > high);
    if let Some(k) = below(&reference.low, &reference.value) {
        findings.add(format!("{key}.low.{k}"), "is above its value", "low is the lower border");
    }
    if let Some(k) = below(&reference.value, &reference.high) {
        findings.add(format!("{key}.high.{k}"), "is below its value", "high is the upper border");
    }
}
