//! Where particles go, who is left, and the balances.

use crate::boundaries::contact::{self, Approach};
use crate::boundaries::sampling::BoundaryPoints;
use crate::error::Error;
use crate::isph::shifting::{self, ShiftingInput};
use crate::isph::solver::Isph;
use crate::isph::state::State;
use crate::isph::step::scratch::{ROWS, Scratch};
use crate::isph::taylor;
use crate::particles::accounting;
use crate::particles::class::SurfaceClass;
use crate::report::StepReport;
use rayon::prelude::*;
use sph::{Vector, parallel};

impl<const D: usize> Isph<D> {
    /// Eq. (19), position projection and shifting, nowhere nearer to a boundary than allowed; then who has
    /// left.
    pub(super) fn move_particles(
        &mut self,
        accepted: &State<D>,
        dt: f64,
        structure: &BoundaryPoints<D>,
        trial: &mut State<D>,
        report: &mut StepReport<D>,
    ) {
        let h = self.kernel.smoothing_length();
        let s = &mut self.scratch;
        let fastest = parallel::max(trial.len(), self.reference_velocity, |a| trial.velocities[a].norm());
        let input = ShiftingInput {
            neighbourhood: &s.neighbourhood,
            surface: &s.surface,
            positions: &accepted.positions,
            wall_positions: &self.walls.positions,
            structure_positions: &structure.positions,
            structure_normals: &s.structure_normals,
            magnitude: fastest * dt,
            smoothing_length: h,
        };
        shifting::shifts(&input, &self.options, &mut s.shifts);
        if self.options.taylor_correction {
            taylor::correct_velocities(&s.neighbourhood, &s.corrections, &s.shifts, &mut trial.velocities);
        }
        // From here on the position projection's shifts are the whole displacement.
        let displacements = &mut s.position_shifts;
        let carried =
            |a: usize, trial: &State<D>| (accepted.velocities[a] + trial.velocities[a]) * (0.5 * dt);
        displacements.par_iter_mut().zip(&s.shifts).with_min_len(ROWS).enumerate().for_each(
            |(a, (d, shift))| {
                *d += carried(a, trial) + shift;
            },
        );
        let spacing = self.properties.spacing;
        let approach = Approach { dt, least_distance: self.options.contact_distance * spacing };
        let mass = self.properties.density * self.properties.particle_volume;
        s.wall_contacts.clear();
        s.keep.clear();
        s.keep.resize(trial.len(), true);
        for a in 0..trial.len() {
            let near_walls = !s.neighbourhood.walls.of(a).is_empty();
            let near_structure = s.neighbourhood.structure.of(a);
            if !near_walls && near_structure.is_empty() {
                continue;
            }
            let at = accepted.positions[a];
            let (u, displacement) = (&mut trial.velocities[a], &mut displacements[a]);
            let before = u.norm_squared();
            let mut lost = false;
            let nearest = contact::nearest_structure(
                &at,
                near_structure,
                &structure.positions,
                &s.structure_normals,
                &self.sampling.spacings,
            );
            if let Some((i, surface)) = nearest {
                lost |= surface.distance < -0.5 * spacing;
                let change = approach.limit(&surface, &structure.velocities[i], u, displacement);
                s.contact_impulses[i] += change * mass;
                report.contact_structure_work += mass * change.dot(&structure.velocities[i]);
            }
            if near_walls {
                let reach = 2.0 * spacing;
                contact::keep_off_walls(
                    &approach,
                    &self.walls,
                    reach,
                    &at,
                    u,
                    displacement,
                    |part, change, boundary| {
                        s.wall_contacts.push((part, change, at));
                        report.contact_structure_work += mass * change.dot(&boundary);
                    },
                );
                let to = at + *displacement;
                lost |= (0..self.walls.parts.len()).any(|part| {
                    let d = self.walls.surface_point(part, &to, true).distance;
                    d < -0.5 * spacing && d > -3.0 * h
                });
            }
            report.contact_work += 0.5 * mass * (u.norm_squared() - before);
            s.keep[a] = !lost;
        }
        let gravity = self.properties.gravity;
        report.displacement_work =
            -mass * parallel::sum(trial.len(), |a| gravity.dot(&(displacements[a] - carried(a, trial))));
        let (period, (low, high)) = (&s.neighbourhood.period, &self.properties.domain);
        let moved = trial.positions.par_iter_mut().zip(&*displacements).with_min_len(ROWS);
        moved.for_each(|(position, displacement)| *position = period.wrap(*position + displacement));
        for (a, (keep, position)) in s.keep.iter_mut().zip(&trial.positions).enumerate() {
            let left = (0..D).any(|i| position[i] < low[i] || position[i] > high[i]);
            trial.left += u64::from(left);
            if !*keep && !left {
                trial.lost += 1;
                report.first_lost.get_or_insert((trial.ids[a], *position));
            }
            *keep &= !left;
        }
        trial.classes.clone_from(&s.surface.classes);
        s.torn.iter().for_each(|&a| trial.classes[a as usize] = SurfaceClass::Torn);
        report.largest_shift = parallel::max(s.shifts.len(), 0.0, |a| s.shifts[a].norm());
    }

    /// Eq. (32), once the loads are made.
    pub(super) fn shift_pressures(&self, trial: &mut State<D>) {
        let s = &self.scratch;
        if self.options.taylor_correction {
            taylor::correct_pressures(&s.neighbourhood, &s.corrections, &s.shifts, &mut trial.pressures);
        }
    }

    pub(super) fn account(
        &mut self,
        accepted: &State<D>,
        time: f64,
        trial: &mut State<D>,
        report: &mut StepReport<D>,
    ) -> Result<(), Error> {
        let remedy = "restart from an earlier state with a smaller Courant number";
        for (field, values) in [("velocity", &trial.velocities), ("position", &trial.positions)] {
            // A sum over all of them is quicker than to look at each, and not finite where one is not.
            let sound = parallel::sum(values.len(), |a| values[a].sum()).is_finite();
            let unsound = |v: &Vector<D>| !v.iter().all(|x| x.is_finite());
            if let (false, Some(a)) = (sound, values.iter().position(unsound)) {
                return Err(Error::NotFinite { field, particle: trial.ids[a] as usize, time, remedy });
            }
        }
        let s = &mut self.scratch;
        let mass = self.properties.density * self.properties.particle_volume;
        accounting::balance(&self.properties, &s.neighbourhood.period, mass, accepted, trial, report);
        let own =
            report.energy_change - report.structure_work - report.wall_work - report.contact_structure_work;
        trial.memory.energy_excess = (trial.memory.energy_excess + own).max(0.0);
        report.structure_impulse = self
            .output
            .pair_reactions
            .iter()
            .zip(&self.interface.volumes)
            .fold(Vector::zeros(), |sum, (r, v)| sum + r * (v * report.dt));
        let forces = &s.wall_forces.forces;
        report.wall_impulse = forces.iter().fold(Vector::zeros(), |sum, f| sum - f * report.dt);
        report.momentum_error -= report.structure_impulse + report.wall_impulse;
        s.wall_forces.lay(&report.momentum_error, report.dt);
        (report.mean_density_error, report.largest_density_error) =
            accounting::density_errors(&s.neighbourhood, &s.surface.alpha, self.lattice_concentration);
        report.pocket_particles = s.surface.pocket_particles;
        report.torn = s.torn.len();
        report.splashes = s.surface.classes.iter().filter(|c| **c == SurfaceClass::Splash).count();
        if s.keep.contains(&false) {
            accounting::leave(&self.properties, mass, trial, &s.keep, report);
            trial.retain(&s.keep);
        }
        report.particles = trial.len();
        (report.left, report.lost) = (trial.left, trial.lost);
        Ok(())
    }

    /// Sorts the particles of `trial` where its next step makes a hierarchy and their order has decayed:
    /// aggregates are groups of places, so an old hierarchy could not serve.
    pub(super) fn keep_order(&mut self, trial: &mut State<D>) {
        let Scratch { order, viscous: vectors, viscous_factors: numbers, .. } = &mut self.scratch;
        let (low, cell) = (&self.properties.domain.0, self.kernel.support());
        if trial.memory.hierarchy.is_some() || !order.has_decayed(&trial.positions, low, cell) {
            return;
        }
        order.rearrange(trial, (vectors, numbers));
        order.apply(&mut trial.memory.pressure_accelerations, vectors);
        order.apply(&mut trial.memory.position_potentials, numbers);
    }
}
