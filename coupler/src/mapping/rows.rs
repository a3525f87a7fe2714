//! The rows of a mapping: a CSR matrix, gathered row by row.

use sprs::CsMatViewI;

/// Rows in CSR form: columns ascending in each row, no explicit zeros.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    starts: Vec<usize>,
    columns: Vec<u32>,
    weights: Vec<f64>,
    row: Vec<(u32, f64)>,
}

impl Default for Rows {
    fn default() -> Self {
        Self { starts: vec![0], columns: Vec::new(), weights: Vec::new(), row: Vec::new() }
    }
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
        self.row.push((column as u32, weight));
    }

    /// Ends the row at hand: sorts it, adds up entries of one column in the order in which they came, and
    /// leaves out those that are zero.
    pub fn end_row(&mut self) {
        self.sort();
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

    /// Puts the rows of `other` behind its own.
    pub fn append(&mut self, other: &Self) {
        let entries = self.columns.len();
        self.columns.extend_from_slice(&other.columns);
        self.weights.extend_from_slice(&other.weights);
        self.starts.extend(other.starts[1..].iter().map(|start| entries + start));
    }

    /// Lays out rows of such lengths, to be filled in.
    pub fn lay_out<'a>(&mut self, lengths: impl Iterator<Item = &'a u32>) {
        let mut end = 0;
        self.starts.clear();
        self.starts.push(0);
        self.starts.extend(lengths.map(|length| {
            end += *length as usize;
            end
        }));
        self.columns.resize(end, 0);
        self.weights.resize(end, 0.0);
    }

    /// Where rows start, their columns and weights.
    pub fn slots(&mut self) -> (&[usize], &mut [u32], &mut [f64]) {
        (&self.starts, &mut self.columns, &mut self.weights)
    }

    /// Leaves out what is zero.
    pub fn drop_zeros(&mut self) {
        let (mut from, mut kept) = (0, 0);
        for end in &mut self.starts[1..] {
            for k in from..*end {
                if self.weights[k] != 0.0 {
                    (self.columns[kept], self.weights[kept]) = (self.columns[k], self.weights[k]);
                    kept += 1;
                }
            }
            (from, *end) = (*end, kept);
        }
        self.columns.truncate(kept);
        self.weights.truncate(kept);
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Columns and weights of a row.
    #[inline]
    pub fn row(&self, row: usize) -> (&[u32], &[f64]) {
        let range = self.starts[row]..self.starts[row + 1];
        (&self.columns[range.clone()], &self.weights[range])
    }

    /// As a matrix of so many columns.
    pub fn matrix(&self, columns: usize) -> CsMatViewI<'_, f64, u32, usize> {
        CsMatViewI::try_new((self.count(), columns), &self.starts[..], &self.columns[..], &self.weights[..])
            .map_err(|(.., error)| error)
            .expect("rows are ended one by one, with columns ascending and inside the source points")
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
        let matrix = rows.matrix(4);
        assert_eq!(matrix.shape(), (2, 4));
        assert_eq!((matrix.indices(), matrix.data()), (&[1, 3][..], &[2.0, 1.5][..]));
    }

    #[test]
    fn rows_laid_out_are_filled_in_and_rid_of_zeros() {
        let mut rows = Rows::default();
        rows.lay_out([2, 0, 3].iter());
        let (starts, columns, weights) = rows.slots();
        assert_eq!(starts, [0, 2, 2, 5]);
        columns.copy_from_slice(&[0, 3, 1, 2, 3]);
        weights.copy_from_slice(&[1.0, 0.0, 0.0, 2.0, 0.0]);
        rows.drop_zeros();
        assert_eq!(rows.count(), 3);
        assert_eq!(rows.row(0), (&[0][..], &[1.0][..]));
        assert_eq!(rows.row(1), (&[][..], &[][..]));
        assert_eq!(rows.row(2), (&[2][..], &[2.0][..]));
    }
}
