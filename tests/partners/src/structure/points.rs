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
    /// Segments between points, if the points are the vertices of a boundary mesh: they then take forces, and
    /// stand for no volume.
    pub facets: Vec<usize>,
}

impl Points {
    /// A box of `counts[0] × counts[1] (× counts[2])` points `spacing` (m) apart, the first at `origin` (m),
    /// the first axis running fastest. A line of points is a box with counts of one. A point's volume is
    /// `spacing^D`.
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
        Self { dimension, positions, volume, density, facets: Vec::new() }
    }

    /// The outline of a box of `counts[0] × counts[1]` cells `spacing` (m) wide, its lower left corner at
    /// `origin` (m): a boundary mesh in the plane, its segments going round anticlockwise. The box's mass is
    /// spread over its points.
    pub fn on_outline(counts: [usize; 2], origin: &[f64], spacing: f64, density: f64) -> Self {
        let [nx, ny] = counts;
        let bottom = (0..nx).map(|i| [i, 0]);
        let right = (0..ny).map(|j| [nx, j]);
        let top = (0..nx).map(|i| [nx - i, ny]);
        let left = (0..ny).map(|j| [0, ny - j]);
        let vertices = bottom.chain(right).chain(top).chain(left);
        let at = |[i, j]: [usize; 2]| [origin[0] + spacing * i as f64, origin[1] + spacing * j as f64];
        let positions: Vec<f64> = vertices.flat_map(at).collect();
        let count = positions.len() / 2;
        let volume = spacing * spacing * (nx * ny) as f64 / count as f64;
        let facets = (0..count).flat_map(|i| [i, (i + 1) % count]).collect();
        Self { dimension: 2, positions, volume, density, facets }
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
        let mut force = vec![0.0; self.dimension];
        if !self.facets.is_empty() {
            let forces = inputs.get(force_name(name)).unwrap_or(&[]);
            forces.iter().enumerate().for_each(|(i, f)| force[i % self.dimension] += f);
            return force;
        }
        let gradient = inputs.get(name).unwrap_or(&[]);
        for value in gradient.chunks_exact(self.dimension) {
            for axis in 0..self.dimension {
                force[axis] -= self.volume * value[axis];
            }
        }
        force
    }

    /// A structure on these points: position and velocity given every window, volume and density once; the
    /// load taken.
    pub fn description(&self, solver: &str, load_required: bool, scalars: Vec<Scalar>) -> Description {
        let (d, n) = (self.dimension, Some(self.len()));
        let port = |name, quantity, direction| Port::new(name, quantity, d, n, direction);
        let mut ports = vec![
            port(names::POSITION, Quantity::Position, Direction::Out),
            port(names::VELOCITY, Quantity::Velocity, Direction::Out),
        ];
        let load = if self.facets.is_empty() {
            ports.push(port(names::REFERENCE_VOLUME, Quantity::ReferenceVolume, Direction::Out).constant());
            ports.push(port(names::DENSITY, Quantity::Density, Direction::Out).constant());
            port(names::PRESSURE_GRADIENT, Quantity::PressureGradient, Direction::In)
        } else {
            let facets = Some(self.facets.len() / d);
            ports.push(Port::new(names::FACETS, Quantity::Facet, d, facets, Direction::Out).constant());
            port(names::FORCE, Quantity::Force, Direction::In)
        };
        ports.push(if load_required { load } else { load.optional() });
        Description {
            role: Role::Structure,
            solver: solver.to_owned(),
            dimension: d,
            ports,
            scalars,
            saves: true,
            notes: vec![],
        }
    }

    /// The port of the load at a window's start.
    pub fn start_load(&self) -> Port {
        let (d, n) = (self.dimension, Some(self.len()));
        let quantity = if self.facets.is_empty() { Quantity::PressureGradient } else { Quantity::Force };
        let name = names::START_PRESSURE_GRADIENT;
        let name = if self.facets.is_empty() { name } else { force_name(name) };
        Port::new(name, quantity, d, n, Direction::In)
    }

    /// Writes volume and density, or facets.
    pub fn constants(&self, outputs: &mut Fields) {
        if !self.facets.is_empty() {
            let facets: Vec<f64> = self.facets.iter().map(|&vertex| vertex as f64).collect();
            write(outputs, names::FACETS, &facets);
            return;
        }
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

/// The port by which a boundary mesh takes what others take as this load.
fn force_name(load: &str) -> &str {
    match load {
        names::START_PRESSURE_GRADIENT => names::START_FORCE,
        _ => names::FORCE,
    }
}

/// Scalars of the components of a vector: `<name>_x` for balances, `<name>.x` for probes.
pub(crate) fn components(name: &str, unit: &str, kind: ScalarKind, dimension: usize) -> Vec<Scalar> {
    let separator = if kind == ScalarKind::Probe { '.' } else { '_' };
    let scalar = |axis| Scalar::new(format!("{name}{separator}{axis}"), unit, kind);
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

    #[test]
    fn an_outline_goes_round_anticlockwise() {
        let mesh = Points::on_outline([2, 1], &[1.0, 0.0], 0.5, 8.0);
        assert_eq!(mesh.positions, [1.0, 0.0, 1.5, 0.0, 2.0, 0.0, 2.0, 0.5, 1.5, 0.5, 1.0, 0.5]);
        assert_eq!(mesh.facets, [0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 0]);
        // 1 m × 0.5 m at 8 kg/m³, up to the sixth part of it six times.
        assert!((mesh.mass() - 4.0).abs() < 1e-14);
    }
}
