//! Groups of strongly coupled unknowns, each of which becomes one unknown of the next level.

use super::matrix::{Entry, RowChunk, SymmetricRows};
use rayon::prelude::*;

/// Rows that one task works through at least.
const ROWS: usize = 512;

/// A coupling is strong from this fraction of the strongest one in its row on: with the cubic spline at h =
/// 1.2 Δx that takes the 8 nearest of a square lattice's 20 neighbours and the 26 nearest of a cubic one's,
/// so aggregates are about 3 particles wide.
const STRONG: f32 = 0.1;

/// An unknown that belongs to no aggregate, because it is coupled to nothing.
const NONE: u32 = u32::MAX;

/// Which unknowns form which aggregate: interpolation from the coarse level is constant on each.
#[derive(Clone, Debug, Default)]
pub(super) struct Aggregates {
    /// The aggregate of each unknown, or [`NONE`].
    of: Vec<u32>,
    /// Members of aggregate `c` are `members[starts[c]..starts[c + 1]]`, ascending.
    starts: Vec<u32>,
    members: Vec<u32>,
    /// [`of`](Self::of) while it is made.
    joined: Vec<u32>,
}

impl Aggregates {
    /// Number of aggregates.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Unknowns that the aggregates were made for.
    pub fn unknowns(&self) -> usize {
        self.of.len()
    }

    /// Members of aggregate `c`.
    #[inline]
    pub fn members(&self, c: usize) -> &[u32] {
        &self.members[self.starts[c] as usize..self.starts[c + 1] as usize]
    }

    /// The value of unknown `i` interpolated from the coarse level.
    #[inline]
    pub fn interpolate(&self, i: usize, coarse: &[f64]) -> f64 {
        if self.of[i] == NONE { 0.0 } else { coarse[self.of[i] as usize] }
    }

    /// Chooses the aggregates anew.
    ///
    /// The greedy sweep of Vaněk, Mandel and Brezina (1996), in the order of the rows: an unknown none of
    /// whose strong neighbours is taken founds an aggregate with all of them; what is left joins the founded
    /// aggregate it is coupled to most strongly.
    pub fn choose(&mut self, matrix: &SymmetricRows) {
        self.of.clear();
        self.of.resize(matrix.len(), NONE);
        let founded = self.found(matrix);
        self.join(matrix);
        self.list_members(founded);
    }

    fn found(&mut self, matrix: &SymmetricRows) -> u32 {
        let mut count = 0;
        for i in 0..matrix.len() {
            let row = matrix.row(i);
            if self.of[i] != NONE || row.is_empty() {
                continue;
            }
            let bound = STRONG * matrix.rows[i].strongest;
            let strong = || row.iter().filter(|e| e.coupling.abs() >= bound).map(|e| e.column as usize);
            if strong().any(|j| self.of[j] != NONE) {
                continue;
            }
            self.of[i] = count;
            for j in strong() {
                self.of[j] = count;
            }
            count += 1;
        }
        count
    }

    /// Joining is towards founded aggregates only, those of the first sweep, so that aggregates do not grow
    /// into chains.
    fn join(&mut self, matrix: &SymmetricRows) {
        let founded = &self.of;
        self.joined.resize(founded.len(), NONE);
        self.joined.par_iter_mut().with_min_len(ROWS).enumerate().for_each(|(i, joined)| {
            *joined = founded[i];
            if *joined != NONE {
                return;
            }
            let mut strongest = -1.0f32;
            for &Entry { column, coupling } in matrix.row(i) {
                let candidate = founded[column as usize];
                if candidate != NONE && coupling.abs() > strongest {
                    (strongest, *joined) = (coupling.abs(), candidate);
                }
            }
        });
        std::mem::swap(&mut self.of, &mut self.joined);
    }

    fn list_members(&mut self, count: u32) {
        let count = count as usize;
        self.starts.clear();
        self.starts.resize(count + 2, 0);
        for &c in self.of.iter().filter(|&&c| c != NONE) {
            self.starts[c as usize + 2] += 1;
        }
        for c in 2..count + 2 {
            self.starts[c] += self.starts[c - 1];
        }
        self.members.resize(self.starts[count + 1] as usize, 0);
        for (i, &c) in self.of.iter().enumerate().filter(|&(_, &c)| c != NONE) {
            let next = &mut self.starts[c as usize + 1];
            self.members[*next as usize] = i as u32;
            *next += 1;
        }
        self.starts.pop();
    }

    /// Makes the coarse matrix `Pᵀ A P`: couplings summed over members.
    pub fn coarsen(&self, fine: &SymmetricRows, chunks: &mut Vec<RowChunk>, coarse: &mut SymmetricRows) {
        coarse.make(self.len(), chunks, |c, row, position| {
            let mut diagonal = 0.0;
            for &i in self.members(c) {
                let i = i as usize;
                diagonal += fine.rows[i].diagonal;
                for &Entry { column, coupling } in fine.row(i) {
                    let other = self.of[column as usize];
                    if other as usize == c {
                        diagonal += f64::from(coupling);
                    } else if other != NONE {
                        row.add(other, f64::from(coupling), position);
                    }
                }
            }
            diagonal
        });
    }
}
