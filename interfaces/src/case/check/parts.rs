//! Checks that several sections share: names, boxes, faces, participants.

use crate::case::findings::Findings;
use crate::case::geometry::AxisBox;
use crate::case::participant::Participant;
use std::borrow::Cow;
use words::geometry::Face;

/// A box with its key and name.
pub(super) struct Part<'a> {
    pub key: String,
    pub what: String,
    pub bounds: Cow<'a, AxisBox>,
}

/// Names are words that can stand in a column's head and in a `--set`, and each is there once.
pub(super) fn check_names<'a>(list: &str, names: impl Iterator<Item = &'a str>, findings: &mut Findings) {
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
pub(super) fn check_box(key: &str, bounds: &AxisBox, findings: &mut Findings) -> bool {
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
pub(super) fn check_filled_box(key: &str, bounds: &AxisBox, spacing: f64, findings: &mut Findings) {
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

pub(super) fn check_face(key: &str, face: Option<Face>, dimension: usize, findings: &mut Findings) {
    if face.is_some_and(|face| face.axis() >= dimension) {
        findings.add(key, "is a face in three dimensions", "take \"left\", \"right\", \"bottom\" or \"top\"");
    }
}

pub(super) fn check_participant(side: &str, participant: &Participant, findings: &mut Findings) {
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

/// Without the digits that round-off adds.
fn rounded(length: f64) -> f64 {
    format!("{length:.9e}").parse().unwrap_or(length)
}
