//! The serial explicit scheme: structure predicted, fluid solved, condition (46) enforced, structure solved. No iteration.
//!
//! Per window, from the accepted state at `tⁿ` to `tⁿ⁺¹` (section 2.3 and Algorithm 1 of the paper, with the prediction that makes heavy
//! fluid on a light structure stable):
//!
//! 1. the structure is *predicted* under the load held from the last window;
//! 2. the fluid takes the structure's position at `tⁿ`, its predicted velocity over the window and the load of the prediction, and solves for
//!    the pressure in fluid and structure together; it gives the new load;
//! 3. condition (46) is measured and enforced;
//! 4. the load is relaxed, `g ← r g + (1 − r) g_held`, and the structure is *solved* from the same accepted state under it;
//! 5. both accept.
//!
//! With the structure's compliance in the fluid's equations and the velocity at the window's end, `r = 0.3 … 0.5` is stable at an added-mass
//! ratio of 9, `r = 1` is not; with the mean velocity every `r` is; without the compliance (a moving wall) none, see `docs/decisions`.

use super::{Accepted, Onward, Pair, SchemeError};
use crate::schedule::Schedule;
use interfaces::TimeWindow;

/// What the case sets of the scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SerialExplicit {
    /// Relaxation `r` of the load, in (0, 1].
    pub relaxation: f64,
    /// Whether condition (46) is enforced, or only measured.
    pub enforce: bool,
}

impl SerialExplicit {
    /// Runs the pair over the schedule. `record` hears of every accepted window.
    pub fn run(
        &self,
        pair: &mut Pair,
        schedule: &mut Schedule,
        mut record: impl FnMut(&Accepted, &Pair) -> Result<Onward, SchemeError>,
    ) -> Result<(), SchemeError> {
        while let Some(window) = schedule.next(pair.window_limit()) {
            let prediction = window;
            let solution = TimeWindow { iteration: 1, ..window };

            pair.solve_structure(&prediction)?;
            pair.solve_fluid(&prediction)?;
            let condition46 = pair.condition46(self.enforce);
            super::relax(&mut pair.load, &pair.new_load, self.relaxation);
            let applied = pair.applied();
            pair.solve_structure(&solution)?;

            let output = schedule.accept(&solution);
            pair.accept(&solution, output)?;
            let accepted = Accepted::alone(solution, schedule.time(), output).with(condition46, applied);
            if record(&accepted, pair)? == Onward::Stop {
                break;
            }
        }
        Ok(())
    }
}
