//! Coupling schemes, one file each, and a participant without a partner.

pub mod alone;
pub mod extrapolation;
pub mod implicit;
pub mod pair;
pub mod parallel_explicit;
pub mod serial_explicit;

pub use pair::Pair;

use crate::condition46::{Condition46, Resultant};
use crate::schedule::Schedule;
use crate::side::SideError;
use implicit::Implicit;
use interfaces::TimeWindow;
use interfaces::case::coupling::{Coupling, CouplingScheme};
use parallel_explicit::ParallelExplicit;
use serial_explicit::SerialExplicit;
use thiserror::Error;

/// The scheme that a case chose.
pub enum Scheme {
    /// One after the other, once.
    SerialExplicit(SerialExplicit),
    /// At once, once.
    ParallelExplicit(ParallelExplicit),
    /// Either way, until the window converges.
    Implicit(Box<Implicit>),
}

impl Scheme {
    /// As the case has it.
    pub fn of(coupling: &Coupling) -> Self {
        let (relaxation, enforce) = (coupling.relaxation, coupling.enforce_condition_46);
        let implicit = |parallel| Self::Implicit(Box::new(Implicit::of(coupling, parallel)));
        match coupling.scheme {
            CouplingScheme::SerialExplicit => {
                let predict = coupling.prediction.unwrap_or(true);
                Self::SerialExplicit(SerialExplicit { relaxation, enforce, predict })
            }
            CouplingScheme::ParallelExplicit => {
                Self::ParallelExplicit(ParallelExplicit { relaxation, enforce })
            }
            CouplingScheme::SerialImplicit => implicit(false),
            CouplingScheme::ParallelImplicit => implicit(true),
        }
    }

    /// Runs the pair over the schedule. `record` hears of every accepted window.
    pub fn run(
        &mut self,
        pair: &mut Pair,
        schedule: &mut Schedule,
        record: impl FnMut(&Accepted, &Pair) -> Result<Onward, SchemeError>,
    ) -> Result<(), SchemeError> {
        match self {
            Self::SerialExplicit(scheme) => scheme.run(pair, schedule, record),
            Self::ParallelExplicit(scheme) => scheme.run(pair, schedule, record),
            Self::Implicit(scheme) => scheme.run(pair, schedule, record),
        }
    }
}

/// Whether to go on after a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Onward {
    /// On to the next window.
    Continue,
    /// The run was told to stop: end in order.
    Stop,
}

/// What a scheme tells of an accepted window.
#[derive(Clone, Copy, Debug)]
pub struct Accepted {
    /// The window, its iteration the last one solved.
    pub window: TimeWindow,
    /// Time at its end (s), as the schedule keeps it.
    pub time: f64,
    /// Number of the output due at its end, if one is.
    pub output: Option<u64>,
    /// Condition (46) of the window; nothing without a partner.
    pub condition46: Option<Condition46>,
    /// Resultant of the load under which the structure was solved, relaxation included; nothing without a
    /// partner.
    pub applied: Option<Resultant>,
}

impl Accepted {
    /// A window of which nothing is known but the time at its end (s) and the output due there.
    pub fn alone(window: TimeWindow, time: f64, output: Option<u64>) -> Self {
        Self { window, time, output, condition46: None, applied: None }
    }

    /// The same, with what condition (46) found and the resultant of the load under which the structure was
    /// solved.
    fn with(self, condition46: Condition46, applied: Resultant) -> Self {
        Self { condition46: Some(condition46), applied: Some(applied), ..self }
    }
}

/// Why a scheme ended before its end time.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SchemeError {
    /// A participant failed.
    #[error(transparent)]
    Side(#[from] SideError),
    /// The records could not be written.
    #[error("failed to record window {window}: {what}")]
    Record {
        /// The window.
        window: u64,
        /// What failed.
        what: String,
    },
    /// The iterations of a window did not converge, and the case says to stop then.
    #[error(
        "window {window} from t = {time} s, {size} s long, did not converge in {iterations} iterations: the residual is {relative:.1e} of the \
         values; raise coupling.convergence.max_iterations, loosen coupling.convergence.relative, or choose another coupling.acceleration.method"
    )]
    NotConverged {
        /// The window.
        window: u64,
        /// Its start (s).
        time: f64,
        /// Its size (s).
        size: f64,
        /// Iterations at that size.
        iterations: u32,
        /// The largest residual of a quantity over its values.
        relative: f64,
    },
    /// The two sides do not fit together.
    #[error("fluid and structure do not fit together:\n  {}", .0.join("\n  "))]
    Mismatch(Vec<String>),
}
