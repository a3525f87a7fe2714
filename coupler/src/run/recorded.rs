//! A run with its records.

use super::options::RunError;
use crate::phase::Announce;
use crate::phase::Phase;
pub use crate::records::Wanted;
use crate::records::{Records, Sums};
use crate::schemes::{Accepted, Onward, Run, SchemeError, Solver};
use std::path::Path;
use words::bytes::{Reader, Writer};

/// First bytes of its state; the last is the version of its layout.
const MAGIC: &[u8; 8] = b"mnscrec4";

/// A run whose accepted windows are recorded.
pub struct Recorded<S> {
    /// The run.
    pub run: Run<S>,
    records: Records,
    announce: Announce,
}

impl<S: Solver> Recorded<S> {
    /// Makes the tables in the folder `out`.
    ///
    /// # Errors
    /// If they cannot be made.
    pub fn create(
        run: Run<S>,
        out: &Path,
        wanted: &Wanted<'_>,
        announce: Announce,
    ) -> Result<Self, RunError> {
        let records = {
            let (solver, time) = (&run.solver, run.schedule.time());
            Records::create(out, (solver.sides().as_ref(), solver.interface()), time, wanted)?
        };
        Ok(Self { run, records, announce })
    }

    /// Solves all windows; `heard` is told of each when it is recorded.
    ///
    /// # Errors
    /// What ended the run.
    pub fn drive(&mut self, mut heard: impl FnMut(&Accepted, &S) -> Onward) -> Result<(), SchemeError> {
        let Self { run, records, announce } = self;
        run.drive(|accepted, solver| {
            let window = accepted.window.index;
            let recorded = announce.during(Phase::Records, || {
                let residuals = solver.residuals();
                records.record(accepted, residuals, (solver.sides().as_ref(), solver.interface()))
            });
            recorded.map_err(|error| SchemeError::Record { window, what: error.to_string() })?;
            Ok(heard(accepted, solver))
        })
    }

    /// The run between two windows and how far its records are, as bytes.
    ///
    /// # Errors
    /// A participant that cannot be saved.
    pub fn save(&mut self) -> Result<Vec<u8>, SchemeError> {
        let mut state = Writer::new(MAGIC);
        state.bytes(&self.run.save()?);
        self.records.save(&mut state);
        Ok(state.finish())
    }

    /// Goes to a state of a run of the same case. Gives the rows that its tables had: see [`Records::rows`].
    ///
    /// # Errors
    /// What is no such state; the run is then of no use.
    pub fn restore(&mut self, state: &[u8]) -> Result<[Option<u64>; 4], SchemeError> {
        let mut state = Reader::new("recorded run's state", MAGIC, state)?;
        self.run.restore(state.bytes("run")?)?;
        self.records.restore(&mut state)?;
        state.finish()?;
        Ok(self.records.rows())
    }

    /// What all windows say in sum, and whether the last rows could be written.
    pub(super) fn sums(&mut self) -> (Sums, output::Result<()>) {
        self.records.balances()
    }
}
