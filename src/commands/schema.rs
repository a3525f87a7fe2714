//! `meniscus schema`.

use std::process::ExitCode;

/// Prints the JSON schema of case files.
pub fn schema() -> ExitCode {
    println!("{:#}", interfaces::case::schema());
    ExitCode::SUCCESS
}
