//! `[fluid.participant]`, `[structure.participant]`: who solves a side.

use super::unit::{Parameters, Variables};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Who solves a side: `start`, `command` or `fmu`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Participant {
    /// Our own solver, or one that somebody starts by hand.
    pub start: Option<StartWord>,
    /// A command that the coupler starts: the program and its arguments.
    pub command: Option<Vec<String>>,
    /// A functional mock-up unit (FMI 2.0 or 3.0): its file, sought from where the case file is. A process
    /// that the coupler starts serves it.
    pub fmu: Option<PathBuf>,
    /// Variables behind the ports of an FMU, and numbers that it tells.
    #[serde(default, skip_serializing_if = "Variables::is_empty")]
    pub variables: Variables,
    /// Parameters of an FMU and their values, by name: `{ youngs_modulus = 1e6, nodes = 40 }`; its own if
    /// left out.
    #[serde(default, skip_serializing_if = "Parameters::is_empty")]
    pub parameters: Parameters,
    /// Variables of an FMU that are recorded besides its energies and the case's probes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub record: Vec<String>,
}

/// Who starts a participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StartWord {
    /// The coupler starts our own solver.
    Own,
    /// Somebody starts it by hand.
    ByHand,
}

/// Who solves a side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start<'a> {
    /// Our own solver, started by the coupler.
    Own,
    /// Another command, started by the coupler: the program and its arguments.
    Command(&'a [String]),
    /// A functional mock-up unit, in a process started by the coupler.
    Fmu(Unit<'a>),
    /// A process that somebody starts by hand.
    ByHand,
}

/// A functional mock-up unit (FMU) that solves a side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit<'a> {
    /// Its file.
    pub file: &'a Path,
    /// Variables behind its ports, as far as they have other names.
    pub variables: &'a Variables,
    /// Parameters to set before it is initialised.
    pub parameters: &'a Parameters,
    /// Variables to record besides its energies and the case's probes.
    pub record: &'a [String],
}

impl Participant {
    /// Who solves the side: our own solver where nothing is said.
    pub fn start(&self) -> Start<'_> {
        let Self { start, command, fmu, variables, parameters, record } = self;
        match (fmu, command, start) {
            (Some(file), ..) => Start::Fmu(Unit { file, variables, parameters, record }),
            (None, Some(command), _) => Start::Command(command),
            (None, None, Some(StartWord::ByHand)) => Start::ByHand,
            (None, None, Some(StartWord::Own) | None) => Start::Own,
        }
    }
}
