//! Walls: solid boxes and polylines, filled with particles as deep as a kernel reaches.

use crate::boundaries::wall_motion::{Motion, Pose};
use crate::error::Error;
use sph::Vector;
use sph::lattice::Lattice;
use sph::neighbours::{CellGrid, NeighbourList};
pub use words::geometry::Side;

/// Shape of a wall.
#[derive(Clone, Debug, PartialEq)]
pub enum WallShape<const D: usize> {
    /// A solid box between two corners (m), its edges along the axes.
    Box {
        /// Lowest coordinates.
        low: Vector<D>,
        /// Highest coordinates.
        high: Vector<D>,
    },
    /// Straight pieces from point to point (m), solid on one side (two dimensions only); closed when the last
    /// point is the first.
    Polyline {
        /// The points.
        points: Vec<Vector<D>>,
        /// Where the solid is.
        solid: Side,
    },
}

/// A named wall.
#[derive(Clone, Debug, PartialEq)]
pub struct WallPart<const D: usize> {
    /// Name, for forces and messages.
    pub name: String,
    /// Shape.
    pub shape: WallShape<D>,
    /// Velocity of the surface (m/s) along itself: the wall slides, its shape stays where it is.
    pub velocity: Vector<D>,
    /// How the wall moves; none for one that stays where it is.
    pub motion: Option<Motion<D>>,
}

/// All walls, as particles and as shapes.
#[derive(Clone, Debug)]
pub struct Walls<const D: usize> {
    /// The parts.
    pub parts: Vec<WallPart<D>>,
    /// Particle positions (m), at the time of [`Walls::move_to`].
    pub positions: Vec<Vector<D>>,
    /// Particle velocities (m/s), surfaces that slide along themselves included; the mean of the step of
    /// [`Walls::move_to`].
    pub velocities: Vec<Vector<D>>,
    /// Particle volumes (m³).
    pub volumes: Vec<f64>,
    /// Depth of each particle under its part's surface (m).
    pub depths: Vec<f64>,
    /// Part of each particle.
    pub part_of: Vec<u32>,
    /// Particles binned.
    pub grid: CellGrid<D>,
    /// Positions (m) where the motions begin.
    rest: Vec<Vector<D>>,
    /// Columns of particles of walls that slide along themselves.
    columns: Vec<Column<D>>,
    /// Of the parts that move, where the motion has brought each at the start and the end of the step, and
    /// had at the start of the step before it.
    poses: Vec<Option<[Pose<D>; 3]>>,
    /// Lengths (s) of the step, and of that before it: zero where there is none.
    dt: f64,
    last_dt: f64,
}

/// Particles of a wall between its ends, one behind the other along its motion. They stay where they are:
/// cells of a lattice at rest, as far as the wall that passes by fills them. Particles that went with it
/// would push to and fro as they pass by.
#[derive(Clone, Debug)]
struct Column<const D: usize> {
    part: usize,
    /// Unit vector along the motion.
    direction: Vector<D>,
    /// Its particles, one more than the wall fills when its cells are those of the lattice.
    particles: std::ops::Range<usize>,
    /// Where it begins (m) at rest, and the edge (m) and the volume (m³) of a whole cell.
    start: Vector<D>,
    edge: f64,
    volume: f64,
}

impl<const D: usize> Column<D> {
    /// Middle (m) and volume (m³) of particle `k`, the wall having gone `shift` (m).
    fn cell(&self, k: usize, shift: f64) -> (Vector<D>, f64) {
        let cells = self.particles.len() as f64 - 1.0;
        let first = (shift / self.edge).floor() * self.edge;
        let from = (first + k as f64 * self.edge).max(shift);
        let to = (first + (k + 1) as f64 * self.edge).min(shift + cells * self.edge).max(from);
        let middle = self.start + self.direction * (0.5 * (from + to));
        (middle, self.volume * (to - from) / self.edge)
    }
}

/// The particles with which parts are filled.
#[derive(Default)]
struct Filling<const D: usize> {
    positions: Vec<Vector<D>>,
    volumes: Vec<f64>,
    part_of: Vec<u32>,
    columns: Vec<Column<D>>,
}

impl<const D: usize> Filling<D> {
    fn add(&mut self, part: usize, at: Vector<D>, volume: f64) {
        self.positions.push(at);
        self.volumes.push(volume);
        self.part_of.push(part as u32);
    }

    /// A column of so many whole cells.
    fn add_column(&mut self, part: usize, start: Vector<D>, along: Vector<D>, volume: f64, cells: usize) {
        let edge = along.norm();
        let first = self.positions.len();
        for k in 0..=cells {
            self.add(part, start + along * (k as f64 + 0.5), volume);
        }
        let particles = first..self.positions.len();
        self.columns.push(Column { part, direction: along / edge, particles, start, edge, volume });
    }
}

/// A point on a surface: signed distance to it (m, negative inside the solid) and the direction away from the
/// solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint<const D: usize> {
    /// Distance (m).
    pub distance: f64,
    /// Unit normal, out of the solid.
    pub normal: Vector<D>,
}

impl<const D: usize> Walls<D> {
    /// Fills the parts with particles about `spacing` (m) apart, as deep as `support` (m). Where parts
    /// overlap, the earlier one fills.
    ///
    /// # Errors
    /// [`Error::Setting`] for a box turned inside out, a polyline of fewer than two distinct points or one in
    /// three dimensions.
    pub fn new(parts: Vec<WallPart<D>>, spacing: f64, support: f64) -> Result<Self, Error> {
        let mut filling = Filling::default();
        // Of a wall that slides along itself the ends go with it, as deep as they are felt.
        let reach = support + 0.5 * spacing;
        for (index, part) in parts.iter().enumerate() {
            let is_free = |point: &Vector<D>| {
                !parts[..index].iter().any(|earlier| {
                    let d = earlier.shape.surface_point(point).distance;
                    d < 0.0 && d > -support - spacing
                })
            };
            match &part.shape {
                WallShape::Box { low, high } => {
                    if (0..D).any(|i| high[i].partial_cmp(&low[i]) != Some(std::cmp::Ordering::Greater)) {
                        return Err(Error::Setting {
                            key: "walls.box",
                            value: format!("{low:?} to {high:?} ({})", part.name),
                            remedy: "its second corner must lie above the first along every axis",
                        });
                    }
                    let lattice = Lattice::fill_box(*low, *high, spacing);
                    let volume = lattice.cell_volume();
                    let shallow = |p: &Vector<D>| part.shape.surface_point(p).distance > -reach;
                    let between = slides_along(part, &lattice, reach);
                    let is_between = |p: &Vector<D>| {
                        between.is_some_and(|(axis, low, high)| (low..high).contains(&p[axis]))
                    };
                    for p in lattice.positions.iter().filter(|p| shallow(p) && !is_between(p) && is_free(p)) {
                        filling.add(index, *p, volume);
                    }
                    let Some((axis, low, high)) = between else { continue };
                    let edge = lattice.cell[axis];
                    let in_first_row = |p: &&Vector<D>| p[axis] > low && p[axis] < low + edge;
                    let cells = ((high - low) / edge).round() as usize;
                    let along = Vector::from_fn(|i, _| if i == axis { edge } else { 0.0 });
                    for p in lattice.positions.iter().filter(in_first_row).filter(|p| shallow(p)) {
                        filling.add_column(index, p - along * 0.5, along, volume, cells);
                    }
                }
                WallShape::Polyline { points, solid } => {
                    let degenerate = points.windows(2).any(|w| w[0] == w[1]);
                    if D != 2 || points.len() < 2 || degenerate {
                        return Err(Error::Setting {
                            key: "walls.polyline",
                            value: format!("{} points ({})", points.len(), part.name),
                            remedy: "give at least two points, each different from the one before, in two dimensions",
                        });
                    }
                    fill_polyline(points, *solid, spacing, support, |start, along, cells| {
                        let edge = along.norm();
                        let volume = edge * spacing;
                        let mut ends = (reach / edge).ceil() as usize;
                        if !slides_with(part, &along) || cells <= 2 * ends {
                            ends = cells;
                        }
                        for i in (0..ends.min(cells)).chain((cells - ends).max(ends)..cells) {
                            let p = start + along * (i as f64 + 0.5);
                            if is_free(&p) {
                                filling.add(index, p, volume);
                            }
                        }
                        if ends < cells {
                            let start = start + along * ends as f64;
                            filling.add_column(index, start, along, volume, cells - 2 * ends);
                        }
                    });
                }
            }
        }
        let Filling { positions, volumes, part_of, columns } = filling;
        let grid = CellGrid::new(&positions, support);
        let velocities = part_of.iter().map(|&part: &u32| parts[part as usize].velocity).collect();
        let depth = |(w, part): (&Vector<D>, &u32)| -parts[*part as usize].shape.surface_point(w).distance;
        let depths = positions.iter().zip(&part_of).map(depth).collect();
        let (rest, poses) = (positions.clone(), vec![None; parts.len()]);
        let mut walls = Self {
            parts,
            positions,
            velocities,
            volumes,
            depths,
            part_of,
            grid,
            rest,
            columns,
            poses,
            dt: 1.0,
            last_dt: 0.0,
        };
        walls.move_to(0.0, (1.0, 0.0));
        Ok(walls)
    }

    /// Whether any part moves.
    pub fn moves(&self) -> bool {
        self.parts.iter().any(|part| part.motion.is_some())
    }

    /// Whether a part moves.
    pub fn part_moves(&self, part: usize) -> bool {
        self.parts[part].motion.is_some()
    }

    /// Velocities (m/s) of the walls' particles across their surface, one for each pair of `near`, in which
    /// each of `points` (m) has those around it; none where nothing moves. What a wall does along itself
    /// displaces no fluid: in a sum over its particles it would seem to, to and fro as they pass by.
    pub fn velocities_across(&self, points: &[Vector<D>], near: &NeighbourList, out: &mut Vec<Vector<D>>) {
        out.clear();
        if self.velocities.iter().all(|u| *u == Vector::<D>::zeros()) {
            return;
        }
        for (a, at) in points.iter().enumerate() {
            let mut nearest = (usize::MAX, Vector::zeros());
            for &w in near.of(a) {
                let (part, u) = (self.part_of[w as usize] as usize, &self.velocities[w as usize]);
                if *u != Vector::<D>::zeros() && part != nearest.0 {
                    nearest = (part, self.surface_point(part, at, false).normal);
                }
                out.push(nearest.1 * nearest.1.dot(u));
            }
        }
    }

    /// Acceleration (m/s²), across their surface, of the walls that move and of which `near` lists particles,
    /// at `point` (m): the mean over those particles.
    pub fn acceleration_across(&self, point: &Vector<D>, near: &[u32]) -> Vector<D> {
        if !self.moves() {
            return Vector::zeros();
        }
        let (mut nearest, mut sum, mut count) = ((usize::MAX, Vector::zeros()), Vector::zeros(), 0.0);
        for &w in near {
            let part = self.part_of[w as usize] as usize;
            if !self.part_moves(part) {
                continue;
            }
            if part != nearest.0 {
                let normal = self.surface_point(part, point, false).normal;
                nearest = (part, normal * normal.dot(&self.acceleration_at(part, point)));
            }
            sum += nearest.1;
            count += 1.0;
        }
        if count > 0.0 { sum / count } else { sum }
    }

    /// Brings the walls to where they are at `time` (s); velocities are means over the `dt` (s) that follow,
    /// and accelerations are from those over the `last_dt` (s) before it, or from rest where that is zero.
    pub fn move_to(&mut self, time: f64, (dt, last_dt): (f64, f64)) {
        if !self.moves() {
            return;
        }
        (self.dt, self.last_dt) = (dt, last_dt);
        for (pose, part) in self.poses.iter_mut().zip(&self.parts) {
            *pose = part.motion.as_ref().map(|m| [m.pose(time), m.pose(time + dt), m.pose(time - last_dt)]);
        }
        for (w, rest) in self.rest.iter().enumerate() {
            let part = self.part_of[w] as usize;
            if let Some([start, end, _]) = &self.poses[part] {
                self.positions[w] = start.moved(rest);
                let slides = start.turned(&self.parts[part].velocity);
                self.velocities[w] = slides + (end.moved(rest) - self.positions[w]) / dt;
            }
        }
        for column in &self.columns {
            let Some([start, ..]) = &self.poses[column.part] else { continue };
            let shift = start.moved(&Vector::zeros()).dot(&column.direction);
            for (k, w) in column.particles.clone().enumerate() {
                let (middle, volume) = column.cell(k, shift);
                self.positions[w] = middle;
                let taken = self.taken(column.part, &self.positions[w]);
                self.volumes[w] = if taken { 0.0 } else { volume };
            }
        }
        self.grid = CellGrid::new(&self.positions, self.grid.radius());
    }

    /// The longest step (s), `dt` at most, from `time` (s) in which no particle of a wall that moves goes
    /// farther than `reach` (m) from where it was.
    pub fn longest_step(&self, time: f64, mut dt: f64, reach: f64) -> f64 {
        if !self.moves() {
            return dt;
        }
        // A law may turn back within the step: its quarters are looked at too. Each round takes a tenth at
        // least; laws are continuous.
        for _ in 0..100 {
            let gone =
                (1..=4).map(|k| self.farthest(time, time + 0.25 * f64::from(k) * dt)).fold(0.0, f64::max);
            if gone <= reach {
                break;
            }
            dt *= 0.9 * (reach / gone).max(0.5);
        }
        dt
    }

    /// Largest distance (m) that a wall particle moves from one time (s) to another.
    fn farthest(&self, from: f64, to: f64) -> f64 {
        let motions = self.parts.iter().map(|part| part.motion.as_ref());
        let poses: Vec<_> = motions.map(|m| m.map(|m| [m.pose(from), m.pose(to)])).collect();
        let moved = self.rest.iter().zip(&self.part_of).filter_map(|(rest, &part)| {
            let [start, end] = poses[part as usize].as_ref()?;
            Some((end.moved(rest) - start.moved(rest)).norm())
        });
        moved.fold(0.0, f64::max)
    }

    /// The nearest point of a part's surface to `point` (m) at the start of the step, or at its end.
    pub fn surface_point(&self, part: usize, point: &Vector<D>, at_end: bool) -> SurfacePoint<D> {
        let shape = &self.parts[part].shape;
        match &self.poses[part] {
            None => shape.surface_point(point),
            Some(poses) => {
                let pose = &poses[usize::from(at_end)];
                let nearest = shape.surface_point(&pose.at_rest(point));
                SurfacePoint { distance: nearest.distance, normal: pose.turned(&nearest.normal) }
            }
        }
    }

    /// Mean velocity (m/s) over the step of the point of a part that is at `point` (m); sliding along itself
    /// does not count.
    pub fn motion_at(&self, part: usize, point: &Vector<D>) -> Vector<D> {
        match &self.poses[part] {
            None => Vector::zeros(),
            Some([start, end, _]) => (end.moved(&start.at_rest(point)) - point) / self.dt,
        }
    }

    /// Whether a part before this one fills the place (m), as deep as its particles reach.
    fn taken(&self, part: usize, at: &Vector<D>) -> bool {
        let deepest = -self.grid.radius();
        (0..part).any(|earlier| (deepest..0.0).contains(&self.surface_point(earlier, at, false).distance))
    }

    /// Whether a part fills the place (m), as deep as its particles reach.
    pub fn fill(&self, at: &Vector<D>) -> bool {
        self.taken(self.parts.len(), at)
    }

    /// Acceleration (m/s²) of the point of a part that is at `point` (m), sliding along itself left out: of
    /// its mean velocity over the step from that over the step before, or from rest.
    pub fn acceleration_at(&self, part: usize, point: &Vector<D>) -> Vector<D> {
        let Some([start, _, before]) = &self.poses[part] else { return Vector::zeros() };
        let was = if self.last_dt > 0.0 {
            (point - before.moved(&start.at_rest(point))) / self.last_dt
        } else {
            Vector::zeros()
        };
        (self.motion_at(part, point) - was) / self.dt
    }

    /// The part with a name.
    pub fn part(&self, name: &str) -> Option<usize> {
        self.parts.iter().position(|part| part.name == name)
    }
}

impl<const D: usize> WallShape<D> {
    /// The nearest point of the shape's surface to `point` (m).
    pub fn surface_point(&self, point: &Vector<D>) -> SurfacePoint<D> {
        match self {
            Self::Box { low, high } => {
                let nearest = Vector::from_fn(|i, _| point[i].clamp(low[i], high[i]));
                let offset = point - nearest;
                let distance = offset.norm();
                if distance > 0.0 {
                    return SurfacePoint { distance, normal: offset / distance };
                }
                let mut best = SurfacePoint { distance: f64::NEG_INFINITY, normal: Vector::zeros() };
                for axis in 0..D {
                    for (depth, sign) in [(point[axis] - low[axis], -1.0), (high[axis] - point[axis], 1.0)] {
                        if -depth > best.distance {
                            best.distance = -depth;
                            best.normal = Vector::from_fn(|i, _| if i == axis { sign } else { 0.0 });
                        }
                    }
                }
                best
            }
            Self::Polyline { points, solid } => {
                // At a corner two pieces are equally near; the one that the point stands more squarely before
                // has the right sign.
                let mut best = (f64::INFINITY, 0.0, Vector::zeros());
                for piece in points.windows(2) {
                    let along = piece[1] - piece[0];
                    let s = ((point - piece[0]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                    let offset = point - (piece[0] + along * s);
                    let out = fluid_side(&along, *solid);
                    let (distance, square) = (offset.norm(), offset.dot(&out));
                    let tie = (distance - best.0).abs() <= 1e-12 * along.norm();
                    if (tie && square.abs() > f64::abs(best.1)) || (!tie && distance < best.0) {
                        best = (distance, square, if distance > 0.0 { offset / distance } else { out });
                    }
                }
                let (distance, square, direction) = best;
                if square < 0.0 {
                    SurfacePoint { distance: -distance, normal: -direction }
                } else {
                    SurfacePoint { distance, normal: direction }
                }
            }
        }
    }
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
    let axis = direction.iamax();
    if !slides_with(part, &Vector::from_fn(|i, _| f64::from(u8::from(i == axis)))) {
        return None;
    }
    let edge = lattice.cell[axis];
    let end = (reach / edge).ceil() * edge;
    let (low, high) = (low[axis] + end, high[axis] - end);
    (high - low > 0.5 * edge).then_some((axis, low, high))
}

/// Whether a part moves in this direction or against it.
fn slides_with<const D: usize>(part: &WallPart<D>, along: &Vector<D>) -> bool {
    let Some(Motion::Translation { direction, .. }) = &part.motion else { return false };
    direction.dot(along).abs() > (1.0 - 1e-12) * along.norm() * direction.norm()
}

/// Unit normal of a piece, out of the solid.
fn fluid_side<const D: usize>(along: &Vector<D>, solid: Side) -> Vector<D> {
    let right = Vector::from_fn(|i, _| if i == 0 { along[1] } else { -along[0] }) / along.norm();
    match solid {
        Side::Left => right,
        Side::Right => -right,
    }
}

/// Rows of cells behind each piece, lengthened or shortened at the corners so that they meet on the mitre;
/// `add` is told where a row begins, the edge of a cell along it (m), and how many there are.
fn fill_polyline<const D: usize>(
    points: &[Vector<D>],
    solid: Side,
    spacing: f64,
    support: f64,
    mut add: impl FnMut(Vector<D>, Vector<D>, usize),
) {
    let pieces: Vec<[Vector<D>; 2]> = points.windows(2).map(|w| [w[0], w[1]]).collect();
    let closed = points.first() == points.last();
    let rows = (support / spacing).ceil() as usize;
    // Half the turn at the corner from one piece to the next, positive to the left.
    let half_turn = |from: &[Vector<D>; 2], to: &[Vector<D>; 2]| {
        let (a, b) = (from[1] - from[0], to[1] - to[0]);
        0.5 * (a[0] * b[1] - a[1] * b[0]).atan2(a.dot(&b))
    };
    let sign = if solid == Side::Left { -1.0 } else { 1.0 };
    for (k, piece) in pieces.iter().enumerate() {
        let previous = if k > 0 { Some(&pieces[k - 1]) } else { pieces.last().filter(|_| closed) };
        let next = pieces.get(k + 1).or_else(|| pieces.first().filter(|_| closed));
        let length = (piece[1] - piece[0]).norm();
        let direction = (piece[1] - piece[0]) / length;
        let out = fluid_side(&direction, solid);
        for row in 0..rows {
            let depth = (row as f64 + 0.5) * spacing;
            // Rows behind the outside of a turn are longer than the piece, behind its inside shorter.
            let stretch = |turn: f64| sign * depth * turn.tan();
            let from = -previous.map_or(0.0, |p| stretch(half_turn(p, piece)));
            let to = length + next.map_or(0.0, |n| stretch(half_turn(piece, n)));
            if to <= from {
                continue;
            }
            let count = ((to - from) / spacing).round().max(1.0) as usize;
            let cell = (to - from) / count as f64;
            add(piece[0] + direction * from - out * depth, direction * cell, count);
        }
    }
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
