//! The parallel explicit scheme: both participants solve the window at once, each with what the other gave
//! for the last one.
//!
//! Per window: the structure solves under the load of the last window while the fluid solves against the
//! velocity of the last window; condition (46) is enforced on what the fluid gives, the load is relaxed, and
//! both accept. The fastest and least stable of the schemes: with added mass of a third of the structure's
//! and more it needs the compliance or an implicit scheme.

use super::{Accepted, Pair, SchemeError};
use crate::schedule::Schedule;
use interfaces::TimeWindow;

/// What the case sets of the scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParallelExplicit {
    /// Relaxation `r` of the load, in (0, 1].
    pub relaxation: f64,
    /// Whether condition (46) is enforced, or only measured.
    pub enforce: bool,
}

impl ParallelExplicit {
    /// Solves the window with the pair and accepts it.
    pub fn solve(
        &self,
        pair: &mut Pair,
        window: TimeWindow,
        schedule: &mut Schedule,
    ) -> Result<Accepted, SchemeError> {
        pair.start_structure(&window)?;
        pair.start_fluid(&window)?;
        pair.finish_structure(&window)?;
        pair.finish_fluid(&window)?;
        pair.take_load(self.enforce);
        let found = pair.condition46(&window);
        let accepted = pair.accept(&window, found, schedule)?;
        pair.relax_load(self.relaxation);
        Ok(accepted)
    }
}
