//! Which call is legal when: one table, used by every client, server and stand-in.

use crate::{Description, Fields, Participant, ParticipantError, Readiness, TimeWindow, WindowReport};
use std::any::Any;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use thiserror::Error;

/// Where a participant is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// It can be described, and no more.
    Created,
    /// Its last window is accepted (or none was yet): it can start one.
    Ready,
    /// A window was started and not finished.
    Solving,
    /// A window was solved: it can be accepted, or started again from the accepted state.
    Solved,
    /// Ended in order.
    Terminated,
    /// A call failed: all it can do is terminate.
    Broken,
}

/// The calls of a participant that change its state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// [`Participant::initialize`]
    Initialize,
    /// [`Participant::start`]
    Start,
    /// [`Participant::finish`]
    Finish,
    /// [`Participant::accept`]
    Accept,
    /// [`Participant::save`]
    Save,
    /// [`Participant::restore`]
    Restore,
    /// [`Participant::terminate`]
    Terminate,
}

/// The table: a call, the states in which it is legal, the state it leads to, and what should have come
/// first.
pub const LEGAL: &[(Call, &[State], State, &str)] = &[
    (Call::Initialize, &[State::Created], State::Ready, "a participant is initialised once"),
    (
        Call::Start,
        &[State::Ready, State::Solved],
        State::Solving,
        "call `initialize` first, and `finish` an open window",
    ),
    (Call::Finish, &[State::Solving], State::Solved, "call `start` first"),
    (Call::Accept, &[State::Solved], State::Ready, "call `start` and `finish` first"),
    (Call::Save, &[State::Ready], State::Ready, "`accept` the window first"),
    (
        Call::Restore,
        &[State::Ready, State::Solved],
        State::Ready,
        "call `initialize` first, and `finish` an open window",
    ),
    (
        Call::Terminate,
        &[State::Created, State::Ready, State::Solving, State::Solved, State::Broken],
        State::Terminated,
        "a participant is terminated once",
    ),
];

/// A call out of order.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{call}` is not legal when the participant is {state}: {remedy}")]
pub struct IllegalCall {
    /// The call.
    pub call: Call,
    /// The state it found.
    pub state: State,
    /// What should have come first.
    pub remedy: &'static str,
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Created => "created",
            Self::Ready => "ready",
            Self::Solving => "solving",
            Self::Solved => "solved",
            Self::Terminated => "terminated",
            Self::Broken => "broken",
        })
    }
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Initialize => "initialize",
            Self::Start => "start",
            Self::Finish => "finish",
            Self::Accept => "accept",
            Self::Save => "save",
            Self::Restore => "restore",
            Self::Terminate => "terminate",
        })
    }
}

/// The state of one participant, moved by the table alone.
#[derive(Clone, Debug)]
pub struct Lifecycle {
    state: State,
    accepted: u64,
    iteration: Option<u32>,
}

impl Default for Lifecycle {
    fn default() -> Self {
        Self { state: State::Created, accepted: 0, iteration: None }
    }
}

impl Lifecycle {
    /// Where the participant is.
    pub fn state(&self) -> State {
        self.state
    }

    /// Windows accepted so far: the number of the next window.
    pub fn accepted(&self) -> u64 {
        self.accepted
    }

    /// Whether the call is legal now; changes nothing.
    pub fn check(&self, call: Call) -> Result<State, IllegalCall> {
        let (_, from, to, remedy) =
            LEGAL.iter().find(|row| row.0 == call).expect("the table has a row for every call");
        if from.contains(&self.state) {
            Ok(*to)
        } else {
            Err(IllegalCall { call, state: self.state, remedy })
        }
    }

    /// Whether this window may be started now: the call is legal, the number is the next one, the iteration
    /// newer than the last, the size positive.
    pub fn check_window(&self, window: &TimeWindow) -> Result<(), ParticipantError> {
        self.check(Call::Start)?;
        let wrong = |what: String| Err(ParticipantError::WrongWindow { window: window.index, what });
        if window.index != self.accepted {
            return wrong(format!("window {} comes next", self.accepted));
        }
        if self.iteration.is_some_and(|last| window.iteration <= last) {
            return wrong(format!("iteration {} was solved already", window.iteration));
        }
        if !(window.size > 0.0 && window.size.is_finite() && window.start.is_finite()) {
            return wrong(format!("it starts at {} s and lasts {} s", window.start, window.size));
        }
        Ok(())
    }

    /// Records that the call succeeded (`window` for a start, else nothing).
    pub fn done(&mut self, call: Call, window: Option<&TimeWindow>) {
        self.state = self.check(call).expect("a call is checked before it is made");
        match call {
            Call::Start => self.iteration = window.map(|w| w.iteration),
            Call::Accept => (self.accepted, self.iteration) = (self.accepted + 1, None),
            _ => {}
        }
    }

    /// Records the window count of a restored state.
    pub fn restored(&mut self, accepted: u64) {
        self.done(Call::Restore, None);
        (self.accepted, self.iteration) = (accepted, None);
    }

    /// Records that a call failed.
    pub fn failed(&mut self) {
        self.state = State::Broken;
    }
}

/// A participant behind the table: calls out of order, wrong windows and fields that are not finite are
/// refused before they reach it, and what it gives is checked before it is passed on. Illegal calls leave it
/// as it was; failed calls, panics among them, break it for good.
pub struct Guarded<P> {
    inner: P,
    life: Lifecycle,
}

impl<P: Participant> Guarded<P> {
    /// Guards a participant that was not initialised yet.
    pub fn new(inner: P) -> Self {
        Self { inner, life: Lifecycle::default() }
    }

    /// Where the participant is.
    pub fn state(&self) -> State {
        self.life.state()
    }

    fn made<T>(
        &mut self,
        call: Call,
        window: Option<&TimeWindow>,
        result: Result<T, ParticipantError>,
    ) -> Result<T, ParticipantError> {
        match &result {
            Ok(_) => self.life.done(call, window),
            Err(_) => self.life.failed(),
        }
        result
    }
}

impl<P: Participant> Participant for Guarded<P> {
    fn describe(&self) -> &Description {
        self.inner.describe()
    }

    fn initialize(
        &mut self,
        start: f64,
        inputs: &Fields,
        outputs: &mut Fields,
    ) -> Result<Readiness, ParticipantError> {
        self.life.check(Call::Initialize)?;
        inputs.check_finite()?;
        let result = caught(|| self.inner.initialize(start, inputs, outputs));
        let result = result.and_then(|ready| Ok(outputs.check_finite().map(|()| ready)?));
        self.made(Call::Initialize, None, result)
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<(), ParticipantError> {
        self.life.check_window(window)?;
        let refuses = self.inner.refuses_not_finite();
        if !refuses {
            inputs.check_finite()?;
        }
        let result = caught(|| self.inner.start(window, inputs));
        if refuses && matches!(result, Err(ParticipantError::Field(_))) {
            return result;
        }
        self.made(Call::Start, Some(window), result)
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport, ParticipantError> {
        self.life.check(Call::Finish)?;
        let result = caught(|| self.inner.finish(outputs));
        let result = match result {
            Ok(report) if !self.inner.refuses_not_finite() => {
                outputs.check_finite().map(|()| report).map_err(ParticipantError::from)
            }
            result => result,
        };
        self.made(Call::Finish, None, result)
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<(), ParticipantError> {
        self.life.check(Call::Accept)?;
        let result = caught(|| self.inner.accept(snapshot));
        self.made(Call::Accept, None, result)
    }

    fn save(&mut self) -> Result<Vec<u8>, ParticipantError> {
        self.life.check(Call::Save)?;
        let mut bytes = self.life.accepted().to_le_bytes().to_vec();
        let result = caught(|| self.inner.save());
        bytes.extend(self.made(Call::Save, None, result)?);
        Ok(bytes)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), ParticipantError> {
        self.life.check(Call::Restore)?;
        let (count, rest) = state
            .split_at_checked(8)
            .ok_or_else(|| ParticipantError::failed("a saved state has at least 8 bytes"))?;
        let accepted = u64::from_le_bytes(count.try_into().expect("eight bytes were split off"));
        let result = caught(|| self.inner.restore(rest));
        match &result {
            Ok(()) => self.life.restored(accepted),
            Err(_) => self.life.failed(),
        }
        result
    }

    fn terminate(&mut self) -> Result<(), ParticipantError> {
        self.life.check(Call::Terminate)?;
        let result = caught(|| self.inner.terminate());
        self.made(Call::Terminate, None, result)
    }
}

/// Makes a panic of the participant an error with its text.
pub(crate) fn caught<T>(call: impl FnOnce() -> Result<T, ParticipantError>) -> Result<T, ParticipantError> {
    catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|panic| Err(ParticipantError::Failed(told(&*panic))))
}

fn told(panic: &(dyn Any + Send)) -> String {
    let text =
        panic.downcast_ref::<&str>().copied().or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    format!("it panicked: {}", text.unwrap_or("no text was given"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SubSteps;

    #[test]
    fn every_call_has_one_row() {
        for call in [
            Call::Initialize,
            Call::Start,
            Call::Finish,
            Call::Accept,
            Call::Save,
            Call::Restore,
            Call::Terminate,
        ] {
            assert_eq!(LEGAL.iter().filter(|row| row.0 == call).count(), 1, "{call}");
        }
    }

    #[test]
    fn windows_are_counted_and_iterations_grow() {
        let mut life = Lifecycle::default();
        let window = |index, iteration| TimeWindow {
            index,
            iteration,
            start: 0.0,
            size: 0.1,
            sub_steps: SubSteps::Stable,
        };
        assert!(life.check_window(&window(0, 0)).is_err());
        life.done(Call::Initialize, None);
        assert!(life.check_window(&window(1, 0)).unwrap_err().to_string().contains("window 0 comes next"));
        life.done(Call::Start, Some(&window(0, 0)));
        assert!(
            life.check(Call::Accept).unwrap_err().to_string().contains("call `start` and `finish` first")
        );
        life.done(Call::Finish, None);
        assert!(life.check_window(&window(0, 0)).is_err());
        assert!(life.check_window(&window(0, 1)).is_ok());
        life.done(Call::Accept, None);
        assert!(life.check_window(&window(0, 1)).is_err());
        assert!(life.check_window(&window(1, 0)).is_ok());
        assert!(life.check_window(&TimeWindow { size: f64::NAN, ..window(1, 0) }).is_err());
    }
}
