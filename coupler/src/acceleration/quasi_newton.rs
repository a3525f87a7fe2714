//! Interface quasi-Newton: inverse least squares (IQN-ILS, Degroote, Bathe and Vierendeels 2009) and inverse
//! multi-vector Jacobian (IQN-IMVJ, Bogaers et al. 2014), with the filter of Haelterman et al. 2016.
//!
//! Differences of residuals `V = [Δr]` and of images `W = [Δy]`, the newest first, tell what `H` does:
//! `Δr = V c` was answered by `Δy = W c`. To make the residual zero, `c = argmin ‖V c + r‖`, and the next
//! iterate is `y + W c`. The multi-vector method adds what all earlier windows told, `J_prev`, of which only
//! the factors are kept: `J = J_prev + (W − J_prev V) V⁺`, the next iterate `y − J r`.
//!
//! What earlier windows told is of the map as it was. Where a fluid meets or leaves the structure it changes
//! from one window to the next, and their step may go tens of residuals far, to loads that tear the
//! structure. So a step of more than [`FARTHEST`] residuals is taken by this window's own columns alone, and
//! by relaxation where it has none.
//!
//! The least squares are solved through the factor `R` of `V = Q R`, found as the Cholesky factor of `VᵀV`:
//! its entries are kept, so an iteration costs one product with every column, `O(N m)`, and nothing of the
//! size of the interface is orthogonalised. A column whose part orthogonal to the newer ones is below
//! [`Choice::filter`] of itself is left out (QR2 of Haelterman et al.): what it would add is error. That is
//! also what makes the normal equations safe: with a filter of 1e-3 they lose six of sixteen digits.

mod saved;

use super::blocks::{relax, sizes, weighed};
use crate::flat::{self, dot, dots};
use std::collections::VecDeque;
use std::ops::Range;

/// Below this the Cholesky factor of `VᵀV` would be rounding: the least filter that may be asked for.
pub const LEAST_FILTER: f64 = 1e-6;

/// What a case sets of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Relaxation of an iteration that has no column to go by.
    pub relaxation: f64,
    /// Earlier windows whose differences are used: as columns (inverse least squares), or as factors of
    /// `J_prev` (multi-vector: up to twice as many, before it starts anew from so many).
    pub reused_windows: usize,
    /// Whether the earlier windows make a Jacobian of their own.
    pub multi_vector: bool,
    /// Least share of a column that must be orthogonal to the newer ones.
    pub filter: f64,
    /// Most columns kept, the oldest go first.
    pub columns: usize,
}

/// A pair of differences.
#[derive(Clone, Debug, Default)]
struct Column {
    /// Window in which it arose, counted from the first.
    window: u64,
    residual: Vec<f64>,
    image: Vec<f64>,
    /// Per block, products with the residuals of this column and of all older ones, in their order.
    products: Vec<VecDeque<f64>>,
}

/// What one earlier window adds to `J_prev`: `(W − J V) (VᵀV)⁻¹ Vᵀ`.
#[derive(Clone, Debug)]
struct Factor {
    /// `W − J V`, column by column.
    images: Vec<Vec<f64>>,
    /// `W`, column by column.
    observed: Vec<Vec<f64>>,
    /// `V`, column by column.
    residuals: Vec<Vec<f64>>,
    sizes: Vec<f64>,
    triangle: Triangle,
}

/// The quasi-Newton method with its history.
#[derive(Clone, Debug)]
pub struct QuasiNewton {
    choice: Choice,
    window: u64,
    /// The newest first.
    columns: VecDeque<Column>,
    /// The newest first.
    factors: VecDeque<Factor>,
    /// Image and residual of the last iteration of this window; empty before there is one.
    last: (Vec<f64>, Vec<f64>),
    /// Per column and block, the product of its residuals with the residual at hand.
    with_residual: Vec<Vec<f64>>,
    /// Columns that were dropped, for their memory: it is the system's work to clear new memory, and takes
    /// longer than filling it.
    dropped: Vec<Column>,
    /// The next iterate while it is not yet trusted.
    trial: Vec<f64>,
}

impl QuasiNewton {
    /// Without history.
    pub fn new(choice: Choice) -> Self {
        let choice = Choice { filter: choice.filter.max(LEAST_FILTER), ..choice };
        Self {
            choice,
            window: 0,
            columns: VecDeque::new(),
            factors: VecDeque::new(),
            last: (Vec::new(), Vec::new()),
            with_residual: Vec::new(),
            dropped: Vec::new(),
            trial: Vec::new(),
        }
    }

    /// Whether the earlier windows make a Jacobian of their own.
    pub fn is_multi_vector(&self) -> bool {
        self.choice.multi_vector
    }

    /// Number of columns at hand.
    pub fn columns(&self) -> usize {
        self.columns.len()
    }

    /// See [`super::Acceleration::next`].
    pub fn next(&mut self, blocks: &[Range<usize>], x: &mut [f64], y: &[f64], r: &[f64]) {
        self.learn(blocks, y, r);
        if self.columns.is_empty() && self.factors.is_empty() {
            relax(self.choice.relaxation, x, r);
            return;
        }
        let sizes = sizes(blocks, y);
        let mut trial = std::mem::take(&mut self.trial);
        trial.resize(x.len(), 0.0);
        self.step(blocks, &sizes, self.columns.len(), &mut trial, y, r);
        // What earlier windows told is of another map where the fluid has since met or left the structure.
        let own = self.columns.iter().take_while(|column| column.window == self.window).count();
        let is_all_own = own == self.columns.len() && self.factors.is_empty();
        if is_all_own || is_near(blocks, &sizes, x, &trial, r) {
            x.copy_from_slice(&trial);
        } else if own > 0 {
            let factors = std::mem::take(&mut self.factors);
            self.step(blocks, &sizes, own, x, y, r);
            self.factors = factors;
        } else {
            relax(self.choice.relaxation, x, r);
        }
        self.trial = trial;
    }

    /// The next iterate by the newest `count` columns, and the factors.
    fn step(
        &self,
        blocks: &[Range<usize>],
        sizes: &[f64],
        count: usize,
        next: &mut [f64],
        y: &[f64],
        r: &[f64],
    ) {
        let (kept, triangle) = self.triangle(sizes, count);
        let c = triangle.solve(self.products_with(&kept, sizes));
        // y − J_prev (r − V c) − W c; without factors y − W c.
        let images: Vec<(f64, &[f64])> =
            kept.iter().zip(&c).map(|(&column, &c)| (c, self.columns[column].image.as_slice())).collect();
        flat::subtract_all(next, y, &images);
        if !self.factors.is_empty() {
            let mut unexplained = r.to_vec();
            for (&column, &c) in kept.iter().zip(&c) {
                relax(-c, &mut unexplained, &self.columns[column].residual);
            }
            for factor in &self.factors {
                factor.subtract(blocks, &unexplained, next);
            }
        }
    }

    /// See [`super::Acceleration::end_window`].
    pub fn end_window(&mut self, blocks: &[Range<usize>], y: &[f64], r: &[f64]) {
        let reused = if self.choice.multi_vector { 0 } else { self.choice.reused_windows as u64 };
        if !self.choice.multi_vector {
            // Before the last column is made, which would have products with them.
            self.drop_older_than(self.window + 1, reused);
        }
        self.learn(blocks, y, r);
        self.forget_last();
        if self.choice.multi_vector {
            self.factorise(blocks, y);
        }
        self.window += 1;
        self.drop_older_than(self.window, reused);
    }

    /// Keeps their memory.
    fn forget_last(&mut self) {
        self.last.0.clear();
        self.last.1.clear();
    }

    fn drop_older_than(&mut self, window: u64, reused: u64) {
        while self.columns.back().is_some_and(|column| column.window + reused < window) {
            self.drop_oldest();
        }
    }

    /// See [`super::Acceleration::restart_window`].
    pub fn restart_window(&mut self) {
        self.forget_last();
        // The newest are those of this window.
        while self.columns.front().is_some_and(|column| column.window == self.window) {
            self.dropped.extend(self.columns.pop_front());
        }
    }

    /// A column of the difference to the last iteration of this window, if there is one; and the products of
    /// all columns with the residual `r`.
    fn learn(&mut self, blocks: &[Range<usize>], y: &[f64], r: &[f64]) {
        let (mut last_y, mut last_r) = std::mem::take(&mut self.last);
        if last_r.is_empty() {
            last_y.extend_from_slice(y);
            last_r.extend_from_slice(r);
            self.last = (last_y, last_r);
            let with = |column: &Column| {
                blocks.iter().map(|b| dot(&column.residual[b.clone()], &r[b.clone()])).collect()
            };
            self.with_residual = self.columns.iter().map(with).collect();
            return;
        }
        while self.columns.len() >= self.choice.columns.max(1) {
            self.drop_oldest();
        }
        let mut new = self.dropped.pop().unwrap_or_default();
        new.window = self.window;
        flat::difference(&mut new.residual, r, &last_r);
        flat::difference(&mut new.image, y, &last_y);
        new.products = blocks.iter().map(|_| VecDeque::with_capacity(self.columns.len() + 1)).collect();
        self.with_residual.clear();
        for of in std::iter::once(&new.residual).chain(self.columns.iter().map(|column| &column.residual)) {
            let mut with = Vec::with_capacity(blocks.len());
            for (block, products) in blocks.iter().zip(&mut new.products) {
                let both = [&new.residual[block.clone()], &r[block.clone()]];
                let [with_new, with_r] = dots(&of[block.clone()], both);
                products.push_back(with_new);
                with.push(with_r);
            }
            self.with_residual.push(with);
        }
        last_y.copy_from_slice(y);
        last_r.copy_from_slice(r);
        self.last = (last_y, last_r);
        if new.products.iter().all(|products| products[0] == 0.0) {
            // The same residual again tells nothing.
            self.with_residual.remove(0);
            self.dropped.push(new);
        } else {
            self.columns.push_front(new);
        }
    }

    fn drop_oldest(&mut self) {
        self.dropped.extend(self.columns.pop_back());
        for column in &mut self.columns {
            for products in &mut column.products {
                products.pop_back();
            }
        }
    }

    /// Of the newest `count` columns those that pass the filter, newest first, and the triangle `R` of their
    /// products.
    fn triangle(&self, sizes: &[f64], count: usize) -> (Vec<usize>, Triangle) {
        let mut kept: Vec<usize> = Vec::with_capacity(count);
        let mut triangle = Triangle::default();
        let product = |newer: usize, older: usize| -> f64 {
            let products = &self.columns[newer].products;
            products.iter().zip(sizes).map(|(p, size)| p[older - newer] / (size * size)).sum()
        };
        for column in 0..count {
            let with: Vec<f64> = kept.iter().map(|&newer| product(newer, column)).collect();
            if triangle.append(with, product(column, column), self.choice.filter) {
                kept.push(column);
            }
        }
        (kept, triangle)
    }

    /// `Vᵀ r` of the columns kept, each block weighed by its size.
    fn products_with(&self, kept: &[usize], sizes: &[f64]) -> Vec<f64> {
        let weighed = |with: &Vec<f64>| with.iter().zip(sizes).map(|(p, size)| p / (size * size)).sum();
        kept.iter().map(|&column| weighed(&self.with_residual[column])).collect()
    }

    /// Makes the window's columns a factor of the Jacobian.
    fn factorise(&mut self, blocks: &[Range<usize>], y: &[f64]) {
        let sizes = sizes(blocks, y);
        let (kept, triangle) = self.triangle(&sizes, self.columns.len());
        if kept.is_empty() {
            return;
        }
        let kept = kept.iter().map(|&column| &self.columns[column]);
        let (residuals, observed): (Vec<_>, Vec<_>) =
            kept.map(|column| (column.residual.clone(), column.image.clone())).unzip();
        let mut factor = Factor { images: Vec::new(), observed, residuals, sizes, triangle };
        factor.explain_beyond(blocks, &self.factors);
        self.factors.push_front(factor);
        if self.factors.len() > 2 * self.choice.reused_windows {
            self.restart(blocks);
        }
    }

    /// Forgets all windows but the newest. What a factor holds is what its window told beyond those before
    /// it: without them it would say that `H` hardly answers. So the factors that stay are made anew, of what
    /// was observed (the restart by least squares of Scheufele and Mehl 2017).
    fn restart(&mut self, blocks: &[Range<usize>]) {
        let mut stay = std::mem::take(&mut self.factors);
        stay.truncate(self.choice.reused_windows);
        for mut factor in stay.into_iter().rev() {
            factor.explain_beyond(blocks, &self.factors);
            self.factors.push_front(factor);
        }
    }
}

/// Longest step by what earlier windows told, over the residual. Against an added mass `μ` a step is
/// `1/(1 + μ)` of the residual; one that is longer than it bets on a map that answers by more of the same.
pub const FARTHEST: f64 = 2.0;

/// Whether the step from `x` to `next` is at most [`FARTHEST`] residuals long, each block weighed by its
/// size.
fn is_near(blocks: &[Range<usize>], sizes: &[f64], x: &[f64], next: &[f64], r: &[f64]) -> bool {
    let (mut step, mut residual) = (0.0, 0.0);
    for (block, size) in blocks.iter().zip(sizes) {
        let pairs = x[block.clone()].iter().zip(&next[block.clone()]);
        step += pairs.map(|(x, next)| (next - x).powi(2)).sum::<f64>() / (size * size);
        residual += dot(&r[block.clone()], &r[block.clone()]) / (size * size);
    }
    step <= FARTHEST * FARTHEST * residual
}

impl Factor {
    /// `W − J V` with the `J` of the windows before.
    fn explain_beyond(&mut self, blocks: &[Range<usize>], before: &VecDeque<Self>) {
        self.images.clone_from(&self.observed);
        for (residual, image) in self.residuals.iter().zip(&mut self.images) {
            for factor in before {
                factor.subtract(blocks, residual, image);
            }
        }
    }

    /// `from ← from − (W − J V) V⁺ r`.
    fn subtract(&self, blocks: &[Range<usize>], r: &[f64], from: &mut [f64]) {
        let with = self.residuals.iter().map(|column| weighed(blocks, &self.sizes, column, r)).collect();
        for (image, c) in self.images.iter().zip(self.triangle.solve(with)) {
            relax(-c, from, image);
        }
    }
}

/// The upper triangle `R` with `RᵀR = VᵀV`, column by column.
#[derive(Clone, Debug, Default)]
struct Triangle {
    columns: Vec<Vec<f64>>,
}

impl Triangle {
    /// Appends the column of products with those before it and with itself, unless too little of it is
    /// orthogonal to them.
    fn append(&mut self, mut with: Vec<f64>, own: f64, filter: f64) -> bool {
        for i in 0..with.len() {
            let known: f64 = dot(&self.columns[i][..i], &with[..i]);
            with[i] = (with[i] - known) / self.columns[i][i];
        }
        let orthogonal = own - dot(&with, &with);
        if orthogonal.is_nan() || orthogonal <= filter * filter * own {
            return false;
        }
        with.push(orthogonal.sqrt());
        self.columns.push(with);
        true
    }

    /// `(RᵀR)⁻¹ b`.
    fn solve(&self, mut b: Vec<f64>) -> Vec<f64> {
        let n = self.columns.len();
        for i in 0..n {
            let known: f64 = dot(&self.columns[i][..i], &b[..i]);
            b[i] = (b[i] - known) / self.columns[i][i];
        }
        for i in (0..n).rev() {
            b[i] /= self.columns[i][i];
            for j in 0..i {
                b[j] -= self.columns[i][j] * b[i];
            }
        }
        b
    }
}
