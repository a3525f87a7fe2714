//! Symmetric sparse rows of one level, and loops over rows.

use rayon::prelude::*;

/// Rows made by one task.
const CHUNK: usize = 512;

/// Rows that one task works through at least where a row is summed: below it handing them over takes longer
/// than summing them.
pub(super) const SUMMED: usize = 128;

/// Rows that one task works through at least where there are a few multiplications for each.
pub(super) const SCALED: usize = 4096;

/// The damping of the Jacobi smoother. Below one it contracts, because `D⁻¹A` has no eigenvalue above two.
const JACOBI_WEIGHT: f64 = 0.94;

/// Calls `pass(i, &mut out[i])` for every row, at least `task` rows by one thread.
#[inline]
pub(super) fn for_rows(task: usize, out: &mut [f64], pass: impl Fn(usize, &mut f64) + Sync) {
    out.par_iter_mut().with_min_len(task).enumerate().for_each(|(i, value)| pass(i, value));
}

/// A coupling `a_ij`, `i ≠ j`, and its column.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Entry {
    pub column: u32,
    pub coupling: f32,
}

/// What a row has besides its couplings.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Row {
    /// The diagonal `a_ii`.
    pub diagonal: f64,
    /// The smoother's step for a unit residual: `0.94/max(a_ii, ½ Σ_j |a_ij|)`, where the maximum keeps the
    /// eigenvalues of `D⁻¹A` at or below two (Gershgorin); `1/a_ii` in a row without couplings, and zero in
    /// an empty one; rounded.
    pub step: f32,
    /// The magnitude of the strongest coupling.
    pub strongest: f32,
    start: u32,
    count: u32,
}

/// A symmetric matrix in compressed rows, the diagonal apart.
///
/// Couplings are rounded to single precision, and the diagonal is the row's own sum in double precision less
/// the rounded couplings: constants are mapped as by the unrounded matrix, which is what long waves depend
/// on.
#[derive(Clone, Debug, Default)]
pub(super) struct SymmetricRows {
    pub rows: Vec<Row>,
    /// Couplings, row after row; the slots of a row may be more than its couplings.
    entries: Vec<Entry>,
}

/// A row while it is made, in double precision.
#[derive(Clone, Debug, Default)]
pub struct OpenRow {
    columns: Vec<u32>,
    couplings: Vec<f64>,
}

impl OpenRow {
    /// Adds a coupling with a column that the row does not hold yet.
    #[inline]
    pub fn push(&mut self, column: u32, coupling: f64) {
        self.columns.push(column);
        self.couplings.push(coupling);
    }

    /// Adds `value` to the coupling with `column`, which `position` remembers the place of.
    #[inline]
    pub(super) fn add(&mut self, column: u32, value: f64, position: &mut [u32]) {
        let place = position[column as usize] as usize;
        if place < self.columns.len() && self.columns[place] == column {
            self.couplings[place] += value;
        } else {
            position[column as usize] = self.columns.len() as u32;
            self.push(column, value);
        }
    }

    /// Ends the row, whose couplings `store` takes in order, and empties this.
    fn close(&mut self, diagonal: f64, start: u32, mut store: impl FnMut(usize, Entry)) -> Row {
        let (mut lost, mut absolute, mut strongest) = (0.0, 0.0, 0.0f32);
        for (k, (&column, &a)) in self.columns.iter().zip(&self.couplings).enumerate() {
            let coupling = a as f32;
            store(k, Entry { column, coupling });
            lost += a - f64::from(coupling);
            absolute += f64::from(coupling.abs());
            strongest = strongest.max(coupling.abs());
        }
        let count = self.columns.len() as u32;
        self.columns.clear();
        self.couplings.clear();
        let diagonal = diagonal + lost;
        let (bound, weight) = if absolute > 0.0 {
            (diagonal.max(0.5 * (diagonal + absolute)), JACOBI_WEIGHT)
        } else {
            (diagonal, 1.0)
        };
        let step = if bound > 0.0 { (weight / bound) as f32 } else { 0.0 };
        Row { diagonal, step, strongest, start, count }
    }
}

/// Rows of one chunk while they are made.
#[derive(Clone, Debug, Default)]
pub(super) struct RowChunk {
    open: OpenRow,
    rows: Vec<Row>,
    entries: Vec<Entry>,
}

impl SymmetricRows {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Number of entries, diagonal included.
    pub fn entries(&self) -> usize {
        self.len() + self.rows.iter().map(|row| row.count as usize).sum::<usize>()
    }

    /// Couplings of row `i`.
    #[inline]
    pub fn row(&self, i: usize) -> &[Entry] {
        let Row { start, count, .. } = self.rows[i];
        &self.entries[start as usize..(start + count) as usize]
    }

    /// `b_i − Σ_j a_ij x_j`.
    #[inline]
    pub fn residual(&self, i: usize, b: &[f64], x: &[f64]) -> f64 {
        let Row { start, count, diagonal, .. } = self.rows[i];
        let mut sum = diagonal * x[i];
        for entry in &self.entries[start as usize..(start + count) as usize] {
            sum += f64::from(entry.coupling) * x[entry.column as usize];
        }
        b[i] - sum
    }

    /// Makes rows that have at most the couplings that `slots` (row starts, one more than rows) leaves room
    /// for: `fill(i, row)` adds the couplings of row `i` in a fixed order and returns its diagonal.
    pub fn make_in_slots(&mut self, slots: &[u32], fill: impl Fn(usize, &mut OpenRow) -> f64 + Sync) {
        let rows = slots.len().saturating_sub(1);
        self.rows.resize(rows, Row::default());
        self.entries.resize(slots.last().map_or(0, |&end| end as usize), Entry::default());
        let mut tasks = Vec::with_capacity(rows.div_ceil(CHUNK));
        let mut rest = self.entries.as_mut_slice();
        for (c, of_rows) in self.rows.chunks_mut(CHUNK).enumerate() {
            let first = c * CHUNK;
            let (own, tail) = rest.split_at_mut((slots[first + of_rows.len()] - slots[first]) as usize);
            tasks.push((first, of_rows, own));
            rest = tail;
        }
        tasks.into_par_iter().for_each_init(OpenRow::default, |open, (first, of_rows, entries)| {
            for (k, row) in of_rows.iter_mut().enumerate() {
                let i = first + k;
                let diagonal = fill(i, open);
                let at = (slots[i] - slots[first]) as usize;
                let own = &mut entries[at..(slots[i + 1] - slots[first]) as usize];
                *row = open.close(diagonal, slots[i], |k, entry| own[k] = entry);
            }
        });
    }

    /// Makes `rows` rows of any length: `fill(i, row, position)` adds the couplings of row `i` in a fixed
    /// order and returns its diagonal.
    pub fn make(
        &mut self,
        rows: usize,
        chunks: &mut Vec<RowChunk>,
        fill: impl Fn(usize, &mut OpenRow, &mut [u32]) -> f64 + Sync,
    ) {
        let chunk_count = rows.div_ceil(CHUNK);
        chunks.resize_with(chunk_count.max(chunks.len()), RowChunk::default);
        let chunks = &mut chunks[..chunk_count];
        chunks.par_iter_mut().enumerate().for_each_init(
            || vec![0u32; rows],
            |position, (c, RowChunk { open, rows: made, entries })| {
                made.clear();
                entries.clear();
                for i in c * CHUNK..((c + 1) * CHUNK).min(rows) {
                    let diagonal = fill(i, open, position);
                    made.push(open.close(diagonal, entries.len() as u32, |_, entry| entries.push(entry)));
                }
            },
        );
        self.rows.resize(rows, Row::default());
        self.entries.resize(chunks.iter().map(|c| c.entries.len()).sum(), Entry::default());
        let mut first_entry = 0;
        let mut rest = self.entries.as_mut_slice();
        for (chunk, of_rows) in chunks.iter().zip(self.rows.chunks_mut(CHUNK)) {
            let (own, tail) = rest.split_at_mut(chunk.entries.len());
            own.copy_from_slice(&chunk.entries);
            rest = tail;
            for (row, made) in of_rows.iter_mut().zip(&chunk.rows) {
                *row = Row { start: made.start + first_entry, ..*made };
            }
            first_entry += chunk.entries.len() as u32;
        }
    }
}
