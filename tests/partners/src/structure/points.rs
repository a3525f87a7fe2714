//! The interface points of a mock structure, and what all mock structures do with them.

use crate::stand_in::write;
use interfaces::port::names;
use interfaces::{Description, Direction, Fields, Port, Quantity, Role, Scalar, ScalarKind};

/// Points on a lattice, all of one volume and one density.
#[derive(Clone, Debug, PartialEq)]
pub struct Points {
    /// Space dimension `D`, 2 or 3.
    pub dimension: usize,
    /// Positions in the reference configuration (m), `n × D`.
    pub positions: Vec<f64>,
    /// Reference volume of a point (m³; in two dimensions for one metre of depth).
    pub volume: f64,
    /// Density (kg/m³).
    pub density: f64,
}

impl Points {
    /// A box of `counts[0] × counts[1] (× counts[2])` points `spacing` (m) apart, the first at `origin` (m), the first axis running fastest.
    /// A line of points is a box with counts of one. A point's volume is `spacing^D`.
    pub fn on_lattice(counts: &[usize], origin: &[f64], spacing: f64, density: f64) -> Self {
        let dimension = counts.len();
        assert_eq!(dimension, origin.len(), "counts and origin are of one dimension");
        let n: usize = counts.iter().product();
        let mut positions = Vec::with_capacity(n * dimension);
        for point in 0..n {
            let mut rest = point;
            for axis in 0..dimension {
                positions.push(origin[axis] + spacing * (rest % counts[axis]) as f64);
                rest /= counts[axis];
            }
        }
        let volume = spacing.powi(i32::try_from(dimension).expect("2 or 3"));
        Self { dimension, positions, volume, density }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.positions.len() / self.dimension
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Mass of all points, `Σ ρ V` (kg).
    pub fn mass(&self) -> f64 {
        self.density * self.volume * self.len() as f64
    }

    /// Force on all points `−Σ V ∇p` (N), `D` components, of the load that the field `name` is.
    pub fn force(&self, inputs: &Fields, name: &str) -> Vec<f64> {
        let gradient = inputs.get(name).unwrap_or(&[]);
        let mut force = vec![0.0; self.dimension];
        for value in gradient.chunks_exact(self.dimension) {
            for axis in 0..self.dimension {
                force[axis] -= self.volume * value[axis];
            }
        }
        force
    }

    /// A structure on these points: position and velocity given every window, volume and density once; the load taken.
    pub fn description(&self, solver: &str, load_required: bool, scalars: Vec<Scalar>) -> Description {
        let (d, n) = (self.dimension, Some(self.len()));
        let load = Port::new(names::PRESSURE_GRADIENT, Quantity::PressureGradient, d, n, Direction::In);
        Description {
            role: Role::Structure,
            solver: solver.to_owned(),
            dimension: d,
            ports: vec![
                Port::new(names::POSITION, Quantity::Position, d, n, Direction::Out),
                Port::new(names::VELOCITY, Quantity::Velocity, d, n, Direction::Out),
                Port::new(names::REFERENCE_VOLUME, Quantity::ReferenceVolume, d, n, Direction::Out)
                    .constant(),
                Port::new(names::DENSITY, Quantity::Density, d, n, Direction::Out).constant(),
                if load_required { load } else { load.optional() },
            ],
            scalars,
        }
    }

    /// The port of the load at a window's start.
    pub fn start_load(&self) -> Port {
        let (d, n) = (self.dimension, Some(self.len()));
        Port::new(names::START_PRESSURE_GRADIENT, Quantity::PressureGradient, d, n, Direction::In)
    }

    /// Writes volume and density.
    pub fn constants(&self, outputs: &mut Fields) {
        write(outputs, names::REFERENCE_VOLUME, &vec![self.volume; self.len()]);
        write(outputs, names::DENSITY, &vec![self.density; self.len()]);
    }

    /// Writes the reference positions moved by `displacement` (m), and one velocity (m/s) for all.
    pub fn translated(&self, displacement: &[f64], velocity: &[f64], outputs: &mut Fields) {
        let d = self.dimension;
        let moved = self.positions.iter().enumerate().map(|(i, x)| x + displacement[i % d]);
        let moved: Vec<f64> = moved.collect();
        write(outputs, names::POSITION, &moved);
        write(outputs, names::VELOCITY, &velocity.repeat(self.len()));
    }
}

/// Scalars of the components of a vector: `<name>_x` for balances, `<name>.x` for probes.
pub(crate) fn components(name: &str, unit: &str, kind: ScalarKind, dimension: usize) -> Vec<Scalar> {
    let separator = if kind == ScalarKind::Probe { '.' } else { '_' };
    let scalar = |axis| Scalar { name: format!("{name}{separator}{axis}"), unit: unit.to_owned(), kind };
    ["x", "y", "z"][..dimension].iter().map(scalar).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_axis_runs_fastest() {
        let points = Points::on_lattice(&[2, 2], &[1.0, 2.0], 0.5, 10.0);
        assert_eq!(points.positions, [1.0, 2.0, 1.5, 2.0, 1.0, 2.5, 1.5, 2.5]);
        // Four points of 0.25 m³ at 10 kg/m³.
        assert_eq!((points.len(), points.mass()), (4, 10.0));
    }
}
