//! The potential of a node and its partner: distance, energy, force, and what may not happen.

use crate::contact::distance::nearest;
use crate::contact::friction::{Under, squareness};
use crate::contact::pairing::Contact;
use crate::contact::search::{Near, Row};
use crate::contact::walls::Part;
use sph::Vector;
use words::rigid::Pose;

/// How much the energy is raised where a node has gone all of the thickness.
const STIFFENING: f64 = 1.0;

/// A node that is nearer to a surface than this (fraction of the thickness) is about to pass.
const PASSING: f64 = 0.05;

/// A node that is about to pass through a surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Passed {
    pub particle: usize,
    pub position: Vec<f64>,
    pub body: usize,
    /// Body, or after all bodies wall.
    pub partner: usize,
}

/// A node that touches.
#[derive(Clone, Copy)]
pub(super) struct Met<const D: usize> {
    pub force: Vector<D>,
    pub energy: f64,
    pub normal_force: f64,
    pub normal: Vector<D>,
    /// Nearest element of a body.
    pub under: Option<Found>,
}

/// An element near a node.
#[derive(Clone, Copy)]
pub(super) struct Found {
    pub corners: [u32; 3],
    pub weights: [f64; 3],
    pub distance: f64,
    /// How squarely the node stands before it.
    pub squareness: f64,
}

impl<const D: usize> Contact<D> {
    /// The force of a row on its node and its energy; none where they do not touch.
    pub(super) fn meet(&self, row: &Row) -> Result<Option<Met<D>>, Passed> {
        let (meets, stiffness) = self.meeting(row);
        let (mut force, mut energy, mut touching) = (Vector::zeros(), 0.0, false);
        let mut least = f64::INFINITY;
        let mut under = None;
        self.each_part(row, meets, |near, weights, away, distance| {
            touching = true;
            let (energy_of, force_of) = response(stiffness * near.sign, meets, distance);
            energy += energy_of;
            force += away * (force_of / distance);
            if near.sign > 0.0 && distance < least {
                least = distance;
            }
            if (row.partner as usize) < self.bodies && near.count as usize == D {
                let squareness = squareness(&self.points(near.corners)[..D], &(away / distance));
                let nearer = under.is_none_or(|found: Found| {
                    let tie = (distance - found.distance).abs() <= 1e-9 * meets;
                    if tie { squareness > found.squareness } else { distance < found.distance }
                });
                if nearer {
                    under = Some(Found { corners: near.corners, weights, distance, squareness });
                }
            }
        });
        if !touching {
            return Ok(None);
        }
        if least <= PASSING * meets {
            return Err(self.passed(row));
        }
        let normal_force = force.norm();
        let normal = if normal_force > 0.0 { force / normal_force } else { Vector::zeros() };
        Ok(Some(Met { force, energy, normal_force, normal, under }))
    }

    /// Gives a body's nodes the opposite of what they do to a row's node.
    pub(super) fn push_back(&mut self, row: &Row) {
        if row.partner as usize >= self.bodies {
            return;
        }
        let (meets, stiffness) = self.meeting(row);
        let mut forces = std::mem::take(&mut self.forces);
        self.each_part(row, meets, |near, weights, away, distance| {
            let force = away * (response(stiffness * near.sign, meets, distance).1 / distance);
            for (&corner, weight) in near.corners[..near.count as usize].iter().zip(weights) {
                forces[corner as usize] -= force * weight;
            }
        });
        self.forces = forces;
    }

    /// Calls `visit(part, weights of its corners, from its nearest point to the node, distance)` for the
    /// parts of a row that are nearer than `meets` (m).
    fn each_part(&self, row: &Row, meets: f64, mut visit: impl FnMut(&Near, [f64; 3], Vector<D>, f64)) {
        let x = self.at[row.node as usize];
        let wall = (row.partner as usize).checked_sub(self.bodies);
        for near in &self.lists.near[row.parts.0 as usize..row.parts.1 as usize] {
            let (weights, away) = match wall {
                None => {
                    let points =
                        self.points(near.corners.map(|c| if c == u32::MAX { near.corners[0] } else { c }));
                    let points = &points[..near.count as usize];
                    let weights = nearest(&x, points);
                    (weights, points.iter().zip(weights).fold(x, |sum, (p, w)| sum - p * w))
                }
                Some(wall) => {
                    let part = &self.wall_parts[wall][near.corners[0] as usize].0;
                    (
                        [1.0, 0.0, 0.0],
                        match &self.poses[wall] {
                            None => x - part.nearest(&x),
                            Some(pose) => {
                                let rest = pose.at_rest(&x);
                                pose.turned(&(rest - part.nearest(&rest)))
                            }
                        },
                    )
                }
            };
            let distance = away.norm();
            if distance < meets {
                visit(near, weights, away, distance);
            }
        }
    }

    /// Whether a row's node was before a part of its partner when the sub-step began, and is now before its
    /// other side.
    pub(super) fn has_crossed(&self, row: &Row) -> bool {
        if self.meeting(row).0 == 0.0 {
            return false;
        }
        let wall = (row.partner as usize).checked_sub(self.bodies);
        let node = row.node as usize;
        self.lists.near[row.parts.0 as usize..row.parts.1 as usize].iter().any(|near| match wall {
            None => {
                near.count as usize == D && {
                    let nodes = &near.corners[..D];
                    let before = side(&self.began[node], nodes.iter().map(|&n| self.began[n as usize]));
                    let now = side(&self.at[node], nodes.iter().map(|&n| self.at[n as usize]));
                    before * now < 0.0
                }
            }
            Some(wall) => {
                let Part::Segment(a, b) = self.wall_parts[wall][near.corners[0] as usize].0 else {
                    return false;
                };
                let rest = |pose: Option<Pose<D>>, x: Vector<D>| pose.map_or(x, |pose| pose.at_rest(&x));
                let before = side(&rest(self.began_poses[wall], self.began[node]), [a, b].into_iter());
                before * side(&rest(self.poses[wall], self.at[node]), [a, b].into_iter()) < 0.0
            }
        })
    }

    pub(super) fn passed(&self, row: &Row) -> Passed {
        Passed {
            particle: self.surface.particles[row.node as usize] as usize,
            position: self.at[row.node as usize].as_slice().to_vec(),
            body: self.surface.bodies[row.node as usize] as usize,
            partner: row.partner as usize,
        }
    }

    pub(super) fn points(&self, corners: [u32; 3]) -> [Vector<D>; 3] {
        corners.map(|corner| self.at[corner as usize])
    }

    pub(super) fn under<'a>(&self, found: &'a Found, points: &'a [Vector<D>; 3]) -> Under<'a, D> {
        let Found { corners, weights, distance, .. } = found;
        Under { corners: &corners[..D], points: &points[..D], weights: *weights, distance: *distance }
    }
}

/// Energy (J) and force (N) at a distance (m) of a surface that is met at `meets` (m).
fn response(stiffness: f64, meets: f64, distance: f64) -> (f64, f64) {
    let depth = meets - distance;
    let square = depth * depth / (meets * meets);
    let (energy, force) = (0.5 + 0.5 * STIFFENING * square, 1.0 + 2.0 * STIFFENING * square);
    (stiffness * depth * depth * energy, stiffness * depth * force)
}

/// The sign of the side of a segment's line, or a triangle's plane, on which `x` is; 0 where the nearest
/// point is on its border.
fn side<const D: usize>(x: &Vector<D>, corners: impl Iterator<Item = Vector<D>>) -> f64 {
    let mut points = [Vector::zeros(); 3];
    points.iter_mut().zip(corners).for_each(|(to, from)| *to = from);
    let points = &points[..D];
    let weights = nearest(x, points);
    if weights[..D].iter().any(|&w| w <= 0.0) {
        return 0.0;
    }
    let (a, r) = (points[1] - points[0], x - points[0]);
    let volume = if D == 2 {
        a[0] * r[1] - a[1] * r[0]
    } else {
        let b = points[2] - points[0];
        (0..3).map(|i| (a[(i + 1) % D] * b[(i + 2) % D] - a[(i + 2) % D] * b[(i + 1) % D]) * r[i]).sum()
    };
    volume.signum()
}
