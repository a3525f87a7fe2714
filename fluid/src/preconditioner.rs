//! The preconditioner of both solves of a step: the one place where it is chosen, set up and applied.

use crate::multigrid::{self, Multigrid};
use crate::options::Preconditioner;
use crate::pressure_operator::PressureOperator;
use rayon::prelude::*;

/// A preconditioner for one step's operator. Made anew each step from that step's matrix alone, so that no result depends on steps before.
#[derive(Debug, Default)]
pub struct PressurePreconditioner {
    inverse_diagonal: Vec<f64>,
    multigrid: Option<Multigrid>,
    by_multigrid: bool,
}

impl PressurePreconditioner {
    /// Sets up for `operator`, whose diagonal is `diagonal`. The multigrid's matrix is the compact Laplacian between unknown pressures, with
    /// the operator's extra diagonal and, for the wide operator, its reaction, the square of the force of a
    /// constant pressure (see [`multigrid::Options::WIDE_OPERATOR`]), all times ρ.
    pub fn prepare<const D: usize>(
        &mut self,
        kind: Preconditioner,
        operator: &PressureOperator<'_, D>,
        diagonal: &[f64],
    ) {
        self.by_multigrid = kind == Preconditioner::Multigrid;
        if !self.by_multigrid {
            self.inverse_diagonal.clear();
            self.inverse_diagonal.extend(diagonal.iter().map(|d| if *d > 0.0 { 1.0 / d } else { 0.0 }));
            return;
        }
        let wide = operator.wide_share > 0.0;
        let multigrid = self.multigrid.get_or_insert_with(|| {
            Multigrid::new(if wide {
                multigrid::Options::WIDE_OPERATOR
            } else {
                multigrid::Options::SAME_OPERATOR
            })
        });
        let (list, free) = (&operator.neighbourhood.fluid, operator.free);
        multigrid.rebuild_rows(list.offsets(), |a, row| {
            if !free[a] {
                return 1.0;
            }
            let sums = &operator.neighbourhood.surroundings[a];
            let one_sided = (sums.fluid_gradient + sums.boundary_gradient) * 2.0;
            let reaction = operator.wide_share * one_sided.norm_squared();
            let mut total = operator.extra_diagonal[a] / operator.inverse_density + reaction;
            for (&b, pair) in list.of(a).iter().zip(&operator.neighbourhood.fluid_pairs[list.range(a)]) {
                total += pair.stiffness();
                if free[b as usize] {
                    row.push(b, -pair.stiffness());
                }
            }
            total
        });
    }

    /// `z ≈ A⁻¹ r` up to a factor.
    pub fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        if let (true, Some(multigrid)) = (self.by_multigrid, &mut self.multigrid) {
            multigrid.apply(r, z);
        } else {
            z.par_iter_mut()
                .with_min_len(4096)
                .zip(r)
                .zip(&self.inverse_diagonal)
                .for_each(|((z, r), d)| *z = r * d);
        }
    }
}
