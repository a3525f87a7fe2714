//! What an exported unit carries in `resources/`: the case as resolved, and the points of a reduced
//! interface.

use interfaces::case::Case;
use interfaces::case::coupling::LoadInWindow;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::path::Path;

/// The case, in `resources/`.
pub const CASE: &str = "case.toml";
/// The points of a reduced interface, in `resources/`; not there for a whole one.
pub const POINTS: &str = "points.toml";

/// The resources as text.
#[derive(Clone, Debug)]
pub struct Resources {
    /// The case as resolved.
    pub case: String,
    /// The points of a reduced interface.
    pub points: Option<Points>,
}

/// Points that stand for the interface, in the reference configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Points {
    /// Coordinates (m) of each.
    pub points: Vec<Vec<f64>>,
}

/// Resources that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ResourceError {
    /// A file cannot be read.
    #[error("failed to read {}: {source}; the unit's archive must be unpacked whole", .path.display())]
    Read {
        /// The file.
        path: std::path::PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file is not what it should be.
    #[error("failed to read {}: {what}", .path.display())]
    Parse {
        /// The file.
        path: std::path::PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// Of another unit than the token says.
    #[error(
        "the token given is {given}, but these resources have {own}: model description and resources are of two units"
    )]
    Token {
        /// By the importer, from the model description.
        given: String,
        /// Of the resources.
        own: String,
    },
}

impl Resources {
    /// Of a case and, for a reduced interface, its points.
    pub fn new(case: &Case, points: Option<Points>) -> Self {
        let mut case = case.clone();
        if let Some(coupling) = &mut case.coupling {
            // An importer sets the load of a step, not what it was at the step's start.
            coupling.load_in_window = LoadInWindow::Held;
        }
        Self { case: case.to_toml(), points }
    }

    /// Reads the folder of an unpacked unit.
    ///
    /// # Errors
    /// Files that are not there or not readable.
    pub fn read(folder: &Path) -> Result<Self, ResourceError> {
        let read = |name: &str| {
            let path = folder.join(name);
            std::fs::read_to_string(&path).map_err(|source| ResourceError::Read { path, source })
        };
        let points = match folder.join(POINTS).exists() {
            true => Some(toml::from_str(&read(POINTS)?).map_err(|error| ResourceError::Parse {
                path: folder.join(POINTS),
                what: error.to_string(),
            })?),
            false => None,
        };
        Ok(Self { case: read(CASE)?, points })
    }

    /// The points as the text of their file.
    pub fn points_text(&self) -> Option<String> {
        self.points.as_ref().map(|p| toml::to_string(p).expect("lists of numbers are valid TOML"))
    }

    /// The token by which an importer says that it has read the description of this very unit: from the
    /// SHA-256 of all resources.
    pub fn token(&self) -> String {
        let mut hash = Sha256::new();
        hash.update(env!("CARGO_PKG_VERSION"));
        hash.update(&self.case);
        hash.update(self.points_text().unwrap_or_default());
        let hex: String = hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect();
        format!("{{{}-{}-{}-{}-{}}}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
    }

    /// Refuses a token of another unit.
    ///
    /// # Errors
    /// [`ResourceError::Token`].
    pub fn check_token(&self, given: &str) -> Result<(), ResourceError> {
        let own = self.token();
        if given == own { Ok(()) } else { Err(ResourceError::Token { given: given.to_owned(), own }) }
    }
}
