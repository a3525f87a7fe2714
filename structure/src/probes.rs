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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::Body;
    use crate::materials::{Law, Material, Plane};
    use crate::setup::Setup;
    use crate::solid::Solid;
    use crate::tlsph::total_lagrangian::TotalLagrangian;
    use words::motion::Law as Course;
    use words::probe::ProbeQuantity;

    type V = Vector<2>;

    const SPACING: f64 = 0.1;

    fn block() -> TotalLagrangian<2> {
        let material = Material::new(Law::StVenantKirchhoff, 1e6, 0.3, Plane::Strain);
        let body = Body::block(V::zeros(), V::from([1.0, 0.5]), SPACING, material, 1000.0);
        TotalLagrangian::new(Setup::new(vec![body])).unwrap()
    }

    /// A quarter turn about the point (0.3, 0.1).
    fn quarter() -> Motion<2> {
        let table = vec![[0.0, 0.0], [1.0, std::f64::consts::FRAC_PI_2]];
        Motion::Rotation { pivot: [0.3, 0.1], law: Course::Table { table } }
    }

    fn read(of: What<2>, frame: Option<Motion<2>>, seen: &Seen<'_, 2>) -> Vec<f64> {
        let mut values = Vec::new();
        Reading { of, frame }.push(seen, ProbeQuantity::places(2), &mut values);
        values
    }

    fn near(found: &[f64], expected: &[f64], tolerance: f64) {
        assert_eq!(found.len(), expected.len());
        let close = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
        assert!(close, "{found:?} and not {expected:?}");
    }

    /// A block under `x = F X`: `E = (FᵀF − 1)/2`, `S = λ tr E 1 + 2 μ E` with `E_zz = 0`, `σ = F S Fᵀ/J`, by
    /// hand, at a corner as inside. The operators reproduce linear fields to round-off.
    #[test]
    fn stress_and_strain_of_a_homogeneous_deformation_by_hand() {
        let mut solid = block();
        let f = Matrix::<2>::new(1.2, 0.1, -0.05, 0.9);
        let mut state = solid.state_at_rest(1.0);
        for (x, at) in state.positions.iter_mut().zip(&solid.particles().reference_positions) {
            *x = f * at;
        }
        let mut derived = Derived::default();
        solid.derive(&state, &mut derived).unwrap();
        let (mu, lambda) = (1e6 / 2.6, 1e6 * 0.3 / (1.3 * 0.4));
        let e = (f.transpose() * f - Matrix::<2>::identity()) * 0.5;
        let s = Matrix::<2>::identity() * (lambda * e.trace()) + e * (2.0 * mu);
        let sigma = f * s * f.transpose() / f.determinant();
        let out = lambda * e.trace() / f.determinant();
        let (x, y) = (sigma[(0, 0)], sigma[(1, 1)]);
        let squares = (x - y).powi(2) + (y - out).powi(2) + (out - x).powi(2);
        let von_mises = (0.5 * squares + 3.0 * sigma[(0, 1)].powi(2)).sqrt();
        let seen = Seen { particles: solid.particles(), state: &state, derived: &derived, load: &[] };
        for at in [[1.0, 0.5], [0.42, 0.21]].map(V::from) {
            let point = MaterialPoint::new(at, &seen.particles.reference_positions, SPACING).unwrap();
            let strain = read(What::Strain(point.clone()), None, &seen);
            near(&strain, &[e[(0, 0)], e[(1, 1)], e[(0, 1)]], 1e-12);
            let stress = read(What::Stress(point.clone()), None, &seen);
            near(&stress, &[x, y, sigma[(0, 1)]], 1e-6);
            // Seen by who has made a quarter turn, what was along y is along x.
            let turned = read(What::Stress(point.clone()), Some(quarter()), &seen);
            near(&turned, &[y, x, -sigma[(0, 1)]], 1e-6);
            near(&read(What::VonMisesStress(point), None, &seen), &[von_mises], 1e-6);
        }
    }

    /// 3 N upwards and 1 N to the left at one particle, by hand; the forces of all under a load that is the
    /// same everywhere act at the middle.
    #[test]
    fn moments_by_hand() {
        let solid = block();
        let state = solid.state_at_rest(1.0);
        let particles = solid.particles();
        let volume = SPACING * SPACING;
        let mut load = vec![V::zeros(); particles.interface.len()];
        load[7] = -V::from([-1.0, 3.0]) / volume;
        let at = particles.reference_positions[7];
        let body = 0..particles.len();
        let about = V::from([2.0, -1.0]);
        let arm = at - about;
        let expected = arm.x * 3.0 + arm.y;
        let derived = Derived::default();
        let seen = Seen { particles, state: &state, derived: &derived, load: &load };
        near(&read(What::Moment(body.clone(), about), None, &seen), &[expected], 1e-12);
        // The point goes along with the frame: from (2, −1) by a quarter turn about (0.3, 0.1) to (1.4, 1.8).
        let arm = at - V::from([1.4, 1.8]);
        let expected = arm.x * 3.0 + arm.y;
        near(&read(What::Moment(body.clone(), about), Some(quarter()), &seen), &[expected], 1e-12);
        let load = vec![V::from([0.0, -4.0]); particles.interface.len()];
        let seen = Seen { load: &load, ..seen };
        near(&read(What::Force(body.clone()), None, &seen), &[0.0, 2.0], 1e-12);
        near(&read(What::Moment(body.clone(), V::from([0.5, 0.25])), None, &seen), &[0.0], 1e-12);
        near(&read(What::Moment(body, V::zeros()), None, &seen), &[1.0], 1e-12);
    }
}
