//! Radial basis functions with local support: a partition of unity over clusters of source points.
//!
//! Balls of radius `R` around the nodes of a lattice of spacing `R` overlap so that every target is inside one or more. In each ball the source
//! points are interpolated by a linear polynomial, fitted by least squares, and Wendland's C² function of what the polynomial leaves:
//!
//! ```text
//! s(x) = p(x) + Σ λᵢ φ(|x − xᵢ| / 4R),   φ(q) = (1 − q)⁴ (4q + 1),   Φ λ = f − p
//! ```
//!
//! and `u(x) = Σ_k ω_k(x) s_k(x)`, where `ω_k ∝ φ(|x − c_k| / R)` and `Σ ω_k = 1`. As weights of one ball, with `w₀ = Φ⁻¹ φ(x)`,
//!
//! ```text
//! w = w₀ + P (PᵀP)⁻¹ (p(x) − Pᵀ w₀)
//! ```
//!
//! so `Pᵀ w = p(x)`: linear fields are exact to round-off however badly `Φ` is conditioned, and `u` interpolates. `R` is the radius within
//! which a source point has `points_per_cluster` others (median over some), so the support shrinks with the spacing and the error falls with
//! its square at least. (H. Wendland, Scattered Data Approximation, 2005, table 9.1 and section 15.4; polynomial apart from the basis functions:
//! F. Lindner, M. Mehl, B. Uekermann, Radial basis function interpolation for black-box multi-physics simulations, 2017.)
//!
//! Smooth (but where a cluster is left out for a target that it does not determine) and the most accurate of the methods, at an inverse matrix for
//! each cluster and a product with it for each target in it when points move. [`super::basis`] has the arithmetic.

use super::basis::{Basis, LANES, Quality, invert, wendland_c2};
use super::cell_grid::{CellGrid, distance_squared};
use super::error::MappingError;
use super::nearest_neighbour::{POINTS_PER_CELL, out_of_reach};
use super::nearest_neighbour_gradient::typical_distance;
use super::parts::Parts;
use super::rows::Rows;
use super::semidefinite::{dot, minus};
use std::collections::HashMap;
use std::ops::Range;

/// Support of the basis functions over the radius of a cluster. On points scattered about a lattice the error at 4 was half of that at 2, and at 8
/// a third less again, as a matrix that is harder to invert.
const SUPPORT: f64 = 4.0;
/// Largest `Σ |w|` of a cluster. Two source points much nearer to each other than to the rest share large weights of opposite sign, which do no
/// harm to smooth fields: up to 60 were met in clouds of random points.
const AMPLIFICATION: f64 = 256.0;
/// Largest `|x − Σ w xᵢ|` and `|1 − Σ w|` (in radii): rounding of sums of a hundred terms stays below, a target off a plane of sources
/// far above.
const INCONSISTENCY: f64 = 1e-11;

/// Source points of a ball with their inverse matrix. Arrays over its points have a stride, see [`super::basis`].
#[derive(Clone, Debug)]
struct Cluster {
    points: Range<usize>,
    /// Points with the zeros behind them.
    stride: usize,
    /// First of its positions from the mean, of its ones, and of its inverse matrix.
    data: usize,
    /// Mean position, from which the polynomial counts.
    mean: [f64; 3],
    /// `Σ d dᵀ` of the positions from the mean.
    spread: [[f64; 3]; 3],
}

/// The source points in cells, and the clusters of each part of the targets.
#[derive(Clone, Debug)]
pub(super) struct RadialBasis {
    points_per_cluster: usize,
    grid: CellGrid,
    distances: Vec<f64>,
    samples: Vec<f64>,
    parts: Parts<Clusters>,
}

impl RadialBasis {
    /// With about so many points in a cluster.
    pub fn new(points_per_cluster: usize) -> Self {
        Self {
            points_per_cluster,
            grid: CellGrid::default(),
            distances: Vec::new(),
            samples: Vec::new(),
            parts: Parts::default(),
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
        let count = (*points_per_cluster).max(D + 1);
        let radius = typical_distance(grid, source, count, distances, samples);
        // A single source point has no spacing.
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let sources = Sources { grid, positions: source, radius };
        parts.gather(target.len(), threads, rows, |part, clusters, rows| {
            clusters.fill(sources, target, part, reach, rows)
        })
    }
}

/// Where clusters take their points from.
#[derive(Clone, Copy)]
struct Sources<'a, const D: usize> {
    grid: &'a CellGrid,
    positions: &'a [[f64; D]],
    /// Of a cluster (m).
    radius: f64,
}

/// The clusters that targets asked for, and scratch.
#[derive(Clone, Debug, Default)]
struct Clusters {
    /// Cluster of a lattice node. Looked up only: its order has no say.
    cluster_of: HashMap<[i64; 3], usize>,
    clusters: Vec<Cluster>,
    /// Source points of all clusters, cluster by cluster.
    points: Vec<usize>,
    /// Of each cluster an array of positions from its mean for each coordinate, one of ones, and a row a point of the inverse matrix.
    data: Vec<f64>,
    /// Values of the functions at a target.
    values: Vec<f64>,
    weights: Vec<f64>,
    /// `(cluster, φ, first of its weights)` of the target at hand.
    shares: Vec<(usize, f64, usize)>,
}

impl Clusters {
    fn fill<const D: usize>(
        &mut self,
        sources: Sources<D>,
        target: &[[f64; D]],
        part: Range<usize>,
        reach: f64,
        rows: &mut Rows,
    ) -> Result<(), MappingError> {
        self.cluster_of.clear();
        self.clusters.clear();
        self.points.clear();
        self.data.clear();
        let grid = sources.grid;
        for point in part {
            let x = &target[point];
            grid.nearest(x, reach).ok_or_else(|| out_of_reach(grid, point, x, reach))?;
            let looked_at = self.share(sources, x)?;
            if self.shares.is_empty() {
                return Err(MappingError::Degenerate { point, position: x.to_vec(), sources: looked_at });
            }
            let total: f64 = self.shares.iter().map(|&(_, phi, _)| phi).sum();
            for &(cluster, phi, first) in &self.shares {
                for (k, &column) in self.points[self.clusters[cluster].points.clone()].iter().enumerate() {
                    rows.add(column, phi / total * self.weights[first + k]);
                }
            }
            rows.end_row();
        }
        Ok(())
    }

    /// Gathers the shares of the clusters around `x` that determine a linear field there; returns how many points the fullest has.
    fn share<const D: usize>(&mut self, sources: Sources<D>, x: &[f64; D]) -> Result<usize, MappingError> {
        let radius = sources.radius;
        self.shares.clear();
        self.weights.clear();
        let mut looked_at = 0;
        let (mut low, mut high) = ([0; 3], [0; 3]);
        for i in 0..D {
            low[i] = (x[i] / radius - 1.0).ceil() as i64;
            high[i] = (x[i] / radius + 1.0).floor() as i64;
        }
        for k in low[2]..=high[2] {
            for j in low[1]..=high[1] {
                for i in low[0]..=high[0] {
                    let node = [i, j, k];
                    let center: [f64; D] = std::array::from_fn(|c| node[c] as f64 * radius);
                    let phi = wendland_c2(distance_squared(x, &center).sqrt() / radius);
                    if phi == 0.0 {
                        continue;
                    }
                    let cluster = self.cluster(sources, node, center)?;
                    looked_at = looked_at.max(self.clusters[cluster].points.len());
                    let first = self.weights.len();
                    if self.weigh(cluster, x, radius) {
                        self.shares.push((cluster, phi, first));
                    } else {
                        self.weights.truncate(first);
                    }
                }
            }
        }
        Ok(looked_at)
    }

    /// The cluster of a lattice node, made when first asked for.
    fn cluster<const D: usize>(
        &mut self,
        sources: Sources<D>,
        node: [i64; 3],
        center: [f64; D],
    ) -> Result<usize, MappingError> {
        let Sources { grid, positions: source, radius } = sources;
        if let Some(&cluster) = self.cluster_of.get(&node) {
            return Ok(cluster);
        }
        let first = self.points.len();
        let points = &mut self.points;
        grid.visit_around(&center, radius, |point, x| {
            if distance_squared(x, &center) < radius * radius {
                points.push(point);
            }
        });
        points[first..].sort_unstable();
        let members = &points[first..];
        let (mean, spread) = moments(source, members);
        let (count, stride) = (members.len(), members.len().next_multiple_of(LANES));
        let data = self.data.len();
        self.data.resize(data + (D + 1 + count) * stride, 0.0);
        let (places, rest) = self.data[data..].split_at_mut(D * stride);
        let (ones, matrix) = rest.split_at_mut(stride);
        for (i, &a) in members.iter().enumerate() {
            ones[i] = 1.0;
            for c in 0..D {
                places[c * stride + i] = source[a][c] - mean[c];
            }
            for (j, &b) in members[..=i].iter().enumerate() {
                let phi = wendland_c2(distance_squared(&source[a], &source[b]).sqrt() / (SUPPORT * radius));
                (matrix[i * stride + j], matrix[j * stride + i]) = (phi, phi);
            }
        }
        if let Err(row) = invert(matrix, count, stride) {
            let apart = |&&other: &&usize| distance_squared(&source[other], &source[members[row]]);
            let nearest = members[..row].iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
            let first = *nearest.expect("the first pivot is φ(0) = 1");
            return Err(MappingError::Coincident { first, second: members[row] });
        }
        self.clusters.push(Cluster { points: first..self.points.len(), stride, data, mean, spread });
        self.cluster_of.insert(node, self.clusters.len() - 1);
        Ok(self.clusters.len() - 1)
    }

    /// Appends the weights of a cluster for the target; false if they do not reproduce linear fields, or amplify errors.
    fn weigh<const D: usize>(&mut self, cluster: usize, x: &[f64; D], radius: f64) -> bool {
        let Cluster { points, stride, data, mean, spread } = &self.clusters[cluster];
        let (count, stride) = (points.len(), *stride);
        if count <= D {
            return false;
        }
        let (places, rest) = self.data[*data..].split_at(D * stride);
        let basis = Basis {
            places: std::array::from_fn(|c| &places[c * stride..(c + 1) * stride]),
            points: &rest[..stride],
            count,
            inverse: &rest[stride..(1 + count) * stride],
            spread: std::array::from_fn(|i| std::array::from_fn(|j| spread[i][j])),
            support: SUPPORT * radius,
        };
        let first = self.weights.len();
        self.weights.resize(first + stride, 0.0);
        self.values.resize(stride, 0.0);
        let from_mean = minus(x, &std::array::from_fn(|c| mean[c]));
        let quality = basis.weigh(&from_mean, &mut self.values, &mut self.weights[first..]);
        let Quality { one, linear, amplification } = quality;
        one.abs() <= INCONSISTENCY
            && dot(&linear, &linear).sqrt() <= INCONSISTENCY * radius
            && amplification <= AMPLIFICATION
    }
}

/// Mean position and `Σ d dᵀ` about it.
fn moments<const D: usize>(source: &[[f64; D]], members: &[usize]) -> ([f64; 3], [[f64; 3]; 3]) {
    let (mut mean, mut spread) = ([0.0; 3], [[0.0; 3]; 3]);
    for &i in members {
        for c in 0..D {
            mean[c] += source[i][c] / members.len() as f64;
        }
    }
    for &i in members {
        for c in 0..D {
            for e in 0..D {
                spread[c][e] += (source[i][c] - mean[c]) * (source[i][e] - mean[e]);
            }
        }
    }
    (mean, spread)
}
