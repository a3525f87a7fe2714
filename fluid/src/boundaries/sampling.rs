//! The structure as the fluid meets it: boundary points at the fluid's own spacing, whatever the structure's.
//!
//! A structure as fine as the fluid is met at its particles. Another is cut into pieces, each carried by the
//! motion of the particle that it is of and of those around, `u = Σ_s w_s u_s` with `w` exact for linear
//! motion in the reference configuration; the pieces in each cell of a lattice of the fluid's spacing make a
//! boundary point. Loads go back by the transpose, `V_s g_s = Σ_i w_is V_i g_i`, so that force, moment and
//! work are the same on either side. What is held and stands inside a wall is left to it.
//!
//! Pairs of lattices of one spacing are what the kernel sums are best at: beside a face twice as fine as the
//! fluid, met at its particles, water at rest presses with 0.97 of its weight, beside one cut to the fluid's
//! spacing as beside one as fine as the fluid.

use crate::interface::{InterfaceInput, InterfaceParticles};
use rayon::prelude::*;
use sph::neighbours::{CellGrid, NeighbourList};
use sph::{Matrix, Vector, tensor};
use std::collections::BTreeMap;

/// Edges of particles, in the fluid's spacing, that are met as they are.
const AS_FINE: std::ops::RangeInclusive<f64> = 0.9..=1.1;

/// Extent of a body, in the fluid's spacing, below which it counts as thin.
const THIN: f64 = 1.5;

/// Share of a box from which on a body counts as the box.
const FILLED: f64 = 0.9;

/// How far (in longest edges of their cells) particles carry the pieces of each other.
const REACH: f64 = 1.6;

/// How far (in mean edges) neighbours are looked for that tell the edges of a cell.
const SIGHT: f64 = 2.5;

/// Weights below which a particle carries nothing.
const NEGLIGIBLE: f64 = 1e-14;

/// Lengths, in an edge, that come of rounding.
const NEGLIGIBLE_LENGTH: f64 = 1e-9;

/// Boundary points, and how interface particles carry them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sampling {
    /// Volumes of the points (m³).
    pub volumes: Vec<f64>,
    /// Their spacings (m), `V^(1/D)`.
    pub spacings: Vec<f64>,
    /// Volumes of the particles (m³).
    particle_volumes: Vec<f64>,
    /// Nothing where each particle is a point.
    carried: Option<Carried>,
}

/// Which particles carry each point.
#[derive(Clone, Debug, Default, PartialEq)]
struct Carried {
    /// Where each point's weights begin; one more entry at the end.
    starts: Vec<u32>,
    /// Particles and weights.
    weights: Vec<(u32, f64)>,
}

impl Sampling {
    /// Points of `particles` for a fluid of `spacing` (m); `inside_wall` tells of a place (m) whether a wall
    /// fills it.
    pub fn new<const D: usize>(
        particles: &InterfaceParticles<D>,
        spacing: f64,
        inside_wall: impl Fn(&Vector<D>) -> bool,
    ) -> Self {
        let cells = Cells::around(particles);
        let as_fine = |frame: &Frame<D>| frame.iter().all(|(_, edge)| AS_FINE.contains(&(edge / spacing)));
        let all_as_fine = cells.frames.iter().all(as_fine);
        let is_left = |s: usize, at: &Vector<D>| particles.densities[s] == 0.0 && inside_wall(at);
        let mut sampling = Self { particle_volumes: particles.volumes.clone(), ..Self::default() };
        let mut carried = Carried { starts: vec![0], ..Carried::default() };
        let mut add = |volume: f64, weights: &mut dyn Iterator<Item = (u32, f64)>| {
            sampling.volumes.push(volume);
            sampling.spacings.push(volume.powf(1.0 / D as f64));
            carried.weights.extend(weights.filter(|(_, w)| w.abs() > NEGLIGIBLE));
            carried.starts.push(carried.weights.len() as u32);
        };
        if all_as_fine {
            for s in (0..particles.volumes.len()).filter(|&s| !is_left(s, &particles.positions[s])) {
                add(particles.volumes[s], &mut std::iter::once((s as u32, 1.0)));
            }
        } else {
            for body in cells.bodies() {
                let volume = body.iter().map(|&s| particles.volumes[s as usize]).sum();
                let lattice = cells.lattice(&body, volume, spacing);
                let mut points: BTreeMap<[i64; D], (f64, BTreeMap<u32, f64>)> = BTreeMap::new();
                for &s in &body {
                    let (s, from) = (s as usize, &particles.positions[s as usize]);
                    for (cell, offset, share) in cells.pieces(s, particles.volumes[s], &lattice) {
                        if is_left(s, &(from + offset)) {
                            continue;
                        }
                        let volume = particles.volumes[s] * share;
                        let (sum, weights) = points.entry(cell).or_default();
                        *sum += volume;
                        for (t, w) in cells.weights(s, &offset) {
                            *weights.entry(t).or_default() += w * volume;
                        }
                    }
                }
                for (volume, weights) in points.into_values() {
                    add(volume, &mut weights.into_iter().map(|(t, w)| (t, w / volume)));
                }
            }
        }
        let is_each_particle = all_as_fine && sampling.volumes.len() == particles.volumes.len();
        sampling.carried = (!is_each_particle).then_some(carried);
        sampling
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.volumes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.volumes.is_empty()
    }

    /// Values at the points of those at the particles.
    pub fn at_points<const D: usize>(&self, particles: &[Vector<D>], points: &mut Vec<Vector<D>>) {
        points.clear();
        match &self.carried {
            None => points.extend_from_slice(particles),
            Some(carried) => points.extend((0..self.len()).map(|i| {
                let sum = |sum, &(s, w): &(u32, f64)| sum + particles[s as usize] * w;
                carried.of(i).iter().fold(Vector::zeros(), sum)
            })),
        }
    }

    /// Loads (Pa/m) on the particles of those on the points.
    pub fn at_particles<const D: usize>(&self, points: &[Vector<D>], particles: &mut Vec<Vector<D>>) {
        let Some(carried) = &self.carried else {
            particles.clear();
            return particles.extend_from_slice(points);
        };
        particles.clear();
        particles.resize(self.particle_volumes.len(), Vector::zeros());
        for (i, (load, volume)) in points.iter().zip(&self.volumes).enumerate() {
            let force = load * *volume;
            carried.of(i).iter().for_each(|&(s, w)| particles[s as usize] += force * w);
        }
        particles.iter_mut().zip(&self.particle_volumes).for_each(|(load, volume)| *load /= *volume);
    }

    /// Means at the particles of the `values` that `count`, weighed by how much of each point a particle
    /// carries; zero where none do. `total` is memory.
    pub fn means<T, U>(
        &self,
        values: &[T],
        zero: U,
        count: impl Fn(&T) -> Option<U>,
        total: &mut Vec<f64>,
        out: &mut Vec<U>,
    ) where
        U: Copy + std::ops::Add<Output = U> + std::ops::Mul<f64, Output = U>,
    {
        out.clear();
        let Some(carried) = &self.carried else {
            return out.extend(values.iter().map(|value| count(value).unwrap_or(zero)));
        };
        total.clear();
        total.resize(self.particle_volumes.len(), 0.0);
        out.resize(total.len(), zero);
        for (i, (value, volume)) in values.iter().zip(&self.volumes).enumerate() {
            let Some(value) = count(value) else { continue };
            for &(s, w) in carried.of(i).iter().filter(|(_, w)| *w > 0.0) {
                out[s as usize] = out[s as usize] + value * (w * volume);
                total[s as usize] += w * volume;
            }
        }
        out.iter_mut()
            .zip(&*total)
            .filter(|(_, t)| **t > 0.0)
            .for_each(|(mean, t)| *mean = *mean * (1.0 / t));
    }
}

impl Carried {
    fn of(&self, point: usize) -> &[(u32, f64)] {
        &self.weights[self.starts[point] as usize..self.starts[point + 1] as usize]
    }
}

/// The structure where its boundary points are, for one step.
#[derive(Clone, Debug, Default)]
pub struct BoundaryPoints<const D: usize> {
    /// Positions at the step's start (m).
    pub positions: Vec<Vector<D>>,
    /// Velocities (m/s) under the held load.
    pub velocities: Vec<Vector<D>>,
    /// Velocities (m/s) without it.
    pub unloaded: Vec<Vector<D>>,
    /// The same of the interface particles.
    pub unloaded_particles: Vec<Vector<D>>,
}

impl<const D: usize> BoundaryPoints<D> {
    /// The points of what the structure sent for a step of `dt` (s). `compliance` (m³/kg) of each interface
    /// particle is empty where none yields.
    pub fn take(
        &mut self,
        sampling: &Sampling,
        structure: &InterfaceInput<'_, D>,
        compliance: &[f64],
        dt: f64,
    ) {
        sampling.at_points(structure.positions, &mut self.positions);
        sampling.at_points(structure.velocities, &mut self.velocities);
        self.unloaded_particles.clear();
        self.unloaded_particles.extend_from_slice(structure.velocities);
        let held = structure.held_pressure_gradients.iter().zip(compliance);
        self.unloaded_particles.iter_mut().zip(held).for_each(|(u, (held, c))| *u += held * (dt * c));
        sampling.at_points(&self.unloaded_particles, &mut self.unloaded);
    }
}

/// Unit vectors along the edges of a cell, each with the edge (m).
type Frame<const D: usize> = Vec<(Vector<D>, f64)>;

/// A lattice that tiles a body's box.
struct BodyLattice<const D: usize> {
    axes: [Vector<D>; D],
    low: [f64; D],
    edges: [f64; D],
    counts: [i64; D],
}

impl<const D: usize> BodyLattice<D> {
    /// Cuts what reaches `half` (m) to both sides of a place (m) along an axis at the lattice's cells: the
    /// cell, the middle (m) from the place, and the share of each cut. What reaches out of the box counts
    /// within.
    fn cut(&self, i: usize, at: &Vector<D>, half: f64) -> Vec<(i64, f64, f64)> {
        let (low, edge) = (self.low[i], self.edges[i]);
        let high = low + edge * self.counts[i] as f64;
        let middle = self.axes[i].dot(at);
        let (from, to) = ((middle - half).clamp(low, high), (middle + half).clamp(low, high));
        let cell = |x: f64| (((x - low) / edge).floor() as i64).clamp(0, self.counts[i] - 1);
        if to - from < NEGLIGIBLE_LENGTH * edge {
            let inside = middle.clamp(low, high);
            return vec![(cell(inside), inside - middle, 1.0)];
        }
        let cuts = (cell(from)..=cell(to)).map(|k| {
            let (begin, end) = (low + edge * k as f64, low + edge * (k + 1) as f64);
            let (begin, end) = (begin.max(from), end.min(to));
            (k, 0.5 * (begin + end) - middle, (end - begin) / (to - from))
        });
        cuts.filter(|(.., share)| *share > NEGLIGIBLE_LENGTH).collect()
    }
}

/// The cells of interface particles, as their neighbours tell them.
struct Cells<'a, const D: usize> {
    positions: &'a [Vector<D>],
    near: NeighbourList,
    /// How far (m) each particle's pieces are carried by others.
    reach: Vec<f64>,
    /// The edges of each cell along which it has neighbours.
    frames: Vec<Frame<D>>,
    /// Of each particle, the inverse of `Σ φ (X_t − X_s) ⊗ (X_t − X_s)`.
    moments: Vec<Matrix<D>>,
}

impl<'a, const D: usize> Cells<'a, D> {
    fn around(particles: &'a InterfaceParticles<D>) -> Self {
        let positions = &particles.positions[..];
        let mean_edges = particles.volumes.iter().map(|v| v.powf(1.0 / D as f64));
        let longest = mean_edges.fold(0.0, f64::max);
        let mut near = NeighbourList::default();
        if longest > 0.0 {
            let grid = CellGrid::new(positions, SIGHT * longest);
            near.rebuild(positions, &grid, positions);
        }
        let mut cells = Self { positions, near, reach: Vec::new(), frames: Vec::new(), moments: Vec::new() };
        let all = || (0..positions.len()).into_par_iter();
        cells.reach = vec![SIGHT * longest; positions.len()];
        cells.frames = all().map(|s| cells.frame(s, particles.volumes[s])).collect();
        let longest = |frame: &Frame<D>| frame.iter().map(|(_, edge)| *edge).fold(0.0, f64::max);
        cells.reach = cells.frames.iter().map(|frame| REACH * longest(frame)).collect();
        cells.moments = all().map(|s| cells.moment(s, &cells.frames[s])).collect();
        cells
    }

    /// Offsets (m) from particle `s` to its neighbours, nearest first.
    fn neighbours(&self, s: usize) -> Vec<(u32, Vector<D>)> {
        let others = self.near.of(s).iter().filter(|&&t| t as usize != s);
        let mut offsets: Vec<_> =
            others.map(|&t| (t, self.positions[t as usize] - self.positions[s])).collect();
        offsets.retain(|(_, r)| r.norm() < self.reach[s]);
        offsets.sort_by(|(_, p), (_, q)| p.norm_squared().total_cmp(&q.norm_squared()));
        offsets
    }

    /// Axes along which particle `s` has neighbours, each with the edge of the cell: the nearest neighbour's
    /// distance along it, all scaled to the cell's volume where there are as many axes as dimensions.
    fn frame(&self, s: usize, volume: f64) -> Frame<D> {
        let mut axes: Vec<(Vector<D>, f64)> = Vec::new();
        for (_, offset) in self.neighbours(s) {
            let aside = axes.iter().fold(offset, |r, (axis, _)| r - axis * axis.dot(&r));
            if axes.len() < D && aside.norm() > 0.9 * offset.norm() {
                axes.push((aside.normalize(), offset.norm()));
            }
        }
        if axes.len() == D {
            let product: f64 = axes.iter().map(|(_, edge)| edge).product();
            let scale = (volume / product).powf(1.0 / D as f64);
            axes.iter_mut().for_each(|(_, edge)| *edge *= scale);
        }
        axes
    }

    fn moment(&self, s: usize, frame: &Frame<D>) -> Matrix<D> {
        let mut moment = Matrix::zeros();
        for (_, r) in self.neighbours(s) {
            moment += tensor::outer(&r, &r) * weight(&r, self.reach[s]);
        }
        // Along axes without neighbours nothing is asked.
        let scale = (0..D).map(|i| moment[(i, i)]).sum::<f64>();
        let known = frame.iter().fold(Matrix::zeros(), |sum, (axis, _)| sum + tensor::outer(axis, axis));
        moment += (Matrix::identity() - known) * scale;
        tensor::inverse(&moment).unwrap_or_else(Matrix::zeros)
    }

    /// Particles that neighbours lead to from each other.
    fn bodies(&self) -> Vec<Vec<u32>> {
        let mut bodies = Vec::new();
        let mut seen = vec![false; self.positions.len()];
        for first in 0..seen.len() {
            if std::mem::replace(&mut seen[first], true) {
                continue;
            }
            let (mut body, mut next) = (vec![first as u32], 0);
            while let Some(&s) = body.get(next) {
                next += 1;
                for (t, _) in self.neighbours(s as usize) {
                    if !std::mem::replace(&mut seen[t as usize], true) {
                        body.push(t);
                    }
                }
            }
            bodies.push(body);
        }
        bodies
    }

    /// A lattice of edges near `spacing` (m) over the box of a body: along the edges of its cells where they
    /// all point the same way and fill that box, else along the axes.
    fn lattice(&self, body: &[u32], volume: f64, spacing: f64) -> BodyLattice<D> {
        let frame = &self.frames[body[0] as usize];
        let like = |axis: &Vector<D>, other: &Vector<D>| axis.dot(other).abs() > 1.0 - 1e-6;
        let agrees = |&s: &u32| {
            let own = &self.frames[s as usize];
            own.iter().all(|(axis, _)| frame.iter().any(|(other, _)| like(axis, other)))
        };
        let middles = |axes: &[Vector<D>; D]| {
            let along = |i: usize| body.iter().map(move |&s| axes[i].dot(&self.positions[s as usize]));
            let low: [f64; D] = std::array::from_fn(|i| along(i).fold(f64::INFINITY, f64::min));
            let high: [f64; D] = std::array::from_fn(|i| along(i).fold(f64::NEG_INFINITY, f64::max));
            (low, high)
        };
        let mut axes: [Vector<D>; D] =
            std::array::from_fn(|i| Vector::from_fn(|j, _| if i == j { 1.0 } else { 0.0 }));
        let (mut low, mut high) = middles(&axes);
        // The faces are where the box has the body's volume, no farther out than half a cell.
        let longest = frame.iter().map(|(_, edge)| *edge).fold(0.0, f64::max);
        let filled = |out: f64| low.iter().zip(&high).map(|(l, h)| h - l + 2.0 * out).product::<f64>();
        let (mut least, mut most) = (0.0, 0.5 * longest);
        for _ in 0..50 {
            let out = 0.5 * (least + most);
            *(if filled(out) < volume { &mut least } else { &mut most }) = out;
        }
        // A chain has no volume to go by.
        let mut out = [if frame.len() == D { most } else { 0.5 * longest }; D];
        if frame.len() == D && body.iter().all(agrees) {
            let own = std::array::from_fn(|i| frame[i].0);
            let (own_low, own_high) = middles(&own);
            let edges: [f64; D] = std::array::from_fn(|i| frame[i].1);
            let box_volume: f64 = (0..D).map(|i| own_high[i] - own_low[i] + edges[i]).product();
            if volume > FILLED * box_volume {
                (axes, low, high, out) = (own, own_low, own_high, edges.map(|edge| 0.5 * edge));
            }
        }
        for i in 0..D {
            (low[i], high[i]) = (low[i] - out[i], high[i] + out[i]);
        }
        // A body of one layer would have no side to tell from the other: a thin one keeps three of its own.
        let thin = (0..D).map(|i| high[i] - low[i]).filter(|extent| *extent < THIN * spacing);
        let spacing = thin.fold(spacing, |spacing, extent| spacing.min((extent / 3.0).max(longest)));
        let counts: [i64; D] =
            std::array::from_fn(|i| ((high[i] - low[i]) / spacing).round().max(1.0) as i64);
        let edges = std::array::from_fn(|i| {
            let edge = (high[i] - low[i]) / counts[i] as f64;
            if edge > 0.0 { edge } else { spacing }
        });
        BodyLattice { axes, low, edges, counts }
    }

    /// The pieces of particle `s` in the cells of a lattice: the cell, the offset (m) from the particle to
    /// the middle, and the share of the particle. A cell whose edges are not the lattice's counts as a cube
    /// along them.
    fn pieces(&self, s: usize, volume: f64, lattice: &BodyLattice<D>) -> Vec<([i64; D], Vector<D>, f64)> {
        let frame = &self.frames[s];
        let like = |axis: &Vector<D>, other: &Vector<D>| axis.dot(other).abs() > 1.0 - 1e-6;
        let aligned = frame.iter().all(|(own, _)| lattice.axes.iter().any(|axis| like(own, axis)));
        let is_chain = frame.len() < D;
        let mut pieces = vec![([0; D], Vector::zeros(), 1.0)];
        for (i, axis) in lattice.axes.iter().enumerate() {
            let edge = if aligned || is_chain {
                frame.iter().map(|(own, edge)| edge * own.dot(axis).abs()).sum()
            } else {
                volume.powf(1.0 / D as f64)
            };
            let cuts = lattice.cut(i, &self.positions[s], 0.5 * edge);
            let all = pieces.iter().flat_map(|(cell, offset, share)| {
                cuts.iter().map(move |(k, along, part)| {
                    let mut cell: [i64; D] = *cell;
                    cell[i] = *k;
                    (cell, offset + axis * *along, share * part)
                })
            });
            pieces = all.collect();
        }
        if is_chain {
            // It says nothing of what is beside it.
            for (_, offset, _) in &mut pieces {
                *offset = frame.iter().fold(Vector::zeros(), |sum, (own, _)| sum + own * own.dot(offset));
            }
        }
        pieces
    }

    /// Weights by which the particles around `s` carry the point at `offset` (m) from it.
    fn weights(&self, s: usize, offset: &Vector<D>) -> Vec<(u32, f64)> {
        if offset.norm() < NEGLIGIBLE_LENGTH * self.reach[s] {
            return vec![(s as u32, 1.0)];
        }
        let slope = self.moments[s] * offset;
        let neighbours = self.neighbours(s);
        let mut weights: Vec<(u32, f64)> =
            neighbours.iter().map(|(t, r)| (*t, slope.dot(r) * weight(r, self.reach[s]))).collect();
        weights.push((s as u32, 1.0 - weights.iter().map(|(_, w)| w).sum::<f64>()));
        weights.retain(|(_, w)| *w != 0.0);
        weights
    }
}

/// Weight φ of a neighbour at `offset` (m): smooth, zero at `reach` (m).
fn weight<const D: usize>(offset: &Vector<D>, reach: f64) -> f64 {
    (1.0 - offset.norm_squared() / (reach * reach)).max(0.0).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sph::lattice::{Lattice, jittered};

    type V = Vector<2>;

    fn particles(edge: f64) -> InterfaceParticles<2> {
        let lattice = Lattice::fill_box(V::zeros(), V::from([0.4, 0.2]), edge);
        let volumes = vec![lattice.cell_volume(); lattice.positions.len()];
        InterfaceParticles { positions: lattice.positions, densities: vec![1000.0; volumes.len()], volumes }
    }

    #[test]
    fn particles_as_fine_as_the_fluid_are_the_points() {
        let sampling = Sampling::new(&particles(0.02), 0.02, |_| false);
        assert_eq!(sampling.carried, None);
        assert_eq!(sampling.len(), 200);
    }

    /// Also of particles that are no lattice: volume, linear motion, force, moment and work.
    #[test]
    fn pieces_are_carried_exactly_by_linear_motion_and_loads_go_back() {
        for (edge, jitter) in [(0.04, 0.0), (0.05, 0.0), (0.04, 0.2)] {
            let mut particles = particles(edge);
            particles.positions = jittered(particles.positions, jitter * edge, 3);
            let sampling = Sampling::new(&particles, 0.0125, |_| false);
            assert!((400..=600).contains(&sampling.len()), "{edge}");
            assert!((sampling.volumes.iter().sum::<f64>() - 0.08).abs() < 1e-14);
            let (mut points, mut moved, mut back) = (Vec::new(), Vec::new(), Vec::new());
            sampling.at_points(&particles.positions, &mut points);
            let linear = |x: &V| V::from([0.3 + 2.0 * x.x - x.y, -0.1 + 0.5 * x.x + 3.0 * x.y]);
            let motion: Vec<V> = particles.positions.iter().map(linear).collect();
            sampling.at_points(&motion, &mut moved);
            assert!(points.iter().zip(&moved).all(|(x, u)| (linear(x) - u).norm() < 1e-12));
            let load: Vec<V> = points.iter().map(|x| V::from([x.y * x.x, 1.0 - x.x])).collect();
            sampling.at_particles(&load, &mut back);
            let sum = |at: &[V], of: &[V], volumes: &[f64]| {
                let each = at.iter().zip(of).zip(volumes);
                each.fold([0.0; 4], |sum: [f64; 4], ((x, g), v)| {
                    let u = linear(x);
                    let of = [g.x, g.y, x.x * g.y - x.y * g.x, g.dot(&u)].map(|value| value * v);
                    std::array::from_fn(|i| sum[i] + of[i])
                })
            };
            let on_points = sum(&points, &load, &sampling.volumes);
            let on_particles = sum(&particles.positions, &back, &particles.volumes);
            assert!(on_points.iter().zip(on_particles).all(|(a, b)| (a - b).abs() < 1e-14), "{edge}");
        }
    }

    /// A lattice, coarser or finer, is met at the points of one of the fluid's spacing.
    #[test]
    fn points_of_a_lattice_are_a_lattice_of_the_fluids_spacing() {
        let lattice = Lattice::fill_box(V::zeros(), V::from([0.4, 0.2]), 0.02).positions;
        for edge in [0.04, 0.01, 0.005] {
            let particles = particles(edge);
            let sampling = Sampling::new(&particles, 0.02, |_| false);
            let mut points = Vec::new();
            sampling.at_points(&particles.positions, &mut points);
            assert_eq!(points.len(), lattice.len(), "{edge}");
            let has = |x: &V| points.iter().any(|p| (p - x).norm() < 1e-12);
            let missing: Vec<_> = lattice.iter().filter(|x| !has(x)).collect();
            assert!(missing.is_empty(), "{edge} {missing:?} {points:?}");
        }
        assert_eq!(Sampling::new(&particles(0.0133333), 0.02, |_| false).len(), lattice.len());
    }

    /// Of particles that are no lattice along the faces the points are, nearly: those next to a face stand in
    /// a row half a spacing behind it.
    #[test]
    fn points_follow_the_faces_of_a_body_whose_lattice_does_not() {
        let (low, high, angle, edge) = (V::zeros(), V::from([0.4, 0.24]), 0.3f64, 0.027);
        let turned =
            |p: &V| V::from([angle.cos() * p.x - angle.sin() * p.y, angle.sin() * p.x + angle.cos() * p.y]);
        let grid = Lattice::fill_box(V::repeat(-1.08), V::repeat(1.08), edge).positions;
        let inside = |p: &V| (0..2).all(|i| low[i] < p[i] && p[i] < high[i]);
        let positions: Vec<V> = grid.iter().map(turned).filter(inside).collect();
        let volumes = vec![0.4 * 0.24 / positions.len() as f64; positions.len()];
        let particles = InterfaceParticles { positions, densities: vec![1.0; volumes.len()], volumes };
        let sampling = Sampling::new(&particles, 0.02, |_| false);
        let mut points = Vec::new();
        sampling.at_points(&particles.positions, &mut points);
        assert_eq!(points.len(), 20 * 12);
        let first: Vec<f64> = points.iter().map(|p| p.x).filter(|x| *x < 0.02).collect();
        assert_eq!(first.len(), 12);
        assert!(first.iter().all(|x| (x - 0.01).abs() < 0.005), "{first:?}");
    }

    #[test]
    fn a_thin_body_keeps_three_layers() {
        let lattice = Lattice::fill_box(V::zeros(), V::from([0.4, 0.04]), 0.01);
        let volumes = vec![lattice.cell_volume(); lattice.positions.len()];
        let positions = lattice.positions;
        let particles = InterfaceParticles { positions, densities: vec![1.0; volumes.len()], volumes };
        assert_eq!(Sampling::new(&particles, 0.04, |_| false).len(), 3 * 30);
        assert_eq!(Sampling::new(&particles, 0.02, |_| false).len(), 2 * 20);
    }

    #[test]
    fn a_chain_is_divided_along_itself_only() {
        let positions: Vec<V> = (0..5).map(|i| V::from([0.1 * f64::from(i), 0.0])).collect();
        let particles = InterfaceParticles { positions, densities: vec![1.0; 5], volumes: vec![5e-3; 5] };
        let sampling = Sampling::new(&particles, 0.05, |_| false);
        let mut points = Vec::new();
        sampling.at_points(&particles.positions, &mut points);
        assert_eq!(points.len(), 10);
        assert!(points.iter().all(|x| x.y == 0.0));
    }

    #[test]
    fn held_particles_inside_a_wall_are_left_to_it() {
        let mut particles = particles(0.02);
        for (x, density) in particles.positions.iter().zip(&mut particles.densities) {
            *density = if x.y < 0.04 { 0.0 } else { 1000.0 };
        }
        let sampling = Sampling::new(&particles, 0.02, |x| x.y < 0.06);
        assert_eq!(sampling.len(), 160);
        let (mut points, mut back) = (Vec::new(), Vec::new());
        sampling.at_points(&particles.positions, &mut points);
        assert!(points.iter().all(|x| x.y > 0.04));
        sampling.at_particles(&points, &mut back);
        assert_eq!(back.len(), 200);
    }
}
