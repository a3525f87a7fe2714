//! Iterates in blocks of one quantity each, which differ by many orders of magnitude.

use crate::flat::dot;
use std::ops::Range;

/// `x ← x + ω r`.
pub(super) fn relax(omega: f64, x: &mut [f64], r: &[f64]) {
    for (x, r) in x.iter_mut().zip(r) {
        *x += omega * r;
    }
}

/// `Σ_b a_b·b_b / size_b²` over the blocks.
pub(super) fn weighed(blocks: &[Range<usize>], sizes: &[f64], a: &[f64], b: &[f64]) -> f64 {
    blocks
        .iter()
        .zip(sizes)
        .map(|(block, size)| dot(&a[block.clone()], &b[block.clone()]) / (size * size))
        .sum()
}

/// The size of each block of `y`, by which it is weighed; one where there is nothing.
pub(super) fn sizes(blocks: &[Range<usize>], y: &[f64]) -> Vec<f64> {
    let size = |block: &Range<usize>| dot(&y[block.clone()], &y[block.clone()]).sqrt();
    blocks.iter().map(size).map(|size| if size > 0.0 { size } else { 1.0 }).collect()
}
