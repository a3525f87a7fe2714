//! One time step of the fluid: the algorithm, a line a stage.

use crate::accounting::{self, StepReport};
use crate::conjugate_gradients::{self, Limits, Outcome};
use crate::contact::{self, Approach};
use crate::error::Error;
use crate::interface::{InterfaceInput, StructureSurface};
use crate::interface_load;
use crate::neighbourhood::{Bodies, Neighbourhood};
use crate::options::{Load, Options, Scheme};
use crate::position_projection;
use crate::preconditioner::PressurePreconditioner;
use crate::pressure_operator::{self, OperatorScratch, PressureOperator};
use crate::shifting::{self, ShiftingInput};
use crate::solver::{Fluid, FluidProperties};
use crate::state::{State, SurfaceClass};
use crate::surface::Surface;
use crate::surface_offset;
use crate::taylor;
use crate::velocity_correction;
use crate::viscosity::{self, ViscousInput, ViscousScratch};
use rayon::prelude::*;
use sph::{Matrix, Vector, parallel};

/// Memory of a step, used again by the next.
#[derive(Default)]
pub(crate) struct Scratch<const D: usize> {
    pub(crate) neighbourhood: Neighbourhood<D>,
    corrections: Vec<(Matrix<D>, f64)>,
    pub(crate) surface: Surface<D>,
    structure_surface: StructureSurface,
    own: Vec<Vector<D>>,
    diagonal: Vec<f64>,
    extra_diagonal: Vec<f64>,
    right: Vec<f64>,
    known: Vec<f64>,
    wall_rate: Vec<f64>,
    preconditioner: PressurePreconditioner,
    solver: conjugate_gradients::Scratch,
    operator: OperatorScratch<D>,
    known_image: Vec<f64>,
    viscous: ViscousScratch<D>,
    viscous_accelerations: Vec<Vector<D>>,
    predicted: Vec<Vector<D>>,
    predicted_structure: Vec<Vector<D>>,
    accelerations: Vec<Vector<D>>,
    difference: Vec<Vector<D>>,
    confidence: Vec<f64>,
    position_shifts: Vec<Vector<D>>,
    shifts: Vec<Vector<D>>,
    contact_impulses: Vec<Vector<D>>,
    pub(crate) wall_forces: Vec<Vector<D>>,
    keep: Vec<bool>,
}

impl<const D: usize> Fluid<D> {
    /// Advances `accepted` by `dt` (s) into `trial`, memory of `trial` used again. `time` (s) says where walls that move are. Nothing but
    /// `accepted`, `time`, `dt` and `structure` decides the result: calling twice gives the same bits.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::InterfaceLength`] for what came in or out, [`Error::Solve`] when a pressure solve failed.
    pub fn step(
        &mut self,
        accepted: &State<D>,
        time: f64,
        dt: f64,
        structure: &InterfaceInput<'_, D>,
        trial: &mut State<D>,
    ) -> Result<StepReport<D>, Error> {
        structure.check(self.interface.volumes.len(), time)?;
        trial.copy_from(accepted);
        self.walls.move_to(time, dt);
        let mut report = StepReport { dt, ..StepReport::default() };

        self.find_neighbours(accepted, structure); //                      (1), (5), (17), (25), (26)
        self.assemble(); //                                                 (15), (16)
        self.project_positions(time, trial, &mut report)?; //               density error
        self.predict(accepted, dt, structure, &mut report); //              (10)–(13)
        self.solve_pressure(accepted, time, dt, trial, &mut report)?; //     (14)–(17)
        self.correct_velocity(dt, structure, trial, &mut report); //         (18)
        self.load_structure(accepted, trial); //                                      (46), (48)
        self.move_particles(accepted, dt, structure, trial, &mut report); // (19), (21)–(32)
        self.account(accepted, time, trial, &mut report)?;
        trial.last_dt = dt;
        Ok(report)
    }

    fn find_neighbours(&mut self, accepted: &State<D>, structure: &InterfaceInput<'_, D>) {
        let bodies = Bodies {
            wall_positions: &self.walls.positions,
            wall_volumes: &self.walls.volumes,
            wall_grid: &self.walls.grid,
            structure_positions: structure.positions,
            structure_volumes: &self.interface.volumes,
        };
        let Scratch { neighbourhood, corrections, surface, structure_surface, .. } = &mut self.scratch;
        let (spacing, volume) = (self.properties.spacing, self.properties.particle_volume);
        neighbourhood.update(&self.kernel, spacing, volume, &accepted.positions, &bodies);
        neighbourhood.corrections(0.25, corrections);
        let h = self.kernel.smoothing_length();
        surface.detect(neighbourhood, corrections, &accepted.positions, self.options.surface_thresholds, h);
        structure_surface.normals(
            &self.kernel,
            structure.positions,
            &self.interface.volumes,
            &mut self.output.normals,
        );
    }

    /// Makes the diagonal of Eq. (16) divided by α, and the regularisation.
    fn assemble(&mut self) {
        let s = &mut self.scratch;
        pressure_operator::own_gradients(&s.neighbourhood, &mut s.own);
        let unit = 1.0 / (self.properties.density * self.properties.spacing.powi(2));
        s.extra_diagonal.clear();
        s.extra_diagonal.resize(s.own.len(), 0.0);
        operator(
            &s.neighbourhood,
            &s.own,
            &self.properties,
            &self.options,
            &self.compliance,
            &s.extra_diagonal,
            &s.surface,
        )
        .diagonal(&mut s.diagonal);
        for a in 0..s.own.len() {
            // Without any surface the mean of the pressure is taken out instead.
            let pocket = if s.surface.in_pocket[a] && !s.surface.is_closed() {
                self.options.pocket_regularisation
            } else {
                0.0
            };
            let kappa = (self.options.regularisation + pocket) * unit;
            let alpha = s.surface.alpha[a].max(crate::surface::KNOWN);
            s.extra_diagonal[a] = kappa + s.diagonal[a] * (1.0 / alpha - 1.0);
            s.diagonal[a] += s.extra_diagonal[a];
        }
        let a = operator(
            &s.neighbourhood,
            &s.own,
            &self.properties,
            &self.options,
            &self.compliance,
            &s.extra_diagonal,
            &s.surface,
        );
        s.preconditioner.prepare(self.options.preconditioner, &a, &s.diagonal);
    }

    fn project_positions(
        &mut self,
        time: f64,
        trial: &mut State<D>,
        report: &mut StepReport<D>,
    ) -> Result<(), Error> {
        let s = &mut self.scratch;
        s.position_shifts.clear();
        if !self.options.position_projection {
            s.position_shifts.resize(s.own.len(), Vector::zeros());
            return Ok(());
        }
        position_projection::density_errors(
            &s.neighbourhood,
            &s.surface,
            self.lattice_concentration,
            &mut s.right,
        );
        let a = operator(
            &s.neighbourhood,
            &s.own,
            &self.properties,
            &self.options,
            &[],
            &s.extra_diagonal,
            &s.surface,
        );
        let q = &mut trial.position_potentials;
        clear_known(q, &s.surface.free);
        let closed = s.surface.is_closed();
        remove_mean_if(closed, q);
        remove_mean_if(closed, &mut s.right);
        report.position_solve = conjugate_gradients::solve(
            |p, out| {
                a.apply(p, out, &mut s.operator);
                remove_mean_if(closed, out);
            },
            |r, z| {
                s.preconditioner.apply(r, z);
                remove_mean_if(closed, z);
            },
            &s.right,
            q,
            Limits { tolerance: self.options.position_tolerance, iterations: self.options.iteration_limit },
            &mut s.solver,
        );
        require(&report.position_solve, "position correction", time, self.options.position_tolerance)?;
        let limit = 0.1 * self.properties.spacing;
        let inverse_density = 1.0 / self.properties.density;
        pressure_operator::fluid_accelerations(
            &s.neighbourhood,
            &s.own,
            inverse_density,
            q,
            &mut s.position_shifts,
        );
        position_projection::limit(&mut s.position_shifts, limit);
        Ok(())
    }

    /// `u* = u + Δt (g + viscosity)`, Eq. (12); the structure's with the held load taken back.
    fn predict(
        &mut self,
        accepted: &State<D>,
        dt: f64,
        structure: &InterfaceInput<'_, D>,
        report: &mut StepReport<D>,
    ) {
        let approach_viscosity = self.approach_viscosity();
        let s = &mut self.scratch;
        let input = ViscousInput {
            neighbourhood: &s.neighbourhood,
            corrections: &s.corrections,
            positions: &accepted.positions,
            velocities: &accepted.velocities,
            kinematic_viscosity: self.properties.kinematic_viscosity,
            smoothing_length: self.kernel.smoothing_length(),
            approach_viscosity,
        };
        viscosity::accelerations(&input, &self.options, &mut s.viscous, &mut s.viscous_accelerations);
        s.contact_impulses.clear();
        s.contact_impulses.resize(self.interface.volumes.len(), Vector::zeros());
        s.wall_forces.clear();
        s.wall_forces.resize(self.walls.parts.len(), Vector::zeros());
        let mass = self.properties.density * self.properties.particle_volume;
        interface_load::boundary_friction(
            &s.neighbourhood,
            &self.options,
            self.properties.kinematic_viscosity,
            accepted,
            (&self.walls, structure),
            &mut s.viscous_accelerations,
            |body, acceleration| match body {
                interface_load::Body::Structure(i) => s.contact_impulses[i] += acceleration * (mass * dt),
                interface_load::Body::Wall(part) => s.wall_forces[part] -= acceleration * mass,
            },
        );
        let gravity = self.properties.gravity;
        s.predicted.resize(accepted.len(), Vector::zeros());
        s.predicted
            .par_iter_mut()
            .with_min_len(2048)
            .zip(&accepted.velocities)
            .zip(&s.viscous_accelerations)
            .for_each(|((predicted, u), viscous)| *predicted = u + (viscous + gravity) * dt);
        report.viscous_work = mass
            * parallel::sum(accepted.len(), |a| {
                let kick = s.viscous_accelerations[a] * dt;
                kick.dot(&(accepted.velocities[a] + kick * 0.5))
            });
        s.predicted_structure.clear();
        s.predicted_structure.extend_from_slice(structure.velocities);
        if !self.compliance.is_empty() {
            for ((u, held), c) in
                s.predicted_structure.iter_mut().zip(structure.held_pressure_gradients).zip(&self.compliance)
            {
                *u += held * (dt * c);
            }
        }
        let (walls, list) = (&self.walls, &s.neighbourhood.walls);
        s.wall_rate.clear();
        if walls.velocities.iter().any(|u| *u != Vector::<D>::zeros()) {
            s.wall_rate.extend((0..accepted.len()).map(|a| {
                let gradients = &s.neighbourhood.wall_gradients[list.range(a)];
                let speed = |w: u32| walls.velocities[w as usize];
                list.of(a).iter().zip(gradients).map(|(&w, g)| 2.0 * g.dot(&speed(w))).sum::<f64>()
            }));
        }
    }

    /// `(A + …) p = −D u*/Δt` with the surface's pressure known, Eqs. (14)–(17).
    fn solve_pressure(
        &mut self,
        accepted: &State<D>,
        time: f64,
        dt: f64,
        trial: &mut State<D>,
        report: &mut StepReport<D>,
    ) -> Result<(), Error> {
        let s = &mut self.scratch;
        let a = operator(
            &s.neighbourhood,
            &s.own,
            &self.properties,
            &self.options,
            &self.compliance,
            &s.extra_diagonal,
            &s.surface,
        );
        pressure_operator::divergence(
            &s.neighbourhood,
            &s.own,
            &s.predicted,
            &s.wall_rate,
            &s.predicted_structure,
            &mut s.right,
        );
        s.right.par_iter_mut().for_each(|b| *b *= -1.0 / dt);
        s.known.clear();
        s.known.resize(accepted.len(), 0.0);
        if self.options.surface_offset {
            surface_offset::known_pressures(
                &self.properties,
                &s.surface,
                &s.neighbourhood,
                accepted,
                &mut s.known,
            );
            s.known_image.resize(accepted.len(), 0.0);
            a.apply(&s.known, &mut s.known_image, &mut s.operator);
            s.right.iter_mut().zip(&s.known_image).for_each(|(b, known)| *b -= known);
        }
        clear_known(&mut s.right, &s.surface.free);
        let p = &mut trial.pressures;
        clear_known(p, &s.surface.free);
        let tolerance = self.options.pressure_tolerance;
        let closed = s.surface.is_closed();
        remove_mean_if(closed, p);
        remove_mean_if(closed, &mut s.right);
        report.pressure_solve = conjugate_gradients::solve(
            |p, out| {
                a.apply(p, out, &mut s.operator);
                remove_mean_if(closed, out);
            },
            |r, z| {
                s.preconditioner.apply(r, z);
                remove_mean_if(closed, z);
            },
            &s.right,
            p,
            Limits { tolerance, iterations: self.options.iteration_limit },
            &mut s.solver,
        );
        require(&report.pressure_solve, "pressure", time, tolerance)?;
        // An inexact solution can overshoot in energy; the multiple of it that is orthogonal to its residual cannot.
        let pb = parallel::sum(p.len(), |i| p[i] * s.right[i]);
        let pr = parallel::sum(p.len(), |i| p[i] * s.solver.residual()[i]);
        let scale = if pb > 0.0 && pb - pr > 0.0 { pb / (pb - pr) } else { 1.0 };
        p.iter_mut().zip(&s.known).for_each(|(p, known)| *p = *p * scale + known);
        Ok(())
    }

    /// `u = u* + Δt a(p)`, Eq. (18): the symmetric gradient, and of the corrected one what does not raise the energy.
    fn correct_velocity(
        &mut self,
        dt: f64,
        structure: &InterfaceInput<'_, D>,
        trial: &mut State<D>,
        report: &mut StepReport<D>,
    ) {
        let s = &mut self.scratch;
        let inverse_density = 1.0 / self.properties.density;
        let mass = self.properties.density * self.properties.particle_volume;
        let p = &trial.pressures;
        let paper = self.options.scheme == Scheme::Paper;
        pressure_operator::fluid_accelerations(
            &s.neighbourhood,
            &s.own,
            inverse_density,
            p,
            &mut s.accelerations,
        );
        pressure_operator::structure_gradients(&s.neighbourhood, p, &mut self.output.pressure_gradients);

        let velocities = &mut trial.velocities;
        for ((u, predicted), a) in velocities.iter_mut().zip(&s.predicted).zip(&s.accelerations) {
            *u = predicted + a * dt;
        }
        // Work of moving boundaries, by the transpose: what the projection itself may have given the fluid.
        let compliance = &self.compliance;
        report.structure_work = dt
            * (0..structure.positions.len())
                .map(|i| {
                    let g = self.output.pressure_gradients[i];
                    let yielding = compliance.get(i).map_or(Vector::zeros(), |c| g * (0.5 * dt * c));
                    self.interface.volumes[i] * g.dot(&(s.predicted_structure[i] - yielding))
                })
                .sum::<f64>();
        let volume = self.properties.particle_volume;
        report.wall_work = -dt * volume * s.wall_rate.iter().zip(p).map(|(rate, p)| rate * p).sum::<f64>();

        s.confidence.clear();
        if self.options.corrected_gradient {
            velocity_correction::corrected_accelerations(
                &s.neighbourhood,
                &s.corrections,
                inverse_density,
                &self.properties.gravity,
                p,
                &mut s.difference,
            );
            if paper {
                s.confidence.resize(p.len(), 1.0);
            } else {
                velocity_correction::confidence(&s.neighbourhood, &s.corrections, &mut s.confidence);
                velocity_correction::none_beside_moving_walls(
                    &s.neighbourhood,
                    &self.walls,
                    &mut s.confidence,
                );
            }
            for ((d, a), phi) in s.difference.iter_mut().zip(&s.accelerations).zip(&s.confidence) {
                *d = (*d - a) * (phi * dt);
            }
            let taken =
                mass * parallel::sum(p.len(), |a| {
                    0.5 * (s.predicted[a].norm_squared() - velocities[a].norm_squared())
                }) + report.structure_work
                    + report.wall_work;
            let kinetic = 0.5 * mass * parallel::sum(p.len(), |a| velocities[a].norm_squared());
            let scale = mass * p.len() as f64 * self.reference_velocity.powi(2);
            let strictness = velocity_correction::strictness(trial.energy_excess, kinetic, scale);
            let fall = self.properties.gravity * (0.5 * dt * strictness);
            let lifted = mass * parallel::sum(p.len(), |a| fall.dot(&(velocities[a] - s.predicted[a])));
            let returned = report.viscous_work + velocity_correction::RETURNED * trial.energy_excess;
            let budget = taken + lifted - strictness * returned;
            report.gradient_share = if paper {
                1.0
            } else {
                velocity_correction::admissible_share(mass, velocities, &s.difference, &fall, budget)
            };
            let theta = report.gradient_share;
            for (u, d) in velocities.iter_mut().zip(&s.difference) {
                *u += d * theta;
            }
            s.confidence.iter_mut().for_each(|phi| *phi *= theta);
        } else {
            s.confidence.resize(p.len(), 0.0);
        }
        for ((a, u), predicted) in
            trial.pressure_accelerations.iter_mut().zip(velocities.iter()).zip(&s.predicted)
        {
            *a = (u - predicted) / dt;
        }
    }

    /// What the structure gets, and what the fluid got from it by the formula that moved it.
    fn load_structure(&mut self, accepted: &State<D>, trial: &State<D>) {
        let s = &mut self.scratch;
        let p = &trial.pressures;
        interface_load::pair_reactions(
            &s.neighbourhood,
            &s.corrections,
            &s.confidence,
            &self.properties,
            p,
            &mut self.output.pair_reactions,
        );
        interface_load::pressures(&s.neighbourhood, &self.kernel, p, &mut self.output.pressures);
        interface_load::wall_forces(
            &s.neighbourhood,
            &self.walls,
            &self.properties,
            &accepted.positions,
            &s.confidence,
            p,
            &mut s.wall_forces,
        );
    }

    /// Eq. (19), position projection and shifting, nowhere nearer to a boundary than allowed; then who has left.
    fn move_particles(
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
            let to = at + displacement;
            let to = s.neighbourhood.period.wrap(to);
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

    fn account(
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

fn operator<'a, const D: usize>(
    neighbourhood: &'a Neighbourhood<D>,
    own: &'a [Vector<D>],
    properties: &FluidProperties<D>,
    options: &Options,
    compliance: &'a [f64],
    extra_diagonal: &'a [f64],
    surface: &'a Surface<D>,
) -> PressureOperator<'a, D> {
    PressureOperator {
        neighbourhood,
        own,
        inverse_density: 1.0 / properties.density,
        compliance,
        laplacian_share: options.laplacian_share,
        wide_share: if options.scheme == Scheme::Paper { 0.0 } else { 1.0 },
        extra_diagonal,
        free: &surface.free,
    }
}

fn clear_known(values: &mut [f64], free: &[bool]) {
    for (value, free) in values.iter_mut().zip(free) {
        if !free {
            *value = 0.0;
        }
    }
}

/// Where no pressure is known, in a closed or periodic domain, it is known but for a constant: its mean is zero then, and so is that of the
/// equations, whose sum the operator cannot change but by the disorder of the particles.
fn remove_mean_if(closed: bool, values: &mut [f64]) {
    if closed {
        let mean = parallel::sum(values.len(), |i| values[i]) / values.len() as f64;
        values.iter_mut().for_each(|v| *v -= mean);
    }
}

fn require(solve: &Outcome, unknown: &'static str, time: f64, tolerance: f64) -> Result<(), Error> {
    if solve.converged {
        return Ok(());
    }
    let Outcome { iterations, residual, .. } = *solve;
    Err(Error::Solve { unknown, time, residual, iterations, tolerance })
}
