//! A run with its records.

use super::options::RunError;
use crate::phase::Announce;
use crate::phase::Phase;
pub use crate::records::Lengths;
pub use crate::records::Wanted;
use crate::records::{Records, Sums};
use crate::schemes::{Accepted, Onward, Run, SchemeError, Solver};
use std::path::Path;
use words::bytes::{self, Reader, Writer};

/// Name of the records' part of its state.
const RECORDS: &str = "records";
/// First bytes of that part; the last is the version of its layout.
const MAGIC: &[u8; 8] = b"mnscrec5";

/// A run whose accepted windows are recorded.
pub struct Recorded<S> {
    /// The run.
    pub run: Run<S>,
    records: Records,
    announce: Announce,
}

impl<S: Solver> Recorded<S> {
    /// Makes the tables in the folder `out`, or opens those of an earlier run to go on in them.
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

    /// Forces the tables to the disk. Gives the bytes that each has then, by its file.
    ///
    /// # Errors
    /// A full disk.
    pub fn sync(&mut self) -> output::Result<Lengths> {
        self.records.sync()
    }

    /// Hands over the run between two windows in parts, by name, its records' sums among them.
    ///
    /// # Errors
    /// A participant that cannot be saved, and what `part` returns.
    pub fn save<E: From<SchemeError>>(
        &mut self,
        mut part: impl FnMut(&str, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.run.save(&mut part)?;
        let mut state = Writer::new(MAGIC);
        self.records.save(&mut state);
        part(RECORDS, &state.finish())
    }

    /// Goes to a state of a run of the same case, of which it asks for the parts by name. Its tables are to
    /// be cut then: [`go_on`](Self::go_on).
    ///
    /// # Errors
    /// What is no such state; the run is then of no use.
    pub fn restore<E: From<SchemeError>>(
        &mut self,
        mut part: impl FnMut(&str) -> Result<Vec<u8>, E>,
    ) -> Result<(), E> {
        self.run.restore(&mut part)?;
        Ok(self.restore_records(&part(RECORDS)?).map_err(SchemeError::from)?)
    }

    fn restore_records(&mut self, state: &[u8]) -> Result<(), bytes::Error> {
        let mut state = Reader::new("records' state", MAGIC, state)?;
        self.records.restore(&mut state)?;
        state.finish()
    }

    /// Cuts tables and snapshots of an earlier run, which had these lengths at the state that was restored.
    ///
    /// # Errors
    /// A table that is not as long.
    pub fn go_on(&mut self, lengths: &Lengths) -> output::Result<()> {
        self.records.go_on(lengths)
    }

    /// What all windows say in sum, and whether the last rows could be written.
    pub(super) fn sums(&mut self) -> (Sums, output::Result<()>) {
        self.records.balances()
    }
}
