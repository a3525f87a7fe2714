//! `Φ = L D Lᵀ` of eight clusters at once, a lane each, and the form in which one cluster's factors are kept.
//!
//! Rows come in blocks of [`BLOCK`]; where a cluster has fewer points, rows of the identity follow. A block
//! of rows holds `L` column by column up to its own diagonal, [`BLOCK`] entries each: what a block of
//! unknowns needs is in one run.

use super::lanes::{LANES, Lanes};
use pulp::NullaryFnOnce;

/// Rows worked on at once: a block of them by as many columns fills sixteen registers with sums.
pub(super) const BLOCK: usize = 4;

/// A pivot below this is lost in the rounding of a matrix with ones on its diagonal.
const LOST: f64 = 1e-13;

/// Wendland's C² function, positive definite in up to three dimensions, for `q ≤ 1`.
#[inline(always)]
pub(super) fn wendland_c2(q: f64) -> f64 {
    let rest = 1.0 - q;
    (rest * rest) * (rest * rest) * (4.0 * q + 1.0)
}

/// Entries of the factors before a block of rows, and of all where there are so many.
#[inline(always)]
pub(super) fn offset(block: usize) -> usize {
    BLOCK * BLOCK * block * (block + 1) / 2
}

/// The matrices of [`LANES`] clusters and room for their factors.
pub(super) struct Factorise<'a, const D: usize> {
    /// Positions of the points, a whole number of blocks; over the support of the functions, none further
    /// from another than one.
    pub places: &'a [[Lanes; D]],
    /// One where a cluster has the point, zero behind its last.
    pub present: &'a [Lanes],
    /// `L`, [`offset`] of the number of blocks.
    pub factors: &'a mut [Lanes],
    /// `D⁻¹`.
    pub inverse_pivots: &'a mut [Lanes],
}

impl<const D: usize> Factorise<'_, D> {
    /// The first row of each cluster whose pivot is lost in rounding, if there is one.
    pub fn run(self) -> [Option<usize>; LANES] {
        pulp::Arch::new().dispatch(self)
    }

    /// `φ` of two points.
    #[inline(always)]
    fn entry(&self, row: usize, column: usize) -> Lanes {
        let mut squared = Lanes::ZERO;
        for c in 0..D {
            let off = self.places[row][c] - self.places[column][c];
            squared += off * off;
        }
        squared.map(|s| wendland_c2(s.sqrt())) * self.present[row]
    }

    /// Entries of two blocks of points.
    #[inline(always)]
    fn entries(&self, rows: usize, columns: usize) -> [[Lanes; BLOCK]; BLOCK] {
        let mut entries = [[Lanes::ZERO; BLOCK]; BLOCK];
        for r in 0..BLOCK {
            for c in 0..BLOCK {
                entries[r][c] = self.entry(BLOCK * rows + r, BLOCK * columns + c);
            }
        }
        entries
    }

    /// `U = L D` of a block left of the diagonal: what is left of Φ, with the triangle of that block's own
    /// rows divided out.
    #[inline(always)]
    fn solve_block(&mut self, block: usize, other: usize) {
        let mut sums = self.entries(block, other);
        let (done, own) = self.factors.split_at_mut(offset(block));
        let theirs = done[offset(other)..].as_chunks::<BLOCK>().0;
        let own = own.as_chunks_mut::<BLOCK>().0;
        for (u, l) in own[..BLOCK * other].iter().zip(&theirs[..BLOCK * other]) {
            for r in 0..BLOCK {
                for c in 0..BLOCK {
                    sums[r][c] -= u[r] * l[c];
                }
            }
        }
        let triangle = &theirs[BLOCK * other..][..BLOCK];
        for r in 0..BLOCK {
            let [u0, mut u1, mut u2, mut u3] = sums[r];
            u1 -= u0 * triangle[0][1];
            u2 -= u0 * triangle[0][2] + u1 * triangle[1][2];
            u3 -= u0 * triangle[0][3] + u1 * triangle[1][3] + u2 * triangle[2][3];
            for (c, u) in [u0, u1, u2, u3].into_iter().enumerate() {
                own[BLOCK * other + c][r] = u;
            }
        }
    }

    /// `L` from `U` left of the diagonal, and the triangle on it.
    #[inline(always)]
    fn finish_block(&mut self, block: usize, lost: &mut [Option<usize>; LANES]) {
        let mut sums = self.entries(block, block);
        for c in 0..BLOCK {
            sums[c][c] = Lanes::splat(1.0);
        }
        let own = self.factors[offset(block)..].as_chunks_mut::<BLOCK>().0;
        for (column, inverse) in own[..BLOCK * block].iter_mut().zip(&*self.inverse_pivots) {
            let u = *column;
            *column = u.map(|u| u * *inverse);
            for r in 0..BLOCK {
                for c in 0..=r {
                    sums[r][c] -= u[r] * column[c];
                }
            }
        }
        for c in 0..BLOCK {
            let row = BLOCK * block + c;
            let mut pivot = sums[c][c];
            if pivot.0.iter().any(|pivot| *pivot <= LOST) {
                for lane in 0..LANES {
                    if pivot.0[lane] <= LOST {
                        lost[lane] = lost[lane].or(Some(row));
                        pivot.0[lane] = 1.0;
                    }
                }
            }
            let inverse = pivot.map(|pivot| 1.0 / pivot);
            self.inverse_pivots[row] = inverse;
            let u: [Lanes; BLOCK] = std::array::from_fn(|r| sums[r][c]);
            for r in 0..BLOCK {
                let l = if r > c { u[r] * inverse } else { Lanes::ZERO };
                own[row][r] = l;
                for after in c + 1..=r {
                    sums[r][after] -= l * u[after];
                }
            }
        }
    }
}

impl<const D: usize> NullaryFnOnce for Factorise<'_, D> {
    type Output = [Option<usize>; LANES];

    #[inline(always)]
    fn call(mut self) -> Self::Output {
        let mut lost = [None; LANES];
        for block in 0..self.places.len() / BLOCK {
            for other in 0..block {
                self.solve_block(block, other);
            }
            self.finish_block(block, &mut lost);
        }
        lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wendlands_function_by_hand() {
        assert_eq!([wendland_c2(0.0), wendland_c2(0.5), wendland_c2(1.0)], [1.0, 3.0 / 16.0, 0.0]);
    }

    /// Clusters of 1 to 8 points on a line, with two blocks of rows: the factors' product is the matrix, and
    /// the identity behind it.
    #[test]
    fn factors_give_the_matrix_back() {
        let rows = 2 * BLOCK;
        let place = |row: usize, lane: usize| 0.1 * row as f64 / (1.0 + 0.1 * lane as f64);
        let lanes = |f: &dyn Fn(usize) -> f64| Lanes(std::array::from_fn(f));
        let places: Vec<[Lanes; 1]> = (0..rows).map(|row| [lanes(&|lane| place(row, lane))]).collect();
        let is_there = |row: usize, lane: usize| row <= lane;
        let present: Vec<Lanes> =
            (0..rows).map(|row| lanes(&|lane| f64::from(u8::from(is_there(row, lane))))).collect();
        let mut factors = vec![Lanes::splat(f64::NAN); offset(2)];
        let mut inverse_pivots = vec![Lanes::splat(f64::NAN); rows];
        let run = |places: &[[Lanes; 1]], factors: &mut [Lanes], inverse_pivots: &mut [Lanes]| {
            Factorise { places, present: &present, factors, inverse_pivots }.run()
        };
        assert_eq!(run(&places, &mut factors, &mut inverse_pivots), [None; LANES]);
        for lane in 0..LANES {
            let l = |row: usize, column: usize| match row.cmp(&column) {
                std::cmp::Ordering::Less => 0.0,
                std::cmp::Ordering::Equal => 1.0,
                _ => factors[offset(row / BLOCK) + BLOCK * column + row % BLOCK].0[lane],
            };
            for row in 0..rows {
                for column in 0..=row {
                    let product: f64 =
                        (0..rows).map(|k| l(row, k) * l(column, k) / inverse_pivots[k].0[lane]).sum();
                    let apart = (place(row, lane) - place(column, lane)).abs();
                    let entry = if row == column {
                        1.0
                    } else if is_there(row, lane) {
                        wendland_c2(apart)
                    } else {
                        0.0
                    };
                    // Rounding of a sum of eight products of order one.
                    assert!((product - entry).abs() < 2e-15, "{row} {column} {lane}: {product} {entry}");
                }
            }
        }
        // Points 1 and 3 in one place: lost where there is a point 3.
        let mut twice = places;
        twice[3] = twice[1];
        let lost = run(&twice, &mut factors, &mut inverse_pivots);
        assert_eq!(lost, std::array::from_fn(|lane| (lane >= 3).then_some(3)));
    }
}
