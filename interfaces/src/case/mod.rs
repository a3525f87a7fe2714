//! The case file.
//!
//! ```text
//! case.toml ── document (table, with lines) ── overrides (--set) ── conform (keys, types)
//!           ── defaults (that follow from other keys) ── Case ── check (numbers, geometry, names)
//! ```
//!
//! Start at [`Case::load`]. `keys` is what users write, what the JSON schema describes and what solvers
//! read; solvers bring [`section`]s of their own. All mistakes of a case are found before any is reported
//! ([`CaseErrors`]). [`docs`] writes the tables of `docs/case-file.md`.

mod changes;
mod check;
pub mod checkpoints;
mod conform;
pub mod coupling;
mod defaults;
pub mod docs;
mod document;
mod errors;
mod findings;
pub mod fluid;
pub mod geometry;
mod keys;
pub mod motion;
mod nearest;
pub mod participant;
pub mod probe;
pub mod region;
mod schema;
pub mod section;
pub mod structure;
pub mod unit;
pub mod velocity;

pub use changes::Change;
pub use errors::{CaseError, CaseErrors};
pub use findings::Findings;
pub use geometry::{AxisBox, Ball, array};
pub use keys::{Case, General};
pub use schema::schema;
pub use section::Sections;

use checkpoints::Checkpoints;
use document::Document;
use participant::StartWord;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use toml::Value;

impl Case {
    /// Reads the case file at `path`, or `case.toml` in the folder `path`, with `overrides`
    /// (`section.key=value`) applied before it is checked. `solvers` bring the sections of their own;
    /// sections that none of them brings are taken as they are written.
    ///
    /// # Errors
    /// All mistakes of the file, or that it cannot be read.
    pub fn load(path: &Path, overrides: &[String], solvers: &[Sections]) -> Result<Self, CaseErrors> {
        let file = if path.is_dir() { path.join("case.toml") } else { path.to_owned() };
        match std::fs::read_to_string(&file) {
            Ok(text) => Self::parse(&text, &file, overrides, solvers),
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
    pub fn parse(
        text: &str,
        file: &Path,
        overrides: &[String],
        solvers: &[Sections],
    ) -> Result<Self, CaseErrors> {
        let fail = |errors| CaseErrors { file: PathBuf::from(file), errors };
        let mut document = Document::parse(text).map_err(fail)?;
        let mut errors: Vec<_> = overrides.iter().filter_map(|setting| document.set(setting).err()).collect();

        let mut table = document.table.clone();
        let conformity = conform::conform(&mut table, &schema(solvers));
        errors.extend(conformity.errors);
        conformity.renamed.iter().for_each(|(written, meant)| document.take_for(written, meant));
        if conformity.usable {
            let coupling = table.get("coupling").and_then(Value::as_table).cloned();
            defaults::fill_in(&mut table);
            let mut case: Self = table.try_into().map_err(|error: toml::de::Error| {
                fail(vec![CaseError::new("", error.message(), "compare the file with the schema")])
            })?;
            case.seek_files_from(file);
            errors.extend(check::check(&mut case, coupling.as_ref(), solvers));
            if errors.is_empty() {
                return Ok(case);
            }
        }
        Err(fail(document.locate_all(errors)))
    }

    /// What was found wrong with a case that [`load`](Self::load) read: the same file and overrides tell
    /// where it stands.
    pub fn refuse(path: &Path, overrides: &[String], findings: Findings) -> CaseErrors {
        let file = if path.is_dir() { path.join("case.toml") } else { path.to_owned() };
        let text = std::fs::read_to_string(&file).unwrap_or_default();
        let errors = match Document::parse(&text) {
            Ok(mut document) => {
                // They were taken when the case was read.
                overrides.iter().for_each(|setting| drop(document.set(setting)));
                document.locate_all(findings.errors)
            }
            // The file has changed in the meantime.
            Err(_) => findings.errors,
        };
        CaseErrors { file, errors }
    }

    /// The case as resolved, every default filled in: a case file that reads back to the same case.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a case has only tables with names for keys, lists, numbers and words")
    }

    /// SHA-256, in hexadecimal, of what participants must agree on, by which processes find out whether they
    /// run the same case: the case as resolved without `threads` and checkpoints, on which no result depends,
    /// without titles and references, and without what names programs and files, which may be elsewhere for
    /// another.
    pub fn hash(&self) -> String {
        let mut same = self.clone();
        (same.general.threads, same.general.title) = (0, String::new());
        same.checkpoints = Checkpoints::default();
        same.references.clear();
        let starts = [
            same.fluid.as_mut().map(|fluid| &mut fluid.participant),
            same.structure.as_mut().map(|structure| &mut structure.participant),
        ];
        for start in starts.into_iter().flatten() {
            match &mut start.fmu {
                Some(file) => *file = PathBuf::new(),
                None => (start.start, start.command) = (Some(StartWord::Own), None),
            }
        }
        Sha256::digest(same.to_toml()).iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
