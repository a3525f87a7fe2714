//! The serial explicit scheme: structure predicted, fluid solved, condition (46) enforced, structure solved.
//! No iteration.
//!
//! Per window, from the accepted state at `tⁿ` to `tⁿ⁺¹` (section 2.3 and Algorithm 1 of the paper, with the
//! prediction that makes heavy fluid on a light structure stable):
//!
//! 1. the structure is *predicted* under the load held from the last window;
//! 2. the fluid takes the structure's position at `tⁿ`, its predicted velocity over the window and the load
//!    of the prediction, and solves for the pressure in fluid and structure together; it gives the new load;
//! 3. condition (46) is measured and enforced;
//! 4. the load is relaxed, `g ← r g + (1 − r) g_held`, and the structure is *solved* from the same accepted
//!    state under it;
//! 5. both accept.
//!
//! Without the prediction each participant solves a window once: the structure under the held load, then the
//! fluid against its motion, whose load is that of the next window. That is a third less to do, and stable
//! only where the fluid is light.
//!
//! With the structure's compliance in the fluid's equations and the velocity at the window's end,
//! `r = 0.3 … 0.5` is stable at an added-mass ratio of 9, `r = 1` is not; with the mean velocity every `r`
//! is; without the compliance (a moving wall) none, see `docs/decisions`.

use super::{Accepted, Onward, Pair, SchemeError};
use crate::condition46::{Condition46, Resultant};
use crate::schedule::Schedule;
use interfaces::TimeWindow;

/// What the case sets of the scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SerialExplicit {
    /// Relaxation `r` of the load, in (0, 1].
    pub relaxation: f64,
    /// Whether condition (46) is enforced, or only measured.
    pub enforce: bool,
    /// Whether the structure is predicted first.
    pub predict: bool,
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
            let (solution, condition46, applied) =
                if self.predict { self.predicted(pair, &window)? } else { self.staggered(pair, &window)? };
            let output = pair.accept(&solution, schedule)?;
            if !self.predict {
                pair.relax_load(self.relaxation);
            }
            let accepted = Accepted::alone(solution, schedule.time(), output).with(condition46, applied);
            if record(&accepted, pair)? == Onward::Stop {
                break;
            }
        }
        Ok(())
    }

    /// Steps 1 to 4.
    fn predicted(
        &self,
        pair: &mut Pair,
        prediction: &TimeWindow,
    ) -> Result<(TimeWindow, Condition46, Resultant), SchemeError> {
        let solution = TimeWindow { iteration: 1, ..*prediction };
        pair.solve_structure(prediction)?;
        pair.solve_fluid(prediction)?;
        pair.take_load(self.enforce);
        pair.relax_load(self.relaxation);
        let (condition46, applied) = pair.condition46();
        pair.solve_structure(&solution)?;
        Ok((solution, condition46, applied))
    }

    /// The structure under the held load, the fluid against its motion.
    fn staggered(
        &self,
        pair: &mut Pair,
        window: &TimeWindow,
    ) -> Result<(TimeWindow, Condition46, Resultant), SchemeError> {
        pair.solve_structure(window)?;
        pair.solve_fluid(window)?;
        pair.take_load(self.enforce);
        let (condition46, applied) = pair.condition46();
        Ok((*window, condition46, applied))
    }
}
