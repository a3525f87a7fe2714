//! Wall particles behind the structure's face: what they do across it is the structure's.
//!
//! Where a structure stands on a wall, the corner behind both is filled by wall particles. They press on the
//! fluid across the structure's face as well as across the wall's: with them the pressure on the face is
//! carried down to the wall, without them the face lacks a third of a spacing of it, and its velocity ends as
//! much too high.

use sph::Vector;
use sph::neighbours::{CellGrid, NeighbourList};

/// A wall particle that stands for an interface particle in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tie<const D: usize> {
    /// The wall particle.
    pub wall: u32,
    /// The interface particle.
    pub structure: u32,
    /// Across the structure's face and along the wall's; its square is the share of the particle's cell that
    /// lies behind the face.
    pub direction: Vector<D>,
}

/// Length below which a face's normal, the wall's taken out, counts as none: the face goes on as the wall.
const ASLANT: f64 = 0.3;

/// Ties the walls' particles to the interface particles within `support` (m). `walls` are positions, and the
/// outward normal of the wall at each; `structure` positions, outward normals (zero inside) and spacings (m).
pub fn find<const D: usize>(
    support: f64,
    (walls, wall_normal): (&[Vector<D>], impl Fn(usize) -> Vector<D>),
    (structure, normals, spacings): (&[Vector<D>], &[Vector<D>], &[f64]),
    near: &mut NeighbourList,
    out: &mut Vec<Tie<D>>,
) {
    out.clear();
    if walls.is_empty() || structure.is_empty() {
        return;
    }
    near.rebuild(walls, &CellGrid::new(structure, support), structure);
    for (w, at) in walls.iter().enumerate() {
        if near.of(w).is_empty() {
            continue;
        }
        let n = wall_normal(w);
        let across = |s: usize| normals[s] - n * n.dot(&normals[s]);
        let distance = |s: usize| (at - structure[s]).norm_squared();
        let faces = near.of(w).iter().map(|&s| s as usize).filter(|&s| across(s).norm() > ASLANT);
        let Some(s) = faces.min_by(|&s, &t| distance(s).total_cmp(&distance(t))) else { continue };
        let direction = across(s).normalize();
        let behind = (1.0 - (at - structure[s]).dot(&direction) / spacings[s]).clamp(0.0, 1.0);
        if behind > 0.0 {
            out.push(Tie { wall: w as u32, structure: s as u32, direction: direction * behind.sqrt() });
        }
    }
}

/// Takes from the `velocities` (m/s) of pairs of fluid and wall, `walls` particles of it, what ties leave to
/// the structure.
pub fn leave_to_structure<const D: usize>(
    ties: &[Tie<D>],
    walls: usize,
    near: &NeighbourList,
    velocities: &mut [Vector<D>],
) {
    if ties.is_empty() || velocities.is_empty() {
        return;
    }
    let mut tie_of = vec![None; walls];
    ties.iter().for_each(|tie| tie_of[tie.wall as usize] = Some(tie.direction));
    for (u, &w) in velocities.iter_mut().zip(near.indices()) {
        if let Some(direction) = &tie_of[w as usize] {
            *u -= direction * direction.dot(u);
        }
    }
}
