//! The outer surface of each body in the reference configuration, through the centres of its outer
//! particles: segments in two dimensions, triangles in three.
//!
//! On a lattice it is the border of all cells whose corners are particles. Particles that are no lattice
//! have the border that a ball as wide as `BALL` touches from outside (the α-shape of Edelsbrunner,
//! Kirkpatrick and Seidel 1983): segments (triangles) with nothing in one of the two balls through their
//! corners. Particles without a volume, points of a clamped face, are none of it: the surface's half
//! thickness reaches to the face by itself.

use crate::bodies::Body;
use sph::Vector;
use sph::neighbours::{CellGrid, NeighbourList};
use std::collections::HashMap;

/// Radius of the ball over the spacing. On a lattice the empty ball between particles has 0.71 (in three
/// dimensions 0.87).
const BALL: f64 = 1.2;

/// How far (fraction of the cell) a particle may be off the lattice.
const OFF_LATTICE: f64 = 1e-6;

/// Displacement (fraction of the spacing) that decides between the two diagonals of a square.
const ROUGH: f64 = 1e-5;

/// Surfaces of all bodies: nodes body after body.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surface {
    /// Particle of each node, ascending.
    pub particles: Vec<u32>,
    /// Body of each node.
    pub bodies: Vec<u32>,
    /// Nodes of each segment or triangle, as many as there are dimensions.
    pub elements: Vec<[u32; 3]>,
    /// Elements of each node: where they begin in `incident`.
    pub first_incident: Vec<u32>,
    pub incident: Vec<u32>,
}

impl Surface {
    /// The surfaces of all bodies.
    pub fn new<const D: usize>(bodies: &[Body<D>]) -> Self {
        let mut surface = Self::default();
        let mut first = 0;
        for (index, body) in bodies.iter().enumerate() {
            surface.add(index, first, elements_of(body));
            first += body.positions.len();
        }
        let mut incident: Vec<(u32, u32)> = Vec::new();
        for (e, nodes) in surface.elements.iter().enumerate() {
            incident.extend(nodes[..D].iter().map(|&node| (node, e as u32)));
        }
        incident.sort_unstable();
        surface.first_incident = vec![0; surface.particles.len() + 1];
        incident.iter().for_each(|(node, _)| surface.first_incident[*node as usize + 1] += 1);
        for node in 0..surface.particles.len() {
            surface.first_incident[node + 1] += surface.first_incident[node];
        }
        surface.incident = incident.into_iter().map(|(_, element)| element).collect();
        surface
    }

    /// Adds a body's elements, given by its own particles; they become nodes in their order.
    fn add<const D: usize>(&mut self, body: usize, first: usize, elements: Vec<[u32; D]>) {
        let mut particles: Vec<u32> = elements.iter().flatten().copied().collect();
        particles.sort_unstable();
        particles.dedup();
        let first_node = self.particles.len() as u32;
        for element in elements {
            let mut nodes = [0; 3];
            for (node, particle) in nodes.iter_mut().zip(element) {
                let index = particles.binary_search(&particle).expect("it is one of these");
                *node = first_node + index as u32;
            }
            self.elements.push(nodes);
        }
        self.bodies.resize(self.bodies.len() + particles.len(), body as u32);
        self.particles.extend(particles.into_iter().map(|particle| first as u32 + particle));
    }

    /// Elements that a node is a corner of.
    pub fn elements_at(&self, node: usize) -> &[u32] {
        &self.incident[self.first_incident[node] as usize..self.first_incident[node + 1] as usize]
    }
}

/// Elements of a body's surface by its own particles.
fn elements_of<const D: usize>(body: &Body<D>) -> Vec<[u32; D]> {
    let members: Vec<u32> =
        (0..body.positions.len() as u32).filter(|&i| body.volumes[i as usize] > 0.0).collect();
    of_lattice(body, &members).unwrap_or_else(|| of_points(body, &members))
}

/// The border of all full cells; none where particles are no lattice or are in no full cell.
fn of_lattice<const D: usize>(body: &Body<D>, members: &[u32]) -> Option<Vec<[u32; D]>> {
    let low =
        members.iter().fold(Vector::repeat(f64::INFINITY), |low, &i| body.positions[i as usize].inf(&low));
    let mut at: HashMap<[i32; D], u32> = HashMap::with_capacity(members.len());
    let mut places = Vec::with_capacity(members.len());
    for &i in members {
        let offset = (body.positions[i as usize] - low).component_div(&body.cell);
        let place: [i32; D] = std::array::from_fn(|a| offset[a].round() as i32);
        let off = (0..D).map(|a| (offset[a] - f64::from(place[a])).abs()).fold(0.0, f64::max);
        if off > OFF_LATTICE * (1.0 + offset.amax()) || at.insert(place, i).is_some() {
            return None;
        }
        places.push(place);
    }
    let corner = |cell: &[i32; D], n: usize| -> [i32; D] {
        std::array::from_fn(|a| cell[a] + i32::from(n >> a & 1 == 1))
    };
    let is_full = |cell: &[i32; D]| (0..1 << D).all(|n| at.contains_key(&corner(cell, n)));
    let mut in_cell = 0;
    let mut elements = Vec::new();
    for place in &places {
        let around = (0..1 << D)
            .map(|n| -> [i32; D] { std::array::from_fn(|a| place[a] - i32::from(n >> a & 1 == 1)) });
        in_cell += usize::from(around.into_iter().any(|cell| is_full(&cell)));
        if !is_full(place) {
            continue;
        }
        for axis in 0..D {
            for high in [false, true] {
                let mut beyond = *place;
                beyond[axis] += if high { 1 } else { -1 };
                if is_full(&beyond) {
                    continue;
                }
                let face: Vec<u32> = (0..1usize << D)
                    .filter(|n| (n >> axis & 1 == 1) == high)
                    .map(|n| at[&corner(place, n)])
                    .collect();
                // Corners of a square in the order 00, 10, 01, 11: two triangles along 10–01.
                for first in 0..D - 1 {
                    elements.push(std::array::from_fn(|k| face[first + k]));
                }
            }
        }
    }
    (in_cell == members.len()).then_some(elements)
}

/// What a ball touches from outside.
fn of_points<const D: usize>(body: &Body<D>, members: &[u32]) -> Vec<[u32; D]> {
    let (spacing, radius) = (body.spacing(), BALL * body.spacing());
    let points: Vec<Vector<D>> =
        members.iter().map(|&i| body.positions[i as usize] + roughness(i) * (ROUGH * spacing)).collect();
    let mut list = NeighbourList::default();
    list.rebuild(&points, &CellGrid::new(&points, 2.0 * radius), &points);
    let mut elements = Vec::new();
    let mut with = |element: [u32; D]| {
        // A centre's ball reaches no farther than those that its corner has in the list.
        let corners = element.map(|n| points[n as usize]);
        let others = || list.of(element[0] as usize).iter().filter(|n| !element.contains(n));
        let is_empty = |centre: Vector<D>| others().all(|&n| (points[n as usize] - centre).norm() >= radius);
        if centres(&corners, radius).is_some_and(|both| both.into_iter().any(is_empty)) {
            elements.push(element.map(|n| members[n as usize]));
        }
    };
    for i in 0..points.len() as u32 {
        let after: Vec<u32> = list.of(i as usize).iter().copied().filter(|&j| j > i).collect();
        for (n, &j) in after.iter().enumerate() {
            if D == 2 {
                with(std::array::from_fn(|k| [i, j][k]));
            } else {
                after[n + 1..]
                    .iter()
                    .for_each(|&k| with(std::array::from_fn(|c| [i, j.min(k), j.max(k)][c])));
            }
        }
    }
    elements
}

/// A vector of components in ±1, the same at every run.
fn roughness<const D: usize>(n: u32) -> Vector<D> {
    let mut seed = u64::from(n).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    Vector::from_fn(|_, _| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / (1u64 << 30) as f64 - 1.0
    })
}

/// Centres of the two balls through all corners; none where these are too far apart or on a line.
fn centres<const D: usize>(corners: &[Vector<D>; D], radius: f64) -> Option<[Vector<D>; 2]> {
    let u = corners[1] - corners[0];
    let (to_centre, normal): (Vector<D>, Vector<D>) = if D == 2 {
        (u * 0.5, Vector::from_fn(|i, _| if i == 0 { -u[1] } else { u[0] }))
    } else {
        let v = corners[2] - corners[0];
        let normal =
            Vector::from_fn(|i, _| u[(i + 1) % D] * v[(i + 2) % D] - u[(i + 2) % D] * v[(i + 1) % D]);
        let (uu, uv, vv) = (u.norm_squared(), u.dot(&v), v.norm_squared());
        let twice = 2.0 * (uu * vv - uv * uv);
        if twice <= 1e-9 * uu * vv {
            return None;
        }
        ((u * (vv * (uu - uv)) + v * (uu * (vv - uv))) / twice, normal)
    };
    let height = radius * radius - to_centre.norm_squared();
    let normal = normal / normal.norm();
    (height > 0.0).then(|| [1.0, -1.0].map(|s| corners[0] + to_centre + normal * (s * height.sqrt())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::materials::{Law, Material, Plane};

    const MATERIAL: Material = Material::new(Law::StVenantKirchhoff, 1.0, 0.3, Plane::Strain);

    /// Each inner point of a closed chain is in two segments, each edge of a closed surface in two triangles.
    fn is_closed<const D: usize>(surface: &Surface) -> bool {
        let mut ridges: HashMap<Vec<u32>, usize> = HashMap::new();
        for element in &surface.elements {
            for left_out in 0..D {
                let mut ridge: Vec<u32> = (0..D).filter(|&k| k != left_out).map(|k| element[k]).collect();
                ridge.sort_unstable();
                *ridges.entry(ridge).or_default() += 1;
            }
        }
        ridges.values().all(|&count| count == 2)
    }

    #[test]
    fn a_box_has_its_border_whatever_finds_it() {
        let flat = Body::block(Vector::from([0.0, 0.0]), Vector::from([6.0, 4.0]), 1.0, MATERIAL, 1.0);
        let solid = Body::block(Vector::zeros(), Vector::<3>::from([4.0, 3.0, 3.0]), 1.0, MATERIAL, 1.0);
        let members: Vec<u32> = (0..solid.positions.len() as u32).collect();
        let by_ball = of_points(&flat, &members[..24]);
        let surface = Surface::new(std::slice::from_ref(&flat));
        assert_eq!((surface.particles.len(), surface.elements.len(), by_ball.len()), (16, 16, 16));
        assert!(is_closed::<2>(&surface));
        let surface = Surface::new(std::slice::from_ref(&solid));
        // Quads of the faces of 3 × 2 × 2 cells, two triangles each.
        assert_eq!((surface.particles.len(), surface.elements.len()), (34, 2 * 32));
        assert!(is_closed::<3>(&surface));
        let mut by_ball = Surface::default();
        by_ball.add(0, 0, of_points(&solid, &members));
        assert_eq!((by_ball.particles.len(), by_ball.elements.len()), (34, 2 * 32));
        assert!(is_closed::<3>(&by_ball));
    }

    #[test]
    fn points_of_a_clamped_face_are_none_of_the_surface_and_a_hollow_has_its_own() {
        let body = Body::block(Vector::from([0.0, 0.0]), Vector::from([6.0, 4.0]), 1.0, MATERIAL, 1.0)
            .with_fixed_face(0, crate::bodies::Side::Low);
        assert_eq!(Surface::new(&[body]).particles.len(), 16);
        let mut ring = Body::block(Vector::from([0.0, 0.0]), Vector::from([8.0, 8.0]), 1.0, MATERIAL, 1.0);
        let keep = |p: &Vector<2>| (p - Vector::from([4.0, 4.0])).amax() > 2.0;
        ring.positions.retain(keep);
        ring.volumes.truncate(ring.positions.len());
        ring.clamped.truncate(ring.positions.len());
        let surface = Surface::new(&[ring]);
        assert_eq!(surface.elements.len(), 28 + 20);
        assert!(is_closed::<2>(&surface));
    }
}
