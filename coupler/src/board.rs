//! What everybody in a run is at, and since when: kept while it goes on, and asked from another thread
//! ([`crate::run`]'s watch) or when a deadline has passed.
//!
//! [`crate::timing`] takes down who was asked for what and who answered; the loop tells of its windows.

use crate::launch;
use crate::phase::Phase;
use crate::status::{Checkpoint, Doing, Iterations, Party, Status, Task};
use interfaces::{ParticipantError, Role, TimeWindow};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Looks that are remembered: rates are those since the oldest.
const LOOKS: usize = 30;
/// Warnings that are remembered: the last ones.
const WARNINGS: usize = 5;

/// What everybody in a run is at. Copies are of the same one.
#[derive(Clone, Default)]
pub struct Board(Arc<Mutex<Known>>);

struct Known {
    about: Status,
    started: Instant,
    phase: (Phase, Instant),
    waits_for: Option<(Role, Instant)>,
    sides: BTreeMap<Role, Side>,
    checkpoint: Option<(Instant, u64, f64)>,
    looks: VecDeque<Look>,
    /// As it stood when a deadline passed for the first time.
    at_deadline: Option<Status>,
}

impl Default for Known {
    fn default() -> Self {
        let now = Instant::now();
        Self {
            about: Status::default(),
            started: now,
            phase: (Phase::Coupling, now),
            waits_for: None,
            sides: BTreeMap::new(),
            checkpoint: None,
            looks: VecDeque::new(),
            at_deadline: None,
        }
    }
}

#[derive(Default)]
struct Side {
    solver: String,
    process: Option<u32>,
    asked: Option<(Task, Instant)>,
    answered: Option<(Task, Instant)>,
    compute_seconds: f64,
}

/// What the system says of a process.
struct Process {
    state: &'static str,
    processor_seconds: f64,
    memory_bytes: u64,
}

impl Process {
    fn look(number: u32) -> Self {
        Self {
            state: launch::state(number).unwrap_or_default(),
            processor_seconds: launch::cpu_seconds(Some(number)),
            memory_bytes: launch::peak_memory_bytes(Some(number)),
        }
    }
}

/// What was seen at a time.
struct Look {
    at: Instant,
    windows: u64,
    time: f64,
    processor_seconds: BTreeMap<Role, f64>,
}

impl Board {
    fn known(&self) -> MutexGuard<'_, Known> {
        // Every change is whole: one who panicked between two left nothing half done.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets what the run is: title, hash, version, end time.
    pub fn about(&self, change: impl FnOnce(&mut Status)) {
        change(&mut self.known().about);
    }

    /// The coupler enters a phase.
    pub fn enter(&self, phase: Phase) {
        self.known().phase = (phase, Instant::now());
    }

    /// The process of a role was started.
    pub fn started(&self, role: Role, process: u32) {
        self.known().sides.entry(role).or_default().process = Some(process);
    }

    /// A participant has said what it is.
    pub fn came(&self, role: Role, solver: &str) {
        let mut known = self.known();
        let side = known.sides.entry(role).or_default();
        solver.clone_into(&mut side.solver);
        side.answered = Some((Task::Come, Instant::now()));
        (side.asked, known.waits_for) = (None, None);
    }

    /// The participant was asked for something, and nobody waits for it yet.
    pub fn asked(&self, role: Role, task: Task) {
        self.known().sides.entry(role).or_default().asked = Some((task, Instant::now()));
    }

    /// The coupler waits for the participant.
    pub fn waits_for(&self, role: Role) {
        self.known().waits_for = Some((role, Instant::now()));
    }

    /// The participant has answered, after so much work (s) where it told. One that failed has not.
    pub fn answered(&self, role: Role, compute_seconds: f64) {
        let mut known = self.known();
        known.waits_for = None;
        let side = known.sides.entry(role).or_default();
        side.compute_seconds += compute_seconds;
        side.answered = side.asked.take().map(|(task, _)| (task, Instant::now())).or(side.answered);
    }

    /// A window was accepted and recorded: simulated time (s) and windows then, how it converged.
    pub fn window(&self, window: &TimeWindow, time: f64, iterations: Option<Iterations>) {
        let about = &mut self.known().about;
        (about.windows, about.simulated_seconds) = (window.index + 1, time);
        about.iterations = iterations;
    }

    /// Something that the user was warned of.
    pub fn warn(&self, what: &str) {
        let warnings = &mut self.known().about.warnings;
        warnings.push(what.to_owned());
        let many = warnings.len().saturating_sub(WARNINGS);
        warnings.drain(..many);
    }

    /// A checkpoint was written.
    pub fn checkpoint(&self, windows: u64, time: f64) {
        self.known().checkpoint = Some((Instant::now(), windows, time));
    }

    /// What the system says of the participants' processes. It is asked without the lock: the coupling goes
    /// on meanwhile.
    fn processes(&self) -> BTreeMap<Role, Process> {
        let of = |(role, side): (&Role, &Side)| Some((*role, side.process?));
        let numbers: Vec<_> = self.known().sides.iter().filter_map(of).collect();
        numbers.into_iter().map(|(role, number)| (role, Process::look(number))).collect()
    }

    /// Looks at the clock and at what the processes have used, for rates.
    pub fn look(&self) {
        let used = self.processes().into_iter().map(|(role, process)| (role, process.processor_seconds));
        let processor_seconds = used.collect();
        let mut known = self.known();
        let look = Look {
            at: Instant::now(),
            windows: known.about.windows,
            time: known.about.simulated_seconds,
            processor_seconds,
        };
        if known.looks.len() == LOOKS {
            known.looks.pop_front();
        }
        known.looks.push_back(look);
    }

    /// A call failed: where its deadline passed, what everybody was at then is kept.
    pub fn failed(&self, error: &ParticipantError) {
        if matches!(error, ParticipantError::TimedOut { .. }) {
            let status = self.status();
            self.known().at_deadline.get_or_insert(status);
        }
    }

    /// Who waited for whom when a deadline passed, or waits now: [`Status::waits`].
    pub fn waits(&self) -> Vec<String> {
        let at_deadline = self.known().at_deadline.clone();
        at_deadline.unwrap_or_else(|| self.status()).waits()
    }

    /// All of it, now.
    pub fn status(&self) -> Status {
        let (processes, memory_bytes) = (self.processes(), launch::peak_memory_bytes(None));
        let known = self.known();
        let now = Instant::now();
        let since = |then: Instant| now.saturating_duration_since(then).as_secs_f64();
        let mut status = Status {
            elapsed_seconds: since(known.started),
            phase: known.phase.0.name().to_owned(),
            phase_seconds: since(known.phase.1),
            waits_for: known.waits_for.map(|(role, _)| role),
            waits_seconds: known.waits_for.map(|(_, at)| since(at)),
            memory_bytes,
            checkpoint: known.checkpoint.map(|(at, windows, simulated_seconds)| Checkpoint {
                windows,
                simulated_seconds,
                seconds_ago: since(at),
            }),
            ..known.about.clone()
        };
        let party = |(role, side): (&Role, &Side)| known.party(*role, side, processes.get(role), now);
        status.participants = known.sides.iter().map(party).collect();
        if let Some(first) = known.looks.front() {
            let (passed, windows) = (since(first.at), status.windows.saturating_sub(first.windows));
            let simulated = status.simulated_seconds - first.time;
            if passed > 0.0 && windows > 0 {
                status.windows_per_second = Some(windows as f64 / passed);
                let left = status.end_time - status.simulated_seconds;
                status.remaining_seconds = (simulated > 0.0).then(|| left * passed / simulated);
            }
        }
        status
    }
}

impl Known {
    fn party(&self, role: Role, side: &Side, process: Option<&Process>, now: Instant) -> Party {
        let since = |then: Instant| now.saturating_duration_since(then).as_secs_f64();
        let doing = |(task, at): (Task, Instant)| Doing { task, seconds_ago: since(at) };
        // What it used while it was at this, as far as it was looked at; else in all the time that is known.
        let begun = side.asked.map_or(now.checked_sub(Duration::from_secs(3600)), |(_, at)| Some(at));
        let mut looks = self.looks.iter().filter(|look| begun.is_none_or(|begun| look.at >= begun));
        let first = looks.find_map(|look| Some((look.at, *look.processor_seconds.get(&role)?)));
        let used = process
            .zip(first)
            .map(|(process, (at, before))| (since(at), (process.processor_seconds - before).max(0.0)));
        Party {
            role,
            solver: side.solver.clone(),
            process: side.process,
            state: process.map_or_else(String::new, |process| process.state.to_owned()),
            asked: side.asked.map(doing),
            answered: side.answered.map(doing),
            compute_seconds: side.compute_seconds,
            processor_seconds: used.map(|(_, seconds)| seconds),
            looked_at_seconds: used.map(|(passed, _)| passed),
            memory_bytes: process.map_or(0, |process| process.memory_bytes),
        }
    }
}
