//! Room in shared memory. It is made of memory as it is written: where there is none, the writer is ended by
//! SIGBUS. So room is looked for before segments are made or grow, and reserved before they are written.

use super::private::{SHARED_MEMORY, segments};
use rustix::fs::{FallocateFlags, fallocate, statvfs};
use rustix::io::Errno;
use rustix::process::geteuid;
use std::fs::OpenOptions;
use std::os::unix::fs::MetadataExt;

/// More than the segments of one side take before any message is long (bytes).
pub(super) const FIRST: u64 = 1 << 20;
/// Messages that a segment has room for at most: those that wait, that are held and that are written.
const MESSAGES: u64 = 8;

/// Whether there are so many bytes; says what there is, and what to do.
pub(super) fn look(needed: u64) -> Result<(), String> {
    // Where the system does not tell, nothing is known.
    let Ok(there) = statvfs(SHARED_MEMORY) else { return Ok(()) };
    let [free, all] = [there.f_bavail, there.f_blocks].map(|blocks| blocks.saturating_mul(there.f_frsize));
    if free >= needed { Ok(()) } else { Err(told(needed, free, all)) }
}

/// Bytes of a segment for messages of so many doubles.
pub(super) fn of_messages(doubles: usize) -> u64 {
    MESSAGES * 8 * (doubles as u64 + 64).next_power_of_two()
}

/// Takes the memory of all segments of the domain that are this user's.
pub(super) fn reserve(prefix: &str) -> Result<(), String> {
    for (path, there) in segments(prefix).filter(|(_, there)| there.uid() == geteuid().as_raw()) {
        // st_blocks counts 512 bytes each.
        if there.blocks() * 512 >= there.len() {
            continue;
        }
        let Ok(segment) = OpenOptions::new().write(true).open(&path) else { continue };
        if fallocate(&segment, FallocateFlags::KEEP_SIZE, 0, there.len()) == Err(Errno::NOSPC) {
            look(there.len() - there.blocks() * 512)?;
            return Err(told(there.len(), 0, 0));
        }
    }
    Ok(())
}

fn told(needed: u64, free: u64, all: u64) -> String {
    let [needed, free, all] = [needed, free, all].map(|bytes| bytes.div_ceil(1024));
    format!(
        "{SHARED_MEMORY} is full: {needed} kB are needed, {free} of {all} kB are free; remove what others left \
         there, or make it larger (mount -o remount,size=1G {SHARED_MEMORY}; in a container --shm-size)"
    )
}
