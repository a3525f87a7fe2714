//! Water that tears instead of being pulled: an option ([`Options::tearing`](crate::Options::tearing)).
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
//! Here the set of particles with `p = 0` is corrected once a step: one whose pressure was below −[`LIMIT`]
//! in the last step, or that was torn, has the known pressure zero in this step if it parts, `D u* > 0`; if
//! it closes, its pressure is unknown again. So tension lasts a step or two, there is no second solve, and
//! the projection takes energy only, as it does with the known pressures of the surface. Where particles have
//! parted far enough they are a surface as any ([`surface`](crate::isph::surface::detection)), and a cavity stays open until
//! the flow closes it.
//!
//! [`Tearing::AtSurface`] asks in addition that air can come in: that the surface, or fluid torn in the last
//! step, is within reach. Water without air bears pressures below that of the air, 0.1 MPa below it before it
//! boils, and does so beside a whirl, a sharp edge or a plate that moves away, deep in the water.
//! [`Tearing::Everywhere`] tears there, too. It is right where such places are cavities full of air that have
//! closed: single-phase fluid does not know one from the other. Nothing resists a void but the fluid's
//! weight: the one under the dam break's jet grows to about 0.6 × 0.35 m in 0.2 s, where air that is shut in
//! would be thinned.
//!
//! # Numbers
//!
//! A dam break with the measures of `cases/dam_break`, 3.84 s. "Tension" is `∫ Σ|p| dt` over particles with
//! `p < 0` over that of all, 2.16 to 3.36 s; "held" the longest time (s) that a particle stayed under −0.05
//! ρgH; "lowest" of all particles in single steps (ρgH); energy left at the end, largest rise of energy,
//! volume drift, iterations of the pressure a step, steps.
//!
//! | Δx = width/ | torn | tension | held | lowest | energy left | rise | drift | iterations | steps |
//! |---|---|---|---|---|---|---|---|---|---|
//! | 20 | off | 5.20 % | 0.192 | −6.34 | 0.443 | 3.82e-4 | 1.60e-3 | 5.63 | 2,478 |
//! | 20 | at the surface | 0.93 % | 0.158 | −3.96 | 0.470 | 3.48e-4 | 3.75e-3 | 5.34 | 2,244 |
//! | 20 | everywhere | 0.21 % | 0.004 | −2.01 | 0.454 | 3.78e-4 | 3.13e-3 | 5.31 | 2,394 |
//! | 40 | off | 5.76 % | 0.604 | −8.48 | 0.463 | 1.56e-4 | 4.14e-4 | 6.90 | 5,393 |
//! | 40 | at the surface | 2.25 % | 0.459 | −7.09 | 0.470 | 1.31e-4 | 1.20e-3 | 6.36 | 5,327 |
//! | 40 | everywhere | 0.13 % | 0.004 | −4.87 | 0.426 | 1.65e-4 | 1.54e-3 | 6.51 | 5,336 |
//! | 80 | off | 7.57 % | 0.751 | −33.36 | 0.484 | 4.19e-5 | 1.00e-4 | 8.40 | 11,171 |
//! | 80 | everywhere | 0.07 % | 0.002 | −11.59 | 0.436 | 6.91e-5 | 5.32e-4 | 7.85 | 11,445 |
//!
//! The front passes Z = 4 within 0.3 % of the same time. What is left is the first step of each impact. Five
//! jittered starts at 20 and 40, everywhere: tension 0.12 to 0.24 %, held 0.003 to 0.009 s, rise 1.2e-4 to
//! 4.3e-4, drift 3.3e-3 to 4.0e-3 (3.2e-3 to 3.8e-3 without), no particle lost, 5.3 to 6.5 iterations. A tank
//! at rest (`cases/hydrostatic_tank`, 10, 20 and 40 particles in depth, 10 s) is the same with and without.
//! So are the standing wave (20 particles in depth) and the closed Taylor–Green flow; the elliptical drop's
//! minor axis is 1.7 instead of 1.4 % off (50 across).
//!
//! The elastic gate (`cases/elastic_gate`): water under the gate's free end is pulled at by up to 3.5 ρgH in
//! the outflow behind the edge, which is ragged; torn, it leaves as a smooth jet. The tip goes to 44.1 / 15.8
//! mm at 0.122 s with either law, instead of 41.8 / 13.9 mm at 0.118 s (experiment 46.2 / 17.0), and comes
//! back later: 42.0, 37.5, 33.3 mm at 0.16, 0.20, 0.24 s instead of 39.0, 34.7, 31.0 (46.2, 44.0, 42.8). It
//! is off by default because those cases were measured without.
//!
//! Tried at 20 particles a width: limits of 0.1 and 0.005 `ρ u_ref²` leave 0.61 and 0.15 % of tension; to
//! tear only where particles are less dense than on the lattice leaves up to 1.2 % (in the worst 0.24 s,
//! which have 0.5 % as it is here), and without remembering who was torn 10 %: every second step pulls. To
//! keep them torn until they are as dense as on the lattice to 2 % gains nothing and took more of the energy
//! (0.41 left).

use crate::isph::options::Tearing;
use crate::isph::state::State;
use crate::isph::surface::detection::Surface;
use crate::particles::class::SurfaceClass;
use crate::particles::neighbourhood::Neighbourhood;

/// Tension over `ρ u_ref²` from which on fluid tears: what a tank at rest has of it by noise stays below.
pub const LIMIT: f64 = 0.02;

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
