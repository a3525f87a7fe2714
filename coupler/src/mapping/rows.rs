//! The rows of a mapping while they are gathered, in the storage of a CSR matrix.

use sprs::CsMat;

/// Rows in CSR form: columns ascending in each row, no explicit zeros.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    starts: Vec<usize>,
    columns: Vec<usize>,
    weights: Vec<f64>,
    row: Vec<(usize, f64)>,
    /// Of the columns around those of the row at hand, which it has, a bit each, and their sums.
    taken: Vec<u64>,
    sums: Vec<f64>,
}

impl Rows {
    /// Forgets all rows and keeps the memory.
    pub fn clear(&mut self) {
        self.starts.clear();
        self.starts.push(0);
        self.columns.clear();
        self.weights.clear();
        self.row.clear();
    }

    /// Adds `weight` to `column` of the row at hand.
    pub fn add(&mut self, column: usize, weight: f64) {
        self.row.push((column, weight));
    }

    /// Ends the row at hand: sorts it, adds up entries of one column in the order in which they came, and leaves out those that are zero.
    pub fn end_row(&mut self) {
        let columns = self.row.iter().map(|&(column, _)| column);
        let (low, high) = columns.fold((usize::MAX, 0), |(low, high), c| (low.min(c), high.max(c)));
        let words = if low <= high { high / 64 - low / 64 + 1 } else { 0 };
        // A long row is sorted by marking its columns, unless they are too far apart for that.
        if self.row.len() > 16 && words <= 8 * self.row.len() {
            self.mark(low / 64 * 64, words);
        } else {
            self.sort();
        }
        self.row.clear();
        self.starts.push(self.columns.len());
    }

    fn sort(&mut self) {
        self.row.sort_by_key(|&(column, _)| column);
        let start = self.columns.len();
        for &(column, weight) in &self.row {
            if self.columns[start..].last() == Some(&column) {
                *self.weights.last_mut().expect("a column has its weight") += weight;
            } else if weight != 0.0 {
                self.columns.push(column);
                self.weights.push(weight);
            }
        }
    }

    /// Sorts the row at hand whose columns are in that number of words of 64 from `first` on.
    fn mark(&mut self, first: usize, words: usize) {
        let Self { columns, weights, row, taken, sums, .. } = self;
        if taken.len() < words {
            taken.resize(words, 0);
            sums.resize(64 * words, 0.0);
        }
        for &(column, weight) in row.iter().filter(|(_, weight)| *weight != 0.0) {
            let at = column - first;
            let bit = 1 << (at % 64);
            let before = if taken[at / 64] & bit == 0 { 0.0 } else { sums[at] };
            taken[at / 64] |= bit;
            sums[at] = before + weight;
        }
        for (word, taken) in taken[..words].iter_mut().enumerate() {
            let mut bits = std::mem::take(taken);
            while bits != 0 {
                let at = 64 * word + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                columns.push(first + at);
                weights.push(sums[at]);
            }
        }
    }

    /// Puts the rows of `other` behind its own.
    pub fn append(&mut self, other: &Self) {
        let entries = self.columns.len();
        self.columns.extend_from_slice(&other.columns);
        self.weights.extend_from_slice(&other.weights);
        self.starts.extend(other.starts[1..].iter().map(|start| entries + start));
    }

    /// Puts the rows into `matrix` and takes its storage for the next time.
    pub fn swap_into(&mut self, matrix: &mut CsMat<f64>, columns: usize) {
        let shape = (self.starts.len() - 1, columns);
        let take = std::mem::take::<Vec<usize>>;
        let rows = CsMat::try_new(
            shape,
            take(&mut self.starts),
            take(&mut self.columns),
            std::mem::take(&mut self.weights),
        )
        .map_err(|(.., error)| error)
        .expect("rows are ended one by one, with columns ascending and inside the source points");
        (self.starts, self.columns, self.weights) = std::mem::replace(matrix, rows).into_raw_storage();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_sorted_merged_and_without_zeros() {
        let mut rows = Rows::default();
        rows.clear();
        for (column, weight) in [(3, 1.0), (1, 2.0), (3, 0.5), (0, 0.0)] {
            rows.add(column, weight);
        }
        rows.end_row();
        rows.end_row();
        let mut matrix = CsMat::zero((0, 0));
        rows.swap_into(&mut matrix, 4);
        assert_eq!(matrix.shape(), (2, 4));
        assert_eq!((matrix.indices(), matrix.data()), (&[1, 3][..], &[2.0, 1.5][..]));
    }

    #[test]
    fn long_rows_are_sorted_as_short_ones_are() {
        let (mut marked, mut sorted) = (Rows::default(), Rows::default());
        for rows in [&mut marked, &mut sorted] {
            rows.clear();
            // Each column twice, over three words; two weights that cancel each other and one that is zero among them.
            for k in 0..60_u32 {
                let k_in_half = (k % 30) as usize;
                rows.add(100 + k_in_half * (1 + 98 * (k_in_half % 2)) % 131, f64::from(k) - 20.0);
            }
        }
        marked.end_row();
        sorted.sort();
        assert_eq!((marked.columns, marked.weights), (sorted.columns, sorted.weights));
    }
}
