//! A process beside those of a run, which outlives a coupler that was killed: it ends whoever is left of the
//! participants' process groups, and removes what they leave in shared memory.
//!
//! Participants see the coupler's death by themselves while they wait for it. One that computes for minutes
//! does not, nor does a program of another make, nor what that started.

use super::{LOOK, LaunchError, watch};
use interfaces::{Address, Role, remove_stale};
use rustix::process::{Pid, Signal, kill_process_group};
use std::fs::File;
use std::io::{self, BufRead, Write as _};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{ChildStdin, Command, Stdio};
use std::time::{Duration, Instant};

/// What the coupler says when it ends in order: nothing is left to do.
const DONE: &str = "done";
/// How long those who see the coupler's death may take to leave in order.
const GRACE: Duration = Duration::from_millis(2500);

/// The guard of a run, seen from the coupler. A coupler that ends in any way closes what the guard reads.
#[derive(Debug)]
pub struct Guard {
    process: std::process::Child,
    told: Option<ChildStdin>,
}

impl Guard {
    /// Starts it: the command `guard` of `executable`, for the domain of `address`. It holds the lock of
    /// `folder` together with the coupler: nobody else writes there before those who are left have ended.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn start(executable: &Path, address: &Address, folder: Option<&File>) -> Result<Self, LaunchError> {
        let command = format!("{} guard", executable.display());
        let failed = |source| LaunchError { role: address.role, command: command.clone(), source };
        // A lock is there as long as any process has the folder open that was locked.
        let held = folder.map(File::try_clone).transpose().map_err(failed)?;
        let mut process = Command::new(executable)
            .args(["guard", &address.connect()])
            .env(interfaces::transport::FOLDER, address.root())
            .stdin(Stdio::piped())
            .stdout(held.map_or_else(Stdio::null, Stdio::from))
            .stderr(Stdio::null())
            .process_group(0)
            .spawn()
            .map_err(failed)?;
        let told = process.stdin.take();
        Ok(Self { process, told })
    }

    /// Tells it of a process group.
    pub fn watch(&mut self, group: Pid) {
        // A guard that is gone guards nothing, which is no reason to end a run.
        let _ = self.told.as_mut().map(|told| writeln!(told, "{}", group.as_raw_nonzero()));
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        let _ = self.told.take().map(|mut told| writeln!(told, "{DONE}"));
        let _ = self.process.wait();
    }
}

/// What the guard does: reads the groups from `input` until it ends.
pub fn stand(input: impl BufRead, run: &str) {
    let mut groups = Vec::new();
    for line in input.lines().map_while(io::Result::ok) {
        if line == DONE {
            return;
        }
        groups.extend(line.parse().ok().and_then(Pid::from_raw));
    }
    let deadline = Instant::now() + GRACE;
    // What a participant that has ended left in its group has nothing to leave in order.
    let is_there = |group: &Pid| watch(group.as_raw_nonzero().get().cast_unsigned())().is_none();
    while groups.iter().any(is_there) && Instant::now() < deadline {
        std::thread::sleep(LOOK);
    }
    for group in groups {
        // One that has gone in the meantime is what is wanted.
        let _ = kill_process_group(group, Signal::KILL);
    }
    // What cannot be removed now, the next run removes.
    let _ = remove_stale(&Address::parse(run, Role::Fluid));
}
