//! Water at rest, known on the boundary of the body in it: a fluid with points of its own.

use crate::Model;
use crate::stand_in::write;
use crate::structure::{Points, components};
use interfaces::port::names;
use interfaces::{Description, Direction, Fields, Port, Quantity, Result, Role, ScalarKind, TimeWindow};

/// `p = ρ g max(0, H − y)` on the segments of a closed outline that goes with the structure, linear along
/// each; given as forces on its vertices that do the pressure's work: force and moment are those of the
/// pressure. Two dimensions.
///
/// State: the resultant force (N, 2), the force on each vertex (`n × 2`).
#[derive(Clone, Debug)]
pub struct SurfacePressure {
    /// The outline at the start.
    pub outline: Points,
    /// Density `ρ` (kg/m³).
    pub density: f64,
    /// Gravity `g` (m/s²).
    pub gravity: f64,
    /// Height `H` of the surface (m).
    pub level: f64,
}

impl SurfacePressure {
    fn state(&self, displacement: &[f64]) -> Vec<f64> {
        let vertex =
            |i: usize| [0, 1].map(|axis| self.outline.positions[2 * i + axis] + displacement[2 * i + axis]);
        let pressure = |x: [f64; 2]| self.density * self.gravity * (self.level - x[1]).max(0.0);
        let mut state = vec![0.0; 2 + displacement.len()];
        for segment in self.outline.facets.chunks_exact(2) {
            let [from, to] = [segment[0], segment[1]];
            let [a, b] = [vertex(from), vertex(to)];
            // Out of the body, as long as the segment: the outline goes round anticlockwise.
            let normal = [b[1] - a[1], a[0] - b[0]];
            for (i, (near, far)) in [(from, (pressure(a), pressure(b))), (to, (pressure(b), pressure(a)))] {
                for axis in 0..2 {
                    let force = -normal[axis] * (near / 3.0 + far / 6.0);
                    state[axis] += force;
                    state[2 + 2 * i + axis] += force;
                }
            }
        }
        state
    }
}

impl Model for SurfacePressure {
    fn description(&self) -> Description {
        let port =
            |name, quantity, direction| Port::new(name, quantity, 2, Some(self.outline.len()), direction);
        Description {
            role: Role::Fluid,
            solver: "mock fluid (surface pressure)".to_owned(),
            dimension: 2,
            ports: vec![
                port(names::OWN_POSITION, Quantity::Position, Direction::Out).constant(),
                port(names::DISPLACEMENT, Quantity::Displacement, Direction::In),
                port(names::VELOCITY, Quantity::Velocity, Direction::In).optional(),
                port(names::FORCE, Quantity::Force, Direction::Out),
            ],
            scalars: components("force", "N", ScalarKind::Balance, 2),
            saves: true,
            notes: vec![],
        }
    }

    fn initial(&mut self, _start: f64, _inputs: &Fields) -> Result<Vec<f64>> {
        Ok(self.state(&vec![0.0; self.outline.positions.len()]))
    }

    fn constants(&self, outputs: &mut Fields) {
        write(outputs, names::OWN_POSITION, &self.outline.positions);
    }

    fn advance(&self, _accepted: &[f64], window: &TimeWindow, inputs: &Fields) -> Result<(Vec<f64>, u32)> {
        let start = inputs.get(names::DISPLACEMENT).unwrap_or(&[]);
        let velocity = inputs.get(names::VELOCITY).unwrap_or(&[]);
        // Where it is at the window's end.
        let moved: Vec<f64> = start.iter().zip(velocity).map(|(u, v)| u + window.size * v).collect();
        Ok((self.state(&moved), 1))
    }

    fn outputs(&self, state: &[f64], outputs: &mut Fields) {
        write(outputs, names::FORCE, &state[2..]);
    }

    fn scalars(&self, state: &[f64]) -> Vec<f64> {
        state[..2].to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Archimedes: a box of 4 cm × 2 cm at a slant, its moment about the origin that of its weight in water
    /// at its centre.
    #[test]
    fn force_and_moment_are_those_of_the_displaced_water() {
        let outline = Points::on_outline([4, 2], &[0.1, 0.0], 0.01, 1.0);
        let (sin, cos) = 0.3_f64.sin_cos();
        let turned: Vec<f64> = outline
            .positions
            .chunks_exact(2)
            .flat_map(|x| [cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]])
            .collect();
        let displacement: Vec<f64> =
            turned.iter().zip(&outline.positions).map(|(x, start)| x - start).collect();
        let fluid = SurfacePressure { outline, density: 1000.0, gravity: 10.0, level: 1.0 };
        let state = fluid.state(&displacement);
        let moment: f64 = turned
            .chunks_exact(2)
            .zip(state[2..].chunks_exact(2))
            .map(|(x, f)| x[0] * f[1] - x[1] * f[0])
            .sum();
        // 8e-4 m² of 1 m depth weigh 8 N; the centre was at (0.12, 0.01).
        let centre = cos * 0.12 - sin * 0.01;
        assert!(
            state[0].abs() < 1e-12 && (state[1] - 8.0).abs() < 1e-12 && (moment - 8.0 * centre).abs() < 1e-12
        );
    }
}
