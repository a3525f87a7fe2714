//! `meniscus fluid`, `meniscus structure` and `meniscus mock`: one participant, served to a coupler.

use super::{WRONG, failed};
use crate::arguments::{Mock, Solver};
use interfaces::case::Case;
use interfaces::{Participant, Role, transport};
use std::path::Path;
use std::process::ExitCode;

/// Serves our own solver of one side.
pub fn solver(arguments: &Solver, role: Role) -> ExitCode {
    serve(&arguments.case, &arguments.run, |case| {
        super::set_threads(case);
        let out = arguments.case.parent().unwrap_or(Path::new("."));
        super::solver(case, role, out).map_err(|e| e.to_string())
    })
}

/// Serves a mock partner.
pub fn mock(arguments: &Mock) -> ExitCode {
    serve(&arguments.case, &arguments.run, |case| {
        let words: Vec<&str> = arguments.words.iter().map(String::as_str).collect();
        partners::build(&words, case.general.dimension).map_err(|e| e.to_string())
    })
}

fn serve(
    case_file: &Path,
    run: &str,
    build: impl FnOnce(&Case) -> Result<Box<dyn Participant>, String>,
) -> ExitCode {
    let case = match Case::load(case_file, &[]) {
        Ok(case) => case,
        Err(errors) => {
            eprintln!("{errors}");
            return ExitCode::from(WRONG);
        }
    };
    let mut participant = match build(&case) {
        Ok(participant) => participant,
        Err(error) => return failed(error),
    };
    match transport::serve(participant.as_mut(), run, &case.hash(), case.deadline()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failed(error),
    }
}
