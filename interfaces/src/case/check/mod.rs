//! What types cannot say: boxes inside out, overlaps, names that mean nothing, values
//! that contradict each other.
//!
//! A number that [`super::conform`] found wrong is NaN here, and every check asks for what is wrong
//! (`low >= high`), never for what is right (`!(low < high)`): so an unknown number fails none.

mod corners;
mod fluid;
mod held;
mod measured;
mod motions;
mod overlaps;
mod parts;
mod polylines;
mod records;
mod sizes;
mod structure;

use super::coupling::CouplingScheme;
use super::defaults::characteristic_speed;
use super::errors::CaseError;
use super::findings::Findings;
use super::keys::Case;
use super::participant::{Participant, Start};
use super::section::Sections;
use serde::Deserialize as _;
use toml::{Table, Value};

/// All mistakes of a case that the schema lets pass.
///
/// The sections of `solvers` are filled in on the way; `coupling` is as written.
pub(super) fn check(file: &mut Case, coupling: Option<&Table>, solvers: &[Sections]) -> Vec<CaseError> {
    let mut findings = Findings::default();
    if let Some(fluid) = file.fluid.as_mut().filter(|fluid| fluid.characteristic_speed == 0.0) {
        fluid.characteristic_speed = characteristic_speed(fluid, &file.general.gravity);
    }
    for solver in solvers {
        (solver.resolve)(file, &mut findings);
    }
    for clamp in file.structure.iter_mut().flat_map(|structure| &mut structure.clamps) {
        clamp.rows = clamp.rows.or(clamp.face.map(|_| 0));
    }
    motions::resolve(file, &mut findings);
    let file = &*file;
    check_whole(file, coupling, &mut findings);
    if let Some(fluid) = &file.fluid {
        fluid::check(fluid, &file.general, &mut findings);
    }
    if let Some(structure) = &file.structure {
        structure::check(structure, &file.general, &mut findings);
    }
    overlaps::check(file, &mut findings);
    records::check(file, &mut findings);
    sizes::check(file, coupling, &mut findings);
    findings.errors
}

fn check_whole(file: &Case, coupling: Option<&Table>, findings: &mut Findings) {
    let case = &file.general;
    if case.title.chars().any(char::is_control) {
        findings.add("case.title", "has control characters", "write one line of plain text");
    }
    if file.fluid.is_none() && file.structure.is_none() {
        findings.add("", "the case has neither [fluid] nor [structure]", "add at least one of them");
    }
    let Some(coupling) = coupling else { return };
    if file.fluid.is_none() || file.structure.is_none() {
        let missing = if file.fluid.is_none() { "fluid" } else { "structure" };
        findings.add(
            "coupling",
            format!("there is no [{missing}] to couple"),
            format!("add [{missing}], or leave [coupling] out"),
        );
    }
    let scheme = coupling.get("scheme").and_then(|word| CouplingScheme::deserialize(word.clone()).ok());
    if !scheme.is_some_and(CouplingScheme::is_implicit) {
        for key in ["acceleration", "convergence", "extrapolation"] {
            if coupling.contains_key(key) {
                let remedy =
                    "leave it out, or take coupling.scheme = \"serial-implicit\" or \"parallel-implicit\"";
                findings.add(format!("coupling.{key}"), "an explicit scheme has no iterations", remedy);
            }
        }
    }
    let predicts = scheme.is_none_or(|scheme| scheme == CouplingScheme::SerialExplicit);
    if coupling.contains_key("prediction") && !predicts {
        let remedy = "leave it out, or take coupling.scheme = \"serial-explicit\"";
        findings.add("coupling.prediction", "only a serial explicit window has a prediction", remedy);
    }
    let shares_core = coupling.get("share_core").and_then(Value::as_bool) == Some(true);
    if shares_core && scheme.is_some_and(CouplingScheme::is_parallel) {
        let remedy = "leave it out, or take coupling.scheme = \"serial-explicit\" or \"serial-implicit\"";
        findings.add("coupling.share_core", "in parallel order both participants work at once", remedy);
    }
    let own_fluid = file.fluid.as_ref().is_some_and(|fluid| is_own(&fluid.participant));
    let own_structure = file.structure.as_ref().is_some_and(|structure| is_own(&structure.participant));
    for (key, side, wrong) in [
        ("coupling.mapping", "structure", coupling.contains_key("mapping") && own_structure),
        ("coupling.fluid_mapping", "fluid", coupling.contains_key("fluid_mapping") && own_fluid),
    ] {
        if wrong {
            let problem = format!("is for a {side} with points of its own, and our own solver has none");
            findings.add(key, problem, format!("leave it out, or name another {side}.participant"));
        }
    }
    let steady = coupling.get("steady_state").and_then(|steady| steady.get("quantities")?.as_array());
    if steady.is_some_and(Vec::is_empty) {
        let remedy = "name \"position\", \"velocity\" or \"load\", or leave it out";
        findings.add("coupling.steady_state.quantities", "names nothing that could be steady", remedy);
    }
}

/// Whether our own solver solves the side.
fn is_own(participant: &Participant) -> bool {
    participant.start() == Start::Own
}
