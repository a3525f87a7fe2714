//! What all mock fluids give, and the ports they need for it.

use crate::stand_in::write;
use interfaces::port::names;
use interfaces::{Description, Direction, Fields, Port, Quantity, Role, Scalar};

/// The load as a mock fluid gives it.
#[derive(Clone, Debug)]
pub struct Load {
    /// Space dimension `D`, 2 or 3.
    pub dimension: usize,
    /// What the fluid says it received, as a multiple of what it gives: 1 fulfils condition (46), anything
    /// else leaves the coupler a residual to find.
    pub reaction_factor: f64,
    /// Reference volume of the partner's points (m³), taken at initialisation.
    pub volumes: Vec<f64>,
}

impl Load {
    /// A load that fulfils condition (46).
    pub fn new(dimension: usize) -> Self {
        Self { dimension, reaction_factor: 1.0, volumes: Vec::new() }
    }

    /// Ports of a mock fluid. It takes as many points as its partner has; what `required` names it cannot do
    /// without.
    pub fn description(&self, solver: &str, required: &[&str], scalars: Vec<Scalar>) -> Description {
        let d = self.dimension;
        let taken = |name: &str, quantity| {
            let port = Port::new(name, quantity, d, None, Direction::In);
            if required.contains(&name) { port } else { port.optional() }
        };
        let given = |name: &str, quantity| Port::new(name, quantity, d, None, Direction::Out);
        Description {
            role: Role::Fluid,
            solver: solver.to_owned(),
            dimension: d,
            ports: vec![
                taken(names::POSITION, Quantity::Position),
                taken(names::VELOCITY, Quantity::Velocity),
                taken(names::REFERENCE_VOLUME, Quantity::ReferenceVolume).constant(),
                taken(names::DENSITY, Quantity::Density).constant(),
                taken(names::HELD_PRESSURE_GRADIENT, Quantity::PressureGradient),
                given(names::PRESSURE_GRADIENT, Quantity::PressureGradient),
                given(names::PRESSURE, Quantity::Pressure),
                given(names::PAIR_REACTION, Quantity::PairReaction),
                given(names::NORMAL, Quantity::Normal),
            ],
            scalars,
            saves: true,
            notes: vec![],
        }
    }

    /// Keeps the partner's reference volumes.
    pub fn take_volumes(&mut self, inputs: &Fields) {
        self.volumes = inputs.get(names::REFERENCE_VOLUME).unwrap_or(&[]).to_vec();
    }

    /// Writes pressure gradient (Pa/m, `n × D`), pressure (Pa, `n`), reaction and normal. The load pushes
    /// against the normal out of the structure, so the normal is the direction of the gradient, and zero
    /// where there is none.
    pub fn write(&self, gradient: &[f64], pressure: &[f64], outputs: &mut Fields) {
        let normals: Vec<f64> = gradient
            .chunks_exact(self.dimension)
            .flat_map(|g| {
                let length = g.iter().map(|x| x * x).sum::<f64>().sqrt();
                g.iter().map(move |x| if length > 0.0 { x / length } else { 0.0 })
            })
            .collect();
        let reaction: Vec<f64> = gradient.iter().map(|x| self.reaction_factor * x).collect();
        write(outputs, names::PRESSURE_GRADIENT, gradient);
        write(outputs, names::PRESSURE, pressure);
        write(outputs, names::PAIR_REACTION, &reaction);
        write(outputs, names::NORMAL, &normals);
    }

    /// Force on the structure `−Σ V ∇p` (N), `D` components; zero where the partner gave no volumes.
    pub fn force(&self, gradient: &[f64]) -> Vec<f64> {
        let mut force = vec![0.0; self.dimension];
        for (g, volume) in gradient.chunks_exact(self.dimension).zip(&self.volumes) {
            for axis in 0..self.dimension {
                force[axis] -= volume * g[axis];
            }
        }
        force
    }
}
