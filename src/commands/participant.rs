//! `meniscus fluid`, `meniscus structure`, `meniscus fmu` and `meniscus mock`: one participant, served to a
//! coupler.

use super::{WRONG, failed};
use crate::arguments::{self, CaseArguments, Fmu, Join, Mock, Solver};
use coupler::recording::{OnDeparture, Replay};
use interfaces::case::Case;
use interfaces::transport::Alive;
use interfaces::{Address, Participant, Role};
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Serves our own solver of one side.
pub fn solver(arguments: &Solver, role: Role) -> ExitCode {
    serve(&arguments.case, &arguments.join, role, |case| {
        super::set_threads(case);
        let out = arguments.case.parent().unwrap_or(Path::new("."));
        super::solver(case, role, out).map_err(|e| e.to_string())
    })
}

/// Serves the unit that the case has for a side.
pub fn fmu(arguments: &Fmu) -> ExitCode {
    let (role, solver) = (arguments.role.into(), &arguments.solver);
    serve(&solver.case, &solver.join, role, |case| {
        if fmu_host::participant::unit_of(case, role).is_none() {
            return Err(format!("the case has no unit for the {role}: name one in {role}.participant.fmu"));
        }
        let out = solver.case.parent().unwrap_or(Path::new("."));
        fmu_host::open(case, role, out).map_err(|e| e.to_string())
    })
}

/// Loads and instantiates the unit that the case has for a side.
pub fn probe(arguments: &CaseArguments, role: Role) -> ExitCode {
    let case = match super::load(arguments) {
        Ok(case) => case,
        Err(code) => return code,
    };
    match super::check::probe_fmu(&case, role) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failed(error),
    }
}

/// Serves a mock partner, or a side that was recorded.
pub fn mock(arguments: &Mock) -> ExitCode {
    if let Some(recording) = &arguments.replay {
        return replay(arguments, recording);
    }
    let participant = match partners::MockSpec::from_words(&arguments.words).and_then(|spec| spec.build()) {
        Ok(participant) => participant,
        Err(error) => return failed(error),
    };
    let role = participant.describe().role;
    serve(&arguments.case, &arguments.join, role, |_| Ok(participant))
}

/// Serves a side as it was recorded. What departs is told on standard error, which the coupler keeps as that
/// side's log.
fn replay(arguments: &Mock, recording: &Path) -> ExitCode {
    let Some(role) = arguments.role else {
        return failed(
            "a replay needs the side that it stands in for: give --role fluid or --role structure",
        );
    };
    let role = role.into();
    let on_departure = match arguments.on_departure {
        arguments::OnDeparture::End => OnDeparture::End,
        arguments::OnDeparture::Continue => OnDeparture::Continue,
    };
    let mut replay = match Replay::open(recording, role, on_departure, |line| super::tell(line)) {
        Ok(replay) => replay,
        Err(error) => return failed(error),
    };
    serve(&arguments.case, &arguments.join, role, |case| {
        let changes = case.changes_since(&replay.header().case)?;
        let changes: Vec<_> =
            changes.iter().filter(|change| !change.is_free()).map(ToString::to_string).collect();
        if !changes.is_empty() {
            replay.note(&format!("it was recorded with another case: {}", changes.join(", ")));
        }
        Ok(Box::new(replay))
    })
}

/// Becomes a program of another make once the coupler says on standard input that the run's guard knows of
/// this process. A coupler that ends before closes it instead, and nothing is started that would outlive it.
pub fn become_other(words: &[String]) -> ExitCode {
    if !coupler::launch::is_released(std::io::stdin().lock()) {
        return failed("the coupler ended before the start");
    }
    let error = Command::new(&words[0]).args(&words[1..]).stdin(Stdio::null()).exec();
    failed(format_args!("failed to start `{}`: {error}", words.join(" ")))
}

/// A queue tells all processes of a job to end. The coupler then still wants its checkpoint, and ends us: so
/// we wait for that for a while, of one that lives.
fn left_to_the_coupler(told: Arc<AtomicBool>, mut coupler: Alive) -> (Arc<AtomicBool>, Alive) {
    const WHILE: Duration = Duration::from_secs(20);
    let (stop, mut since) = (Arc::new(AtomicBool::new(false)), None);
    let set = Arc::clone(&stop);
    let alive = move || {
        if told.load(Ordering::Relaxed) && since.get_or_insert_with(Instant::now).elapsed() > WHILE {
            set.store(true, Ordering::Relaxed);
        }
        coupler()
    };
    (stop, Box::new(alive))
}

fn serve(
    case_file: &Path,
    join: &Join,
    role: Role,
    build: impl FnOnce(&Case) -> Result<Box<dyn Participant>, String>,
) -> ExitCode {
    let case = match Case::load(case_file, &[], &super::SECTIONS) {
        Ok(case) => case,
        Err(errors) => {
            super::tell(&errors);
            return ExitCode::from(WRONG);
        }
    };
    let mut participant = match build(&case) {
        Ok(participant) => participant,
        Err(error) => return failed(error),
    };
    let stop = match super::checkpoint_flag().and_then(|_| super::stop_flag()) {
        Ok(stop) => stop,
        Err(error) => return failed(error),
    };
    let address = Address::parse(&join.run, role);
    let deadlines = coupler::run::participant_deadlines(&case);
    let coupler = join.coupler.map_or_else(|| Box::new(|| None) as _, coupler::launch::watch);
    let (stop, coupler) = match join.coupler {
        Some(_) => left_to_the_coupler(stop, coupler),
        None => (stop, coupler),
    };
    match interfaces::serve(participant.as_mut(), &address, &case.hash(), deadlines, &stop, coupler) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failed(error),
    }
}
