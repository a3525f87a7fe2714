//! Viscous accelerations: laminar, sub-particle-scale (10) and between approaching particles.
//!
//! Both operators are Laplacians of each component, among fluid particles: at a free surface they leave
//! `∂u/∂n = 0`, not a stress of zero. Where the surface's own dissipation counts, it is too small: a standing
//! wave on a very viscous oil (ν = 1e-2 m²/s, H = 1 m, λ = 2 m, 20 and 40 particles in depth) loses height by
//! 0.07 to 0.10 1/s more than water does, about the `νk²` = 0.10 1/s of `∂u/∂n = 0`; with zero stress it is
//! `2νk²` = 0.20 1/s (Lamb 1932 § 348).
//!
//! The step's limit `h²/8ν` counts the laminar viscosity and that between approaching particles. The
//! sub-particle-scale one cannot reach it first: `ν_t = (c_s h)² √(2 ε:ε)` with `c_s = 0.1` and rates of
//! strain up to `2u/Δx` allows steps of `6 Δx/u`, twenty times those of Eq. (49).

use crate::isph::correction::second_derivative_correction;
use crate::isph::options::{Options, ViscousOperator};
use crate::particles::neighbourhood::Neighbourhood;
use rayon::prelude::*;
use sph::{Matrix, Vector, tensor};

/// Fields the viscous stage reads.
pub struct ViscousInput<'a, const D: usize> {
    /// Lists and gradients.
    pub neighbourhood: &'a Neighbourhood<D>,
    /// `B` of Eq. (5).
    pub corrections: &'a [(Matrix<D>, f64)],
    /// Positions (m).
    pub positions: &'a [Vector<D>],
    /// Velocities (m/s).
    pub velocities: &'a [Vector<D>],
    /// Laminar kinematic viscosity (m²/s).
    pub kinematic_viscosity: f64,
    /// Smoothing length (m), the filter width of Eq. (10).
    pub smoothing_length: f64,
    /// Viscosity (m²/s) added between approaching particles.
    pub artificial_viscosity: f64,
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

/// Viscous accelerations (m/s²) among fluid particles; `viscosities` is memory, and holds those of the
/// particles (m²/s) afterwards.
pub fn accelerations<const D: usize>(
    input: &ViscousInput<'_, D>,
    options: &Options,
    viscosities: &mut Vec<f64>,
    out: &mut Vec<Vector<D>>,
) {
    let count = input.velocities.len();
    viscosities.clear();
    viscosities.resize(count, input.kinematic_viscosity);
    if options.smagorinsky > 0.0 {
        viscosities.par_iter_mut().with_min_len(128).enumerate().for_each(|(a, nu)| {
            let gradient = velocity_gradient(input, a);
            *nu += eddy_viscosity(&gradient, options.smagorinsky, input.smoothing_length);
        });
    }
    let list = &input.neighbourhood.fluid;
    let viscosities = &*viscosities;
    out.resize(count, Vector::zeros());
    out.par_iter_mut().with_min_len(128).enumerate().for_each(|(a, acceleration)| {
        let pairs = &input.neighbourhood.fluid_pairs[list.range(a)];
        let mut sum = Vector::zeros();
        let fitted = options.viscosity_operator == ViscousOperator::FatehiManzari;
        for (&b, pair) in list.of(a).iter().zip(pairs) {
            let b = b as usize;
            let u = input.velocities[b] - input.velocities[a];
            let mut nu = if fitted { 0.0 } else { 0.5 * (viscosities[a] + viscosities[b]) };
            if input.artificial_viscosity > 0.0 {
                let r = input.neighbourhood.period.nearest(input.positions[b] - input.positions[a]);
                nu += if u.dot(&r) < 0.0 { input.artificial_viscosity } else { 0.0 };
            }
            sum += u * (nu * pair.stiffness());
        }
        if fitted {
            sum += fitted_laplacian(input, viscosities, a);
        }
        *acceleration = sum;
    });
}

/// Eq. (13), the corrected Laplacian (4), (6), (7): `B̂ : Σ 2V e ∇W ν_ab ((u_a − u_b)/|r_ab| − e·∇u)`.
///
/// Deviation: Eq. (13) as printed carries `μ_ab = ρ_a ν_a + ρ_b ν_b` without the mean's half against the 2 of
/// Eq. (4); here `ν_ab` is the mean and the 2 stands.
fn fitted_laplacian<const D: usize>(input: &ViscousInput<'_, D>, viscosities: &[f64], a: usize) -> Vector<D> {
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
            (input.velocities[b] - input.velocities[a])
                * (0.5 * (viscosities[a] + viscosities[b]) * pair.stiffness())
        });
        return simple.fold(Vector::zeros(), |sum, term| sum + term);
    };
    let gradient = velocity_gradient(input, a);
    let mut sum = Vector::zeros();
    for (b, r, pair) in around() {
        let distance = r.norm();
        let e = r / distance;
        let nu = 0.5 * (viscosities[a] + viscosities[b]);
        let weight = 2.0 * nu * e.dot(&(b_hat * pair.gradient()));
        let jump = (input.velocities[a] - input.velocities[b]) / distance - gradient * e;
        sum += jump * weight;
    }
    sum
}
