//! What is read of a structure while it moves.

use crate::bodies::point::MaterialPoint;
use crate::particles::Particles;
use crate::state::{Derived, State};
use sph::{Matrix, Vector};
use std::ops::Range;
use words::rigid::Motion;

/// What is read from a state, or from the load that led to it.
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
    /// Cauchy stress (Pa) at a point of the material.
    Stress(MaterialPoint<D>),
    /// Green–Lagrange strain at a point of the material, along the axes of the reference configuration.
    Strain(MaterialPoint<D>),
    /// Von Mises stress (Pa) at a point of the material.
    VonMisesStress(MaterialPoint<D>),
    /// Force (N) of the fluid on the particles of a body.
    Force(Range<usize>),
    /// Moment (N m) of that force about a point (m), which goes along with the frame.
    Moment(Range<usize>, Vector<D>),
}

impl<const D: usize> What<D> {
    /// Whether it is read from stresses or deformation gradients.
    pub fn is_derived(&self) -> bool {
        matches!(self, Self::Stress(_) | Self::Strain(_) | Self::VonMisesStress(_))
    }
}

/// A state and what led to it.
pub struct Seen<'a, const D: usize> {
    /// The particles.
    pub particles: &'a Particles<D>,
    /// The state.
    pub state: &'a State<D>,
    /// Stresses and deformation gradients in it; read only where any reading asks for them.
    pub derived: &'a Derived<D>,
    /// Pressure gradient (Pa/m) at the interface particles.
    pub load: &'a [Vector<D>],
}

impl<const D: usize> Reading<D> {
    /// Adds its components: of vectors along the axes, of symmetric tensors at `places`, of a moment that
    /// about the third axis in two dimensions.
    pub fn push(&self, seen: &Seen<'_, D>, places: &[(usize, usize)], values: &mut Vec<f64>) {
        let Seen { particles, state, derived, load } = *seen;
        let pose = self.frame.as_ref().map(|frame| frame.pose(state.time));
        let position = |point: &MaterialPoint<D>| {
            let at = point.value(&state.positions);
            pose.map_or(at, |pose| pose.at_rest(&at))
        };
        let turned_back = |vector: Vector<D>| pose.map_or(vector, |pose| pose.turned_back(&vector));
        let mut push_tensor = |tensor: Matrix<D>| values.extend(places.iter().map(|&at| tensor[at]));
        let vector = match &self.of {
            What::Displacement(point) => position(point) - point.reference,
            What::Position(point) => position(point),
            What::Velocity(point) => {
                let velocity = point.value(&state.velocities);
                let of_frame = self.frame.as_ref().map(|frame| frame.twist(state.time));
                let of_frame = of_frame.map(|twist| twist.at(&point.value(&state.positions)));
                turned_back(of_frame.map_or(velocity, |own| velocity - own))
            }
            What::Stress(point) => {
                let stress = point.tensor(&derived.cauchy_stress);
                // Qᵀ σ Q: its columns turned back, then its rows.
                let columns = |tensor: Matrix<D>| {
                    let turned: [Vector<D>; D] =
                        std::array::from_fn(|j| turned_back(tensor.column(j).into_owned()));
                    Matrix::<D>::from_fn(|i, j| turned[j][i])
                };
                push_tensor(columns(columns(stress).transpose()));
                return;
            }
            What::Strain(point) => {
                let f = point.tensor(&derived.deformation_gradient);
                push_tensor((f.transpose() * f - Matrix::<D>::identity()) * 0.5);
                return;
            }
            What::VonMisesStress(point) => {
                values.push(point.scalar(&derived.von_mises));
                return;
            }
            What::Force(body) => turned_back(
                forces(particles, body, load).fold(Vector::zeros(), |sum, (_, force)| sum + force),
            ),
            What::Moment(body, about) => {
                let about = pose.map_or(*about, |pose| pose.moved(about));
                // Components along axes that have turned: those of arm and force, turned back.
                let moment = forces(particles, body, load).fold([0.0; 3], |sum, (particle, force)| {
                    let arm = turned_back(state.positions[particle] - about);
                    let moment = moment(&arm, &turned_back(force));
                    std::array::from_fn(|i| sum[i] + moment[i])
                });
                values.extend(if D == 2 { &moment[2..] } else { &moment[..] });
                return;
            }
        };
        values.extend(vector.iter());
    }
}

/// Forces (N) of the fluid on the particles of a body.
fn forces<const D: usize>(
    particles: &Particles<D>,
    body: &Range<usize>,
    load: &[Vector<D>],
) -> impl Iterator<Item = (usize, Vector<D>)> {
    let loaded = particles.interface.iter().map(|&particle| particle as usize).zip(load);
    let of_body = loaded.filter(|(particle, _)| body.contains(particle));
    of_body.map(|(particle, gradient)| (particle, -gradient * particles.volumes[particle]))
}

/// Moment (N m) of a force (N) at the end of an arm (m).
fn moment<const D: usize>(arm: &Vector<D>, force: &Vector<D>) -> [f64; 3] {
    let of = |i: usize, j: usize| arm[i] * force[j] - arm[j] * force[i];
    if D == 2 { [0.0, 0.0, of(0, 1)] } else { [of(1, 2), of(2, 0), of(0, 1)] }
}
