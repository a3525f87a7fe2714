//! Where particles go, who is left, and the balances.

use crate::accounting::{self, StepReport};
use crate::contact::{self, Approach};
use crate::error::Error;
use crate::interface::InterfaceInput;
use crate::interface_load;
use crate::options::Load;
use crate::shifting::{self, ShiftingInput};
use crate::solver::Fluid;
use crate::state::{State, SurfaceClass};
use crate::taylor;
use sph::{Vector, parallel};

impl<const D: usize> Fluid<D> {
    /// Eq. (19), position projection and shifting, nowhere nearer to a boundary than allowed; then who has left.
    pub(super) fn move_particles(
        &mut self,
        accepted: &State<D>,
        dt: f64,
        structure: &InterfaceInput<'_, D>,
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
            structure_positions: structure.positions,
            structure_normals: &self.output.normals,
            magnitude: fastest * dt,
            smoothing_length: h,
        };
        shifting::shifts(&input, &self.options, &mut s.shifts);
        if self.options.taylor_correction {
            taylor::correct_fields(
                &s.neighbourhood,
                &s.corrections,
                &s.shifts,
                &mut trial.velocities,
                &mut trial.pressures,
            );
        }
        if self.options.load == Load::PressureGradient {
            interface_load::pressure_gradient_load(
                &s.neighbourhood,
                &self.kernel,
                (structure.positions, &self.interface.volumes),
                &trial.pressures,
                &self.output.pressures,
                &mut self.output.pressure_gradients,
            );
        }
        let spacing = self.properties.spacing;
        let approach = Approach { dt, least_distance: self.options.contact_distance * spacing };
        let mass = self.properties.density * self.properties.particle_volume;
        s.keep.clear();
        s.keep.resize(trial.len(), true);
        for a in 0..trial.len() {
            let mut displacement = (accepted.velocities[a] + trial.velocities[a]) * (0.5 * dt)
                + s.position_shifts[a]
                + s.shifts[a];
            let at = accepted.positions[a];
            let near_walls = !s.neighbourhood.walls.of(a).is_empty();
            let near_structure = s.neighbourhood.structure.of(a);
            let mut lost = false;
            if near_walls || !near_structure.is_empty() {
                let u = &mut trial.velocities[a];
                let before = u.norm_squared();
                let nearest = contact::nearest_structure(
                    &at,
                    near_structure,
                    structure.positions,
                    &self.output.normals,
                    &self.interface_spacings,
                );
                if let Some((i, surface)) = nearest {
                    lost |= surface.distance < -0.5 * spacing;
                    let change = approach.limit(&surface, &structure.velocities[i], u, &mut displacement);
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
                        &mut displacement,
                        |part, change, boundary| {
                            s.wall_forces[part] -= change * (mass / dt);
                            report.contact_structure_work += mass * change.dot(&boundary);
                        },
                    );
                    let to = at + displacement;
                    lost |= (0..self.walls.parts.len()).any(|part| {
                        let d = self.walls.surface_point(part, &to, true).distance;
                        d < -0.5 * spacing && d > -3.0 * h
                    });
                }
                report.contact_work += 0.5 * mass * (u.norm_squared() - before);
            }
            let carried = (accepted.velocities[a] + trial.velocities[a]) * (0.5 * dt);
            report.displacement_work -= mass * self.properties.gravity.dot(&(displacement - carried));
            let to = s.neighbourhood.period.wrap(at + displacement);
            trial.positions[a] = to;
            let (low, high) = &self.properties.domain;
            let left = (0..D).any(|i| to[i] < low[i] || to[i] > high[i]);
            trial.left += u64::from(left);
            trial.lost += u64::from(lost && !left);
            s.keep[a] = !(left || lost);
        }
        for (i, impulse) in s.contact_impulses.iter().enumerate() {
            self.output.pair_reactions[i] += impulse / (dt * self.interface.volumes[i]);
        }
        trial.classes.clone_from(&s.surface.classes);
        report.largest_shift = parallel::max(s.shifts.len(), 0.0, |a| s.shifts[a].norm());
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
            if let Some(a) = values.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
                return Err(Error::NotFinite { field, particle: trial.ids[a] as usize, time, remedy });
            }
        }
        let s = &self.scratch;
        let mass = self.properties.density * self.properties.particle_volume;
        accounting::balance(&self.properties, &s.neighbourhood.period, mass, accepted, trial, report);
        let own =
            report.energy_change - report.structure_work - report.wall_work - report.contact_structure_work;
        trial.energy_excess = (trial.energy_excess + own).max(0.0);
        report.structure_impulse = self
            .output
            .pair_reactions
            .iter()
            .zip(&self.interface.volumes)
            .fold(Vector::zeros(), |sum, (r, v)| sum + r * (v * report.dt));
        report.wall_impulse = s.wall_forces.iter().fold(Vector::zeros(), |sum, f| sum - f * report.dt);
        report.momentum_error -= report.structure_impulse + report.wall_impulse;
        (report.mean_density_error, report.largest_density_error) =
            accounting::density_errors(&s.neighbourhood, &s.surface, self.lattice_concentration);
        report.pocket_particles = s.surface.pocket_particles;
        report.splashes = s.surface.classes.iter().filter(|c| **c == SurfaceClass::Splash).count();
        if s.keep.contains(&false) {
            trial.retain(&s.keep);
        }
        report.particles = trial.len();
        (report.left, report.lost) = (trial.left, trial.lost);
        Ok(())
    }
}
