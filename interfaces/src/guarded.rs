//! Participants behind the table of legal calls.

use crate::lifecycle::{Call, IllegalCall, LEGAL, State};
use crate::{
    Description, Fields, Participant, ParticipantError, Readiness, Result, TimeWindow, WindowReport,
};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use words::bytes::{self, Reader, Writer};

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
    pub fn check_window(&self, window: &TimeWindow) -> Result<()> {
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
        if window.start + window.size == window.start {
            return wrong(format!("{} s are too short to change the time, {} s", window.size, window.start));
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

/// First bytes of a saved state; the last is the version of its layout.
const MAGIC: &[u8; 8] = b"mnscgrd1";

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

    fn made<T>(&mut self, call: Call, window: Option<&TimeWindow>, result: Result<T>) -> Result<T> {
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

    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        self.life.check(Call::Initialize)?;
        inputs.check_finite()?;
        let result = caught(|| self.inner.initialize(start, inputs, outputs));
        let result = result.and_then(|ready| Ok(outputs.check_finite().map(|()| ready)?));
        self.made(Call::Initialize, None, result)
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
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

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
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

    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        self.life.check(Call::Accept)?;
        let result = caught(|| self.inner.accept(snapshot));
        self.made(Call::Accept, None, result)
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        self.life.check(Call::Save)?;
        let result = caught(|| self.inner.save());
        let own = self.made(Call::Save, None, result)?;
        let mut state = Writer::new(MAGIC);
        state.u64(self.life.accepted());
        state.bytes(&own);
        Ok(state.finish())
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        self.life.check(Call::Restore)?;
        let result = read(state).and_then(|(accepted, own)| {
            let ready = caught(|| self.inner.restore(own, outputs))?;
            outputs.check_finite()?;
            Ok((accepted, ready))
        });
        match &result {
            Ok((accepted, _)) => self.life.restored(*accepted),
            Err(_) => self.life.failed(),
        }
        result.map(|(_, ready)| ready)
    }

    fn terminate(&mut self) -> Result<()> {
        self.life.check(Call::Terminate)?;
        let result = caught(|| self.inner.terminate());
        self.made(Call::Terminate, None, result)
    }
}

/// Windows accepted, and the participant's own state.
fn read(state: &[u8]) -> Result<(u64, &[u8])> {
    let read = || {
        let mut state = Reader::new("participant's state", MAGIC, state)?;
        let parts = (state.u64("accepted windows")?, state.bytes("own state")?);
        state.finish().map(|()| parts)
    };
    read().map_err(|error: bytes::Error| ParticipantError::failed(error.to_string()))
}

/// Makes a panic of the participant an error with its text.
pub fn caught<T>(call: impl FnOnce() -> Result<T>) -> Result<T> {
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
