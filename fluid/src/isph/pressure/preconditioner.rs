//! The preconditioner of both solves of a step: the one place where it is chosen, set up and applied.

use crate::isph::options::Preconditioner;
use crate::isph::pressure::multigrid::{self, Multigrid};
use crate::isph::pressure::pressure_operator::PressureOperator;
use rayon::prelude::*;
use sph::Vector;

/// A preconditioner for the operators of one step and of those that follow, as long as it serves (see
/// [`hierarchy`](crate::isph::pressure::hierarchy)).
#[derive(Debug, Default)]
pub struct PressurePreconditioner<const D: usize> {
    inverse_diagonal: Vec<f64>,
    /// Accelerations (m²/kg) of the interface particles by a pressure of one.
    yields: Vec<Vector<D>>,
    multigrid: Option<Multigrid>,
    by_multigrid: bool,
    /// Which pressures were unknown when it was made.
    made_free: Vec<bool>,
    /// The operator's diagonal then.
    made_diagonal: Vec<f32>,
    /// Particles whose pressure was unknown then and is known now.
    closed: Vec<u32>,
    /// Particles whose pressure was known then and is unknown now, each with its smoother's step.
    opened: Vec<(u32, f64)>,
    /// Particles whose diagonal has changed, each with the root of what it was over what it is.
    rescaled: Vec<(u32, f64)>,
    /// The residual of these scaled.
    scaled: Vec<f64>,
}

/// Ratio of a diagonal to what it was, or of what it was to it, from which on it counts as changed.
const CHANGED: f64 = 1.1;

impl<const D: usize> PressurePreconditioner<D> {
    /// Sets up for `operator`, whose diagonal is `diagonal`. The multigrid's matrix is the compact Laplacian
    /// between unknown pressures, with the operator's extra diagonal and, for the wide operator, its
    /// reaction, the square of the force of a constant pressure (see [`multigrid::Options::WIDE_OPERATOR`]),
    /// all times ρ. Where the structure yields to a constant pressure, what it takes up is added to the
    /// reaction: in `cases/elastic_gate` (0.15 s) a solve to 1e-3 took 8.0 iterations in the mean instead of
    /// 10.0.
    pub fn prepare(&mut self, kind: Preconditioner, operator: &PressureOperator<'_, D>, diagonal: &[f64]) {
        self.by_multigrid = kind == Preconditioner::Multigrid;
        self.made_free.clear();
        self.made_free.extend_from_slice(operator.free);
        self.made_diagonal.clear();
        self.made_diagonal.extend(diagonal.iter().map(|d| *d as f32));
        if !self.by_multigrid {
            self.inverse_diagonal.clear();
            self.inverse_diagonal.extend(diagonal.iter().map(|d| if *d > 0.0 { 1.0 / d } else { 0.0 }));
            return;
        }
        let wide = operator.wide_share > 0.0;
        let multigrid = self.multigrid.get_or_insert_with(|| {
            Multigrid::new(if wide {
                multigrid::Options::WIDE_OPERATOR
            } else {
                multigrid::Options::SAME_OPERATOR
            })
        });
        self.yields.clear();
        if let (true, Some(yielding)) = (wide, &operator.yielding) {
            let list = &operator.pair.neighbourhood.fluid_of_structure;
            let of_unit_pressure = |s: usize| {
                let gradients = &operator.pair.neighbourhood.fluid_of_structure_gradients[list.range(s)];
                gradients.iter().fold(Vector::zeros(), |sum: Vector<D>, g| sum + g) * 2.0
            };
            self.yields.extend((0..list.len()).map(of_unit_pressure));
            yielding.accelerate(&mut self.yields, &mut Vec::new());
        }
        let yields = &self.yields;
        let (list, free) = (&operator.pair.neighbourhood.fluid, operator.free);
        multigrid.rebuild_rows(list.offsets(), |a, row| {
            if !free[a] {
                return 1.0;
            }
            let sums = &operator.pair.neighbourhood.surroundings[a];
            let one_sided = (sums.fluid_gradient + sums.boundary_gradient) * 2.0;
            let reaction = operator.wide_share * one_sided.norm_squared();
            let taken_up = if yields.is_empty() { 0.0 } else { taken_up(operator, yields, a) };
            let mut total = (operator.extra_diagonal[a] + taken_up) / operator.inverse_density + reaction;
            for (&b, pair) in list.of(a).iter().zip(&operator.pair.neighbourhood.fluid_pairs[list.range(a)]) {
                total += pair.stiffness();
                if free[b as usize] {
                    row.push(b, -pair.stiffness());
                }
            }
            total
        });
    }

    /// Fits what was prepared to an operator of the same particles with this `diagonal`, whose pressures are
    /// unknown where `free` says: particles whose pressure is known by now get no correction, those whose
    /// pressure was known get that of their diagonal alone. Where the diagonal has changed, by a tenth at
    /// least, residual and correction are scaled by the root of the change. What is left is symmetric and
    /// positive.
    ///
    /// Diagonals change by orders of magnitude where α of Eq. (16) comes from nearly zero, and with the old
    /// ones a few such particles hold nearly all of the residual: in a splashing dam (8,800 particles, 2.4 s)
    /// the two solves took 11.8 and 4.6 iterations with them, 8.8 and 3.2 scaled, and made 0.23 hierarchies a
    /// step instead of 0.43; with a new hierarchy each step it is 9.0 and 3.4.
    pub fn fit(&mut self, free: &[bool], diagonal: &[f64], inverse_density: f64) {
        assert_eq!(free.len(), self.made_free.len(), "a hierarchy serves the particles that it was made for");
        self.closed.clear();
        self.opened.clear();
        self.rescaled.clear();
        for (a, (&now, &then)) in free.iter().zip(&self.made_free).enumerate() {
            match (then, now) {
                (true, false) => self.closed.push(a as u32),
                (false, true) => self.opened.push((a as u32, inverse_density / diagonal[a])),
                (true, true) => {
                    let ratio = f64::from(self.made_diagonal[a]) / diagonal[a];
                    if !(1.0 / CHANGED..CHANGED).contains(&ratio) {
                        self.rescaled.push((a as u32, ratio.sqrt()));
                    }
                }
                (false, false) => {}
            }
        }
    }

    /// `z ≈ A⁻¹ r` up to a factor.
    pub fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        if let (true, Some(multigrid)) = (self.by_multigrid, &mut self.multigrid) {
            let rescaled = &self.rescaled;
            if rescaled.is_empty() {
                multigrid.apply(r, z);
            } else {
                self.scaled.clear();
                self.scaled.extend_from_slice(r);
                rescaled.iter().for_each(|&(a, scale)| self.scaled[a as usize] *= scale);
                multigrid.apply(&self.scaled, z);
                rescaled.iter().for_each(|&(a, scale)| z[a as usize] *= scale);
            }
            for &a in &self.closed {
                z[a as usize] = 0.0;
            }
            for &(a, step) in &self.opened {
                z[a as usize] = step * r[a as usize];
            }
        } else {
            z.par_iter_mut()
                .with_min_len(4096)
                .zip(r)
                .zip(&self.inverse_diagonal)
                .for_each(|((z, r), d)| *z = r * d);
        }
    }
}

/// Row `a` of the structure's part of the operator, summed: what the structure's `yields` under a constant
/// pressure of one take up of the divergence (m³/kg/m²). A row that is negative, of a particle among others
/// that press from both sides, counts as zero, so that the matrix stays positive.
fn taken_up<const D: usize>(operator: &PressureOperator<'_, D>, yields: &[Vector<D>], a: usize) -> f64 {
    let list = &operator.pair.neighbourhood.structure;
    let gradients = &operator.pair.neighbourhood.structure_gradients[list.range(a)];
    let sum = list.of(a).iter().zip(gradients).map(|(&s, g)| 2.0 * g.dot(&yields[s as usize])).sum::<f64>();
    sum.max(0.0)
}
