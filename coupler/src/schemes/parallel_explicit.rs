//! The parallel explicit scheme: both participants solve the window at once, each with what the other gave
//! for the last one.
//!
//! Per window: the structure solves under the load of the last window while the fluid solves against the
//! velocity of the last window; condition (46) is enforced on what the fluid gives, the load is relaxed, and
//! both accept. The fastest and least stable of the schemes: with added mass of a third of the structure's
//! and more it needs the compliance or an implicit scheme.

use super::{Accepted, Onward, Pair, SchemeError};
use crate::schedule::Schedule;

/// What the case sets of the scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParallelExplicit {
    /// Relaxation `r` of the load, in (0, 1].
    pub relaxation: f64,
    /// Whether condition (46) is enforced, or only measured.
    pub enforce: bool,
}

impl ParallelExplicit {
    /// Runs the pair over the schedule. `record` hears of every accepted window.
    pub fn run(
        &self,
        pair: &mut Pair,
        schedule: &mut Schedule,
        mut record: impl FnMut(&Accepted, &Pair) -> Result<Onward, SchemeError>,
    ) -> Result<(), SchemeError> {
        let mut velocity = pair.new_velocity.clone();
        while let Some(window) = schedule.next(pair.window_limit()) {
            pair.start_structure(&window)?;
            pair.start_fluid(&window, &mut velocity)?;
            pair.finish_structure(&window)?;
            pair.finish_fluid(&window)?;
            pair.take_load(self.enforce);
            let (condition46, applied) = pair.condition46();

            let output = pair.accept(&window, schedule)?;
            pair.relax_load(self.relaxation);
            velocity.copy_from_slice(&pair.new_velocity);
            let accepted = Accepted::alone(window, schedule.time(), output).with(condition46, applied);
            if record(&accepted, pair)? == Onward::Stop {
                break;
            }
        }
        Ok(())
    }
}
