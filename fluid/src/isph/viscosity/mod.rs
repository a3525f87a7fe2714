//! Viscosity: laminar, sub-particle-scale (10) and between approaching particles, and the friction of no-slip
//! boundaries.
//!
//! The pairs of Monaghan and Gingold (1983) act along the line that joins them, `Σ ν (D + 2) w e e·(u_b −
//! u_a)`: no couple turns a pair that moves as a rigid body, and where pairs are missing the stress is: a
//! free surface is free of traction, and a wave loses `2νk²` of its height (Colagrossi et al. 2011), where
//! the Laplacian of each component leaves `∂u/∂n = 0` and takes half of it. For a flow without divergence
//! they are the Laplacian inside.
//!
//! Where `h²/16ν` is less than the step, the stage is implicit ([`ImplicitViscosity`]).

mod friction;
mod implicit;

pub use friction::{Body, Friction, frictions};
pub use implicit::{ImplicitViscosity, TOLERANCE};

use crate::isph::correction::second_derivative_correction;
use crate::isph::options::ViscousOperator;
use crate::particles::neighbourhood::{Neighbourhood, Pair};
use rayon::prelude::*;
use sph::{Matrix, Vector, tensor};

/// Steps longer than this times `h²/ν` are implicit. Explicit, the stiffest mode of a lattice would have
/// decayed to a quarter in such a step (its rate is at most 12.6 `ν/h²`), and is stable up to 2.5 times it.
const EXPLICIT: f64 = 1.0 / 16.0;

/// Steps of `h²/ν` that the corrected Laplacian, which is explicit always, is stable at.
const STABLE: f64 = 1.0 / 8.0;

/// Fields the viscous stage reads.
pub struct ViscousInput<'a, const D: usize> {
    /// Lists and gradients.
    pub neighbourhood: &'a Neighbourhood<D>,
    /// `B` of Eq. (5).
    pub corrections: &'a [(Matrix<D>, f64)],
    /// Positions (m).
    pub positions: &'a [Vector<D>],
    /// Velocities (m/s) at the step's start.
    pub velocities: &'a [Vector<D>],
    /// Viscosities.
    pub viscosity: Viscosity,
}

/// The fluid's viscosity, and how its pairs have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viscosity {
    /// Laminar kinematic viscosity (m²/s).
    pub laminar: f64,
    /// What is added between approaching particles (m²/s).
    pub artificial: f64,
    /// Smagorinsky constant of Eq. (10).
    pub smagorinsky: f64,
    /// Form of the pairs.
    pub operator: ViscousOperator,
    /// Smoothing length (m), the filter width of Eq. (10).
    pub smoothing_length: f64,
}

impl Viscosity {
    /// The longest step (s) that is explicit.
    fn longest_explicit(&self) -> f64 {
        EXPLICIT * self.smoothing_length.powi(2) / (self.laminar + self.artificial)
    }

    /// Whether a step of `dt` (s) has its viscosity implicit. The sub-particle-scale one does not count: `ν_t
    /// = (c_s h)² √(2 ε:ε)` with `c_s = 0.1` and rates of strain up to `2u/Δx` allows steps of `3 Δx/u`, ten
    /// times those of Eq. (49).
    pub fn is_implicit(&self, dt: f64) -> bool {
        self.operator != ViscousOperator::FatehiManzari && dt > self.longest_explicit()
    }

    /// The longest step (s) that viscosity bears.
    pub fn longest_step(&self) -> f64 {
        match self.operator {
            ViscousOperator::FatehiManzari => self.longest_explicit() * (STABLE / EXPLICIT),
            ViscousOperator::MonaghanGingold | ViscousOperator::Morris => f64::INFINITY,
        }
    }

    /// What a particle gets of a neighbour whose velocity differs by `jump` (m/s), over the factor of the
    /// pair ([`factors`]). The same with its sign turned, to the bit, for the neighbour.
    #[inline]
    fn between<const D: usize>(&self, pair: &Pair<D>, jump: &Vector<D>) -> Vector<D> {
        let stiffness = pair.stiffness();
        if self.operator == ViscousOperator::Morris {
            return jump * stiffness;
        }
        let gradient = pair.gradient();
        // At the kernel's edge both vanish.
        if stiffness > 0.0 { gradient * (gradient.dot(jump) / stiffness) } else { Vector::zeros() }
    }
}

/// Corrected velocity gradient of particle `a`, Eq. (2): entry (i, j) is `∂u_i/∂x_j` (1/s), over fluid
/// neighbours.
pub fn velocity_gradient<const D: usize>(input: &ViscousInput<'_, D>, a: usize) -> Matrix<D> {
    let list = &input.neighbourhood.fluid;
    let mut sum = Matrix::zeros();
    for (&b, pair) in list.of(a).iter().zip(&input.neighbourhood.fluid_pairs[list.range(a)]) {
        sum += tensor::outer(&(input.velocities[b as usize] - input.velocities[a]), &pair.gradient());
    }
    sum * input.corrections[a].0.transpose()
}

/// `ν_t = (c_s Δ)² √(2 ε:ε)`, Eq. (10), in m²/s.
pub fn eddy_viscosity<const D: usize>(gradient: &Matrix<D>, smagorinsky: f64, filter_width: f64) -> f64 {
    let strain = (gradient + gradient.transpose()) * 0.5;
    (smagorinsky * filter_width).powi(2) * (2.0 * strain.norm_squared()).sqrt()
}

/// What the pairs of each particle have for a factor, the mean of its own and the neighbour's: the viscosity
/// ν (m²/s), the sub-particle-scale one included, and in the pairs of Monaghan and Gingold `4 (D + 2) c ν`
/// (1/s), `c` (1/m²) being that of their weight `w = c r² stiffness`.
///
/// Any weight of the distance will do, if `½ Σ w x² = 1`. With the Laplacian's own, `w = stiffness`, a shear
/// along the axes of a lattice of h = 1.2 Δx meets 0.80 of the viscosity; with `r² stiffness` 0.975 in two
/// dimensions and 1.009 in three. `c = Σ stiffness r²/Σ stiffness r⁴` makes `Σ w r²` what it is for the
/// Laplacian, however particles lie and however many are missing; with that of the lattice, vortices lose a
/// tenth too much at any resolution once they have drawn particles into rows.
pub fn factors<const D: usize>(input: &ViscousInput<'_, D>, out: &mut Vec<f64>) {
    let Viscosity { laminar, smagorinsky, smoothing_length, operator, .. } = input.viscosity;
    out.resize(input.velocities.len(), 0.0);
    out.par_iter_mut().with_min_len(128).enumerate().for_each(|(a, factor)| {
        *factor = laminar;
        if smagorinsky > 0.0 {
            *factor += eddy_viscosity(&velocity_gradient(input, a), smagorinsky, smoothing_length);
        }
        if operator == ViscousOperator::MonaghanGingold {
            *factor *= 4.0 * (D as f64 + 2.0) * weight_factor(input.neighbourhood, a);
        }
    });
}

/// `c = Σ stiffness r²/Σ stiffness r⁴` (1/m²) of particle `a`; nothing where it has no neighbours.
fn weight_factor<const D: usize>(neighbourhood: &Neighbourhood<D>, a: usize) -> f64 {
    let (mut second, mut fourth) = (0.0, 0.0);
    for pair in &neighbourhood.fluid_pairs[neighbourhood.fluid.range(a)] {
        let stiffness = pair.stiffness();
        if stiffness > 0.0 {
            // V ∇W = stiffness r/2.
            let squared = 4.0 * pair.gradient().norm_squared() / (stiffness * stiffness);
            second += stiffness * squared;
            fourth += stiffness * squared * squared;
        }
    }
    if fourth > 0.0 { second / fourth } else { 0.0 }
}

/// Accelerations (m/s²) among fluid particles with these [`factors`] and the velocities that they have.
pub fn accelerations<const D: usize>(input: &ViscousInput<'_, D>, factors: &[f64], out: &mut Vec<Vector<D>>) {
    let fitted = input.viscosity.operator == ViscousOperator::FatehiManzari;
    out.resize(input.velocities.len(), Vector::zeros());
    out.par_iter_mut().with_min_len(128).enumerate().for_each(|(a, acceleration)| {
        let pairs = of_pairs(input, factors, a, |b| input.velocities[b]);
        *acceleration = if fitted { pairs + fitted_laplacian(input, factors, a) } else { pairs };
    });
}

/// What the pairs of particle `a` give it (m/s²) where the particles have these velocities (m/s); what
/// approaches is held back as a whole, not along the line that joins it alone. Of the corrected Laplacian no
/// more than that.
#[inline]
fn of_pairs<const D: usize>(
    input: &ViscousInput<'_, D>,
    factors: &[f64],
    a: usize,
    velocity: impl Fn(usize) -> Vector<D>,
) -> Vector<D> {
    let (list, viscosity) = (&input.neighbourhood.fluid, &input.viscosity);
    let fitted = viscosity.operator == ViscousOperator::FatehiManzari;
    let own = velocity(a);
    let mut sum = Vector::zeros();
    for (&b, pair) in list.of(a).iter().zip(&input.neighbourhood.fluid_pairs[list.range(a)]) {
        let b = b as usize;
        let jump = velocity(b) - own;
        if !fitted {
            sum += viscosity.between(pair, &jump) * (0.5 * (factors[a] + factors[b]));
        }
        let approaching = || (input.velocities[b] - input.velocities[a]).dot(&pair.gradient()) < 0.0;
        if viscosity.artificial > 0.0 && approaching() {
            sum += jump * (viscosity.artificial * pair.stiffness());
        }
    }
    sum
}

/// Eq. (13), the corrected Laplacian (4), (6), (7): `B̂ : Σ 2V e ∇W ν_ab ((u_a − u_b)/|r_ab| − e·∇u)`.
///
/// Deviation: Eq. (13) as printed carries `μ_ab = ρ_a ν_a + ρ_b ν_b` without the mean's half against the 2 of
/// Eq. (4); here `ν_ab` is the mean and the 2 stands.
fn fitted_laplacian<const D: usize>(input: &ViscousInput<'_, D>, factors: &[f64], a: usize) -> Vector<D> {
    let list = &input.neighbourhood.fluid;
    let pairs = &input.neighbourhood.fluid_pairs[list.range(a)];
    let around = || {
        list.of(a).iter().zip(pairs).map(|(&b, pair)| {
            let r = input.neighbourhood.period.nearest(input.positions[a] - input.positions[b as usize]);
            (b as usize, r, pair)
        })
    };
    let gradients = around().map(|(_, r, pair)| (r, pair.gradient()));
    let Some(b_hat) = second_derivative_correction(&gradients, &input.corrections[a].0) else {
        let simple = around().map(|(b, _, pair)| {
            (input.velocities[b] - input.velocities[a]) * (0.5 * (factors[a] + factors[b]) * pair.stiffness())
        });
        return simple.fold(Vector::zeros(), |sum, term| sum + term);
    };
    let gradient = velocity_gradient(input, a);
    let mut sum = Vector::zeros();
    for (b, r, pair) in around() {
        let distance = r.norm();
        let e = r / distance;
        let nu = 0.5 * (factors[a] + factors[b]);
        let weight = 2.0 * nu * e.dot(&(b_hat * pair.gradient()));
        let jump = (input.velocities[a] - input.velocities[b]) / distance - gradient * e;
        sum += jump * weight;
    }
    sum
}
