//! Taylor correction of the fields after shifting, Eqs. (20), (31), (32), (47): an option, off by default.
//!
//! At ragged surfaces it adds energy: see the departures from the paper in `docs/fluid.md`.

use crate::particles::neighbourhood::{Neighbourhood, Pair};
use rayon::prelude::*;
use sph::{Matrix, Vector, tensor};
use std::ops::AddAssign;

/// `u' = u + δr·⟨∇u⟩` with the corrected gradient of Eq. (2) over fluid neighbours and the `shifts` δr (m).
pub fn correct_velocities<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    corrections: &[(Matrix<D>, f64)],
    shifts: &[Vector<D>],
    velocities: &mut [Vector<D>],
) {
    add(velocities, |velocities, a| {
        let mut gradient = Matrix::<D>::zeros();
        for (b, pair) in pairs(neighbourhood, a) {
            gradient += tensor::outer(&(velocities[b] - velocities[a]), &pair.gradient());
        }
        gradient * (corrections[a].0.transpose() * shifts[a])
    });
}

/// `p' = p + δr·⟨∇p⟩`, likewise.
pub fn correct_pressures<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    corrections: &[(Matrix<D>, f64)],
    shifts: &[Vector<D>],
    pressures: &mut [f64],
) {
    add(pressures, |pressures, a| {
        let mut gradient = Vector::<D>::zeros();
        for (b, pair) in pairs(neighbourhood, a) {
            gradient += pair.gradient() * (pressures[b] - pressures[a]);
        }
        gradient.dot(&(corrections[a].0.transpose() * shifts[a]))
    });
}

fn pairs<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    a: usize,
) -> impl Iterator<Item = (usize, &Pair<D>)> {
    let list = &neighbourhood.fluid;
    list.of(a).iter().map(|&b| b as usize).zip(&neighbourhood.fluid_pairs[list.range(a)])
}

/// Adds to all values changes that are made of the values as they were.
fn add<T: AddAssign + Send + Sync>(values: &mut [T], change: impl Fn(&[T], usize) -> T + Sync) {
    let before = &*values;
    let changes: Vec<T> =
        (0..before.len()).into_par_iter().with_min_len(256).map(|a| change(before, a)).collect();
    values.iter_mut().zip(changes).for_each(|(value, change)| *value += change);
}
