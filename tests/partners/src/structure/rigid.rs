//! A structure that never moves.

use super::points::{Points, components};
use crate::Model;
use interfaces::port::names;
use interfaces::{Description, Fields, Result, ScalarKind, TimeWindow};

/// Points that stay where they are, and report the force on them (N). State: that force.
#[derive(Clone, Debug)]
pub struct Rigid {
    /// The points.
    pub points: Points,
}

impl Model for Rigid {
    fn description(&self) -> Description {
        let force = components("force", "N", ScalarKind::Balance, self.points.dimension);
        self.points.description("mock structure (rigid)", false, force)
    }

    fn initial(&mut self, _start: f64, inputs: &Fields) -> Result<Vec<f64>> {
        Ok(self.points.force(inputs, names::PRESSURE_GRADIENT))
    }

    fn constants(&self, outputs: &mut Fields) {
        self.points.constants(outputs);
    }

    fn advance(&self, _accepted: &[f64], window: &TimeWindow, inputs: &Fields) -> Result<(Vec<f64>, u32)> {
        Ok((self.points.force(inputs, names::PRESSURE_GRADIENT), super::prescribed::asked_sub_steps(window)))
    }

    fn outputs(&self, _state: &[f64], outputs: &mut Fields) {
        let still = vec![0.0; self.points.dimension];
        self.points.translated(&still, &still, outputs);
    }

    fn scalars(&self, state: &[f64]) -> Vec<f64> {
        state.to_vec()
    }
}
