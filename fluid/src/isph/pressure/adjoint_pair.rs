//! Divergence and gradient, each the negative transpose of the other.
//!
//! The divergence is `D_a u = Σ_b V (u_b − u_a)·∇W_ab + 2 Σ_s V_s (u_s − u_a)·∇W_as`, over fluid `b` and the
//! points `s` of walls and structure, and the forces are its transpose:
//!
//! `a_a = −(1/ρ) Σ_b V (p_a + p_b) ∇W_ab − (1/ρ) Σ_s V_s (p_a + p_s) ∇W_as` in the fluid and
//! `g_s = Σ_a V (p_a + p_s) ∇W_sa` on the structure, `p_s = p_a`.
//!
//! Beside boundaries where [`along`](super::along) has a row, `p_s = p_a + G_a·P_s (r_s − r_a)`, and the
//! divergence is the transpose of that. So `V Σ p_a D_a u = m Σ u_a·a_a − Σ V_s u_s·g_s` to rounding,
//! whatever the pressures and velocities, and a translation of everything has no divergence.

use super::along::{Along, BoundaryVelocities, Row};
use crate::particles::neighbourhood::{Neighbourhood, Pair};
use rayon::prelude::*;
use sph::Vector;

/// Rows that one task works through at least.
pub(super) const ROWS: usize = 128;

/// What both are made of.
#[derive(Clone, Copy)]
pub struct AdjointPair<'a, const D: usize> {
    /// Lists and gradients.
    pub neighbourhood: &'a Neighbourhood<D>,
    /// What boundaries carry of the pressure's gradient.
    pub along: &'a Along<D>,
    /// What a particle's own pressure is multiplied by, [`own_gradients`] (1/m).
    pub own: &'a [Vector<D>],
}

/// `Σ_b V ∇W_ab + 2 Σ_s V_s ∇W_as` of every particle, with what `along` takes of it.
pub fn own_gradients<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    along: &Along<D>,
    out: &mut Vec<Vector<D>>,
) {
    let sums = &neighbourhood.surroundings;
    out.resize(sums.len(), Vector::zeros());
    out.par_iter_mut().with_min_len(1024).zip(sums).for_each(|(own, s)| {
        *own = s.fluid_gradient + s.boundary_gradient * 2.0;
    });
    along.complete_own(neighbourhood, out);
}

/// The fluid's acceleration by pressure in one row: `−(1/ρ) (p_a own_a + T_a Σ_b p_b V∇W_ab)`.
#[inline]
fn row_acceleration<const D: usize>(
    (neighbours, pairs): (&[u32], &[Pair<D>]),
    (own, row): (&Vector<D>, Option<&Row<D>>),
    p: &[f64],
    p_a: f64,
    inverse_density: f64,
) -> Vector<D> {
    let start = if row.is_some() { Vector::zeros() } else { own * p_a };
    let mut sum = start;
    for (&b, pair) in neighbours.iter().zip(pairs) {
        sum += pair.gradient() * p[b as usize];
    }
    if let Some(row) = row {
        sum = row.transfer * sum + own * p_a;
    }
    sum * -inverse_density
}

impl<const D: usize> AdjointPair<'_, D> {
    /// Accelerations of the fluid by pressure (m/s²).
    pub fn accelerations(&self, inverse_density: f64, p: &[f64], out: &mut Vec<Vector<D>>) {
        out.resize(p.len(), Vector::zeros());
        out.par_iter_mut().with_min_len(ROWS).enumerate().for_each(|(a, acceleration)| {
            let list = &self.neighbourhood.fluid;
            let pairs = (list.of(a), &self.neighbourhood.fluid_pairs[list.range(a)]);
            let own = (&self.own[a], self.along.of(a));
            *acceleration = row_acceleration(pairs, own, p, p[a], inverse_density);
        });
    }

    /// The pressure gradient `g_s` that loads the structure (Pa/m): the force on particle s is `−V_s g_s`.
    /// `gradients` becomes `G_a` (Pa/m) of each row of `along`.
    pub fn structure_gradients(&self, p: &[f64], gradients: &mut Vec<Vector<D>>, out: &mut Vec<Vector<D>>) {
        let neighbourhood = self.neighbourhood;
        let list = &neighbourhood.fluid_of_structure;
        self.along.gradients(neighbourhood, p, gradients);
        let gradients = &*gradients;
        out.resize(list.len(), Vector::zeros());
        out.par_iter_mut().with_min_len(ROWS).enumerate().for_each(|(s, gradient)| {
            let mut sum = Vector::zeros();
            for (e, &a) in list.range(s).zip(list.of(s)) {
                let a = a as usize;
                let offset = &neighbourhood.fluid_of_structure_offsets[e];
                let tie = &neighbourhood.fluid_of_structure_ties[e];
                let carried = self
                    .along
                    .index(a)
                    .map_or(0.0, |i| gradients[i].dot(&self.along.rows[i].along_structure(offset, tie)));
                sum += neighbourhood.fluid_of_structure_gradients[e] * (2.0 * p[a] + carried);
            }
            *gradient = sum;
        });
    }

    /// `D_a u` of every particle (1/s). `velocities` (m/s) become what [`Along::carry`] makes of them,
    /// `own_terms` is memory.
    pub fn divergence(
        &self,
        velocities: &mut [Vector<D>],
        boundaries: &BoundaryVelocities<'_, D>,
        own_terms: &mut Vec<f64>,
        out: &mut Vec<f64>,
    ) {
        out.resize(velocities.len(), 0.0);
        self.along.carry(self.neighbourhood, self.own, boundaries, velocities, own_terms);
        let (carried, own_terms) = (&*velocities, &*own_terms);
        out.par_iter_mut().with_min_len(ROWS).enumerate().for_each(|(a, divergence)| {
            *divergence = self.row_divergence(carried, own_terms, boundaries, a);
        });
    }

    /// One row of it, of velocities that were carried.
    #[inline]
    pub(super) fn row_divergence(
        &self,
        carried: &[Vector<D>],
        own_terms: &[f64],
        boundaries: &BoundaryVelocities<'_, D>,
        a: usize,
    ) -> f64 {
        let list = &self.neighbourhood.fluid;
        let pairs = &self.neighbourhood.fluid_pairs[list.range(a)];
        let own = self.along.index(a).map_or_else(|| self.own[a].dot(&carried[a]), |i| own_terms[i]);
        let mut sum = -own;
        for (&b, pair) in list.of(a).iter().zip(pairs) {
            sum += pair.gradient().dot(&carried[b as usize]);
        }
        sum + boundaries.divergence(self.neighbourhood, a)
    }
}
