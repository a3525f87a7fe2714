//! Forces between fluid and boundaries: what the structure gets, and what the fluid got from each of its
//! particles.

use crate::boundaries::walls::Walls;
use crate::isph::pressure::along::{Along, Row};
use crate::particles::neighbourhood::Neighbourhood;
use rayon::prelude::*;
use sph::kernel::CubicSpline;
use sph::{Matrix, Vector};

/// How pressures are carried onto boundaries.
#[derive(Clone, Copy)]
pub struct Carried<'a, const D: usize> {
    /// Particles beside boundaries.
    pub along: &'a Along<D>,
    /// `G_a` (Pa/m) of each.
    pub gradients: &'a [Vector<D>],
    /// `ρ (g − a_w)` (Pa/m) at each, `a_w` the acceleration of walls across their surface.
    pub weights: &'a [Vector<D>],
    /// `ρ g` (Pa/m), at all others.
    pub weight: Vector<D>,
    /// Share φ of Eq. (18) that moved each particle.
    pub share: &'a [f64],
    /// `B` of each.
    pub corrections: &'a [(Matrix<D>, f64)],
}

impl<const D: usize> Carried<'_, D> {
    /// What a boundary point at `offset` (m) from particle `a` is pressed with (Pa/m), `along` (m) of it
    /// along the boundary, which counts where the particle has a row; `gradient` is `V ∇W` (1/m) and
    /// `pressure` twice the particle's or nothing (Pa): `(1 − φ) (pressure + G_a·along) ∇W + φ (pressure +
    /// weight·offset) B ∇W`.
    #[inline]
    fn push(
        &self,
        a: usize,
        pressure: f64,
        gradient: &Vector<D>,
        offset: &Vector<D>,
        along: impl Fn(&Row<D>) -> Vector<D>,
    ) -> Vector<D> {
        let share = self.share[a];
        let row = self.along.index(a).map(|i| (i, along(&self.along.rows[i])));
        let carried = row.map_or(0.0, |(i, along)| self.gradients[i].dot(&along));
        let symmetric = gradient * ((1.0 - share) * (pressure + carried));
        if share == 0.0 {
            return symmetric;
        }
        let carried = row.map_or(&self.weight, |(i, _)| &self.weights[i]).dot(offset);
        symmetric + self.corrections[a].0 * gradient * (share * (pressure + carried))
    }
}

/// `R_s` (Pa/m): `V_s R_s` is the force of particle s on the fluid, over all particles `a` around it
/// `−V V_s [(1 − φ) (2 p_a + G_a·P_s r_sa) + φ (2 p_a + ρ g·r_sa) B_a] ∇W_as`: the transpose of the
/// divergence, and for the share φ of Eq. (18) a sum over the structure's surface that carries `p` from the
/// particle to it. Eq. (18) leaves `2 p_a` out, since it vanishes over all that surrounds a particle; not
/// over the structure alone. `whole` tells whether it counts: in the paper's scheme nothing but Eq. (18)
/// moves the fluid.
pub fn pair_reactions<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    carried: &Carried<'_, D>,
    whole: bool,
    p: &[f64],
    out: &mut Vec<Vector<D>>,
) {
    let list = &neighbourhood.fluid_of_structure;
    out.resize(list.len(), Vector::zeros());
    out.par_iter_mut().with_min_len(64).enumerate().for_each(|(s, reaction)| {
        let mut sum = Vector::zeros();
        for (e, &a) in list.range(s).zip(list.of(s)) {
            let a = a as usize;
            let pressure = if whole { 2.0 * p[a] } else { 0.0 };
            let (gradient, offset, tie) = (
                &neighbourhood.fluid_of_structure_gradients[e],
                &neighbourhood.fluid_of_structure_offsets[e],
                &neighbourhood.fluid_of_structure_ties[e],
            );
            sum += carried.push(a, pressure, gradient, offset, |row| row.along_structure(offset, tie));
        }
        *reaction = sum;
    });
}

/// Work (J) of a load `pressure_gradients` (Pa/m) on the fluid in `dt` (s), with the velocity that the
/// structure comes to have under it: `u_s = u*_s − Δt c g_s`, `c` its compliance (m³/kg, nothing where it
/// does not yield). That is the work which the structure gives.
pub fn structure_work<const D: usize>(
    (volumes, compliance): (&[f64], &[f64]),
    unloaded: &[Vector<D>],
    pressure_gradients: &[Vector<D>],
    dt: f64,
) -> f64 {
    let of = |(i, g): (usize, &Vector<D>)| {
        let yielding = compliance.get(i).map_or(Vector::zeros(), |c| g * (dt * c));
        volumes[i] * g.dot(&(unloaded[i] - yielding))
    };
    dt * pressure_gradients.iter().enumerate().map(of).sum::<f64>()
}

/// Power of walls on the fluid over the volume of its particles (Pa/s): `−Σ_a Σ_w V_w (2 p_a + G_a·P_w r_wa)
/// ∇W_aw·u_w`, with the walls' `velocities` across their surface (m/s), one per pair.
pub fn wall_work<const D: usize>(
    (neighbourhood, along): (&Neighbourhood<D>, &Along<D>),
    (p, gradients): (&[f64], &[Vector<D>]),
    velocities: &[Vector<D>],
) -> f64 {
    if velocities.is_empty() {
        return 0.0;
    }
    let of = |a: usize| {
        let row = along.index(a);
        let pairs = neighbourhood.walls.range(a).map(|e| {
            let carried = row.map_or(0.0, |i| gradients[i].dot(along.wall_offset(e)));
            (2.0 * p[a] + carried) * neighbourhood.wall_gradients[e].dot(&velocities[e])
        });
        pairs.sum::<f64>()
    };
    -(0..p.len()).map(of).sum::<f64>()
}

/// Pressures (Pa) beside the interface particles, `Σ |∇W| p/Σ |∇W|` over the fluid, zero where it is dry.
pub fn pressures<const D: usize>(neighbourhood: &Neighbourhood<D>, p: &[f64], out: &mut Vec<f64>) {
    let list = &neighbourhood.fluid_of_structure;
    out.clear();
    out.extend((0..list.len()).map(|s| {
        let gradients = &neighbourhood.fluid_of_structure_gradients[list.range(s)];
        // |∇W| as weight: it needs no second evaluation of the kernel and vanishes at its edge as W does.
        let (mut sum, mut weight) = (0.0, 0.0);
        for (&a, g) in list.of(s).iter().zip(gradients) {
            let w = g.norm();
            sum += w * p[a as usize];
            weight += w;
        }
        if weight > 0.0 { sum / weight } else { 0.0 }
    }));
}

/// Forces on the parts of the walls.
#[derive(Clone, Debug, Default)]
pub struct WallForces<const D: usize> {
    /// Force (N) of the fluid on each part.
    pub forces: Vec<Vector<D>>,
    /// Moment (N m) of that about the origin, about the third axis alone in two dimensions. A pair acts at
    /// the wall's particle: along the line that joins the two, it were the same at the fluid's.
    pub moments: Vec<[f64; 3]>,
    /// How strongly each part is met by particles that Eq. (18) moves: `Σ φ V V_w |2 p_a ∇W_aw|` along each
    /// axis (N).
    met: Vec<Vector<D>>,
    /// Where each part is met: the sum over the axes of that, and its moment of first order (N, N m).
    met_at: Vec<(f64, Vector<D>)>,
}

impl<const D: usize> WallForces<D> {
    /// No force on `parts` parts.
    pub fn clear(&mut self, parts: usize) {
        for values in [&mut self.forces, &mut self.met] {
            values.clear();
            values.resize(parts, Vector::zeros());
        }
        self.moments.clear();
        self.moments.resize(parts, [0.0; 3]);
        self.met_at.clear();
        self.met_at.resize(parts, (0.0, Vector::zeros()));
    }

    /// Adds a force (N) on a part, at a point (m).
    pub fn add(&mut self, part: usize, force: &Vector<D>, at: &Vector<D>) {
        self.forces[part] += force;
        let of = |i: usize, j: usize| at[i] * force[j] - at[j] * force[i];
        let moment = &mut self.moments[part];
        moment[2] += of(0, 1);
        if D == 3 {
            moment[0] += of(1, 2);
            moment[1] += of(2, 0);
        }
    }

    /// Adds the forces of the fluid's pressure, as [`pair_reactions`] has them of the structure: the
    /// transpose of the divergence, and for the share φ of Eq. (18) a sum over the wall's surface that
    /// carries `p` from the particle to it. Particles that have moved are not a lattice: their `∇·r/D` is
    /// 1.01 to 1.02, by which `B` divides their pressure's gradient and so this sum. In
    /// `cases/hydrostatic_tank` the bed carries 1.022 of the water's weight without `B`, 1.007 with it, at
    /// H/Δx = 20. `volume` (m³) is that of a particle.
    pub fn add_pressures(
        &mut self,
        neighbourhood: &Neighbourhood<D>,
        carried: &Carried<'_, D>,
        walls: &Walls<D>,
        volume: f64,
        p: &[f64],
    ) {
        let list = &neighbourhood.walls;
        for a in 0..p.len() {
            for (e, &w) in list.range(a).zip(list.of(a)) {
                let part = walls.part_of[w as usize] as usize;
                let (gradient, offset) = (&neighbourhood.wall_gradients[e], &neighbourhood.wall_offsets[e]);
                let along = |_: &Row<D>| *carried.along.wall_offset(e);
                let force = carried.push(a, 2.0 * p[a], gradient, offset, along) * volume;
                let at = &walls.positions[w as usize];
                self.add(part, &force, at);
                let met = gradient.abs() * (carried.share[a] * 2.0 * p[a].abs() * volume);
                self.met[part] += met;
                self.met_at[part].0 += met.sum();
                self.met_at[part].1 += at * met.sum();
            }
        }
        for pair in &neighbourhood.tied {
            let (a, e, w) = (pair.particle as usize, pair.pair as usize, pair.wall as usize);
            let (offset, along) =
                (&neighbourhood.wall_offsets[e], |_: &Row<D>| *carried.along.wall_offset(e));
            let force = carried.push(a, 2.0 * p[a], &pair.gradient, offset, along) * volume;
            self.add(walls.part_of[w] as usize, &-force, &walls.positions[w]);
        }
    }

    /// Lays on the walls what the fluid got of momentum in `dt` (s) that no pair explains, `unexplained` (kg
    /// m/s): it came from nowhere else. Each part gets of it as it is met, axis by axis; nothing is laid
    /// where no wall is met.
    ///
    /// Eq. (18) has no equal and opposite pairs of fluid, so without this the forces on walls miss the
    /// balance `Σ F = M g − dP/dt`: in the resting tank by 0.7 %, in a dam break (Δx = width/20) by 1 to 4 %
    /// once its jet has fallen back. It acts in the middle of where the part is met.
    pub fn lay(&mut self, unexplained: &Vector<D>, dt: f64) {
        let met = self.met.iter().fold(Vector::<D>::zeros(), |sum, m| sum + m);
        for part in 0..self.forces.len() {
            let (own, (weight, place)) = (self.met[part], self.met_at[part]);
            let mut laid = Vector::<D>::zeros();
            for i in 0..D {
                if met[i] > 0.0 {
                    laid[i] = -(unexplained[i] / dt * (own[i] / met[i]));
                }
            }
            // Where it is met; what is not met gets nothing.
            let at = if weight > 0.0 { place / weight } else { place };
            self.add(part, &laid, &at);
        }
    }
}

/// The paper's Eq. (48): `∇p_s = Σ V_k (p_k − p_s) ∇W_sk` over fluid and structure, dry structure particles
/// at `p = 0`.
pub fn pressure_gradient_load<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    kernel: &CubicSpline<D>,
    structure: (&[Vector<D>], &[f64]),
    p: &[f64],
    structure_p: &[f64],
    out: &mut Vec<Vector<D>>,
) {
    let (positions, volumes) = structure;
    let list = &neighbourhood.fluid_of_structure;
    out.resize(list.len(), Vector::zeros());
    for (s, gradient) in out.iter_mut().enumerate() {
        let gradients = &neighbourhood.fluid_of_structure_gradients[list.range(s)];
        let mut sum = Vector::zeros();
        for (&a, g) in list.of(s).iter().zip(gradients) {
            sum += g * (p[a as usize] - structure_p[s]);
        }
        for (t, position) in positions.iter().enumerate() {
            let r = positions[s] - position;
            if r.norm_squared() < kernel.support().powi(2) {
                sum += kernel.gradient(&r) * (volumes[t] * (structure_p[t] - structure_p[s]));
            }
        }
        *gradient = sum;
    }
}
