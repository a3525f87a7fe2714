//! Loops over the rows of a neighbour list that fill one entry a pair and one entry a row, in parallel
//! without allocation.

use sph::neighbours::NeighbourList;

/// Rows that one task works through.
const ROWS: usize = 256;

/// Calls `work(row, entries of the row's pairs, entry of the row)` for every row of `list`, in parallel.
/// `pairs` has one entry a pair of the list, `rows` one a row.
pub fn for_each_row<P: Send, R: Send>(
    list: &NeighbourList,
    pairs: &mut [P],
    rows: &mut [R],
    work: impl Fn(usize, &mut [P], &mut R) + Sync,
) {
    assert_eq!((pairs.len(), rows.len()), (list.pairs(), list.len()), "one entry a pair and one a row");
    halve(list.offsets(), 0, pairs, rows, &work);
}

fn halve<P: Send, R: Send>(
    offsets: &[u32],
    first: usize,
    mut pairs: &mut [P],
    rows: &mut [R],
    work: &(impl Fn(usize, &mut [P], &mut R) + Sync),
) {
    if rows.len() <= ROWS {
        for (i, row) in rows.iter_mut().enumerate() {
            let row_length = (offsets[first + i + 1] - offsets[first + i]) as usize;
            let (own, rest) = pairs.split_at_mut(row_length);
            work(first + i, own, row);
            pairs = rest;
        }
        return;
    }
    let middle = rows.len() / 2;
    let (upper_rows, lower_rows) = rows.split_at_mut(middle);
    let (upper, lower) = pairs.split_at_mut((offsets[first + middle] - offsets[first]) as usize);
    rayon::join(
        || halve(offsets, first, upper, upper_rows, work),
        || halve(offsets, first + middle, lower, lower_rows, work),
    );
}
