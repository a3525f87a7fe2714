//! The loop over windows, and a run as a value.

use super::{Accepted, Onward, SchemeError};
use crate::convergence::Residual;
use crate::schedule::Schedule;
use crate::side::Side;
use interfaces::TimeWindow;
use words::bytes::{self, Reader, Writer};

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

    /// Writes all that the next windows depend on, but for the participants' own states.
    fn save(&self, state: &mut Writer);

    /// Goes to what [`save`](Self::save) wrote in a run of the same case, with participants that are in their
    /// own states.
    fn restore(&mut self, state: &mut Reader<'_>) -> Result<(), bytes::Error>;
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

/// Name of the coupler's part of a run's state.
const COUPLER: &str = "coupler";
/// First bytes of that part; the last is the version of its layout.
const MAGIC: &[u8; 8] = b"mnscrun2";

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

    /// Hands over the run between two windows in parts, by name: each participant's state under its role, and
    /// the coupler's own. A part is given up before the next is made: there is no copy of the whole.
    pub fn save<E: From<SchemeError>>(
        &mut self,
        mut part: impl FnMut(&str, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        for side in self.solver.sides_mut() {
            let state = side.save_participant().map_err(SchemeError::from)?;
            part(&side.role().to_string(), &state)?;
        }
        let mut state = Writer::new(MAGIC);
        self.schedule.save(&mut state);
        self.solver.save(&mut state);
        part(COUPLER, &state.finish())
    }

    /// Goes to a state of a run of the same case, of which it asks for the parts by name, with participants
    /// that are initialised. What follows is what followed it there, to the bit. After an error the run is of
    /// no use.
    pub fn restore<E: From<SchemeError>>(
        &mut self,
        mut part: impl FnMut(&str) -> Result<Vec<u8>, E>,
    ) -> Result<(), E> {
        for side in self.solver.sides_mut() {
            let state = part(&side.role().to_string())?;
            side.restore_participant(&state).map_err(SchemeError::from)?;
        }
        Ok(self.restore_coupler(&part(COUPLER)?).map_err(SchemeError::from)?)
    }

    fn restore_coupler(&mut self, state: &[u8]) -> Result<(), bytes::Error> {
        let mut state = Reader::new("coupler's state", MAGIC, state)?;
        self.schedule.restore(&mut state)?;
        self.solver.restore(&mut state)?;
        state.finish()
    }
}
