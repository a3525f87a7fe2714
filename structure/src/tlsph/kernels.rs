//! The two hot loops: stresses from displacements, and the Runge–Kutta stage from stresses.
//!
//! Both are written once, on slices of [`LANES`] particles, for `K` basis functions per pair, and compiled
//! for each vector instruction set; `pulp` picks at run time. Each particle gathers its own sum in list
//! order, so neither the number of threads nor the width of the vectors changes a bit of the result.

use crate::lanes::{LANES, Lanes, Tensor, matrix, row as row_of};
use crate::materials::{ConstitutiveLaw, Elasticity, Law, with_law};
use crate::options::Gradient;
use crate::tlsph::field::Field;
use crate::tlsph::gradient::{first_order, quadratic};
use crate::tlsph::patches::Patches;
use crate::tlsph::stencil::{Slice, Stencil};
use crate::tlsph::tasks::{in_tasks, split};
use std::ops::Range;

/// One body's part of a pass.
#[derive(Clone, Debug)]
pub(crate) struct BodyPass {
    pub slices: Range<usize>,
    pub law: Law,
    pub elasticity: Elasticity,
    /// Where the body is nearly incompressible.
    pub patches: Option<Patches>,
}

impl BodyPass {
    /// The stress (Pa) that patches add at a slice of the structure, and its energy per volume (J/m³).
    #[inline(always)]
    pub fn volumetric(&self, slice: usize) -> (Lanes, Lanes) {
        match &self.patches {
            Some(patches) => {
                let mean = patches.mean(slice - self.slices.start);
                let stress = mean * self.elasticity.patch_lambda;
                (stress, stress * mean * 0.5)
            }
            None => (Lanes::ZERO, Lanes::ZERO),
        }
    }
}

/// Constants of the pass that are the same for all slices.
#[derive(Clone, Copy)]
struct Pairs<'a> {
    stencil: &'a Stencil,
    margin: usize,
}

/// Stage of the Runge–Kutta step, Eqs. (43)–(45), and what acts in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stage {
    /// Weight in the sums of Eqs. (43), (44): 1, 2, 2, 1.
    pub weight: f64,
    /// Time (s) from the step's start to the next stage; nothing after the last.
    pub to_next: Option<f64>,
    /// `Δt/6` (s).
    pub sixth: f64,
    /// Viscous damping `c` (1/s).
    pub damping: f64,
    /// Whether external accelerations act.
    pub loaded: bool,
}

/// All fields of a Runge–Kutta step, in internal order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fields {
    /// Displacement of the stage (m), `D` components.
    pub displacement: Field,
    /// Conjugates of the moments, `D K` components.
    pub conjugate: Field,
    /// External acceleration of the stage (m/s²), `D` components; zero for fixed particles.
    pub external: Field,
    /// `START_DISPLACEMENT` and the rows after it, `D` components each.
    pub step: Field,
    /// One over the mass that the pair sum is divided by, zero for fixed particles: see
    /// [`Pairs::acceleration`].
    pub scale: Field,
    /// Strain energy per volume (J/m³), filled where it is asked for.
    pub energy: Field,
    /// What the pair sum is multiplied by to be the internal force (N) on a fixed particle that moves, zero
    /// for all others.
    pub clamp_scale: Field,
}

/// Rows of [`Fields::step`]: displacement and velocity at the step's start, velocity of the stage, (3) and
/// (4) the sums of Eqs. (43) and (44), and the work per mass (J/kg) that external accelerations and damping
/// have done.
pub(crate) mod row {
    pub const START_DISPLACEMENT: usize = 0;
    pub const START_VELOCITY: usize = 1;
    pub const STAGE_VELOCITY: usize = 2;
    pub const WORK: usize = 5;
    pub const DISSIPATION: usize = 6;
    pub const COUNT: usize = 7;
}

impl Fields {
    /// Zeros for a dimension, basis functions per pair, margin and particles.
    pub fn new(dimension: usize, basis: usize, margin: usize, count: usize) -> Self {
        Self {
            displacement: Field::new(dimension, margin, count),
            conjugate: Field::new(dimension * basis, margin, count),
            external: Field::new(dimension, margin, count),
            step: Field::new(row::COUNT * dimension, margin, count),
            scale: Field::new(1, margin, count),
            energy: Field::new(1, margin, count),
            clamp_scale: Field::new(1, margin, count),
        }
    }
}

/// Basis functions per pair of a gradient in `dimension` dimensions.
pub(crate) fn basis(dimension: usize, gradient: Gradient) -> usize {
    match gradient {
        Gradient::FirstOrder => dimension,
        Gradient::Quadratic => dimension + dimension * (dimension + 1) / 2,
    }
}

/// Calls `$function::<D, K>` for the dimension and gradient.
macro_rules! for_dimension {
    ($dimension:expr, $gradient:expr, $function:ident ($($argument:expr),*)) => {
        match ($dimension, $gradient) {
            (2, Gradient::FirstOrder) => $function::<2, 2>($($argument),*),
            (3, Gradient::FirstOrder) => $function::<3, 3>($($argument),*),
            (2, Gradient::Quadratic) => $function::<2, 5>($($argument),*),
            (3, Gradient::Quadratic) => $function::<3, 9>($($argument),*),
            _ => unreachable!("two or three dimensions"),
        }
    };
}

/// Conjugates `Q` of the moments at all particles from the displacements; gives the first slice in which `J`
/// is not positive.
pub(crate) fn stress_pass(
    dimension: usize,
    gradient: Gradient,
    stencil: &Stencil,
    bodies: &mut [BodyPass],
    fields: &mut Fields,
) -> Option<usize> {
    average_dilatations(dimension, gradient, stencil, bodies, fields);
    for_dimension!(dimension, gradient, stress_pass_in(stencil, bodies, fields))
}

/// Means over patches of the dilatations that the displacements make, where bodies have patches.
pub(crate) fn average_dilatations(
    dimension: usize,
    gradient: Gradient,
    stencil: &Stencil,
    bodies: &mut [BodyPass],
    fields: &Fields,
) {
    for body in bodies {
        if let Some(patches) = &mut body.patches {
            let (slices, law, out) = (body.slices.clone(), body.law, patches.dilatations.as_mut_slice());
            for_dimension!(dimension, gradient, dilatation_pass_in(stencil, slices, law, fields, out));
            patches.average();
        }
    }
}

/// Accelerations from the conjugates, and one Runge–Kutta stage.
pub(crate) fn stage_pass(
    dimension: usize,
    gradient: Gradient,
    stencil: &Stencil,
    stage: &Stage,
    fields: &mut Fields,
) {
    for_dimension!(dimension, gradient, stage_pass_in(stencil, stage, fields));
}

/// Strain energies per volume at all particles from the displacements.
pub(crate) fn energy_pass(
    dimension: usize,
    gradient: Gradient,
    stencil: &Stencil,
    bodies: &mut [BodyPass],
    fields: &mut Fields,
) {
    average_dilatations(dimension, gradient, stencil, bodies, fields);
    for_dimension!(dimension, gradient, energy_pass_in(stencil, bodies, fields));
}

/// Internal accelerations (m/s²) from the conjugates alone, to a field of `D` components.
pub(crate) fn acceleration_pass(
    dimension: usize,
    gradient: Gradient,
    stencil: &Stencil,
    fields: &Fields,
    out: &mut Field,
) {
    for_dimension!(dimension, gradient, acceleration_pass_in(stencil, fields, out));
}

/// Calls `visit(slice, force)` with the internal forces (N) on the fixed particles that move, zero for the
/// others, for each of `slices` in order.
pub(crate) fn visit_clamp_forces<const D: usize>(
    gradient: Gradient,
    stencil: &Stencil,
    fields: &Fields,
    slices: &[usize],
    mut visit: impl FnMut(usize, &[Lanes; D]),
) {
    let mut copy = |s: usize, force: &[Lanes; 3]| visit(s, &row_of(|i| force[i]));
    for_dimension!(D, gradient, visit_clamp_forces_in(stencil, fields, slices, &mut copy));
}

/// Calls `visit(slice, displacement gradient, strain-gradient energy per volume)` for every slice in order.
pub(crate) fn visit_gradients<const D: usize>(
    gradient: Gradient,
    stencil: &Stencil,
    fields: &Fields,
    mut visit: impl FnMut(usize, &Tensor<D>, Lanes),
) {
    // The dimension is known to the compiler twice, so the lanes are copied over.
    let mut copy = |s: usize, l: &[[Lanes; 3]; 3], energy: Lanes| visit(s, &matrix(|i, j| l[i][j]), energy);
    for_dimension!(D, gradient, visit_gradients_in(stencil, fields, &mut copy));
}

fn stress_pass_in<const D: usize, const K: usize>(
    stencil: &Stencil,
    bodies: &[BodyPass],
    fields: &mut Fields,
) -> Option<usize> {
    let pairs = Pairs { stencil, margin: stencil.margin };
    let displacement = fields.displacement.components::<D>();
    let mut conjugate = fields.conjugate.interior_rows_mut::<D, K>();
    let mut failed = None;
    for body in bodies {
        let (own, rest) = split(conjugate, body.slices.len() * LANES);
        conjugate = rest;
        let leaf = |slices: Range<usize>, mut out: [[&mut [f64]; K]; D]| {
            pulp::Arch::new().dispatch(
                #[inline(always)]
                || {
                    with_law!(body.law, L => {
                        stresses::<D, K, L>(pairs, body, &displacement, slices, &mut out)
                    })
                },
            )
        };
        let found = in_tasks(body.slices.clone(), own, &leaf);
        failed = failed.or(found);
    }
    failed
}

fn dilatation_pass_in<const D: usize, const K: usize>(
    stencil: &Stencil,
    slices: Range<usize>,
    law: Law,
    fields: &Fields,
    out: &mut [f64],
) {
    let pairs = Pairs { stencil, margin: stencil.margin };
    let displacement = fields.displacement.components::<D>();
    let leaf = |slices: Range<usize>, out: [[&mut [f64]; 1]; 1]| {
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || with_law!(law, L => dilatations::<D, K, L>(pairs, &displacement, slices, out[0][0])),
        );
        None
    };
    in_tasks(slices, [[out]], &leaf);
}

fn stage_pass_in<const D: usize, const K: usize>(stencil: &Stencil, stage: &Stage, fields: &mut Fields) {
    let pairs = Pairs { stencil, margin: stencil.margin };
    let conjugate = fields.conjugate.rows::<D, K>();
    let external = fields.external.components::<D>();
    let scale = fields.scale.component(0);
    let [displacement] = fields.displacement.interior_rows_mut::<1, D>();
    let [r0, r1, r2, r3, r4, r5, r6] = fields.step.interior_rows_mut::<{ row::COUNT }, D>();
    let rows = [r0, r1, r2, r3, r4, r5, r6, displacement];
    let leaf = |slices: Range<usize>, mut out: [[&mut [f64]; D]; row::COUNT + 1]| {
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || integrate::<D, K>(pairs, stage, &conjugate, &external, scale, slices, &mut out),
        );
        None
    };
    in_tasks(0..stencil.slices.len(), rows, &leaf);
}

fn energy_pass_in<const D: usize, const K: usize>(
    stencil: &Stencil,
    bodies: &[BodyPass],
    fields: &mut Fields,
) {
    let pairs = Pairs { stencil, margin: stencil.margin };
    let displacement = fields.displacement.components::<D>();
    let mut energy = fields.energy.interior_rows_mut::<1, 1>();
    for body in bodies {
        let (own, rest) = split(energy, body.slices.len() * LANES);
        energy = rest;
        let leaf = |slices: Range<usize>, out: [[&mut [f64]; 1]; 1]| {
            pulp::Arch::new().dispatch(
                #[inline(always)]
                || {
                    with_law!(body.law, L => {
                        energies::<D, K, L>(pairs, body, &displacement, slices, out[0][0]);
                    });
                },
            );
            None
        };
        in_tasks(body.slices.clone(), own, &leaf);
    }
}

fn acceleration_pass_in<const D: usize, const K: usize>(stencil: &Stencil, fields: &Fields, out: &mut Field) {
    let pairs = Pairs { stencil, margin: stencil.margin };
    let (conjugate, scale) = (fields.conjugate.rows::<D, K>(), fields.scale.component(0));
    let out = out.interior_mut::<D>();
    for s in 0..stencil.slices.len() {
        let acceleration = pairs.acceleration::<D, K>(s, &conjugate, scale);
        for i in 0..D {
            acceleration[i].store(out[i], s * LANES);
        }
    }
}

fn visit_clamp_forces_in<const D: usize, const K: usize>(
    stencil: &Stencil,
    fields: &Fields,
    slices: &[usize],
    visit: &mut impl FnMut(usize, &[Lanes; 3]),
) {
    let pairs = Pairs { stencil, margin: stencil.margin };
    let (conjugate, scale) = (fields.conjugate.rows::<D, K>(), fields.clamp_scale.component(0));
    for &s in slices {
        let mut padded = [Lanes::ZERO; 3];
        padded[..D].copy_from_slice(&pairs.acceleration::<D, K>(s, &conjugate, scale));
        visit(s, &padded);
    }
}

fn visit_gradients_in<const D: usize, const K: usize>(
    stencil: &Stencil,
    fields: &Fields,
    visit: &mut impl FnMut(usize, &[[Lanes; 3]; 3], Lanes),
) {
    let pairs = Pairs { stencil, margin: stencil.margin };
    let displacement = fields.displacement.components::<D>();
    for s in 0..stencil.slices.len() {
        let (l, energy) = pairs.observe::<D, K>(s, &displacement);
        let mut padded = [[Lanes::ZERO; 3]; 3];
        for i in 0..D {
            padded[i][..D].copy_from_slice(&l[i]);
        }
        visit(s, &padded, energy);
    }
}

#[inline(always)]
fn stresses<const D: usize, const K: usize, L: ConstitutiveLaw>(
    pairs: Pairs,
    body: &BodyPass,
    displacement: &[&[f64]; D],
    slices: Range<usize>,
    out: &mut [[&mut [f64]; K]; D],
) -> Option<usize> {
    let mut failed = None;
    for (n, s) in slices.enumerate() {
        let moments = pairs.moments::<D, K>(s, displacement);
        let constants = pairs.constants(s);
        let (q, jacobian) = if K == D {
            first_order::respond::<D, K, L>(&body.elasticity, &moments, constants)
        } else {
            quadratic::respond::<D, K, L>(&body.elasticity, &moments, constants, body.volumetric(s).0)
        };
        if !jacobian.all_positive() && failed.is_none() {
            failed = Some(s);
        }
        for i in 0..D {
            for k in 0..K {
                q[i][k].store(out[i][k], n * LANES);
            }
        }
    }
    failed
}

#[inline(always)]
fn dilatations<const D: usize, const K: usize, L: ConstitutiveLaw>(
    pairs: Pairs,
    displacement: &[&[f64]; D],
    slices: Range<usize>,
    out: &mut [f64],
) {
    for (n, s) in slices.enumerate() {
        let moments = pairs.moments::<D, K>(s, displacement);
        let constants = pairs.constants(s);
        let l = if K == D {
            first_order::displacement_gradient::<D, K>(&moments, constants)
        } else {
            quadratic::displacement_gradient::<D, K>(&moments, constants)
        };
        L::dilatation(&l).store(out, n * LANES);
    }
}

#[inline(always)]
fn energies<const D: usize, const K: usize, L: ConstitutiveLaw>(
    pairs: Pairs,
    body: &BodyPass,
    displacement: &[&[f64]; D],
    slices: Range<usize>,
    out: &mut [f64],
) {
    for (n, s) in slices.enumerate() {
        let (l, gradient_energy) = pairs.observe::<D, K>(s, displacement);
        (L::energy(&body.elasticity, &l) + gradient_energy + body.volumetric(s).1).store(out, n * LANES);
    }
}

#[inline(always)]
fn integrate<const D: usize, const K: usize>(
    pairs: Pairs,
    stage: &Stage,
    conjugate: &[[&[f64]; K]; D],
    external: &[&[f64]; D],
    scale: &[f64],
    slices: Range<usize>,
    out: &mut [[&mut [f64]; D]; row::COUNT + 1],
) {
    let [start_x, start_u, stage_u, sum_u, sum_a, work, dissipation, stage_x] = out;
    for (n, s) in slices.enumerate() {
        let (at, padded) = (n * LANES, pairs.margin + s * LANES);
        let internal = pairs.acceleration::<D, K>(s, conjugate, scale);
        for i in 0..D {
            let u = Lanes::load(stage_u[i], at);
            let mut a = internal[i];
            if stage.loaded {
                let given = Lanes::load(external[i], padded);
                a += given;
                (Lanes::load(work[i], at) + given * u * (stage.weight * stage.sixth)).store(work[i], at);
            }
            if stage.damping > 0.0 {
                a = a - u * stage.damping;
                let lost = u * u * (stage.damping * stage.weight * stage.sixth);
                (Lanes::load(dissipation[i], at) + lost).store(dissipation[i], at);
            }
            let total_u = Lanes::load(sum_u[i], at) + u * stage.weight;
            let total_a = Lanes::load(sum_a[i], at) + a * stage.weight;
            let (x0, u0) = (Lanes::load(start_x[i], at), Lanes::load(start_u[i], at));
            if let Some(to_next) = stage.to_next {
                total_u.store(sum_u[i], at);
                total_a.store(sum_a[i], at);
                (x0 + u * to_next).store(stage_x[i], at);
                (u0 + a * to_next).store(stage_u[i], at);
            } else {
                let (x, u) = (x0 + total_u * stage.sixth, u0 + total_a * stage.sixth);
                Lanes::ZERO.store(sum_u[i], at);
                Lanes::ZERO.store(sum_a[i], at);
                x.store(start_x[i], at);
                x.store(stage_x[i], at);
                u.store(start_u[i], at);
                u.store(stage_u[i], at);
            }
        }
    }
}

impl<'a> Pairs<'a> {
    #[inline(always)]
    fn constants(&self, s: usize) -> &'a [f64] {
        &self.stencil.constants[self.stencil.slices[s].constants..]
    }

    #[inline(always)]
    fn weights<const K: usize>(&self, slice: &Slice) -> &'a [f64] {
        let entries = (slice.entries.1 - slice.entries.0) as usize;
        &self.stencil.weights[slice.weights..slice.weights + entries * K * LANES]
    }

    /// `Σ_b (U_b − U_a) φ_ab` for the basis functions `φ` of the slice's pairs.
    #[inline(always)]
    fn moments<const D: usize, const K: usize>(
        &self,
        s: usize,
        displacement: &[&[f64]; D],
    ) -> [[Lanes; K]; D] {
        let slice = &self.stencil.slices[s];
        let base = self.margin + s * LANES;
        let own: [Lanes; D] = row_of(|i| Lanes::load(displacement[i], base));
        let mut sums = [[Lanes::ZERO; K]; D];
        let weights = self.weights::<K>(slice).chunks_exact(K * LANES);
        let range = slice.entries.0 as usize..slice.entries.1 as usize;
        if slice.runs {
            for (&offset, phi) in self.stencil.offsets[range].iter().zip(weights) {
                let start = (base as i64 + i64::from(offset)) as usize;
                let difference = row_of(|i| Lanes::load(displacement[i], start) - own[i]);
                add_moments::<D, K>(&mut sums, &difference, phi);
            }
        } else {
            for (indices, phi) in self.stencil.indices[range].iter().zip(weights) {
                let difference = row_of(|i| Lanes::gather(&displacement[i][self.margin..], indices) - own[i]);
                add_moments::<D, K>(&mut sums, &difference, phi);
            }
        }
        sums
    }

    /// The displacement gradient, and the strain-gradient energy per volume (J/m³).
    #[inline(always)]
    fn observe<const D: usize, const K: usize>(
        &self,
        s: usize,
        displacement: &[&[f64]; D],
    ) -> (Tensor<D>, Lanes) {
        let moments = self.moments::<D, K>(s, displacement);
        let constants = self.constants(s);
        if K == D {
            (first_order::displacement_gradient::<D, K>(&moments, constants), Lanes::ZERO)
        } else {
            quadratic::observe::<D, K>(&moments, constants)
        }
    }

    /// `scale_a Σ_b (Q_a φ_ab − Q_b φ_ba)`. The first `D` basis functions are odd, `φ_ba = −φ_ab`, the others
    /// even.
    ///
    /// First order: Eq. (42) with `Q = P K⁻¹`, `φ_ab = V_b ∇₀W_ab` and `scale = 1/ρ_s`. Quadratic:
    /// `Q = V c M` and `scale = 1/(ρ_s V)`.
    #[inline(always)]
    fn acceleration<const D: usize, const K: usize>(
        &self,
        s: usize,
        conjugate: &[[&[f64]; K]; D],
        scale: &[f64],
    ) -> [Lanes; D] {
        let slice = &self.stencil.slices[s];
        let base = self.margin + s * LANES;
        let own: [[Lanes; K]; D] = matrix(|i, k| Lanes::load(conjugate[i][k], base));
        let mut sums = [Lanes::ZERO; D];
        let weights = self.weights::<K>(slice).chunks_exact(K * LANES);
        let range = slice.entries.0 as usize..slice.entries.1 as usize;
        if slice.runs {
            for (&offset, phi) in self.stencil.offsets[range].iter().zip(weights) {
                let start = (base as i64 + i64::from(offset)) as usize;
                for k in 0..K {
                    let w = Lanes::load(phi, k * LANES);
                    for i in 0..D {
                        sums[i] += pair_sum::<D>(k, own[i][k], Lanes::load(conjugate[i][k], start)) * w;
                    }
                }
            }
        } else {
            for (indices, phi) in self.stencil.indices[range].iter().zip(weights) {
                for k in 0..K {
                    let w = Lanes::load(phi, k * LANES);
                    for i in 0..D {
                        let other = Lanes::gather(&conjugate[i][k][self.margin..], indices);
                        sums[i] += pair_sum::<D>(k, own[i][k], other) * w;
                    }
                }
            }
        }
        let scale = Lanes::load(scale, base);
        row_of(|i| sums[i] * scale)
    }
}

#[inline(always)]
fn add_moments<const D: usize, const K: usize>(
    sums: &mut [[Lanes; K]; D],
    difference: &[Lanes; D],
    phi: &[f64],
) {
    for k in 0..K {
        let w = Lanes::load(phi, k * LANES);
        for i in 0..D {
            sums[i][k] += difference[i] * w;
        }
    }
}

#[inline(always)]
fn pair_sum<const D: usize>(k: usize, own: Lanes, other: Lanes) -> Lanes {
    if k < D { own + other } else { own - other }
}
