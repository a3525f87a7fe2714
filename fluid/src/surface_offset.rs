//! The pressure of the layer outside particles on and near the surface.
//!
//! A particle on a flat surface stands `Δx/2` inside it: with zero pressure on the particle, pressures below are wrong by up to `½ρgΔx`, from layer to
//! layer with the other sign (the symmetric gradient balances the top layer's weight by `p₁ + p₂`). So it gets the pressure at its depth,
//! and a particle that Eq. (16) draws towards the surface's pressure by its α < 1 is drawn towards the pressure at its own depth. Drawn towards zero, a
//! particle of the second layer whose `∇·r` falls below 1.8 for some steps loses up to 0.6 ρgΔx.
//!
//! # Gravity, not acceleration
//!
//! The pressure is `ρ d g·(−n)`, not `ρ d (g − Du/Dt)·(−n)` with a constant `d = ½Δx`. The half layer takes part in the wave: with a displacement `ξ` it is
//! `d = ½Δx (1 + ∂ξ_n/∂n)` thick. In a wave of wavenumber k on water of depth H, `∂ξ_n/∂n = kη coth kH` and `Du_n/Dt = −gkη tanh kH`, so that to first order
//!
//! `p = ½ρΔx (1 + kη coth kH)(g − gkη tanh kH) = ½ρgΔx [1 + kη (coth kH − tanh kH)]`:
//!
//! in water deeper than a third of a wavelength a particle keeps its pressure (as in Gerstner's wave, Lamb 1932 § 251). With the inertia and without the thickness
//! the wave's frequency is `ω² = gk tanh kH/(1 + ½kΔx)`: the top half layer's inertia counts twice. In shallow water `p = ½ρgΔx (1 + η/H)`, whose second term is
//! left out: an error of `Δx/4H` in the period.
//!
//! Fluid that falls freely has no such pressure: where the acceleration by pressure `a_p` of the last step is less than half of gravity's normal part, the pressure is
//! `ρ d 2a_p·n`. It is averaged with its last value.

use crate::neighbourhood::Neighbourhood;
use crate::solver::FluidProperties;
use crate::state::{State, SurfaceClass};
use crate::surface::Surface;

/// `∇·r/D` between which a surface counts from ragged (no offset) to flat: a lattice's edge row has 0.64, its corner 0.39 (h = 1.2 Δx).
const FLAT: (f64, f64) = (0.45, 0.55);

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
/// In fluid without grain below a plane this is 1/2 in the plane and 1 from `2h` on; up to `h` deep a line meets it to 0.025 h in the plane, 0.04 h in space.
pub fn depth<const D: usize>(divergence: f64) -> f64 {
    let slope = if D == 2 { 0.385 } else { 0.43 };
    ((divergence - 0.5) / slope).max(0.0)
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
            let weight = -properties.gravity.dot(normal);
            let carried = (2.0 * accepted.pressure_accelerations[a].dot(normal)).min(weight).max(0.0);
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
