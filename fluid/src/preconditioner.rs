//! The preconditioner of both solves of a step: the one place where it is chosen, set up and applied.

use crate::multigrid::{self, Multigrid};
use crate::neighbourhood::Neighbourhood;
use crate::options::{Options, Preconditioner, Scheme};
use rayon::prelude::*;
use sph::Vector;

/// A preconditioner for one step's operator. Made anew each step from that step's matrix alone, so that no result depends on steps before.
#[derive(Debug, Default)]
pub struct PressurePreconditioner {
    inverse_diagonal: Vec<f64>,
    offsets: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<f64>,
    multigrid: Option<Multigrid>,
    by_multigrid: bool,
}

impl PressurePreconditioner {
    /// Sets up. The multigrid's matrix is the compact Laplacian between unknown pressures, with the operator's extra diagonal and, for the
    /// wide operator, its reaction `|own|²` (see [`multigrid::Options::WIDE_OPERATOR`]), all times ρ. `diagonal` is the operator's.
    pub fn prepare<const D: usize>(
        &mut self,
        options: &Options,
        neighbourhood: &Neighbourhood<D>,
        own: &[Vector<D>],
        density: f64,
        extra_diagonal: &[f64],
        diagonal: &[f64],
        free: &[bool],
    ) {
        self.by_multigrid = options.preconditioner == Preconditioner::Multigrid;
        if !self.by_multigrid {
            self.inverse_diagonal.clear();
            self.inverse_diagonal.extend(diagonal.iter().map(|d| if *d > 0.0 { 1.0 / d } else { 0.0 }));
            return;
        }
        let wide = options.scheme == Scheme::EnergyConsistent;
        let list = &neighbourhood.fluid;
        self.offsets.clear();
        self.columns.clear();
        self.values.clear();
        self.offsets.push(0);
        for a in 0..list.len() {
            if free[a] {
                let reaction = if wide { own[a].norm_squared() } else { 0.0 };
                let mut total = density * extra_diagonal[a] + reaction;
                for (&b, pair) in list.of(a).iter().zip(&neighbourhood.fluid_pairs[list.range(a)]) {
                    total += pair.stiffness;
                    if free[b as usize] {
                        self.columns.push(b);
                        self.values.push(-pair.stiffness);
                    }
                }
                self.columns.push(a as u32);
                self.values.push(total);
            } else {
                self.columns.push(a as u32);
                self.values.push(1.0);
            }
            self.offsets.push(self.columns.len() as u32);
        }
        let kind = if wide { multigrid::Options::WIDE_OPERATOR } else { multigrid::Options::SAME_OPERATOR };
        let multigrid = self.multigrid.get_or_insert_with(|| Multigrid::new(kind));
        multigrid.rebuild(&self.offsets, &self.columns, &self.values);
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
