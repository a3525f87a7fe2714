//! Taylor correction of the fields after shifting, Eqs. (20), (31), (32), (47): an option, off by default.
//!
//! At ragged surfaces it adds energy: see the table of deviations in the crate's documentation.

use crate::particles::neighbourhood::Neighbourhood;
use rayon::prelude::*;
use sph::{Matrix, Vector, tensor};

/// `A' = A + δr·⟨∇A⟩` for velocity and pressure with the corrected gradient of Eq. (2) over fluid neighbours.
pub fn correct_fields<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    corrections: &[(Matrix<D>, f64)],
    shifts: &[Vector<D>],
    velocities: &mut [Vector<D>],
    pressures: &mut [f64],
) {
    let list = &neighbourhood.fluid;
    let changes: Vec<(Vector<D>, f64)> = (0..shifts.len())
        .into_par_iter()
        .with_min_len(256)
        .map(|a| {
            let (mut gradient_u, mut gradient_p) = (Matrix::<D>::zeros(), Vector::<D>::zeros());
            for (&b, pair) in list.of(a).iter().zip(&neighbourhood.fluid_pairs[list.range(a)]) {
                let b = b as usize;
                gradient_u += tensor::outer(&(velocities[b] - velocities[a]), &pair.gradient());
                gradient_p += pair.gradient() * (pressures[b] - pressures[a]);
            }
            let step = corrections[a].0.transpose() * shifts[a];
            (gradient_u * step, gradient_p.dot(&step))
        })
        .collect();
    for ((u, p), (du, dp)) in velocities.iter_mut().zip(pressures).zip(changes) {
        *u += du;
        *p += dp;
    }
}
