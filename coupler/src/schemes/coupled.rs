//! A pair under the scheme that the case chose.

use super::implicit::Implicit;
use super::parallel_explicit::ParallelExplicit;
use super::serial_explicit::SerialExplicit;
use super::{Accepted, InterfaceState, Pair, SchemeError, Solver};
use crate::convergence::Residual;
use crate::schedule::Schedule;
use crate::side::Side;
use interfaces::TimeWindow;
use interfaces::case::coupling::{Coupling, CouplingScheme};
use words::bytes::{self, Reader, Writer};

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
        match coupling.scheme {
            CouplingScheme::SerialExplicit => {
                let predict = coupling.prediction.unwrap_or(true);
                SerialExplicit { relaxation, enforce, predict }.into()
            }
            CouplingScheme::ParallelExplicit => ParallelExplicit { relaxation, enforce }.into(),
            CouplingScheme::SerialImplicit => Implicit::of(coupling, false).into(),
            CouplingScheme::ParallelImplicit => Implicit::of(coupling, true).into(),
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Self::SerialExplicit(_) => "serial explicit",
            Self::ParallelExplicit(_) => "parallel explicit",
            Self::Implicit(scheme) if scheme.parallel => "parallel implicit",
            Self::Implicit(_) => "serial implicit",
        }
    }
}

impl From<SerialExplicit> for Scheme {
    fn from(scheme: SerialExplicit) -> Self {
        Self::SerialExplicit(scheme)
    }
}

impl From<ParallelExplicit> for Scheme {
    fn from(scheme: ParallelExplicit) -> Self {
        Self::ParallelExplicit(scheme)
    }
}

impl From<Implicit> for Scheme {
    fn from(scheme: Implicit) -> Self {
        Self::Implicit(Box::new(scheme))
    }
}

/// A fluid and a structure, and the scheme by which they solve windows.
pub struct Coupled {
    /// Both sides.
    pub pair: Pair,
    /// The scheme, with what it remembers.
    pub scheme: Scheme,
}

impl Coupled {
    /// A pair under this scheme.
    pub fn new(pair: Pair, scheme: impl Into<Scheme>) -> Self {
        Self { pair, scheme: scheme.into() }
    }
}

impl Solver for Coupled {
    fn window_limit(&self) -> f64 {
        self.pair.window_limit()
    }

    fn solve(&mut self, window: TimeWindow, schedule: &mut Schedule) -> Result<Accepted, SchemeError> {
        match &mut self.scheme {
            Scheme::SerialExplicit(scheme) => scheme.solve(&mut self.pair, window, schedule),
            Scheme::ParallelExplicit(scheme) => scheme.solve(&mut self.pair, window, schedule),
            Scheme::Implicit(scheme) => scheme.solve(&mut self.pair, window, schedule),
        }
    }

    fn ending(&self) -> Option<String> {
        self.pair.ending.clone()
    }

    fn residuals(&self) -> &[Residual] {
        &self.pair.residuals
    }

    fn interface(&self) -> Option<InterfaceState<'_>> {
        self.pair.interface_state()
    }

    fn sides(&self) -> impl AsRef<[&Side]> {
        [&self.pair.fluid, &self.pair.structure]
    }

    fn sides_mut(&mut self) -> impl IntoIterator<Item = &mut Side> {
        [&mut self.pair.fluid, &mut self.pair.structure]
    }

    /// The explicit schemes remember nothing from window to window that the pair does not have.
    fn save(&self, state: &mut Writer) {
        state.text(self.scheme.name());
        self.pair.save(state);
        if let Scheme::Implicit(scheme) = &self.scheme {
            scheme.save(state);
        }
    }

    fn restore(&mut self, state: &mut Reader<'_>) -> Result<(), bytes::Error> {
        match state.text("scheme")? {
            scheme if scheme == self.scheme.name() => {}
            other => return Err(state.refuse("scheme", other)),
        }
        self.pair.restore(state)?;
        if let Scheme::Implicit(scheme) = &mut self.scheme {
            scheme.restore(state, &self.pair)?;
        }
        Ok(())
    }
}
