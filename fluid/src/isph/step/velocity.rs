//! From pressure to velocity, and the loads that go with it.

use crate::boundaries::sampling::BoundaryPoints;
use crate::isph::interface_load::{self, Carried};
use crate::isph::options::{Load, Scheme};
use crate::isph::pressure::adjoint_pair::AdjointPair;
use crate::isph::pressure::along::Row;
use crate::isph::pressure::velocity_correction;
use crate::isph::solver::Isph;
use crate::isph::state::State;
use crate::isph::step::scratch::ROWS;
use crate::report::StepReport;
use rayon::prelude::*;
use sph::{Vector, parallel};

impl<const D: usize> Isph<D> {
    /// `u = u* + Δt a(p)`, Eq. (18): the symmetric gradient, and of the corrected one what does not raise the
    /// energy.
    pub(super) fn correct_velocity(
        &mut self,
        dt: f64,
        structure: &BoundaryPoints<D>,
        trial: &mut State<D>,
        report: &mut StepReport<D>,
    ) {
        let s = &mut self.scratch;
        let inverse_density = 1.0 / self.properties.density;
        let mass = self.properties.density * self.properties.particle_volume;
        let p = &trial.pressures;
        let paper = self.options.scheme == Scheme::Paper;
        let pair = AdjointPair { neighbourhood: &s.neighbourhood, along: &s.terms.along, own: &s.terms.own };
        pair.accelerations(inverse_density, p, &mut s.operator.fluid);
        pair.structure_gradients(p, &mut s.gradients_along, &mut s.structure_gradients);
        let (gravity, density) = (&self.properties.gravity, self.properties.density);
        let of_walls =
            |a: usize| self.walls.acceleration_across(&trial.positions[a], s.neighbourhood.walls.of(a));
        let weight = |row: &Row<D>| (gravity - of_walls(row.particle as usize)) * density;
        s.weights_along.clear();
        s.weights_along.extend(s.terms.along.rows.iter().map(weight));

        let velocities = &mut trial.velocities;
        let with_pressure =
            velocities.par_iter_mut().zip(&s.predicted).zip(&s.operator.fluid).with_min_len(ROWS);
        with_pressure.for_each(|((u, predicted), a)| *u = predicted + a * dt);
        // Work of moving boundaries, by the transpose: what the projection itself may have given the fluid.
        self.sampling.at_particles(&s.structure_gradients, &mut s.particle_loads);
        let particles = (&self.interface.volumes[..], &self.compliance[..]);
        let unloaded = &structure.unloaded_particles;
        let structure_work = interface_load::structure_work(particles, unloaded, &s.particle_loads, dt);
        let volume = self.properties.particle_volume;
        report.wall_work = interface_load::wall_work(
            (&s.neighbourhood, &s.terms.along),
            (p, &s.gradients_along),
            &s.wall_velocities,
        ) * volume
            * dt;

        s.confidence.clear();
        if self.options.corrected_gradient {
            velocity_correction::corrected_accelerations(
                &s.neighbourhood,
                &s.corrections,
                (&s.terms.along, &s.weights_along),
                inverse_density,
                &self.properties.gravity,
                p,
                &mut s.differences,
            );
            if paper {
                s.confidence.resize(p.len(), 1.0);
            } else {
                velocity_correction::confidence(&s.corrections, &mut s.confidence);
            }
            let differences = s.differences.par_iter_mut().zip(&s.operator.fluid).zip(&s.confidence);
            differences.with_min_len(ROWS).for_each(|((d, a), phi)| *d = (*d - a) * (phi * dt));
            let taken =
                mass * parallel::sum(p.len(), |a| {
                    0.5 * (s.predicted[a].norm_squared() - velocities[a].norm_squared())
                }) + structure_work
                    + report.wall_work;
            let kinetic = 0.5 * mass * parallel::sum(p.len(), |a| velocities[a].norm_squared());
            let scale = mass * p.len() as f64 * self.reference_velocity.powi(2);
            let strictness = velocity_correction::strictness(trial.memory.energy_excess, kinetic, scale);
            let fall = self.properties.gravity * (0.5 * dt * strictness);
            let lifted = mass * parallel::sum(p.len(), |a| fall.dot(&(velocities[a] - s.predicted[a])));
            let returned = report.viscous_work + velocity_correction::RETURNED * trial.memory.energy_excess;
            let budget = velocity_correction::lent(kinetic, scale) * taken + lifted - strictness * returned;
            report.gradient_share = if paper {
                1.0
            } else {
                velocity_correction::admissible_share(mass, velocities, &s.differences, &fall, budget)
            };
            let theta = report.gradient_share;
            let corrected = velocities.par_iter_mut().zip(&s.differences).with_min_len(ROWS);
            corrected.for_each(|(u, d)| *u += d * theta);
            s.confidence.iter_mut().for_each(|phi| *phi *= theta);
        } else {
            s.confidence.resize(p.len(), 0.0);
        }
        let changes = trial.memory.pressure_accelerations.par_iter_mut().zip(&*velocities).zip(&s.predicted);
        changes.with_min_len(ROWS).for_each(|((a, u), predicted)| *a = (u - predicted) / dt);
    }

    /// All that the boundaries get: the load on the structure, what the fluid got from it by the formula that
    /// moved the fluid, friction and contact included, and the forces on walls.
    ///
    /// All loads are of the pressures that the projection found, where the neighbour lists stand: those of
    /// Eq. (32) belong to places to which the particles have been shifted.
    pub(super) fn load_boundaries(
        &mut self,
        dt: f64,
        structure: &BoundaryPoints<D>,
        trial: &State<D>,
        report: &mut StepReport<D>,
    ) {
        let s = &mut self.scratch;
        let p = &trial.pressures;
        let carried = Carried {
            along: &s.terms.along,
            gradients: &s.gradients_along,
            weights: &s.weights_along,
            weight: self.properties.gravity * self.properties.density,
            share: &s.confidence,
            corrections: &s.corrections,
        };
        let whole = self.options.scheme == Scheme::EnergyConsistent;
        interface_load::pair_reactions(&s.neighbourhood, &carried, whole, p, &mut s.reactions);
        interface_load::pressures(&s.neighbourhood, p, &mut s.structure_pressures);
        s.wall_forces.add_pressures(
            &s.neighbourhood,
            &carried,
            &self.walls,
            self.properties.particle_volume,
            p,
        );
        let load = match self.options.load {
            // The paper's scheme leaves the particles' own pressure to what surrounds them; a load has it.
            Load::Transpose if whole => &s.reactions,
            Load::Transpose => &s.structure_gradients,
            Load::PressureGradient => {
                interface_load::pressure_gradient_load(
                    &s.neighbourhood,
                    &self.kernel,
                    (&structure.positions, &self.sampling.volumes),
                    p,
                    &s.structure_pressures,
                    &mut s.structure_gradients,
                );
                &s.structure_gradients
            }
        };
        let output = &mut self.output;
        self.sampling.at_particles(load, &mut output.pressure_gradients);
        report.structure_work = interface_load::structure_work(
            (&self.interface.volumes, &self.compliance),
            &structure.unloaded_particles,
            &output.pressure_gradients,
            dt,
        );
        let impulses = s.contact_impulses.iter().zip(&self.sampling.volumes);
        for (reaction, (impulse, volume)) in s.reactions.iter_mut().zip(impulses) {
            *reaction += impulse / (dt * volume);
        }
        self.sampling.at_particles(&s.reactions, &mut output.pair_reactions);
        let wet = |p: &f64| (*p != 0.0).then_some(*p);
        self.sampling.means(&s.structure_pressures, 0.0, wet, &mut s.carried, &mut output.pressures);
        let exposed = |n: &Vector<D>| (*n != Vector::<D>::zeros()).then_some(*n);
        self.sampling.means(
            &s.structure_normals,
            Vector::zeros(),
            exposed,
            &mut s.carried,
            &mut output.normals,
        );
        let mass = self.properties.particle_mass();
        for (part, change, at) in s.wall_contacts.drain(..) {
            s.wall_forces.add(part, &-(change * (mass / dt)), &at);
        }
    }
}
