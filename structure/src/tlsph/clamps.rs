//! Clamps that move: fixed particles are put where their law says at the time of each stage, and the work is
//! counted that it takes.
//!
//! The internal forces on all particles have the power `−dE/dt` of the strain energy `E`. Those on the free
//! ones change their kinetic energy; so what the clamps give to both is the power `−Σ f_c·u_c` of the
//! internal forces `f_c` on fixed particles, integrated with the weights of the Runge–Kutta step like that of
//! the loads.

use crate::lanes::LANES;
use crate::tlsph::kernels::{self, row};
use crate::tlsph::total_lagrangian::TotalLagrangian;

impl<const D: usize> TotalLagrangian<D> {
    /// Puts the fixed particles that move where they are at a time (s), as displacements and velocities of
    /// the stage.
    pub(super) fn move_clamps(&mut self, time: f64) {
        let Self { particles, numbering, fields, .. } = self;
        particles.follow_clamps(time, |user, displacement, velocity| {
            let internal = numbering.internal_of[user] as usize;
            fields.displacement.set_vector(internal, &displacement);
            for i in 0..D {
                fields.step.set(row::STAGE_VELOCITY * D + i, internal, velocity[i]);
            }
        });
    }

    /// The same as a result of the step.
    pub(super) fn leave_clamps(&mut self, time: f64) {
        self.move_clamps(time);
        let Self { particles, numbering, fields, .. } = self;
        particles.follow_clamps(time, |user, displacement, velocity| {
            let internal = numbering.internal_of[user] as usize;
            for i in 0..D {
                fields.step.set(row::START_DISPLACEMENT * D + i, internal, displacement[i]);
                fields.step.set(row::START_VELOCITY * D + i, internal, velocity[i]);
            }
        });
    }

    /// Power (W) that the clamps give to the structure in a stage, from its conjugates and velocities.
    pub(super) fn clamp_power(&self) -> f64 {
        let (gradient, fields) = (self.particles.setup.options.gradient, &self.fields);
        let mut power = 0.0;
        kernels::visit_clamp_forces::<D>(gradient, &self.stencil, fields, &self.clamp_slices, |s, force| {
            for lane in 0..LANES {
                let internal = s * LANES + lane;
                for i in 0..D {
                    power -= force[i].0[lane] * fields.step.get(row::STAGE_VELOCITY * D + i, internal);
                }
            }
        });
        power
    }
}
