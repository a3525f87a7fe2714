//! The velocity without pressure.

use crate::boundaries::sampling::BoundaryPoints;
use crate::boundaries::ties;
use crate::error::Error;
use crate::isph::options::Tearing;
use crate::isph::pressure::adjoint_pair::AdjointPair;
use crate::isph::pressure::along::BoundaryVelocities;
use crate::isph::solver::Isph;
use crate::isph::state::State;
use crate::isph::step::scratch::{ROWS, Scratch};
use crate::isph::step::solves::require;
use crate::isph::surface::tearing;
use crate::isph::viscosity::{self, Body, ViscousInput};
use crate::report::StepReport;
use rayon::prelude::*;
use sph::{Vector, parallel};

impl<const D: usize> Isph<D> {
    /// `u* = u + Δt (g + viscosity)`, Eq. (12).
    pub(super) fn predict(
        &mut self,
        accepted: &State<D>,
        (time, dt): (f64, f64),
        structure: &BoundaryPoints<D>,
        report: &mut StepReport<D>,
    ) -> Result<(), Error> {
        let viscosity = self.viscosity();
        let s = &mut self.scratch;
        let input = ViscousInput {
            neighbourhood: &s.neighbourhood,
            corrections: &s.corrections,
            positions: &accepted.positions,
            velocities: &accepted.velocities,
            viscosity,
        };
        viscosity::factors(&input, &mut s.viscous_factors);
        viscosity::frictions(
            &s.neighbourhood,
            &self.options,
            viscosity.laminar,
            accepted,
            (&self.walls, structure),
            &mut s.frictions,
        );
        // The velocities that friction is by, and what gravity has given when viscosity is half done:
        // explicit, it comes after it.
        let (rubbing, fallen) = if viscosity.is_implicit(dt) {
            let forces = (&self.properties.gravity, dt);
            let implicit = &mut s.implicit_viscosity;
            report.viscous_solve =
                implicit.solve(&input, &s.viscous_factors, &s.frictions, forces, &mut s.viscous);
            require(&report.viscous_solve, "velocity with viscosity", time, viscosity::TOLERANCE)?;
            (&implicit.mean, self.properties.gravity * (0.5 * dt))
        } else {
            viscosity::accelerations(&input, &s.viscous_factors, &mut s.viscous);
            for friction in &s.frictions {
                s.viscous[friction.particle as usize] += friction.acceleration(&accepted.velocities);
            }
            (&accepted.velocities, Vector::zeros())
        };
        s.contact_impulses.clear();
        s.contact_impulses.resize(self.sampling.len(), Vector::zeros());
        s.wall_forces.clear(self.walls.parts.len());
        let mass = self.properties.particle_mass();
        for friction in &s.frictions {
            let force = friction.acceleration(rubbing) * mass;
            match friction.body {
                Body::Structure(i) => s.contact_impulses[i] += force * dt,
                Body::Wall(part) => {
                    s.wall_forces.add(part, &-force, &accepted.positions[friction.particle as usize]);
                }
            }
        }
        let gravity = self.properties.gravity;
        s.predicted.resize(accepted.len(), Vector::zeros());
        s.predicted
            .par_iter_mut()
            .with_min_len(ROWS)
            .zip(&accepted.velocities)
            .zip(&s.viscous)
            .for_each(|((predicted, u), viscous)| *predicted = u + (viscous + gravity) * dt);
        report.viscous_work = mass
            * parallel::sum(accepted.len(), |a| {
                let kick = s.viscous[a] * dt;
                kick.dot(&(accepted.velocities[a] + kick * 0.5 + fallen))
            });
        let near = &s.neighbourhood.walls;
        self.walls.velocities_across(&accepted.positions, near, &mut s.wall_velocities);
        ties::leave_to_structure(&s.ties, self.walls.positions.len(), near, &mut s.wall_velocities);
        Ok(())
    }

    /// `D u*` (1/s) of every particle.
    pub(super) fn predicted_divergence(
        scratch: &mut Scratch<D>,
        structure: &BoundaryPoints<D>,
        out: &mut Vec<f64>,
    ) {
        let Scratch { neighbourhood, terms, predicted, operator, .. } = scratch;
        let pair = AdjointPair { neighbourhood, along: &terms.along, own: &terms.own };
        let boundaries =
            BoundaryVelocities { walls: &scratch.wall_velocities, structure: &structure.unloaded };
        operator.fluid.clone_from(predicted);
        pair.divergence(&mut operator.fluid, &boundaries, &mut operator.own_terms, out);
    }

    /// Settles which pressures are known, and tells the preconditioner.
    pub(super) fn find_known(&mut self, accepted: &State<D>, structure: &BoundaryPoints<D>) {
        let s = &mut self.scratch;
        s.torn.clear();
        if self.options.tearing != Tearing::Off {
            let mut parting = std::mem::take(&mut s.parting);
            Self::predicted_divergence(s, structure, &mut parting);
            s.parting = parting;
            let noise = tearing::NOISE * self.properties.density * self.reference_velocity.powi(2);
            let limit = self.options.tensile_limit - noise;
            let law = (self.options.tearing, limit);
            tearing::find(law, &s.parting, &s.neighbourhood, accepted, &mut s.surface, &mut s.torn);
        }
        s.preconditioner.fit(&s.surface.free, &s.diagonal, 1.0 / self.properties.density);
    }
}
