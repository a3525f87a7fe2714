//! `meniscus report`.

use super::{failed, say};
use crate::arguments::Report;
use std::process::ExitCode;

/// Makes the report of a run's outputs.
pub fn report(arguments: &Report) -> ExitCode {
    match output::report::write_report(&arguments.dir) {
        Ok(page) => {
            say(format_args!("{}", page.display()));
            ExitCode::SUCCESS
        }
        Err(error) => failed(error),
    }
}
