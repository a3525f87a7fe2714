//! Forces between fluid and boundaries: what the structure gets, and what the fluid got from each of its
//! particles.

use crate::boundaries::walls::Walls;
use crate::interface::InterfaceInput;
use crate::isph::options::Options;
use crate::isph::state::State;
use crate::particles::neighbourhood::Neighbourhood;
use crate::properties::FluidProperties;
use sph::kernel::CubicSpline;
use sph::{Matrix, Vector};

/// What a fluid particle meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Body {
    /// A part of the walls.
    Wall(usize),
    /// An interface particle.
    Structure(usize),
}

/// `R_s` (Pa/m): `V_s R_s` is the force on the fluid from particle s by the formula that moved the fluid,
/// `−V V_s [(1 − φ) 2 p_a + φ (p_s − p_a) B_a] ∇W_as` summed over the fluid, with
/// `p_s − p_a = ρ g·(r_s − r_a)` and the share φ of Eq. (18). `positions` are those of fluid and structure
/// (m).
pub fn pair_reactions<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    corrections: &[(Matrix<D>, f64)],
    share: &[f64],
    properties: &FluidProperties<D>,
    positions: (&[Vector<D>], &[Vector<D>]),
    p: &[f64],
    out: &mut Vec<Vector<D>>,
) {
    let (fluid, structure) = positions;
    let list = &neighbourhood.fluid_of_structure;
    out.clear();
    out.extend((0..list.len()).map(|s| {
        let gradients = &neighbourhood.fluid_of_structure_gradients[list.range(s)];
        let (mut symmetric, mut corrected) = (Vector::zeros(), Vector::zeros());
        for (&a, g) in list.of(s).iter().zip(gradients) {
            let a = a as usize;
            symmetric += g * (p[a] * (1.0 - share[a]));
            if share[a] > 0.0 {
                let jump = properties.density * properties.gravity.dot(&(structure[s] - fluid[a]));
                corrected += corrections[a].0 * g * (share[a] * jump);
            }
        }
        symmetric * 2.0 + corrected
    }));
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
    /// How strongly each part is met by particles that Eq. (18) moves: `Σ φ V V_w |2 p_a ∇W_aw|` along each
    /// axis (N).
    met: Vec<Vector<D>>,
}

impl<const D: usize> WallForces<D> {
    /// No force on `parts` parts.
    pub fn clear(&mut self, parts: usize) {
        for values in [&mut self.forces, &mut self.met] {
            values.clear();
            values.resize(parts, Vector::zeros());
        }
    }

    /// Adds the forces of the fluid's pressure,
    /// `+V V_w [(1 − φ) 2 p_a + φ (2 p_a + ρ g·(r_w − r_a)) B_a] ∇W_aw`: the transpose of the divergence, and
    /// for the share φ of Eq. (18) a sum over the wall's surface that carries `p` from the particle to it.
    /// Particles that have moved are not a lattice: their `∇·r/D` is 1.01 to 1.02, by which `B` divides their
    /// pressure's gradient and so this sum. In `cases/hydrostatic_tank` the bed carries 1.022 of the water's
    /// weight without `B`, 1.007 with it, at H/Δx = 20.
    pub fn add_pressures(
        &mut self,
        (neighbourhood, corrections): (&Neighbourhood<D>, &[(Matrix<D>, f64)]),
        walls: &Walls<D>,
        properties: &FluidProperties<D>,
        positions: &[Vector<D>],
        share: &[f64],
        p: &[f64],
    ) {
        let list = &neighbourhood.walls;
        let (volume, weight) = (properties.particle_volume, properties.gravity * properties.density);
        for a in 0..p.len() {
            let (symmetric, corrected) = (1.0 - share[a], corrections[a].0 * share[a]);
            for (&w, g) in list.of(a).iter().zip(&neighbourhood.wall_gradients[list.range(a)]) {
                let part = walls.part_of[w as usize] as usize;
                let step = weight.dot(&(walls.positions[w as usize] - positions[a]));
                self.forces[part] +=
                    (g * (symmetric * 2.0 * p[a]) + corrected * g * (2.0 * p[a] + step)) * volume;
                self.met[part] += g.abs() * (share[a] * 2.0 * p[a].abs() * volume);
            }
        }
    }

    /// Lays on the walls what the fluid got of momentum in `dt` (s) that no pair explains, `unexplained` (kg
    /// m/s): it came from nowhere else. Each part gets of it as it is met, axis by axis; nothing is laid
    /// where no wall is met.
    ///
    /// Eq. (18) has no equal and opposite pairs of fluid, so without this the forces on walls miss the
    /// balance `Σ F = M g − dP/dt`: in the resting tank by 0.7 %, in a dam break (Δx = width/20) by 1 to 4 %
    /// once its jet has fallen back.
    pub fn lay(&mut self, unexplained: &Vector<D>, dt: f64) {
        let met = self.met.iter().fold(Vector::<D>::zeros(), |sum, m| sum + m);
        for (force, own) in self.forces.iter_mut().zip(&self.met) {
            for i in 0..D {
                if met[i] > 0.0 {
                    force[i] -= unexplained[i] / dt * (own[i] / met[i]);
                }
            }
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

/// Largest ratio of the extrapolated difference of velocity to that at the wall: with it the friction of a
/// row half in the wall stays stable at the step `h²/8ν`. Morris has 1.5.
const STEEPEST: f64 = 3.0;

/// Wall particles have the velocity that is, extrapolated through the wall's surface from the particle that
/// they meet, the wall's own at the surface: the difference is `1 + depth/distance` times as large (Morris,
/// Fox and Zhu 1997). The structure's particles have their own velocity.
///
/// Adds the friction of no-slip boundaries, `Σ ν stiffness (u_b − u_a)` in Morris' form, to the viscous
/// accelerations (m/s²); `taken(body, acceleration)` is told what each body gave to a fluid particle.
pub fn boundary_friction<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    options: &Options,
    kinematic_viscosity: f64,
    fluid: &State<D>,
    bodies: (&Walls<D>, &InterfaceInput<'_, D>),
    accelerations: &mut [Vector<D>],
    mut taken: impl FnMut(Body, Vector<D>),
) {
    let (walls, structure) = bodies;
    let (positions, velocities) = (&fluid.positions, &fluid.velocities);
    let mut pull = |a: usize, at: &Vector<D>, u: &Vector<D>, g: &Vector<D>, factor: f64, body: Body| {
        let stiffness = 2.0 * factor * g.norm() / (positions[a] - at).norm();
        let acceleration = (u - velocities[a]) * (kinematic_viscosity * stiffness);
        accelerations[a] += acceleration;
        taken(body, acceleration);
    };
    for a in 0..positions.len() {
        if options.no_slip_walls {
            let list = &neighbourhood.walls;
            let (mut nearest, mut distance) = (usize::MAX, 0.0);
            for (&w, g) in list.of(a).iter().zip(&neighbourhood.wall_gradients[list.range(a)]) {
                let w = w as usize;
                let part = walls.part_of[w] as usize;
                if part != nearest {
                    (nearest, distance) = (part, walls.surface_point(part, &positions[a], false).distance);
                }
                let factor =
                    if distance > 0.0 { (1.0 + walls.depths[w] / distance).min(STEEPEST) } else { STEEPEST };
                pull(a, &walls.positions[w], &walls.velocities[w], g, factor, Body::Wall(part));
            }
        }
        if options.no_slip_structure {
            let list = &neighbourhood.structure;
            for (&s, g) in list.of(a).iter().zip(&neighbourhood.structure_gradients[list.range(a)]) {
                let s = s as usize;
                pull(a, &structure.positions[s], &structure.velocities[s], g, 1.0, Body::Structure(s));
            }
        }
    }
}
