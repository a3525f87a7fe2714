//! The time step: the paper's fourth-order Runge–Kutta scheme, Eqs. (43)–(45), over the sub-steps of one
//! window.
//!
//! `x` and `u` at the end are those at the start plus `Δt/6 (k₁ + 2 (k₂ + k₃) + k₄)` with `k_r` the stage's
//! velocity and `k_u` its acceleration; the stages' velocities are `k_r2 = u + k_u1 Δt/2`,
//! `k_r3 = u + k_u2 Δt/2`, `k_r4 = u + k_u3 Δt` (the paper's Eq. (45) drops `u`).

use crate::kernels::{self, Stage};
use crate::state::{Report, State};
use crate::structure::Structure;
use crate::{Error, Load};

/// The stages: time of evaluation and of the next stage over `Δt`, weight.
const STAGES: [(f64, Option<f64>, f64); 4] =
    [(0.0, Some(0.5), 1.0), (0.5, Some(0.5), 2.0), (0.5, Some(1.0), 2.0), (1.0, None, 1.0)];

/// A sub-step may exceed the stable one by round-off of the division that made it.
const STEP_TOLERANCE: f64 = 1.0 + 1e-9;

impl<const D: usize> Structure<D> {
    /// Solves one window of length `dt` (s) in `sub_steps` equal steps from the accepted state `from`, which
    /// is not changed, to `to`, whose memory is used again. The load belongs to the interface particles.
    /// Repeatable to the bit.
    ///
    /// Where it fails, `to` holds nothing of use.
    pub fn advance(
        &mut self,
        from: &State<D>,
        to: &mut State<D>,
        dt: f64,
        sub_steps: usize,
        load: &Load<D>,
    ) -> Result<Report, Error> {
        if kernels::is_shared(self.stencil.slices.len()) {
            // Into the pool once a window: from outside, each pass would wait for a worker to wake up and for
            // its answer.
            rayon::scope(|_| self.solve(from, to, dt, sub_steps, load))
        } else {
            self.solve(from, to, dt, sub_steps, load)
        }
    }

    fn solve(
        &mut self,
        from: &State<D>,
        to: &mut State<D>,
        dt: f64,
        sub_steps: usize,
        load: &Load<D>,
    ) -> Result<Report, Error> {
        Self::check_window(from, dt, sub_steps)?;
        self.check_load(load, from.time)?;
        self.load_state(from)?;
        let sub_step = dt / sub_steps as f64;
        let varies = self.load_varies(load, from.time, from.time + dt);
        if !varies {
            self.fill_external(load, from.time, 0.0);
        }
        for n in 0..sub_steps {
            for (at, next, weight) in STAGES {
                let elapsed = (n as f64 + at) * sub_step;
                if varies {
                    self.fill_external(load, from.time + elapsed, elapsed / dt);
                }
                if let Some(slice) = self.stresses() {
                    return Err(self.inversion(slice, from.time + elapsed));
                }
                let stage = Stage {
                    weight,
                    to_next: next.map(|fraction| fraction * sub_step),
                    sixth: sub_step / 6.0,
                    damping: self.setup.options.damping,
                    loaded: self.is_loaded(load),
                };
                kernels::stage_pass(D, self.setup.options.gradient, &self.stencil, &stage, &mut self.fields);
            }
        }
        self.store_state(from, to, dt)?;
        Ok(Report { sub_steps, sub_step })
    }

    fn check_window(from: &State<D>, window: f64, sub_steps: usize) -> Result<(), Error> {
        let time = from.time;
        if !(window > 0.0 && window.is_finite() && sub_steps > 0) {
            return Err(Error::Window { time, window, sub_steps });
        }
        let sub_step = window / sub_steps as f64;
        let stable = from.stability.step;
        if sub_step > stable * STEP_TOLERANCE {
            let remedy = from.stable_sub_steps(window);
            return Err(Error::Unstable { time, sub_step, stable, window, remedy });
        }
        Ok(())
    }
}

impl<const D: usize> State<D> {
    /// The number of sub-steps in a window of length `dt` (s) from this state that stability asks for.
    pub fn stable_sub_steps(&self, dt: f64) -> usize {
        ((dt / (self.stability.step * STEP_TOLERANCE)).ceil() as usize).max(1)
    }
}
