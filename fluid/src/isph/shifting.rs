//! Particle shifting, Eqs. (21)–(26), and the relocation next to the structure, Eqs. (27)–(30).

use crate::isph::options::{Options, ShiftingLaw};
use crate::isph::surface::detection::Surface;
use crate::particles::class::SurfaceClass;
use crate::particles::neighbourhood::Neighbourhood;
use rayon::prelude::*;
use sph::Vector;

/// Fields that shifting reads.
pub struct ShiftingInput<'a, const D: usize> {
    /// Lists and sums.
    pub neighbourhood: &'a Neighbourhood<D>,
    /// Classes and normals.
    pub surface: &'a Surface<D>,
    /// Positions (m) of fluid, walls and structure, on which the lists were made.
    pub positions: &'a [Vector<D>],
    /// Wall positions (m).
    pub wall_positions: &'a [Vector<D>],
    /// Structure positions (m).
    pub structure_positions: &'a [Vector<D>],
    /// Normals out of the structure.
    pub structure_normals: &'a [Vector<D>],
    /// `ζ = u Δt` (m).
    pub magnitude: f64,
    /// Smoothing length (m).
    pub smoothing_length: f64,
}

/// Shifts (m) of all particles.
pub fn shifts<const D: usize>(input: &ShiftingInput<'_, D>, options: &Options, out: &mut Vec<Vector<D>>) {
    let limit = options.shifting_limit * input.smoothing_length;
    out.resize(input.positions.len(), Vector::zeros());
    out.par_iter_mut().with_min_len(256).enumerate().for_each(|(a, shift)| {
        let class = input.surface.classes[a];
        let mut r = match options.shifting {
            ShiftingLaw::Off => Vector::zeros(),
            _ if class == SurfaceClass::Splash => Vector::zeros(),
            ShiftingLaw::Concentration => {
                let crowding = input.neighbourhood.surroundings[a].crowding;
                crowding * (-2.0 * input.smoothing_length * options.shifting_coefficient * input.magnitude)
            }
            ShiftingLaw::Paper => scattering(input, a) * (options.shifting_coefficient * input.magnitude),
        };
        if options.interface_shifting {
            relocate(input, options.shifting_coefficient, a, &mut r);
        }
        if matches!(class, SurfaceClass::Surface | SurfaceClass::NearSurface) {
            // Eq. (24): along the surface only, and not at all where no normal can be told.
            let n = input.surface.normals[a];
            r = if n == Vector::<D>::zeros() { n } else { r - n * n.dot(&r) };
        }
        let length = r.norm();
        *shift = if length > limit { r * (limit / length) } else { r };
    });
}

/// `R_a = Σ (r̄/r)² r_ab/|r_ab|` over everything around, Eqs. (22)–(23); `n_ab` points from b to a, so that
/// particles part.
fn scattering<const D: usize>(input: &ShiftingInput<'_, D>, a: usize) -> Vector<D> {
    let n = input.neighbourhood;
    let at = input.positions[a];
    let fluid = n.fluid.of(a).iter().map(|&b| n.period.nearest(at - input.positions[b as usize]));
    let walls = n.walls.of(a).iter().map(|&b| at - input.wall_positions[b as usize]);
    let structure = n.structure.of(a).iter().map(|&b| at - input.structure_positions[b as usize]);
    let (mut sum, mut mean, mut count) = (Vector::zeros(), 0.0, 0usize);
    for r in fluid.chain(walls).chain(structure) {
        let distance = r.norm();
        sum += r / distance.powi(3);
        mean += distance;
        count += 1;
    }
    if count == 0 {
        return Vector::zeros();
    }
    mean /= count as f64;
    sum * (mean * mean)
}

/// Eq. (27) for particles that have structure within reach: the shift's part along the structure's normal,
/// `δ_n`, becomes `δ_n + d (exp(−|δ_n|/|d|) − 1)` with `|d| = ζ/(2 C |R_n|)` of Eq. (29), kept within Eq.
/// (30).
///
/// `d` takes the sign of `δ_n`; with the sign as printed, shifts towards the structure would double.
fn relocate<const D: usize>(input: &ShiftingInput<'_, D>, coefficient: f64, a: usize, shift: &mut Vector<D>) {
    let at = input.positions[a];
    let nearest = input.neighbourhood.structure.of(a).iter().map(|&s| s as usize).min_by(|&s, &t| {
        let distance = |s: usize| (at - input.structure_positions[s]).norm_squared();
        distance(s).total_cmp(&distance(t))
    });
    let Some(normal) = nearest.map(|s| input.structure_normals[s]) else { return };
    let along = shift.dot(&normal);
    if along == 0.0 || input.magnitude == 0.0 {
        return;
    }
    let r_n = along.abs() / (coefficient * input.magnitude);
    let depth = (0.5 / coefficient).clamp(5.0, 50.0) * input.magnitude / r_n;
    let relocated = along + along.signum() * depth * ((-along.abs() / depth).exp() - 1.0);
    *shift += normal * (relocated - along);
}
