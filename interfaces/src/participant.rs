//! The participant contract.
//!
//! Order of calls (the table in [`crate::lifecycle`] is the law):
//!
//! ```text
//! describe → initialize (→ restore) → { start → finish (again: start → finish) … → accept } … → terminate
//! ```
//!
//! - `start` and `finish` are apart so that participants can work at the same time without threads in the
//!   coupler.
//! - Every `start` solves its window **from the last accepted state**: solving again needs no roll-back
//!   ritual, and gives the same result to the bit for the same input.
//! - Between windows a participant can be saved, and goes to a saved state as if it had just accepted it.
//! - Time is the coupler's: a participant takes it from the window.
//! - A participant whose call failed is broken for good; all it can do is `terminate`.

use crate::{Direction, FieldError, Fields, IllegalCall, Port, TimeWindow};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fmt;
use thiserror::Error;
use words::text::{EXPLANATION, NAME, is_name, tame};

/// The side of the coupling a participant stands on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Takes motion, gives loads.
    Fluid,
    /// Takes loads, gives motion.
    Structure,
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Fluid => "fluid",
            Self::Structure => "structure",
        })
    }
}

/// A number that a participant reports after every solution of a window, for the records.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Scalar {
    /// Name in full words, as it heads its column: `kinetic_energy`, or `<probe>.<component>` for a probe.
    pub name: String,
    /// SI unit, `1` for counts and ratios.
    pub unit: String,
    /// Where it is recorded.
    pub kind: ScalarKind,
    /// What it is, in words; empty where its name says all.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub meaning: String,
}

impl Scalar {
    /// A scalar whose name says all.
    pub fn new(name: impl Into<String>, unit: &str, kind: ScalarKind) -> Self {
        Self { name: name.into(), unit: unit.to_owned(), kind, meaning: String::new() }
    }

    /// The same, with what it is in words.
    #[must_use]
    pub fn meaning(self, meaning: impl Into<String>) -> Self {
        Self { meaning: meaning.into(), ..self }
    }
}

/// Name of a scalar by which a participant asks for the end of the run: it ends, in order, with the first
/// accepted window of which this is not zero.
pub const END_REQUESTED: &str = "end_requested";

/// Where a scalar is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ScalarKind {
    /// In `windows.csv`, its column headed `<role>.<name>`.
    Balance,
    /// In `probes.csv`, its column headed `<name>`.
    Probe,
}

/// What a participant is and exchanges. It does not change over a life.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// Which side it is.
    pub role: Role,
    /// What solves it, for messages and records: `meniscus fluid (ISPH)`.
    pub solver: String,
    /// Space dimension, 2 or 3.
    pub dimension: usize,
    /// What it takes and gives.
    pub ports: Vec<Port>,
    /// What it reports.
    pub scalars: Vec<Scalar>,
    /// Whether it can be saved, and go to a saved state. Of a run with one who cannot there are no
    /// checkpoints.
    #[serde(default)]
    pub saves: bool,
    /// What looks odd to it and may be meant, one line each, for the summary.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}

impl Description {
    /// Zeroed fields of one direction; `points` stands in where a port names no number of its own.
    pub fn fields(&self, direction: Direction, points: usize) -> Fields {
        Fields::new(&self.ports, direction, points)
    }

    /// What no participant may claim, whoever made it: nothing of it is then used, and nothing of that size
    /// is allocated. One line each.
    pub fn mistakes(&self) -> Vec<String> {
        let mut mistakes = Vec::new();
        let (ports, scalars) = (self.ports.len(), self.scalars.len());
        if ports > MOST_PORTS || scalars > MOST_SCALARS {
            return vec![format!(
                "description: {ports} ports and {scalars} scalars, and {MOST_PORTS} and {MOST_SCALARS} are taken at most"
            )];
        }
        let words = [("solver", self.solver.as_str())].into_iter();
        let words = words.chain(self.ports.iter().map(|port| ("name of a port", port.name.as_str())));
        let words = words.chain(self.scalars.iter().map(|scalar| ("name of a scalar", scalar.name.as_str())));
        for (what, text) in words.chain(self.scalars.iter().map(|scalar| ("unit", scalar.unit.as_str()))) {
            if !is_name(text) {
                let text = tame(text, 60);
                mistakes.push(format!("{what}: `{text}` is none: 1 to {NAME} characters on one line"));
            }
        }
        if self.notes.len() > MOST_PORTS || self.notes.iter().any(|note| note.chars().count() > EXPLANATION) {
            mistakes.push(format!("notes: {MOST_PORTS} of {EXPLANATION} characters are taken at most"));
        }
        if let Some(scalar) = self.scalars.iter().find(|scalar| scalar.meaning.chars().count() > EXPLANATION)
        {
            mistakes.push(format!("scalar `{}`: its meaning has over {EXPLANATION} characters", scalar.name));
        }
        let mut names = BTreeSet::new();
        for port in &self.ports {
            if !names.insert((port.direction == Direction::In, &port.name)) {
                mistakes.push(format!("port `{}`: two have this name in one direction", port.name));
            }
            let values = port.points.unwrap_or(0).checked_mul(port.components);
            if !(1..=MOST_COMPONENTS).contains(&port.components) || values.is_none_or(|n| n > MOST_VALUES) {
                mistakes.push(format!(
                    "port `{}`: {} points of {} components, and {MOST_VALUES} values, {MOST_COMPONENTS} a point, are taken at most",
                    port.name,
                    port.points.unwrap_or(0),
                    port.components
                ));
            }
        }
        let mut names = BTreeSet::new();
        for scalar in self.scalars.iter().filter(|s| !names.insert((s.kind == ScalarKind::Probe, &s.name))) {
            mistakes.push(format!("scalar `{}`: two have this name", scalar.name));
        }
        mistakes
    }
}

/// Ports of a participant at most.
const MOST_PORTS: usize = 64;
/// Scalars of a participant at most.
const MOST_SCALARS: usize = 4096;
/// Doubles a point at most.
const MOST_COMPONENTS: usize = 64;
/// Doubles of a field at most (64 MB): some millions of interface points.
pub const MOST_VALUES: usize = 1 << 23;

/// What a participant says that was initialised or went to a saved state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Readiness {
    /// Largest next window it can solve (s); infinite where it does not mind.
    pub window_limit: f64,
    /// Its scalars then.
    pub scalars: Vec<f64>,
}

/// What a participant says of a window it solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WindowReport {
    /// Sub-steps taken.
    pub sub_steps: u32,
    /// Largest next window it can solve (s); infinite where it does not mind.
    pub window_limit: f64,
    /// Wall time of its own work on this solution (s).
    pub compute_seconds: f64,
    /// Its scalars at the window's end.
    pub scalars: Vec<f64>,
}

/// What a call on a participant gives.
pub type Result<T, E = ParticipantError> = std::result::Result<T, E>;

/// The contract. Errors leave the participant broken (see [`crate::lifecycle`]).
pub trait Participant {
    /// What it is and exchanges.
    fn describe(&self) -> &Description;

    /// Takes the constant fields and the initial values of the others at time `start` (s), and gives its own.
    /// A structure is initialised first, with zero loads; the fluid then takes the structure's constants and
    /// initial motion.
    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness>;

    /// Whether it refuses values that are not finite itself, in the fields it takes by `start`, which then
    /// leave it as it was, and in those it gives by `finish`. Whoever copies the fields anyway checks them at
    /// no cost on the way, and [`crate::Guarded`] does not go over them again.
    fn refuses_not_finite(&self) -> bool {
        false
    }

    /// Begins to solve the window from the last accepted state. Does not wait for the solution where another
    /// process solves.
    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()>;

    /// Waits for the solution begun by `start`: the fields that are exchanged every window, whole, whatever
    /// stood there, and a report. Constant fields are left as they are.
    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport>;

    /// The last solution is final. With a number, the participant writes its snapshot of that number.
    fn accept(&mut self, snapshot: Option<u64>) -> Result<()>;

    /// The accepted state, whole, for a restart with the same case. Legal between windows: after
    /// `initialize`, `accept` or `restore`.
    fn save(&mut self) -> Result<Vec<u8>>;

    /// Goes back, or on, to a state that a participant of the same case saved: this one, or another that has
    /// ended since. Legal once initialised, unless a window is open between `start` and `finish`: in a fresh
    /// participant right after `initialize`, later between windows, or over a solution that was not accepted,
    /// which is forgotten.
    ///
    /// Gives what it gave when that state was accepted: the fields that are exchanged every window, whole,
    /// limit and scalars, to the bit. Constant fields are left as `initialize` gave them. The next window is
    /// the one that followed the state, and is solved as it was then, to the bit.
    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness>;

    /// Ends in order: outputs are whole, resources are given back.
    fn terminate(&mut self) -> Result<()>;
}

impl<P: Participant + ?Sized> Participant for Box<P> {
    fn describe(&self) -> &Description {
        (**self).describe()
    }
    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        (**self).initialize(start, inputs, outputs)
    }
    fn refuses_not_finite(&self) -> bool {
        (**self).refuses_not_finite()
    }
    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        (**self).start(window, inputs)
    }
    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        (**self).finish(outputs)
    }
    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        (**self).accept(snapshot)
    }
    fn save(&mut self) -> Result<Vec<u8>> {
        (**self).save()
    }
    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        (**self).restore(state, outputs)
    }
    fn terminate(&mut self) -> Result<()> {
        (**self).terminate()
    }
}

/// Why a call on a participant failed. Every variant says what its message needs; the coupler adds role,
/// window and time.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ParticipantError {
    /// A call out of order.
    #[error(transparent)]
    IllegalCall(#[from] IllegalCall),
    /// A window that is not the next one.
    #[error("window {window} cannot be started: {what}")]
    WrongWindow {
        /// The window's number.
        window: u64,
        /// What is wrong with it.
        what: String,
    },
    /// A field that must not cross.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The solver gave up; its own words.
    #[error("{0}")]
    Failed(String),
    /// Both sides' descriptions do not fit; one line each.
    #[error("the handshake found {} mismatch(es):\n  {}", .0.len(), .0.join("\n  "))]
    Mismatch(Vec<String>),
    /// The process is gone.
    #[error("its process died {during}")]
    Died {
        /// What it was asked for: `while solving window 17, iteration 0`.
        during: String,
    },
    /// No answer by the deadline.
    #[error("it gave no answer within its deadline of {seconds} s {during}")]
    TimedOut {
        /// What it was asked for.
        during: String,
        /// The deadline.
        seconds: f64,
    },
    /// A message that the protocol does not allow here.
    #[error("it broke the protocol {during}: {what}")]
    Protocol {
        /// What it was asked for.
        during: String,
        /// What came.
        what: String,
    },
    /// Shared memory failed.
    #[error("shared memory failed {during}: {what}")]
    Transport {
        /// What was tried.
        during: String,
        /// What the transport said.
        what: String,
    },
    /// The run was told to stop.
    #[error("the run was interrupted {during}")]
    Interrupted {
        /// What was waited for.
        during: String,
    },
}

impl ParticipantError {
    /// A solver's failure in its own words.
    pub fn failed(what: impl Into<String>) -> Self {
        Self::Failed(what.into())
    }
}
