//! What is read of a structure while it moves.

use crate::bodies::point::MaterialPoint;
use crate::particles::Particles;
use crate::state::State;
use sph::Vector;
use std::ops::Range;
use words::rigid::Motion;

/// One vector read from a state, or from the load that led to it.
pub struct Reading<const D: usize> {
    /// What is read.
    pub of: What<D>,
    /// The frame that it is read in, along the axes that turn with it; none is the one at rest.
    pub frame: Option<Motion<D>>,
}

/// What is read.
pub enum What<const D: usize> {
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
        let pose = self.frame.as_ref().map(|frame| frame.pose(state.time));
        let position = |point: &MaterialPoint<D>| {
            let at = point.value(&state.positions);
            pose.map_or(at, |pose| pose.at_rest(&at))
        };
        let turned_back = |vector: Vector<D>| pose.map_or(vector, |pose| pose.turned_back(&vector));
        match &self.of {
            What::Displacement(point) => position(point) - point.reference,
            What::Position(point) => position(point),
            What::Velocity(point) => {
                let velocity = point.value(&state.velocities);
                let of_frame = self.frame.as_ref().map(|frame| frame.twist(state.time));
                let of_frame = of_frame.map(|twist| twist.at(&point.value(&state.positions)));
                turned_back(of_frame.map_or(velocity, |own| velocity - own))
            }
            What::Force(body) => turned_back(fluid_force(particles, body, load)),
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
