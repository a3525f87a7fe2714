//! The direct solve on the coarsest level.

use super::matrix::{Entry, SymmetricRows};

/// A pivot below this fraction of its diagonal is rounding: sums of a few thousand terms leave about 1e-13.
const VANISHING: f64 = 1e-13;

/// A dense Cholesky factorisation `A = L Lᵀ`.
#[derive(Clone, Debug, Default)]
pub(super) struct Cholesky {
    size: usize,
    /// `L` row-major, `size · size`, with the inverse of its diagonal in place of the diagonal.
    factor: Vec<f64>,
}

impl Cholesky {
    /// Factorises `matrix`. An unknown whose pivot vanishes (the constant of a singular component) is held at
    /// zero.
    pub fn factorise(&mut self, matrix: &SymmetricRows) {
        let n = matrix.len();
        self.size = n;
        self.factor.clear();
        self.factor.resize(n * n, 0.0);
        for i in 0..n {
            for &Entry { column, coupling } in matrix.row(i) {
                self.factor[i * n + column as usize] = f64::from(coupling);
            }
            self.factor[i * n + i] = matrix.rows[i].diagonal;
        }
        for i in 0..n {
            let (above, rest) = self.factor.split_at_mut(i * n);
            let row = &mut rest[..n];
            for j in 0..i {
                let other = &above[j * n..=j * n + j];
                let dot: f64 = row[..j].iter().zip(other).map(|(a, b)| a * b).sum();
                row[j] = (row[j] - dot) * other[j];
            }
            let diagonal = row[i];
            let pivot = diagonal - row[..i].iter().map(|a| a * a).sum::<f64>();
            row[i] = if pivot > VANISHING * diagonal { 1.0 / pivot.sqrt() } else { 0.0 };
        }
    }

    /// Replaces the right-hand side `x` by the solution.
    pub fn solve(&self, x: &mut [f64]) {
        let n = self.size;
        for i in 0..n {
            let row = &self.factor[i * n..=i * n + i];
            let dot: f64 = row.iter().zip(&x[..i]).map(|(a, b)| a * b).sum();
            x[i] = (x[i] - dot) * row[i];
        }
        for i in (0..n).rev() {
            let row = &self.factor[i * n..=i * n + i];
            let (solved, value) = (&mut x[..=i], row[i]);
            solved[i] *= value;
            let value = solved[i];
            for (b, a) in solved[..i].iter_mut().zip(row) {
                *b -= a * value;
            }
        }
    }
}
