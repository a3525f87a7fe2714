//! The gradient of the pressure along boundaries, carried onto their points.
//!
//! A boundary without unknowns of its own takes the pressure of the particle that meets it, `p_s = p_a`. The
//! symmetric gradient then sees, of a pressure that varies along the boundary, only what is among fluid
//! particles: 0.79 of it in the first layer (cubic spline, `h = 1.2 Δx`, lattice), whatever Δx. Beside a
//! standing face the missing fifth lets still water fall by 0.21 g. Here
//!
//! `p_s = p_a + G_a·P_s (r_s − r_a)`, `G_a = K_a Σ_b V (p_b − p_a) ∇W_ab`, `K_a = (Σ_b V ∇W_ab ⊗ r_ba)⁻¹`,
//! `P_s = 1 − n nᵀ`,
//!
//! with sums over fluid and `n` across the boundary that `s` belongs to, as the particle sees it: exact for
//! linear pressures along it. Each wall and the structure have an `n` of their own: at the foot of a face
//! that stands on a bed the gradient along the face is none of the bed's. Across, the pressure stays that of
//! the particle: carried there, too, the gradient would be exact and its transpose, the divergence, wrong by
//! as much in the first layer. For the same reason a wall's particle that is [tied](crate::boundaries::ties)
//! to the structure carries only what is along both.
//!
//! In the particle's row this is a matrix, `T_a = 1 + M_a K_a` with `M_a = Σ_s V_s ∇W_as ⊗ P_s r_sa`, before
//! the sum over its fluid neighbours; in the divergence of its neighbours it is `T_aᵀ` before its velocity.

use crate::particles::neighbourhood::Neighbourhood;
use rayon::prelude::*;
use sph::{Matrix, Vector, tensor};

/// What a particle beside a boundary carries.
#[derive(Clone, Copy, Debug)]
pub struct Row<const D: usize> {
    /// The particle.
    pub particle: u32,
    /// Across the structure's surface: a unit vector, or zero.
    normal: Vector<D>,
    /// `K_a`.
    along: Matrix<D>,
    /// How far the fluid around it tells a gradient at all, 0 to 1; a part of `K_a`.
    pub trust: f64,
    /// `T_a`.
    pub transfer: Matrix<D>,
}

impl<const D: usize> Row<D> {
    /// `P_s r` of an offset (m) to a point of the structure; of a tie's, along the wall, too, whose unit normal
    /// is `tie`, zero where there is none.
    #[inline]
    pub fn along_structure(&self, offset: &Vector<D>, tie: &Vector<D>) -> Vector<D> {
        along(&self.normal, &along(tie, offset))
    }
}

/// What of an offset is along a surface.
#[inline]
fn along<const D: usize>(normal: &Vector<D>, offset: &Vector<D>) -> Vector<D> {
    offset - normal * normal.dot(offset)
}

/// Particles beside boundaries along which the pressure's gradient is carried.
#[derive(Clone, Debug, Default)]
pub struct Along<const D: usize> {
    row_of: Vec<u32>,
    /// One entry per such particle.
    pub rows: Vec<Row<D>>,
    /// `P_w r_wa` (m) of pairs of fluid and wall; nothing where there is no row.
    wall_offsets: Vec<Vector<D>>,
    /// Where a wall's pairs are the structure's, the sum of these for each particle (1/m).
    tied: Vec<Vector<D>>,
}

const NONE: u32 = u32::MAX;

/// Smallest eigenvalue of `Σ_b V ∇W_ab ⊗ r_ba` below which nothing is carried, and from which on all is. A
/// particle at a face and at the free surface has 0.25 on the lattice, one of a film of one layer 0.
const TRUSTED: (f64, f64) = (0.08, 0.16);

impl<const D: usize> Along<D> {
    /// Finds the rows of the particles for which `counts` holds. `structure_normals` are out of the structure
    /// at each of its points, zero deep inside; `wall_normal` is out of a wall, the particle and one of that
    /// wall's particles given.
    pub fn find(
        &mut self,
        neighbourhood: &Neighbourhood<D>,
        counts: impl Fn(usize) -> bool,
        structure_normals: &[Vector<D>],
        mut wall_normal: impl FnMut(usize, usize) -> Vector<D>,
    ) {
        let sums = &neighbourhood.surroundings;
        self.row_of.clear();
        self.row_of.resize(sums.len(), NONE);
        self.rows.clear();
        self.wall_offsets.clear();
        self.tied.clear();
        if !neighbourhood.tied.is_empty() {
            self.tied.resize(sums.len(), Vector::zeros());
            neighbourhood.tied.iter().for_each(|pair| self.tied[pair.particle as usize] += pair.gradient);
        }
        for (a, sums) in sums.iter().enumerate() {
            if !counts(a) {
                continue;
            }
            let fluid = sums.moment - sums.boundary_moment;
            let smallest = tensor::smallest_eigenvalue(&fluid);
            let trust = ((smallest - TRUSTED.0) / (TRUSTED.1 - TRUSTED.0)).clamp(0.0, 1.0);
            let Some(inverse) = tensor::inverse(&fluid).filter(|_| trust > 0.0) else { continue };
            self.wall_offsets.resize(neighbourhood.wall_offsets.len(), Vector::zeros());
            let mut moment = Matrix::zeros();
            for (e, &w) in neighbourhood.walls.range(a).zip(neighbourhood.walls.of(a)) {
                let offset = along(&wall_normal(a, w as usize), &neighbourhood.wall_offsets[e]);
                moment += tensor::outer(&neighbourhood.wall_gradients[e], &offset);
                self.wall_offsets[e] = offset;
            }
            let tied = self.tied.get(a).and_then(|sum| sum.try_normalize(0.0));
            let normal = tied.unwrap_or_else(|| structure_normal(neighbourhood, structure_normals, a));
            for e in neighbourhood.structure.range(a) {
                let along_wall = along(&neighbourhood.structure_ties[e], &neighbourhood.structure_offsets[e]);
                let offset = along(&normal, &along_wall);
                moment += tensor::outer(&neighbourhood.structure_gradients[e], &offset);
            }
            self.row_of[a] = self.rows.len() as u32;
            let along = inverse * trust;
            let transfer = Matrix::identity() + moment * along;
            self.rows.push(Row { particle: a as u32, normal, along, trust, transfer });
        }
        // What of a wall is the structure's is among its pairs.
        for pair in &neighbourhood.tied {
            if let Some(row) = self.index(pair.particle as usize) {
                let of_wall = tensor::outer(&pair.gradient, &self.wall_offsets[pair.pair as usize]);
                let row = &mut self.rows[row];
                row.transfer -= of_wall * row.along;
            }
        }
    }

    /// `P_w r_wa` (m) of a pair of fluid and wall, of a particle that has a row.
    #[inline]
    pub fn wall_offset(&self, pair: usize) -> &Vector<D> {
        &self.wall_offsets[pair]
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

    /// Makes of the particles' velocities (m/s) what enters their neighbours' divergence,
    /// `T_aᵀ u_a − z_a`, `z_a = K_aᵀ Σ_s V_s P_s r_sa (∇W_as·u_s)`; `own_terms` keeps each row's own part,
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
            let lever = row.along.transpose() * boundaries.lever(neighbourhood, self, row);
            own_terms
                .push(own[a].dot(&velocities[a]) + lever.dot(&neighbourhood.surroundings[a].fluid_gradient));
            velocities[a] = row.transfer.transpose() * velocities[a] - lever;
        }
    }
}

/// Across the structure's surface where particle `a` meets it: the mean of the normals around it, by the weight
/// that each has in the gradient; of a structure without any, such as one of a single layer, the direction of
/// that gradient. (Beside walls on which it stands a tie tells it: at a foot the structure's own normals are
/// aslant.)
fn structure_normal<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    normals: &[Vector<D>],
    a: usize,
) -> Vector<D> {
    let list = &neighbourhood.structure;
    let (mut mean, mut sum) = (Vector::zeros(), Vector::zeros());
    for (&s, gradient) in list.of(a).iter().zip(&neighbourhood.structure_gradients[list.range(a)]) {
        mean += normals[s as usize] * gradient.norm();
        sum += gradient;
    }
    mean.try_normalize(0.0).or_else(|| sum.try_normalize(0.0)).unwrap_or_else(Vector::zeros)
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
    /// `Σ_s V_s P_s r_sa (∇W_as·u_s)` (m/s) over all boundaries.
    fn lever(&self, neighbourhood: &Neighbourhood<D>, along: &Along<D>, row: &Row<D>) -> Vector<D> {
        let (mut sum, a) = (Vector::zeros(), row.particle as usize);
        if !self.walls.is_empty() {
            for e in neighbourhood.walls.range(a) {
                sum += along.wall_offset(e) * neighbourhood.wall_gradients[e].dot(&self.walls[e]);
            }
        }
        if !self.structure.is_empty() {
            let list = &neighbourhood.structure;
            for (e, &s) in list.range(a).zip(list.of(a)) {
                let rate = neighbourhood.structure_gradients[e].dot(&self.structure[s as usize]);
                let (offset, tie) = (&neighbourhood.structure_offsets[e], &neighbourhood.structure_ties[e]);
                sum += row.along_structure(offset, tie) * rate;
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
