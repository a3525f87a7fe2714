//! The pressure of the half layer outside surface particles.
//!
//! A particle on a flat surface stands `Δx/2` inside it: with zero pressure on the particle every pressure below is `½ρgΔx` too small. So
//! it gets `p = ½ρΔx max(0, a_p·n)` with the acceleration by pressure `a_p` of the last step, at most `2g`, averaged with its last value.

use crate::neighbourhood::Neighbourhood;
use crate::solver::FluidProperties;
use crate::state::{State, SurfaceClass};
use crate::surface::Surface;

/// `∇·r/D` between which a surface counts from ragged (no offset) to flat: a lattice's edge row has 0.64, its corner 0.39 (h = 1.2 Δx).
const FLAT: (f64, f64) = (0.45, 0.55);

/// Pressures (Pa) of the surface particles; other entries are left alone.
pub fn known_pressures<const D: usize>(
    properties: &FluidProperties<D>,
    surface: &Surface<D>,
    neighbourhood: &Neighbourhood<D>,
    accepted: &State<D>,
    known: &mut [f64],
) {
    let largest = 2.0 * properties.gravity.norm();
    for (a, p) in known.iter_mut().enumerate() {
        if surface.classes[a] != SurfaceClass::Surface {
            continue;
        }
        let divergence = neighbourhood.surroundings[a].moment.trace() / D as f64;
        let flat = ((divergence - FLAT.0) / (FLAT.1 - FLAT.0)).clamp(0.0, 1.0);
        let outward = accepted.pressure_accelerations[a].dot(&surface.normals[a]).clamp(0.0, largest);
        let new = 0.5 * properties.density * properties.spacing * outward * flat;
        let was_known = accepted.classes[a] == SurfaceClass::Surface;
        *p = if was_known { 0.5 * (new + accepted.pressures[a]) } else { new };
    }
}
