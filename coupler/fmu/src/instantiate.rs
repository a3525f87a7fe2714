//! From an unpacked unit to an instance of it, by the version of the standard.

#![expect(unsafe_code, reason = "opening a library runs its initialisers")]

use crate::Error;
use crate::archive::Unpacked;
use crate::description::{Description, Version};
use crate::unit::{Instance, Teller, reason};
use crate::{fmi2, fmi3};
use libloading::Library;
use std::path::Path;

/// Instantiates an unpacked unit.
///
/// # Errors
/// A library that cannot be opened or lacks a function; a unit that refuses.
pub fn instantiate(
    description: &Description,
    unpacked: &Unpacked,
    file: &Path,
) -> Result<Box<dyn Instance>, Error> {
    let failed = |what: String| Error::Library { file: file.to_owned(), what };
    // SAFETY: opening a library runs its initialisers. That foreign code does as it likes is why a unit has a
    // process of its own.
    let library = unsafe { Library::new(&unpacked.library) }.map_err(|error| failed(reason(&error)))?;
    // It stays open as long as the process: a unit may have threads of its own, which outlive an instance.
    let library: &'static Library = Box::leak(Box::new(library));
    let teller = Teller::new(file);
    Ok(match description.version {
        Version::Fmi2 => Box::new(fmi2::Unit::new(library, description, unpacked, teller)?),
        Version::Fmi3 => Box::new(fmi3::Unit::new(library, description, unpacked, teller)?),
    })
}
