//! The structure by itself.

use super::{Findings, check_box, check_face, check_filled_box, check_names, check_participant, is_own};
use crate::case::nearest::nearest;
use crate::case::numerics::GradientOperator;
use crate::case::resolved::{Assumption, InitialVelocity};
use crate::case::typed::{Body, Clamp, General, Load, Material, Structure};

pub(super) fn check(structure: &Structure, case: &General, findings: &mut Findings) {
    let spacing = structure.particle_spacing.unwrap_or(case.particle_spacing);
    check_names("structure.body", structure.body.iter().map(|body| body.name.as_str()), findings);
    check_names("structure.clamp", structure.clamp.iter().map(|clamp| clamp.name.as_str()), findings);
    check_names("structure.load", structure.load.iter().map(|load| load.name.as_str()), findings);
    check_participant("structure", &structure.participant, findings);
    check_material(&structure.material, case.dimension, findings);
    if structure.body.is_empty() && is_own(&structure.participant) {
        findings.add("structure", "there is no body in it", "add a [[structure.body]]");
    }
    for (i, body) in structure.body.iter().enumerate() {
        check_filled_box(&format!("structure.body.{i}.box"), &body.bounds, spacing, findings);
        if case.dimension != 2 && body.is_off_lattice(&[]) {
            let remedy = "leave lattice_angle, jitter and relaxation out";
            findings.add(
                format!("structure.body.{i}"),
                "particles off the lattice are for two dimensions",
                remedy,
            );
        }
        if let Some(InitialVelocity::Mode(mode)) = &body.velocity {
            let key = format!("structure.body.{i}.velocity.clamped_face");
            check_face(&key, Some(mode.clamped_face), case.dimension, findings);
        }
    }
    for (i, clamp) in structure.clamp.iter().enumerate() {
        check_clamp(&format!("structure.clamp.{i}"), clamp, structure, case.dimension, findings);
    }
    for (i, load) in structure.load.iter().enumerate() {
        check_load(&format!("structure.load.{i}"), load, structure, case, findings);
    }
}

fn check_material(material: &Material, dimension: u32, findings: &mut Findings) {
    let assumption = match (dimension, material.assumption) {
        (2, Some(Assumption::ThreeDimensional)) => {
            let remedy = "take \"plane-strain\" or \"plane-stress\"";
            findings.add("structure.material.assumption", "does not fit two dimensions", remedy);
            return;
        }
        (2, assumption) => assumption.unwrap_or(Assumption::PlaneStrain),
        (_, Some(Assumption::PlaneStrain | Assumption::PlaneStress)) => {
            findings.add("structure.material.assumption", "does not fit three dimensions", "leave it out");
            return;
        }
        _ => Assumption::ThreeDimensional,
    };
    let ratio = material.poisson_ratio;
    let plane_stress = assumption == Assumption::PlaneStress;
    if ratio <= -1.0 || ratio > 0.5 || (ratio == 0.5 && !plane_stress) {
        let (range, model) = match assumption {
            Assumption::PlaneStress => ("over -1 and at most 0.5", "plane stress"),
            Assumption::PlaneStrain => ("over -1 and under 0.5", "plane strain"),
            Assumption::ThreeDimensional => ("over -1 and under 0.5", "three dimensions"),
        };
        findings.add(
            "structure.material.poisson_ratio",
            format!("must be {range} in {model}"),
            "take 0.3 for metals, 0.4 to 0.49 for rubber",
        );
    }
}

/// The body of that name; says so where there is none.
fn body_named<'a>(
    key: &str,
    name: &str,
    structure: &'a Structure,
    findings: &mut Findings,
) -> Option<&'a Body> {
    let found = structure.body.iter().find(|body| body.name == name);
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
    structure.body.iter().map(|body| body.name.as_str()).collect()
}

/// "did you mean", or what there is.
pub(super) fn remedy_for_name(name: &str, known: &[&str], section: &str) -> String {
    match (nearest(name, known.iter().copied()), known) {
        (Some(meant), _) => format!("did you mean \"{meant}\"?"),
        (None, []) => format!("add a {section} of that name"),
        (None, known) => {
            let known: Vec<_> = known.iter().map(|name| format!("\"{name}\"")).collect();
            format!("there is {}", known.join(", "))
        }
    }
}

fn check_clamp(key: &str, clamp: &Clamp, structure: &Structure, dimension: u32, findings: &mut Findings) {
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
    let gradient = structure.numerics.gradient;
    let rows = clamp.rows.map_or(gradient.clamp_rows(), |rows| rows as usize);
    if clamp.face.is_some() && rows > 0 && body.is_some_and(|body| body.is_off_lattice(&structure.clamp)) {
        findings.add(
            key,
            "its fixed rows would go on with a lattice that the body has not",
            "take the quadratic gradient and rows = 0, or a box",
        );
    }
    if clamp.circle.is_some() && dimension != 2 {
        findings.add(format!("{key}.circle"), "is for two dimensions", "take face or box");
    } else if clamp.circle.is_some() && gradient == GradientOperator::FirstOrder {
        findings.add(
            format!("{key}.circle"),
            "is held by fixed points, which the first-order gradient does not see",
            "take the quadratic gradient, or a box",
        );
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
    if let (Some(at), Some(body)) = (&load.at, body) {
        let spacing = structure.particle_spacing.unwrap_or(case.particle_spacing);
        if body.bounds.is_clear_of(at, 0.5 * spacing) {
            findings.add(
                format!("{key}.at"),
                format!("is outside of \"{}\"", load.body),
                "take a point of the body",
            );
        }
    }
    match load.ramp.as_deref() {
        Some([]) => {
            findings.add(format!("{key}.ramp"), "is empty", "write [[time, factor], ...], or leave it out");
        }
        Some(ramp) => {
            if let Some(k) = ramp.windows(2).position(|pair| pair[0][0] >= pair[1][0]) {
                findings.add(
                    format!("{key}.ramp.{}", k + 1),
                    "is not later than the pair before",
                    "let times grow",
                );
            }
        }
        None => {}
    }
}
