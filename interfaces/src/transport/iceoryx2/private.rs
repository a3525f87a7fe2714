//! What a domain has is its user's alone: its folder, its lock, its segments in shared memory.
//!
//! The folder stands where others may make files too, and shared memory is everybody's. So nothing there is
//! taken for ours because of its name: the folder has to be a directory of this user that nobody else can
//! write, below folders in which nobody else can replace it; files in it are opened without following links
//! and without waiting; segments have to be regular files of this user. Anything else is refused, with its
//! owner named.

use rustix::fs::OFlags;
use rustix::process::geteuid;
use std::fs::{self, DirBuilder, File, Metadata, OpenOptions, Permissions};
use std::io::{self, ErrorKind, Read, Write as _};
use std::os::unix::fs::{DirBuilderExt, FileTypeExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

/// Where POSIX shared memory stands.
pub(super) const SHARED_MEMORY: &str = "/dev/shm";
/// The end of the name of the segment in which iceoryx2 counts nodes. It is made for everybody to write.
const COUNTER: &str = ".global_mgmt";
/// Far more bytes than the counter has.
const COUNTER_BYTES: u64 = 4096;
/// What group and others may do.
const OTHERS: u32 = 0o077;
/// What group and others may write.
const OTHERS_WRITE: u32 = 0o022;
/// Whoever may write in a folder with this bit, the entries of others stay theirs.
const STICKY: u32 = 0o1000;

/// What to do where a place cannot be ours.
const ELSEWHERE: &str =
    "remove it (who owns it can, and root), or set XDG_RUNTIME_DIR to a folder of yours with mode 0700";

/// Makes the folder, or takes the one that is there: a directory of this user, which nobody else can write or
/// replace, and after this nobody else can read.
pub(super) fn folder(path: &Path) -> io::Result<()> {
    if let Some(parent) = path.parent() {
        let whole = parent.canonicalize()?;
        whole.ancestors().try_for_each(|above| keeps_its_entries(path, above))?;
    }
    match DirBuilder::new().mode(0o700).create(path) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(error),
        _ => {}
    }
    let flags = (OFlags::DIRECTORY | OFlags::NOFOLLOW).bits() as i32;
    let there = fs::symlink_metadata(path)?;
    if !there.is_dir() {
        return Err(refused(path, &there, "no directory"));
    }
    ours(path, &there)?;
    let opened = OpenOptions::new().read(true).custom_flags(flags).open(path)?;
    let there = opened.metadata()?;
    ours(path, &there)?;
    if there.mode() & OTHERS_WRITE != 0 {
        return Err(refused(path, &there, "a folder in which others can write"));
    }
    if there.mode() & OTHERS != 0 {
        opened.set_permissions(Permissions::from_mode(0o700))?;
    }
    Ok(())
}

/// Refuses a folder above in which another user could put something else in the place of `path`.
fn keeps_its_entries(path: &Path, above: &Path) -> io::Result<()> {
    let there = fs::symlink_metadata(above)?;
    let own = there.uid() == geteuid().as_raw() || there.uid() == 0;
    if own && (there.mode() & OTHERS_WRITE == 0 || there.mode() & STICKY != 0) {
        return Ok(());
    }
    let what = format!("a folder in which others can replace {}", path.display());
    Err(refused(above, &there, &what))
}

/// Opens a file of the folder to hold locks on, or makes it; nothing where it vanished in between.
pub(super) fn lock_file(path: &Path) -> io::Result<Option<File>> {
    let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32;
    let opened = OpenOptions::new()
        .create(true)
        .truncate(false)
        .write(true)
        .mode(0o600)
        .custom_flags(flags)
        .open(path);
    let opened = match opened {
        Ok(opened) => opened,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => {
            return match fs::symlink_metadata(path) {
                Ok(there) if !there.is_file() => Err(refused(path, &there, "no regular file")),
                _ => Err(error),
            };
        }
    };
    let there = opened.metadata()?;
    if !there.is_file() {
        return Err(refused(path, &there, "no regular file"));
    }
    if there.nlink() > 1 {
        return Err(refused(path, &there, "a file with another name besides"));
    }
    ours(path, &there)?;
    if there.mode() & 0o177 != 0 {
        opened.set_permissions(Permissions::from_mode(0o600))?;
    }
    Ok(Some(opened))
}

/// The domain's segments in shared memory; one that is no regular file of this user, or that others can
/// write, is refused. The counter may be one of those for the moment in which it is made.
pub(super) fn check_segments(prefix: &str) -> io::Result<()> {
    for (path, there) in segments(prefix) {
        ours(&path, &there)?;
        if !there.is_file() {
            return Err(refused(&path, &there, "no regular file"));
        }
    }
    Ok(())
}

/// Puts the counter of iceoryx2, which it makes for everybody to write, where only this user can: a copy
/// takes its place, so that nobody has the new one open.
pub(super) fn close_counter(prefix: &str) -> io::Result<()> {
    let open_to_others = |path: &Path, there: &Metadata| {
        path.to_string_lossy().ends_with(COUNTER) && there.mode() & OTHERS != 0
    };
    for (path, _) in segments(prefix).filter(|(path, there)| open_to_others(path, there)) {
        let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits() as i32;
        let opened = match OpenOptions::new().read(true).custom_flags(flags).open(&path) {
            // Another of ours was quicker, or the last to leave.
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            opened => opened?,
        };
        ours(&path, &opened.metadata()?)?;
        let mut counter = Vec::new();
        opened.take(COUNTER_BYTES).read_to_end(&mut counter)?;
        if counter.is_empty() {
            return Err(refused(&path, &fs::symlink_metadata(&path)?, "empty"));
        }
        let copy = PathBuf::from(format!("{}.{}", path.display(), std::process::id()));
        let written = OpenOptions::new().create_new(true).write(true).mode(0o600).open(&copy);
        written.and_then(|mut file| file.write_all(&counter)).and_then(|()| fs::rename(&copy, &path))?;
    }
    Ok(())
}

/// The domain's segments in shared memory that are empty, which iceoryx2 waits for others to fill.
pub(super) fn empty_segments(prefix: &str) -> Vec<String> {
    let empty = segments(prefix).filter(|(_, there)| there.len() == 0);
    empty.map(|(path, _)| path.display().to_string()).collect()
}

/// Removes the domain's segments of this user. What cannot be removed is found by [`check_segments`].
pub(super) fn remove_segments(prefix: &str) {
    for (path, _) in segments(prefix).filter(|(_, there)| there.uid() == geteuid().as_raw()) {
        let _ = fs::remove_file(path);
    }
}

pub(super) fn segments(prefix: &str) -> impl Iterator<Item = (PathBuf, Metadata)> {
    let entries = fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
    let of_domain = entries.filter(move |e| e.file_name().as_encoded_bytes().starts_with(prefix.as_bytes()));
    of_domain.filter_map(|entry| Some((entry.path(), entry.metadata().ok()?)))
}

fn ours(path: &Path, there: &Metadata) -> io::Result<()> {
    if there.uid() == geteuid().as_raw() { Ok(()) } else { Err(refused(path, there, "not ours")) }
}

fn refused(path: &Path, there: &Metadata, what: &str) -> io::Error {
    let kind = there.file_type();
    let kind = match () {
        () if kind.is_symlink() => "a symbolic link",
        () if kind.is_dir() => "a directory",
        () if kind.is_fifo() => "a FIFO",
        () if kind.is_socket() => "a socket",
        () if kind.is_file() => "a file",
        () => "a device",
    };
    let (path, mode, owner) = (path.display(), there.mode() & 0o7777, there.uid());
    let what = format!("{path} is {what}: {kind} of user {owner} with mode {mode:04o}; {ELSEWHERE}");
    io::Error::new(ErrorKind::PermissionDenied, what)
}
