//! The same load at every point, whatever the motion.

use super::load::Load;
use crate::Model;
use crate::structure::components;
use interfaces::port::names;
use interfaces::{Description, Fields, ParticipantError, ScalarKind, TimeWindow};

/// A constant pressure gradient. State: the force on the structure (N, `D`).
#[derive(Clone, Debug)]
pub struct Constant {
    /// How it is given.
    pub load: Load,
    /// Pressure gradient at every point (Pa/m), `D`.
    pub gradient: Vec<f64>,
    /// Pressure at every point (Pa).
    pub pressure: f64,
}

impl Model for Constant {
    fn description(&self) -> Description {
        let force = components("force", "N", ScalarKind::Balance, self.load.dimension);
        self.load.description("mock fluid (constant load)", &[], force)
    }

    fn initial(&mut self, _start: f64, inputs: &Fields) -> Result<Vec<f64>, ParticipantError> {
        self.load.take_volumes(inputs);
        Ok(self.load.force(&self.gradient.repeat(self.load.volumes.len())))
    }

    fn constants(&self, _outputs: &mut Fields) {}

    fn advance(
        &self,
        accepted: &[f64],
        _window: &TimeWindow,
        _inputs: &Fields,
    ) -> Result<(Vec<f64>, u32), ParticipantError> {
        Ok((accepted.to_vec(), 1))
    }

    fn outputs(&self, _state: &[f64], outputs: &mut Fields) {
        let n = outputs.get(names::PRESSURE).map_or(0, <[f64]>::len);
        self.load.write(&self.gradient.repeat(n), &vec![self.pressure; n], outputs);
    }

    fn scalars(&self, state: &[f64]) -> Vec<f64> {
        state.to_vec()
    }
}
