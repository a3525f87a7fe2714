//! A load that swings with time, the same at every point, whatever the motion.

use super::load::Load;
use crate::Model;
use crate::structure::components;
use interfaces::port::names;
use interfaces::{Description, Fields, Result, ScalarKind, TimeWindow};
use std::f64::consts::TAU;

/// A pressure gradient `g sin(2π f t)`, given for the window's end. State: the time (s), then the force on
/// the structure (N, `D`).
#[derive(Clone, Debug)]
pub struct Harmonic {
    /// How it is given.
    pub load: Load,
    /// Amplitude of the pressure gradient at every point (Pa/m), `D`.
    pub gradient: Vec<f64>,
    /// Frequency (Hz).
    pub frequency: f64,
}

impl Harmonic {
    fn gradient(&self, time: f64) -> Vec<f64> {
        let sine = (TAU * self.frequency * time).sin();
        self.gradient.iter().map(|g| g * sine).collect()
    }

    fn state(&self, time: f64) -> Vec<f64> {
        let all = self.gradient(time).repeat(self.load.volumes.len());
        [vec![time], self.load.force(&all)].concat()
    }
}

impl Model for Harmonic {
    fn description(&self) -> Description {
        let force = components("force", "N", ScalarKind::Balance, self.load.dimension);
        self.load.description("mock fluid (harmonic load)", &[], force)
    }

    fn initial(&mut self, start: f64, inputs: &Fields) -> Result<Vec<f64>> {
        self.load.take_volumes(inputs);
        Ok(self.state(start))
    }

    fn constants(&self, _outputs: &mut Fields) {}

    fn advance(&self, _accepted: &[f64], window: &TimeWindow, _inputs: &Fields) -> Result<(Vec<f64>, u32)> {
        Ok((self.state(window.end()), 1))
    }

    fn outputs(&self, state: &[f64], outputs: &mut Fields) {
        let n = outputs.get(names::PRESSURE).map_or(0, <[f64]>::len);
        self.load.write(&self.gradient(state[0]).repeat(n), &vec![0.0; n], outputs);
    }

    fn scalars(&self, state: &[f64]) -> Vec<f64> {
        state[1..].to_vec()
    }
}
