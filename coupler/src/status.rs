//! What a run is at: the file `status.json` of its folder, and in words, for `meniscus status` and for the
//! message of a deadline that has passed.

use interfaces::Role;
use output::files;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;
use std::time::Duration;
use words::text::tame;

/// File of the status, in the folder of the outputs, while a run goes on or after it was killed.
pub const FILE: &str = "status.json";
/// Longest file that is read (bytes): titles and warnings of any length that we write.
const LONGEST: u64 = 1 << 20;
/// Below this share of the time a process is said to wait, and above the other one to compute.
const IDLE: f64 = 0.05;
/// See [`IDLE`].
const BUSY: f64 = 0.5;

/// What a run is at, at the moment that it was written. Durations are up to then.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Status {
    /// Title of the case.
    pub title: String,
    /// Hash of the case, as the participants compare it.
    pub case_hash: String,
    /// Version of meniscus.
    pub version: String,
    /// The coupler's process.
    pub process: u32,
    /// When this was written (s since 1970).
    pub written: f64,
    /// Time since the start of this part of the run (s).
    pub elapsed_seconds: f64,
    /// Accepted windows.
    pub windows: u64,
    /// Simulated time (s).
    pub simulated_seconds: f64,
    /// Simulated time at which the run ends (s).
    pub end_time: f64,
    /// Interval of the outputs (s), which may have been changed while the run went on.
    pub output_interval: f64,
    /// Windows in each second of the last half minute; nothing before the first.
    pub windows_per_second: Option<f64>,
    /// What is left at that rate (s).
    pub remaining_seconds: Option<f64>,
    /// What the coupler is at.
    pub phase: String,
    /// For how long (s).
    pub phase_seconds: f64,
    /// Whom it waits for.
    pub waits_for: Option<Role>,
    /// For how long (s).
    pub waits_seconds: Option<f64>,
    /// Its largest memory so far (bytes).
    pub memory_bytes: u64,
    /// The participants.
    pub participants: Vec<Party>,
    /// How the last window converged; nothing with an explicit scheme.
    pub iterations: Option<Iterations>,
    /// The last checkpoint.
    pub checkpoint: Option<Checkpoint>,
    /// The last warnings.
    pub warnings: Vec<String>,
    /// The last request that was taken up ([`crate::request`]), and what came of it.
    pub answered: Option<Answered>,
}

/// A participant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Party {
    /// Which side.
    pub role: Role,
    /// What solves it; empty until it has come.
    #[serde(default)]
    pub solver: String,
    /// Its process, where the coupler started one.
    #[serde(default)]
    pub process: Option<u32>,
    /// What the system says of that process; empty where it is unknown.
    #[serde(default)]
    pub state: String,
    /// What it was asked for and has not answered yet.
    #[serde(default)]
    pub asked: Option<Doing>,
    /// What it did last.
    #[serde(default)]
    pub answered: Option<Doing>,
    /// Time of its own work so far, as it told (s).
    #[serde(default)]
    pub compute_seconds: f64,
    /// Processor time that it used while it was looked at (s): since it was asked, half a minute at most.
    #[serde(default)]
    pub processor_seconds: Option<f64>,
    /// For how long it was looked at (s).
    #[serde(default)]
    pub looked_at_seconds: Option<f64>,
    /// Its largest memory so far (bytes).
    #[serde(default)]
    pub memory_bytes: u64,
}

/// A task, and how long ago it was given or done.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Doing {
    /// Which.
    pub task: Task,
    /// How long ago (s).
    pub seconds_ago: f64,
}

/// What a participant is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// To connect and say what it is.
    Come,
    /// To initialise.
    Initialize,
    /// To solve a window.
    Solve {
        /// Its number.
        window: u64,
        /// The iteration.
        iteration: u32,
        /// Where it starts (s).
        start: f64,
    },
    /// To accept a window.
    Accept {
        /// Its number.
        window: u64,
    },
    /// To be saved.
    Save,
    /// To go to a saved state.
    Restore,
    /// To end.
    Terminate,
}

/// How a window converged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Iterations {
    /// Iterations of the last window.
    pub count: u64,
    /// Its last residual over the values, 1.
    pub relative: f64,
    /// Whether the measures held.
    pub converged: bool,
}

/// The last checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint {
    /// Windows before it.
    pub windows: u64,
    /// Simulated time (s).
    pub simulated_seconds: f64,
    /// How long ago it was written (s).
    pub seconds_ago: f64,
}

/// A request that was taken up.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Answered {
    /// Its number.
    pub number: u64,
    /// What came of it, one line each.
    pub what: Vec<String>,
}

impl fmt::Display for Task {
    /// As what is asked for: `solve window 17, iteration 1`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Come => f.write_str("connect"),
            Self::Initialize => f.write_str("initialise"),
            Self::Solve { window, iteration, .. } => {
                write!(f, "solve window {window}, iteration {iteration}")
            }
            Self::Accept { window } => write!(f, "accept window {window}"),
            Self::Save => f.write_str("save its state"),
            Self::Restore => f.write_str("go to a saved state"),
            Self::Terminate => f.write_str("end"),
        }
    }
}

impl Task {
    /// As what was done: `solved window 17, iteration 1`.
    fn done(self) -> String {
        match self {
            Self::Come => "connected".to_owned(),
            Self::Initialize => "initialised".to_owned(),
            Self::Solve { window, iteration, .. } => format!("solved window {window}, iteration {iteration}"),
            Self::Accept { window } => format!("accepted window {window}"),
            Self::Save => "saved its state".to_owned(),
            Self::Restore => "went to a saved state".to_owned(),
            Self::Terminate => "ended".to_owned(),
        }
    }
}

impl Status {
    /// Reads the file of a folder.
    ///
    /// # Errors
    /// What keeps it from being read, in words.
    pub fn read(folder: &Path) -> Result<Self, String> {
        let path = folder.join(FILE);
        let failed = |what: String| format!("failed to read {}: {what}", path.display());
        let text = files::read_text(&path, LONGEST).map_err(|error| failed(error.to_string()))?;
        serde_json::from_str(&text).map_err(|error| failed(error.to_string()))
    }

    /// All of it in lines for people, `old` being how long ago it was written.
    pub fn lines(&self, old: Duration) -> Vec<String> {
        let Self { title, windows, simulated_seconds, end_time, .. } = self;
        let share = 100.0 * simulated_seconds / end_time;
        let mut lines = vec![
            tame(title, 200),
            format!(
                "at          t = {} of {end_time} s ({share:.1} %), {windows} windows, after {}",
                short(*simulated_seconds),
                span(self.elapsed_seconds)
            ),
        ];
        if let Some(rate) = self.windows_per_second {
            let left =
                self.remaining_seconds.map_or_else(String::new, |left| format!(", {} left", span(left)));
            lines.push(format!("rate        {} windows/s{left}", short(rate)));
        }
        if let Some(Iterations { count, relative, converged }) = self.iterations {
            let ended = if converged { "converged" } else { "did not converge" };
            lines.push(format!(
                "iterations  {count} in the last window, which {ended}: residual {relative:.1e}"
            ));
        }
        lines.extend(self.waits());
        let of_coupler = (self.memory_bytes > 0).then(|| ("coupler".to_owned(), self.memory_bytes));
        let of_sides = self.participants.iter().filter(|party| party.memory_bytes > 0);
        let memory: Vec<_> = of_coupler
            .into_iter()
            .chain(of_sides.map(|party| (party.role.to_string(), party.memory_bytes)))
            .map(|(who, bytes)| format!("{who} {:.0} MB", bytes as f64 / 1e6))
            .collect();
        if !memory.is_empty() {
            lines.push(format!("memory      {}", memory.join(", ")));
        }
        if let Some(Checkpoint { windows, simulated_seconds, seconds_ago }) = self.checkpoint {
            let ago = span(seconds_ago + old.as_secs_f64());
            let time = short(simulated_seconds);
            lines.push(format!("checkpoint  after {windows} windows, t = {time} s, {ago} ago"));
        }
        lines.extend(self.warnings.iter().map(|what| format!("warning     {}", tame(what, 500))));
        lines
    }

    /// Who waits for whom, since when, and what each did last: a line for the coupler and each participant.
    pub fn waits(&self) -> Vec<String> {
        let asked = |role: Role| self.participants.iter().find(|party| party.role == role)?.asked;
        let mut lines = vec![match self.waits_for.and_then(|role| Some((role, asked(role)?))) {
            Some((role, Doing { task, .. })) => {
                let at = match task {
                    Task::Solve { start, .. } => format!(", from t = {} s", short(start)),
                    _ => String::new(),
                };
                let waits = span(self.waits_seconds.unwrap_or(self.phase_seconds));
                format!("coupler     waits for the {role} to {task}{at}, for {waits}")
            }
            None => format!("coupler     {}, for {}", self.phase, span(self.phase_seconds)),
        }];
        lines.extend(self.participants.iter().map(|party| party.line(self.waits_for)));
        lines
    }
}

impl Party {
    /// What it is at, in a line, while the coupler waits for `waited_for`.
    fn line(&self, waited_for: Option<Role>) -> String {
        let role = self.role.to_string();
        let last = self.answered.map_or_else(String::new, |Doing { task, seconds_ago }| {
            format!("; it {} {} ago", task.done(), span(seconds_ago))
        });
        let doing = match self.asked {
            Some(Doing { task, seconds_ago }) => {
                // Both work at once, and one answer is taken after the other.
                let turn = match waited_for.filter(|other| *other != self.role) {
                    Some(other) => format!(" (its answer is taken after that of the {other})"),
                    None => String::new(),
                };
                format!("was asked {} ago to {task}{turn}", span(seconds_ago))
            }
            None if self.answered.is_none() => "has not been asked yet".to_owned(),
            None => "waits for the coupler".to_owned(),
        };
        let who = match (self.solver.as_str(), self.process) {
            ("", None) => String::new(),
            ("", Some(process)) => format!(" [process {process}]"),
            (solver, None) => format!(" [{}]", tame(solver, 100)),
            (solver, Some(process)) => format!(" [{}, process {process}]", tame(solver, 100)),
        };
        format!("{role:<12}{doing}{last}{}{who}", self.use_of_time())
    }

    /// What the system says of its process, where it was asked for something.
    fn use_of_time(&self) -> String {
        let state = match self.state.as_str() {
            "" => return String::new(),
            state @ ("stopped" | "traced" | "ended") => return format!("; its process is {state}"),
            state => state,
        };
        if self.asked.is_none() {
            return String::new();
        }
        match self.processor_seconds.zip(self.looked_at_seconds).filter(|(_, passed)| *passed > 0.5) {
            Some((used, passed)) => {
                let does = match used / passed {
                    share if share < IDLE => "its process waits for something else",
                    share if share > BUSY => "it computes",
                    _ => "it computes now and then",
                };
                format!("; {does}: {used:.2} s of processor time in the last {}", span(passed))
            }
            None => format!("; its process is {state}"),
        }
    }
}

/// A duration (s) for people.
fn span(seconds: f64) -> String {
    let whole = seconds.max(0.0) as u64;
    match whole {
        0..=9 => format!("{seconds:.1} s"),
        10..=119 => format!("{whole} s"),
        120..=7199 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

fn short(value: f64) -> String {
    output::report::short(value).replace('−', "-")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn party(role: Role) -> Party {
        Party {
            role,
            solver: String::new(),
            process: None,
            state: String::new(),
            asked: None,
            answered: None,
            compute_seconds: 0.0,
            processor_seconds: None,
            looked_at_seconds: None,
            memory_bytes: 0,
        }
    }

    #[test]
    fn the_one_who_is_waited_for_is_named_with_what_it_does() {
        let solve = |window| Task::Solve { window, iteration: 1, start: 0.25 };
        let doing = |task, seconds_ago| Some(Doing { task, seconds_ago });
        let mut fluid = Party {
            solver: "meniscus fluid (ISPH)".to_owned(),
            process: Some(77),
            state: "sleeping".to_owned(),
            asked: doing(solve(17), 60.0),
            answered: doing(Task::Accept { window: 16 }, 61.5),
            processor_seconds: Some(0.0),
            looked_at_seconds: Some(30.0),
            ..party(Role::Fluid)
        };
        let structure = Party { answered: doing(solve(17), 60.25), ..party(Role::Structure) };
        let mut status = Status {
            waits_for: Some(Role::Fluid),
            waits_seconds: Some(60.0),
            participants: vec![fluid.clone(), structure],
            ..Status::default()
        };
        assert_eq!(
            status.waits(),
            [
                "coupler     waits for the fluid to solve window 17, iteration 1, from t = 0.25 s, for 60 s",
                "fluid       was asked 60 s ago to solve window 17, iteration 1; it accepted window 16 61 s ago; its process waits for \
                 something else: 0.00 s of processor time in the last 30 s [meniscus fluid (ISPH), process 77]",
                "structure   waits for the coupler; it solved window 17, iteration 1 60 s ago",
            ]
        );
        fluid.processor_seconds = Some(29.5);
        assert!(fluid.line(None).contains("; it computes: 29.50 s of processor time in the last 30 s"));
        fluid.state = "stopped".to_owned();
        let line = fluid.line(Some(Role::Structure));
        assert!(
            line.contains(
                "1 (its answer is taken after that of the structure); it accepted window 16 61 s ago"
            ),
            "{line}"
        );
        assert!(line.contains("; its process is stopped ["), "{line}");
        // What is written is what is read.
        status.participants.push(fluid);
        let dir = tempfile::tempdir().unwrap();
        let text = serde_json::to_vec(&status).unwrap();
        output::atomic::write_file(&dir.path().join(FILE), &text).unwrap();
        assert_eq!(Status::read(dir.path()), Ok(status));
    }

    #[test]
    fn durations_are_for_people() {
        let of = [0.04, 9.94, 10.0, 119.0, 120.0, 3725.0, 90_000.0];
        assert_eq!(
            of.map(span),
            ["0.0 s", "9.9 s", "10 s", "119 s", "2 min 00 s", "62 min 05 s", "25 h 00 min"]
        );
    }
}
