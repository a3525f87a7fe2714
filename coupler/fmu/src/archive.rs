//! The archive of a unit.

use crate::Error;
use crate::description::{Description, Version};
use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use zip::ZipArchive;

/// Files of an archive at most.
const MOST_FILES: usize = 20_000;
/// Bytes of all files of an archive, unpacked, at most.
const MOST_BYTES: u64 = 2 << 30;
/// Bytes of a model description at most.
const DESCRIPTION: u64 = 64 << 20;

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
        // Resolved: whoever names a unit may name a link to it, but no device.
        let whole = file.canonicalize().map_err(|error| failed(error.to_string()))?;
        let opened = output::files::open(&whole, u64::MAX).map_err(|error| failed(error.to_string()))?;
        let zip = ZipArchive::new(opened).map_err(|error| failed(error.to_string()))?;
        if zip.len() > MOST_FILES {
            return Err(failed(format!("it has {} files, and {MOST_FILES} are unpacked at most", zip.len())));
        }
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
        let read = self.zip.by_name("modelDescription.xml").map_err(io::Error::from);
        read.and_then(|entry| entry.take(DESCRIPTION + 1).read_to_string(&mut text))
            .and_then(|length| match length as u64 > DESCRIPTION {
                true => Err(io::Error::other(format!("it has more than {DESCRIPTION} bytes"))),
                false => Ok(()),
            })
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
        self.extract(&folder).map_err(|what| Error::Archive { file: self.file.clone(), what })?;
        Ok(unpacked)
    }

    /// Writes all files below the folder, which is made anew; refuses those that would lead out of it, links,
    /// and more bytes than any unit has, whatever the archive says of their number.
    fn extract(&mut self, folder: &Path) -> Result<(), String> {
        let told = |error: io::Error| error.to_string();
        match fs::remove_dir_all(folder) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(told(error)),
            _ => {}
        }
        output::files::folder(folder).map_err(told)?;
        let mut room = MOST_BYTES;
        for index in 0..self.zip.len() {
            let mut entry = self.zip.by_index(index).map_err(|error| error.to_string())?;
            let name = entry.name().to_owned();
            let inside = entry.enclosed_name().filter(|_| !entry.is_symlink());
            let path = folder.join(inside.ok_or_else(|| format!("`{name}` leads out of the folder"))?);
            if entry.is_dir() {
                fs::create_dir_all(&path).map_err(told)?;
                continue;
            }
            path.parent().map_or(Ok(()), fs::create_dir_all).map_err(told)?;
            let mut file = output::files::create(&path).map_err(told)?;
            let written = io::copy(&mut entry.by_ref().take(room + 1), &mut file).map_err(told)?;
            room = room.checked_sub(written).ok_or_else(|| {
                format!("unpacked it has more than the {MOST_BYTES} bytes that are taken, up to `{name}`")
            })?;
        }
        Ok(())
    }
}

impl Drop for Unpacked {
    fn drop(&mut self) {
        // What cannot be removed now is removed by the next run into these outputs.
        let _ = fs::remove_dir_all(&self.folder);
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
