//! `meniscus schema`.

use super::say;
use std::process::ExitCode;

/// Prints the JSON schema of case files.
pub fn schema() -> ExitCode {
    say(format_args!("{:#}", interfaces::case::schema()));
    ExitCode::SUCCESS
}
