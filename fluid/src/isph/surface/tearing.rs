//! Water that tears instead of being pulled ([`Options::tearing`](crate::isph::options::Options::tearing)).
//!
//! The projection holds every particle inside the fluid to `D u = 0`, by tension (a pressure below the
//! surface's) where it must. Where a jet falls back and shuts a cavity in, where water leaves a wall or an
//! edge, that tension holds together what nothing held: in a dam break (`cases/dam_break`) a whirl is left
//! under the plunging jet whose core stands at −0.3 to −1.5 ρgH, and where water meets water or wall again
//! single particles come to −8 ρgH and, at 80 particles a width, −33 ρgH. Without air and above the pressure
//! at which it boils, fluid obeys `p ≥ 0`, `D u ≥ 0` and `p D u = 0`: it parts freely where it would be
//! pulled (unilateral incompressibility: Narain, Golas and Lin 2010 for sand, Gerszewski and Bargteil 2013
//! for splashes).
//!
//! Here the set of particles with `p = 0` is corrected once a step: one whose pressure was below the tensile
//! limit (by more than [`NOISE`]) in the last step, or that was torn, has a known pressure in this step if it
//! parts, `D u* > 0`; if it closes, its pressure is unknown again. So tension lasts a step or two, there is
//! no second solve, and the projection takes energy only, as it does with the known pressures of the surface.
//! Where particles have parted far enough they are a surface as any
//! ([`surface`](crate::isph::surface::detection)), and a cavity stays open until the flow closes it.
//!
//! [`Tearing::AtSurface`] asks in addition that air can come in: that the surface, or fluid torn in the last
//! step, is within reach. Water without air bears pressures below that of the air, 0.1 MPa below it before it
//! boils, and does so beside a whirl, a sharp edge or a plate that moves away, deep in the water.
//! [`Tearing::Everywhere`] tears there, too. It is right where such places are cavities full of air that have
//! closed: single-phase fluid does not know one from the other. Nothing resists a void but the fluid's
//! weight: the one under the dam break's jet grows to about 0.6 × 0.35 m in 0.2 s, where air that is shut in
//! would be thinned.
//!
//! [`Tearing::AtSurface`] is the default; water under tension without air, in a sealed vessel or a vacuum,
//! asks for [`Tearing::Off`] or for its tensile limit. `docs/fluid.md` has the numbers with and without, and
//! what else was tried: in a dam break it takes tension to 1/25 to 1/100 at no cost, and the elastic gate's
//! tip goes 6 % farther.

use crate::isph::options::Tearing;
use crate::isph::state::State;
use crate::isph::surface::detection::Surface;
use crate::particles::class::SurfaceClass;
use crate::particles::neighbourhood::Neighbourhood;

/// Tension over `ρ u_ref²` beyond the tensile limit from which on fluid tears: what a tank at rest has of it
/// by noise stays below.
pub const NOISE: f64 = 0.02;

/// Finds the torn particles: `torn` lists them, and `surface` counts their pressures as known.
///
/// `parting` is `D u*` (1/s), `limit` the pressure (Pa, not positive) under which particles tear that have
/// not. None is torn where no pressure is known: neither in pockets nor in a closed domain does the fluid
/// know the surface's pressure.
pub fn find<const D: usize>(
    (tearing, limit): (Tearing, f64),
    parting: &[f64],
    neighbourhood: &Neighbourhood<D>,
    accepted: &State<D>,
    surface: &mut Surface<D>,
    torn: &mut Vec<u32>,
) {
    torn.clear();
    if tearing == Tearing::Off || surface.is_closed() {
        return;
    }
    let was_torn = |a: usize| accepted.classes[a] == SurfaceClass::Torn;
    for (a, &rate) in parting.iter().enumerate() {
        let gives_way = was_torn(a) || accepted.pressures[a] < limit;
        if !(gives_way && rate > 0.0 && surface.free[a] && !surface.in_pocket[a]) {
            continue;
        }
        let open = |&b: &u32| !surface.free[b as usize] || was_torn(b as usize);
        if tearing == Tearing::Everywhere || neighbourhood.fluid.of(a).iter().any(open) {
            torn.push(a as u32);
        }
    }
    for &a in &*torn {
        surface.free[a as usize] = false;
        surface.alpha[a as usize] = 0.0;
    }
}
