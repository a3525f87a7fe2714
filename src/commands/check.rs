//! `meniscus check`.

use super::{failed, say};
use crate::arguments::CaseArguments;
use interfaces::Role;
use std::process::ExitCode;

/// Reports all mistakes of a case; without one, what would run.
pub fn check(arguments: &CaseArguments) -> ExitCode {
    let case = match super::load(arguments) {
        Ok(case) => case,
        Err(code) => return code,
    };
    say(format_args!("{}: no mistakes found", case.general.title));
    let previews = [
        case.fluid.as_ref().map(|_| (Role::Fluid, fluid::participant::preview(&case))),
        case.structure.as_ref().map(|_| (Role::Structure, structure::participant::preview(&case))),
    ];
    for (role, preview) in previews.into_iter().flatten() {
        match preview {
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
