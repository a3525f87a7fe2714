//! What a fluid is and where.

use sph::Vector;

/// What a fluid is and where.
#[derive(Clone, Debug, PartialEq)]
pub struct FluidProperties<const D: usize> {
    /// Density ρ (kg/m³).
    pub density: f64,
    /// Laminar kinematic viscosity ν (m²/s).
    pub kinematic_viscosity: f64,
    /// Gravity (m/s²).
    pub gravity: Vector<D>,
    /// Particle spacing Δx (m).
    pub spacing: f64,
    /// Volume of each particle (m³).
    pub particle_volume: f64,
    /// The domain's lowest and highest corner (m): particles outside have left.
    pub domain: (Vector<D>, Vector<D>),
    /// Axes along which the domain repeats.
    pub periodic: [bool; D],
}

impl<const D: usize> FluidProperties<D> {
    /// Mass of a particle (kg).
    pub fn particle_mass(&self) -> f64 {
        self.density * self.particle_volume
    }
}
