//! Whether the iterations of a window have converged.

use crate::flat::dot;
use std::ops::Range;

/// Limits on the residual `r = y − x` of one iteration, each left out where it is none. Norms are Euclidean,
/// over one quantity (load, velocity).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measures {
    /// `‖r‖ ≤ absolute`, in the unit of the quantity: Pa/m for the load. A velocity is not held to it.
    pub absolute: Option<f64>,
    /// `‖r‖ ≤ relative · ‖y‖`.
    pub relative: Option<f64>,
    /// `‖r‖ ≤ residual_relative · ‖r₀‖`, with the residual of the window's first iteration.
    pub residual_relative: Option<f64>,
    /// Whether all measures that are given must hold, or any of them is enough.
    pub all: bool,
}

/// What an iteration left, per quantity the worst.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// `‖r‖` of the load (Pa/m).
    pub absolute: f64,
    /// The largest `‖r‖/‖y‖` of the quantities; zero where there is no residual.
    pub relative: f64,
    /// The largest `‖r‖/‖r₀‖` of the quantities.
    pub of_first: f64,
    /// Whether the measures hold.
    pub converged: bool,
}

impl Measures {
    /// Judges the residual `r` of the image `y`, block by block: the load first. `first` holds the norms of
    /// the window's first residual, one a block, and is filled by its first iteration.
    pub fn judge(&self, blocks: &[Range<usize>], y: &[f64], r: &[f64], first: &mut Vec<f64>) -> Residual {
        let norm = |of: &[f64], block: &Range<usize>| dot(&of[block.clone()], &of[block.clone()]).sqrt();
        if first.is_empty() {
            first.extend(blocks.iter().map(|block| norm(r, block)));
        }
        let mut worst = Residual { absolute: 0.0, relative: 0.0, of_first: 0.0, converged: true };
        for (index, (block, first)) in blocks.iter().zip(first).enumerate() {
            let (left, image) = (norm(r, block), norm(y, block));
            let held = [
                self.absolute.filter(|_| index == 0).map(|limit| left <= limit),
                self.relative.map(|limit| left <= limit * image),
                self.residual_relative.map(|limit| left <= limit * *first),
            ];
            let mut held = held.into_iter().flatten();
            worst.converged &=
                left == 0.0 || if self.all { held.all(|held| held) } else { held.any(|held| held) };
            if index == 0 {
                worst.absolute = left;
            }
            worst.relative = worst.relative.max(share(left, image));
            worst.of_first = worst.of_first.max(share(left, *first));
        }
        worst
    }
}

fn share(part: f64, whole: f64) -> f64 {
    if part == 0.0 { 0.0 } else { part / whole }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLOCKS: [Range<usize>; 2] = [0..2, 2..3];

    /// Load (30, 40) with residual (3, 4): 5 of 50. Velocity 2 with residual 1: a half.
    fn judge(measures: Measures, first: &mut Vec<f64>) -> Residual {
        measures.judge(&BLOCKS, &[30.0, 40.0, 2.0], &[3.0, 4.0, 1.0], first)
    }

    const NONE: Measures = Measures { absolute: None, relative: None, residual_relative: None, all: false };

    #[test]
    fn norms_by_hand() {
        let found = judge(NONE, &mut Vec::new());
        assert_eq!(found, Residual { absolute: 5.0, relative: 0.5, of_first: 1.0, converged: false });
        assert_eq!(judge(NONE, &mut vec![50.0, 1.25]).of_first, 0.8);
    }

    #[test]
    fn every_quantity_is_held_to_its_measures() {
        let mut first = vec![50.0, 10.0];
        let mut converged = |measures| judge(measures, &mut first).converged;
        assert!(!converged(Measures { relative: Some(0.1), ..NONE }), "the velocity is not");
        assert!(converged(Measures { relative: Some(0.5), ..NONE }));
        assert!(converged(Measures { residual_relative: Some(0.1), ..NONE }));
        assert!(!converged(Measures {
            residual_relative: Some(0.1),
            relative: Some(0.1),
            all: true,
            ..NONE
        }));
        assert!(converged(Measures { residual_relative: Some(0.1), relative: Some(0.1), ..NONE }));
        // 5 Pa/m are enough for the load; the velocity has to meet another measure.
        assert!(converged(Measures { absolute: Some(5.0), relative: Some(0.5), ..NONE }));
        assert!(!converged(Measures { absolute: Some(5.0), relative: Some(0.1), ..NONE }));
    }

    #[test]
    fn nothing_left_is_converged_by_every_measure_and_what_is_no_number_by_none() {
        let (one, mut first) = (BLOCKS.split_at(1).0, Vec::new());
        let measures = Measures { absolute: Some(1.0), relative: Some(1e-3), ..NONE };
        assert!(measures.judge(one, &[0.0; 2], &[0.0; 2], &mut first).converged);
        assert!(!measures.judge(one, &[1.0; 2], &[f64::NAN, 0.0], &mut first).converged);
    }
}
