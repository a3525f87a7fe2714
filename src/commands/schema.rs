//! `meniscus schema`.

use super::{SECTIONS, failed, say};
use crate::arguments::Schema;
use interfaces::case::{docs, schema as schema_of};
use std::process::ExitCode;

/// Prints the JSON schema of case files, or makes the tables of keys of a page anew.
pub fn schema(arguments: &Schema) -> ExitCode {
    let schema = schema_of(&SECTIONS);
    let Some(page) = &arguments.docs else {
        say(format_args!("{schema:#}"));
        return ExitCode::SUCCESS;
    };
    let made = std::fs::read_to_string(page)
        .map_err(|error| error.to_string())
        .and_then(|text| docs::filled(&text, &schema))
        .and_then(|text| std::fs::write(page, text).map_err(|error| error.to_string()));
    match made {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failed(format_args!("failed to make the tables of {}: {error}", page.display())),
    }
}
