//! A bench on which the command is run: a folder, a domain of shared memory that must be empty in the end,
//! processes with a watchdog.

use interfaces::{Address, Role};
use output::summary::Summary;
use output::table::Columns;
use rustix::process::{Pid, Signal, kill_process};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// The command under test.
pub const MENISCUS: &str = env!("CARGO_BIN_EXE_meniscus");

/// Far more than any process of these tests takes, on a loaded machine, unless it is stuck.
pub const WATCHDOG: Duration = Duration::from_secs(90);

/// The gate of `cases/elastic_gate` with 560 particles of water, two through the rubber, for 0.02 s: a fifth
/// of a second of work.
pub const COARSE: [&str; 8] = [
    "cases/elastic_gate",
    "--set",
    "case.particle_spacing=5e-3",
    "--set",
    "structure.particle_spacing=2.5e-3",
    "--set",
    "case.end_time=0.02",
    "--no-report",
];

/// A folder and a domain of shared memory.
pub struct Bench {
    dir: TempDir,
    pub domain: String,
}

impl Bench {
    pub fn new() -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let domain = format!("mr-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        Self { dir: tempfile::tempdir().expect("a folder for the test"), domain }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    /// The command with these words, in the folder of the sources and the bench's domain.
    pub fn command(&self, words: &[&str]) -> Command {
        let mut command = Command::new(MENISCUS);
        command
            .args(words)
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .env("MENISCUS_DOMAIN", &self.domain)
            .stdin(Stdio::null());
        command
    }

    /// Starts the command; `name` is for the files that take what it prints.
    pub fn start(&self, name: &str, words: &[&str]) -> Running {
        Running::spawn(self.command(words), &self.path(name))
    }

    /// Runs the command to its end.
    pub fn call(&self, words: &[&str]) -> Ended {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let name = format!("call-{}", COUNT.fetch_add(1, Ordering::Relaxed));
        self.start(&name, words).wait()
    }

    /// `meniscus run <words> --out <bench>/<out>`.
    pub fn start_run(&self, out: &str, words: &[&str]) -> Running {
        let dir = self.path(out).display().to_string();
        self.start(&format!("{out}.printed"), &[&["run"], words, &["--out", &dir]].concat())
    }

    /// A run of the coarse gate with more words, which must complete.
    pub fn coarse_gate(&self, out: &str, words: &[&str]) -> Outputs {
        let ended = self.start_run(out, &[&COARSE, words].concat()).wait();
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        self.outputs(out)
    }

    pub fn outputs(&self, out: &str) -> Outputs {
        Outputs(self.path(out))
    }

    /// What the domain has in shared memory and under its folder, but for empty folders.
    pub fn left(&self) -> Vec<String> {
        let address = self.address();
        let mut left = files(Path::new(&address.root()));
        left.extend(files(Path::new("/dev/shm")).into_iter().filter(|path| path.contains(&address.prefix())));
        left
    }

    fn address(&self) -> Address {
        Address::new("any", Role::Fluid).in_domain(&self.domain)
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        // The guard of a run that was killed may still be at work.
        let started = Instant::now();
        let left = loop {
            let left = self.left();
            if left.is_empty() || started.elapsed() > Duration::from_secs(5) {
                break left;
            }
            std::thread::sleep(Duration::from_millis(10));
        };
        let _ = fs::remove_dir_all(self.address().root());
        if !std::thread::panicking() {
            assert!(left.is_empty(), "left in shared memory: {left:#?}");
        }
    }
}

fn files(folder: &Path) -> Vec<String> {
    let Ok(entries) = fs::read_dir(folder) else { return vec![] };
    let mut found = vec![];
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.push(path.display().to_string());
        }
    }
    found
}

/// A process of the command, killed with its test.
pub struct Running {
    child: Child,
    printed: PathBuf,
}

/// How a process ended.
pub struct Ended {
    pub status: ExitStatus,
    /// Standard output.
    pub text: String,
    /// Standard error.
    pub errors: String,
}

impl Running {
    pub fn spawn(mut command: Command, printed: &Path) -> Self {
        let [output, errors] = ["out", "err"]
            .map(|end| File::create(printed.with_extension(end)).expect("a file for what it prints"));
        let child = command.stdout(output).stderr(errors).spawn().expect("the command starts");
        Self { child, printed: printed.to_owned() }
    }

    pub fn pid(&self) -> Pid {
        Pid::from_child(&self.child)
    }

    pub fn signal(&self, signal: Signal) {
        kill_process(self.pid(), signal).expect("the process is there");
    }

    /// The process that the run started for that role, once there is one.
    pub fn participant(&self, role: Role) -> Pid {
        until("the participant's process", || self.participant_if_any(role))
    }

    /// The process that the run has started for that role.
    pub fn participant_if_any(&self, role: Role) -> Option<Pid> {
        let id = self.child.id();
        let ids = fs::read_to_string(format!("/proc/{id}/task/{id}/children")).ok()?;
        let variable = format!("MENISCUS_ROLE={role}");
        let found = ids.split_whitespace().find(|id| {
            let environment = fs::read(format!("/proc/{id}/environ")).unwrap_or_default();
            environment.split(|&byte| byte == 0).any(|entry| entry == variable.as_bytes())
        })?;
        Pid::from_raw(found.parse().ok()?)
    }

    /// Whether it has ended.
    pub fn has_ended(&mut self) -> bool {
        self.child.try_wait().expect("a child of ours").is_some()
    }

    /// Waits for its end, within the watchdog.
    pub fn wait(mut self) -> Ended {
        let started = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().expect("a child of ours") {
                break status;
            }
            assert!(started.elapsed() < WATCHDOG, "it did not end; it said: {}", self.printed("err"));
            std::thread::sleep(Duration::from_millis(5));
        };
        Ended { status, text: self.printed("out"), errors: self.printed("err") }
    }

    pub fn printed(&self, end: &str) -> String {
        fs::read_to_string(self.printed.with_extension(end)).expect("what it printed")
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Whether that process has ended, a zombie being none any more.
pub fn gone(process: Pid) -> bool {
    let state = coupler::launch::state(process.as_raw_nonzero().get().unsigned_abs());
    state.is_none_or(|state| state == "ended")
}

/// A participant of a case: this command.
pub fn command(words: &[&str]) -> String {
    format!("{{ command = {words:?} }}")
}

/// A participant of a case: the mock of these words.
pub fn mock(words: &str) -> String {
    command(&[MENISCUS, "mock"].into_iter().chain(words.split_whitespace()).collect::<Vec<_>>())
}

/// Looks until there is something, within the watchdog.
pub fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(started.elapsed() < WATCHDOG, "{what} did not come");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// The folder of a run's outputs.
pub struct Outputs(pub PathBuf);

impl Outputs {
    pub fn table(&self, name: &str) -> Columns {
        output::table::read(&self.0.join(name)).expect("a table that can be read")
    }

    pub fn summary(&self) -> Summary {
        Summary::read(&self.0.join("summary.json")).expect("a summary that can be read")
    }

    /// Tables but for columns of seconds, to the bit.
    pub fn tables(&self) -> Vec<(String, Vec<u64>)> {
        let mut result = Vec::new();
        let of_probes = ["probes.csv", "probes_intervals.csv"].into_iter();
        let of_probes = of_probes.filter(|name| self.0.join(name).exists());
        for name in ["windows.csv"].into_iter().chain(of_probes) {
            for (column, values) in self.table(name).iter().filter(|(c, _)| !c.ends_with("_seconds")) {
                result.push((format!("{name}: {column}"), values.iter().map(|v| v.to_bits()).collect()));
            }
        }
        result
    }

    /// Everything that must not depend on how the run was made: tables, and snapshots byte for byte.
    pub fn result(&self) -> Vec<(String, Vec<u64>)> {
        let mut result = self.tables();
        for file in self.snapshots() {
            let bytes = fs::read(&file).expect("a snapshot that can be read");
            let name = file.file_name().expect("a file has a name").to_string_lossy().into_owned();
            result.push((name, bytes.into_iter().map(u64::from).collect()));
        }
        result
    }

    /// The snapshots that the series list. They must be readable.
    pub fn snapshots(&self) -> Vec<PathBuf> {
        let mut found = Vec::new();
        for series in ["fluid.pvd", "structure.pvd"].map(|name| self.0.join(name)) {
            if !series.exists() {
                continue;
            }
            for entry in output::pvd::read(&series).expect("a series that can be read") {
                let file = self.0.join(&entry.file);
                output::vtu::read(&file).expect("a snapshot that can be read");
                found.push(file);
            }
        }
        found
    }
}

/// Names where two results differ.
pub fn assert_same(one: &Outputs, other: &Outputs) {
    let (one, other) = (one.result(), other.result());
    let names = |result: &[(String, Vec<u64>)]| result.iter().map(|r| r.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&one), names(&other));
    for ((name, one), (_, other)) in one.iter().zip(&other) {
        let differs = (0..one.len().max(other.len())).find(|&i| one.get(i) != other.get(i));
        assert_eq!(differs, None, "{name} differs first there");
    }
}
