//! What is read of a structure while it moves.

use crate::bodies::point::MaterialPoint;
use crate::particles::Particles;
use crate::state::State;
use sph::Vector;
use std::ops::Range;

/// One vector read from a state, or from the load that led to it.
pub enum Reading<const D: usize> {
    /// Displacement (m) of a point of the material.
    Displacement(MaterialPoint<D>),
    /// Position (m) of a point of the material.
    Position(MaterialPoint<D>),
    /// Velocity (m/s) of a point of the material.
    Velocity(MaterialPoint<D>),
    /// Force (N) of the fluid on the particles of a body.
    Force(Range<usize>),
}

impl<const D: usize> Reading<D> {
    /// The value in a state under the pressure gradient `load` (Pa/m) at the interface particles.
    pub fn value(&self, particles: &Particles<D>, state: &State<D>, load: &[Vector<D>]) -> Vector<D> {
        match self {
            Self::Displacement(point) => point.value(&state.positions) - point.reference,
            Self::Position(point) => point.value(&state.positions),
            Self::Velocity(point) => point.value(&state.velocities),
            Self::Force(body) => fluid_force(particles, body, load),
        }
    }
}

fn fluid_force<const D: usize>(
    particles: &Particles<D>,
    body: &Range<usize>,
    load: &[Vector<D>],
) -> Vector<D> {
    let loaded = particles.interface.iter().map(|&particle| particle as usize).zip(load);
    loaded
        .filter(|(particle, _)| body.contains(particle))
        .fold(Vector::zeros(), |sum, (particle, gradient)| sum - gradient * particles.volumes[particle])
}
