//! Water at rest.

use super::load::Load;
use crate::Model;
use crate::structure::components;
use interfaces::port::names;
use interfaces::{Description, Fields, Result, ScalarKind, TimeWindow};

/// `p = ρ g max(0, H − y)` at the points' current height `y`, the last coordinate.
///
/// A point under water of a submerged body feels `∇p = −ρ g e_y`: Archimedes' force. A plate of thickness `T`
/// that is dry beneath feels `∇p = p/T e_y`: the pressure on its upper face, spread over its thickness.
/// State: force on the structure (N, `D`), pressure gradient (`n × D`), pressure (`n`).
#[derive(Clone, Debug)]
pub struct Hydrostatic {
    /// How it is given.
    pub load: Load,
    /// Density `ρ` (kg/m³).
    pub density: f64,
    /// Gravity `g` (m/s²).
    pub gravity: f64,
    /// Height `H` of the surface (m).
    pub level: f64,
    /// Thickness `T` of the plate (m), or nothing for a submerged body.
    pub plate_thickness: Option<f64>,
}

impl Hydrostatic {
    fn state(&self, inputs: &Fields) -> Vec<f64> {
        let d = self.load.dimension;
        let positions = inputs.get(names::POSITION).unwrap_or(&[]);
        let (mut gradient, mut pressure) = (vec![0.0; positions.len()], vec![0.0; positions.len() / d]);
        let weight = self.density * self.gravity;
        for (point, x) in positions.chunks_exact(d).enumerate() {
            pressure[point] = weight * (self.level - x[d - 1]).max(0.0);
            if x[d - 1] < self.level {
                gradient[point * d + d - 1] =
                    self.plate_thickness.map_or(-weight, |thickness| pressure[point] / thickness);
            }
        }
        [self.load.force(&gradient), gradient, pressure].concat()
    }
}

impl Model for Hydrostatic {
    fn description(&self) -> Description {
        let force = components("force", "N", ScalarKind::Balance, self.load.dimension);
        self.load.description("mock fluid (hydrostatic)", &[names::POSITION], force)
    }

    fn initial(&mut self, _start: f64, inputs: &Fields) -> Result<Vec<f64>> {
        self.load.take_volumes(inputs);
        Ok(self.state(inputs))
    }

    fn constants(&self, _outputs: &mut Fields) {}

    fn advance(&self, _accepted: &[f64], _window: &TimeWindow, inputs: &Fields) -> Result<(Vec<f64>, u32)> {
        Ok((self.state(inputs), 1))
    }

    fn outputs(&self, state: &[f64], outputs: &mut Fields) {
        let d = self.load.dimension;
        let n = (state.len() - d) / (d + 1);
        let (gradient, pressure) = state[d..].split_at(n * d);
        self.load.write(gradient, pressure, outputs);
    }

    fn scalars(&self, state: &[f64]) -> Vec<f64> {
        state[..self.load.dimension].to_vec()
    }
}
