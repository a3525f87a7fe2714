//! Friction of no-slip boundaries: pairs in Morris' form, equal and opposite.

use crate::boundaries::sampling::BoundaryPoints;
use crate::boundaries::walls::Walls;
use crate::isph::options::Options;
use crate::isph::state::State;
use crate::particles::neighbourhood::Neighbourhood;
use sph::Vector;

/// Largest ratio of the extrapolated difference of velocity to that at the wall: with it the friction of a
/// row half in the wall stays stable at the step `h²/8ν`. Morris has 1.5.
const STEEPEST: f64 = 3.0;

/// What a fluid particle meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// A part of the walls.
    Wall(usize),
    /// A boundary point of the structure.
    Structure(usize),
}

/// The pair of a fluid particle and a boundary point that holds it back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction<const D: usize> {
    /// The fluid particle.
    pub particle: u32,
    /// What holds it.
    pub body: Body,
    /// `ν stiffness` (1/s): the acceleration is this times the difference of velocity.
    pub rate: f64,
    /// The boundary point's velocity (m/s).
    pub velocity: Vector<D>,
}

impl<const D: usize> Friction<D> {
    /// What the particle gets (m/s²) where the fluid has these velocities (m/s).
    pub fn acceleration(&self, velocities: &[Vector<D>]) -> Vector<D> {
        (self.velocity - velocities[self.particle as usize]) * self.rate
    }
}

/// Pairs of fluid and no-slip boundaries, particle by particle.
///
/// Wall particles have the velocity that is, extrapolated through the wall's surface from the particle that
/// they meet, the wall's own at the surface: the difference is `1 + depth/distance` times as large (Morris,
/// Fox and Zhu 1997). The structure's particles have their own velocity.
pub fn frictions<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    options: &Options,
    kinematic_viscosity: f64,
    fluid: &State<D>,
    (walls, structure): (&Walls<D>, &BoundaryPoints<D>),
    out: &mut Vec<Friction<D>>,
) {
    let positions = &fluid.positions;
    let rate = |a: usize, at: &Vector<D>, g: &Vector<D>, factor: f64| {
        2.0 * factor * g.norm() / (positions[a] - at).norm() * kinematic_viscosity
    };
    out.clear();
    for a in 0..positions.len() {
        let particle = a as u32;
        if options.no_slip_walls {
            let list = &neighbourhood.walls;
            let (mut nearest, mut distance) = (usize::MAX, 0.0);
            for (&w, g) in list.of(a).iter().zip(&neighbourhood.wall_gradients[list.range(a)]) {
                let w = w as usize;
                let part = walls.part_of[w] as usize;
                if part != nearest {
                    (nearest, distance) = (part, walls.surface_point(part, &positions[a], false).distance);
                }
                let factor =
                    if distance > 0.0 { (1.0 + walls.depths[w] / distance).min(STEEPEST) } else { STEEPEST };
                let rate = rate(a, &walls.positions[w], g, factor);
                out.push(Friction { particle, body: Body::Wall(part), rate, velocity: walls.velocities[w] });
            }
        }
        if options.no_slip_structure {
            let list = &neighbourhood.structure;
            for (&s, g) in list.of(a).iter().zip(&neighbourhood.structure_gradients[list.range(a)]) {
                let s = s as usize;
                let rate = rate(a, &structure.positions[s], g, 1.0);
                let velocity = structure.velocities[s];
                out.push(Friction { particle, body: Body::Structure(s), rate, velocity });
            }
        }
    }
}
