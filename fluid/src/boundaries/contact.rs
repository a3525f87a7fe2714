//! Particles near walls and structure: none may come nearer than a least distance in a step.
//!
//! The pressure keeps the fluid off its boundaries where it is unknown; a surface particle has a known
//! pressure and would run into them. Its approach is limited to what the remaining distance allows,
//! inelastically: velocity is only ever taken away relative to the boundary.

use crate::boundaries::walls::{SurfacePoint, Walls};
use sph::Vector;

/// Limits of an approach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Time step (s).
    pub dt: f64,
    /// Distance (m) from the surface that a particle keeps.
    pub least_distance: f64,
}

impl Approach {
    /// Limits a particle's velocity and displacement towards a surface that moves with `boundary`; gives the
    /// change of velocity (m/s).
    pub fn limit<const D: usize>(
        &self,
        surface: &SurfacePoint<D>,
        boundary: &Vector<D>,
        velocity: &mut Vector<D>,
        displacement: &mut Vector<D>,
    ) -> Vector<D> {
        let room = (surface.distance - self.least_distance).max(0.0);
        let into = (displacement.dot(&surface.normal) - boundary.dot(&surface.normal) * self.dt) + room;
        if into < 0.0 {
            *displacement -= surface.normal * into;
        }
        let excess = (*velocity - boundary).dot(&surface.normal) + room / self.dt;
        if excess < 0.0 {
            let change = surface.normal * -excess;
            *velocity += change;
            return change;
        }
        Vector::zeros()
    }
}

/// Limits a particle's approach to all walls; `contact(part, change, boundary)` is told each change of
/// velocity, and the wall's own.
pub fn keep_off_walls<const D: usize>(
    approach: &Approach,
    walls: &Walls<D>,
    reach: f64,
    position: &Vector<D>,
    velocity: &mut Vector<D>,
    displacement: &mut Vector<D>,
    mut contact: impl FnMut(usize, Vector<D>, Vector<D>),
) {
    for index in 0..walls.parts.len() {
        let surface = walls.surface_point(index, position, false);
        if surface.distance.abs() < reach {
            let boundary = walls.motion_at(index, position);
            let change = approach.limit(&surface, &boundary, velocity, displacement);
            if change != Vector::<D>::zeros() {
                contact(index, change, boundary);
            }
        }
    }
}

/// The structure's surface next to a fluid particle: the nearest interface particle, and the distance to the
/// plane through its outer side.
///
/// `near` lists the interface particles within reach; nothing when there are none or the particle stands
/// beside that plane's patch.
pub fn nearest_structure<const D: usize>(
    position: &Vector<D>,
    near: &[u32],
    positions: &[Vector<D>],
    normals: &[Vector<D>],
    spacings: &[f64],
) -> Option<(usize, SurfacePoint<D>)> {
    let offset = |s: usize| position - positions[s];
    let s = near
        .iter()
        .map(|&s| s as usize)
        .min_by(|&s, &t| offset(s).norm_squared().total_cmp(&offset(t).norm_squared()))?;
    let (r, normal) = (offset(s), normals[s]);
    if normal == Vector::<D>::zeros() {
        // Deep inside the structure counts as such only when really among its particles.
        let inside = r.norm() < 0.8 * spacings[s];
        return inside.then(|| (s, SurfacePoint { distance: -spacings[s], normal }));
    }
    let height = r.dot(&normal);
    let aside = (r - normal * height).norm();
    (aside < spacings[s]).then(|| (s, SurfacePoint { distance: height - 0.5 * spacings[s], normal }))
}
