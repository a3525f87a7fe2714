//! Viscosity over steps that are long beside `h²/ν`: two stages, each a symmetric positive definite system.
//!
//! `u' = f − K u` by the method of two stages, singly diagonally implicit, of second order and stable for any
//! step (Alexander 1977): `(1 + γ Δt K) u_1 = u + γ Δt f`, `(1 + γ Δt K) u_2 = u + (1 − γ) Δt (f − K u_1) + γ
//! Δt f` with `γ = 1 − 1/√2`. `f` is gravity and what boundaries drag along, `K` the pairs of fluid and the
//! friction. What bodies get is by the mean velocity of the stages, `ū = (1 − γ) u_1 + γ u_2`, so that
//! momentum is kept as well as the systems are solved.

use super::{Friction, ViscousInput, of_pairs};
use crate::isph::pressure::conjugate_gradients::{self, Limits};
use crate::report::Outcome;
use rayon::prelude::*;
use sph::Vector;
use std::f64::consts::FRAC_1_SQRT_2;

/// Residual over right-hand side; momentum is kept to it.
pub const TOLERANCE: f64 = 1e-9;

/// Most iterations.
const ITERATIONS: usize = 1000;

/// Particles that one task works through at least.
const ROWS: usize = 128;

/// Memory of the solve. Components of a particle stand side by side.
#[derive(Clone, Debug, Default)]
pub struct ImplicitViscosity<const D: usize> {
    /// Σ of the friction's rates (1/s) and `Σ rate u_b` (m/s²).
    drag: Vec<(f64, Vector<D>)>,
    diagonal: Vec<f64>,
    right: Vec<f64>,
    stages: [Vec<f64>; 2],
    rate: Vec<f64>,
    solver: conjugate_gradients::Scratch,
    /// `ū` (m/s): the velocities that the forces of the step are by.
    pub mean: Vec<Vector<D>>,
}

impl<const D: usize> ImplicitViscosity<D> {
    /// Writes the viscous accelerations (m/s²) over a step of `dt` (s) under `gravity` (m/s²).
    pub fn solve(
        &mut self,
        input: &ViscousInput<'_, D>,
        factors: &[f64],
        frictions: &[Friction<D>],
        (gravity, dt): (&Vector<D>, f64),
        out: &mut Vec<Vector<D>>,
    ) -> Outcome {
        let gamma = 1.0 - FRAC_1_SQRT_2;
        let count = input.velocities.len();
        self.drag.clear();
        self.drag.resize(count, (0.0, Vector::zeros()));
        for friction in frictions {
            let (rate, drawn) = &mut self.drag[friction.particle as usize];
            *rate += friction.rate;
            *drawn += friction.velocity * friction.rate;
        }
        let drag = &self.drag;
        // f − K v
        let rate = |v: &[f64], out: &mut [f64]| {
            let at = |b: usize| Vector::<D>::from_column_slice(&v[b * D..(b + 1) * D]);
            out.par_chunks_mut(D).with_min_len(ROWS).enumerate().for_each(|(a, out)| {
                let held = drag[a].1 - at(a) * drag[a].0 + gravity;
                out.copy_from_slice((of_pairs(input, factors, a, at) + held).as_slice());
            });
        };
        // (1 + γ Δt K) v
        let operator = |v: &[f64], out: &mut [f64]| {
            let at = |b: usize| Vector::<D>::from_column_slice(&v[b * D..(b + 1) * D]);
            out.par_chunks_mut(D).with_min_len(ROWS).enumerate().for_each(|(a, out)| {
                let taken = at(a) * drag[a].0 - of_pairs(input, factors, a, at);
                out.copy_from_slice((at(a) + taken * (gamma * dt)).as_slice());
            });
        };
        self.diagonal.resize(count * D, 0.0);
        self.diagonal.par_chunks_mut(D).with_min_len(ROWS).enumerate().for_each(|(a, diagonal)| {
            for (i, value) in diagonal.iter_mut().enumerate() {
                let unit = |b: usize| Vector::from_fn(|k, _| f64::from(u8::from(b == a && k == i)));
                *value = 1.0 + gamma * dt * (drag[a].0 - of_pairs(input, factors, a, unit)[i]);
            }
        });
        let diagonal = &self.diagonal;
        let precondition = |r: &[f64], z: &mut [f64]| {
            let values = z.par_iter_mut().zip(r).zip(diagonal).with_min_len(ROWS * D);
            values.for_each(|((z, r), diagonal)| *z = r / diagonal);
        };
        let limits = Limits { tolerance: TOLERANCE, iterations: ITERATIONS };
        let flat = |a: usize| &input.velocities[a / D][a % D];
        let forcing = |i: usize| drag[i / D].1[i % D] + gravity[i % D];

        let [first, second] = &mut self.stages;
        for stage in [&mut *first, &mut *second, &mut self.right, &mut self.rate] {
            stage.resize(count * D, 0.0);
        }
        self.right.par_iter_mut().with_min_len(ROWS * D).enumerate().for_each(|(i, right)| {
            *right = flat(i) + gamma * dt * forcing(i);
        });
        first.copy_from_slice(&self.right);
        let one =
            conjugate_gradients::solve(operator, precondition, &self.right, first, limits, &mut self.solver);
        rate(first, &mut self.rate);
        let right = self.right.par_iter_mut().zip(&self.rate).with_min_len(ROWS * D).enumerate();
        right.for_each(|(i, (right, rate))| {
            *right = flat(i) + (1.0 - gamma) * dt * rate + gamma * dt * forcing(i);
        });
        second.copy_from_slice(first);
        let two =
            conjugate_gradients::solve(operator, precondition, &self.right, second, limits, &mut self.solver);

        self.mean.resize(count, Vector::zeros());
        out.resize(count, Vector::zeros());
        for (a, (mean, acceleration)) in self.mean.iter_mut().zip(&mut *out).enumerate() {
            let at = |stage: &[f64]| Vector::<D>::from_column_slice(&stage[a * D..(a + 1) * D]);
            *mean = at(first) * (1.0 - gamma) + at(second) * gamma;
            *acceleration = (at(second) - input.velocities[a]) / dt - gravity;
        }
        if one.converged && two.converged {
            Outcome { iterations: one.iterations + two.iterations, ..two }
        } else if one.converged {
            two
        } else {
            one
        }
    }
}
