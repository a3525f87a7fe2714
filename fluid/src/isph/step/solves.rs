//! The two solves of a step: displacements that mend the density, and the pressure.

use crate::boundaries::sampling::BoundaryPoints;
use crate::error::Error;
use crate::isph::options::Tearing;
use crate::isph::pressure::conjugate_gradients::{self, Limits};
use crate::isph::pressure::position_projection;
use crate::isph::pressure::preconditioner::PressurePreconditioner;
use crate::isph::pressure::pressure_operator::{OperatorScratch, PressureOperator, Yielding};
use crate::isph::solver::Isph;
use crate::isph::state::State;
use crate::isph::step::assembly::operator;
use crate::isph::step::scratch::ROWS;
use crate::report::Outcome;
use crate::report::StepReport;
use rayon::prelude::*;
use sph::{Vector, parallel};

/// Particles that one task works through at least where one operation is done for each.
const LIGHT_ROWS: usize = 4096;

impl<const D: usize> Isph<D> {
    pub(super) fn project_positions(
        &mut self,
        time: f64,
        trial: &mut State<D>,
        report: &mut StepReport<D>,
    ) -> Result<(), Error> {
        let s = &mut self.scratch;
        s.position_shifts.clear();
        if !self.options.position_projection {
            s.position_shifts.resize(s.terms.own.len(), Vector::zeros());
            return Ok(());
        }
        position_projection::density_errors(
            &s.neighbourhood,
            &s.surface,
            self.lattice_concentration,
            &mut s.right,
        );
        let a = operator((&self.properties, &self.options), None, &s.neighbourhood, &s.surface, &s.terms);
        let q = &mut trial.memory.position_potentials;
        let limits = Limits {
            tolerance: self.options.position_tolerance,
            iterations: self.options.pressure_iterations_limit,
        };
        let memory = (&mut s.preconditioner, &mut s.operator, &mut s.solver);
        remove_mean_if(s.surface.is_closed(), &mut s.right);
        report.position_solve = solve(&a, s.surface.is_closed(), &s.right, q, limits, memory);
        require(&report.position_solve, "position correction", time, limits.tolerance)?;
        let limit = self.options.position_limit * self.properties.spacing;
        let inverse_density = 1.0 / self.properties.density;
        a.pair.accelerations(inverse_density, q, &mut s.position_shifts);
        position_projection::limit(&mut s.position_shifts, limit);
        Ok(())
    }

    /// `(A + …) p = −D u*/Δt` with the surface's pressure known, Eqs. (14)–(17).
    pub(super) fn solve_pressure(
        &mut self,
        accepted: &State<D>,
        (time, dt): (f64, f64),
        structure: &BoundaryPoints<D>,
        trial: &mut State<D>,
        report: &mut StepReport<D>,
    ) -> Result<(), Error> {
        let s = &mut self.scratch;
        let mut right = std::mem::take(&mut s.right);
        Self::predicted_divergence(s, structure, &mut right);
        s.right = right;
        let a = operator(
            (&self.properties, &self.options),
            Yielding::of(&self.sampling, &self.compliance),
            &s.neighbourhood,
            &s.surface,
            &s.terms,
        );
        s.right.par_iter_mut().with_min_len(ROWS).for_each(|b| *b *= -1.0 / dt);
        if self.options.surface_offset {
            let smoothing_length = self.kernel.smoothing_length();
            s.outside.find((&self.properties, smoothing_length), &s.surface, &s.neighbourhood, accepted);
        } else {
            s.outside.clear(accepted.len());
        }
        if self.options.tearing == Tearing::Everywhere {
            s.torn.iter().for_each(|&a| s.outside.known[a as usize] = self.options.tensile_limit);
        }
        if self.options.surface_offset || self.options.tensile_limit < 0.0 {
            s.of_known.resize(accepted.len(), 0.0);
            a.apply(&s.outside.known, &mut s.of_known, &mut s.operator);
            let drawn = s.of_known.par_iter().zip(&s.outside.drawn_to).zip(&s.terms.draw);
            let right = s.right.par_iter_mut().zip(drawn).with_min_len(LIGHT_ROWS);
            right.for_each(|(b, ((known, drawn_to), draw))| *b += draw * drawn_to - known);
        }
        clear_known(&mut s.right, &s.surface.free);
        let p = &mut trial.pressures;
        let limits = Limits {
            tolerance: self.options.pressure_tolerance,
            iterations: self.options.pressure_iterations_limit,
        };
        let memory = (&mut s.preconditioner, &mut s.operator, &mut s.solver);
        remove_mean_if(s.surface.is_closed(), &mut s.right);
        report.pressure_solve = solve(&a, s.surface.is_closed(), &s.right, p, limits, memory);
        require(&report.pressure_solve, "pressure", time, limits.tolerance)?;
        let iterations = report.pressure_solve.iterations + report.position_solve.iterations;
        if trial.memory.hierarchy.as_mut().is_some_and(|hierarchy| !hierarchy.serves(iterations)) {
            trial.memory.hierarchy = None;
        }
        // An inexact solution can overshoot in energy; the multiple of it that is orthogonal to its residual
        // cannot.
        let pb = parallel::sum(p.len(), |i| p[i] * s.right[i]);
        let pr = parallel::sum(p.len(), |i| p[i] * s.solver.residual()[i]);
        let scale = if pb > 0.0 && pb - pr > 0.0 { pb / (pb - pr) } else { 1.0 };
        let both = p.par_iter_mut().zip(&s.outside.known).with_min_len(ROWS);
        both.for_each(|(p, known)| *p = *p * scale + known);
        Ok(())
    }
}

/// Solves `a x = right` for the unknown entries of `x` from where they stand; known ones become zero. With
/// nothing known, `closed`, `x` is known but for a constant, and its mean is zero.
fn solve<const D: usize>(
    a: &PressureOperator<'_, D>,
    closed: bool,
    right: &[f64],
    x: &mut [f64],
    limits: Limits,
    memory: (&mut PressurePreconditioner<D>, &mut OperatorScratch<D>, &mut conjugate_gradients::Scratch),
) -> Outcome {
    let (preconditioner, operator, solver) = memory;
    clear_known(x, a.free);
    remove_mean_if(closed, x);
    conjugate_gradients::solve(
        |p, out| {
            a.apply(p, out, operator);
            remove_mean_if(closed, out);
        },
        |r, z| {
            preconditioner.apply(r, z);
            remove_mean_if(closed, z);
        },
        right,
        x,
        limits,
        solver,
    )
}

fn clear_known(values: &mut [f64], free: &[bool]) {
    values.par_iter_mut().zip(free).with_min_len(LIGHT_ROWS).for_each(|(value, free)| {
        if !free {
            *value = 0.0;
        }
    });
}

/// Where no pressure is known, in a closed or periodic domain, it is known but for a constant: its mean is
/// zero then, and so is that of the equations, whose sum the operator cannot change but by the disorder of
/// the particles.
fn remove_mean_if(closed: bool, values: &mut [f64]) {
    if closed {
        let mean = parallel::sum(values.len(), |i| values[i]) / values.len() as f64;
        values.par_iter_mut().with_min_len(LIGHT_ROWS).for_each(|v| *v -= mean);
    }
}

/// Nothing, or the error of a solve for `unknown` that missed its `tolerance`.
pub(super) fn require(
    solve: &Outcome,
    unknown: &'static str,
    time: f64,
    tolerance: f64,
) -> Result<(), Error> {
    if solve.converged {
        return Ok(());
    }
    let Outcome { iterations, residual, .. } = *solve;
    Err(Error::Solve { unknown, time, residual, iterations, tolerance })
}
