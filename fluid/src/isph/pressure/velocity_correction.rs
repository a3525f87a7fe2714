//! From pressure to velocity: the symmetric gradient, that of Eq. (18), and as much of the second as energy
//! allows.

use crate::isph::pressure::along::Along;
use crate::particles::neighbourhood::Neighbourhood;
use rayon::prelude::*;
use sph::{Matrix, Vector, parallel};

/// How much of Eq. (18) a particle may take by its surroundings: none where neighbours are one-sided.
///
/// `clamp((λ_min − 0.3)/0.2)` with the smallest eigenvalue of the inverse of `B`.
pub fn confidence<const D: usize>(corrections: &[(Matrix<D>, f64)], out: &mut Vec<f64>) {
    out.resize(corrections.len(), 0.0);
    out.par_iter_mut().zip(corrections).with_min_len(1024).for_each(|(out, (_, smallest))| {
        *out = ((smallest - 0.3) / 0.2).clamp(0.0, 1.0);
    });
}

/// Accelerations (m/s²) by Eq. (18), `−(1/ρ) Σ V (p_b − p_a) B∇W`, with `p_w = p_a − ρ g·r_aw` on walls and
/// structure; where `along` has a row, `weights` are `ρ (g − a_w)` (Pa/m) in place of `ρ g`.
pub fn corrected_accelerations<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    corrections: &[(Matrix<D>, f64)],
    (along, weights): (&Along<D>, &[Vector<D>]),
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
        let weight = along.index(a).map_or(*gravity, |i| weights[i] * inverse_density);
        let carried = neighbourhood.surroundings[a].boundary_moment * weight;
        *acceleration = corrections[a].0 * (gradient * -inverse_density - carried);
    });
}

/// Largest share of the reference energy `M u_ref²` by which the total energy may come to stand above the
/// least it had: half of a thousandth of the potential energy `½ M g H` of water H high.
const EXCESS: f64 = 2.5e-4;

/// Share of the energy that the projection took which Eq. (18) may give back to water at rest. Given back in
/// full, it keeps alive what the projection is there to take: water at rest 100 particles deep in a rigid
/// tank (0.1 to 0.4 s) then presses with 782 ± 69 N, with this share with 783.0 ± 2.4 N; 782.1 N are right.
const LENT_AT_REST: f64 = 0.2;

/// The same of water that moves, from its kinetic energy and `M u_ref²` (J).
pub fn lent(kinetic_energy: f64, scale: f64) -> f64 {
    LENT_AT_REST + (1.0 - LENT_AT_REST) * motion(kinetic_energy, scale)
}

/// How far the fluid counts as moving, 0 to 1.
fn motion(kinetic_energy: f64, scale: f64) -> f64 {
    if scale > 0.0 { (kinetic_energy / (MOVING * scale)).min(1.0) } else { 0.0 }
}

/// Share of the energy excess that a step's budget is shortened by, times the strictness.
pub const RETURNED: f64 = 0.1;

/// Kinetic energy over `M u_ref²` from which on the budget counts in full: a tank at rest keeps 3e-4, a dam
/// that has run against the far wall over 0.07.
const MOVING: f64 = 0.01;

/// How strictly the budget of [`admissible_share`] counts, 0 to 1, from the energy (J) that the fluid stands
/// above the least it had, its kinetic energy (J), and `M u_ref²` (J).
///
/// The pressure's own work is always counted. The time integration's error, `½ Δt m Σ g·(u − u*)` for
/// displacements with the mean of old and new velocity, is counted the more the nearer the excess comes to
/// its limit. Counted never, it lets a dam break gain 0.44 % of its energy while its jet falls back from the
/// far wall (Δx = width/20, 2 s; 0.04 % as it is here). Counted at rest, it leaves nothing to spend: a tank
/// whose jittered start has been lifted by 0.07 % of its depth then keeps 3 J of noise instead of 0.02 J, so
/// it does not count where there is no motion. Displacements that are not the velocity's lift the fluid too:
/// of the excess, [`RETURNED`] is taken out of the budget each step.
pub fn strictness(excess: f64, kinetic_energy: f64, scale: f64) -> f64 {
    if scale > 0.0 {
        (excess / (EXCESS * scale)).clamp(0.0, 1.0) * motion(kinetic_energy, scale)
    } else {
        0.0
    }
}

/// Largest share θ ≤ 1 of the change `difference` (m/s) to velocities `u` for which the kinetic energy (J)
/// rises by no more than `budget` (J, not positive beyond rounding: less than what the symmetric gradient
/// took).
///
/// `½ m Σ |u + θ d|² − ½ m Σ |u|² − θ m Σ f·d = m θ Σ (u − f)·d + ½ m θ² Σ d² ≤ budget`, where `f` (m/s) is
/// what potential energy takes of it: the strictness times `½ Δt g`.
pub fn admissible_share<const D: usize>(
    mass: f64,
    u: &[Vector<D>],
    difference: &[Vector<D>],
    fall: &Vector<D>,
    budget: f64,
) -> f64 {
    let linear = mass * parallel::sum(u.len(), |a| (u[a] - fall).dot(&difference[a]));
    let square = 0.5 * mass * parallel::sum(u.len(), |a| difference[a].norm_squared());
    if linear + square <= budget {
        return 1.0;
    }
    if budget < 0.0 || square == 0.0 {
        return 0.0;
    }
    ((-linear + (linear * linear + 4.0 * square * budget).sqrt()) / (2.0 * square)).clamp(0.0, 1.0)
}
