//! Preconditioned conjugate gradients for the pressure, with the one place where a preconditioner is applied.

use crate::pressure_operator::{OperatorScratch, PressureOperator};
use rayon::prelude::*;
use sph::parallel;

/// What a solve came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Solve {
    /// Iterations.
    pub iterations: usize,
    /// `|b − A p|/|b|` at the end.
    pub residual: f64,
    /// Whether the tolerance was reached.
    pub converged: bool,
}

/// Memory of the solver.
#[derive(Clone, Debug, Default)]
pub struct SolverScratch<const D: usize> {
    /// The residual `b − A p` after a solve.
    pub residual: Vec<f64>,
    preconditioned: Vec<f64>,
    direction: Vec<f64>,
    image: Vec<f64>,
    /// For the operator.
    pub operator: OperatorScratch<D>,
}

/// Solves `(A + …) p = b` on the unknown pressures, starting from `p`; known ones must be zero in `p` and `b`.
/// `precondition(r, z)` sets `z ≈ A⁻¹ r`, must be symmetric and positive, and leaves known entries zero.
pub fn solve<const D: usize>(
    operator: &PressureOperator<'_, D>,
    b: &[f64],
    p: &mut [f64],
    tolerance: f64,
    iteration_limit: usize,
    scratch: &mut SolverScratch<D>,
    mut precondition: impl FnMut(&[f64], &mut [f64]),
) -> Solve {
    let n = b.len();
    let SolverScratch { residual, preconditioned, direction, image, operator: operator_scratch } = scratch;
    for field in [&mut *residual, preconditioned, direction, image] {
        field.resize(n, 0.0);
    }
    let dot = |x: &[f64], y: &[f64]| parallel::sum(n, |i| x[i] * y[i]);
    let norm_b = dot(b, b).sqrt();
    if norm_b == 0.0 {
        p.fill(0.0);
        residual.fill(0.0);
        return Solve { iterations: 0, residual: 0.0, converged: true };
    }
    operator.apply(p, image, operator_scratch);
    for i in 0..n {
        residual[i] = b[i] - image[i];
    }
    let mut relative = dot(residual, residual).sqrt() / norm_b;
    if relative > 1.0 {
        // The start is worse than none.
        p.fill(0.0);
        residual.copy_from_slice(b);
        relative = 1.0;
    }
    let mut rho = 0.0;
    let mut iterations = 0;
    while relative > tolerance && iterations < iteration_limit {
        precondition(residual, preconditioned);
        let rho_new = dot(residual, preconditioned);
        let beta = if iterations == 0 { 0.0 } else { rho_new / rho };
        rho = rho_new;
        direction
            .par_iter_mut()
            .with_min_len(4096)
            .zip(&*preconditioned)
            .for_each(|(d, z)| *d = z + beta * *d);
        operator.apply(direction, image, operator_scratch);
        let curvature = dot(direction, image);
        // Not positive only when the preconditioner or the operator is broken, or everything is zero to rounding.
        if curvature.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            break;
        }
        let step = rho / curvature;
        p.par_iter_mut()
            .zip(residual.par_iter_mut())
            .with_min_len(4096)
            .zip(&*direction)
            .zip(&*image)
            .for_each(|(((p, r), d), q)| {
                *p += step * d;
                *r -= step * q;
            });
        relative = dot(residual, residual).sqrt() / norm_b;
        iterations += 1;
    }
    Solve { iterations, residual: relative, converged: relative <= tolerance }
}
