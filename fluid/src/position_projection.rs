//! Projection of positions onto the fluid's density: what the divergence-free velocity leaves undone is taken back by moving particles,
//! without touching their velocity.
//!
//! Solves `(A + …) q = α clamp((n − n₀)/n₀, ±0.05)` and moves by `δr = M⁻¹ Dᵀ q`. Putting the same error into the velocity
//! (`div u* − γ (n − n₀)/(n₀Δt)`) pumps energy.

use crate::neighbourhood::Neighbourhood;
use crate::surface::Surface;
use sph::Vector;

/// Largest density error that one step takes back.
const CLAMP: f64 = 0.05;

/// `α clamp((n − n₀)/n₀)` of all particles, zero on the surface.
pub fn density_errors<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    surface: &Surface<D>,
    lattice_concentration: f64,
    out: &mut Vec<f64>,
) {
    out.clear();
    out.extend(neighbourhood.surroundings.iter().enumerate().map(|(a, sums)| {
        let error = (sums.concentration - lattice_concentration) / lattice_concentration;
        if surface.free[a] { surface.alpha[a] * error.clamp(-CLAMP, CLAMP) } else { 0.0 }
    }));
}

/// Shortens displacements (m) to `limit` (m).
pub fn limit<const D: usize>(displacements: &mut [Vector<D>], limit: f64) {
    for d in displacements {
        let length = d.norm();
        if length > limit {
            *d *= limit / length;
        }
    }
}
