//! Groups of strongly coupled unknowns, each of which becomes one unknown of the next level.

use super::matrix::{RowChunk, SymmetricRows};

/// A coupling is strong from this fraction of the strongest one in its row on: with the cubic spline at h = 1.2 Δx that takes
/// the 8 nearest of a square lattice's 20 neighbours and the 26 nearest of a cubic one's, so aggregates are about 3 particles wide.
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
    /// The greedy sweep of Vaněk, Mandel and Brezina (1996), in the order of the rows: an unknown none of whose strong neighbours
    /// is taken founds an aggregate with all of them; what is left joins the founded aggregate it is coupled to most strongly.
    pub fn choose(&mut self, matrix: &SymmetricRows) {
        self.of.clear();
        self.of.resize(matrix.len(), NONE);
        let founded = self.found(matrix);
        self.join(matrix, founded);
        self.list_members(founded);
    }

    fn found(&mut self, matrix: &SymmetricRows) -> u32 {
        let mut count = 0;
        for i in 0..matrix.len() {
            let (columns, couplings) = matrix.row(i);
            if self.of[i] != NONE || columns.is_empty() {
                continue;
            }
            let bound = STRONG * couplings.iter().fold(0.0f32, |m, a| m.max(a.abs()));
            let strong = || {
                columns.iter().zip(couplings).filter(|&(_, &a)| a.abs() >= bound).map(|(&j, _)| j as usize)
            };
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

    fn join(&mut self, matrix: &SymmetricRows, founded: u32) {
        // Joining is towards founded aggregates only, those of the first sweep, so that aggregates do not grow into chains.
        for i in 0..matrix.len() {
            if self.of[i] != NONE {
                continue;
            }
            let (columns, couplings) = matrix.row(i);
            let (mut strongest, mut best) = (-1.0f32, NONE);
            for (&j, &a) in columns.iter().zip(couplings) {
                let candidate = self.of[j as usize];
                if candidate < founded && a.abs() > strongest {
                    (strongest, best) = (a.abs(), candidate);
                }
            }
            // Marked beyond the founded ones until the sweep is over.
            self.of[i] = if best == NONE { NONE } else { best + founded };
        }
        for of in &mut self.of {
            if *of != NONE && *of >= founded {
                *of -= founded;
            }
        }
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
                diagonal += fine.diagonal[i];
                let (columns, couplings) = fine.row(i);
                for (&j, &a) in columns.iter().zip(couplings) {
                    let other = self.of[j as usize];
                    if other as usize == c {
                        diagonal += f64::from(a);
                    } else if other != NONE {
                        row.add(other, f64::from(a), position);
                    }
                }
            }
            diagonal
        });
    }
}
