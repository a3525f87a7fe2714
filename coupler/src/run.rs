//! A run from case to summary: participants, coupling, records. Start at [`run`].

pub mod checkpoint;
mod checkpoints;
pub mod folder;
pub mod found;
mod made;
pub mod options;
pub(crate) mod participants;
pub mod recorded;
mod watch;

pub use folder::{CASE, SUMMARY, is_alive};
pub use found::Found;
pub(crate) use made::coupled;
pub use options::{Options, Record, RunError};
pub use participants::{Build, Solvers, participant_deadlines, threads};
pub use recorded::{Recorded, Wanted};

use crate::convergence::Residual;
use crate::phase::Phase;
use crate::progress::Progress;
use crate::recording::{self, Header, Kept, Recording};
use crate::schemes::{Onward, Run, Solver};
use crate::side::Side;
use crate::status::Iterations;
use crate::timing::Timing;
use crate::trace::{TRACE, Trace};
use checkpoints::{Checkpoints, Written, patience};
use folder::Held;
use interfaces::Direction::Out;
use interfaces::case::Case;
use interfaces::case::participant::Start;
use interfaces::case::probe::Probe;
use interfaces::port::names;
use interfaces::{Port, Role, Scalar};
use made::alone;
use output::summary::{RoleUse, Status, Summary};
use participants::Participants;
use std::fs::File;
use std::panic::AssertUnwindSafe;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use watch::Watch;

/// Key of the summary's coupler: windows that were solved with all processes on one core
/// ([`crate::placement`]).
const WINDOWS_ON_ONE_CORE: &str = "windows_on_one_core";

/// Key of the summary's coupler: the recording's file, its bytes and blocks ([`crate::recording`]).
const RECORDING: &str = "recording";

/// Runs a case and writes its outputs. The summary is written, and given, however the run ends; the error
/// says why it did not complete.
pub fn run(case: &Case, options: &Options, solvers: &Solvers) -> (Summary, Result<(), RunError>) {
    let started = Instant::now();
    // Held until the end: a second run into the same folder is refused.
    let folder = callable(case, options)
        .and_then(|()| recordable(options))
        .and_then(|()| playable(case, options))
        .and_then(|()| prepare(case, options))
        .and_then(|held| folder::keep_scenario(&options.out, options.scenario.as_ref()).map(|()| held));
    let Outcome { result, ending, known } = match &folder {
        Ok(held) => couple(case, options, solvers, held.folder.try_clone().ok()),
        Err(_) => Outcome::default(),
    };
    let mut summary = Summary {
        title: case.general.title.clone(),
        case_hash: case.hash(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        threads: threads(case),
        seams: options.from.as_ref().map_or_else(Vec::new, |from| from.header.seams.clone()),
        ..known
    };
    if let Err(error) = folder {
        return (summary, Err(error));
    }
    summary.wall_seconds = seconds_before(options) + started.elapsed().as_secs_f64();
    for use_of in summary.roles.values_mut() {
        use_of.share = use_of.compute_seconds / summary.wall_seconds;
    }
    (summary.status, summary.message) = match &result {
        Ok(()) if summary.simulated_seconds >= case.general.end_time => (Status::Completed, None),
        Ok(()) if ending.is_some() => (Status::Completed, ending),
        Ok(()) => (Status::Interrupted, Some("the run was told to stop".to_owned())),
        Err(error) if error.is_interruption() => (Status::Interrupted, Some(error.to_string())),
        Err(error) => (Status::Failed, Some(error.to_string())),
    };
    folder::free_room(&options.out);
    let result = match (result, summary.write(&options.out.join(SUMMARY))) {
        (result, Ok(())) => result,
        (Ok(()), Err(summary)) => Err(summary.into()),
        (Err(run), Err(summary)) => Err(RunError::NoSummary { run: Box::new(run), summary }),
    };
    (summary, result)
}

/// The folder of the outputs: made anew, that of the run that goes on, or that of a branch of it.
fn prepare(case: &Case, options: &Options) -> Result<Held, RunError> {
    let Some(from) = &options.from else { return folder::prepare(&options.out, case) };
    if from.is_of(&options.out) {
        return folder::go_on(&options.out, case, from);
    }
    let folder = folder::prepare(&options.out, case)?;
    folder::branch(&options.out, from).map(|()| folder)
}

/// Time that the run had taken (s) when the checkpoint was written that it goes on from.
fn seconds_before(options: &Options) -> f64 {
    options.from.as_ref().map_or(0.0, Found::wall_seconds)
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

/// How a run ended.
struct Outcome {
    /// Why it could not go on.
    result: Result<(), RunError>,
    /// What ended it before its end time, where a participant asked for that or its state was steady.
    ending: Option<String>,
    /// What is known of it by then.
    known: Summary,
}

impl Default for Outcome {
    fn default() -> Self {
        Self { result: Ok(()), ending: None, known: Summary::default() }
    }
}

impl From<RunError> for Outcome {
    fn from(error: RunError) -> Self {
        Self { result: Err(error), ..Self::default() }
    }
}

/// From participants to records.
fn couple(case: &Case, options: &Options, solvers: &Solvers, folder: Option<File>) -> Outcome {
    let trace = options.trace.then(|| Trace::create(&options.out.join(TRACE))).transpose();
    let timing = match trace {
        Ok(trace) => Timing::new(trace),
        Err(error) => return RunError::from(error).into(),
    };
    let recording = match recording(case, options) {
        Ok(recording) => recording,
        Err(error) => return RunError::from(error).into(),
    };
    let board = timing.board();
    board.about(|status| {
        status.title.clone_from(&case.general.title);
        (status.case_hash, status.version) = (case.hash(), env!("CARGO_PKG_VERSION").to_owned());
        (status.end_time, status.output_interval) = (case.general.end_time, case.general.output_interval);
    });
    let watch = Watch::start(&options.out, board);
    let mut participants = Participants::new(timing.clone(), &options.stop, folder);
    if let Some(recording) = &recording {
        participants.record(recording.clone());
    }
    let announce = timing.announce();
    // Whatever comes of it, those that were started are ended, and nothing is left in shared memory.
    let mut outcome = caught(|| {
        let started = announce.during(Phase::Starting, || participants.start(case, options, solvers));
        started.and_then(|()| solve(case, options, &mut participants, &watch))
    })
    .unwrap_or_else(Outcome::from);
    let cause = |error: RunError| participants.blame(error).with_waits(|| board.waits());
    outcome.result = outcome.result.map_err(cause);
    let in_order = outcome.result.as_ref().err().is_none_or(RunError::is_interruption);
    let did = participants.did();
    let (memory, ends) = announce.during(Phase::Starting, || participants.end(in_order));
    // After another failure, or told to stop, nobody has to end as if nothing had happened.
    if let (Ok(()), Some(end)) = (&outcome.result, ends.into_iter().next())
        && !options.stop.load(Ordering::Relaxed)
    {
        outcome.result = Err(end.into());
    }
    outcome.known.notes.extend(did.lines().into_iter().map(|line| format!("scenario: {line}")));
    folder::remove_unpacked(&options.out);
    drop(watch);
    let roles = &mut outcome.known.roles;
    for (role, bytes) in memory {
        roles.entry(role).or_default().peak_memory_bytes = bytes;
    }
    let coupler = roles.entry("coupler".to_owned()).or_default();
    for (phase, seconds) in timing.seconds() {
        coupler.extra.insert(seconds_key(phase), seconds.into());
    }
    if let Some(Kept { path, bytes, blocks, note }) = recording.map(|recording| recording.end()) {
        let told =
            serde_json::json!({ "file": path.display().to_string(), "bytes": bytes, "blocks": blocks });
        coupler.extra.insert(RECORDING.to_owned(), told);
        outcome.known.notes.extend(note);
    }
    outcome.result = outcome.result.and(timing.end().map_err(RunError::from));
    outcome
}

/// The recording that is asked for.
fn recording(case: &Case, options: &Options) -> Result<Option<Recording>, recording::Error> {
    let Some(Record { path, limit }) = &options.record else { return Ok(None) };
    let version = env!("CARGO_PKG_VERSION").to_owned();
    let header = Header { version, case_hash: case.hash(), case: case.to_toml() };
    Recording::create(path, &header, *limit).map(Some)
}

/// Makes a panic of the coupler an error with its text.
fn caught<T>(call: impl FnOnce() -> Result<T, RunError>) -> Result<T, RunError> {
    std::panic::catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
        Err(RunError::Panicked(text.unwrap_or_else(|| "no text was given".to_owned())))
    })
}

/// Initialises the participants and solves all windows.
fn solve(
    case: &Case,
    options: &Options,
    participants: &mut Participants,
    watch: &Watch,
) -> Result<Outcome, RunError> {
    let started = Instant::now();
    if case.coupling.is_some() {
        Ok(windows(coupled(case, options, participants)?, case, options, (participants, watch), started))
    } else {
        Ok(windows(alone(case, options, participants)?, case, options, (participants, watch), started))
    }
}

/// Solves all windows and ends the sides in order.
fn windows<S: Solver>(
    mut recorded: Recorded<S>,
    case: &Case,
    options: &Options,
    (participants, watch): (&mut Participants, &Watch),
    started: Instant,
) -> Outcome {
    let board = participants.timing.board().clone();
    let mut notes_of_requests = Vec::new();
    let mut progress = Progress::new(0.0, case.general.end_time, options.quiet);
    let mut placement = participants.placement(case);
    let mut checkpoints = Checkpoints::new(case, options, &recorded, (started, &board));
    let (mut longest, mut last) = (Duration::ZERO, Instant::now());
    let mut result = loop {
        let driven = recorded.drive(|accepted, solver| {
            progress.window(accepted.time, accepted.window.index + 1, solver.sides().as_ref());
            board.window(&accepted.window, accepted.time, converged(solver.residuals()));
            if accepted.output.is_some() {
                participants.look_at_memory();
            }
            placement.window();
            longest = longest.max(last.elapsed());
            last = Instant::now();
            if checkpoints.wait_at_stop() {
                participants.be_patient(patience(longest));
            }
            let pauses = options.stop.load(Ordering::Relaxed)
                || checkpoints.are_due(accepted.time)
                || watch.is_asked();
            if pauses { Onward::Stop } else { Onward::Continue }
        });
        let asked = watch.take_up(&mut recorded.run.schedule, options, &checkpoints.written);
        let onward = driven.map_err(RunError::from).and_then(|()| checkpoints.between_windows(&mut recorded));
        if let Some(asked) = asked {
            watch.answer(&asked, &recorded.run.schedule, &checkpoints.written);
            notes_of_requests.extend(asked.note);
        }
        match onward {
            Ok(Onward::Continue) => {}
            ended => break ended.map(drop),
        }
    };
    let (sums, written) = recorded.sums();
    let Run { mut solver, schedule } = recorded.run;
    let mut known = Summary {
        windows: schedule.windows(),
        simulated_seconds: schedule.time(),
        notes: notes(case, solver.sides().as_ref()),
        ..Summary::default()
    };
    participants.leave();
    for side in solver.sides_mut() {
        let ended = side.terminate();
        // The first failure is the cause; that a failed participant cannot end in order is no news.
        result = result.and(ended.map_err(RunError::from));
        if side.role() == Role::Structure {
            known.sub_steps = side.sub_steps;
        }
        let role = RoleUse { compute_seconds: side.compute_seconds, ..RoleUse::default() };
        known.roles.insert(side.role().to_string(), role);
    }
    progress.end();
    for role in known.roles.values_mut() {
        let taken = seconds_before(options) + started.elapsed().as_secs_f64();
        role.wait_seconds = (taken - role.compute_seconds).max(0.0);
    }
    let coupler = known.roles.entry("coupler".to_owned()).or_default();
    coupler.extra.insert(WINDOWS_ON_ONE_CORE.to_owned(), placement.windows_together().into());
    let Written { count, bytes, seconds, notes } = checkpoints.written;
    if count > 0 {
        let told = serde_json::json!({ "count": count, "bytes": bytes, "seconds": seconds });
        coupler.extra.insert("checkpoints".to_owned(), told);
    }
    known.notes.extend(notes.into_iter().chain(notes_of_requests));
    let ending = solver.ending().filter(|_| result.is_ok());
    (known.balances, known.condition_46) = (sums.balances, sums.condition_46);
    (known.fluid, known.probes, known.iterations) = (sums.fluid, sums.probes, sums.iterations);
    result = result.and(written.map_err(RunError::from));
    Outcome { result, ending, known }
}

/// How a window with these residuals converged; nothing without iterations.
fn converged(residuals: &[Residual]) -> Option<Iterations> {
    let Residual { relative, converged, .. } = *residuals.last()?;
    Some(Iterations { count: residuals.len() as u64, relative, converged })
}

/// What the sides note, and probes of the case that nobody records: of a side that is not ours, which records
/// what it likes.
fn notes(case: &Case, sides: &[&Side]) -> Vec<String> {
    let mut notes = Vec::new();
    for side in sides {
        let (role, description) = (side.role(), side.describe());
        notes.extend(description.notes.iter().map(|note| format!("the {role}: {note}")));
        let is_of_side = |probe: &&Probe| probe.is_on_structure() == (role == Role::Structure);
        for probe in case.probes.iter().filter(is_of_side) {
            let is_missing = |probe: &Scalar| description.scalars.iter().all(|s| s.name != probe.name);
            let gives_position = |port: &Port| (port.name.as_str(), port.direction) == (names::POSITION, Out);
            if case.coupling.is_some()
                && probe.is_of_interface()
                && description.ports.iter().any(gives_position)
            {
                // The coupler records it.
                continue;
            }
            let missing: Vec<_> = probe.scalars(case.general.dimension).filter(is_missing).collect();
            if let Some(first) = missing.first() {
                let (solver, name) = (&description.solver, &probe.name);
                notes.push(format!(
                    "probe \"{name}\" is not recorded: the {role}, {solver}, reports no `{}`",
                    first.name
                ));
            }
        }
    }
    notes
}

/// Refuses, before anything is touched, to call a participant in this process that is no solver of ours.
fn callable(case: &Case, options: &Options) -> Result<(), RunError> {
    let mut roles = [Role::Structure, Role::Fluid].into_iter();
    let foreign = roles.find(|role| case.start(*role).is_some_and(|start| start != Start::Own));
    match foreign {
        Some(role) if options.in_process => Err(RunError::NotInProcess { role }),
        _ => Ok(()),
    }
}

/// Refuses, before anything is touched, a scenario of sides or processes that the run does not have.
fn playable(case: &Case, options: &Options) -> Result<(), RunError> {
    let there = [Role::Fluid, Role::Structure].into_iter().filter(|role| case.start(*role).is_some());
    let there: Vec<_> = there.collect();
    let fits = options.scenario.as_ref().map(|scenario| scenario.fits(&there, options.in_process));
    Ok(fits.transpose().map(drop)?)
}

/// Refuses, before anything is touched, to record what could not be replayed, or over another file.
fn recordable(options: &Options) -> Result<(), RunError> {
    let Some(Record { path, .. }) = &options.record else { return Ok(()) };
    let what = if options.from.is_some() {
        "a run that goes on from a checkpoint is not recorded, as its beginning would be missing; start one anew"
    } else if path.symlink_metadata().is_ok() {
        "it is there already; remove it, or give another name"
    } else if path.parent().is_some_and(|folder| !folder.starts_with(&options.out) && !is_there(folder)) {
        "its folder is not there; make it, or give another name"
    } else {
        return Ok(());
    };
    Err(recording::Error { doing: "write", path: path.clone(), what: what.to_owned() }.into())
}

/// Whether a folder is there: that of a bare name is the one at hand.
fn is_there(folder: &Path) -> bool {
    folder.as_os_str().is_empty() || folder.is_dir()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_of_the_coupler_ends_a_run_in_words() {
        let error = caught(|| -> Result<(), RunError> { panic!("capacity overflow") }).unwrap_err();
        assert!(error.to_string().starts_with("the coupler panicked: capacity overflow"), "{error}");
    }
}
