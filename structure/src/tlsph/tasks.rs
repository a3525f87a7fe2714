//! Slices shared among threads, each task with its own part of the output.

use crate::lanes::LANES;
use std::array::from_fn;
use std::ops::Range;

/// Fewer slices than this are not shared among threads: handing half of so short a pass over costs more than
/// it saves. Two threads over one were measured to be 1.0 at 250 particles and 1.2 to 1.3 at 1,000 (loaded
/// machine), 1.7 to 2.0 at 3,000 (idle).
const PARALLEL_SLICES: usize = 128;

/// Whether passes over so many slices are shared among threads.
pub(crate) fn is_shared(slices: usize) -> bool {
    slices >= PARALLEL_SLICES && rayon::current_num_threads() > 1
}

/// Works on all slices, on several threads where there are many, each task with its own part of the output;
/// gives the first result in the order of the slices.
pub(crate) fn in_tasks<const N: usize, const M: usize>(
    slices: Range<usize>,
    out: [[&mut [f64]; N]; M],
    leaf: &(impl Fn(Range<usize>, [[&mut [f64]; N]; M]) -> Option<usize> + Sync),
) -> Option<usize> {
    let count = slices.len();
    if !is_shared(count) {
        return leaf(slices, out);
    }
    let half = count / 2;
    let (first, second) = split(out, half * LANES);
    let middle = slices.start + half;
    let (a, b) = rayon::join(
        || in_tasks(slices.start..middle, first, leaf),
        || in_tasks(middle..slices.end, second, leaf),
    );
    a.or(b)
}

pub(crate) type Parts<'a, const N: usize, const M: usize> = [[&'a mut [f64]; N]; M];

/// Every slice of the arrays in two at `at`.
pub(crate) fn split<const N: usize, const M: usize>(
    all: Parts<N, M>,
    at: usize,
) -> (Parts<N, M>, Parts<N, M>) {
    let mut second: Parts<N, M> = from_fn(|_| from_fn(|_| Default::default()));
    let mut r = 0;
    let first = all.map(|row| {
        let mut c = 0;
        let row = row.map(|whole| {
            let (head, tail) = whole.split_at_mut(at);
            second[r][c] = tail;
            c += 1;
            head
        });
        r += 1;
        row
    });
    (first, second)
}
