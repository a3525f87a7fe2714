//! Who is present in a domain, and that the last one to leave leaves nothing.
//!
//! iceoryx2 removes what a dead node left, but not what a process left that was killed while it made or
//! removed a node, service or port. So every node of ours holds a shared lock on a file of its domain for as
//! long as it is there; the kernel gives it back when the process ends, however it ends. Who can have the
//! lock alone knows that nobody is there, and removes whatever there still is.

use crate::transport::Address;
use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;
use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// The file of the domain's folder that is locked.
const LOCK: &str = "presence.lock";
/// Where POSIX shared memory stands.
const SHARED_MEMORY: &str = "/dev/shm";
/// For another process to finish removing what was left.
const REMOVAL: Duration = Duration::from_secs(5);
/// Between two attempts to have the lock.
const RETRY: Duration = Duration::from_millis(2);

/// A node of ours is there; while one is, nobody removes anything but what iceoryx2 says belongs to the dead.
pub(super) struct Presence {
    root: PathBuf,
    prefix: String,
    lock: File,
}

impl Presence {
    /// Enters the domain, which is empty before if nobody else is there. Comes before the node.
    pub(super) fn enter(address: &Address) -> io::Result<Self> {
        let (root, prefix) = (PathBuf::from(address.root()), address.prefix());
        let deadline = Instant::now() + REMOVAL;
        loop {
            if let Some(lock) = locked(&root, &prefix)? {
                return Ok(Self { root, prefix, lock });
            }
            if Instant::now() >= deadline {
                let what = format!("another process keeps {} to itself", root.join(LOCK).display());
                return Err(io::Error::new(ErrorKind::TimedOut, what));
            }
            sleep(RETRY);
        }
    }
}

impl Drop for Presence {
    /// Comes after the node's end. The last one to leave removes what is still there, the folder with it.
    fn drop(&mut self) {
        if flock(&self.lock, FlockOperation::NonBlockingLockExclusive).is_ok()
            && remove(&self.root, &self.prefix)
        {
            // The lock last: who comes now finds it gone, or not to be the file it has open, and begins anew.
            let _ = fs::remove_file(self.root.join(LOCK));
            let _ = fs::remove_dir(&self.root);
        }
    }
}

/// The domain's lock, shared; nothing while another process has it alone or has just removed it.
fn locked(root: &Path, prefix: &str) -> io::Result<Option<File>> {
    fs::DirBuilder::new().recursive(true).mode(0o750).create(root)?;
    let path = root.join(LOCK);
    let lock = match File::options().create(true).truncate(false).write(true).open(&path) {
        Ok(lock) => lock,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
    };
    let current = || {
        let there = fs::metadata(&path).ok()?;
        let ours = lock.metadata().ok()?;
        ((there.dev(), there.ino()) == (ours.dev(), ours.ino())).then_some(())
    };
    if flock(&lock, FlockOperation::NonBlockingLockExclusive).is_ok() && current().is_some() {
        remove(root, prefix);
    }
    // Between the two locks, or before the first, another may have come, left as the last and removed the
    // file.
    match flock(&lock, FlockOperation::NonBlockingLockShared) {
        Ok(()) => Ok(current().map(|()| lock)),
        Err(Errno::WOULDBLOCK) => Ok(None),
        // Some file systems know no locks; then nobody is ever alone, and iceoryx2's own cleaning has to do.
        Err(_) => Ok(Some(lock)),
    }
}

/// Removes everything of the domain but the lock, unless a process that holds no lock, a participant of
/// another make, has a node there. What cannot be removed is tried again by the next who finds itself alone.
fn remove(root: &Path, prefix: &str) -> bool {
    let nodes = root.join("nodes");
    if entries(&nodes).any(|path| owner(&path).is_some_and(lives)) {
        return false;
    }
    let ours = |path: &PathBuf| {
        path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(prefix.as_bytes()))
    };
    for segment in entries(Path::new(SHARED_MEMORY)).filter(ours) {
        let _ = fs::remove_file(segment);
    }
    for path in entries(root).filter(|path| path.file_name().is_none_or(|name| name != LOCK)) {
        let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
    true
}

fn entries(folder: &Path) -> impl Iterator<Item = PathBuf> {
    fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path())
}

/// The process that made a node, of which the folder for its details has its identity as name: seconds,
/// nanoseconds, process and a counter, 32 bits each.
fn owner(node: &Path) -> Option<u32> {
    let id: u128 = node.file_name()?.to_str()?.parse().ok()?;
    let [_, _, process, _] = parts(id);
    Some(process)
}

fn parts(id: u128) -> [u32; 4] {
    let bytes = id.to_ne_bytes();
    std::array::from_fn(|i| {
        u32::from_ne_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]])
    })
}

fn lives(process: u32) -> bool {
    // Its name, in parentheses, may hold anything; its state is the letter after it. A zombie has closed its
    // files.
    fs::read_to_string(format!("/proc/{process}/stat"))
        .is_ok_and(|stat| !stat.rsplit(") ").next().is_some_and(|rest| rest.starts_with(['Z', 'X'])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Role;
    use std::sync::atomic::{AtomicU64, Ordering};

    fn domain() -> Address {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let domain = format!("presence-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        Address::new("any", Role::Fluid).in_domain(domain)
    }

    /// What a process leaves that is killed while it makes a node, of the process of that number.
    fn litter(address: &Address, process: u32) -> [PathBuf; 4] {
        let mut id = [0; 16];
        id[8..12].copy_from_slice(&process.to_ne_bytes());
        let nodes = Path::new(&address.root()).join("nodes");
        let node = nodes.join(u128::from_ne_bytes(id).to_string());
        fs::create_dir_all(&node).unwrap();
        let left = [
            node.join(format!("{}node.details", address.prefix())),
            nodes.join(format!("{}.node_monitor_context", address.prefix())),
            Path::new(&address.root()).join(format!("{}.service", address.prefix())),
            Path::new(SHARED_MEMORY).join(format!("{}any.dynamic", address.prefix())),
        ];
        for file in &left {
            fs::write(file, "left").unwrap();
        }
        left
    }

    /// A process that has ended.
    fn ended() -> u32 {
        let mut child = std::process::Command::new("true").spawn().unwrap();
        child.wait().unwrap();
        child.id()
    }

    #[test]
    fn the_first_to_come_and_the_last_to_leave_remove_what_the_dead_left() {
        let address = domain();
        let left = litter(&address, ended());
        let first = Presence::enter(&address).unwrap();
        assert!(!left.iter().any(|file| file.exists()), "the first to come");
        let left = litter(&address, ended());
        let second = Presence::enter(&address).unwrap();
        drop(second);
        assert!(left.iter().all(|file| file.exists()), "while another is there");
        drop(first);
        assert!(!left.iter().any(|file| file.exists()), "the last to leave");
        assert!(!Path::new(&address.root()).exists());
    }

    #[test]
    fn the_node_of_a_participant_without_a_lock_keeps_everything() {
        let address = domain();
        let left = litter(&address, std::process::id());
        drop(Presence::enter(&address).unwrap());
        assert!(left.iter().all(|file| file.exists()));
        fs::remove_dir_all(Path::new(&address.root()).join("nodes")).unwrap();
        drop(Presence::enter(&address).unwrap());
        assert!(!left.iter().any(|file| file.exists()));
    }

    #[test]
    fn who_is_present_loses_nothing_to_those_who_come_and_leave() {
        let address = &domain();
        std::thread::scope(|scope| {
            for thread in 0..4 {
                scope.spawn(move || {
                    for visit in 0..200 {
                        let presence = Presence::enter(address).unwrap();
                        let file = Path::new(&address.root()).join(format!("{thread}-{visit}"));
                        fs::write(&file, "ours").unwrap();
                        std::thread::yield_now();
                        assert!(fs::remove_file(&file).is_ok(), "thread {thread}, visit {visit}");
                        drop(presence);
                    }
                });
            }
        });
        assert!(!Path::new(&address.root()).exists());
    }
}
