//! How the files of a run's folder are opened: nobody who could put something there before us has a run or a
//! report write to, or read, anything else.
//!
//! A file is made exclusively, after whatever bears its name was removed, so that neither a link nor a second
//! name of another file is followed; what is read is a regular file that is no link, and no larger than what
//! the caller is ready to hold.

use rustix::fs::OFlags;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Read as _};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

/// Largest file of words (summary, case, columns, collection of snapshots) that is read (bytes).
pub const WORDS: u64 = 64 << 20;
/// Largest snapshot that is read (bytes).
pub const SNAPSHOT: u64 = 2 << 30;

const NO_LINK: i32 = (OFlags::NOFOLLOW.bits() | OFlags::NONBLOCK.bits()) as i32;

/// Makes the file anew, in place of what bears its name.
///
/// # Errors
/// If a folder bears that name, or the file cannot be made.
pub fn create(path: &Path) -> io::Result<File> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    OpenOptions::new().write(true).create_new(true).custom_flags(NO_LINK).open(path)
}

/// Makes the folder, or takes the one that is there, which must not be a link to another.
///
/// # Errors
/// If something else bears its name, or it cannot be made.
pub fn folder(path: &Path) -> io::Result<()> {
    fs::create_dir_all(path)?;
    if fs::symlink_metadata(path)?.is_dir() {
        return Ok(());
    }
    Err(io::Error::new(ErrorKind::InvalidInput, "it is a link, and what is written there would go elsewhere"))
}

/// Opens a regular file that is no link and has at most `most` bytes.
///
/// # Errors
/// If it is anything else, or cannot be opened.
pub fn open(path: &Path, most: u64) -> io::Result<File> {
    let file = OpenOptions::new().read(true).custom_flags(NO_LINK).open(path).map_err(|error| {
        let is_link = fs::symlink_metadata(path).is_ok_and(|there| there.is_symlink());
        if is_link { io::Error::new(ErrorKind::InvalidInput, "it is a link to another file") } else { error }
    })?;
    let there = file.metadata()?;
    if !there.is_file() {
        return Err(io::Error::new(ErrorKind::InvalidInput, "it is no regular file"));
    }
    if there.len() > most {
        let what = format!("it has {} bytes, more than the {most} that are read", there.len());
        return Err(io::Error::new(ErrorKind::FileTooLarge, what));
    }
    Ok(file)
}

/// Opens a regular file that is no link, to write on in it.
///
/// # Errors
/// If it is not there or anything else.
pub fn reopen(path: &Path) -> io::Result<File> {
    let file = OpenOptions::new().read(true).write(true).custom_flags(NO_LINK).open(path)?;
    if file.metadata()?.is_file() {
        return Ok(file);
    }
    Err(io::Error::new(ErrorKind::InvalidInput, "it is no regular file"))
}

/// The text of a file that [`open`] opens.
///
/// # Errors
/// As [`open`]; a file that grows beyond `most` bytes, or is no UTF-8.
pub fn read_text(path: &Path, most: u64) -> io::Result<String> {
    let mut text = String::new();
    open(path, most)?.take(most).read_to_string(&mut text)?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    /// Writes go to a file of the folder's own, whatever was planted under its name.
    #[test]
    fn what_is_written_stays_in_the_folder() {
        let (dir, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let victim = elsewhere.path().join("victim");
        fs::write(&victim, "precious").unwrap();
        let path = dir.path().join("a.json");
        let partial = dir.path().join(".a.json.partial");
        type Plant = fn(&Path, &Path);
        let link: Plant = |victim, at| symlink(victim, at).unwrap();
        let name: Plant = |victim, at| fs::hard_link(victim, at).unwrap();
        let fifo: Plant = |_, at| assert!(crate::mkfifo(at));
        for (index, plant) in [link, name, fifo].into_iter().enumerate() {
            for at in [&partial, &path] {
                plant(&victim, at);
                crate::atomic::write_file(&path, b"new").unwrap();
                assert_eq!(fs::read_to_string(&path).unwrap(), "new", "row {index}");
                fs::remove_file(&path).unwrap();
                plant(&victim, &path);
                drop(create(&path).unwrap());
                assert_eq!(fs::metadata(&path).unwrap().len(), 0, "row {index}");
                fs::remove_file(&path).unwrap();
            }
            assert_eq!(fs::read_to_string(&victim).unwrap(), "precious", "row {index}");
        }
        let frames = dir.path().join("frames");
        symlink(elsewhere.path(), &frames).unwrap();
        assert!(folder(&frames).unwrap_err().to_string().contains("link"));
        assert!(crate::Series::create(dir.path(), "frames").is_err());
        assert_eq!(fs::read_dir(elsewhere.path()).unwrap().count(), 1);
    }

    #[test]
    fn only_regular_files_of_the_folder_are_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("summary.json");
        let refused = |what: &str| {
            let error = read_text(&path, 100).unwrap_err().to_string();
            fs::remove_file(&path).unwrap();
            assert!(error.contains(what), "{error}");
        };
        symlink("/dev/zero", &path).unwrap();
        refused("link");
        assert!(crate::mkfifo(&path));
        refused("no regular file");
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        refused("1099511627776 bytes");
        fs::create_dir(&path).unwrap();
        assert!(read_text(&path, 100).unwrap_err().to_string().contains("no regular file"));
    }
}
