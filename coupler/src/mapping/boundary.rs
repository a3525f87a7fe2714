//! A boundary of facets in a tree of boxes: the facets near a point, and those that a line meets.
//!
//! What a search finds does not depend on the shape of the tree: of equal candidates the facet with the
//! smaller number is taken.

use super::cell_grid::distance_squared;
use super::error::MappingError;
use super::facet;
use super::semidefinite::dot;

/// Facets of a leaf.
const LEAF: usize = 4;
/// A tree over `u32` facets, halved at every level, is not deeper; a search leaves one node a level to be
/// looked at, and has two in hand.
const DEPTH: usize = 36;

/// A box, a little widened, with what is in it: children, or facets.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    lower: [f64; 3],
    upper: [f64; 3],
    /// Slots of its facets.
    from: u32,
    to: u32,
    /// The second child (the first follows its parent); zero for a leaf.
    second: u32,
}

/// Which way the facets of a node look.
#[derive(Clone, Copy, Debug, Default)]
struct Normals {
    /// Middle of the box.
    middle: [f64; 3],
    /// A unit vector, and how far from it the unit normal of a facet is at most.
    normal: [f64; 3],
    spread: f64,
    /// How far from the middle a point of the box is at most, across that vector.
    across: f64,
}

/// Memory of a search.
#[derive(Clone, Debug)]
pub(super) struct Stack {
    /// Nodes still to be looked at, and the distance squared (m²) of each where it is known.
    nodes: [u32; DEPTH],
    distances: [f64; DEPTH],
    length: usize,
}

/// The boundary: facets of `D` vertices, by number of source point.
#[derive(Clone, Debug)]
pub(super) struct Boundary {
    facets: Vec<usize>,
    /// Positions of the facets' vertices (m), flat.
    corners: Vec<f64>,
    /// Facets in the order of the leaves.
    order: Vec<u32>,
    nodes: Vec<Node>,
    normals: Vec<Normals>,
    /// Whether every edge (in the plane: vertex) joins two facets.
    closed: bool,
}

/// A point of the boundary.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot<const D: usize> {
    pub facet: usize,
    pub barycentric: [f64; D],
    pub position: [f64; D],
}

impl Boundary {
    /// A boundary whose tree is not built yet.
    pub fn new(facets: Vec<usize>, dimension: usize) -> Result<Self, MappingError> {
        if facets.is_empty() || !facets.len().is_multiple_of(dimension) {
            return Err(MappingError::Facets { length: facets.len(), dimension });
        }
        let closed = is_closed(&facets, dimension);
        let (corners, order, nodes, normals) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Ok(Self { facets, corners, order, nodes, normals, closed })
    }

    /// Builds the tree for the positions `source` of the points; later only its boxes are drawn anew.
    pub fn update<const D: usize>(&mut self, source: &[[f64; D]]) -> Result<(), MappingError> {
        if let Some(at) = self.facets.iter().position(|&vertex| vertex >= source.len()) {
            let (facet, vertex) = (at / D, self.facets[at]);
            return Err(MappingError::Vertex { facet, vertex, points: source.len() });
        }
        self.corners.clear();
        self.corners.extend(self.facets.iter().flat_map(|&vertex| source[vertex]));
        self.check(source)?;
        if self.nodes.is_empty() {
            self.order = (0..(self.facets.len() / D) as u32).collect();
            self.split(source, 0, self.order.len());
        }
        self.normals.resize(self.nodes.len(), Normals::default());
        for node in (0..self.nodes.len()).rev() {
            self.draw(source, node);
        }
        Ok(())
    }

    /// Vertices of a facet, by number of source point.
    pub fn vertices<const D: usize>(&self, facet: usize) -> &[usize; D] {
        &self.facets.as_chunks().0[facet]
    }

    /// Positions of a facet's vertices.
    #[inline]
    pub fn corners<const D: usize>(&self, facet: usize) -> &[[f64; D]; D] {
        &self.corners.as_chunks::<D>().0.as_chunks::<D>().0[facet]
    }

    /// Visits facets that may be nearer to `x` than a bound, near boxes first; with `upright` only those that
    /// may have a line to it perpendicular to them, up to an angle of 1e-6. `visit(facet, bound)` returns the
    /// next bound, a distance squared (m²); facets at exactly the bound are visited too.
    pub fn visit_near<const D: usize>(
        &self,
        x: &[f64; D],
        bound: f64,
        upright: bool,
        stack: &mut Stack,
        mut visit: impl FnMut(usize, f64) -> f64,
    ) {
        let (mut bound, mut bound_root) = (bound, bound.sqrt());
        stack.length = 0;
        stack.push(0, self.nodes[0].distance_squared(x));
        while let Some((at, distance)) = stack.pop() {
            if distance > bound {
                continue;
            }
            let node = &self.nodes[at];
            if upright && self.normals[at].is_beside(x, bound_root) {
                continue;
            }
            if node.second == 0 {
                for &facet in &self.order[node.from as usize..node.to as usize] {
                    bound = visit(facet as usize, bound);
                }
                bound_root = bound.sqrt();
            } else {
                let [first, second] = [at + 1, node.second as usize];
                let first = (first, self.nodes[first].distance_squared(x));
                let second = (second, self.nodes[second].distance_squared(x));
                let (near, far) = if first.1 <= second.1 { (first, second) } else { (second, first) };
                for (child, distance) in [far, near] {
                    if distance <= bound {
                        stack.push(child, distance);
                    }
                }
            }
        }
    }

    /// The nearest point of the boundary, and its distance squared (m²). The search is short where the facet
    /// that `hint` names is near.
    pub fn nearest<const D: usize>(
        &self,
        x: &[f64; D],
        hint: Option<usize>,
        stack: &mut Stack,
    ) -> (Foot<D>, f64) {
        let mut best: Option<(f64, Foot<D>)> = None;
        let mut look_at = |facet| {
            let foot = self.foot(facet, x);
            let squared = distance_squared(&foot.position, x);
            if best.is_none_or(|(least, ref nearest)| (squared, facet) < (least, nearest.facet)) {
                best = Some((squared, foot));
            }
            best.map_or(f64::INFINITY, |(least, _)| least)
        };
        let bound = hint.map_or(f64::INFINITY, &mut look_at);
        self.visit_near(x, bound, false, stack, |facet, _| look_at(facet));
        let (squared, foot) = best.expect("a boundary has a facet, and positions are finite");
        (foot, squared)
    }

    /// The point of `facet` nearest to `x`.
    #[inline]
    pub fn foot<const D: usize>(&self, facet: usize, x: &[f64; D]) -> Foot<D> {
        let corners = self.corners(facet);
        let barycentric = facet::nearest(corners, x);
        Foot { facet, barycentric, position: facet::point(corners, &barycentric) }
    }

    /// The first point beyond `t > after` where the ray `origin + t direction` meets the boundary, with its
    /// `t`. The search is short where the facet that `hint` names is met soon.
    pub fn first_meeting<const D: usize>(
        &self,
        origin: &[f64; D],
        direction: &[f64; D],
        after: f64,
        hint: Option<usize>,
        stack: &mut Stack,
    ) -> Option<(f64, Foot<D>)> {
        let mut best: Option<(f64, usize, [f64; D])> = None;
        let mut look_at = |facet: usize| {
            let corners = self.corners(facet);
            if !facet::is_missed(corners, origin, direction)
                && let Some((t, b)) = facet::meet(corners, origin, direction)
                && t > after
                && best.is_none_or(|(best_t, best_facet, _)| (t, facet) < (best_t, best_facet))
            {
                best = Some((t, facet, b));
            }
            best.map_or(f64::INFINITY, |(t, ..)| t)
        };
        let mut bound = hint.map_or(f64::INFINITY, &mut look_at);
        let inverse = direction.map(|c| 1.0 / c);
        stack.length = 0;
        stack.push(0, 0.0);
        while let Some((at, _)) = stack.pop() {
            let node = &self.nodes[at];
            if !node.is_met(origin, &inverse, after, bound) {
                continue;
            }
            if node.second == 0 {
                for &facet in &self.order[node.from as usize..node.to as usize] {
                    bound = look_at(facet as usize);
                }
            } else {
                stack.push(node.second as usize, 0.0);
                stack.push(at + 1, 0.0);
            }
        }
        best.map(|(t, facet, barycentric)| {
            let position = facet::point(self.corners(facet), &barycentric);
            (t, Foot { facet, barycentric, position })
        })
    }

    /// All facets name points there are, have an extent, and a closed boundary is not inside out.
    fn check<const D: usize>(&self, source: &[[f64; D]]) -> Result<(), MappingError> {
        let mut volume = 0.0;
        for (facet, vertices) in self.facets.as_chunks::<D>().0.iter().enumerate() {
            let corners = self.corners::<D>(facet);
            let normal = facet::normal(corners);
            let longest = (1..D).map(|k| distance_squared(&corners[k], &corners[0])).fold(0.0, f64::max);
            // Length of the normal: that of the segment, or base times height of the triangle.
            let extent = dot(&normal, &normal);
            if extent <= 1e-24 * longest.powi(D as i32 - 1) {
                return Err(MappingError::FlatFacet { facet, vertices: vertices.to_vec() });
            }
            let from_first: [f64; D] = std::array::from_fn(|i| corners[0][i] - source[0][i]);
            volume += dot(&normal, &from_first) / [2.0, 6.0][D - 2];
        }
        if self.closed && volume < 0.0 {
            return Err(MappingError::Inwards { volume });
        }
        Ok(())
    }

    /// Adds the node of the slots `from..to` and its children; boxes are drawn later.
    fn split<const D: usize>(&mut self, source: &[[f64; D]], from: usize, to: usize) {
        let at = self.nodes.len();
        self.nodes.push(Node { from: from as u32, to: to as u32, ..Node::default() });
        if to - from <= LEAF {
            return;
        }
        self.draw_box_of_slots(source, at);
        let node = &self.nodes[at];
        let extent = |i: usize| node.upper[i] - node.lower[i];
        let axis = (0..D).fold(0, |best, i| if extent(i) > extent(best) { i } else { best });
        let facets = &self.facets;
        let center = |facet: u32| -> f64 {
            facets[D * facet as usize..D * (facet as usize + 1)].iter().map(|&v| source[v][axis]).sum()
        };
        let middle = (to - from) / 2;
        self.order[from..to]
            .select_nth_unstable_by(middle, |&a, &b| center(a).total_cmp(&center(b)).then(a.cmp(&b)));
        self.split(source, from, from + middle);
        self.nodes[at].second = self.nodes.len() as u32;
        self.split(source, from + middle, to);
    }

    /// Draws a node's box and normals; those of its children are drawn.
    fn draw<const D: usize>(&mut self, source: &[[f64; D]], at: usize) {
        let second = self.nodes[at].second as usize;
        if second == 0 {
            self.draw_box_of_slots(source, at);
        } else {
            let (a, b) = (self.nodes[at + 1], self.nodes[second]);
            let node = &mut self.nodes[at];
            for i in 0..D {
                node.lower[i] = a.lower[i].min(b.lower[i]);
                node.upper[i] = a.upper[i].max(b.upper[i]);
            }
        }
        let mut normals = if second == 0 {
            let Node { from, to, .. } = self.nodes[at];
            Normals::of::<D>(self.order[from as usize..to as usize].iter().map(|&facet| {
                let normal = facet::normal(self.corners::<D>(facet as usize));
                let length = dot(&normal, &normal).sqrt();
                let mut unit = [0.0; 3];
                (0..D).for_each(|i| unit[i] = normal[i] / length);
                (unit, 0.0)
            }))
        } else {
            Normals::of::<D>([at + 1, second].into_iter().map(|child| {
                let Normals { normal, spread, .. } = self.normals[child];
                (normal, spread)
            }))
        };
        self.nodes[at].widen::<D>();
        normals.measure::<D>(&self.nodes[at]);
        self.normals[at] = normals;
    }

    fn draw_box_of_slots<const D: usize>(&mut self, source: &[[f64; D]], at: usize) {
        let node = &mut self.nodes[at];
        (node.lower, node.upper) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &facet in &self.order[node.from as usize..node.to as usize] {
            for &vertex in &self.facets[D * facet as usize..D * (facet as usize + 1)] {
                for i in 0..D {
                    node.lower[i] = node.lower[i].min(source[vertex][i]);
                    node.upper[i] = node.upper[i].max(source[vertex][i]);
                }
            }
        }
    }
}

impl Node {
    #[inline]
    fn distance_squared<const D: usize>(&self, x: &[f64; D]) -> f64 {
        let mut sum = 0.0;
        for i in 0..D {
            let off = larger(larger(self.lower[i] - x[i], x[i] - self.upper[i]), 0.0);
            sum += off * off;
        }
        // A facet's distance is rounded otherwise than its box's: do not cut off what is equally near.
        sum * (1.0 - 1e-12)
    }

    fn widen<const D: usize>(&mut self) {
        let mut widest = 0.0;
        for i in 0..D {
            widest = larger(widest, self.upper[i] - self.lower[i]);
        }
        for i in 0..D {
            self.lower[i] -= 1e-8 * widest;
            self.upper[i] += 1e-8 * widest;
        }
    }

    /// Whether `origin + t direction` meets the box for a `t` in `from..=to`. `inverse` has one over each
    /// component of the direction; an infinite one makes the two bounds of its axis infinite, of one sign
    /// where the origin is outside.
    #[inline]
    fn is_met<const D: usize>(&self, origin: &[f64; D], inverse: &[f64; D], from: f64, to: f64) -> bool {
        let (mut from, mut to) = (from, to * (1.0 + 1e-8));
        for i in 0..D {
            let (low, high) = (self.lower[i] - origin[i], self.upper[i] - origin[i]);
            // On the very edge of a widened box the product of zero and infinity is no number, and the box
            // may be missed: nothing in it is met there.
            let (a, b) = (low * inverse[i], high * inverse[i]);
            from = larger(from, smaller(a, b));
            to = smaller(to, larger(a, b));
        }
        from <= to
    }
}

impl Normals {
    /// From those of parts, with how far others are from them.
    fn of<const D: usize>(parts: impl Iterator<Item = ([f64; 3], f64)> + Clone) -> Self {
        let mut sum = [0.0; 3];
        for (normal, _) in parts.clone() {
            (0..D).for_each(|i| sum[i] += normal[i]);
        }
        let length = dot(&sum, &sum).sqrt();
        // Normals that cancel each other have no mean: any vector does.
        let normal = if length > 0.0 { sum.map(|c| c / length) } else { [1.0, 0.0, 0.0] };
        let mut spread = 0.0;
        for (part, more) in parts {
            spread = larger(spread, distance_squared(&part, &normal).sqrt() + more);
        }
        Self { normal, spread, ..Self::default() }
    }

    /// Where the box is, and how far it extends.
    fn measure<const D: usize>(&mut self, node: &Node) {
        let mut side = [0.0; 3];
        for i in 0..D {
            self.middle[i] = 0.5 * (node.lower[i] + node.upper[i]);
            side[i] = node.upper[i] - self.middle[i];
        }
        let mut squared = 0.0;
        for corner in 0..1 << (D - 1) {
            let off: [f64; 3] =
                std::array::from_fn(|i| if corner >> i & 1 == 1 { -side[i] } else { side[i] });
            squared = larger(squared, dot(&off, &off) - dot(&off, &self.normal).powi(2));
        }
        // Of a box that is flat the difference of squares may round to nothing.
        self.across = squared.sqrt() + 1e-7 * dot(&side, &side).sqrt();
    }

    /// Whether no facet has a point within the bound (whose root is in m) from which `x` is perpendicular to
    /// the facet, up to an angle of 1e-6.
    ///
    /// With `p` such a point, `n` the unit normal there and `m` the node's vector: what is across `m` of
    /// `x − p = ± |x − p| n` is no longer than `|x − p| |n − m|`.
    #[inline]
    fn is_beside<const D: usize>(&self, x: &[f64; D], bound_root: f64) -> bool {
        let (mut squared, mut along) = (0.0, 0.0);
        for i in 0..D {
            let off = x[i] - self.middle[i];
            squared += off * off;
            along += off * self.normal[i];
        }
        let limit = self.across + bound_root * (self.spread + 2e-6);
        // The difference of squares is rounded.
        squared - along * along - 1e-12 * squared > limit * limit
    }
}

/// One instruction, other than [`f64::max`], which has to mind what is no number.
#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

impl Default for Stack {
    fn default() -> Self {
        Self { nodes: [0; DEPTH], distances: [0.0; DEPTH], length: 0 }
    }
}

impl Stack {
    #[inline]
    fn push(&mut self, node: usize, distance: f64) {
        self.nodes[self.length] = node as u32;
        self.distances[self.length] = distance;
        self.length += 1;
    }

    #[inline]
    fn pop(&mut self) -> Option<(usize, f64)> {
        self.length = self.length.checked_sub(1)?;
        Some((self.nodes[self.length] as usize, self.distances[self.length]))
    }
}

/// Whether every edge of a triangle is run through once in either direction, and every vertex of a polyline
/// is once a first and once a second.
fn is_closed(facets: &[usize], dimension: usize) -> bool {
    let mut sides: Vec<(usize, usize)> = Vec::new();
    for vertices in facets.chunks_exact(dimension) {
        match *vertices {
            [a, b] => sides.extend([(a, usize::MAX), (usize::MAX, b)]),
            [a, b, c] => sides.extend([(a, b), (b, c), (c, a)]),
            _ => return false,
        }
    }
    sides.sort_unstable();
    sides.windows(2).all(|pair| pair[0] != pair[1])
        && sides.iter().all(|&(a, b)| sides.binary_search(&(b, a)).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn knows_closed_boundaries() {
        assert!(is_closed(&[0, 1, 1, 2, 2, 0], 2));
        assert!(!is_closed(&[0, 1, 1, 2], 2));
        assert!(!is_closed(&[0, 1, 1, 2, 0, 2], 2));
        assert!(is_closed(&[0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3], 3));
        assert!(!is_closed(&[0, 2, 1, 0, 1, 3, 1, 2, 3], 3));
    }

    /// A circle of 97 segments: searches in the tree against all facets.
    #[test]
    fn finds_what_a_search_over_all_facets_finds() {
        let count = 97;
        let angle = |i: usize| std::f64::consts::TAU * i as f64 / count as f64;
        let source: Vec<[f64; 2]> = (0..count).map(|i| [angle(i).cos(), angle(i).sin()]).collect();
        let facets = (0..count).flat_map(|i| [i, (i + 1) % count]).collect();
        let mut boundary = Boundary::new(facets, 2).unwrap();
        boundary.update(&source).unwrap();
        for k in 0..300 {
            let x = [1.3 * (0.7 * k as f64).sin(), 1.1 * (1.3 * k as f64).cos()];
            let all = (0..count).map(|f| (distance_squared(&boundary.foot(f, &x).position, &x), f));
            let best = all.min_by(|a, b| a.partial_cmp(b).unwrap()).unwrap();
            let (foot, distance) = boundary.nearest(&x, None, &mut Stack::default());
            assert_eq!((distance, foot.facet), best);
            let direction = [(k as f64).cos(), (k as f64).sin()];
            let meetings = (0..count).filter_map(|f| {
                let (t, _) = facet::meet(boundary.corners(f), &x, &direction)?;
                (t > 0.1).then_some((t, f))
            });
            let first = meetings.min_by(|a, b| a.partial_cmp(b).unwrap());
            let found = boundary.first_meeting(&x, &direction, 0.1, None, &mut Stack::default());
            assert_eq!(found.map(|(t, foot)| (t, foot.facet)), first);
        }
    }

    /// Of two waves, one in the plane and one in space: no facet with an upright foot within the bound is
    /// passed by.
    #[test]
    fn finds_all_facets_upright_to_a_point() {
        let line: Vec<[f64; 2]> =
            (0..80).map(|i| [0.1 * i as f64, (0.3 * i as f64).sin() * (i % 9) as f64 * 0.1]).collect();
        finds_upright(&line, (0..79).flat_map(|i| [i, i + 1]).collect());
        let at = |i: usize| [(i % 12) as f64, (i / 12) as f64].map(|c| 0.2 * c);
        let height = |[x, y]: [f64; 2]| 0.2 * (4.0 * x).sin() * (3.0 * y).cos();
        let sheet: Vec<[f64; 3]> = (0..144).map(|i| [at(i)[0], at(i)[1], height(at(i))]).collect();
        let squares = (0..132).filter(|i| i % 12 < 11);
        finds_upright(&sheet, squares.flat_map(|i| [i, i + 1, i + 13, i, i + 13, i + 12]).collect());
    }

    fn finds_upright<const D: usize>(source: &[[f64; D]], facets: Vec<usize>) {
        let count = facets.len() / D;
        let mut boundary = Boundary::new(facets, D).unwrap();
        boundary.update(source).unwrap();
        let (mut seen, mut passed_by) = (0, 0);
        for k in 0..400 {
            // Near the boundary and up to one metre off.
            let mut x = source[(k * 7) % source.len()];
            x[0] += 0.13 * (1.7 * k as f64).sin();
            x[D - 1] += (0.9 * k as f64).cos();
            let bound = 0.2 * (1.0 + (0.37 * k as f64).sin());
            let mut visited = vec![false; count];
            boundary.visit_near(&x, bound, true, &mut Stack::default(), |facet, bound| {
                visited[facet] = true;
                bound
            });
            for f in 0..count {
                let foot = boundary.foot(f, &x);
                let off: [f64; D] = std::array::from_fn(|i| x[i] - foot.position[i]);
                let (normal, squared) = (facet::normal(boundary.corners::<D>(f)), dot(&off, &off));
                let upright = dot(&off, &normal).powi(2) >= (1.0 - 1e-12) * squared * dot(&normal, &normal);
                assert!(visited[f] || !upright || squared > bound, "facet {f} from {x:?}");
                seen += usize::from(upright && squared <= bound);
                passed_by += usize::from(!visited[f]);
            }
        }
        assert!(seen > 100 && passed_by > 200 * count, "{seen} {passed_by}");
    }
}
