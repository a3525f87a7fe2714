//! The operator of the pressure Poisson equation, in factored form.
//!
//! With divergence `D` and gradient of [`adjoint_pair`](super::adjoint_pair), the accelerations that a
//! pressure causes are `a_a` in the fluid and `−g_s/ρ_s` in the structure, and `A p = D a(p)`, so that
//! `V pᵀ A p` is the kinetic energy that the pressure's impulse over a unit of time carries (twice it):
//! symmetric and never negative. Walls (and a structure without compliance) do not move. To `A` are added a
//! share of the compact Laplacian `L p = (1/ρ) Σ_b stiffness_ab (p_a − p_b)`, a compressibility κ, and
//! `A_aa (1/α − 1)`, which is Eq. (16) divided by its α.

use super::adjoint_pair::{AdjointPair, ROWS};
use super::along::BoundaryVelocities;
use crate::boundaries::sampling::Sampling;
use rayon::prelude::*;
use sph::Vector;

/// What the operator is made of, one entry a fluid particle unless it says otherwise.
pub struct PressureOperator<'a, const D: usize> {
    /// Divergence and gradient.
    pub pair: AdjointPair<'a, D>,
    /// `1/ρ` (m³/kg).
    pub inverse_density: f64,
    /// How the structure yields, where it does.
    pub yielding: Option<Yielding<'a>>,
    /// Share of the compact Laplacian.
    pub pressure_stabilization: f64,
    /// Share of `D M⁻¹ Dᵀ`: 1, or 0 for the paper's scheme.
    pub wide_share: f64,
    /// Added to the diagonal (m³/kg/m²).
    pub extra_diagonal: &'a [f64],
    /// Whether a pressure is unknown; others' rows are zero.
    pub free: &'a [bool],
}

/// A structure that yields to its load.
#[derive(Clone, Copy)]
pub struct Yielding<'a> {
    /// Its boundary points.
    pub sampling: &'a Sampling,
    /// `1/ρ_s` of each interface particle, or a share of it (m³/kg).
    pub compliance: &'a [f64],
}

impl<'a> Yielding<'a> {
    /// Nothing where `compliance` is empty.
    pub fn of(sampling: &'a Sampling, compliance: &'a [f64]) -> Option<Self> {
        (!compliance.is_empty()).then_some(Self { sampling, compliance })
    }

    /// Makes accelerations (m/s²) of loads (Pa/m) on the boundary points: a load goes to the particles that
    /// carry the point, and their acceleration comes back the same way. `particles` is memory.
    pub fn accelerate<const D: usize>(&self, points: &mut Vec<Vector<D>>, particles: &mut Vec<Vector<D>>) {
        self.sampling.at_particles(points, particles);
        particles.iter_mut().zip(self.compliance).for_each(|(g, c)| *g *= -c);
        self.sampling.at_points(particles, points);
    }
}

/// Memory for applying the operator.
#[derive(Clone, Debug, Default)]
pub struct OperatorScratch<const D: usize> {
    /// Accelerations of the fluid (m/s²).
    pub fluid: Vec<Vector<D>>,
    /// Accelerations of the structure's boundary points (m/s²).
    pub structure: Vec<Vector<D>>,
    /// Those of its particles.
    pub particles: Vec<Vector<D>>,
    /// Pressure gradients along boundaries (Pa/m).
    pub gradients: Vec<Vector<D>>,
    /// What particles beside boundaries give to their own divergence (1/s).
    pub own_terms: Vec<f64>,
}

impl<const D: usize> PressureOperator<'_, D> {
    /// `out = (A + share L + diagonal) p` on unknown pressures; `p` counts everywhere, zero where it is meant
    /// to.
    pub fn apply(&self, p: &[f64], out: &mut [f64], scratch: &mut OperatorScratch<D>) {
        let AdjointPair { neighbourhood, along, own } = self.pair;
        let list = &neighbourhood.fluid;
        scratch.fluid.resize(p.len(), Vector::zeros());
        let compact = self.pressure_stabilization * self.inverse_density;
        scratch.fluid.par_iter_mut().zip(out.par_iter_mut()).with_min_len(ROWS).enumerate().for_each(
            |(a, (acceleration, out))| {
                let pairs = &neighbourhood.fluid_pairs[list.range(a)];
                let p_a = p[a];
                let row = along.of(a);
                let start = if row.is_some() { Vector::zeros() } else { own[a] * p_a };
                let (mut gradient, mut laplacian) = (start, 0.0);
                for (&b, pair) in list.of(a).iter().zip(pairs) {
                    let p_b = p[b as usize];
                    gradient += pair.gradient() * p_b;
                    laplacian += pair.stiffness() * (p_a - p_b);
                }
                if let Some(row) = row {
                    gradient = row.transfer * gradient + own[a] * p_a;
                }
                *acceleration = gradient * -self.inverse_density;
                *out = if self.free[a] { compact * laplacian + self.extra_diagonal[a] * p_a } else { 0.0 };
            },
        );
        if self.wide_share == 0.0 {
            return;
        }
        scratch.structure.clear();
        if let Some(yielding) = &self.yielding {
            self.pair.structure_gradients(p, &mut scratch.gradients, &mut scratch.structure);
            yielding.accelerate(&mut scratch.structure, &mut scratch.particles);
        }
        let boundaries = BoundaryVelocities { walls: &[], structure: &scratch.structure };
        along.carry(neighbourhood, own, &boundaries, &mut scratch.fluid, &mut scratch.own_terms);
        let (carried, own_terms) = (&*scratch.fluid, &*scratch.own_terms);
        out.par_iter_mut().with_min_len(ROWS).enumerate().for_each(|(a, out)| {
            if self.free[a] {
                *out += self.pair.row_divergence(carried, own_terms, &boundaries, a);
            }
        });
    }

    /// Diagonal of `A + share L`, without the extra diagonal.
    pub fn diagonal(&self, out: &mut Vec<f64>) {
        let AdjointPair { neighbourhood, along, own } = self.pair;
        out.resize(own.len(), 0.0);
        out.par_iter_mut().with_min_len(ROWS).enumerate().for_each(|(a, out)| {
            let (mut wide, mut compact) = (own[a].norm_squared(), 0.0);
            let list = &neighbourhood.fluid;
            for (&b, pair) in list.of(a).iter().zip(&neighbourhood.fluid_pairs[list.range(a)]) {
                let gradient = pair.gradient();
                let carried = along.of(b as usize).map_or(gradient, |row| row.transfer * gradient);
                wide += carried.norm_squared();
                compact += pair.stiffness();
            }
            *out = self.inverse_density * (self.wide_share * wide + self.pressure_stabilization * compact);
        });
    }
}
