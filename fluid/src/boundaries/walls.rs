//! Walls: solid boxes and polylines, filled with particles as deep as a kernel reaches.

use crate::boundaries::filling::{Column, Filling};
pub use crate::boundaries::shapes::{Side, SurfacePoint, WallPart, WallShape};
use crate::boundaries::wall_motion::Pose;
use crate::error::Error;
use sph::Vector;
use sph::lattice::TIE;
use sph::neighbours::{CellGrid, NeighbourList};

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
    /// How near (m) to a surface a place counts as on it.
    tolerance: f64,
    /// Lengths (s) of the step, and of that before it: zero where there is none.
    dt: f64,
    last_dt: f64,
}

impl<const D: usize> Walls<D> {
    /// Fills the parts with particles about `spacing` (m) apart, as deep as `support` (m). Where parts
    /// overlap, the earlier one fills.
    ///
    /// # Errors
    /// [`Error::Setting`] for a box turned inside out, a polyline of fewer than two distinct points or one in
    /// three dimensions.
    pub fn new(parts: Vec<WallPart<D>>, spacing: f64, support: f64) -> Result<Self, Error> {
        let Filling { positions, volumes, depths, part_of, columns } =
            Filling::new(&parts, spacing, support)?;
        let grid = CellGrid::new(&positions, support);
        let velocities = part_of.iter().map(|&part: &u32| parts[part as usize].velocity).collect();
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
            tolerance: TIE * spacing,
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
        let depths = deepest..-self.tolerance;
        (0..part).any(|earlier| depths.contains(&self.surface_point(earlier, at, false).distance))
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
