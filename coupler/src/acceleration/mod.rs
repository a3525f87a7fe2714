//! Accelerations of the fixed-point iteration `x ← H(x)` within a window: from iterates and their images, the
//! next iterate.
//!
//! `x` are the unknowns of the coupling (the load; with a parallel scheme the velocity too), `y = H(x)` what
//! the solvers answer, `r = y − x` the residual. Everything here is a function of slices: no participant, no
//! file, no clock.
//!
//! | method | next iterate | file |
//! |---|---|---|
//! | constant relaxation | `x + ω r` | here |
//! | Aitken | `x + ω_k r`, `ω_k = −ω_{k−1} r_{k−1}·Δr / Δr·Δr` | [`aitken`] |
//! | IQN-ILS | `y + W c`, `c = argmin ‖V c + r‖` over differences of this and reused windows | [`quasi_newton`] |
//! | IQN-IMVJ | `y − J r`, `J = J_prev + (W − J_prev V) V⁺` | [`quasi_newton`] |

pub mod aitken;
mod blocks;
pub mod quasi_newton;
#[cfg(test)]
mod tests;

use aitken::Aitken;
use blocks::relax;
use interfaces::case::coupling::{self, AccelerationMethod};
use quasi_newton::{Choice, QuasiNewton};
use std::ops::Range;
use words::bytes::{self, Reader, Writer};

/// The method, with what it remembers.
#[derive(Clone, Debug)]
pub enum Acceleration {
    /// `x + ω r`.
    Constant(f64),
    /// Aitken's dynamic relaxation.
    Aitken(Aitken),
    /// Interface quasi-Newton, by inverse least squares or multi-vector.
    QuasiNewton(Box<QuasiNewton>),
}

impl Acceleration {
    /// As the case has it; `relaxation` where the method has no better.
    pub fn of(choice: &coupling::Acceleration, relaxation: f64) -> Self {
        let quasi_newton = |multi_vector| {
            Self::QuasiNewton(Box::new(QuasiNewton::new(Choice {
                relaxation,
                reused_windows: choice.reused_windows as usize,
                multi_vector,
                filter: choice.filter,
                columns: choice.max_columns as usize,
            })))
        };
        match choice.method {
            AccelerationMethod::Constant => Self::Constant(relaxation),
            AccelerationMethod::Aitken => Self::Aitken(Aitken::new(relaxation)),
            AccelerationMethod::IqnIls => quasi_newton(false),
            AccelerationMethod::IqnImvj => quasi_newton(true),
        }
    }

    /// Replaces the iterate `x` by the next one, from its image `y` and the residual `r = y − x`.
    ///
    /// `blocks` are the parts of the vectors of one quantity each: load, velocity. They differ by many orders
    /// of magnitude, and a method that weighs them together weighs each by its own size.
    pub fn next(&mut self, blocks: &[Range<usize>], x: &mut [f64], y: &[f64], r: &[f64]) {
        match self {
            Self::Constant(omega) => relax(*omega, x, r),
            Self::Aitken(aitken) => {
                let omega = aitken.relaxation(blocks, y, r);
                relax(omega, x, r);
            }
            Self::QuasiNewton(quasi_newton) => quasi_newton.next(blocks, x, y, r),
        }
    }

    /// The window is final: its last iterates are history. `y` and `r` are those that ended it.
    pub fn end_window(&mut self, blocks: &[Range<usize>], y: &[f64], r: &[f64]) {
        match self {
            Self::Constant(_) => {}
            Self::Aitken(aitken) => aitken.end_window(),
            Self::QuasiNewton(quasi_newton) => quasi_newton.end_window(blocks, y, r),
        }
    }

    /// Writes the method and what it remembers from window to window: constant relaxation and Aitken's
    /// nothing.
    pub fn save(&self, state: &mut Writer) {
        state.text(self.name());
        if let Self::QuasiNewton(quasi_newton) = self {
            quasi_newton.save(state);
        }
    }

    /// Goes to what [`save`](Self::save) wrote, of so many `unknowns` in so many `blocks`.
    pub fn restore(
        &mut self,
        state: &mut Reader<'_>,
        blocks: usize,
        unknowns: usize,
    ) -> Result<(), bytes::Error> {
        match state.text("acceleration")? {
            method if method == self.name() => {}
            other => return Err(state.refuse("acceleration", other)),
        }
        match self {
            Self::Constant(_) => {}
            Self::Aitken(aitken) => aitken.end_window(),
            Self::QuasiNewton(quasi_newton) => quasi_newton.restore(state, blocks, unknowns)?,
        }
        Ok(())
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Constant(_) => "constant relaxation",
            Self::Aitken(_) => "Aitken",
            Self::QuasiNewton(quasi_newton) if quasi_newton.is_multi_vector() => "IQN-IMVJ",
            Self::QuasiNewton(_) => "IQN-ILS",
        }
    }

    /// The window starts anew with another size: what its iterates told so far is of another map, and is
    /// forgotten.
    pub fn restart_window(&mut self) {
        match self {
            Self::Constant(_) => {}
            Self::Aitken(aitken) => aitken.end_window(),
            Self::QuasiNewton(quasi_newton) => quasi_newton.restart_window(),
        }
    }
}
