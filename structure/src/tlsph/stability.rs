//! The stable step from the operator itself: its largest frequency by Lanczos iteration, at rest and again as
//! the structure is strained.

use crate::bodies::Body;
use crate::lanes::{Lanes, Tensor};
use crate::options::Options;
use crate::state::{Stability, State};
use crate::tlsph::field::Field;
use crate::tlsph::kernels;
use crate::tlsph::total_lagrangian::TotalLagrangian;
use sph::Vector;

/// Fourth-order Runge–Kutta is stable on the imaginary axis up to `ω Δt = 2√2` (Hairer and Wanner 1996,
/// §IV.2).
const RUNGE_KUTTA_LIMIT: f64 = 2.0 * std::f64::consts::SQRT_2;

/// The limit is found anew where the largest strain has changed by this since it was found. For St. Venant
/// and Kirchhoff's law the frequency rises by 1.5 times the strain, 3 % of the 10 % that
/// [`SAFETY`](crate::options::SAFETY) leaves.
const STRAIN_CHANGE: f64 = 0.02;

/// Lanczos vectors. The largest Ritz value is then within 1e-3 of the eigenvalue on lattices of 10² to 10⁵
/// particles.
const ITERATIONS: usize = 40;

/// Largest further displacement (fraction of the spacing) of the finite difference that stands for the
/// linearised operator.
const PROBE: f64 = 1e-5;

impl<const D: usize> TotalLagrangian<D> {
    /// The stable step (s) at rest in the reference configuration:
    /// [`step_fraction`](Options::step_fraction) times `2√2/ω_max`; with damping `c` the limit on the
    /// real axis, `2.78/c`, is kept too. That of a strained structure is [`State::stability`].
    pub fn stable_time_step(&self) -> f64 {
        self.stable_time_step
    }

    /// The stable step of a state whose displacements and their gradients are in the fields: the one `known`,
    /// unless the strain has changed much since that was found.
    pub(super) fn stability(&mut self, state: &State<D>, known: Stability) -> Stability {
        let strain = self.largest_strain();
        if (strain - known.strain).abs() < STRAIN_CHANGE {
            return known;
        }
        let displacements = self.particles.displacements(&state.positions);
        let omega = self.largest_frequency(&displacements);
        Stability { strain, step: self.stable_step(omega) }
    }

    /// The largest component of the Green–Lagrange strain `½ (L + Lᵀ + Lᵀ L)` in magnitude.
    fn largest_strain(&self) -> f64 {
        let mut largest = 0.0_f64;
        kernels::visit_gradients::<D>(
            self.particles.setup.options.gradient,
            &self.stencil,
            &self.fields,
            |_, l: &Tensor<D>, _| {
                for i in 0..D {
                    for j in i..D {
                        let square = (0..D).fold(Lanes::ZERO, |sum, k| sum + l[k][i] * l[k][j]);
                        let strain = (l[i][j] + l[j][i] + square) * 0.5;
                        largest = strain.0.iter().fold(largest, |most, e| most.max(e.abs()));
                    }
                }
            },
        );
        largest
    }

    /// The stable step (s) of a structure with this largest frequency (rad/s).
    pub(super) fn stable_step(&self, omega: f64) -> f64 {
        let Options { step_fraction, damping, .. } = self.particles.setup.options;
        let step = step_fraction * RUNGE_KUTTA_LIMIT / omega;
        if damping > 0.0 { step.min(step_fraction * 2.78 / damping) } else { step }
    }

    /// The largest angular frequency `ω_max` (rad/s) of the structure linearised about displacements `U` (m)
    /// without contact, which adds little to it (`contact`): Lanczos on `−∂a/∂x`, which for laws with a
    /// potential is symmetric in the product weighted with the masses; with `y = √m v` in the usual one.
    pub(super) fn largest_frequency(&mut self, displacements: &[Vector<D>]) -> f64 {
        let spacing = self.particles.setup.bodies.iter().map(Body::spacing).fold(f64::INFINITY, f64::min);
        let amplitude = PROBE * spacing;
        let free: Vec<Free<D>> = self
            .numbering
            .pairs()
            .filter(|&(user, _)| !self.particles.clamped[user])
            .map(|(user, internal)| Free {
                internal,
                root_mass: self.particles.masses[user].sqrt(),
                displacement: displacements[user],
            })
            .collect();
        let mut fixed = Vec::new();
        for &user in self.particles.setup.motions.iter().flat_map(|moving| &moving.particles) {
            fixed.push((self.numbering.internal_of[user] as usize, displacements[user]));
        }
        let count = free.len() * D;
        let mut scratch = Field::new(D, self.stencil.margin, self.numbering.count());
        let mut v = rough_start(count);
        let mut previous = vec![0.0; count];
        let (mut diagonal, mut off_diagonal) = (Vec::new(), Vec::new());
        let mut beta = 0.0;
        for _ in 0..ITERATIONS.min(count) {
            let mut w = self.stiffness_times(&v, (&free, &fixed), amplitude, &mut scratch);
            let alpha = dot(&v, &w);
            for i in 0..count {
                w[i] -= alpha * v[i] + beta * previous[i];
            }
            diagonal.push(alpha);
            beta = dot(&w, &w).sqrt();
            if beta <= 1e-9 * alpha.abs() {
                break;
            }
            off_diagonal.push(beta);
            w.iter_mut().for_each(|x| *x /= beta);
            previous = std::mem::replace(&mut v, w);
        }
        let size = diagonal.len();
        let matrix = nalgebra::DMatrix::from_fn(size, size, |i, j| match i.abs_diff(j) {
            0 => diagonal[i],
            1 => off_diagonal[i.min(j)],
            _ => 0.0,
        });
        matrix.symmetric_eigenvalues().max().max(f64::MIN_POSITIVE).sqrt()
    }

    /// `√m (−∂a/∂x) v/√m` by central differences, fixed particles that have moved at their displacements.
    fn stiffness_times(
        &mut self,
        v: &[f64],
        (free, fixed): (&[Free<D>], &[(usize, Vector<D>)]),
        amplitude: f64,
        scratch: &mut Field,
    ) -> Vec<f64> {
        let further = |n: usize| Vector::<D>::from_fn(|i, _| v[n * D + i] / free[n].root_mass);
        let largest = (0..free.len()).map(|n| further(n).amax()).fold(0.0, f64::max);
        let step = amplitude / largest.max(f64::MIN_POSITIVE);
        let mut out = vec![0.0; v.len()];
        for sign in [1.0, -1.0] {
            self.fields.displacement.clear();
            for (internal, displacement) in fixed {
                self.fields.displacement.set_vector(*internal, displacement);
            }
            for (n, particle) in free.iter().enumerate() {
                let moved = particle.displacement + further(n) * (sign * step);
                self.fields.displacement.set_vector(particle.internal, &moved);
            }
            self.stresses();
            self.accelerations(scratch);
            for (n, particle) in free.iter().enumerate() {
                let a = scratch.vector::<D>(particle.internal);
                for i in 0..D {
                    out[n * D + i] -= sign * a[i] * particle.root_mass / (2.0 * step);
                }
            }
        }
        self.fields.displacement.clear();
        out
    }
}

/// A particle that is not fixed.
struct Free<const D: usize> {
    internal: usize,
    root_mass: f64,
    displacement: Vector<D>,
}

/// A unit vector with all frequencies in it, the same at every run.
fn rough_start(count: usize) -> Vec<f64> {
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut v: Vec<f64> = (0..count)
        .map(|_| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as f64 / (1u64 << 30) as f64 - 1.0
        })
        .collect();
    let norm = dot(&v, &v).sqrt();
    v.iter_mut().for_each(|x| *x /= norm);
    v
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    sph::parallel::sum(a.len(), |i| a[i] * b[i])
}
