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

use super::{Accepted, Pair, SchemeError};
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
    /// Solves the window with the pair and accepts it.
    pub fn solve(
        &self,
        pair: &mut Pair,
        window: TimeWindow,
        schedule: &mut Schedule,
    ) -> Result<Accepted, SchemeError> {
        if self.predict {
            return self.predicted(pair, &window, schedule);
        }
        let accepted = self.staggered(pair, &window, schedule)?;
        pair.relax_load(self.relaxation);
        Ok(accepted)
    }

    /// Steps 1 to 5.
    fn predicted(
        &self,
        pair: &mut Pair,
        prediction: &TimeWindow,
        schedule: &mut Schedule,
    ) -> Result<Accepted, SchemeError> {
        let solution = TimeWindow { iteration: 1, ..*prediction };
        pair.solve_structure(prediction)?;
        pair.solve_fluid(prediction)?;
        pair.take_load(self.enforce);
        pair.relax_load(self.relaxation);
        pair.solve_structure(&solution)?;
        let found = pair.condition46(&solution);
        pair.accept(&solution, found, schedule)
    }

    /// The structure under the held load, the fluid against its motion.
    fn staggered(
        &self,
        pair: &mut Pair,
        window: &TimeWindow,
        schedule: &mut Schedule,
    ) -> Result<Accepted, SchemeError> {
        pair.solve_structure(window)?;
        pair.solve_fluid(window)?;
        pair.take_load(self.enforce);
        let found = pair.condition46(window);
        pair.accept(window, found, schedule)
    }
}
