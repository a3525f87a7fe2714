//! Reductions whose result does not depend on the number of threads.

use rayon::prelude::*;
use std::iter::Sum;

/// Particles summed by one task, and the unit in which sums are combined: fixed, so that rounding is the same
/// for every number of threads.
const CHUNK: usize = 1024;

/// Chunks that one thread works through at least: handing over fewer takes longer than summing them.
const CHUNKS: usize = 4;

/// `Σ term(i)` for `i` in `0..count`, of numbers or vectors, summed in chunks of fixed size and the chunks'
/// sums in order.
pub fn sum<T: Send + Sum>(count: usize, term: impl Fn(usize) -> T + Sync) -> T {
    let chunk_sum = |c: usize| (c * CHUNK..((c + 1) * CHUNK).min(count)).map(&term).sum::<T>();
    let chunks = count.div_ceil(CHUNK);
    if chunks <= 1 {
        return chunk_sum(0);
    }
    (0..chunks).into_par_iter().with_min_len(CHUNKS).map(chunk_sum).collect::<Vec<_>>().into_iter().sum()
}

/// The largest `term(i)` for `i` in `0..count`, and `floor` where there is none larger.
pub fn max(count: usize, floor: f64, term: impl Fn(usize) -> f64 + Sync + Send) -> f64 {
    (0..count).into_par_iter().with_min_len(CHUNKS * CHUNK).map(term).reduce(|| floor, f64::max)
}

#[cfg(test)]
mod tests {
    #[test]
    fn sums_are_the_same_to_the_bit_for_any_number_of_threads() {
        let term = |i: usize| 1.0 / (1.0 + i as f64).powf(1.1);
        let with = |threads| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap()
                .install(|| super::sum(100_000, term))
        };
        assert_eq!(with(1).to_bits(), with(2).to_bits());
        assert_eq!(with(1).to_bits(), with(7).to_bits());
        assert_eq!(super::sum(0, term), 0.0);
    }
}
