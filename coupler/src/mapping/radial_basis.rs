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
//! Smooth (but where a cluster is left out for a target that it does not determine) and the most accurate of the methods, at a
//! factorisation for each cluster when points move.

use super::cell_grid::{CellGrid, distance_squared};
use super::error::MappingError;
use super::nearest_neighbour::{POINTS_PER_CELL, out_of_reach};
use super::nearest_neighbour_gradient::typical_distance;
use super::parts::Parts;
use super::rows::Rows;
use super::semidefinite::{dot, minus, solve};
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

/// Source points of a ball with their factorised matrix.
#[derive(Clone, Debug)]
struct Cluster {
    points: Range<usize>,
    factor: Range<usize>,
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
    /// Cholesky factors of all clusters, lower triangles row by row.
    factors: Vec<f64>,
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
        self.factors.clear();
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
        let Sources { positions: source, radius, .. } = sources;
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
                    if self.weigh(source, cluster, x, radius) {
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
        let first_factor = self.factors.len();
        for (i, &a) in members.iter().enumerate() {
            for &b in &members[..=i] {
                self.factors
                    .push(wendland_c2(distance_squared(&source[a], &source[b]).sqrt() / (SUPPORT * radius)));
            }
        }
        if let Err(row) = factorise(&mut self.factors[first_factor..], members.len()) {
            let apart = |&&other: &&usize| distance_squared(&source[other], &source[members[row]]);
            let nearest = members[..row].iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
            let first = *nearest.expect("the first pivot is φ(0) = 1");
            return Err(MappingError::Coincident { first, second: members[row] });
        }
        self.clusters.push(Cluster {
            points: first..self.points.len(),
            factor: first_factor..self.factors.len(),
            mean,
            spread,
        });
        self.cluster_of.insert(node, self.clusters.len() - 1);
        Ok(self.clusters.len() - 1)
    }

    /// Appends the weights of a cluster for the target; false if they do not reproduce linear fields, or amplify errors.
    fn weigh<const D: usize>(
        &mut self,
        source: &[[f64; D]],
        cluster: usize,
        x: &[f64; D],
        radius: f64,
    ) -> bool {
        let cluster = &self.clusters[cluster];
        let members = &self.points[cluster.points.clone()];
        if members.len() <= D {
            return false;
        }
        let first = self.weights.len();
        self.weights.extend(
            members.iter().map(|&i| wendland_c2(distance_squared(x, &source[i]).sqrt() / (SUPPORT * radius))),
        );
        let weights = &mut self.weights[first..];
        substitute(&self.factors[cluster.factor.clone()], weights);
        let mean: [f64; D] = std::array::from_fn(|i| cluster.mean[i]);
        let spread: [[f64; D]; D] = std::array::from_fn(|i| std::array::from_fn(|j| cluster.spread[i][j]));
        // Once for the polynomial, once more for the rounding of the first.
        for _ in 0..2 {
            let (one, linear) = missing(source, members, weights, &mean, x);
            let gradient = solve(spread, linear);
            for (w, &i) in weights.iter_mut().zip(members) {
                *w += one / members.len() as f64 + dot(&minus(&source[i], &mean), &gradient);
            }
        }
        let (one, linear) = missing(source, members, weights, &mean, x);
        let amplification: f64 = weights.iter().map(|w| w.abs()).sum();
        one.abs() <= INCONSISTENCY
            && dot(&linear, &linear).sqrt() <= INCONSISTENCY * radius
            && amplification <= AMPLIFICATION
    }
}

/// Wendland's C² function, positive definite in up to three dimensions.
fn wendland_c2(q: f64) -> f64 {
    if q < 1.0 { (1.0 - q).powi(4) * (4.0 * q + 1.0) } else { 0.0 }
}

/// `1 − Σ w` and `x − x̄ − Σ w (xᵢ − x̄)`.
fn missing<const D: usize>(
    source: &[[f64; D]],
    members: &[usize],
    weights: &[f64],
    mean: &[f64; D],
    x: &[f64; D],
) -> (f64, [f64; D]) {
    let (mut one, mut linear) = (1.0, minus(x, mean));
    for (w, &i) in weights.iter().zip(members) {
        one -= w;
        for c in 0..D {
            linear[c] -= w * (source[i][c] - mean[c]);
        }
    }
    (one, linear)
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

/// Cholesky's `A = L Lᵀ` in place, lower triangle row by row; else the row whose pivot is lost in rounding.
fn factorise(a: &mut [f64], count: usize) -> Result<(), usize> {
    /// Rounding errors of a pivot, of a matrix with ones on its diagonal.
    const LOST: f64 = 1e-13;
    for i in 0..count {
        let (above, row) = a.split_at_mut(i * (i + 1) / 2);
        let row = &mut row[..=i];
        for j in 0..i {
            let other = &above[j * (j + 1) / 2..][..=j];
            let sum: f64 = row[..j].iter().zip(other).map(|(x, y)| x * y).sum();
            row[j] = (row[j] - sum) / other[j];
        }
        let pivot = row[i] - row[..i].iter().map(|x| x * x).sum::<f64>();
        if pivot <= LOST {
            return Err(i);
        }
        row[i] = pivot.sqrt();
    }
    Ok(())
}

/// Solves `L Lᵀ w = b` in place.
fn substitute(l: &[f64], b: &mut [f64]) {
    for i in 0..b.len() {
        let row = &l[i * (i + 1) / 2..][..=i];
        let sum: f64 = row[..i].iter().zip(&*b).map(|(x, y)| x * y).sum();
        b[i] = (b[i] - sum) / row[i];
    }
    for i in (0..b.len()).rev() {
        let row = &l[i * (i + 1) / 2..][..=i];
        b[i] /= row[i];
        let value = b[i];
        for (x, y) in b[..i].iter_mut().zip(row) {
            *x -= y * value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_and_solves_by_hand() {
        // [[4, 2], [2, 10]] = L Lᵀ with L = [[2, 0], [1, 3]].
        let mut a = [4.0, 2.0, 10.0];
        assert_eq!(factorise(&mut a, 2), Ok(()));
        assert_eq!(a, [2.0, 1.0, 3.0]);
        let mut b = [8.0, 22.0];
        substitute(&a, &mut b);
        assert_eq!(b, [1.0, 2.0]);
        assert_eq!(factorise(&mut [1.0, 1.0, 1.0], 2), Err(1));
    }

    #[test]
    fn wendlands_function_by_hand() {
        assert_eq!(wendland_c2(0.0), 1.0);
        assert_eq!(wendland_c2(0.5), 3.0 / 16.0);
        assert_eq!(wendland_c2(1.0), 0.0);
    }
}
