//! Who computed, waited, mapped and sent, when: summed for the summary, and written as a trace where one is
//! asked for.
//!
//! A [`Timing`] has the clock. The coupling loop announces its phases to it ([`Timing::announce`]); a
//! participant behind [`Timed`] has its calls taken down, and what it reports of its own work is put where it
//! can only have been: from the moment it was handed the window on.

use crate::board::Board;
use crate::phase::{Announce, Phase};
use crate::status::Task;
use crate::trace::{Trace, Track};
use interfaces::{Description, Fields, Participant, Readiness, Result, Role, TimeWindow, WindowReport};
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

/// The clock of a run, shared by all that is timed.
#[derive(Clone)]
pub struct Timing(Rc<RefCell<Sums>>, Board);

struct Sums {
    started: Instant,
    phase: Phase,
    since: f64,
    seconds: [f64; Phase::ALL.len()],
    trace: Option<Trace>,
}

impl Timing {
    /// From now on; a trace is written where there is one.
    pub fn new(trace: Option<Trace>) -> Self {
        let sums = Sums {
            started: Instant::now(),
            phase: Phase::Coupling,
            since: 0.0,
            seconds: [0.0; Phase::ALL.len()],
            trace,
        };
        Self(Rc::new(RefCell::new(sums)), Board::default())
    }

    /// What everybody is at.
    pub fn board(&self) -> &Board {
        &self.1
    }

    /// What the coupling loop announces its phases to.
    pub fn announce(&self) -> Announce {
        let timing = self.clone();
        Announce::to(move |phase| {
            timing.1.enter(phase);
            timing.0.borrow_mut().enter(phase)
        })
    }

    /// Times the calls of a participant.
    pub fn timed<P: Participant>(&self, participant: P) -> Timed<P> {
        let role = participant.describe().role;
        Timed { inner: participant, timing: self.clone(), announce: self.announce(), role, begun: None }
    }

    /// Time of the coupler in each phase so far (s), in the order of [`Phase::ALL`].
    pub fn seconds(&self) -> Vec<(Phase, f64)> {
        let mut sums = self.0.borrow_mut();
        let phase = sums.phase;
        sums.enter(phase);
        Phase::ALL.into_iter().map(|phase| (phase, sums.seconds[phase as usize])).collect()
    }

    /// Writes the trace out as far as it has come; ends it where there will be no more.
    ///
    /// # Errors
    /// What kept it from being written at any time.
    pub fn end(&self) -> output::Result<()> {
        match &mut self.0.borrow_mut().trace {
            Some(trace) => trace.end(),
            None => Ok(()),
        }
    }

    fn now(&self) -> f64 {
        self.0.borrow().now()
    }
}

impl Sums {
    /// Seconds since the start.
    fn now(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    fn enter(&mut self, phase: Phase) -> Phase {
        let now = self.now();
        let ended = std::mem::replace(&mut self.phase, phase);
        self.seconds[ended as usize] += now - self.since;
        if let (Some(trace), false) = (&mut self.trace, ended == Phase::Coupling) {
            trace.span(Track::Coupler, ended.name(), self.since, now);
        }
        self.since = now;
        ended
    }
}

/// A participant whose calls are timed.
pub struct Timed<P> {
    inner: P,
    timing: Timing,
    announce: Announce,
    role: Role,
    /// The window that was started, when the call began and when it came back (s).
    begun: Option<(TimeWindow, f64, f64)>,
}

impl<P: Participant> Timed<P> {
    /// A call that waits for its answer.
    fn waiting<T>(&mut self, task: Task, call: impl FnOnce(&mut P) -> Result<T>) -> Result<T> {
        let Self { inner, announce, timing, role, .. } = self;
        timing.board().asked(*role, task);
        timing.board().waits_for(*role);
        let answer = announce.during(Phase::Waiting, || call(inner));
        let answer = answer.inspect_err(|error| timing.board().failed(error))?;
        timing.board().answered(*role, 0.0);
        Ok(answer)
    }

    /// The work on a window: a participant in this process did it within `start`, any other from then on.
    fn computed(&self, report: &WindowReport) {
        let Some((window, called, returned)) = self.begun else { return };
        let seconds = report.compute_seconds;
        let mut sums = self.timing.0.borrow_mut();
        if let Some(trace) = &mut sums.trace {
            let from = if seconds > returned - called { returned } else { called };
            let name = format!("window {} iteration {}", window.index, window.iteration);
            trace.span(Track::of(self.role), &name, from, from + seconds);
        }
    }
}

impl<P: Participant> Participant for Timed<P> {
    fn describe(&self) -> &Description {
        self.inner.describe()
    }

    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        self.waiting(Task::Initialize, |inner| inner.initialize(start, inputs, outputs))
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        let called = self.timing.now();
        let (index, iteration) = (window.index, window.iteration);
        let task = Task::Solve { window: index, iteration, start: window.start };
        self.timing.board().asked(self.role, task);
        let Self { inner, announce, .. } = self;
        let started = announce.during(Phase::Sending, || inner.start(window, inputs));
        started.inspect_err(|error| self.timing.board().failed(error))?;
        self.begun = Some((*window, called, self.timing.now()));
        Ok(())
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        self.timing.board().waits_for(self.role);
        let Self { inner, announce, .. } = self;
        let report = announce.during(Phase::Waiting, || inner.finish(outputs));
        let report = report.inspect_err(|error| self.timing.board().failed(error))?;
        self.timing.board().answered(self.role, report.compute_seconds);
        self.computed(&report);
        Ok(report)
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        let window = self.begun.map_or(0, |(window, ..)| window.index);
        self.timing.board().asked(self.role, Task::Accept { window });
        let Self { inner, announce, .. } = self;
        let accepted = announce.during(Phase::Sending, || inner.accept(snapshot));
        accepted.inspect_err(|error| self.timing.board().failed(error))?;
        self.timing.board().answered(self.role, 0.0);
        Ok(())
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        self.waiting(Task::Save, Participant::save)
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        self.waiting(Task::Restore, |inner| inner.restore(state, outputs))
    }

    fn terminate(&mut self) -> Result<()> {
        self.waiting(Task::Terminate, Participant::terminate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_goes_to_the_phase_in_which_it_passed() {
        let timing = Timing::new(None);
        timing.announce().during(Phase::Records, || std::thread::sleep(std::time::Duration::from_millis(20)));
        for (phase, seconds) in timing.seconds() {
            // A sleep is never shorter than asked for; all the rest is some microseconds, or what the machine
            // took.
            assert!(phase != Phase::Records || seconds >= 0.02, "{phase:?} {seconds}");
            assert!(seconds >= 0.0);
        }
    }
}
