//! Which call is legal when: one table, used by every client, server and stand-in.

use std::fmt;
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
    /// [`crate::Participant::initialize`]
    Initialize,
    /// [`crate::Participant::start`]
    Start,
    /// [`crate::Participant::finish`]
    Finish,
    /// [`crate::Participant::accept`]
    Accept,
    /// [`crate::Participant::save`]
    Save,
    /// [`crate::Participant::restore`]
    Restore,
    /// [`crate::Participant::terminate`]
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
