//! The renormalisation tensor of second derivatives, Eqs. (6)–(7) (Fatehi and Manzari 2012).

use nalgebra::{SMatrix, SVector};
use sph::{Matrix, Vector};

/// Independent entries of a symmetric tensor in three dimensions.
const ENTRIES: usize = 6;

/// The symmetric `B̂` for which `B̂ : Σ 2V e ∇W ((f_a − f_b)/|r| − e·⟨∇f⟩_a)` is exactly `∇²f` for quadratic
/// `f`.
///
/// From the Taylor series: `B̂ : [Σ r e e e ∇W + (Σ e e ∇W)·(Σ r r B∇W)] = −I` (V in every sum). The paper's
/// Eqs. (6)–(7) have `B̂` on both sides, which cannot be. `gradients` gives `(r_ab, V_b ∇W_ab)` of every
/// neighbour, `b` is the tensor of Eq. (5). Nothing where neighbours are too few for a solution.
pub fn second_derivative_correction<const D: usize>(
    gradients: &(impl Iterator<Item = (Vector<D>, Vector<D>)> + Clone),
    b: &Matrix<D>,
) -> Option<Matrix<D>> {
    let entries: Vec<(usize, usize)> = (0..D).flat_map(|i| (i..D).map(move |j| (i, j))).collect();
    // second[k][mn] = Σ V r_m r_n (B∇W)_k
    let mut second = [[0.0; ENTRIES]; 3];
    for (r, g) in gradients.clone() {
        let corrected = b * g;
        for (k, row) in second.iter_mut().enumerate().take(D) {
            for (value, &(m, n)) in row.iter_mut().zip(&entries) {
                *value += r[m] * r[n] * corrected[k];
            }
        }
    }
    let mut system = SMatrix::<f64, ENTRIES, ENTRIES>::identity();
    let mut right = SVector::<f64, ENTRIES>::zeros();
    for (row, &(m, n)) in entries.iter().enumerate() {
        right[row] = if m == n { -1.0 } else { 0.0 };
        for (column, &(p, q)) in entries.iter().enumerate() {
            let mut sum = 0.0;
            for (r, g) in gradients.clone() {
                let distance = r.norm();
                let e = r / distance;
                let bracket = distance * e[m] * e[n] + (0..D).map(|k| e[k] * second[k][row]).sum::<f64>();
                sum += bracket * e[p] * g[q];
                if p != q {
                    sum += bracket * e[q] * g[p];
                }
            }
            system[(row, column)] = sum;
        }
    }
    let solution = system.lu().solve(&right)?;
    let mut b_hat = Matrix::<D>::zeros();
    for (&(p, q), &value) in entries.iter().zip(solution.iter()) {
        (b_hat[(p, q)], b_hat[(q, p)]) = (value, value);
    }
    b_hat.iter().all(|x| x.abs() < 10.0).then_some(b_hat)
}
