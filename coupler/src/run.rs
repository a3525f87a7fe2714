//! A run from case to summary: participants, coupling, records. Start at [`run`].

use crate::phase::Phase;
use crate::records::Records;
use crate::schedule::Schedule;
use crate::schemes::{Accepted, Onward, Pair, Scheme, SchemeError, alone};
use crate::side::{Side, SideError};
use crate::timing::Timing;
use crate::trace::{TRACE, Trace};
use crate::{launch, progress::Progress};
use interfaces::case::Case;
use interfaces::case::resolved::Start;
use interfaces::{ParticipantError, Role, SubSteps, pairing};
use output::summary::{RoleUse, Status, Summary};
use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use thiserror::Error;

pub(crate) mod participants;

use participants::Participants;
pub use participants::{Build, Solvers, participant_deadlines};

/// What the command line sets of a run.
pub struct Options {
    /// Folder of the outputs.
    pub out: PathBuf,
    /// Whether the participants are called in this process instead of being processes of their own.
    pub in_process: bool,
    /// Whether nothing is drawn on the terminal.
    pub quiet: bool,
    /// Whether a trace is written.
    pub trace: bool,
    /// Domain of shared memory, where it is not the usual one.
    pub domain: Option<String>,
    /// Becomes true when the run is told to stop.
    pub stop: Arc<AtomicBool>,
}

/// Why a run did not complete.
#[derive(Debug, Error)]
pub enum RunError {
    /// A participant failed, or the two do not fit together.
    #[error(transparent)]
    Scheme(#[from] SchemeError),
    /// A participant could not be started.
    #[error(transparent)]
    Launch(#[from] launch::LaunchError),
    /// Outputs could not be written.
    #[error(transparent)]
    Output(#[from] output::Error),
    /// A participant that is not one of our solvers cannot be called in this process.
    #[error(
        "failed to call the {role} in this process: the case has another program for it ({role}.participant); leave out --in-process"
    )]
    NotInProcess {
        /// Which participant.
        role: Role,
    },
    /// The folder of the outputs holds something else.
    #[error("failed to use {} as the folder of the outputs: {what}; choose another with --out", .path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
}

impl From<SideError> for RunError {
    fn from(error: SideError) -> Self {
        Self::Scheme(error.into())
    }
}

impl RunError {
    /// Whether the run ended because it was told to.
    pub fn is_interruption(&self) -> bool {
        let Self::Scheme(SchemeError::Side(side)) = self else { return false };
        matches!(side.source, ParticipantError::Interrupted { .. })
    }
}

/// File of the case as resolved, in the folder of the outputs.
pub const CASE: &str = "case.toml";
/// The line that tells a case as resolved from a case as written, which must not be overwritten.
const RESOLVED: &str = "# The case as resolved by meniscus: every default filled in, all overrides applied.";
/// Folders into which a role's functional mock-up unit is unpacked while it runs.
const UNPACKED: [&str; 2] = ["fluid_fmu", "structure_fmu"];
/// Key of the summary's coupler: windows that were solved with all processes on one core
/// ([`crate::placement`]).
const WINDOWS_ON_ONE_CORE: &str = "windows_on_one_core";
/// File of the summary.
pub const SUMMARY: &str = "summary.json";

/// Runs a case and writes its outputs. The summary is written, and given, however the run ends; the error
/// says why it did not complete.
pub fn run(case: &Case, options: &Options, solvers: &Solvers) -> (Summary, Result<(), RunError>) {
    let started = Instant::now();
    let mut summary = Summary {
        title: case.general.title.clone(),
        case_hash: case.hash(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        threads: threads(case),
        ..Summary::default()
    };
    // Held until the end: a second run into the same folder is refused.
    let folder = match callable(case, options).and_then(|()| prepare_folder(&options.out, case)) {
        Ok(folder) => folder,
        Err(error) => return (summary, Err(error)),
    };
    let mut result = couple(case, options, solvers, &mut summary);
    summary.wall_seconds = started.elapsed().as_secs_f64();
    for use_of in summary.roles.values_mut() {
        use_of.share = use_of.compute_seconds / summary.wall_seconds;
    }
    (summary.status, summary.message) = match &result {
        Ok(()) if summary.message.is_some() => (Status::Completed, summary.message.take()),
        Ok(()) if summary.simulated_seconds < case.general.end_time => {
            (Status::Interrupted, Some("the run was told to stop".to_owned()))
        }
        Ok(()) => (Status::Completed, None),
        Err(error) if error.is_interruption() => (Status::Interrupted, Some(error.to_string())),
        Err(error) => (Status::Failed, Some(error.to_string())),
    };
    let written = summary.write(&options.out.join(SUMMARY));
    result = result.and(written.map_err(RunError::from));
    drop(folder);
    (summary, result)
}

/// What the coupler did in a run, in words, and for how long (s).
pub fn phases(summary: &Summary) -> Vec<(&'static str, f64)> {
    let Some(coupler) = summary.roles.get("coupler") else { return Vec::new() };
    let seconds = |phase: Phase| coupler.extra.get(&seconds_key(phase)).and_then(serde_json::Value::as_f64);
    Phase::ALL.into_iter().filter_map(|phase| Some((phase.name(), seconds(phase)?))).collect()
}

fn seconds_key(phase: Phase) -> String {
    format!("{}_seconds", phase.key())
}

/// Threads that a solver is given.
pub fn threads(case: &Case) -> usize {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    if case.general.threads == 0 { all } else { case.general.threads }
}

/// From participants to records; what is known at the end is put into the summary, also after a failure.
fn couple(case: &Case, options: &Options, solvers: &Solvers, summary: &mut Summary) -> Result<(), RunError> {
    let trace = options.trace.then(|| Trace::create(&options.out.join(TRACE))).transpose()?;
    let timing = Timing::new(trace);
    let mut participants = Participants::new(timing.clone());
    let announce = timing.announce();
    let result = announce
        .during(Phase::Starting, || participants.start(case, options, solvers))
        .and_then(|()| windows(case, options, &mut participants, summary));
    let in_order = result.as_ref().err().is_none_or(RunError::is_interruption);
    announce.during(Phase::Starting, || participants.end(summary, in_order));
    for name in UNPACKED {
        // What a unit's process could not remove because it died. What is left all the same, the next run
        // removes.
        let _ = std::fs::remove_dir_all(options.out.join(name));
    }
    let coupler = summary.roles.entry("coupler".to_owned()).or_default();
    for (phase, seconds) in timing.seconds() {
        coupler.extra.insert(seconds_key(phase), seconds.into());
    }
    result.and(timing.end().map_err(RunError::from))
}

/// A fluid and a structure ready for their first window, with what keeps their time and records.
pub(crate) struct Coupled {
    pub(crate) pair: Pair,
    pub(crate) schedule: Schedule,
    pub(crate) records: Records,
    timing: Timing,
}

impl Coupled {
    /// Initialises both participants of a case of both sides.
    pub(crate) fn initialize(
        case: &Case,
        options: &Options,
        participants: &mut Participants,
    ) -> Result<Self, RunError> {
        let coupling = case.coupling.as_ref().expect("a case of both sides has a coupling");
        let mut taken = |role| participants.take(role).expect("a case of both sides starts both");
        let (fluid, structure) = (taken(Role::Fluid), taken(Role::Structure));
        fit(&structure, &fluid)?;
        let timing = participants.timing.clone();
        let schedule = schedule(case);
        let mut pair = Pair::initialize(fluid, structure, schedule.time(), coupling.structure_velocity)?;
        pair.announce = timing.announce();
        pair.load_in_window = coupling.load_in_window;
        if let Some(steady_state) = &coupling.steady_state {
            pair.end_when_steady(steady_state.clone());
        }
        let sides = [&pair.fluid, &pair.structure];
        let mut records = Records::create(&options.out, &sides, schedule.time())?;
        if coupling.scheme.is_implicit() {
            records.record_iterations()?;
        }
        Ok(Self { pair, schedule, records, timing })
    }

    /// Solves all windows; `heard` is told of each when it is recorded.
    pub(crate) fn run(
        &mut self,
        case: &Case,
        mut heard: impl FnMut(&Accepted, &Pair) -> Onward,
    ) -> Result<(), SchemeError> {
        let Self { pair, schedule, records, timing } = self;
        let announce = timing.announce();
        Scheme::of(case.coupling.as_ref().expect("a case of both sides has a coupling")).run(
            pair,
            schedule,
            |accepted, pair| {
                announce.during(Phase::Records, || {
                    let sides = [&pair.fluid, &pair.structure];
                    records.iterations(&accepted.window, &pair.residuals).map_err(unrecorded(accepted))?;
                    records.window(accepted, &sides).map_err(unrecorded(accepted))
                })?;
                Ok(heard(accepted, pair))
            },
        )
    }
}

/// Initialises the participants and solves all windows.
fn windows(
    case: &Case,
    options: &Options,
    participants: &mut Participants,
    summary: &mut Summary,
) -> Result<(), RunError> {
    let started = Instant::now();
    let mut progress = Progress::new(0.0, case.general.end_time, options.quiet);
    let stop = || options.stop.load(Ordering::Relaxed);
    let onward = || if stop() { Onward::Stop } else { Onward::Continue };

    let mut placement = participants.placement(case);
    let (result, sums, schedule) = if case.coupling.is_some() {
        let mut coupled = Coupled::initialize(case, options, participants)?;
        let result = coupled.run(case, |accepted, pair| {
            progress_to(&mut progress, participants, accepted, &[&pair.fluid, &pair.structure]);
            placement.window();
            onward()
        });
        let Coupled { mut pair, schedule, mut records, .. } = coupled;
        let sums = records.balances()?;
        summary.message = pair.ending.take().filter(|_| result.is_ok());
        (end([&mut pair.fluid, &mut pair.structure], result, summary), sums, schedule)
    } else {
        let mut schedule = schedule(case);
        let role = if case.fluid.is_some() { Role::Fluid } else { Role::Structure };
        let mut side = participants.take(role).expect("a checked case has a fluid or a structure");
        let points = side.points().unwrap_or(0);
        side.initialize(schedule.time(), points, None)?;
        let mut records = Records::create(&options.out, &[&side], schedule.time())?;
        let announce = participants.timing.announce();
        let result = alone::run(&mut side, &mut schedule, |accepted, side| {
            announce
                .during(Phase::Records, || records.window(accepted, &[side]))
                .map_err(unrecorded(accepted))?;
            progress_to(&mut progress, participants, accepted, &[side]);
            Ok(onward())
        });
        let sums = records.balances()?;
        summary.message =
            (result.is_ok() && side.asks_for_end()).then(|| format!("the {} asked for it", side.role()));
        (end([&mut side], result, summary), sums, schedule)
    };
    progress.end();
    for role in summary.roles.values_mut() {
        role.wait_seconds = (started.elapsed().as_secs_f64() - role.compute_seconds).max(0.0);
    }
    let coupler = summary.roles.entry("coupler".to_owned()).or_default();
    coupler.extra.insert(WINDOWS_ON_ONE_CORE.to_owned(), placement.windows_together().into());
    drop(placement);
    summary.windows = schedule.windows();
    summary.simulated_seconds = schedule.time();
    if summary.simulated_seconds >= case.general.end_time {
        // Who asks for the end at the end only gets what the case had said.
        summary.message = None;
    }
    (summary.balances, summary.condition_46) = (sums.balances, sums.condition_46);
    (summary.fluid, summary.probes, summary.iterations) = (sums.fluid, sums.probes, sums.iterations);
    Ok(result?)
}

fn progress_to(
    progress: &mut Progress,
    participants: &mut Participants,
    accepted: &Accepted,
    sides: &[&Side],
) {
    progress.window(accepted.time, accepted.window.index + 1, sides);
    if accepted.output.is_some() {
        participants.look_at_memory();
    }
}

fn unrecorded(accepted: &Accepted) -> impl Fn(output::Error) -> SchemeError {
    let window = accepted.window.index;
    move |error| SchemeError::Record { window, what: error.to_string() }
}

/// Terminates what still can be, and puts the sides' own figures into the summary.
fn end<const N: usize>(
    sides: [&mut Side; N],
    result: Result<(), SchemeError>,
    summary: &mut Summary,
) -> Result<(), SchemeError> {
    let mut result = result;
    for side in sides {
        let role = RoleUse { compute_seconds: side.compute_seconds, ..RoleUse::default() };
        summary.roles.insert(side.role().to_string(), role);
        if side.role() == Role::Structure {
            summary.sub_steps = side.sub_steps;
        }
        let ended = side.terminate();
        // The first failure is the cause; that a failed participant cannot end in order is no news.
        result = result.and(ended.map_err(SchemeError::from));
    }
    result
}

fn schedule(case: &Case) -> Schedule {
    let general = &case.general;
    let (max_window, sub_steps) =
        case.coupling.as_ref().map_or((f64::INFINITY, SubSteps::Stable), |c| (c.max_window, c.sub_steps));
    Schedule::new(0.0, general.end_time, general.output_interval, max_window, sub_steps)
}

/// Compares what the two sides take and give.
fn fit(structure: &Side, fluid: &Side) -> Result<(), SchemeError> {
    let mismatches = pairing::compare(structure.describe(), fluid.describe());
    if mismatches.is_empty() { Ok(()) } else { Err(SchemeError::Mismatch(mismatches)) }
}

/// Refuses, before anything is touched, to call a participant in this process that is no solver of ours.
fn callable(case: &Case, options: &Options) -> Result<(), RunError> {
    let mut roles = [Role::Structure, Role::Fluid].into_iter();
    let foreign = roles.find(|role| case.start(*role).is_some_and(|start| *start != Start::Own));
    match foreign {
        Some(role) if options.in_process => Err(RunError::NotInProcess { role }),
        _ => Ok(()),
    }
}

/// Makes the folder, or empties it of an earlier run; writes the case as resolved. Gives the folder, locked
/// while it is open.
pub(crate) fn prepare_folder(out: &Path, case: &Case) -> Result<File, RunError> {
    let folder = |what: String| RunError::Folder { path: out.to_owned(), what };
    std::fs::create_dir_all(out).map_err(|e| folder(e.to_string()))?;
    let mut entries = std::fs::read_dir(out).map_err(|e| folder(e.to_string()))?;
    let opened = File::open(out).map_err(|e| folder(e.to_string()))?;
    match opened.try_lock() {
        Err(TryLockError::WouldBlock) => return Err(folder("another run writes to it".to_owned())),
        // Some file systems know no locks; the run does not depend on them.
        Ok(()) | Err(TryLockError::Error(_)) => {}
    }
    let holds_a_run =
        std::fs::read_to_string(out.join(CASE)).is_ok_and(|text| text.lines().next() == Some(RESOLVED));
    if !holds_a_run && entries.next().is_some() {
        return Err(folder("it holds files that are not of an earlier run".to_owned()));
    }
    for name in ["fluid", "structure", "walls", "frames"].into_iter().chain(UNPACKED) {
        remove(&out.join(name), |p| std::fs::remove_dir_all(p)).map_err(|e| folder(e.to_string()))?;
    }
    let files = [
        SUMMARY,
        crate::records::WINDOWS,
        crate::records::PROBES,
        crate::records::ITERATIONS,
        output::columns::FILE,
        TRACE,
        "report.html",
        "fluid.pvd",
        "structure.pvd",
        "walls.pvd",
        "fluid.log",
        "structure.log",
    ];
    for name in files {
        remove(&out.join(name), |p| std::fs::remove_file(p)).map_err(|e| folder(e.to_string()))?;
    }
    let text = format!("{RESOLVED}\n\n{}", case.to_toml());
    output::atomic::write_file(&out.join(CASE), text.as_bytes()).map_err(|e| folder(e.to_string()))?;
    Ok(opened)
}

fn remove(path: &Path, how: impl Fn(&Path) -> std::io::Result<()>) -> std::io::Result<()> {
    match how(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Participants by role.
type ByRole<T> = BTreeMap<Role, T>;
