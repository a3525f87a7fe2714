//! Aitken's dynamic relaxation for vectors (Küttler and Wall 2008, Computational Mechanics 43, 61–72, Eq.
//! 44).

use super::blocks::{sizes, weighed};
use std::ops::Range;

/// Largest magnitude of a relaxation factor: where two residuals hardly differ, the quotient says nothing.
const LIMIT: f64 = 10.0;

/// The relaxation of the last iteration, and its residual.
#[derive(Clone, Debug)]
pub struct Aitken {
    first: f64,
    omega: f64,
    /// Residual of the last iteration of this window; empty before the second.
    last: Vec<f64>,
    difference: Vec<f64>,
}

impl Aitken {
    /// With the relaxation of every window's first iteration.
    pub fn new(first: f64) -> Self {
        Self { first, omega: first, last: Vec::new(), difference: Vec::new() }
    }

    /// The factor for the residual `r` of the image `y`. Two residuals that are the same keep the last
    /// factor.
    pub fn relaxation(&mut self, blocks: &[Range<usize>], y: &[f64], r: &[f64]) -> f64 {
        self.omega = if self.last.is_empty() {
            self.first
        } else {
            self.difference.clear();
            self.difference.extend(r.iter().zip(&self.last).map(|(r, last)| r - last));
            let sizes = sizes(blocks, y);
            let change = weighed(blocks, &sizes, &self.difference, &self.difference);
            let along = weighed(blocks, &sizes, &self.last, &self.difference);
            let omega = -self.omega * along / change;
            if change > 0.0 && omega.is_finite() && omega != 0.0 {
                omega.clamp(-LIMIT, LIMIT)
            } else {
                self.omega
            }
        };
        self.last.clear();
        self.last.extend_from_slice(r);
        self.omega
    }

    /// The next window starts with the first factor.
    pub fn end_window(&mut self) {
        self.last.clear();
    }
}
