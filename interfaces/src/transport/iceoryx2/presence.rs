//! Who is present in a domain, and that the last one to leave leaves nothing.
//!
//! iceoryx2 removes what a dead node left, but not what a process left that was killed while it made or
//! removed a node, service or port. So every node of ours holds a shared lock on a file of its domain for as
//! long as it is there; the kernel gives it back when the process ends, however it ends. Who can have the
//! lock alone knows that nobody is there, and removes whatever there still is.

use super::private::{self, check_segments, close_counter, empty_segments, lock_file, remove_segments};
use crate::transport::Address;
use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;
use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// The file of the domain's folder that is locked.
const LOCK: &str = "presence.lock";
/// For another process to finish removing what was left.
const REMOVAL: Duration = Duration::from_secs(4);
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
                check_segments(&prefix)?;
                return Ok(Self { root, prefix, lock });
            }
            if Instant::now() >= deadline {
                let lock = root.join(LOCK);
                let lock = lock.display();
                let what =
                    format!("another process keeps {lock} to itself; find it with `fuser {lock}` and end it");
                return Err(io::Error::new(ErrorKind::TimedOut, what));
            }
            sleep(RETRY);
        }
    }

    /// Once the node is made: nobody else can reach what it counts with.
    pub(super) fn keep_private(&self) -> io::Result<()> {
        close_counter(&self.prefix)
    }

    /// What the names of the domain's segments begin with.
    pub(super) fn prefix(&self) -> &str {
        &self.prefix
    }

    /// What may keep a node from being made.
    pub(super) fn empty_segments(&self) -> Vec<String> {
        empty_segments(&self.prefix)
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
    match private::folder(root) {
        // The last to leave has just removed it.
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        made => made?,
    }
    let path = root.join(LOCK);
    let Some(lock) = lock_file(&path)? else { return Ok(None) };
    let current = || {
        let there = fs::symlink_metadata(&path).ok()?;
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
    remove_segments(prefix);
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
    use super::private::SHARED_MEMORY;
    use super::*;
    use crate::Role;
    use std::os::unix::fs::PermissionsExt;
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

    /// A user that is not this one; only root can act for it.
    const FOREIGN: u32 = 65534;

    fn give_away(path: &Path) {
        std::os::unix::fs::lchown(path, Some(FOREIGN), None).unwrap();
    }

    fn fifo(path: &Path) {
        assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
    }

    fn chmod(path: &Path, mode: u32) {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    }

    /// What somebody put there before us is refused by name, at once, and left as it is; nothing is made
    /// elsewhere.
    #[test]
    fn what_others_planted_is_refused() {
        type Plant = fn(&Path, &Path);
        let rows: [(&str, bool, Plant); 13] = [
            ("not ours", true, |root, _| {
                fs::create_dir(root).unwrap();
                give_away(root);
            }),
            ("others can write", false, |root, _| {
                fs::create_dir(root).unwrap();
                chmod(root, 0o770);
            }),
            ("others can write", false, |root, _| {
                fs::create_dir(root).unwrap();
                chmod(root, 0o1777);
            }),
            ("a symbolic link", false, |root, target| {
                std::os::unix::fs::symlink(target.parent().unwrap(), root).unwrap();
            }),
            ("no directory: a FIFO", false, |root, _| fifo(root)),
            ("no directory: a file", false, |root, _| fs::write(root, "").unwrap()),
            ("no directory: a socket", false, |root, _| {
                std::os::unix::net::UnixListener::bind(root).unwrap();
            }),
            ("a symbolic link", false, |root, target| {
                private::folder(root).unwrap();
                std::os::unix::fs::symlink(target, root.join(LOCK)).unwrap();
            }),
            ("no regular file: a FIFO", false, |root, _| {
                private::folder(root).unwrap();
                fifo(&root.join(LOCK));
            }),
            ("no regular file: a directory", false, |root, _| {
                private::folder(root).unwrap();
                fs::create_dir(root.join(LOCK)).unwrap();
            }),
            ("a file with another name besides", false, |root, target| {
                private::folder(root).unwrap();
                fs::write(root.join("other"), "").unwrap();
                fs::hard_link(root.join("other"), root.join(LOCK)).unwrap();
                let _ = target;
            }),
            ("not ours: a file", true, |root, _| {
                let name = format!("{}_a.global_mgmt", root.file_name().unwrap().to_str().unwrap());
                let segment = Path::new(SHARED_MEMORY).join(name);
                fs::write(&segment, "").unwrap();
                give_away(&segment);
            }),
            ("no regular file: a directory", false, |root, _| {
                let name = format!("{}_a.dynamic", root.file_name().unwrap().to_str().unwrap());
                fs::create_dir(Path::new(SHARED_MEMORY).join(name)).unwrap();
            }),
        ];
        let elsewhere = tempfile::tempdir().unwrap();
        let target = elsewhere.path().join("made");
        for (index, (named, needs_root, plant)) in rows.into_iter().enumerate() {
            if needs_root && !rustix::process::geteuid().is_root() {
                continue;
            }
            let address = domain();
            let root = PathBuf::from(address.root());
            plant(&root, &target);
            let started = Instant::now();
            let error = match Presence::enter(&address) {
                Ok(_) => panic!("row {index} was let in"),
                Err(error) => error.to_string(),
            };
            let segments = entries(Path::new(SHARED_MEMORY))
                .filter(|p| p.file_name().unwrap().to_string_lossy().starts_with(&address.prefix()));
            for left in [root.clone()].into_iter().chain(segments) {
                let _ = fs::remove_file(&left);
                let _ = fs::remove_dir_all(&left);
            }
            assert!(error.contains(named) && error.contains(&address.prefix()[..12]), "row {index}: {error}");
            assert!(started.elapsed() < Duration::from_secs(5), "row {index}");
            assert!(!target.exists(), "row {index}");
        }
    }

    /// Folders above ours in which somebody else could replace it.
    #[test]
    fn a_place_that_others_can_replace_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let root = place.path().join("domain");
        for (mode, fits) in [(0o755, true), (0o777, false), (0o775, false), (0o1777, true)] {
            chmod(place.path(), mode);
            let made = private::folder(&root);
            let _ = fs::remove_dir(&root);
            assert_eq!(made.is_ok(), fits, "{mode:o}: {made:?}");
        }
    }

    /// What an earlier version or another make left readable is closed.
    #[test]
    fn nobody_else_reads_the_folder_or_writes_the_counter() {
        let address = domain();
        let root = PathBuf::from(address.root());
        fs::create_dir(&root).unwrap();
        chmod(&root, 0o755);
        let node = super::super::node::OwnNode::<iceoryx2::service::ipc::Service>::new(&address).unwrap();
        assert_eq!(fs::metadata(&root).unwrap().mode() & 0o7777, 0o700);
        let modes: Vec<_> = entries(Path::new(SHARED_MEMORY))
            .filter(|path| path.file_name().unwrap().to_string_lossy().starts_with(&address.prefix()))
            .map(|path| fs::metadata(path).unwrap().mode() & 0o7777)
            .collect();
        assert_eq!(modes, [0o600]);
        // Another node counts with what took the counter's place.
        drop(super::super::node::OwnNode::<iceoryx2::service::ipc::Service>::new(&address).unwrap());
        drop(node);
        assert!(!root.exists());
    }

    /// Somebody empties the counter, or leaves an empty one, while a node is there.
    #[test]
    fn a_counter_that_stays_empty_is_named() {
        let address = domain();
        let first = super::super::node::OwnNode::<iceoryx2::service::ipc::Service>::new(&address).unwrap();
        let counter = entries(Path::new(SHARED_MEMORY))
            .find(|path| path.file_name().unwrap().to_string_lossy().starts_with(&address.prefix()))
            .unwrap();
        fs::write(&counter, "").unwrap();
        let started = Instant::now();
        let error = match super::super::node::OwnNode::<iceoryx2::service::ipc::Service>::new(&address) {
            Ok(_) => panic!("an empty counter counts"),
            Err(error) => error.to_string(),
        };
        assert!(error.contains(&counter.display().to_string()), "{error}");
        assert!(started.elapsed() < Duration::from_secs(5));
        // The node that was waited for in vain comes now, and leaves nothing either.
        fs::remove_file(&counter).unwrap();
        drop(first);
        let left = || {
            let mut segments = entries(Path::new(SHARED_MEMORY));
            let of_domain = |path: PathBuf| path.display().to_string().contains(&address.prefix());
            Path::new(&address.root()).exists() || segments.any(of_domain)
        };
        let deadline = Instant::now() + Duration::from_secs(10);
        while left() {
            assert!(Instant::now() < deadline, "something is left of {}", address.prefix());
            sleep(RETRY);
        }
        // Gone for good: who makes it anew does so before it looks like that.
        sleep(20 * RETRY);
        assert!(!left());
    }

    /// A lock that somebody keeps, as another user could who may open the folder.
    #[test]
    fn a_lock_that_is_kept_is_named() {
        let address = domain();
        let root = PathBuf::from(address.root());
        private::folder(&root).unwrap();
        fs::write(root.join(LOCK), "").unwrap();
        chmod(&root.join(LOCK), 0o644);
        let lock = lock_file(&root.join(LOCK)).unwrap().unwrap();
        assert_eq!(lock.metadata().unwrap().mode() & 0o7777, 0o600);
        flock(&lock, FlockOperation::LockExclusive).unwrap();
        let started = Instant::now();
        let error = match Presence::enter(&address) {
            Ok(_) => panic!("two have the domain to themselves"),
            Err(error) => error.to_string(),
        };
        assert!(started.elapsed() < Duration::from_secs(5));
        let lock_path = root.join(LOCK).display().to_string();
        assert!(error.contains(&lock_path) && error.contains("fuser"), "{error}");
        drop(lock);
        drop(Presence::enter(&address).unwrap());
        assert!(!root.exists());
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
