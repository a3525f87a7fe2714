//! The pressure of the layer outside particles on and near the surface.
//!
//! A particle on a flat surface stands `Δx/2` inside it: with zero pressure on the particle, pressures below
//! are wrong by up to `½ρgΔx`, from layer to layer with the other sign (the symmetric gradient balances the
//! top layer's weight by `p₁ + p₂`). So it gets the pressure at its depth, and a particle that Eq. (16) draws
//! towards the surface's pressure by its α < 1 is drawn towards the pressure at its own depth. Drawn towards
//! zero, a particle of the second layer whose `∇·r` falls below 1.8 for some steps loses up to 0.6 ρgΔx.
//!
//! # On quiet water gravity's pressure, not that of the acceleration
//!
//! With the depth `½Δx` held, the pressure would be `½ρΔx (g − Du/Dt)·(−n)`, or `½ρΔx a_p·n` with the
//! acceleration by pressure `a_p`. But the half layer takes part in a wave: with a displacement `ξ` it is
//! `d = ½Δx (1 + ∂ξ_n/∂n)` thick. In a wave of wavenumber k on water of depth H, `∂ξ_n/∂n = kη coth kH` and
//! `Du_n/Dt = −gkη tanh kH`, so that to first order
//!
//! `p = ½ρΔx (1 + kη coth kH)(g − gkη tanh kH) = ½ρgΔx [1 + kη (coth kH − tanh kH)]`:
//!
//! in water deeper than a third of a wavelength a particle keeps its pressure (as in Gerstner's wave, Lamb
//! 1932 § 251). With the inertia and without the thickness the boundary's condition is `p' (1 + ½kΔx) = ρgη`,
//! and the wave's frequency `ω² = gk tanh kH/(1 + ½kΔx)`: the top half layer's inertia counts twice.
//! (`cases/standing_wave`: the period is 5.4, 2.8 and 1.7 % long that way at 20, 40 and 80 particles in
//! depth, 1.3, 0.4 and 0.6 % as it is here.) In shallow water `p = ½ρgΔx (1 + η/H)`, whose second term is
//! left out.
//!
//! A surface far from rest has had no such history: where a column's side is set free, or water falls, the
//! pressure is that of `a_p`. [`carried`] goes from one to the other by the difference of the two. Gravity's
//! pressure alone, limited by `2a_p·n`, gave a dam break 0.15 % of its energy in its first 0.3 s (Δx =
//! width/10; 0.015 % as it is here): the column's side had none. `a_p` is that of the last step, and the
//! pressure of a surface particle is averaged with its last value.

use crate::isph::state::State;
use crate::isph::surface::detection::Surface;
use crate::particles::class::SurfaceClass;
use crate::particles::neighbourhood::Neighbourhood;
use crate::properties::FluidProperties;

/// `∇·r/D` between which a surface counts from ragged (no offset) to flat: a lattice's edge row has 0.64, its
/// corner 0.39 (h = 1.2 Δx).
const FLAT: (f64, f64) = (0.45, 0.55);

/// Departure of the acceleration by pressure from gravity, in units of `g`, up to which a surface counts as
/// that of a wave.
const QUIET: f64 = 0.2;

/// Pressures that the layer outside gives, one entry a particle.
#[derive(Clone, Debug, Default)]
pub struct Outside {
    /// Pressures (Pa) of surface particles, zero elsewhere.
    pub known: Vec<f64>,
    /// What Eq. (16) draws the pressures (Pa) of others with α < 1 towards, zero elsewhere.
    pub drawn_to: Vec<f64>,
}

/// Depth (in smoothing lengths) of a particle under a flat surface from its `∇·r/D`.
///
/// In fluid without grain below a plane this is 1/2 in the plane and 1 from `2h` on; up to `h` deep a line
/// meets it to 0.025 h in the plane, 0.04 h in space.
pub fn depth<const D: usize>(divergence: f64) -> f64 {
    let slope = if D == 2 { 0.385 } else { 0.43 };
    ((divergence - 0.5) / slope).max(0.0)
}

/// Acceleration (m/s²) whose weight the half layer outside has, from the normal parts of gravity and of the
/// acceleration by pressure.
///
/// Gravity's while the two differ by less than a fifth of `g`, that by pressure (0 to `2g`) from two fifths
/// on.
pub fn carried(weight: f64, by_pressure: f64, g: f64) -> f64 {
    let excess = by_pressure - weight;
    let beyond = (2.0 * (excess.abs() - QUIET * g)).clamp(0.0, excess.abs());
    (weight + beyond.copysign(excess)).clamp(0.0, 2.0 * g)
}

impl Outside {
    /// No pressure for `count` particles.
    pub fn clear(&mut self, count: usize) {
        for values in [&mut self.known, &mut self.drawn_to] {
            values.clear();
            values.resize(count, 0.0);
        }
    }

    /// The pressures of surface particles, and of those near it that are not wholly inside.
    pub fn find<const D: usize>(
        &mut self,
        (properties, smoothing_length): (&FluidProperties<D>, f64),
        surface: &Surface<D>,
        neighbourhood: &Neighbourhood<D>,
        accepted: &State<D>,
    ) {
        self.clear(accepted.len());
        for a in 0..accepted.len() {
            let on_surface = surface.classes[a] == SurfaceClass::Surface;
            let near = surface.classes[a] == SurfaceClass::NearSurface && surface.alpha[a] < 1.0;
            if !(on_surface || near) {
                continue;
            }
            let normal = &surface.normals[a];
            let carried = carried(
                -properties.gravity.dot(normal),
                accepted.memory.pressure_accelerations[a].dot(normal),
                properties.gravity.norm(),
            );
            let divergence = neighbourhood.surroundings[a].moment.trace() / D as f64;
            if near {
                self.drawn_to[a] = properties.density * carried * depth::<D>(divergence) * smoothing_length;
                continue;
            }
            let flat = ((divergence - FLAT.0) / (FLAT.1 - FLAT.0)).clamp(0.0, 1.0);
            let new = 0.5 * properties.density * properties.spacing * carried * flat;
            let was_known = accepted.classes[a] == SurfaceClass::Surface;
            self.known[a] = if was_known { 0.5 * (new + accepted.pressures[a]) } else { new };
        }
    }
}
