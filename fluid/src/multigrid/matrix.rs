//! Symmetric sparse rows of one level, and loops over rows.

use rayon::prelude::*;

/// Rows handled by one task: fixed, so that nothing depends on the number of threads.
pub(super) const CHUNK: usize = 2048;

/// The damping of the Jacobi smoother. Below one it contracts, because `D⁻¹A` has no eigenvalue above two.
const JACOBI_WEIGHT: f64 = 0.94;

/// Calls `pass(i, &mut out[i])` for every row, in chunks; inline where there is one chunk only.
#[inline]
pub(super) fn for_rows(out: &mut [f64], pass: impl Fn(usize, &mut f64) + Sync) {
    let chunk_pass = |(chunk, part): (usize, &mut [f64])| {
        for (k, value) in part.iter_mut().enumerate() {
            pass(chunk * CHUNK + k, value);
        }
    };
    if out.len() <= CHUNK {
        chunk_pass((0, out));
    } else {
        out.par_chunks_mut(CHUNK).enumerate().for_each(chunk_pass);
    }
}

/// A symmetric matrix in compressed rows, the diagonal apart.
///
/// Couplings are rounded to single precision, and the diagonal is the row's own sum in double precision less the rounded
/// couplings: constants are mapped as by the unrounded matrix, which is what long waves depend on.
#[derive(Clone, Debug, Default)]
pub(super) struct SymmetricRows {
    /// Row starts, one more than rows.
    offsets: Vec<u32>,
    /// Columns of the couplings, row after row, without the diagonal.
    columns: Vec<u32>,
    /// The couplings `a_ij`, `i ≠ j`.
    couplings: Vec<f32>,
    /// The diagonal `a_ii`.
    pub diagonal: Vec<f64>,
    /// The smoother's step for a unit residual: `0.94/max(a_ii, ½ Σ_j |a_ij|)`, where the maximum keeps the eigenvalues of
    /// `D⁻¹A` at or below two (Gershgorin); `1/a_ii` in a row without couplings, and zero in an empty one.
    pub step: Vec<f64>,
}

/// Rows of one chunk while they are made.
#[derive(Clone, Debug, Default)]
pub(super) struct RowChunk {
    ends: Vec<u32>,
    columns: Vec<u32>,
    couplings: Vec<f32>,
    diagonal: Vec<f64>,
    step: Vec<f64>,
    /// The row being made, in double precision.
    open_columns: Vec<u32>,
    open: Vec<f64>,
}

impl RowChunk {
    fn clear(&mut self) {
        self.ends.clear();
        self.columns.clear();
        self.couplings.clear();
        self.diagonal.clear();
        self.step.clear();
    }

    /// Adds `value` to the open row's coupling with `column`, which `position` remembers the place of.
    #[inline]
    pub fn add(&mut self, column: u32, value: f64, position: &mut [u32]) {
        let place = position[column as usize] as usize;
        if place < self.open_columns.len() && self.open_columns[place] == column {
            self.open[place] += value;
        } else {
            position[column as usize] = self.open_columns.len() as u32;
            self.open_columns.push(column);
            self.open.push(value);
        }
    }

    /// Adds a coupling with a column that the open row does not hold yet.
    #[inline]
    pub fn push(&mut self, column: u32, value: f64) {
        self.open_columns.push(column);
        self.open.push(value);
    }

    /// Ends the open row.
    fn close(&mut self, diagonal: f64) {
        let (mut lost, mut absolute) = (0.0, 0.0);
        for &a in &self.open {
            let rounded = a as f32;
            self.couplings.push(rounded);
            lost += a - f64::from(rounded);
            absolute += f64::from(rounded.abs());
        }
        self.columns.append(&mut self.open_columns);
        self.open.clear();
        let diagonal = diagonal + lost;
        let (bound, weight) = if absolute > 0.0 {
            (diagonal.max(0.5 * (diagonal + absolute)), JACOBI_WEIGHT)
        } else {
            (diagonal, 1.0)
        };
        self.diagonal.push(diagonal);
        self.step.push(if bound > 0.0 { weight / bound } else { 0.0 });
        self.ends.push(self.columns.len() as u32);
    }
}

impl SymmetricRows {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.diagonal.len()
    }

    /// Number of entries, diagonal included.
    pub fn entries(&self) -> usize {
        self.len() + self.columns.len()
    }

    /// Columns and couplings of row `i`.
    #[inline]
    pub fn row(&self, i: usize) -> (&[u32], &[f32]) {
        let range = self.offsets[i] as usize..self.offsets[i + 1] as usize;
        (&self.columns[range.clone()], &self.couplings[range])
    }

    /// `b_i − Σ_j a_ij x_j`.
    #[inline]
    pub fn residual(&self, i: usize, b: &[f64], x: &[f64]) -> f64 {
        let (columns, couplings) = self.row(i);
        let mut sum = self.diagonal[i] * x[i];
        for (&j, &a) in columns.iter().zip(couplings) {
            sum += f64::from(a) * x[j as usize];
        }
        b[i] - sum
    }

    /// Makes `rows` rows: `fill(i, chunk, position)` adds the couplings of row `i` in a fixed order and returns its diagonal.
    pub fn make(
        &mut self,
        rows: usize,
        chunks: &mut Vec<RowChunk>,
        fill: impl Fn(usize, &mut RowChunk, &mut [u32]) -> f64 + Sync,
    ) {
        let chunk_count = rows.div_ceil(CHUNK);
        chunks.resize_with(chunk_count.max(chunks.len()), RowChunk::default);
        let chunks = &mut chunks[..chunk_count];
        chunks.par_iter_mut().enumerate().for_each_init(
            || vec![0u32; rows],
            |position, (c, chunk)| {
                chunk.clear();
                for i in c * CHUNK..((c + 1) * CHUNK).min(rows) {
                    let diagonal = fill(i, chunk, position);
                    chunk.close(diagonal);
                }
            },
        );
        self.join(rows, chunks);
    }

    /// Lays the rows of `chunks` one behind the other.
    fn join(&mut self, rows: usize, chunks: &[RowChunk]) {
        let entries = chunks.iter().map(|c| c.columns.len()).sum();
        self.offsets.resize(rows + 1, 0);
        self.offsets[0] = 0;
        self.columns.resize(entries, 0);
        self.couplings.resize(entries, 0.0);
        self.diagonal.resize(rows, 0.0);
        self.step.resize(rows, 0.0);
        let mut first_entry = 0u32;
        let mut targets = Vec::with_capacity(chunks.len());
        let (mut columns, mut couplings) = (self.columns.as_mut_slice(), self.couplings.as_mut_slice());
        let by_rows = self.offsets[1..]
            .chunks_mut(CHUNK)
            .zip(self.diagonal.chunks_mut(CHUNK).zip(self.step.chunks_mut(CHUNK)));
        for (chunk, of_rows) in chunks.iter().zip(by_rows) {
            let (chunk_columns, chunk_couplings);
            (chunk_columns, columns) = columns.split_at_mut(chunk.columns.len());
            (chunk_couplings, couplings) = couplings.split_at_mut(chunk.columns.len());
            targets.push((chunk, first_entry, of_rows, chunk_columns, chunk_couplings));
            first_entry += chunk.columns.len() as u32;
        }
        targets.into_par_iter().for_each(
            |(chunk, first_entry, (offsets, (diagonal, step)), columns, couplings)| {
                for (offset, end) in offsets.iter_mut().zip(&chunk.ends) {
                    *offset = first_entry + end;
                }
                columns.copy_from_slice(&chunk.columns);
                couplings.copy_from_slice(&chunk.couplings);
                diagonal.copy_from_slice(&chunk.diagonal);
                step.copy_from_slice(&chunk.step);
            },
        );
    }
}
