//! What types cannot say: lengths of vectors, boxes inside out, overlaps, names that mean nothing, values
//! that contradict each other.
//!
//! A number that [`super::conform`] found wrong is NaN here, and every check asks for what is wrong
//! (`low >= high`), never for what is right (`!(low < high)`): so an unknown number fails none.

mod fluid;
mod overlaps;
mod records;
mod structure;
mod vectors;

use super::coupling::CouplingScheme;
use super::errors::CaseError;
use super::geometry::{AxisBox, Face};
use super::typed::{CaseFile, Participant, StartWord};

/// All mistakes of a case that the schema lets pass. Vectors of a wrong length are mended with NaN.
pub(super) fn check(file: &mut CaseFile) -> Vec<CaseError> {
    let mut findings = Findings { errors: Vec::new() };
    vectors::check(file, &mut findings);
    let file = &*file;
    check_whole(file, &mut findings);
    if let Some(fluid) = &file.fluid {
        fluid::check(fluid, &file.case, &mut findings);
    }
    if let Some(structure) = &file.structure {
        structure::check(structure, &file.case, &mut findings);
    }
    overlaps::check(file, &mut findings);
    records::check(file, &mut findings);
    findings.errors
}

/// Collects mistakes.
struct Findings {
    errors: Vec<CaseError>,
}

impl Findings {
    fn add(&mut self, key: impl Into<String>, problem: impl Into<String>, remedy: impl Into<String>) {
        self.errors.push(CaseError::new(key, problem, remedy));
    }
}

fn check_whole(file: &CaseFile, findings: &mut Findings) {
    let case = &file.case;
    if case.output_interval > case.end_time {
        findings.add(
            "case.output_interval",
            format!("is longer than the run of {} s", case.end_time),
            "take at most case.end_time",
        );
    }
    if file.fluid.is_none() && file.structure.is_none() {
        findings.add("", "the case has neither [fluid] nor [structure]", "add at least one of them");
    }
    let Some(coupling) = &file.coupling else { return };
    if file.fluid.is_none() || file.structure.is_none() {
        let missing = if file.fluid.is_none() { "fluid" } else { "structure" };
        findings.add(
            "coupling",
            format!("there is no [{missing}] to couple"),
            format!("add [{missing}], or leave [coupling] out"),
        );
    }
    let iterated = [
        ("coupling.acceleration", coupling.acceleration.is_some()),
        ("coupling.convergence", coupling.convergence.is_some()),
        ("coupling.extrapolation", coupling.extrapolation.is_some()),
    ];
    if !coupling.scheme.is_some_and(CouplingScheme::is_implicit) {
        for (key, _) in iterated.into_iter().filter(|(_, written)| *written) {
            let remedy =
                "leave it out, or take coupling.scheme = \"serial-implicit\" or \"parallel-implicit\"";
            findings.add(key, "an explicit scheme has no iterations", remedy);
        }
    }
    let predicts = coupling.scheme.is_none_or(|scheme| scheme == CouplingScheme::SerialExplicit);
    if coupling.prediction.is_some() && !predicts {
        let remedy = "leave it out, or take coupling.scheme = \"serial-explicit\"";
        findings.add("coupling.prediction", "only a serial explicit window has a prediction", remedy);
    }
    if coupling.share_core == Some(true) && coupling.scheme.is_some_and(CouplingScheme::is_parallel) {
        let remedy = "leave it out, or take coupling.scheme = \"serial-explicit\" or \"serial-implicit\"";
        findings.add("coupling.share_core", "in parallel order both participants work at once", remedy);
    }
    let own_fluid = file.fluid.as_ref().is_some_and(|fluid| is_own(&fluid.participant));
    let own_structure = file.structure.as_ref().is_some_and(|structure| is_own(&structure.participant));
    for (key, side, wrong) in [
        ("coupling.mapping", "structure", coupling.mapping.is_some() && own_structure),
        ("coupling.fluid_mapping", "fluid", coupling.fluid_mapping.is_some() && own_fluid),
    ] {
        if wrong {
            let problem = format!("is for a {side} with points of its own, and our own solver has none");
            findings.add(key, problem, format!("leave it out, or name another {side}.participant"));
        }
    }
    if coupling.steady_state.as_ref().is_some_and(|s| s.quantities.as_ref().is_some_and(Vec::is_empty)) {
        let remedy = "name \"position\", \"velocity\" or \"load\", or leave it out";
        findings.add("coupling.steady_state.quantities", "names nothing that could be steady", remedy);
    }
}

/// Names are words that can stand in a column's head and in a `--set`, and each is there once.
fn check_names<'a>(list: &str, names: impl Iterator<Item = &'a str>, findings: &mut Findings) {
    let mut seen: Vec<&str> = Vec::new();
    for (index, name) in names.enumerate() {
        let key = format!("{list}.{index}.name");
        let letters = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
        if name.is_empty() || !letters || name.chars().all(|c| c.is_ascii_digit()) {
            findings.add(
                key,
                "is no name",
                "take letters, digits, \"-\" and \"_\", and at least one that is no digit",
            );
        } else if let Some(first) = seen.iter().position(|other| *other == name) {
            findings.add(key, format!("is the name of {list}.{first} too"), "give each its own name");
        }
        seen.push(name);
    }
}

/// Whether the box has its corners in order; says so where it has not.
fn check_box(key: &str, bounds: &AxisBox, findings: &mut Findings) -> bool {
    let axes = ["x", "y", "z"];
    let inside_out = bounds.low.iter().zip(&bounds.high).position(|(low, high)| low >= high);
    if let Some(axis) = inside_out {
        let (low, high) = (bounds.low[axis], bounds.high[axis]);
        findings.add(
            key,
            format!("low is not below high along {}: {low} and {high}", axes[axis]),
            "low is the corner with the least coordinates, high that with the greatest",
        );
    }
    inside_out.is_none()
}

/// A box that particles are to fill needs room for one.
fn check_filled_box(key: &str, bounds: &AxisBox, spacing: f64, findings: &mut Findings) {
    if !check_box(key, bounds, findings) {
        return;
    }
    // Lengths are differences of decimal numbers: round-off must not refuse a box of exactly one spacing.
    let least = bounds.extent().into_iter().fold(f64::INFINITY, f64::min);
    if least < spacing * (1.0 - 1e-9) {
        findings.add(
            key,
            format!("is thinner ({} m) than one particle spacing ({spacing} m)", rounded(least)),
            "take a smaller particle_spacing, or a thicker box",
        );
    }
}

fn check_face(key: &str, face: Option<Face>, dimension: u32, findings: &mut Findings) {
    if face.is_some_and(|face| face.axis() >= dimension as usize) {
        findings.add(key, "is a face in three dimensions", "take \"left\", \"right\", \"bottom\" or \"top\"");
    }
}

fn check_participant(side: &str, participant: &Participant, findings: &mut Findings) {
    let key = format!("{side}.participant");
    let said = [
        ("start", participant.start.is_some()),
        ("command", participant.command.is_some()),
        ("fmu", participant.fmu.is_some()),
    ];
    let said: Vec<&str> = said.into_iter().filter_map(|(word, is_said)| is_said.then_some(word)).collect();
    if said.len() > 1 {
        findings.add(&key, format!("has {}", said.join(" and ")), "leave all but one of them out");
    }
    let of_units = [
        ("variables", !participant.variables.is_empty()),
        ("parameters", !participant.parameters.is_empty()),
        ("record", !participant.record.is_empty()),
    ];
    if participant.fmu.is_none() {
        for (word, _) in of_units.into_iter().filter(|(_, is_said)| *is_said) {
            let remedy = format!("name the unit in {key}.fmu, or leave it out");
            findings.add(format!("{key}.{word}"), "is for functional mock-up units alone", remedy);
        }
    }
    match (&participant.command, participant.start) {
        (Some(command), None) if command.first().is_none_or(String::is_empty) => {
            findings.add(
                format!("{key}.command"),
                "names no program",
                "write [\"program\", \"argument\", ...]",
            );
        }
        _ => {}
    }
}

/// Whether our own solver solves the side.
fn is_own(participant: &Participant) -> bool {
    participant.command.is_none() && participant.fmu.is_none() && participant.start != Some(StartWord::ByHand)
}

/// Without the digits that round-off adds.
fn rounded(length: f64) -> f64 {
    format!("{length:.9e}").parse().unwrap_or(length)
}
