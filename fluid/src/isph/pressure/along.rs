//! The gradient of the pressure along boundaries, carried onto their points.
//!
//! A boundary without unknowns of its own takes the pressure of the particle that meets it, `p_s = p_a`. The
//! symmetric gradient then sees, of a pressure that varies along the boundary, only what is among fluid
//! particles: 0.79 of it in the first layer (cubic spline, `h = 1.2 Δx`, lattice), whatever Δx. Beside a
//! standing face the missing fifth lets still water fall by 0.21 g. Here
//!
//! `p_s = p_a + G_a·(r_s − r_a)`, `G_a = K_a Σ_b V (p_b − p_a) ∇W_ab`,
//! `K_a = (1 − n nᵀ) (Σ_b V ∇W_ab ⊗ r_ba)⁻¹`,
//!
//! with sums over fluid and `n` across the boundary: exact for linear pressures along it. Across it the
//! pressure stays that of the particle: carried there, too, the gradient would be exact and its transpose,
//! the divergence, wrong by as much in the first layer.
//!
//! In the particle's row this is a matrix, `T_a = 1 + M_a K_a` with `M_a = Σ_s V_s ∇W_as ⊗ r_sa`, before the
//! sum over its fluid neighbours; in the divergence of its neighbours it is `T_aᵀ` before its velocity.

use crate::particles::neighbourhood::Neighbourhood;
use rayon::prelude::*;
use sph::{Matrix, Vector, tensor};

/// What a particle beside a boundary carries.
#[derive(Clone, Copy, Debug)]
pub struct Row<const D: usize> {
    /// The particle.
    pub particle: u32,
    /// Unit normal into the boundary.
    pub normal: Vector<D>,
    /// `K_a`.
    pub along: Matrix<D>,
    /// How far the fluid around it tells a gradient at all, 0 to 1; a part of `K_a`.
    pub trust: f64,
    /// `T_a`.
    pub transfer: Matrix<D>,
}

/// Particles beside boundaries along which the pressure's gradient is carried.
#[derive(Clone, Debug, Default)]
pub struct Along<const D: usize> {
    row_of: Vec<u32>,
    /// One entry per such particle.
    pub rows: Vec<Row<D>>,
}

const NONE: u32 = u32::MAX;

/// Smallest eigenvalue of `Σ_b V ∇W_ab ⊗ r_ba` below which nothing is carried, and from which on all is. A
/// particle at a face and at the free surface has 0.25 on the lattice, one of a film of one layer 0.
const TRUSTED: (f64, f64) = (0.08, 0.16);

impl<const D: usize> Along<D> {
    /// Finds the rows of the particles for which `counts` holds.
    pub fn find(&mut self, neighbourhood: &Neighbourhood<D>, counts: impl Fn(usize) -> bool) {
        let sums = &neighbourhood.surroundings;
        self.row_of.clear();
        self.row_of.resize(sums.len(), NONE);
        self.rows.clear();
        for (a, sums) in sums.iter().enumerate() {
            if !counts(a) {
                continue;
            }
            let fluid = sums.moment - sums.boundary_moment;
            let smallest = tensor::smallest_eigenvalue(&fluid);
            let trust = ((smallest - TRUSTED.0) / (TRUSTED.1 - TRUSTED.0)).clamp(0.0, 1.0);
            let normal = sums.boundary_gradient.try_normalize(0.0);
            let (Some(n), Some(inverse)) = (normal.filter(|_| trust > 0.0), tensor::inverse(&fluid)) else {
                continue;
            };
            let along = (Matrix::identity() - tensor::outer(&n, &n)) * inverse * trust;
            let transfer = Matrix::identity() + sums.boundary_moment * along;
            self.row_of[a] = self.rows.len() as u32;
            self.rows.push(Row { particle: a as u32, normal: n, along, trust, transfer });
        }
    }

    /// Place in [`rows`](Self::rows) of particle `a`, if it carries anything.
    #[inline]
    pub fn index(&self, a: usize) -> Option<usize> {
        self.row_of.get(a).filter(|&&i| i != NONE).map(|&i| i as usize)
    }

    /// The row of particle `a`, if it has one.
    #[inline]
    pub fn of(&self, a: usize) -> Option<&Row<D>> {
        self.index(a).map(|i| &self.rows[i])
    }

    /// Completes what a particle's own pressure is multiplied by (1/m): `own_a − M_a K_a Σ_b V ∇W_ab`.
    pub fn complete_own(&self, neighbourhood: &Neighbourhood<D>, own: &mut [Vector<D>]) {
        for row in &self.rows {
            let a = row.particle as usize;
            let among_fluid = neighbourhood.surroundings[a].fluid_gradient;
            own[a] += among_fluid - row.transfer * among_fluid;
        }
    }

    /// `G_a` (Pa/m) of each row.
    pub fn gradients(&self, neighbourhood: &Neighbourhood<D>, p: &[f64], out: &mut Vec<Vector<D>>) {
        let list = &neighbourhood.fluid;
        out.resize(self.rows.len(), Vector::zeros());
        out.par_iter_mut().zip(&self.rows).with_min_len(256).for_each(|(gradient, row)| {
            let a = row.particle as usize;
            let mut sum = Vector::zeros();
            for (&b, pair) in list.of(a).iter().zip(&neighbourhood.fluid_pairs[list.range(a)]) {
                sum += pair.gradient() * (p[b as usize] - p[a]);
            }
            *gradient = row.along * sum;
        });
    }

    /// Pressure gradients (Pa/m) by which Eq. (18) carries the pressure onto boundaries, from those of
    /// [`gradients`](Self::gradients): along the boundary `G_a` as far as it is trusted, `weight = ρ (g −
    /// a_w)` (Pa/m) at the particle for the rest and across, `a_w` the acceleration of walls across their
    /// surface.
    pub fn slopes(
        &self,
        weight: impl Fn(usize) -> Vector<D>,
        gradients: &[Vector<D>],
        out: &mut Vec<Vector<D>>,
    ) {
        out.clear();
        out.extend(self.rows.iter().zip(gradients).map(|(row, gradient)| {
            let weight = weight(row.particle as usize);
            let across = row.normal * row.normal.dot(&weight);
            gradient + across + (weight - across) * (1.0 - row.trust)
        }));
    }

    /// Makes of the particles' velocities (m/s) what enters their neighbours' divergence,
    /// `T_aᵀ u_a − z_a`, `z_a = K_aᵀ Σ_s V_s r_sa (∇W_as·u_s)`; `own_terms` keeps each row's own part,
    /// `own_a·u_a + z_a·Σ_b V ∇W_ab` (1/s). Boundary velocities are empty where nothing moves.
    pub fn carry(
        &self,
        neighbourhood: &Neighbourhood<D>,
        own: &[Vector<D>],
        boundaries: &BoundaryVelocities<'_, D>,
        velocities: &mut [Vector<D>],
        own_terms: &mut Vec<f64>,
    ) {
        own_terms.clear();
        for row in &self.rows {
            let a = row.particle as usize;
            let lever = row.along.transpose() * boundaries.lever(neighbourhood, a);
            own_terms
                .push(own[a].dot(&velocities[a]) + lever.dot(&neighbourhood.surroundings[a].fluid_gradient));
            velocities[a] = row.transfer.transpose() * velocities[a] - lever;
        }
    }
}

/// Velocities of boundaries (m/s); empty where they do not move.
#[derive(Clone, Copy, Debug)]
pub struct BoundaryVelocities<'a, const D: usize> {
    /// Of walls, one entry per pair of fluid and wall.
    pub walls: &'a [Vector<D>],
    /// Of interface particles.
    pub structure: &'a [Vector<D>],
}

impl<const D: usize> BoundaryVelocities<'_, D> {
    /// `Σ_s V_s r_sa (∇W_as·u_s)` (m/s) over all boundaries.
    fn lever(&self, neighbourhood: &Neighbourhood<D>, a: usize) -> Vector<D> {
        let mut sum = Vector::zeros();
        if !self.walls.is_empty() {
            for e in neighbourhood.walls.range(a) {
                sum += neighbourhood.wall_offsets[e] * neighbourhood.wall_gradients[e].dot(&self.walls[e]);
            }
        }
        if !self.structure.is_empty() {
            let list = &neighbourhood.structure;
            for (e, &s) in list.range(a).zip(list.of(a)) {
                let rate = neighbourhood.structure_gradients[e].dot(&self.structure[s as usize]);
                sum += neighbourhood.structure_offsets[e] * rate;
            }
        }
        sum
    }

    /// `2 Σ_s V_s ∇W_as·u_s` (1/s) over all boundaries: what they give to the divergence at particle `a`.
    #[inline]
    pub fn divergence(&self, neighbourhood: &Neighbourhood<D>, a: usize) -> f64 {
        let mut sum = 0.0;
        if !self.walls.is_empty() {
            let range = neighbourhood.walls.range(a);
            let pairs = neighbourhood.wall_gradients[range.clone()].iter().zip(&self.walls[range]);
            sum += pairs.map(|(g, u)| g.dot(u)).sum::<f64>();
        }
        if !self.structure.is_empty() {
            let list = &neighbourhood.structure;
            let pairs = list.of(a).iter().zip(&neighbourhood.structure_gradients[list.range(a)]);
            sum += pairs.map(|(&s, g)| g.dot(&self.structure[s as usize])).sum::<f64>();
        }
        2.0 * sum
    }
}
