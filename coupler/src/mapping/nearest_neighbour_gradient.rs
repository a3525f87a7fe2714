//! Nearest neighbour with gradient: the value of the nearest source point, continued with the gradient that
//! its neighbours give.
//!
//! With the nearest source point `x₀`, its neighbours `xᵢ` within a radius `ρ`, `dᵢ = xᵢ − x₀` and
//! `θᵢ = (1 − |dᵢ|²/ρ²)²`, the gradient by weighted least squares gives for a target `x`
//!
//! ```text
//! u(x) = u₀ + Σ wᵢ (uᵢ − u₀),   wᵢ = θᵢ dᵢ · M⁻¹ (x − x₀),   M = Σ θᵢ dᵢ dᵢᵀ
//! ```
//!
//! so that `Σ w = 1` and `Σ w xᵢ = x`: linear fields are exact, rigid motion among them, and a target on a
//! source point takes its value. The weights are those of the smallest `Σ wᵢ²/θᵢ` that do this. The error
//! falls with the square of the distance between source points; where the nearest source point changes, the
//! mapped field jumps by that error.
//!
//! The radius is that within which a source point has [`NEIGHBOURS`] others, by the median over some. It
//! grows for a target whose neighbours do not reach it (all on one face of a thin plate), or only with
//! weights that would amplify errors by more than [`AMPLIFICATION`].

use super::cell_grid::{CellGrid, distance_squared};
use super::error::MappingError;
use super::nearest_neighbour::{POINTS_PER_CELL, out_of_reach};
use super::parts::Parts;
use super::rows::Rows;
use super::semidefinite::{dot, minus, solve};
use std::ops::Range;

/// Neighbours within the radius, in two and three dimensions: on a lattice the diagonal ones are the last.
const NEIGHBOURS: [usize; 2] = [6, 10];
/// Radius over the distance of the last of them, so that it has a weight.
const MARGIN: f64 = 1.05;
/// Source points over which the radius is taken.
const SAMPLES: usize = 33;
/// Largest `Σ |w|`: an error in each source value of `ε` is one of at most `ε Σ |w|` in the mapped value.
/// Between lattice points it is under 3.
const AMPLIFICATION: f64 = 16.0;
/// Growth of the radius where neighbours do not do, and how often: 1.5¹² ≈ 130.
const GROWTH: f64 = 1.5;
const GROWTHS: usize = 12;
/// Largest `|x − Σ w xᵢ|` over the radius: rounding of sums of some dozen terms, of at most a radius times
/// [`AMPLIFICATION`].
const INCONSISTENCY: f64 = 1e-13;

/// A source point near the nearest one.
#[derive(Clone, Copy, Debug)]
struct Neighbour<const D: usize> {
    point: usize,
    offset: [f64; D],
    theta: f64,
    weight: f64,
}

/// The scratch of the method.
#[derive(Clone, Debug, Default)]
pub(super) struct NearestNeighbourGradient {
    grid: CellGrid,
    distances: Vec<f64>,
    samples: Vec<f64>,
    parts: Parts<()>,
}

impl NearestNeighbourGradient {
    /// Gathers a row for each target. There is a source point, and all points are finite.
    pub fn fill<const D: usize>(
        &mut self,
        source: &[[f64; D]],
        target: &[[f64; D]],
        reach: f64,
        threads: usize,
        rows: &mut Rows,
    ) -> Result<(), MappingError> {
        self.grid.rebuild(source, POINTS_PER_CELL);
        let radius = MARGIN
            * typical_distance(&self.grid, source, NEIGHBOURS[D - 2], &mut self.distances, &mut self.samples);
        let mut parts = std::mem::take(&mut self.parts);
        let gathered = parts.gather(target.len(), threads, rows, |part, (), rows| {
            self.fill_part(source, target, part, reach, radius, rows)
        });
        self.parts = parts;
        gathered
    }

    fn fill_part<const D: usize>(
        &self,
        source: &[[f64; D]],
        target: &[[f64; D]],
        part: Range<usize>,
        reach: f64,
        radius: f64,
        rows: &mut Rows,
    ) -> Result<(), MappingError> {
        let mut neighbours = Vec::with_capacity(128);
        for point in part {
            let x = &target[point];
            let (nearest, _) =
                self.grid.nearest(x, reach).ok_or_else(|| out_of_reach(&self.grid, point, x, reach))?;
            let offset = minus(x, &source[nearest]);
            rows.add(nearest, 1.0);
            if offset != [0.0; D] {
                self.add_gradient(source, nearest, offset, radius, &mut neighbours, rows)
                    .map_err(|sources| MappingError::Degenerate { point, position: x.to_vec(), sources })?;
            }
            rows.end_row();
        }
        Ok(())
    }

    /// Adds `Σ wᵢ (uᵢ − u₀)` to the row; else the number of sources that did not do.
    fn add_gradient<const D: usize>(
        &self,
        source: &[[f64; D]],
        nearest: usize,
        offset: [f64; D],
        radius: f64,
        neighbours: &mut Vec<Neighbour<D>>,
        rows: &mut Rows,
    ) -> Result<(), usize> {
        let mut radius = radius;
        for _ in 0..=GROWTHS {
            gather(&self.grid, &source[nearest], radius, neighbours);
            if weigh(neighbours, &offset, radius) {
                let mut sum = 0.0;
                for n in neighbours.iter() {
                    rows.add(n.point, n.weight);
                    sum += n.weight;
                }
                rows.add(nearest, -sum);
                return Ok(());
            }
            if neighbours.len() == source.len() {
                break;
            }
            radius *= GROWTH;
        }
        Err(neighbours.len())
    }
}

/// The sources within `radius` of `center`; itself among them, with offset zero.
fn gather<const D: usize>(
    grid: &CellGrid,
    center: &[f64; D],
    radius: f64,
    neighbours: &mut Vec<Neighbour<D>>,
) {
    let inverse = 1.0 / (radius * radius);
    neighbours.clear();
    grid.visit_around(center, radius, |point, x| {
        let offset = minus(x, center);
        let q = 1.0 - dot(&offset, &offset) * inverse;
        if q > 0.0 {
            neighbours.push(Neighbour { point, offset, theta: q * q, weight: 0.0 });
        }
    });
}

/// Weights `wᵢ`; false if they do not reproduce `x` to round-off, or amplify.
fn weigh<const D: usize>(neighbours: &mut [Neighbour<D>], offset: &[f64; D], radius: f64) -> bool {
    let mut m = [[0.0; D]; D];
    for n in &*neighbours {
        for i in 0..D {
            for j in 0..=i {
                m[i][j] += n.theta * n.offset[i] * n.offset[j];
            }
        }
    }
    for i in 0..D {
        for j in 0..i {
            m[j][i] = m[i][j];
        }
    }
    let mut gradient = solve(m, *offset);
    // The second time for neighbours that are nearly in a line, where the first is inexact.
    for _ in 0..2 {
        let mut missing = *offset;
        let (mut sum, mut sum_of_absolutes) = (0.0, 0.0);
        for n in &mut *neighbours {
            n.weight = n.theta * dot(&n.offset, &gradient);
            sum += n.weight;
            sum_of_absolutes += n.weight.abs();
            for i in 0..D {
                missing[i] -= n.weight * n.offset[i];
            }
        }
        sum_of_absolutes += (1.0 - sum).abs();
        // Written so that not a number is not good enough.
        let fits = dot(&missing, &missing).sqrt() <= INCONSISTENCY * radius;
        if fits {
            return sum_of_absolutes <= AMPLIFICATION;
        }
        let refined = solve(m, missing);
        for i in 0..D {
            gradient[i] += refined[i];
        }
    }
    false
}

/// Median over some sources of the distance (m) to their `count`-th nearest other (or the last there is).
pub(super) fn typical_distance<const D: usize>(
    grid: &CellGrid,
    source: &[[f64; D]],
    count: usize,
    distances: &mut Vec<f64>,
    samples: &mut Vec<f64>,
) -> f64 {
    let count = count.min(source.len() - 1);
    samples.clear();
    for sample in 0..SAMPLES.min(source.len()) {
        let center = &source[sample * source.len() / SAMPLES.min(source.len())];
        let mut radius = grid.cell_size();
        loop {
            distances.clear();
            grid.visit_around(center, radius, |_, x| {
                let squared = distance_squared(x, center);
                if squared <= radius * radius {
                    distances.push(squared);
                }
            });
            if distances.len() > count {
                break;
            }
            // Bounded: the ball grows until it holds all sources, which are more than `count`.
            radius *= GROWTH;
        }
        let (_, squared, _) = distances.select_nth_unstable_by(count, f64::total_cmp);
        samples.push(squared.sqrt());
    }
    let middle = samples.len() / 2;
    *samples.select_nth_unstable_by(middle, f64::total_cmp).1
}
