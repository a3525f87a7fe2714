//! Preconditioned conjugate gradients.
//!
//! Hestenes and Stiefel (1952). The operator and the preconditioner must be symmetric positive definite and
//! must not change between iterations.

use crate::report::Outcome;
use rayon::prelude::*;

/// Unknowns summed by one task, fixed so that rounding does not depend on the number of threads.
const CHUNK: usize = 512;

/// Chunks that one thread works through at least: handing over fewer takes longer than summing them.
const CHUNKS: usize = 8;

/// Vectors that a solve works with; kept between solves, they are allocated once.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    residual: Vec<f64>,
    preconditioned: Vec<f64>,
    direction: Vec<f64>,
    product: Vec<f64>,
    partial: Vec<f64>,
}

impl Scratch {
    /// `b − A x` of the last solve, as the recurrence carries it.
    pub fn residual(&self) -> &[f64] {
        &self.residual
    }
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Residual norm relative to that of the right-hand side at which the solve has converged.
    pub tolerance: f64,
    /// Most iterations to take.
    pub iterations: usize,
}

/// Solves `A x = b` from the start `x`, or from zero where that is nearer; `operator(v, out)` writes `A v`,
/// `preconditioner(r, out)` an approximation of `A⁻¹ r`.
pub fn solve(
    mut operator: impl FnMut(&[f64], &mut [f64]),
    mut preconditioner: impl FnMut(&[f64], &mut [f64]),
    b: &[f64],
    x: &mut [f64],
    limits: Limits,
    scratch: &mut Scratch,
) -> Outcome {
    assert_eq!(b.len(), x.len(), "one unknown for every equation");
    let n = b.len();
    let Scratch { residual, preconditioned, direction, product, partial } = scratch;
    for v in [&mut *residual, &mut *preconditioned, &mut *direction, &mut *product] {
        v.resize(n, 0.0);
    }
    partial.resize(n.div_ceil(CHUNK), 0.0);

    let b_norm = dot(b, b, partial).sqrt();
    if b_norm == 0.0 {
        x.fill(0.0);
        residual.fill(0.0);
        return Outcome { iterations: 0, residual: 0.0, converged: true };
    }
    let target = limits.tolerance * b_norm;
    operator(x, product);
    let mut r_norm = subtract(b, product, residual, partial).sqrt();
    if r_norm > b_norm {
        x.fill(0.0);
        residual.copy_from_slice(b);
        r_norm = b_norm;
    }
    let mut rz = 1.0;
    let mut iterations = 0;
    // Also left when something is not finite: no comparison with it holds.
    while r_norm > target && iterations < limits.iterations {
        preconditioner(residual, preconditioned);
        let rz_new = dot(residual, preconditioned, partial);
        let beta = if iterations == 0 { 0.0 } else { rz_new / rz };
        rz = rz_new;
        turn(beta, preconditioned, direction);
        operator(direction, product);
        let alpha = rz / dot(direction, product, partial);
        r_norm = advance(alpha, direction, product, x, residual, partial).sqrt();
        iterations += 1;
    }
    Outcome { iterations, residual: r_norm / b_norm, converged: r_norm <= target }
}

/// `Σ a_i b_i`.
fn dot(a: &[f64], b: &[f64], partial: &mut [f64]) -> f64 {
    let of = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    partial
        .par_iter_mut()
        .zip(a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK)))
        .with_min_len(CHUNKS)
        .for_each(|(sum, (a, b))| *sum = of(a, b));
    partial.iter().sum()
}

/// `r = b − product`; returns `|r|²`.
fn subtract(b: &[f64], product: &[f64], r: &mut [f64], partial: &mut [f64]) -> f64 {
    partial
        .par_iter_mut()
        .zip(r.par_chunks_mut(CHUNK).zip(b.par_chunks(CHUNK).zip(product.par_chunks(CHUNK))))
        .with_min_len(CHUNKS)
        .for_each(|(sum, (r, (b, product)))| {
            *sum = 0.0;
            for ((r, b), q) in r.iter_mut().zip(b).zip(product) {
                *r = b - q;
                *sum += *r * *r;
            }
        });
    partial.iter().sum()
}

/// `direction = preconditioned + β direction`.
fn turn(beta: f64, preconditioned: &[f64], direction: &mut [f64]) {
    let both = direction.par_chunks_mut(CHUNK).zip(preconditioned.par_chunks(CHUNK));
    both.with_min_len(CHUNKS).for_each(|(d, z)| {
        for (d, z) in d.iter_mut().zip(z) {
            // A first direction of an earlier solve may hold anything: β = 0 must not multiply it.
            *d = if beta == 0.0 { *z } else { z + beta * *d };
        }
    });
}

/// `x += α direction`, `r −= α product`; returns `|r|²`.
fn advance(
    alpha: f64,
    direction: &[f64],
    product: &[f64],
    x: &mut [f64],
    r: &mut [f64],
    partial: &mut [f64],
) -> f64 {
    partial
        .par_iter_mut()
        .zip(x.par_chunks_mut(CHUNK).zip(r.par_chunks_mut(CHUNK)))
        .zip(direction.par_chunks(CHUNK).zip(product.par_chunks(CHUNK)))
        .with_min_len(CHUNKS)
        .for_each(|((sum, (x, r)), (d, q))| {
            *sum = 0.0;
            for k in 0..x.len() {
                x[k] += alpha * d[k];
                r[k] -= alpha * q[k];
                *sum += r[k] * r[k];
            }
        });
    partial.iter().sum()
}
