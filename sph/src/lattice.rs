//! Particles on lattices that fit boxes exactly.

use crate::Vector;

/// A box filled with particles at cell centres, the cells fitted so that they tile the box exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice<const D: usize> {
    /// Particle positions (m), the first axis running fastest.
    pub positions: Vec<Vector<D>>,
    /// Cell edge along each axis (m), within the fit of the spacing asked for.
    pub cell: Vector<D>,
    /// Cells along each axis.
    pub counts: [usize; D],
}

/// Fraction of a cell by which lengths count as the same: over round-off in coordinates, which must not
/// settle ties.
pub const TIE: f64 = 1e-6;

/// Cells of about `spacing` (m) that tile a length (m): `round(length/spacing)`, at least one. Half a cell
/// counts as one, and so does what is short of it by [`TIE`].
pub fn cells(length: f64, spacing: f64) -> usize {
    ((length / spacing + 0.5 + TIE).floor() as usize).max(1)
}

impl<const D: usize> Lattice<D> {
    /// Fills the box from `low` to `high` (m) with cells as near to `spacing` (m) as tile it, [`cells`] along
    /// each axis.
    pub fn fill_box(low: Vector<D>, high: Vector<D>, spacing: f64) -> Self {
        let counts: [usize; D] = std::array::from_fn(|i| cells(high[i] - low[i], spacing));
        let cell = Vector::from_fn(|i, _| (high[i] - low[i]) / counts[i] as f64);
        let total = counts.iter().product();
        let positions = (0..total)
            .map(|mut n| {
                Vector::from_fn(|i, _| {
                    let k = n % counts[i];
                    n /= counts[i];
                    low[i] + (k as f64 + 0.5) * cell[i]
                })
            })
            .collect();
        Self { positions, cell, counts }
    }

    /// Volume of one cell (m³; in two dimensions for one metre of depth).
    pub fn cell_volume(&self) -> f64 {
        self.cell.iter().product()
    }
}

/// The points, each displaced at random along each axis by at most `amplitude` (m). The numbers are those of
/// SplitMix64 (Steele, Lea and Flood 2014) from the seed, so that a start is the same everywhere.
pub fn jittered<const D: usize>(points: Vec<Vector<D>>, amplitude: f64, seed: u64) -> Vec<Vector<D>> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64
    };
    points.into_iter().map(|p| p + Vector::from_fn(|_, _| amplitude * (2.0 * next() - 1.0))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0.105 − 0.1 and 1.105 − 1.1 are on both sides of 0.005, two and a half cells.
    #[test]
    fn a_tie_does_not_depend_on_the_last_bit() {
        for moved in [0.0, 0.1, 1.0, -0.3, 1000.0] {
            let (low, high) = (Vector::from([0.1 + moved, 0.0]), Vector::from([0.105 + moved, 0.01]));
            assert_eq!(Lattice::<2>::fill_box(low, high, 0.002).counts, [3, 5], "{moved}");
        }
    }

    #[test]
    fn a_gate_is_tiled_exactly() {
        let gate = Lattice::<2>::fill_box(Vector::from([0.1, 0.0]), Vector::from([0.105, 0.079]), 1.25e-3);
        assert_eq!(gate.counts, [4, 63]);
        assert!((gate.cell_volume() * gate.positions.len() as f64 - 0.005 * 0.079).abs() < 1e-18);
        assert!((gate.positions[1] - gate.positions[0]).y.abs() < 1e-18);
        let top = gate.positions.last().unwrap();
        assert!((top.y + 0.5 * gate.cell.y - 0.079).abs() < 1e-16);
    }
}
