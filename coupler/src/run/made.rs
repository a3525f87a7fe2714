//! A run from its participants: initialised, at its start or at the checkpoint that it goes on from, with its
//! tables.

use super::checkpoint;
use super::options::{Options, RunError};
use super::participants::Participants;
use super::recorded::{Recorded, Wanted};
use crate::phase::Announce;
use crate::schedule::Schedule;
use crate::schemes::{Coupled, Pair, Run, Scheme, SchemeError, Solver};
use crate::side::Side;
use interfaces::case::Case;
use interfaces::case::participant::Start;
use interfaces::{Role, SubSteps, pairing};

/// A fluid and a structure ready for their first window.
pub(crate) fn coupled(
    case: &Case,
    options: &Options,
    participants: &mut Participants,
) -> Result<Recorded<Coupled>, RunError> {
    let coupling = case.coupling.as_ref().expect("a case of both sides has a coupling");
    let mut taken = |role| participants.take(role).expect("a case of both sides starts both");
    let (fluid, structure) = (taken(Role::Fluid), taken(Role::Structure));
    fit(&structure, &fluid)?;
    let (announce, schedule) = (participants.timing.announce(), schedule(case));
    let mut pair = Pair::initialize(fluid, structure, schedule.time(), coupling.structure_velocity)?;
    pair.announce = announce.clone();
    pair.load_in_window = coupling.load_in_window;
    if case.start(Role::Structure).is_some_and(|start| start != Start::Own) {
        // Of another program's structure the coupler tells what acts on it.
        pair.keep_load();
    }
    if let Some(steady_state) = &coupling.steady_state {
        pair.end_when_steady(steady_state.clone());
    }
    let run = Run { solver: Coupled::new(pair, Scheme::of(coupling)), schedule };
    let iterations = coupling.scheme.is_implicit();
    recorded(run, options, &Wanted { iterations, ..wanted(case, options) }, announce)
}

/// The one side of a case, ready for its first window.
pub(super) fn alone(
    case: &Case,
    options: &Options,
    participants: &mut Participants,
) -> Result<Recorded<Side>, RunError> {
    let role = if case.fluid.is_some() { Role::Fluid } else { Role::Structure };
    let mut side = participants.take(role).expect("a checked case has a fluid or a structure");
    let (points, schedule) = (side.points().unwrap_or(0), schedule(case));
    side.initialize(schedule.time(), points, None)?;
    let announce = participants.timing.announce();
    recorded(Run { solver: side, schedule }, options, &wanted(case, options), announce)
}

fn wanted<'a>(case: &'a Case, options: &Options) -> Wanted<'a> {
    let goes_on = options.from.is_some();
    Wanted { interval: case.general.record_interval, case: Some(case), iterations: false, goes_on }
}

/// The run with its tables, at its start or at the checkpoint that it goes on from.
fn recorded<S: Solver>(
    run: Run<S>,
    options: &Options,
    wanted: &Wanted<'_>,
    announce: Announce,
) -> Result<Recorded<S>, RunError> {
    let mut recorded = Recorded::create(run, &options.out, wanted, announce)?;
    if let Some(from) = &options.from {
        checkpoint::restore(from, &mut recorded)?;
    }
    Ok(recorded)
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
