//! Radial basis functions with local support: a partition of unity over clusters of source points.
//!
//! Balls of radius `R` around the nodes of a lattice of spacing `R` overlap so that every target is inside
//! one or more (with nodes 1.2 `R` apart a fifth of the time was saved; the error was 1.4 times as large, and
//! of 400 random clouds six had a target at a corner with no ball to follow). In each ball the source points
//! are interpolated by a linear polynomial, fitted by least squares, and Wendland's C² function of what the
//! polynomial leaves:
//!
//! ```text
//! s(x) = p(x) + Σ λᵢ φ(|x − xᵢ| / 4R),   φ(q) = (1 − q)⁴ (4q + 1),   Φ λ = f − p
//! ```
//!
//! and `u(x) = Σ_k ω_k(x) s_k(x)`, where `ω_k ∝ φ(|x − c_k| / R)` and `Σ ω_k = 1`. As weights of one ball,
//! with `w₀ = Φ⁻¹ φ(x)`,
//!
//! ```text
//! w = w₀ + P (PᵀP)⁻¹ (p(x) − Pᵀ w₀)
//! ```
//!
//! so `Pᵀ w = p(x)`: linear fields are exact to round-off however badly `Φ` is conditioned, and `u`
//! interpolates. `R` is the radius within which a source point has `points_per_cluster` others (median over
//! some), so the support shrinks with the spacing and the error falls with its square at least. (H. Wendland,
//! Scattered Data Approximation, 2005, table 9.1 and section 15.4; polynomial apart from the basis functions:
//! F. Lindner, M. Mehl, B. Uekermann, Radial basis function interpolation for black-box multi-physics
//! simulations, 2017.)
//!
//! Smooth (but where a cluster is left out for a target that it does not determine) and the most accurate of
//! the methods. When points move each cluster is factorised, `Φ = L D Lᵀ`, and each target in it takes two
//! triangular solutions and the correction of the polynomial. Eight clusters or targets are worked on at
//! once, targets of one cell of the lattice together: [`super::cells`] has who is where, [`super::factors`]
//! and [`super::weigh`] the arithmetic.

use super::cell_grid::CellGrid;
use super::cells::{CORNERS, Cells, NONE, Sources, middle};
use super::error::MappingError;
use super::factors::{BLOCK, Factorise, offset};
use super::lanes::{LANES, Lanes};
use super::nearest_neighbour::{POINTS_PER_CELL, out_of_reach};
use super::nearest_neighbour_gradient::typical_distance;
use super::parts::{count, part, work_off};
use super::rows::Rows;
use super::semidefinite::solve;
use super::weigh::{self, SUPPORT, Values, Weigh};
use std::ops::Range;

/// The source points in cells, and the clusters of each part of the targets.
#[derive(Clone, Debug)]
pub(super) struct RadialBasis {
    points_per_cluster: usize,
    grid: CellGrid,
    distances: Vec<f64>,
    samples: Vec<f64>,
    parts: Vec<Part>,
}

impl RadialBasis {
    /// With about so many points in a cluster.
    pub fn new(points_per_cluster: usize) -> Self {
        Self {
            points_per_cluster,
            grid: CellGrid::default(),
            distances: Vec::new(),
            samples: Vec::new(),
            parts: Vec::new(),
        }
    }

    /// Gathers a row for each target. There is a source point, and all points are finite.
    pub fn fill<const D: usize>(
        &mut self,
        source: &[[f64; D]],
        target: &[[f64; D]],
        reach: f64,
        threads: usize,
        rows: &mut Rows,
    ) -> Result<(), MappingError> {
        let Self { points_per_cluster, grid, distances, samples, parts } = self;
        grid.rebuild(source, POINTS_PER_CELL);
        let in_cluster = (*points_per_cluster).max(D + 1);
        let radius = typical_distance(grid, source, in_cluster, distances, samples);
        // A single source point has no spacing.
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let sources = Sources { grid, positions: source, radius };
        let count = count(target.len(), threads);
        parts.resize_with(count, Part::default);
        for (k, this) in parts.iter_mut().enumerate() {
            this.targets = part(target.len(), count, k);
        }
        work_off(&mut *parts, |part| part.lay(sources, target, reach))?;
        rows.lay_out(parts.iter().flat_map(|part| &part.cells.lengths));
        let (starts, mut columns, mut weights) = rows.slots();
        let tasks: Vec<_> = parts
            .iter_mut()
            .map(|part| {
                let starts = &starts[part.targets.start..=part.targets.end];
                let entries = starts[starts.len() - 1] - starts[0];
                let (own_columns, own_weights);
                (own_columns, columns) = std::mem::take(&mut columns).split_at_mut(entries);
                (own_weights, weights) = std::mem::take(&mut weights).split_at_mut(entries);
                (part, Slots { starts, columns: own_columns, weights: own_weights })
            })
            .collect();
        work_off(tasks, |(part, slots)| part.fill(sources, target, slots))?;
        if parts.iter().any(|part| part.zeros) {
            rows.drop_zeros();
        }
        Ok(())
    }
}

/// Rows of a part of the targets.
struct Slots<'a> {
    /// Where each starts in the whole, and the last ends.
    starts: &'a [usize],
    columns: &'a mut [u32],
    weights: &'a mut [f64],
}

/// Source points of a ball with what their weights are worked out from.
#[derive(Clone, Copy, Debug)]
struct Cluster {
    /// First of its factors, and of its inverse pivots.
    factors: usize,
    inverse_pivots: usize,
    /// Mean position (m), from which the polynomial counts.
    mean: [f64; 3],
    /// A generalised inverse of `Σ d dᵀ` of the positions from the mean.
    inverse_spread: [[f64; 3]; 3],
    /// Source points that coincide, which leaves no factors.
    coincident: Option<(usize, usize)>,
}

/// The clusters of a part of the targets, and scratch.
#[derive(Clone, Debug, Default)]
struct Part {
    targets: Range<usize>,
    cells: Cells,
    clusters: Vec<Cluster>,
    factors: Vec<f64>,
    inverse_pivots: Vec<f64>,
    /// Positions of the clusters' points from their means, flat.
    places: Vec<f64>,
    batch: Batch,
    cell: CellScratch,
    /// Whether a weight is zero.
    zeros: bool,
    /// The first target that cannot be mapped.
    error: Option<(usize, MappingError)>,
}

/// Clusters that are factorised together.
#[derive(Clone, Debug, Default)]
struct Batch {
    places: Vec<Lanes>,
    present: Vec<Lanes>,
    factors: Vec<Lanes>,
    inverse_pivots: Vec<Lanes>,
}

/// Targets that are weighed together.
#[derive(Clone, Debug, Default)]
struct CellScratch {
    places: Vec<f64>,
    values: Vec<Lanes>,
    unknowns: Vec<Lanes>,
    sums: Vec<Lanes>,
    /// Points of the union that are in a row, and their columns.
    taken: Vec<u32>,
    columns: Vec<u32>,
}

impl Part {
    /// Finds the source points of each row; the error is that of the first target out of reach.
    fn lay<const D: usize>(
        &mut self,
        sources: Sources<D>,
        target: &[[f64; D]],
        reach: f64,
    ) -> Result<(), MappingError> {
        let own = &target[self.targets.clone()];
        self.cells.lay(sources, own, BLOCK);
        for (k, x) in own.iter().enumerate() {
            // A point of a ball that the target is in is nearer than its diameter.
            let near = self.cells.lengths[k] > 0 && reach >= 2.0 * sources.radius;
            if !near && sources.grid.nearest(x, reach).is_none() {
                return Err(out_of_reach(sources.grid, self.targets.start + k, x, reach));
            }
        }
        Ok(())
    }

    /// Fills the rows in, cell by cell.
    fn fill<const D: usize>(
        &mut self,
        sources: Sources<D>,
        target: &[[f64; D]],
        mut slots: Slots,
    ) -> Result<(), MappingError> {
        self.clusters.clear();
        self.factors.clear();
        self.inverse_pivots.clear();
        self.places.clear();
        self.zeros = false;
        self.error = None;
        for at in 0..self.cells.cells.len() {
            let last = self.cells.cells[at].clusters.iter().copied().filter(|cluster| *cluster != NONE).max();
            while last.is_some_and(|last| self.clusters.len() <= last as usize) {
                self.factorise(sources);
            }
            let mut targets = self.cells.cells[at].targets.clone();
            while !targets.is_empty() {
                let next = targets.end.min(targets.start + 2 * LANES);
                if next - targets.start > LANES {
                    self.weigh::<D, 2>(sources, target, at, targets.start..next, &mut slots);
                } else {
                    self.weigh::<D, 1>(sources, target, at, targets.start..next, &mut slots);
                }
                targets.start = next;
            }
        }
        self.error.take().map_or(Ok(()), |(_, error)| Err(error))
    }

    /// Factorises the next clusters.
    fn factorise<const D: usize>(&mut self, sources: Sources<D>) {
        let Sources { positions, radius, .. } = sources;
        let Self { cells, clusters, factors, inverse_pivots, places, batch, .. } = self;
        let first = clusters.len();
        let starts = &cells.starts[first..cells.starts.len().min(first + LANES + 1)];
        let count = starts.windows(2).map(|w| w[1] - w[0]).fold(0, usize::max);
        let blocks = count.div_ceil(BLOCK);
        batch.places.clear();
        batch.places.resize(D * BLOCK * blocks, Lanes::ZERO);
        batch.present.clear();
        batch.present.resize(BLOCK * blocks, Lanes::ZERO);
        batch.factors.resize(offset(blocks), Lanes::ZERO);
        batch.inverse_pivots.resize(BLOCK * blocks, Lanes::ZERO);
        let lanes = batch.places.as_chunks_mut::<D>().0;
        let per_radius = 1.0 / radius;
        for (lane, ends) in starts.windows(2).enumerate() {
            let members = &cells.points[ends[0]..ends[1]];
            let (mean, spread) = moments(positions, members, per_radius);
            for (k, &point) in members.iter().enumerate() {
                batch.present[k].0[lane] = 1.0;
                for c in 0..D {
                    let place = (positions[point as usize][c] - mean[c]) * per_radius;
                    lanes[k][c].0[lane] = place * (1.0 / SUPPORT);
                    places.push(place);
                }
            }
            let mut inverse_spread = [[0.0; 3]; 3];
            for e in 0..D {
                let column = solve(spread, std::array::from_fn(|c| if c == e { 1.0 } else { 0.0 }));
                for c in 0..D {
                    inverse_spread[c][e] = column[c];
                }
            }
            let mut absolute = [0.0; 3];
            absolute[..D].copy_from_slice(&mean);
            clusters.push(Cluster {
                factors: 0,
                inverse_pivots: 0,
                mean: absolute,
                inverse_spread,
                coincident: None,
            });
        }
        let lost = Factorise {
            places: lanes,
            present: &batch.present,
            factors: &mut batch.factors,
            inverse_pivots: &mut batch.inverse_pivots,
        }
        .run();
        for (lane, ends) in starts.windows(2).enumerate() {
            let members = &cells.points[ends[0]..ends[1]];
            let cluster = &mut clusters[first + lane];
            let blocks = members.len().div_ceil(BLOCK);
            (cluster.factors, cluster.inverse_pivots) = (factors.len(), inverse_pivots.len());
            factors.extend(batch.factors[..offset(blocks)].iter().map(|lanes| lanes.0[lane]));
            inverse_pivots.extend(batch.inverse_pivots[..BLOCK * blocks].iter().map(|lanes| lanes.0[lane]));
            cluster.coincident = lost[lane].map(|row| nearest_before(positions, members, row));
        }
    }

    /// Weighs up to `W` times [`LANES`] targets of a cell.
    fn weigh<const D: usize, const W: usize>(
        &mut self,
        sources: Sources<D>,
        target: &[[f64; D]],
        at: usize,
        targets: Range<usize>,
        slots: &mut Slots,
    ) {
        let Sources { positions, radius, .. } = sources;
        let Self { cells, clusters, cell: scratch, zeros, error, .. } = self;
        let cell = &cells.cells[at];
        let per_radius = 1.0 / radius;
        let corner: [f64; D] = middle(cell.node, 0, radius);
        let from_corner =
            |x: &[f64; D]| -> [f64; D] { std::array::from_fn(|c| (x[c] - corner[c]) * per_radius) };
        let order = &cells.order[targets.clone()];
        let mut x = [[Lanes::ZERO; W]; D];
        for lane in 0..W * LANES {
            // Lanes without a target do what the last does.
            let point = self.targets.start + order[lane.min(order.len() - 1)] as usize;
            let place = from_corner(&target[point]);
            for c in 0..D {
                x[c][lane / LANES].0[lane % LANES] = place[c];
            }
        }
        let union = &cells.union[cell.union.clone()];
        let corners = &cells.union_corners[cell.union.clone()];
        scratch.places.clear();
        for &point in union {
            scratch.places.extend(from_corner(&positions[point as usize]));
        }
        let largest = (0..1 << D).map(|k| cell.clusters[k]).filter(|cluster| *cluster != NONE);
        let largest =
            largest.map(|k| cells.starts[k as usize + 1] - cells.starts[k as usize]).max().unwrap_or(0);
        scratch.values.resize(W * (union.len() + 1), Lanes::ZERO);
        scratch.unknowns.resize(W * largest.next_multiple_of(BLOCK), Lanes::ZERO);
        scratch.sums.clear();
        scratch.sums.resize(W * union.len(), Lanes::ZERO);
        let values = scratch.values.as_chunks_mut::<W>().0;
        let unknowns = scratch.unknowns.as_chunks_mut::<W>().0;
        let sums = scratch.sums.as_chunks_mut::<W>().0;
        let arch = pulp::Arch::new();
        arch.dispatch(Values {
            targets: &x,
            places: scratch.places.as_chunks::<D>().0,
            values: &mut *values,
        });
        values[union.len()] = [Lanes::ZERO; W];
        let mut total = [Lanes::ZERO; W];
        let inside = &cells.inside[targets];
        for k in 0..1 << D {
            let mut takes = [0; 2 * LANES];
            for (takes, inside) in takes.iter_mut().zip(inside) {
                *takes = inside >> k & 1;
            }
            if cell.clusters[k] == NONE || takes.iter().all(|takes| *takes == 0) {
                continue;
            }
            let number = cell.clusters[k] as usize;
            let cluster = &clusters[number];
            if let Some((first, second)) = cluster.coincident {
                let lane = takes.iter().position(|takes| *takes == 1).expect("one is inside");
                note(
                    error,
                    self.targets.start + order[lane] as usize,
                    MappingError::Coincident { first, second },
                );
                continue;
            }
            let points = cells.starts[number]..cells.starts[number + 1];
            if points.len() <= D {
                continue;
            }
            let padded = points.len().next_multiple_of(BLOCK);
            let slots = cell.slots[k] as usize;
            let weigh = Weigh {
                cluster: weigh::Cluster {
                    count: points.len(),
                    factors: &self.factors[cluster.factors..][..offset(padded / BLOCK)],
                    inverse_pivots: &self.inverse_pivots[cluster.inverse_pivots..][..padded],
                    places: &self.places.as_chunks::<D>().0[points],
                    mean: std::array::from_fn(|c| (cluster.mean[c] - corner[c]) * per_radius),
                    inverse_spread: std::array::from_fn(|c| {
                        std::array::from_fn(|e| cluster.inverse_spread[c][e])
                    }),
                    slots: &cells.slots[slots..slots + padded],
                    middle: std::array::from_fn(|c| (k >> c & 1) as f64),
                    inside: takes,
                },
                targets: &x,
                values,
                unknowns: &mut unknowns[..padded],
                sums,
                total: &mut total,
            };
            arch.dispatch(weigh);
        }
        let mut listed = 0;
        for (lane, &number) in order.iter().enumerate() {
            let (w, l) = (lane / LANES, lane % LANES);
            let point = self.targets.start + number as usize;
            if total[w].0[l] <= 0.0 {
                let sources =
                    (0..CORNERS).filter(|k| inside[lane] >> k & 1 == 1).map(|k| cell.clusters[k] as usize);
                let sources = sources.map(|k| cells.starts[k + 1] - cells.starts[k]).max().unwrap_or(0);
                let position = target[point].to_vec();
                note(error, point, MappingError::Degenerate { point, position, sources });
                continue;
            }
            let from = slots.starts[number as usize] - slots.starts[0];
            let to = slots.starts[number as usize + 1] - slots.starts[0];
            if listed != inside[lane] {
                listed = inside[lane];
                list(listed, union, corners, &mut scratch.taken, &mut scratch.columns);
            }
            slots.columns[from..to].copy_from_slice(&scratch.columns[..to - from]);
            let (mut zero, per_total) = (false, 1.0 / total[w].0[l]);
            for (weight, &slot) in slots.weights[from..to].iter_mut().zip(&scratch.taken) {
                *weight = sums[slot as usize][w].0[l] * per_total;
                zero |= *weight == 0.0;
            }
            *zeros |= zero;
        }
    }
}

/// Lists which points of a union are in a row of targets in the balls around these corners, and their
/// columns.
fn list(inside: u8, union: &[u32], corners: &[u8], taken: &mut Vec<u32>, columns: &mut Vec<u32>) {
    // One more than there are points, so that those that are not in the row can be written over.
    taken.resize(union.len() + 1, 0);
    columns.resize(union.len() + 1, 0);
    let (taken, columns) = (&mut taken[..], &mut columns[..]);
    let mut length = 0;
    for (slot, (&column, corners)) in union.iter().zip(corners).enumerate() {
        taken[length] = slot as u32;
        columns[length] = column;
        length += usize::from(corners & inside != 0);
    }
}

/// Keeps the error of the first target.
fn note(error: &mut Option<(usize, MappingError)>, point: usize, found: MappingError) {
    if error.as_ref().is_none_or(|(first, _)| point < *first) {
        *error = Some((point, found));
    }
}

/// The point before `row` that is nearest to it, and the point.
fn nearest_before<const D: usize>(positions: &[[f64; D]], members: &[u32], row: usize) -> (usize, usize) {
    let second = members[row] as usize;
    let apart =
        |other: u32| super::cell_grid::distance_squared(&positions[other as usize], &positions[second]);
    let nearest = members[..row].iter().copied().min_by(|a, b| apart(*a).total_cmp(&apart(*b)));
    (nearest.expect("the first pivot is φ(0) = 1") as usize, second)
}

/// Mean position (m), and `Σ d dᵀ` about it in radii.
fn moments<const D: usize>(
    source: &[[f64; D]],
    members: &[u32],
    per_radius: f64,
) -> ([f64; D], [[f64; D]; D]) {
    let (mut mean, mut spread) = ([0.0; D], [[0.0; D]; D]);
    for &i in members {
        for c in 0..D {
            mean[c] += source[i as usize][c];
        }
    }
    mean = mean.map(|sum| sum / members.len().max(1) as f64);
    for &i in members {
        let off: [f64; D] = std::array::from_fn(|c| (source[i as usize][c] - mean[c]) * per_radius);
        for c in 0..D {
            for e in 0..D {
                spread[c][e] += off[c] * off[e];
            }
        }
    }
    (mean, spread)
}
