//! Filling of walls with particles: each place once, whatever the last bit of a coordinate is.
//!
//! Ties are settled in one way: half a cell counts as a cell, and what lies on a surface is outside, both to
//! [`TIE`]. So walls that are moved or mirrored have the same particles.
//!
//! # Where a polyline ends at another wall
//!
//! Its rows end at the end of its last piece, and the other wall begins at its own surface: behind the corner
//! between them a quarter may be open, which the fluid in the corner would feel. So the rows go on straight
//! as far as the other wall covers the line, in the cells that no wall fills.

use crate::boundaries::shapes::{Side, WallPart, WallShape, fluid_side};
use crate::boundaries::wall_motion::Motion;
use crate::error::Error;
use sph::Vector;
use sph::lattice::{self, Lattice, TIE};

/// The particles with which parts are filled.
#[derive(Default)]
pub struct Filling<const D: usize> {
    /// Positions (m).
    pub positions: Vec<Vector<D>>,
    /// Volumes (m³).
    pub volumes: Vec<f64>,
    /// Depths (m) under the surface of their part.
    pub depths: Vec<f64>,
    /// Parts that they belong to.
    pub part_of: Vec<u32>,
    /// Those of them that a wall which slides along itself passes by.
    pub columns: Vec<Column<D>>,
}

impl<const D: usize> Filling<D> {
    /// Fills the parts with particles about `spacing` (m) apart, as deep as `support` (m). Where parts
    /// overlap, the earlier one fills.
    ///
    /// # Errors
    /// [`Error::Setting`] for a box turned inside out, a polyline of fewer than two distinct points or one in
    /// three dimensions.
    pub fn new(parts: &[WallPart<D>], spacing: f64, support: f64) -> Result<Self, Error> {
        parts.iter().try_for_each(refuse_impossible)?;
        let solids = Solids::new(parts, spacing, support);
        let mut filling = Self::default();
        for (index, part) in parts.iter().enumerate() {
            match &part.shape {
                WallShape::Box { low, high } => filling.fill_box(index, (low, high), &solids),
                WallShape::Polyline { .. } => filling.fill_polyline(index, &solids),
            }
        }
        let first = filling.positions.len();
        for index in 0..parts.len() {
            filling.continue_ends(index, first, &solids);
        }
        Ok(filling)
    }

    fn fill_box(&mut self, index: usize, (low, high): (&Vector<D>, &Vector<D>), solids: &Solids<'_, D>) {
        let (part, reach) = (&solids.parts[index], solids.reach());
        let lattice = Lattice::fill_box(*low, *high, solids.spacing);
        let volume = lattice.cell_volume();
        let depth = |p: &Vector<D>| -part.shape.surface_point(p).distance;
        let shallow = |p: &&Vector<D>| depth(p) < reach - solids.tolerance();
        let between = slides_along(part, &lattice, reach);
        let is_between =
            |p: &Vector<D>| between.is_some_and(|(axis, low, high)| (low..high).contains(&p[axis]));
        for p in lattice.positions.iter().filter(shallow) {
            if !is_between(p) && solids.is_free_for(index, p) {
                self.add(index, *p, depth(p), volume);
            }
        }
        let Some((axis, low, high)) = between else { return };
        let edge = lattice.cell[axis];
        let in_first_row = |p: &&Vector<D>| p[axis] > low && p[axis] < low + edge;
        let cells = ((high - low) / edge).round() as usize;
        let along = Vector::from_fn(|i, _| if i == axis { edge } else { 0.0 });
        for p in lattice.positions.iter().filter(in_first_row).filter(shallow) {
            self.add_column(index, p - along * 0.5, depth(p), along, volume, cells);
        }
    }

    fn fill_polyline(&mut self, index: usize, solids: &Solids<'_, D>) {
        let (part, spacing) = (&solids.parts[index], solids.spacing);
        for strip in &solids.strips[index] {
            for row in 0..solids.rows() {
                let depth = (row as f64 + 0.5) * spacing;
                let [before, beyond] = strip.cells_in_corners(row);
                for k in 0..before {
                    self.add_if_free(index, strip.at(-(k as f64 + 0.5) * spacing, depth), spacing, solids);
                }
                for k in 0..beyond {
                    let along = strip.length + (k as f64 + 0.5) * spacing;
                    self.add_if_free(index, strip.at(along, depth), spacing, solids);
                }
                let (from, to) = strip.row(row, spacing);
                if to <= from {
                    continue;
                }
                let cells = lattice::cells(to - from, spacing);
                let edge = (to - from) / cells as f64;
                let (start, along) = (strip.at(from, depth), strip.direction * edge);
                let mut ends = (solids.reach() / edge - TIE).ceil() as usize;
                if !slides_with(part, &along) || cells <= 2 * ends {
                    ends = cells;
                }
                for i in (0..ends).chain((cells - ends).max(ends)..cells) {
                    self.add_if_free(index, start + along * (i as f64 + 0.5), edge, solids);
                }
                if ends < cells {
                    let start = start + along * ends as f64;
                    self.add_column(index, start, depth, along, edge * spacing, cells - 2 * ends);
                }
            }
        }
    }

    /// A cell of a polyline, of this edge (m) along its piece.
    fn add_if_free(&mut self, index: usize, at: Vector<D>, edge: f64, solids: &Solids<'_, D>) {
        if solids.is_free_for(index, &at) {
            let depth = -solids.parts[index].shape.surface_point(&at).distance;
            self.add(index, at, depth, edge * solids.spacing);
        }
    }

    /// Cells straight on from the ends of a polyline that end at another wall; those of other ends are the
    /// particles from `first` on.
    fn continue_ends(&mut self, index: usize, first: usize, solids: &Solids<'_, D>) {
        let spacing = solids.spacing;
        for end in solids.free_ends(index) {
            let touched = solids.touched(index, &end.at(0.0, 0.0));
            let middle = |k: usize, depth: f64| end.at((k as f64 + 0.5) * spacing, depth);
            let covered = |k: &usize| touched.iter().any(|part| solids.cover(*part, &middle(*k, 0.0)));
            for k in (0..solids.rows()).take_while(covered) {
                for row in 0..solids.rows() {
                    let depth = (row as f64 + 0.5) * spacing;
                    let p = middle(k, depth);
                    let apart = |q: &Vector<D>| (p - q).norm() > 0.5 * spacing;
                    if solids.is_free(&p) && self.positions[first..].iter().all(apart) {
                        self.add(index, p, depth, spacing * spacing);
                    }
                }
            }
        }
    }

    fn add(&mut self, part: usize, at: Vector<D>, depth: f64, volume: f64) {
        self.positions.push(at);
        self.volumes.push(volume);
        self.depths.push(depth);
        self.part_of.push(part as u32);
    }

    /// A column of so many whole cells.
    fn add_column(
        &mut self,
        part: usize,
        start: Vector<D>,
        depth: f64,
        along: Vector<D>,
        volume: f64,
        cells: usize,
    ) {
        let edge = along.norm();
        let first = self.positions.len();
        for k in 0..=cells {
            self.add(part, start + along * (k as f64 + 0.5), depth, volume);
        }
        let particles = first..self.positions.len();
        self.columns.push(Column { part, direction: along / edge, particles, start, edge, volume });
    }
}

/// Particles of a wall between its ends, one behind the other along its motion. They stay where they are:
/// cells of a lattice at rest, as far as the wall that passes by fills them. Particles that went with it
/// would push to and fro as they pass by.
#[derive(Clone, Debug)]
pub struct Column<const D: usize> {
    /// Part that it belongs to.
    pub part: usize,
    /// Unit vector along the motion.
    pub direction: Vector<D>,
    /// Its particles, one more than the wall fills when its cells are those of the lattice.
    pub particles: std::ops::Range<usize>,
    /// Where it begins (m) at rest, and the edge (m) and the volume (m³) of a whole cell.
    start: Vector<D>,
    edge: f64,
    volume: f64,
}

impl<const D: usize> Column<D> {
    /// Middle (m) and volume (m³) of particle `k`, the wall having gone `shift` (m).
    pub fn cell(&self, k: usize, shift: f64) -> (Vector<D>, f64) {
        let cells = self.particles.len() as f64 - 1.0;
        let first = (shift / self.edge).floor() * self.edge;
        let from = (first + k as f64 * self.edge).max(shift);
        let to = (first + (k + 1) as f64 * self.edge).min(shift + cells * self.edge).max(from);
        let middle = self.start + self.direction * (0.5 * (from + to));
        (middle, self.volume * (to - from) / self.edge)
    }
}

/// The places that parts fill.
struct Solids<'a, const D: usize> {
    parts: &'a [WallPart<D>],
    /// Of each polyline what is behind its pieces; nothing for a box.
    strips: Vec<Vec<Strip<D>>>,
    spacing: f64,
    support: f64,
}

impl<'a, const D: usize> Solids<'a, D> {
    fn new(parts: &'a [WallPart<D>], spacing: f64, support: f64) -> Self {
        let strips = parts.iter().map(|part| match &part.shape {
            WallShape::Box { .. } => Vec::new(),
            WallShape::Polyline { points, solid } => strips(points, *solid),
        });
        Self { parts, strips: strips.collect(), spacing, support }
    }

    fn tolerance(&self) -> f64 {
        TIE * self.spacing
    }

    /// How deep (m) the middle of a cell may be. Of a wall that slides along itself the ends go with it, as
    /// deep as they are felt.
    fn reach(&self) -> f64 {
        self.support + 0.5 * self.spacing
    }

    /// Rows of cells behind a polyline.
    fn rows(&self) -> usize {
        (self.support / self.spacing - TIE).ceil() as usize
    }

    /// Whether no part before this one fills the place (m).
    fn is_free_for(&self, part: usize, point: &Vector<D>) -> bool {
        !(0..part).any(|earlier| self.hold(earlier, point, self.support + self.spacing))
    }

    /// Whether the place (m) is in no part, however deep.
    fn is_free(&self, point: &Vector<D>) -> bool {
        !(0..self.parts.len()).any(|part| self.hold(part, point, f64::INFINITY))
    }

    /// Whether a part has the place (m), a box as deep as `deepest` (m).
    fn hold(&self, part: usize, point: &Vector<D>, deepest: f64) -> bool {
        match &self.parts[part].shape {
            shape @ WallShape::Box { .. } => {
                let depth = -shape.surface_point(point).distance;
                depth > self.tolerance() && depth < deepest - self.tolerance()
            }
            WallShape::Polyline { .. } => {
                self.strips[part].iter().any(|strip| strip.holds(point, self.depth(), self.tolerance()))
            }
        }
    }

    /// Depth (m) to which polylines are filled.
    fn depth(&self) -> f64 {
        self.rows() as f64 * self.spacing
    }

    /// The other parts, of the same motion, on or in which the point (m) lies.
    fn touched(&self, part: usize, point: &Vector<D>) -> Vec<usize> {
        let others = (0..self.parts.len())
            .filter(|other| *other != part && self.parts[*other].motion == self.parts[part].motion);
        let touches = |other: &usize| match &self.parts[*other].shape {
            shape @ WallShape::Box { .. } => shape.surface_point(point).distance <= self.tolerance(),
            WallShape::Polyline { .. } => {
                self.strips[*other].iter().any(|strip| strip.holds(point, self.depth(), -self.tolerance()))
            }
        };
        others.filter(touches).collect()
    }

    /// Whether a part's solid or surface is at the point (m); a polyline's goes on beyond its ends.
    fn cover(&self, part: usize, point: &Vector<D>) -> bool {
        let shape = &self.parts[part].shape;
        let distance = shape.continued_distance(point);
        let deepest = if matches!(shape, WallShape::Box { .. }) {
            f64::INFINITY
        } else {
            self.depth() + self.tolerance()
        };
        distance <= self.tolerance() && distance >= -deepest
    }

    /// Where a polyline that is not closed goes on beyond its ends.
    fn free_ends(&self, part: usize) -> Vec<Strip<D>> {
        let WallShape::Polyline { points, .. } = &self.parts[part].shape else { return Vec::new() };
        let strips = &self.strips[part];
        if points.first() == points.last() {
            return Vec::new();
        }
        let [first, .., last] = &strips[..] else {
            return strips.iter().flat_map(|only| [only.before(), only.beyond()]).collect();
        };
        vec![first.before(), last.beyond()]
    }
}

/// What is behind a piece of a polyline.
struct Strip<const D: usize> {
    start: Vector<D>,
    /// Unit vectors along the piece and out of the solid.
    direction: Vector<D>,
    out: Vector<D>,
    length: f64,
    /// Of each end at a corner what it is longer than the piece, over the depth: strips meet on the mitre.
    corners: [Option<f64>; 2],
}

impl<const D: usize> Strip<D> {
    /// The point (m) so far along and so deep behind the piece.
    fn at(&self, along: f64, depth: f64) -> Vector<D> {
        self.start + self.direction * along - self.out * depth
    }

    /// Where along the piece (m) it begins and ends at this depth (m).
    fn ends(&self, depth: f64) -> (f64, f64) {
        let [before, beyond] = self.corners.map(|corner| corner.map_or(0.0, |stretch| stretch * depth));
        (-before, self.length + beyond)
    }

    /// Where along the piece (m) a row of cells begins and ends: on the mitre, but for right angles. Behind
    /// the outside of one the corner has cells of its own, and behind its inside the row ends with a cell:
    /// that on the mitre belongs to the piece that comes first.
    fn row(&self, row: usize, spacing: f64) -> (f64, f64) {
        let depth = (row as f64 + 0.5) * spacing;
        let end = |stretch: Option<f64>, shorter: usize| match stretch {
            Some(stretch) if is_right(stretch) && stretch > 0.0 => 0.0,
            Some(stretch) if is_right(stretch) => -(shorter as f64) * spacing,
            _ => stretch.map_or(0.0, |stretch| stretch * depth),
        };
        (-end(self.corners[0], row + 1), self.length + end(self.corners[1], row))
    }

    /// Cells of a row in the corners behind the outside of right angles, before and beyond the piece.
    fn cells_in_corners(&self, row: usize) -> [usize; 2] {
        let outside =
            self.corners.map(|corner| corner.is_some_and(|stretch| is_right(stretch) && stretch > 0.0));
        [if outside[0] { row } else { 0 }, if outside[1] { row + 1 } else { 0 }]
    }

    /// Whether it has the point (m), as deep as `deepest` (m), farther than `tolerance` (m) from its borders.
    fn holds(&self, point: &Vector<D>, deepest: f64, tolerance: f64) -> bool {
        let offset = point - self.start;
        let (along, depth) = (offset.dot(&self.direction), -offset.dot(&self.out));
        let (from, to) = self.ends(depth);
        // What is on the mitre belongs to both pieces.
        let [before, beyond] =
            self.corners.map(|corner| if corner.is_some() { -tolerance.abs() } else { tolerance });
        depth > tolerance && depth < deepest - tolerance && along > from + before && along < to - beyond
    }

    /// The strip straight on beyond its start, away from it.
    fn before(&self) -> Self {
        Self { direction: -self.direction, out: self.out, start: self.start, length: 0.0, corners: [None; 2] }
    }

    /// The strip straight on beyond its end.
    fn beyond(&self) -> Self {
        let start = self.start + self.direction * self.length;
        Self { direction: self.direction, out: self.out, start, length: 0.0, corners: [None; 2] }
    }
}

/// Whether a corner is a right angle.
fn is_right(stretch: f64) -> bool {
    (stretch.abs() - 1.0).abs() < TIE
}

/// What is behind the pieces of a polyline, lengthened or shortened at the corners so that strips meet on the
/// mitre.
fn strips<const D: usize>(points: &[Vector<D>], solid: Side) -> Vec<Strip<D>> {
    let pieces: Vec<[Vector<D>; 2]> = points.windows(2).map(|w| [w[0], w[1]]).collect();
    let closed = points.first() == points.last();
    // Half the turn at the corner from one piece to the next, positive to the left.
    let half_turn = |from: &[Vector<D>; 2], to: &[Vector<D>; 2]| {
        let (a, b) = (from[1] - from[0], to[1] - to[0]);
        0.5 * (a[0] * b[1] - a[1] * b[0]).atan2(a.dot(&b))
    };
    // Strips behind the outside of a turn are longer than the piece, behind its inside shorter.
    let sign = if solid == Side::Left { -1.0 } else { 1.0 };
    let stretch = |turn: f64| sign * turn.tan();
    let of = |(k, piece): (usize, &[Vector<D>; 2])| {
        let previous = if k > 0 { Some(&pieces[k - 1]) } else { pieces.last().filter(|_| closed) };
        let next = pieces.get(k + 1).or_else(|| pieces.first().filter(|_| closed));
        let along = piece[1] - piece[0];
        let length = along.norm();
        Strip {
            start: piece[0],
            direction: along / length,
            out: fluid_side(&along, solid),
            length,
            corners: [
                previous.map(|p| stretch(half_turn(p, piece))),
                next.map(|n| stretch(half_turn(piece, n))),
            ],
        }
    };
    pieces.iter().enumerate().map(of).collect()
}

fn refuse_impossible<const D: usize>(part: &WallPart<D>) -> Result<(), Error> {
    match &part.shape {
        WallShape::Box { low, high } => {
            if (0..D).any(|i| high[i].partial_cmp(&low[i]) != Some(std::cmp::Ordering::Greater)) {
                return Err(Error::Setting {
                    key: "walls.box",
                    value: format!("{low:?} to {high:?} ({})", part.name),
                    remedy: "its second corner must lie above the first along every axis",
                });
            }
        }
        WallShape::Polyline { points, .. } => {
            let degenerate = points.windows(2).any(|w| w[0] == w[1]);
            if D != 2 || points.len() < 2 || degenerate {
                return Err(Error::Setting {
                    key: "walls.polyline",
                    value: format!("{} points ({})", points.len(), part.name),
                    remedy: "give at least two points, each different from the one before, in two dimensions",
                });
            }
        }
    }
    Ok(())
}

/// Whether a part is a box that moves along one of its edges and is long in that direction: the axis, and
/// where along it (m) its ends, `reach` (m) deep, leave off.
fn slides_along<const D: usize>(
    part: &WallPart<D>,
    lattice: &Lattice<D>,
    reach: f64,
) -> Option<(usize, f64, f64)> {
    let (Some(Motion::Translation { direction, .. }), WallShape::Box { low, high }) =
        (&part.motion, &part.shape)
    else {
        return None;
    };
    let axis = Vector::from(*direction).iamax();
    if !slides_with(part, &Vector::from_fn(|i, _| f64::from(u8::from(i == axis)))) {
        return None;
    }
    let edge = lattice.cell[axis];
    let end = (reach / edge - TIE).ceil() * edge;
    let (low, high) = (low[axis] + end, high[axis] - end);
    (high - low > 0.5 * edge).then_some((axis, low, high))
}

/// Whether a part moves in this direction or against it.
fn slides_with<const D: usize>(part: &WallPart<D>, along: &Vector<D>) -> bool {
    let Some(Motion::Translation { direction, .. }) = &part.motion else { return false };
    let direction = Vector::from(*direction);
    direction.dot(along).abs() > (1.0 - 1e-12) * along.norm() * direction.norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However far a column has gone, its cells fill what the box does, from end to end and in order, and
    /// their middles stay on the lattice but for the ends.
    #[test]
    fn cells_of_a_column_fill_the_box_wherever_it_is() {
        let (direction, start) = (Vector::from([0.6, 0.8]), Vector::from([0.3, -1.0]));
        let column = Column { part: 0, direction, particles: 0..6, start, edge: 0.1, volume: 0.01 };
        for shift in [0.0, 0.025, 0.1, -0.37, 1.73] {
            let cells: Vec<(Vector<2>, f64)> = (0..6).map(|k| column.cell(k, shift)).collect();
            let volume: f64 = cells.iter().map(|c| c.1).sum();
            let moment = cells.iter().fold(Vector::zeros(), |sum: Vector<2>, c| sum + c.0 * c.1);
            assert!((volume - 0.05).abs() < 1e-15, "{shift}");
            assert!((moment / volume - start - direction * (shift + 0.25)).norm() < 1e-14, "{shift}");
            let along = |at: &Vector<2>| ((at - start).dot(&direction) - 0.05) / 0.1;
            let on_lattice = |at: &Vector<2>| (along(at) - along(at).round()).abs() < 1e-9;
            assert!(cells.iter().filter(|c| c.1 > 0.0099).all(|c| on_lattice(&c.0)), "{shift} {cells:?}");
        }
    }
}
