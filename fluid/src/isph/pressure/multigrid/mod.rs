//! Algebraic multigrid: a preconditioner for the pressure Poisson equation.
//!
//! The matrix is a compact Laplacian, symmetric, with a positive diagonal and couplings that are mostly
//! negative. Unknowns are grouped into aggregates about three particles wide, level by level, until a dense
//! factorisation is cheap; a coarse matrix is the sum of its members' entries (plain aggregation, a Galerkin
//! product with piecewise constant interpolation). The cycle has one damped Jacobi step before and one after
//! the coarse correction, visits each coarse level twice (a W-cycle) and stretches the correction, because
//! piecewise constant functions are too stiff (Braess 1995).
//!
//! | symbol | meaning |
//! |---|---|
//! | `A` | the matrix of a level |
//! | `P` | interpolation from the next coarser level, one on each aggregate |
//! | `S` | the smoother's steps, a diagonal matrix |
//! | `ω` | stretch of the coarse correction, 1.8 |
//!
//! The preconditioner `B` is linear, symmetric and positive definite, so that plain conjugate gradients
//! serve. The Jacobi step contracts in the norm of `A`. Two cycles on a coarse level make
//! `C = 2B_c − B_c A_c B_c`, whose product with `A_c` has its eigenvalues `1 − (1 − λ)²` in (0, 1] as long as
//! those `λ` of `B_c A_c` lie in (0, 2); stretched by `ω < 2`, the correction leaves those of `BA` in (0, 2)
//! again, from the coarsest level up.
//!
//! Every sum is gathered in a fixed order, so results do not depend on the number of threads to the bit.

mod aggregation;
mod coarsest;
mod matrix;

use aggregation::Aggregates;
use coarsest::Cholesky;
pub use matrix::OpenRow;
use matrix::{RowChunk, SCALED, SUMMED, SymmetricRows, for_rows};

/// The factor `ω` on coarse corrections. Below two, see the [module](self).
const STRETCH: f64 = 1.8;

/// Most unknowns that are solved for directly; more would cost more than another level.
const DIRECT: usize = 100;

/// What the preconditioner is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Adds this many damped Jacobi steps' worth of the residual to the correction: for an operator that
    /// agrees with the matrix on long waves but is weaker on short ones. Not negative.
    pub short_wave_gain: f64,
}

impl Options {
    /// For systems whose operator is the matrix itself.
    pub const SAME_OPERATOR: Self = Self { short_wave_gain: 0.0 };

    /// For the wide operator `D M⁻¹ Dᵀ + 0.1 L` preconditioned through the compact Laplacian `L` **and its
    /// reaction**, which the caller adds to `L`: the diagonal `|Σ_j V w_ij ∇W_ij|²/ρ`, the square of the
    /// force of a constant pressure. That sum is over fluid and walls alike, so that it is small wherever a
    /// particle is surrounded, beside a wall too; with `|own|²` instead, which is large along walls, a solve
    /// to 1e-3 took 13 iterations instead of 7 (collapsing column of 50,000 particles).
    pub const WIDE_OPERATOR: Self = Self { short_wave_gain: 1.5 };
}

/// One level: its matrix, its aggregates (none on the coarsest) and the vectors the cycle works with.
#[derive(Clone, Debug, Default)]
struct Level {
    matrix: SymmetricRows,
    aggregates: Aggregates,
    right: Vec<f64>,
    correction: Vec<f64>,
    smoothed: Vec<f64>,
}

/// The hierarchy of matrices, see the [module](self).
#[derive(Clone, Debug)]
pub struct Multigrid {
    options: Options,
    /// More than `depth` where an earlier matrix needed more.
    levels: Vec<Level>,
    depth: usize,
    coarsest: Cholesky,
    chunks: Vec<RowChunk>,
}

impl Multigrid {
    /// A preconditioner without a matrix yet: the first call is [`rebuild`](Self::rebuild).
    pub fn new(options: Options) -> Self {
        assert!(options.short_wave_gain >= 0.0, "a negative gain is not positive definite");
        Self { options, levels: Vec::new(), depth: 0, coarsest: Cholesky::default(), chunks: Vec::new() }
    }

    /// Sets up the hierarchy of a symmetric matrix in compressed rows: `offsets` holds one entry more than
    /// rows, and `columns` and `values` (any unit) the entries row after row, each column once, in any order,
    /// the diagonal among them. Rows without couplings (unit rows of Dirichlet particles) are allowed and
    /// solved exactly.
    pub fn rebuild(&mut self, offsets: &[u32], columns: &[u32], values: &[f64]) {
        self.rebuild_rows(offsets, compressed(offsets, columns, values));
    }

    /// [`rebuild`](Self::rebuild) from rows made one at a time: `fill(i, row)` pushes the couplings of row
    /// `i`, in a fixed order and each column once, and returns its diagonal; `slots` (row starts, one more
    /// than rows) says how many couplings a row has at most.
    pub fn rebuild_rows(&mut self, slots: &[u32], fill: impl Fn(usize, &mut OpenRow) -> f64 + Sync) {
        self.set_up(slots, fill, false);
    }

    /// [`rebuild`](Self::rebuild) that keeps the aggregates where the number of rows is that of the last
    /// matrix. Any matrix is right, but aggregates suit one whose couplings have not changed much; rebuild
    /// when iterations grow.
    pub fn update(&mut self, offsets: &[u32], columns: &[u32], values: &[f64]) {
        self.set_up(offsets, compressed(offsets, columns, values), true);
    }

    /// Rows and matrix entries of each level, finest first.
    pub fn level_sizes(&self) -> impl Iterator<Item = (usize, usize)> {
        self.levels[..self.depth].iter().map(|level| (level.matrix.len(), level.matrix.entries()))
    }

    fn set_up(
        &mut self,
        slots: &[u32],
        fill: impl Fn(usize, &mut OpenRow) -> f64 + Sync,
        keep_aggregates: bool,
    ) {
        if self.levels.is_empty() {
            self.levels.push(Level::default());
        }
        let rows = slots.len().saturating_sub(1);
        let keep_aggregates = keep_aggregates && self.depth > 0 && self.levels[0].matrix.len() == rows;
        self.levels[0].matrix.make_in_slots(slots, fill);
        self.depth = 1;
        loop {
            let (finer, coarser) = self.levels.split_at_mut(self.depth);
            let level = finer.last_mut().expect("there is a finest level");
            let rows = level.matrix.len();
            // The finest level's right-hand side and correction are the caller's.
            if self.depth > 1 {
                level.right.resize(rows, 0.0);
                level.correction.resize(rows, 0.0);
            }
            level.smoothed.resize(rows, 0.0);
            if rows <= DIRECT {
                self.coarsest.factorise(&level.matrix);
                return;
            }
            if !keep_aggregates || level.aggregates.unknowns() != rows {
                level.aggregates.choose(&level.matrix);
            }
            // None where nothing is coupled; as many as rows only where couplings are not finite.
            if level.aggregates.len() == 0 || level.aggregates.len() == rows {
                return;
            }
            if coarser.is_empty() {
                self.levels.push(Level::default());
            }
            let (finer, coarser) = self.levels.split_at_mut(self.depth);
            let level = &finer[self.depth - 1];
            level.aggregates.coarsen(&level.matrix, &mut self.chunks, &mut coarser[0].matrix);
            self.depth += 1;
        }
    }

    /// `correction = B residual`, an approximation of `A⁻¹ residual`. Allocates nothing.
    pub fn apply(&mut self, residual: &[f64], correction: &mut [f64]) {
        assert!(self.depth > 0, "a hierarchy is built before it is applied");
        let rows = self.levels[0].matrix.len();
        assert!(
            residual.len() == rows && correction.len() == rows,
            "vectors are as long as the matrix has rows"
        );
        let gain = self.options.short_wave_gain;
        cycle(&mut self.levels[..self.depth], &self.coarsest, residual, correction, Start::Zero, gain);
    }
}

/// Rows of the caller's matrix.
fn compressed<'a>(
    offsets: &'a [u32],
    columns: &'a [u32],
    values: &'a [f64],
) -> impl Fn(usize, &mut OpenRow) -> f64 + Sync + 'a {
    assert_eq!(columns.len(), values.len(), "one value for every column");
    |i, row| {
        let mut diagonal = 0.0;
        for e in offsets[i] as usize..offsets[i + 1] as usize {
            if columns[e] as usize == i {
                diagonal += values[e];
            } else {
                row.push(columns[e], values[e]);
            }
        }
        diagonal
    }
}

/// What a cycle starts from.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Start {
    Zero,
    Improving,
}

/// One cycle for `A x = right` on the finest of `levels`, from zero or improving `x`; at the end `gain`
/// Jacobi steps' worth of `right` is added.
fn cycle(levels: &mut [Level], coarsest: &Cholesky, right: &[f64], x: &mut [f64], start: Start, gain: f64) {
    let (level, coarser) = levels.split_first_mut().expect("a cycle has a level to work on");
    let Level { matrix, aggregates, smoothed, .. } = level;
    if coarser.is_empty() && matrix.len() <= DIRECT {
        x.copy_from_slice(right);
        coarsest.solve(x);
        for_rows(SCALED, x, |i, v| *v += gain * f64::from(matrix.rows[i].step) * right[i]);
        return;
    }
    if start == Start::Zero {
        for_rows(SCALED, smoothed, |i, v| *v = f64::from(matrix.rows[i].step) * right[i]);
    } else {
        let x = &*x;
        for_rows(SUMMED, smoothed, |i, v| {
            *v = x[i] + f64::from(matrix.rows[i].step) * matrix.residual(i, right, x);
        });
    }
    if let [next, ..] = coarser {
        let (mut coarse_right, mut coarse) =
            (std::mem::take(&mut next.right), std::mem::take(&mut next.correction));
        let fine = &*smoothed;
        for_rows(SUMMED / 8, &mut coarse_right, |c, sum| {
            *sum = aggregates.members(c).iter().map(|&i| matrix.residual(i as usize, right, fine)).sum();
        });
        cycle(coarser, coarsest, &coarse_right, &mut coarse, Start::Zero, 0.0);
        if coarser.len() > 1 {
            cycle(coarser, coarsest, &coarse_right, &mut coarse, Start::Improving, 0.0);
        }
        for_rows(SCALED, smoothed, |i, v| *v += STRETCH * aggregates.interpolate(i, &coarse));
        (coarser[0].right, coarser[0].correction) = (coarse_right, coarse);
    }
    let smoothed = &*smoothed;
    for_rows(SUMMED, x, |i, v| {
        let step = f64::from(matrix.rows[i].step);
        *v = smoothed[i] + step * (matrix.residual(i, right, smoothed) + gain * right[i]);
    });
}
