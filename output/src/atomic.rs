//! Files that are either whole or absent, whenever the writing process is killed.

use crate::error::{Result, write_error};
use crate::files;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Writes `contents` to `path` so that no reader, and no kill at any moment, finds half of it: the bytes go
/// to `.NAME.partial` in the same folder, made anew, which is then renamed over `path`.
///
/// A kill in between leaves the earlier file untouched and the partial one behind; the next write of the same
/// file takes its place. The contents are not forced to the disk: a loss of power is not guarded against.
///
/// # Errors
/// [`crate::Error::Write`] if the folder is missing, full or not writable; the partial file is removed then.
pub fn write_file(path: &Path, contents: &[u8]) -> Result<()> {
    let partial = partial_path(path);
    let written = files::create(&partial).and_then(|mut file| file.write_all(contents));
    written.and_then(|()| fs::rename(&partial, path)).map_err(|source| {
        // The error that counts is the first; that the partial file may be missing as well says nothing new.
        let _ = fs::remove_file(&partial);
        write_error(path)(source)
    })
}

/// Where the bytes go first that will be `path`.
pub(crate) fn partial_path(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.partial"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_the_file_and_leaves_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.json");
        write_file(&path, b"first").unwrap();
        // What a killed run may have left does not stand in the way.
        fs::write(dir.path().join(".a.json.partial"), b"half").unwrap();
        write_file(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_failed_write_names_the_file_and_keeps_the_old_one() {
        let dir = tempfile::tempdir().unwrap();
        let missing = dir.path().join("nowhere").join("a.json");
        let message = write_file(&missing, b"x").unwrap_err().to_string();
        assert!(message.contains("nowhere"), "{message}");
        // A folder cannot be replaced by a file: the rename fails, and the partial file goes.
        let occupied = dir.path().join("occupied");
        fs::create_dir(&occupied).unwrap();
        assert!(write_file(&occupied, b"x").is_err());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }
}
