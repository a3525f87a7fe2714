//! `meniscus report`.

use super::{failed, say, tell};
use crate::arguments::Report;
use output::report::Shown;
use std::process::ExitCode;

/// Makes the report of a run's outputs.
pub fn report(arguments: &Report) -> ExitCode {
    let shown = Shown { times: arguments.times.clone(), view: arguments.view };
    match output::report::write_report(&arguments.dir, &shown) {
        Ok(report) => {
            say(format_args!("{}", report.page.display()));
            report.notes.iter().for_each(|note| tell(format_args!("warning: {note}")));
            ExitCode::SUCCESS
        }
        Err(error) => failed(error),
    }
}
