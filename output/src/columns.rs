//! What the columns of a run's tables are: `columns.json`, beside them, so that the tables stay plain.
//!
//! ```json
//! {"probes.csv": {"tip.ux": {"unit": "m", "meaning": "displacement of gate at (0.1025, 0) m"}, …}, …}
//! ```

use crate::atomic;
use crate::error::{Result, parse_error, read_error};
use crate::files;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// The file's name.
pub const FILE: &str = "columns.json";

/// A column of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name in the header.
    pub name: String,
    /// What its numbers are.
    pub content: Content,
}

/// What the numbers of a column are.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Content {
    /// SI unit, `1` for counts and ratios; in two dimensions that of one metre of depth.
    pub unit: String,
    /// In words; empty where nobody says.
    #[serde(default)]
    pub meaning: String,
}

/// Contents by the name of the table's file and of the column.
pub type Contents = BTreeMap<String, BTreeMap<String, Content>>;

impl Column {
    /// A column of that name, unit and meaning.
    pub fn new(name: impl Into<String>, unit: &str, meaning: impl Into<String>) -> Self {
        Self { name: name.into(), content: Content { unit: unit.to_owned(), meaning: meaning.into() } }
    }
}

impl AsRef<str> for Column {
    /// As it heads the table.
    fn as_ref(&self) -> &str {
        &self.name
    }
}

/// Writes in the folder what the columns of each table are; replaces what was said of these tables.
///
/// # Errors
/// [`crate::Error::Write`] if the file cannot be written; as [`read`] if an earlier one is broken.
pub fn write(dir: &Path, tables: &[(&str, &[Column])]) -> Result<()> {
    let mut contents = read(dir)?;
    for (table, columns) in tables {
        let of_table = columns.iter().map(|column| (column.name.clone(), column.content.clone()));
        contents.insert((*table).to_owned(), of_table.collect());
    }
    let text = serde_json::to_string_pretty(&contents).expect("names and words make JSON");
    atomic::write_file(&dir.join(FILE), (text + "\n").as_bytes())
}

/// What the columns of the tables in a folder are; nothing where the file is not there.
///
/// # Errors
/// [`crate::Error::Read`] if it cannot be read, [`crate::Error::Parse`] if it is not of this form.
pub fn read(dir: &Path) -> Result<Contents> {
    let path = dir.join(FILE);
    match files::read_text(&path, files::WORDS) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Contents::new()),
        Err(error) => Err(read_error(&path)(error)),
        Ok(text) => serde_json::from_str(&text).map_err(|error| parse_error(&path, error.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{self, Table};

    #[test]
    fn a_table_is_read_with_the_units_that_stand_beside_it() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("probes.csv");
        let columns = [Column::new("t", "s", "time"), Column::new("tip.ux", "m", "displacement")];
        Table::create(&path, &columns).unwrap().row(&[0.0, 1.0]).unwrap();
        assert_eq!(table::read(&path).unwrap().unit("tip.ux"), "", "nobody says");
        write(dir.path(), &[("probes.csv", &columns)]).unwrap();
        write(dir.path(), &[("windows.csv", &[Column::new("size", "s", "")])]).unwrap();
        let read_back = table::read(&path).unwrap();
        assert_eq!(["t", "tip.ux", "size"].map(|name| read_back.unit(name)), ["s", "m", ""]);
        assert_eq!(read(dir.path()).unwrap()["probes.csv"]["tip.ux"], columns[1].content);
    }
}
