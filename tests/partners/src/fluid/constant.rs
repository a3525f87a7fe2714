//! The same load at every point, whatever the motion.

use super::load::Load;
use crate::Model;
use crate::structure::components;
use interfaces::port::names;
use interfaces::{Description, END_REQUESTED, Fields, Result, Scalar, ScalarKind, TimeWindow};

/// A constant pressure gradient. State: the force on the structure (N, `D`), then whether it asks for the end
/// of the run (1 or 0), if it ever will.
#[derive(Clone, Debug)]
pub struct Constant {
    /// How it is given.
    pub load: Load,
    /// Pressure gradient at every point (Pa/m), `D`.
    pub gradient: Vec<f64>,
    /// Pressure at every point (Pa).
    pub pressure: f64,
    /// Time from which it asks for the end of the run (s); infinite for never.
    pub end_after: f64,
}

impl Model for Constant {
    fn description(&self) -> Description {
        let mut scalars = components("force", "N", ScalarKind::Balance, self.load.dimension);
        if self.end_after.is_finite() {
            scalars.push(Scalar::new(END_REQUESTED, "1", ScalarKind::Balance));
        }
        self.load.description("mock fluid (constant load)", &[], scalars)
    }

    fn initial(&mut self, _start: f64, inputs: &Fields) -> Result<Vec<f64>> {
        self.load.take_volumes(inputs);
        let mut state = self.load.force(&self.gradient.repeat(self.load.volumes.len()));
        if self.end_after.is_finite() {
            state.push(0.0);
        }
        Ok(state)
    }

    fn constants(&self, _outputs: &mut Fields) {}

    fn advance(&self, accepted: &[f64], window: &TimeWindow, _inputs: &Fields) -> Result<(Vec<f64>, u32)> {
        let mut state = accepted.to_vec();
        if let Some(asks) = state.get_mut(self.load.dimension) {
            *asks = f64::from(window.end() >= self.end_after);
        }
        Ok((state, 1))
    }

    fn outputs(&self, _state: &[f64], outputs: &mut Fields) {
        let n = outputs.get(names::PRESSURE).map_or(0, <[f64]>::len);
        self.load.write(&self.gradient.repeat(n), &vec![self.pressure; n], outputs);
    }

    fn scalars(&self, state: &[f64]) -> Vec<f64> {
        state.to_vec()
    }
}
