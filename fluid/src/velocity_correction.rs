//! From pressure to velocity: the symmetric gradient, that of Eq. (18), and as much of the second as energy allows.

use crate::neighbourhood::Neighbourhood;
use rayon::prelude::*;
use sph::{Matrix, Vector, parallel};

/// How much of Eq. (18) a particle may take by its surroundings: none where neighbours are one-sided, none next to the structure.
///
/// `clamp((λ_min − 0.3)/0.2)` with the smallest eigenvalue of the inverse of `B`.
pub fn confidence<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    corrections: &[(Matrix<D>, f64)],
    out: &mut Vec<f64>,
) {
    out.clear();
    out.extend(corrections.iter().enumerate().map(|(a, (_, smallest))| {
        let beside_structure = !neighbourhood.structure.of(a).is_empty();
        if beside_structure { 0.0 } else { ((smallest - 0.3) / 0.2).clamp(0.0, 1.0) }
    }));
}

/// Accelerations (m/s²) by Eq. (18), `−(1/ρ) Σ V (p_b − p_a) B∇W`, with `p_w = p_a − ρ g·r_aw` on walls and structure.
pub fn corrected_accelerations<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    corrections: &[(Matrix<D>, f64)],
    inverse_density: f64,
    gravity: &Vector<D>,
    p: &[f64],
    out: &mut Vec<Vector<D>>,
) {
    let list = &neighbourhood.fluid;
    out.resize(p.len(), Vector::zeros());
    out.par_iter_mut().with_min_len(128).enumerate().for_each(|(a, acceleration)| {
        let mut gradient = Vector::zeros();
        for (&b, pair) in list.of(a).iter().zip(&neighbourhood.fluid_pairs[list.range(a)]) {
            gradient += pair.gradient() * (p[b as usize] - p[a]);
        }
        // (1/ρ) Σ V (p_w − p_a) ∇W with p_w − p_a = ρ g·(r_w − r_a).
        let hydrostatic = neighbourhood.surroundings[a].boundary_moment * gravity;
        *acceleration = corrections[a].0 * (gradient * -inverse_density - hydrostatic);
    });
}

/// The budget counts the pressure's own work alone. Charging it with the errors of time integration and of displacements too (so that the
/// total energy would not rise either) leaves nothing to spend in water at rest: the tank then keeps 10 J of noise instead of 0.02 J. What the
/// total gains that way stays small: see the case `dam break` in the crate's tests.
///
/// Largest share θ ≤ 1 of the change `difference` (m/s) to velocities `u` for which the kinetic energy (J) rises by no more than `budget`
/// (J, not positive beyond rounding: less than what the symmetric gradient took).
///
/// `½ m Σ |u + θ d|² − ½ m Σ |u|² = m θ Σ u·d + ½ m θ² Σ d² ≤ budget`.
pub fn admissible_share<const D: usize>(
    mass: f64,
    u: &[Vector<D>],
    difference: &[Vector<D>],
    budget: f64,
) -> f64 {
    let linear = mass * parallel::sum(u.len(), |a| u[a].dot(&difference[a]));
    let square = 0.5 * mass * parallel::sum(u.len(), |a| difference[a].norm_squared());
    if linear + square <= budget {
        return 1.0;
    }
    if budget < 0.0 || square == 0.0 {
        return 0.0;
    }
    ((-linear + (linear * linear + 4.0 * square * budget).sqrt()) / (2.0 * square)).clamp(0.0, 1.0)
}
