//! Sections of the case that a solver brings: `[fluid.numerics]`, `[structure.material]`.
//!
//! The solver has a type for each: its documentation comments, fields and attributes are the section's keys,
//! and values of it the defaults. Everybody else hands the section on as a table. What is written is laid
//! over the defaults ([`laid_over`]); the keys, the JSON schema and the tables of `docs/case-file.md` follow
//! from the type ([`schema_of`]).

use super::findings::Findings;
use super::keys::Case;
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
pub use serde_json::Value as Json;
use serde_json::json;
use std::collections::BTreeMap;
use toml::{Table, Value};

/// Schema of a table that others describe.
pub(super) type AnyTable = BTreeMap<String, Json>;

/// Where a section stands (`fluid.numerics`), and what makes its JSON schema.
pub type Section = (&'static str, fn() -> Json);

/// What a solver adds to the case file. A section that nobody brings is handed on as it is written.
#[derive(Clone, Copy)]
pub struct Sections {
    /// The sections' schemas.
    pub schemas: &'static [Section],
    /// Fills in what the sections, and keys elsewhere that only the solver can decide, leave out, and reports
    /// what types cannot say. It runs before the checks of the rest. A number that was found wrong is NaN.
    pub resolve: fn(&mut Case, &mut Findings),
}

/// `written` laid over the defaults of the keys that it leaves out.
///
/// # Errors
/// A key or value that `T` has not; none where the table was held against the schema of `T`.
pub fn laid_over<T: DeserializeOwned>(defaults: &Table, written: &Table) -> Result<T, toml::de::Error> {
    let mut table = defaults.clone();
    lay(&mut table, written);
    table.try_into()
}

fn lay(table: &mut Table, written: &Table) {
    for (key, value) in written {
        match (table.get_mut(key), value) {
            (Some(Value::Table(below)), Value::Table(above)) => lay(below, above),
            _ => {
                table.insert(key.clone(), value.clone());
            }
        }
    }
}

/// All keys and values of a section.
pub fn to_table<T: Serialize>(section: &T) -> Table {
    Table::try_from(section).expect("a section has only tables with names for keys, lists, numbers and words")
}

/// The JSON schema of a section: what has a default may be left out.
pub fn schema_of<T: JsonSchema>(defaults: &Table) -> Json {
    let mut schema = schemars::schema_for!(T).to_value();
    with_defaults(&mut schema, defaults);
    schema
}

/// Writes defaults into the schema of a table.
pub(super) fn with_defaults(schema: &mut Json, defaults: &Table) {
    if let Some(Json::Array(required)) = schema.get_mut("required") {
        required.retain(|key| key.as_str().is_none_or(|key| !defaults.contains_key(key)));
    }
    for (key, default) in defaults {
        schema["properties"][key]["default"] = json!(default);
    }
}

/// Writes into a schema what other defaults a key has where `word` stands (`scheme = "paper"`).
#[must_use]
pub fn and_with(mut schema: Json, word: &str, defaults: &Table) -> Json {
    for (key, default) in defaults {
        let property = &mut schema["properties"][key];
        if property["default"] != json!(default) {
            property["x-defaults"][word] = json!(default);
        }
    }
    schema
}
