//! The operator of the pressure Poisson equation, in factored form.
//!
//! With the divergence
//! `D_a u = Σ_b V (u_b − u_a)·∇W_ab + 2 Σ_w V_w (u_w − u_a)·∇W_aw + 2 Σ_s V_s (u_s − u_a)·∇W_as` and its
//! transpose as force, the accelerations that a pressure causes are
//!
//! `a_a = −(1/ρ) [Σ_b V (p_a + p_b) ∇W_ab + 2 p_a Σ_w V_w ∇W_aw + 2 p_a Σ_s V_s ∇W_as]` in the fluid and
//! `a_s = −(2/ρ_s) Σ_a V p_a ∇W_sa` in the structure,
//!
//! and `A p = D a(p)`, so that `V pᵀ A p` is the kinetic energy that the pressure's impulse over a unit of
//! time carries (twice it): symmetric and never negative. Walls (and a structure without compliance) do not
//! move. To `A` are added a share of the compact Laplacian `L p = (1/ρ) Σ_b stiffness_ab (p_a − p_b)`, a
//! compressibility κ, and `A_aa (1/α − 1)`, which is Eq. (16) divided by its α.

use crate::particles::neighbourhood::{Neighbourhood, Pair};
use rayon::prelude::*;
use sph::Vector;

/// Rows that one task works through at least.
const ROWS: usize = 128;

/// What the operator is made of, one entry a fluid particle unless it says otherwise.
pub struct PressureOperator<'a, const D: usize> {
    /// Lists and gradients.
    pub neighbourhood: &'a Neighbourhood<D>,
    /// `Σ_b V ∇W_ab + 2 Σ_w V_w ∇W_aw + 2 Σ_s V_s ∇W_as` (1/m).
    pub own: &'a [Vector<D>],
    /// `1/ρ` (m³/kg).
    pub inverse_density: f64,
    /// `1/ρ_s` of each interface particle (m³/kg); empty where the structure does not yield.
    pub compliance: &'a [f64],
    /// Share of the compact Laplacian.
    pub laplacian_share: f64,
    /// Share of `D M⁻¹ Dᵀ`: 1, or 0 for the paper's scheme.
    pub wide_share: f64,
    /// Added to the diagonal (m³/kg/m²).
    pub extra_diagonal: &'a [f64],
    /// Whether a pressure is unknown; others' rows are zero.
    pub free: &'a [bool],
}

/// Memory for applying the operator.
#[derive(Clone, Debug, Default)]
pub struct OperatorScratch<const D: usize> {
    /// Accelerations of the fluid (m/s²).
    pub fluid: Vec<Vector<D>>,
    /// Accelerations of the structure (m/s²).
    pub structure: Vec<Vector<D>>,
}

/// `Σ_b V ∇W_ab + 2 (walls and structure)` of every particle.
pub fn own_gradients<const D: usize>(neighbourhood: &Neighbourhood<D>, out: &mut Vec<Vector<D>>) {
    let sums = &neighbourhood.surroundings;
    out.resize(sums.len(), Vector::zeros());
    out.par_iter_mut().with_min_len(1024).zip(sums).for_each(|(own, s)| {
        *own = s.fluid_gradient + s.boundary_gradient * 2.0;
    });
}

/// The fluid's acceleration by pressure in one row: `−(1/ρ) (p_a own_a + Σ_b p_b V∇W_ab)`.
#[inline]
fn row_acceleration<const D: usize>(
    neighbours: &[u32],
    pairs: &[Pair<D>],
    own: &Vector<D>,
    p: &[f64],
    p_a: f64,
    inverse_density: f64,
) -> Vector<D> {
    let mut sum = own * p_a;
    for (&b, pair) in neighbours.iter().zip(pairs) {
        sum += pair.gradient() * p[b as usize];
    }
    sum * -inverse_density
}

/// Accelerations of the fluid by pressure, `−(1/ρ) Σ (p_a + p_b) V∇W` with walls and structure at `2 p_a`
/// (m/s²).
pub fn fluid_accelerations<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    own: &[Vector<D>],
    inverse_density: f64,
    p: &[f64],
    out: &mut Vec<Vector<D>>,
) {
    out.resize(p.len(), Vector::zeros());
    out.par_iter_mut().with_min_len(ROWS).enumerate().for_each(|(a, acceleration)| {
        let list = &neighbourhood.fluid;
        let pairs = &neighbourhood.fluid_pairs[list.range(a)];
        *acceleration = row_acceleration(list.of(a), pairs, &own[a], p, p[a], inverse_density);
    });
}

/// The pressure gradient that loads the structure, `g_s = 2 Σ_a V p_a ∇W_sa` (Pa/m): the force on particle s
/// is `−V_s g_s`.
pub fn structure_gradients<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    p: &[f64],
    out: &mut Vec<Vector<D>>,
) {
    let list = &neighbourhood.fluid_of_structure;
    out.resize(list.len(), Vector::zeros());
    out.par_iter_mut().with_min_len(ROWS).enumerate().for_each(|(s, gradient)| {
        let gradients = &neighbourhood.fluid_of_structure_gradients[list.range(s)];
        let sum =
            list.of(s).iter().zip(gradients).fold(Vector::zeros(), |sum, (&a, g)| sum + g * p[a as usize]);
        *gradient = sum * 2.0;
    });
}

/// `D_a u` of every particle (1/s) for velocities of fluid, walls (`2 Σ V_w u_w·∇W_aw` given as `wall_rate`)
/// and structure.
pub fn divergence<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    own: &[Vector<D>],
    velocities: &[Vector<D>],
    wall_rate: &[f64],
    structure_velocities: &[Vector<D>],
    out: &mut Vec<f64>,
) {
    out.resize(velocities.len(), 0.0);
    out.par_iter_mut().with_min_len(ROWS).enumerate().for_each(|(a, divergence)| {
        *divergence = row_divergence(neighbourhood, own, velocities, structure_velocities, a)
            + wall_rate.get(a).copied().unwrap_or(0.0);
    });
}

#[inline]
fn row_divergence<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    own: &[Vector<D>],
    velocities: &[Vector<D>],
    structure_velocities: &[Vector<D>],
    a: usize,
) -> f64 {
    let list = &neighbourhood.fluid;
    let pairs = &neighbourhood.fluid_pairs[list.range(a)];
    let mut sum = -own[a].dot(&velocities[a]);
    for (&b, pair) in list.of(a).iter().zip(pairs) {
        sum += pair.gradient().dot(&velocities[b as usize]);
    }
    if !structure_velocities.is_empty() {
        let list = &neighbourhood.structure;
        for (&s, g) in list.of(a).iter().zip(&neighbourhood.structure_gradients[list.range(a)]) {
            sum += 2.0 * g.dot(&structure_velocities[s as usize]);
        }
    }
    sum
}

impl<const D: usize> PressureOperator<'_, D> {
    /// `out = (A + share L + diagonal) p` on unknown pressures; `p` counts everywhere, zero where it is meant
    /// to.
    pub fn apply(&self, p: &[f64], out: &mut [f64], scratch: &mut OperatorScratch<D>) {
        let neighbourhood = self.neighbourhood;
        let list = &neighbourhood.fluid;
        scratch.fluid.resize(p.len(), Vector::zeros());
        let compact = self.laplacian_share * self.inverse_density;
        scratch.fluid.par_iter_mut().zip(out.par_iter_mut()).with_min_len(ROWS).enumerate().for_each(
            |(a, (acceleration, out))| {
                let pairs = &neighbourhood.fluid_pairs[list.range(a)];
                let p_a = p[a];
                let (mut gradient, mut laplacian) = (self.own[a] * p_a, 0.0);
                for (&b, pair) in list.of(a).iter().zip(pairs) {
                    let p_b = p[b as usize];
                    gradient += pair.gradient() * p_b;
                    laplacian += pair.stiffness() * (p_a - p_b);
                }
                *acceleration = gradient * -self.inverse_density;
                *out = if self.free[a] { compact * laplacian + self.extra_diagonal[a] * p_a } else { 0.0 };
            },
        );
        if self.wide_share == 0.0 {
            return;
        }
        scratch.structure.clear();
        if !self.compliance.is_empty() {
            structure_gradients(neighbourhood, p, &mut scratch.structure);
            for (g, c) in scratch.structure.iter_mut().zip(self.compliance) {
                *g *= -c;
            }
        }
        let (fluid, structure) = (&scratch.fluid, &scratch.structure);
        out.par_iter_mut().with_min_len(ROWS).enumerate().for_each(|(a, out)| {
            if self.free[a] {
                *out += row_divergence(neighbourhood, self.own, fluid, structure, a);
            }
        });
    }

    /// Diagonal of `A + share L`, without the extra diagonal.
    pub fn diagonal(&self, out: &mut Vec<f64>) {
        let neighbourhood = self.neighbourhood;
        out.resize(self.own.len(), 0.0);
        out.par_iter_mut().with_min_len(ROWS).enumerate().for_each(|(a, out)| {
            let (mut wide, mut compact) = (self.own[a].norm_squared(), 0.0);
            for pair in &neighbourhood.fluid_pairs[neighbourhood.fluid.range(a)] {
                wide += pair.gradient().norm_squared();
                compact += pair.stiffness();
            }
            *out = self.inverse_density * (self.wide_share * wide + self.laplacian_share * compact);
        });
    }
}
