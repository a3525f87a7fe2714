//! Projection of positions onto the fluid's density: what the divergence-free velocity leaves undone is taken
//! back by moving particles, without touching their velocity.
//!
//! Solves `(A + …) q = α clamp((n − n₀)/n₀, ±0.05)` and moves by `δr = M⁻¹ Dᵀ q`. Putting the same error into
//! the velocity (`div u* − γ (n − n₀)/(n₀Δt)`) pumps energy.

use crate::isph::surface::detection::Surface;
use crate::particles::neighbourhood::Neighbourhood;
use rayon::prelude::*;
use sph::Vector;

/// Particles that one task works through at least.
const ROWS: usize = 1024;

/// Largest density error that one step takes back.
const CLAMP: f64 = 0.05;

/// `α clamp((n − n₀)/n₀)` of all particles, zero on the surface.
pub fn density_errors<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    surface: &Surface<D>,
    lattice_concentration: f64,
    out: &mut Vec<f64>,
) {
    let sums = &neighbourhood.surroundings;
    out.resize(sums.len(), 0.0);
    out.par_iter_mut().zip(sums).with_min_len(ROWS).enumerate().for_each(|(a, (out, sums))| {
        let error = (sums.concentration - lattice_concentration) / lattice_concentration;
        *out = if surface.free[a] { surface.alpha[a] * error.clamp(-CLAMP, CLAMP) } else { 0.0 };
    });
}

/// Shortens displacements (m) to `limit` (m).
pub fn limit<const D: usize>(displacements: &mut [Vector<D>], limit: f64) {
    displacements.par_iter_mut().with_min_len(ROWS).for_each(|d| {
        let length = d.norm();
        if length > limit {
            *d *= limit / length;
        }
    });
}
