//! The loop over windows, and a run as a value.

use super::{Accepted, Onward, SchemeError};
use crate::convergence::Residual;
use crate::schedule::Schedule;
use crate::side::Side;
use interfaces::TimeWindow;
use words::bytes::{Reader, Writer};

/// What solves windows: a pair under its scheme, or one side alone.
pub trait Solver {
    /// The largest next window (s).
    fn window_limit(&self) -> f64;

    /// Solves the window, accepts it and moves the schedule on, which ends there where a participant asks for
    /// it or the state is steady.
    fn solve(&mut self, window: TimeWindow, schedule: &mut Schedule) -> Result<Accepted, SchemeError>;

    /// Why the last window ended the run, if it did.
    fn ending(&self) -> Option<String>;

    /// What each iteration of the last window left; nothing without iterations.
    fn residuals(&self) -> &[Residual] {
        &[]
    }

    /// The interface in the accepted state; nothing without a structure, or with one that gives no positions.
    fn interface(&self) -> Option<InterfaceState<'_>> {
        None
    }

    /// The sides, the fluid first.
    fn sides(&self) -> impl AsRef<[&Side]>;

    /// The same, to be ended.
    fn sides_mut(&mut self) -> impl IntoIterator<Item = &mut Side>;

    /// Writes all that the next windows depend on.
    fn save(&mut self, state: &mut Writer) -> Result<(), SchemeError>;

    /// Goes to what [`save`](Self::save) wrote in a run of the same case.
    fn restore(&mut self, state: &mut Reader<'_>) -> Result<(), SchemeError>;
}

/// Points of the interface in an accepted state, fields flat, `components` doubles a vector.
#[derive(Clone, Copy, Debug)]
pub struct InterfaceState<'a> {
    /// Components of a vector: the dimension.
    pub components: usize,
    /// Positions (m).
    pub position: &'a [f64],
    /// Velocities (m/s).
    pub velocity: &'a [f64],
    /// Reference volumes `V` (m³).
    pub volume: &'a [f64],
    /// Pressure gradient `g` (Pa/m) under which the structure came there, force `−V g`; nothing at the start,
    /// and where the run does not keep it.
    pub load: Option<&'a [f64]>,
}

/// First bytes of a run's state; the last is the version of its layout.
const MAGIC: &[u8; 8] = b"mnscrun1";

/// A run between two windows: who solves, and the time.
pub struct Run<S> {
    /// Who solves.
    pub solver: S,
    /// The time.
    pub schedule: Schedule,
}

impl<S: Solver> Run<S> {
    /// Solves window after window, until the schedule ends, or `record`, which hears of every accepted one,
    /// says to stop.
    pub fn drive(
        &mut self,
        mut record: impl FnMut(&Accepted, &S) -> Result<Onward, SchemeError>,
    ) -> Result<(), SchemeError> {
        while let Some(window) = self.schedule.next(self.solver.window_limit()) {
            let accepted = self.solver.solve(window, &mut self.schedule)?;
            if record(&accepted, &self.solver)? == Onward::Stop {
                break;
            }
        }
        Ok(())
    }

    /// The run between two windows, its participants included, as bytes.
    pub fn save(&mut self) -> Result<Vec<u8>, SchemeError> {
        let mut state = Writer::new(MAGIC);
        self.schedule.save(&mut state);
        self.solver.save(&mut state)?;
        Ok(state.finish())
    }

    /// Goes to a state of a run of the same case, with participants that are initialised. What follows is
    /// what followed it there, to the bit. After an error the run is of no use.
    pub fn restore(&mut self, state: &[u8]) -> Result<(), SchemeError> {
        let mut state = Reader::new("run's state", MAGIC, state)?;
        self.schedule.restore(&mut state)?;
        self.solver.restore(&mut state)?;
        Ok(state.finish()?)
    }
}
