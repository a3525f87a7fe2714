//! Which nodes of the surface are near which parts of it, and near which walls.
//!
//! Lists hold all that is nearer than the thickness and a margin, and serve until something has gone half
//! of the margin: what they hold beyond the thickness has no force, so results do not depend on when they
//! were made.

use crate::contact::distance::nearest;
use crate::contact::surface::Surface;
use crate::contact::walls::Part;
use sph::Vector;

/// Parts of one partner that are near a node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// Node of the surface.
    pub node: u32,
    /// A body, or after all bodies a wall.
    pub partner: u32,
    /// Its parts in the list.
    pub parts: (u32, u32),
}

/// A part of a surface near a node: a point, a segment or a triangle, by its nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    /// Nodes; of a wall, the index of its part.
    pub corners: [u32; 3],
    /// How many of these count.
    pub count: u32,
    /// How often it counts.
    pub sign: f64,
}

/// The lists, and memory to make them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lists {
    pub rows: Vec<Row>,
    pub near: Vec<Near>,
    cells: Vec<([i32; 3], u32)>,
    found: Vec<(u32, u32)>,
    shared: Vec<[u32; 3]>,
}

/// What may meet what.
pub(crate) struct Rules<'a, const D: usize> {
    pub surface: &'a Surface,
    /// Reference positions (m) of the nodes.
    pub reference: &'a [Vector<D>],
    /// Distance (m) at which two bodies meet, bodies times bodies; 0 where they never do.
    pub thickness: &'a [f64],
    pub bodies: usize,
    /// Parts of a body that are nearer than this (m) in the reference configuration do not meet; one for each
    /// body.
    pub apart: &'a [f64],
    /// Margin (m).
    pub margin: f64,
}

impl Lists {
    /// Lists the surface's own parts near its nodes at `at` (m).
    pub fn of_bodies<const D: usize>(&mut self, rules: &Rules<D>, at: &[Vector<D>]) {
        self.rows.clear();
        self.near.clear();
        let surface = rules.surface;
        let greatest = rules.thickness.iter().copied().fold(0.0, f64::max);
        if greatest == 0.0 {
            return;
        }
        let mut edge = 0.0_f64;
        for element in &surface.elements {
            for k in 0..D {
                let (a, b) = (element[k] as usize, element[(k + 1) % D] as usize);
                edge = edge.max((at[a] - at[b]).norm_squared());
            }
        }
        // The nearest point of a segment is half its length from a corner at most, of a triangle 0.58 of its
        // longest edge.
        let reach = greatest + rules.margin + 0.6 * edge.sqrt();
        let cell_of = |x: &Vector<D>| -> [i32; 3] {
            // Last axis first, so that cells along the first are neighbours.
            std::array::from_fn(|k| if k + D >= 3 { (x[2 - k] / reach).floor() as i32 } else { 0 })
        };
        self.cells.clear();
        self.cells.extend(at.iter().enumerate().map(|(n, x)| (cell_of(x), n as u32)));
        self.cells.sort_unstable();
        for node in 0..at.len() {
            self.find(rules, at, node, cell_of(&at[node]), reach);
            self.list(rules, at, node);
        }
    }

    /// Elements of nodes within reach of a node, by partner, each once.
    fn find<const D: usize>(
        &mut self,
        rules: &Rules<D>,
        at: &[Vector<D>],
        node: usize,
        cell: [i32; 3],
        reach: f64,
    ) {
        let surface = rules.surface;
        let own = surface.bodies[node];
        self.found.clear();
        let layers = if D == 3 { -1..=1 } else { 0..=0 };
        for z in layers {
            for y in -1..=1 {
                let from = [cell[0] + z, cell[1] + y, cell[2] - 1];
                let to = [cell[0] + z, cell[1] + y, cell[2] + 1];
                let first = self.cells.partition_point(|(c, _)| *c < from);
                for &(_, other) in self.cells[first..].iter().take_while(|(c, _)| *c <= to) {
                    let body = surface.bodies[other as usize];
                    if rules.thickness[own as usize * rules.bodies + body as usize] == 0.0
                        || (at[other as usize] - at[node]).norm_squared() > reach * reach
                    {
                        continue;
                    }
                    let elements = surface.elements_at(other as usize);
                    self.found.extend(elements.iter().map(|&element| (body, element)));
                }
            }
        }
        self.found.sort_unstable();
        self.found.dedup();
    }

    /// Makes rows of what was found for a node.
    fn list<const D: usize>(&mut self, rules: &Rules<D>, at: &[Vector<D>], node: usize) {
        let surface = rules.surface;
        let own = surface.bodies[node];
        let apart = rules.apart[own as usize];
        let mut start = 0;
        while start < self.found.len() {
            let body = self.found[start].0;
            let within = rules.thickness[own as usize * rules.bodies + body as usize] + rules.margin;
            let first = self.near.len();
            let mut end = start;
            while end < self.found.len() && self.found[end].0 == body {
                let nodes = &surface.elements[self.found[end].1 as usize];
                end += 1;
                let far = |&n: &u32| (rules.reference[n as usize] - rules.reference[node]).norm() > apart;
                if body == own && !nodes[..D].iter().all(far) {
                    continue;
                }
                if distance(&at[node], &nodes[..D], at) < within {
                    self.near.push(Near { corners: *nodes, count: D as u32, sign: 1.0 });
                }
            }
            start = end;
            let elements = self.near.len();
            if elements > first {
                self.take_shared::<D>(first, elements);
                let parts = (first as u32, self.near.len() as u32);
                self.rows.push(Row { node: node as u32, partner: body, parts });
            }
        }
    }

    /// Lists what elements share, so that each place counts once: points of segments, edges and points of
    /// triangles. A point counts 1 less the elements and edges that it is in by how often these count.
    fn take_shared<const D: usize>(&mut self, first: usize, end: usize) {
        self.shared.clear();
        const NONE: u32 = u32::MAX;
        if D == 3 {
            for near in &self.near[first..end] {
                for k in 0..3 {
                    let (a, b) = (near.corners[k], near.corners[(k + 1) % 3]);
                    self.shared.push([a.min(b), a.max(b), NONE]);
                }
            }
            self.push_shared(2);
        }
        self.shared.clear();
        for near in &self.near[first..end] {
            self.shared.extend(near.corners[..D].iter().map(|&a| [a, NONE, NONE]));
        }
        let edges = end..self.near.len();
        // Points in the order of their numbers; what their edges take away has been listed.
        self.shared.sort_unstable();
        let mut n = 0;
        while n < self.shared.len() {
            let point = self.shared[n];
            let count = self.shared[n..].iter().take_while(|other| **other == point).count();
            n += count;
            let of_edges: f64 = self.near[edges.clone()]
                .iter()
                .filter(|edge| edge.corners[..2].contains(&point[0]))
                .map(|edge| edge.sign)
                .sum();
            let sign = 1.0 - count as f64 - of_edges;
            if sign != 0.0 {
                self.near.push(Near { corners: point, count: 1, sign });
            }
        }
    }

    fn push_shared(&mut self, count: u32) {
        self.shared.sort_unstable();
        let mut n = 0;
        while n < self.shared.len() {
            let part = self.shared[n];
            let times = self.shared[n..].iter().take_while(|other| **other == part).count();
            n += times;
            if times > 1 {
                self.near.push(Near { corners: part, count, sign: 1.0 - times as f64 });
            }
        }
    }

    /// Adds a row for a node and a wall whose parts are nearer to `rest` (m), the node as the wall at rest
    /// would see it, than `within` (m).
    pub fn of_wall<const D: usize>(
        &mut self,
        (node, partner): (u32, u32),
        rest: &Vector<D>,
        parts: &[(Part<D>, f64)],
        within: f64,
    ) {
        let first = self.near.len() as u32;
        for (n, (part, sign)) in parts.iter().enumerate() {
            if (rest - part.nearest(rest)).norm() < within {
                self.near.push(Near { corners: [n as u32, 0, 0], count: 1, sign: *sign });
            }
        }
        let end = self.near.len() as u32;
        if end > first {
            self.rows.push(Row { node, partner, parts: (first, end) });
        }
    }
}

/// Distance (m) of `x` from the part of a surface with these corners.
pub(crate) fn distance<const D: usize>(x: &Vector<D>, corners: &[u32], at: &[Vector<D>]) -> f64 {
    let mut points = [Vector::zeros(); 3];
    for (point, &corner) in points.iter_mut().zip(corners) {
        *point = at[corner as usize];
    }
    let points = &points[..corners.len()];
    let weights = nearest(x, points);
    (points.iter().zip(weights).fold(-x, |sum, (p, w)| sum + p * w)).norm()
}
