//! The time step: the paper's fourth-order Runge–Kutta scheme, Eqs. (43)–(45), over the sub-steps of one
//! window.
//!
//! `x` and `u` at the end are those at the start plus `Δt/6 (k₁ + 2 (k₂ + k₃) + k₄)` with `k_r` the stage's
//! velocity and `k_u` its acceleration; the stages' velocities are `k_r2 = u + k_u1 Δt/2`,
//! `k_r3 = u + k_u2 Δt/2`, `k_r4 = u + k_u3 Δt` (the paper's Eq. (45) drops `u`). Fixed particles that move
//! are at each stage where their law says at its time.

use crate::contact::Contact;
use crate::error::Error;
use crate::loads::Load;
use crate::state::{Report, STEP_TOLERANCE, State};
use crate::tlsph::contacts::Meeting;
use crate::tlsph::kernels::{self, Stage};
use crate::tlsph::total_lagrangian::TotalLagrangian;

/// The stages: time of evaluation and of the next stage over `Δt`, weight.
const STAGES: [(f64, Option<f64>, f64); 4] =
    [(0.0, Some(0.5), 1.0), (0.5, Some(0.5), 2.0), (0.5, Some(1.0), 2.0), (1.0, None, 1.0)];

impl<const D: usize> TotalLagrangian<D> {
    /// Solves a window: see [`Solid::advance`](crate::solid::Solid::advance).
    pub(super) fn solve(
        &mut self,
        from: &State<D>,
        to: &mut State<D>,
        dt: f64,
        sub_steps: usize,
        load: &Load<D>,
    ) -> Result<Report, Error> {
        Self::check_window(from, dt, sub_steps)?;
        let mut contact = self.contact.take();
        let report = self.sub_steps(from, to, (dt, sub_steps), load, contact.as_mut());
        self.contact = contact;
        report
    }

    fn sub_steps(
        &mut self,
        from: &State<D>,
        to: &mut State<D>,
        (dt, sub_steps): (f64, usize),
        load: &Load<D>,
        contact: Option<&mut Contact<D>>,
    ) -> Result<Report, Error> {
        self.particles.check_load(load, from.time)?;
        self.load_state(from)?;
        let sub_step = dt / sub_steps as f64;
        let moves = self.particles.clamps_move();
        let mut clamp_work = 0.0;
        let mut met = Meeting::begin(self, contact, from, sub_step);
        let varies = self.load_varies(load, from.time, from.time + dt);
        if !varies {
            self.fill_external(load, from.time, 0.0);
        }
        for n in 0..sub_steps {
            met.follow(self, from.time + n as f64 * sub_step);
            for (at, next, weight) in STAGES {
                let elapsed = (n as f64 + at) * sub_step;
                if moves {
                    self.move_clamps(from.time + elapsed);
                }
                if varies {
                    self.fill_external(load, from.time + elapsed, elapsed / dt);
                }
                if let Some(slice) = self.stresses() {
                    return Err(self.inversion(slice, from.time + elapsed));
                }
                let touches = met.act(self, from.time + elapsed, weight * sub_step / 6.0)?;
                let stage = Stage {
                    weight,
                    to_next: next.map(|fraction| fraction * sub_step),
                    sixth: sub_step / 6.0,
                    damping: self.particles.setup.options.damping,
                    loaded: touches || self.is_loaded(load),
                };
                if moves {
                    clamp_work += self.clamp_power() * (stage.weight * stage.sixth);
                }
                kernels::stage_pass(
                    D,
                    self.particles.setup.options.gradient,
                    &self.stencil,
                    &stage,
                    &mut self.fields,
                );
                met.leave(self);
            }
            met.settle(self, from.time + (n + 1) as f64 * sub_step)?;
        }
        if moves {
            self.leave_clamps(from.time + dt);
        }
        met.measure(self, from.time + dt)?;
        self.store_state(from, to, dt)?;
        to.energy.clamp_work = from.energy.clamp_work + clamp_work;
        met.end(from, to);
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
