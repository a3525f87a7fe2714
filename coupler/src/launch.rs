//! Participants as processes of their own.

pub mod guard;

use interfaces::Role;
use interfaces::transport::Alive;
use rustix::io::Errno;
use rustix::process::{
    Pid, PidfdFlags, Signal, WaitIdOptions, WaitIdStatus, kill_process_group, pidfd_open, pidfd_send_signal,
    test_kill_process, waitid,
};
use std::fs::{self, File};
use std::io::{self, Read, Seek as _, SeekFrom, Write as _};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use thiserror::Error;
use words::text::tame;

/// A participant's process could not be started.
#[derive(Debug, Error)]
#[error("failed to start the {role} with `{command}`: {source}")]
pub struct LaunchError {
    role: Role,
    command: String,
    source: io::Error,
}

/// A participant's process and the group that it leads. They are killed when it is dropped, as far as they
/// still run then.
#[derive(Debug)]
pub struct Child {
    process: std::process::Child,
    log: PathBuf,
    peak_memory_bytes: u64,
    is_reaped: bool,
}

/// Bytes of a log that are looked at for last words.
const TAIL: u64 = 64 << 10;
/// Characters of last words at most.
const LAST_WORDS: usize = 500;
/// What a child is told that waits until it may go on.
const RELEASED: &[u8; 1] = b"\n";
/// How often a child that was told to end is looked at.
const LOOK: Duration = Duration::from_millis(5);

impl Child {
    /// Starts `command` in a process group of its own, so that Ctrl-C on the terminal reaches the coupler
    /// alone, which then ends the participants in order. `environment` is added to this process's own. What
    /// it prints goes to `log`; its standard input ends with this process, or with
    /// [`release`](Self::release).
    pub fn spawn(
        role: Role,
        command: &[String],
        environment: &[(&str, String)],
        log: &Path,
    ) -> Result<Self, LaunchError> {
        let failed = |source| LaunchError { role, command: command.join(" "), source };
        let (program, arguments) =
            command.split_first().ok_or_else(|| failed(io::Error::other("the command is empty")))?;
        let output = output::files::create(log).map_err(failed)?;
        let errors = output.try_clone().map_err(failed)?;
        let process = Command::new(program)
            .args(arguments)
            .envs(environment.iter().map(|(key, value)| (key, value)))
            .stdin(Stdio::piped())
            .stdout(output)
            .stderr(errors)
            .process_group(0)
            .spawn()
            .map_err(failed)?;
        Ok(Self { process, log: log.to_owned(), peak_memory_bytes: 0, is_reaped: false })
    }

    /// Says to a process that waits for it that it may go on: [`is_released`].
    pub fn release(&mut self) {
        // One that does not wait, or has ended, needs no word.
        let _ = self.process.stdin.take().map(|mut told| told.write_all(RELEASED));
    }

    /// How the process ended, if it did: its exit status, the last line of its log, and where the log is.
    pub fn ended(&mut self) -> Option<String> {
        let status = self.status()?;
        let said = self
            .last_words()
            .map_or(String::new(), |line| format!("; its last words, in {}: {line}", self.log.display()));
        Some(format!("{}{said}", describe(status)))
    }

    /// Largest resident memory seen by the calls so far (bytes); looks again if the process still runs.
    pub fn peak_memory_bytes(&mut self) -> u64 {
        self.peak_memory_bytes = self.peak_memory_bytes.max(peak_memory_bytes(Some(self.process.id())));
        self.peak_memory_bytes
    }

    /// Its number.
    pub fn id(&self) -> Pid {
        Pid::from_child(&self.process)
    }

    /// Processor time of the process so far (s).
    pub fn cpu_seconds(&self) -> f64 {
        cpu_seconds(Some(self.process.id()))
    }

    /// Lets the process end by itself until `deadline`, and kills it then, and what it started and left
    /// behind. Says how it ended where that was not in order.
    pub fn end(&mut self, deadline: Instant) -> Option<String> {
        while self.status().is_none() && Instant::now() < deadline {
            std::thread::sleep(LOOK);
        }
        let how = match self.status() {
            Some(status) if status.exit_status() == Some(0) => None,
            Some(_) => self.ended(),
            None => Some("it did not end by itself, and was killed".to_owned()),
        };
        self.kill();
        how
    }

    /// How it ended, if it did. It stays what systems call a zombie, so that its number is no other's until
    /// its group is killed.
    fn status(&self) -> Option<WaitIdStatus> {
        let look = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        waitid(rustix::process::WaitId::Pid(self.id()), look).ok().flatten()
    }

    fn kill(&mut self) {
        if self.is_reaped {
            return;
        }
        // An error says that they are gone already, which is what is wanted.
        let _ = kill_process_group(self.id(), Signal::KILL);
        let _ = self.process.kill();
        let _ = self.process.wait();
        self.is_reaped = true;
    }

    fn last_words(&self) -> Option<String> {
        let mut log = File::open(&self.log).ok()?;
        let length = log.metadata().ok()?.len();
        log.seek(SeekFrom::Start(length.saturating_sub(TAIL))).ok()?;
        let mut tail = Vec::new();
        log.take(TAIL).read_to_end(&mut tail).ok()?;
        last_words(&String::from_utf8_lossy(&tail))
    }
}

/// Waits for the word of [`Child::release`] on standard input. No, where that ends without it.
pub fn is_released(mut input: impl Read) -> bool {
    let mut word = [0];
    input.read_exact(&mut word).is_ok() && word == *RELEASED
}

impl Drop for Child {
    fn drop(&mut self) {
        self.kill();
    }
}

/// Sends a process a signal, after so long. It is meant, and no other that gets its number later.
///
/// # Errors
/// If it has ended, or may not be sent it.
pub fn strike(process: Pid, (signal, after): (Signal, Duration)) -> io::Result<()> {
    let process = pidfd_open(process, PidfdFlags::empty())?;
    if after.is_zero() {
        return Ok(pidfd_send_signal(&process, signal)?);
    }
    std::thread::Builder::new().spawn(move || {
        std::thread::sleep(after);
        // One that has ended meanwhile needs none.
        let _ = pidfd_send_signal(&process, signal);
    })?;
    Ok(())
}

/// Says when the process of that number has ended. It need not be a child of ours.
pub fn watch(process: u32) -> Alive {
    let id = i32::try_from(process).ok().and_then(Pid::from_raw);
    Box::new(move || {
        let gone = id.is_none_or(|id| test_kill_process(id) == Err(Errno::SRCH));
        let gone = gone || is_zombie(process);
        gone.then(|| format!("process {process} has ended"))
    })
}

/// Whether a process has ended and its parent has not looked yet.
fn is_zombie(process: u32) -> bool {
    state(process) == Some("ended")
}

/// What a process is at, in a word; nothing where there is none of that number, or the system does not tell.
pub fn state(process: u32) -> Option<&'static str> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // Its name, in parentheses, may hold anything; its state is the letter after it.
    Some(match stat.rsplit(") ").next()?.chars().next()? {
        'R' => "running",
        'D' => "waiting for a disk",
        'T' => "stopped",
        't' => "traced",
        'Z' | 'X' => "ended",
        _ => "sleeping",
    })
}

/// Largest resident memory so far of a process, or of this one (bytes); zero where the system does not tell.
pub fn peak_memory_bytes(process: Option<u32>) -> u64 {
    let file = process.map_or("/proc/self/status".to_owned(), |id| format!("/proc/{id}/status"));
    let kilobytes = fs::read_to_string(file).ok().and_then(|text| {
        let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
        line.trim().trim_end_matches("kB").trim().parse::<u64>().ok()
    });
    kilobytes.unwrap_or(0) * 1024
}

/// Makes the largest resident memory of this process what it is now, where the system can.
pub fn forget_peak_memory() {
    // Where it cannot, a later reading is that of an earlier peak: too much, and never too little.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// Processor time of all threads of a process, or of this one, so far (s); zero where the system does not
/// tell.
pub fn cpu_seconds(process: Option<u32>) -> f64 {
    let folder = process.map_or("/proc/self/task".to_owned(), |id| format!("/proc/{id}/task"));
    let Ok(threads) = fs::read_dir(folder) else { return 0.0 };
    let nanoseconds = |thread: fs::DirEntry| -> Option<u64> {
        let text = fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse().ok()
    };
    1e-9 * threads.flatten().filter_map(nanoseconds).sum::<u64>() as f64
}

/// The last line that says something; of a panic of Rust its place and its words.
fn last_words(log: &str) -> Option<String> {
    let lines: Vec<&str> = log.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    // After the reason come a note about it and a backtrace.
    let note = lines.iter().rposition(|line| line.starts_with("note: ") && line.contains("RUST_BACKTRACE"));
    let before = note.map_or(&lines[..], |note| &lines[..note]);
    let panic = before.iter().rposition(|line| line.starts_with("thread '") && line.contains("panicked at"));
    let words = match (note, panic) {
        (Some(_), Some(at)) => {
            before[at..].iter().take(2).map(|line| line.trim_end_matches(':')).collect::<Vec<_>>().join(": ")
        }
        (Some(_), None) => (*before.last()?).to_owned(),
        (None, _) => (*lines.last()?).to_owned(),
    };
    Some(tame(&words, LAST_WORDS))
}

fn describe(status: WaitIdStatus) -> String {
    match (status.exit_status(), status.terminating_signal()) {
        (Some(code), _) => format!("its process ended with exit code {code}"),
        (None, Some(signal)) if signal == Signal::BUS.as_raw() => {
            format!(
                "its process was ended by signal {signal}, as where memory that is shared cannot be had: see df /dev/shm"
            )
        }
        (None, Some(signal)) => format!("its process was ended by signal {signal}"),
        (None, None) => "its process ended".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str, log: &Path) -> Child {
        Child::spawn(Role::Fluid, &["sh".to_owned(), "-c".to_owned(), script.to_owned()], &[], log).unwrap()
    }

    fn wait_for_end(child: &mut Child) -> String {
        let deadline = Instant::now() + Duration::from_secs(20);
        loop {
            if let Some(ended) = child.ended() {
                return ended;
            }
            assert!(Instant::now() < deadline, "the child did not end");
            std::thread::sleep(LOOK);
        }
    }

    #[test]
    fn an_ended_child_is_described_with_its_last_words() {
        let log = std::env::temp_dir().join(format!("meniscus-launch-{}.log", std::process::id()));
        let mut child = shell("echo working; echo giving up >&2; exit 3", &log);
        let ended = wait_for_end(&mut child);
        let place = log.display();
        assert_eq!(
            ended,
            format!("its process ended with exit code 3; its last words, in {place}: giving up")
        );
        let mut child = shell("kill -9 $$", &log);
        assert_eq!(wait_for_end(&mut child), "its process was ended by signal 9");
        fs::remove_file(&log).unwrap();
    }

    #[test]
    fn what_a_child_started_ends_with_it() {
        let dir = tempfile::tempdir().unwrap();
        let (log, number) = (dir.path().join("log"), dir.path().join("number"));
        for (script, how) in [
            ("sleep 300 & echo $! > NUMBER; wait", Some("it did not end by itself, and was killed")),
            ("sleep 300 & echo $! > NUMBER", None),
        ] {
            let mut child = shell(&script.replace("NUMBER", &number.display().to_string()), &log);
            let started = || fs::read_to_string(&number).ok()?.trim().parse::<u32>().ok();
            while started().is_none() {
                std::thread::sleep(LOOK);
            }
            assert_eq!(child.end(Instant::now() + Duration::from_millis(300)).as_deref(), how);
            let mut other = watch(started().unwrap());
            let deadline = Instant::now() + Duration::from_secs(10);
            while other().is_none() {
                assert!(Instant::now() < deadline, "it still runs");
                std::thread::sleep(LOOK);
            }
            fs::remove_file(&number).unwrap();
        }
    }

    #[test]
    fn last_words_are_the_reason_tame_and_short() {
        let panic = "step 1\n\nthread 'main' (77) panicked at src/a.rs:3:5:\nindex out of bounds\n\
                     note: run with `RUST_BACKTRACE=1` environment variable to display a backtrace\n";
        let said = "thread 'main' (77) panicked at src/a.rs:3:5: index out of bounds";
        for (log, words) in [
            (panic, Some(said)),
            (
                "step 1\nmemory allocation of 11885772240 bytes failed\n\
                 note: run with `RUST_BACKTRACE=1` environment variable to display a backtrace\n",
                Some("memory allocation of 11885772240 bytes failed"),
            ),
            ("error: \u{1b}[31mno\0\n\n", Some("error: \u{fffd}[31mno\u{fffd}")),
            ("\n \n", None),
        ] {
            assert_eq!(last_words(log).as_deref(), words);
        }
        // A log of 800 MB, most of it a hole, and one long line at its end.
        let dir = tempfile::tempdir().unwrap();
        let log = dir.path().join("big.log");
        let script =
            format!("truncate -s 800M {0}; head -c 100000 /dev/zero | tr '\\0' x >> {0}", log.display());
        let mut child = shell(&script, &log);
        let ended = wait_for_end(&mut child);
        assert!(ended.len() < 1000 && ended.contains("more characters"), "{}", ended.len());
    }

    #[test]
    fn a_command_that_does_not_exist_is_named() {
        let log = std::env::temp_dir().join(format!("meniscus-launch-none-{}.log", std::process::id()));
        let error = Child::spawn(Role::Structure, &["/no/such/solver".to_owned()], &[], &log).unwrap_err();
        assert!(
            error.to_string().starts_with("failed to start the structure with `/no/such/solver`"),
            "{error}"
        );
        fs::remove_file(&log).unwrap();
    }

    #[test]
    fn this_process_has_a_peak_memory() {
        assert!(peak_memory_bytes(None) > 1 << 20);
    }
}
