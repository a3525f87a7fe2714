//! `meniscus check`.

use super::{failed, say};
use crate::arguments::CaseArguments;
use interfaces::Role;
use interfaces::case::Case;
use interfaces::case::participant::Start;
use std::process::ExitCode;

/// Reports all mistakes of a case; without one, what would run.
pub fn check(arguments: &CaseArguments) -> ExitCode {
    let case = match super::load(arguments) {
        Ok(case) => case,
        Err(code) => return code,
    };
    say(format_args!("{}: no mistakes found", case.general.title));
    let roles = [Role::Fluid, Role::Structure];
    for (role, start) in roles.into_iter().filter_map(|role| Some((role, case.start(role)?))) {
        match preview(&case, role, start) {
            Ok(lines) => {
                for (what, value) in lines {
                    say(format_args!("{role:<10} {what:<24} {value}"));
                }
            }
            Err(error) => return failed(error),
        }
    }
    ExitCode::SUCCESS
}

/// What would solve a side: pairs of what and value.
fn preview(case: &Case, role: Role, start: Start<'_>) -> Result<Vec<(String, String)>, String> {
    let who = |what: &str, value: String| Ok(vec![(what.to_owned(), value)]);
    match (start, role) {
        (Start::Own, Role::Fluid) => fluid::participant::preview(case).map_err(|e| e.to_string()),
        (Start::Own, Role::Structure) => structure::participant::preview(case).map_err(|e| e.to_string()),
        (Start::Fmu(_), _) => fmu_host::preview(case, role).map_err(|e| e.to_string()),
        (Start::Command(words), _) => who("command", words.join(" ")),
        (Start::ByHand, _) => who("started", "by hand".to_owned()),
    }
}
