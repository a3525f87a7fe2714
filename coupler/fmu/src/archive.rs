//! The archive of a unit.

use crate::Error;
use crate::description::{Description, Version};
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use zip::ZipArchive;

/// An archive that was opened and not unpacked yet.
pub struct Archive {
    file: PathBuf,
    zip: ZipArchive<File>,
}

/// An unpacked unit. The folder is removed when it is dropped; of a process that was killed it stays, until
/// the next run empties its outputs.
#[derive(Debug)]
pub struct Unpacked {
    folder: PathBuf,
    /// The shared library for this platform.
    pub library: PathBuf,
    /// The folder of its resources, which a unit need not have.
    pub resources: PathBuf,
}

impl Archive {
    /// Opens the archive.
    ///
    /// # Errors
    /// No such file, or no zip file.
    pub fn open(file: &Path) -> Result<Self, Error> {
        let failed = |what: String| Error::Archive { file: file.to_owned(), what };
        let opened = File::open(file).map_err(|error| failed(error.to_string()))?;
        let zip = ZipArchive::new(opened).map_err(|error| failed(error.to_string()))?;
        Ok(Self { file: file.to_owned(), zip })
    }

    /// The archive's file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Reads the model description.
    ///
    /// # Errors
    /// There is none, or it is not one of a unit for co-simulation.
    pub fn description(&mut self) -> Result<Description, Error> {
        let mut text = String::new();
        let read = self.zip.by_name("modelDescription.xml").map_err(std::io::Error::from);
        read.and_then(|mut entry| entry.read_to_string(&mut text))
            .map_err(|error| Error::Description { file: self.file.clone(), what: error.to_string() })?;
        Description::parse(&text).map_err(|what| Error::Description { file: self.file.clone(), what })
    }

    /// Finds the shared library for this platform, as a path inside the archive.
    ///
    /// # Errors
    /// Which platforms there are, where this one is not among them.
    pub fn library(&self, description: &Description) -> Result<String, Error> {
        let platform = platform(description.version);
        let ending = std::env::consts::DLL_EXTENSION;
        let wanted = format!("binaries/{platform}/{}.{ending}", description.identifier);
        if self.zip.file_names().any(|name| name == wanted) {
            return Ok(wanted);
        }
        let mut there: Vec<_> = self.zip.file_names().filter(|name| name.starts_with("binaries/")).collect();
        there.sort_unstable();
        let there = if there.is_empty() { "no binaries".to_owned() } else { there.join(", ") };
        let what = format!("it has {there}, and this platform needs {wanted}");
        Err(Error::Archive { file: self.file.clone(), what })
    }

    /// Unpacks it whole into `folder`, which is made.
    ///
    /// # Errors
    /// As [`Archive::library`]; a folder that cannot be written.
    pub fn unpack(mut self, description: &Description, folder: &Path) -> Result<Unpacked, Error> {
        let library = self.library(description)?;
        let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
        let unpacked = Unpacked {
            library: folder.join(library),
            resources: folder.join("resources"),
            folder: folder.clone(),
        };
        let made = std::fs::create_dir_all(&folder).map_err(|error| error.to_string());
        // It refuses entries that would lead out of the folder.
        made.and_then(|()| self.zip.extract(&folder).map_err(|error| error.to_string()))
            .map_err(|what| Error::Archive { file: self.file.clone(), what })?;
        Ok(unpacked)
    }
}

impl Drop for Unpacked {
    fn drop(&mut self) {
        // What cannot be removed now is removed by the next run into these outputs.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// This platform, as the version of the standard names it.
fn platform(version: Version) -> String {
    let (architecture, system) = (std::env::consts::ARCH, std::env::consts::OS);
    let system = if system == "macos" { "darwin" } else { system };
    match version {
        Version::Fmi3 => format!("{architecture}-{system}"),
        Version::Fmi2 => {
            let system = if system == "windows" { "win" } else { system };
            format!("{system}{}", usize::BITS)
        }
    }
}
