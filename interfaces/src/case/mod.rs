//! The case file.
//!
//! ```text
//! case.toml ── document (table, with lines) ── overrides (--set) ── conform (keys, types)
//!           ── typed (as written) ── check (numbers, geometry, names) ── resolve ── Case (nothing optional)
//! ```
//!
//! Start at [`Case::load`]. [`resolved`] is what solvers read, [`typed`] what users write and what the JSON
//! schema describes; [`numerics`] and [`geometry`] are shared. All mistakes of a case are found before any is
//! reported ([`CaseErrors`]).

mod check;
mod conform;
pub mod coupling;
mod document;
mod errors;
pub mod geometry;
mod nearest;
pub mod numerics;
pub mod region;
mod resolve;
pub mod resolved;
mod schema;
#[cfg(test)]
mod tests;
pub mod typed;
pub mod unit;

pub use errors::{CaseError, CaseErrors};
pub use geometry::{AxisBox, Ball, Face, Side, array};
pub use resolved::Case;
pub use schema::schema;

use document::Document;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

impl Case {
    /// Reads the case file at `path`, or `case.toml` in the folder `path`, with `overrides`
    /// (`section.key=value`) applied before it is checked.
    ///
    /// # Errors
    /// All mistakes of the file, or that it cannot be read.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, CaseErrors> {
        let file = if path.is_dir() { path.join("case.toml") } else { path.to_owned() };
        match std::fs::read_to_string(&file) {
            Ok(text) => Self::parse(&text, &file, overrides),
            Err(error) => Err(CaseErrors {
                file,
                errors: vec![CaseError::new(
                    "",
                    format!("cannot be read: {error}"),
                    "name a case file, or a folder with a case.toml",
                )],
            }),
        }
    }

    /// Reads a case from text. `file` stands in messages, and other files that the case names are sought from
    /// where it is.
    ///
    /// # Errors
    /// All mistakes of the text.
    pub fn parse(text: &str, file: &Path, overrides: &[String]) -> Result<Self, CaseErrors> {
        let fail = |errors| CaseErrors { file: PathBuf::from(file), errors };
        let mut document = Document::parse(text).map_err(fail)?;
        let mut errors: Vec<_> = overrides.iter().filter_map(|setting| document.set(setting).err()).collect();

        let mut table = document.table.clone();
        let conformity = conform::conform(&mut table, &schema());
        errors.extend(conformity.errors);
        conformity.renamed.iter().for_each(|(written, meant)| document.take_for(written, meant));
        if conformity.usable {
            let mut typed: typed::CaseFile = table.try_into().map_err(|error: toml::de::Error| {
                fail(vec![CaseError::new("", error.message(), "compare the file with the schema")])
            })?;
            typed.seek_files_from(file);
            errors.extend(check::check(&mut typed));
            if errors.is_empty() {
                return Ok(resolve::resolve(typed));
            }
        }
        let mut errors: Vec<_> = errors.into_iter().map(|error| document.locate(error)).collect();
        errors.sort_by_key(|error| (error.overridden, error.line));
        Err(fail(errors))
    }

    /// The case as resolved, every default filled in: a case file that reads back to the same case.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a case has only tables with names for keys, lists, numbers and words")
    }

    /// SHA-256 of the case as resolved, in hexadecimal, by which processes find out whether they run the same
    /// case. `threads` is left out, since no result depends on it.
    pub fn hash(&self) -> String {
        let mut same = self.clone();
        same.general.threads = 0;
        Sha256::digest(same.to_toml()).iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

impl TryFrom<typed::CaseFile> for Case {
    type Error = CaseErrors;

    fn try_from(mut file: typed::CaseFile) -> Result<Self, Self::Error> {
        let errors = check::check(&mut file);
        if errors.is_empty() {
            Ok(resolve::resolve(file))
        } else {
            Err(CaseErrors { file: PathBuf::new(), errors })
        }
    }
}
