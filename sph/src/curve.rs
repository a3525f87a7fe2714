//! The order of points along a space-filling curve: points that are near each other in it are near each other
//! in space.
//!
//! Morton's curve (G. M. Morton, IBM Ottawa 1966): the key of a cell is made of the bits of its coordinates
//! in turn.

use crate::Vector;
use rayon::prelude::*;

/// Points that one task works through at least.
const ROWS: usize = 4096;

/// Bits of a coordinate that a key of 32 bits has room for.
const fn bits<const D: usize>() -> u32 {
    32 / D as u32
}

/// Key of the cell of edge `cell` (m) that `point` (m) is in, counted from `origin` (m). Points outside of
/// what a key can tell count as in the outermost cell.
pub fn key<const D: usize>(point: &Vector<D>, origin: &Vector<D>, cell: f64) -> u32 {
    let last = ((1u64 << bits::<D>()) - 1) as f64;
    // The conversion takes what is not a number to zero.
    (0..D).fold(0, |key, i| key | spread::<D>(((point[i] - origin[i]) / cell).clamp(0.0, last) as u32) << i)
}

/// The bits of a coordinate with room for those of the others between them.
fn spread<const D: usize>(x: u32) -> u32 {
    let steps: &[(u32, u32)] = match D {
        1 => &[],
        2 => &[(8, 0x00FF_00FF), (4, 0x0F0F_0F0F), (2, 0x3333_3333), (1, 0x5555_5555)],
        3 => &[(16, 0x0300_00FF), (8, 0x0300_F00F), (4, 0x030C_30C3), (2, 0x0924_9249)],
        _ => panic!("space has up to three dimensions"),
    };
    steps.iter().fold(x, |x, &(shift, mask)| (x | x << shift) & mask)
}

/// The places of points in their order along the curve, and memory for finding it.
#[derive(Clone, Debug, Default)]
pub struct CurveOrder {
    /// Key in the upper half, index in the lower: unique, so that sorting has one result.
    keyed: Vec<u64>,
}

impl CurveOrder {
    /// Takes note of `points` (m) in the order in which they stand, their cells being `cell` (m) wide, and
    /// gives the share of them that come before one with a smaller key: 0 in order, ½ without any.
    pub fn note<const D: usize>(&mut self, points: &[Vector<D>], origin: &Vector<D>, cell: f64) -> f64 {
        self.keyed.resize(points.len(), 0);
        let keyed = self.keyed.par_iter_mut().zip(points).with_min_len(ROWS).enumerate();
        keyed.for_each(|(i, (keyed, point))| *keyed = u64::from(key(point, origin, cell)) << 32 | i as u64);
        let falls = self.keyed.par_windows(2).with_min_len(ROWS).filter(|pair| pair[1] < pair[0]).count();
        falls as f64 / points.len().max(1) as f64
    }

    /// Puts the points that were noted in order; those of a cell keep theirs.
    pub fn sort(&mut self) {
        self.keyed.par_sort_unstable();
    }

    /// Rearranges one entry a point: what stood at the place of the curve's first point comes first. `memory`
    /// may hold anything.
    pub fn apply<T: Copy + Send + Sync>(&self, values: &mut Vec<T>, memory: &mut Vec<T>) {
        assert_eq!(values.len(), self.keyed.len(), "an entry a point");
        memory.clear();
        memory.extend(self.keyed.iter().map(|keyed| values[*keyed as u32 as usize]));
        std::mem::swap(values, memory);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_take_the_bits_of_the_coordinates_in_turn() {
        let at = |x: f64, y: f64| key(&Vector::<2>::from([x, y]), &Vector::zeros(), 1.0);
        assert_eq!([at(0.5, 0.5), at(1.5, 0.5), at(0.5, 1.5), at(3.0, 1.0)], [0, 1, 2, 0b111]);
        let at = |x: f64, y: f64, z: f64| key(&Vector::<3>::from([x, y, z]), &Vector::zeros(), 1.0);
        assert_eq!([at(1.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(0.0, 0.0, 1.0)], [1, 2, 4]);
        assert_eq!(at(1023.0, 1023.0, 1023.0), (1 << 30) - 1);
        assert_eq!(at(512.0, 0.0, 256.0), 1 << 27 | 1 << 26);
    }

    #[test]
    fn what_lies_outside_counts_as_in_the_outermost_cell() {
        let at = |x: f64, y: f64| key(&Vector::<2>::from([x, y]), &Vector::zeros(), 0.5);
        assert_eq!(at(-3.0, f64::NAN), 0);
        assert_eq!(at(1e9, f64::INFINITY), u32::MAX);
    }

    #[test]
    fn sorting_brings_the_points_of_a_square_into_z_shape() {
        let points = [[1.5, 1.5], [0.5, 0.5], [0.5, 1.5], [1.5, 0.5], [0.6, 0.4]].map(Vector::<2>::from);
        let mut order = CurveOrder::default();
        assert_eq!(order.note(&points, &Vector::zeros(), 1.0), 3.0 / 5.0);
        order.sort();
        let (mut names, mut memory) = (vec!['d', 'a', 'c', 'b', 'e'], Vec::new());
        order.apply(&mut names, &mut memory);
        assert_eq!(names, ['a', 'e', 'b', 'c', 'd']);
    }
}
