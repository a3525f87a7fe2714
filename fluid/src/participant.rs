//! The fluid as a participant: the one file of this crate that knows the case, messages and outputs.
//!
//! Case → particles, walls and options; interface fields ↔ arrays of vectors; accepted state → snapshots,
//! probes and balances.

mod ledger;
mod places;
mod saved;
mod section;
mod setup;
mod snapshot;

use crate::boundaries::period::Period;
use crate::boundaries::walls::Walls;
use crate::error::Error;
use crate::interface::{InterfaceInput, InterfaceParticles};
use crate::isph::solver::Isph;
use crate::isph::state::Memory;
use crate::method::Fluid;
use crate::particles::state::State;
use crate::probes::{self, flux, gauge};
use interfaces::case::Case;
use interfaces::port::names;
use interfaces::{
    Description, Direction, Fields, Participant, ParticipantError, Port, Quantity, Readiness, Result, Role,
    Scalar, ScalarKind, TimeWindow, WindowReport,
};
use ledger::Ledger;
use places::{Place, Watched};
pub use section::SECTIONS;
use snapshot::Snapshots;
use sph::Vector;
use std::path::Path;
use std::time::Instant;
use words::probe::ProbeQuantity;

/// The fluid of `case`, writing its snapshots to the folder `out`.
///
/// # Errors
/// A setting that cannot be used; a folder that cannot be written.
pub fn from_case(case: &Case, out: &Path) -> Result<Box<dyn Participant>> {
    Ok(match case.general.dimension {
        2 => Box::new(FluidParticipant::new(isph::<2>(case)?, case, out)?),
        _ => Box::new(FluidParticipant::new(isph::<3>(case)?, case, out)?),
    })
}

/// What the fluid of `case` would be: pairs of what and value, for `meniscus check`.
///
/// # Errors
/// A setting that cannot be used.
pub fn preview(case: &Case) -> Result<Vec<(String, String)>> {
    match case.general.dimension {
        2 => preview_in::<2>(case),
        _ => preview_in::<3>(case),
    }
}

/// Peak resident memory of a fluid process (bytes), of itself and a particle: 27.5 MB on `cases/elastic_gate`
/// with 8,960 particles, 81.6 MB on `cases/hydrostatic_column` with 51,200.
const BYTES_OF_PROCESS: f64 = 16e6;
const BYTES_A_PARTICLE: f64 = 1.3e3;

fn preview_in<const D: usize>(case: &Case) -> Result<Vec<(String, String)>> {
    let (fluid, state, max_time_step) = isph::<D>(case)?;
    let (particles, walls) = (state.len(), fluid.walls().positions.len());
    let step = fluid.stable_step(&state, 0.0, &[]).min(max_time_step);
    let line = |what: &str, value: String| (what.to_owned(), value);
    Ok(vec![
        line("particles", format!("{particles} (and {walls} in walls)")),
        line("first time step", format!("{step:.3e} s")),
        line(
            "memory",
            format!("about {:.0} MB", (BYTES_OF_PROCESS + particles as f64 * BYTES_A_PARTICLE) / 1e6),
        ),
    ])
}

/// Speed of a dam break's front over √(g H), after Ritter 1892.
const FASTEST: f64 = 2.0;

/// Largest time steps (s) of the fluid of `case` as fast as it is at the start, and at twice
/// `characteristic_speed`.
///
/// # Errors
/// A setting that cannot be used.
pub fn time_steps(case: &Case) -> Result<[f64; 2]> {
    match case.general.dimension {
        2 => time_steps_in::<2>(case),
        _ => time_steps_in::<3>(case),
    }
}

fn time_steps_in<const D: usize>(case: &Case) -> Result<[f64; 2]> {
    let (fluid, state, max_time_step) = isph::<D>(case)?;
    let mut fast = state.clone();
    let speed = case.fluid.as_ref().map_or(0.0, |fluid| fluid.characteristic_speed);
    for velocity in &mut fast.velocities {
        velocity[0] += FASTEST * speed;
    }
    Ok([&state, &fast].map(|state| fluid.stable_step(state, 0.0, &[]).min(max_time_step)))
}

/// The fluid of a case by ISPH without a structure, its state at the start, and the largest time step (s)
/// that the case allows.
type Made<const D: usize> = (Isph<D>, State<D, Memory<D>>, f64);

fn isph<const D: usize>(case: &Case) -> Result<Made<D>> {
    let setup::Made { properties, options, walls, state, max_time_step } = setup::from_case::<D>(case)?;
    let fluid = Isph::new(properties, options, walls, InterfaceParticles::default(), &state);
    Ok((fluid.map_err(failed)?, state, max_time_step))
}

fn failed(error: impl std::fmt::Display) -> ParticipantError {
    ParticipantError::failed(error.to_string())
}

/// A fluid of any method at work.
struct FluidParticipant<const D: usize, F: Fluid<D>> {
    description: Description,
    fluid: F,
    accepted: State<D, F::Memory>,
    trial: State<D, F::Memory>,
    accepted_ledger: Ledger,
    trial_ledger: Ledger,
    positions: Vec<Vector<D>>,
    velocities: Vec<Vector<D>>,
    held: Vec<Vector<D>>,
    /// Reference volumes (m³) of the structure's particles.
    volumes: Vec<f64>,
    probes: Vec<Watched<D>>,
    /// Of each probe of a flux, what has crossed in the last window, and since the start (m³): in the
    /// accepted state and in the trial.
    accepted_passed: Vec<[f64; 2]>,
    trial_passed: Vec<[f64; 2]>,
    /// Memory for the places of particles by their numbers.
    by_id: Vec<u32>,
    /// Largest time step that the case allows (s).
    max_time_step: f64,
    end_of_trial: f64,
    report: Option<WindowReport>,
    /// Why the last solution must not be accepted: particles that it lost.
    lost: Option<String>,
    /// Limit and scalars at the end of the last solution: between windows, of the accepted state. They depend
    /// on more than that, as does the load.
    ready: Readiness,
    snapshots: Snapshots,
    /// Walls as snapshots show them: at the end of an accepted window, not at the start of a step.
    shown_walls: Walls<D>,
}

impl<const D: usize, F: Fluid<D>> FluidParticipant<D, F> {
    fn new(
        (fluid, initial, max_time_step): (F, State<D, F::Memory>, f64),
        case: &Case,
        out: &Path,
    ) -> Result<Self> {
        let on_fluid = case.probes.iter().filter(|probe| !probe.is_on_structure());
        let probes = on_fluid.map(|probe| Watched::new(probe, case)).collect::<Result<Vec<_>>>()?;
        let fluxes = probes.iter().filter(|probe| probe.is_flux()).count();
        Ok(Self {
            description: describe::<D>(F::METHOD, &probes),
            volumes: Vec::new(),
            accepted_passed: vec![[0.0; 2]; fluxes],
            trial_passed: vec![[0.0; 2]; fluxes],
            by_id: Vec::new(),
            trial: initial.clone(),
            accepted: initial,
            accepted_ledger: Ledger::default(),
            trial_ledger: Ledger::default(),
            positions: Vec::new(),
            velocities: Vec::new(),
            held: Vec::new(),
            probes,
            max_time_step,
            end_of_trial: 0.0,
            report: None,
            lost: None,
            ready: Readiness { window_limit: f64::INFINITY, scalars: Vec::new() },
            snapshots: Snapshots::create(out)?,
            shown_walls: fluid.walls().clone(),
            fluid,
        })
    }

    fn take_motion(&mut self, inputs: &Fields) {
        read(inputs.get(names::POSITION), &mut self.positions);
        read(inputs.get(names::VELOCITY), &mut self.velocities);
        read(inputs.get(names::HELD_PRESSURE_GRADIENT), &mut self.held);
    }

    /// A failed step as the participant's failure; of a failed solve the state is left in the run's folder,
    /// and the message says where.
    fn explain(&self, error: &Error, time: f64) -> ParticipantError {
        if !matches!(error, Error::Solve { .. }) {
            return failed(error);
        }
        let fields = self.fluid.failed_solve(&self.trial);
        match self.snapshots.write_failed_solve(time, &self.accepted, &fields) {
            Ok(path) => failed(format!("{error}; the state and the residual are in {}", path.display())),
            Err(second) => failed(format!("{error}; and the state could not be written: {second}")),
        }
    }

    /// The pressure of the initial state, beside a structure that bears no load yet.
    fn find_initial_pressure(&mut self, start: f64) -> Result<()> {
        let size = self.window_limit(&self.accepted, start);
        let unloaded = vec![Vector::zeros(); self.positions.len()];
        let structure = InterfaceInput {
            positions: &self.positions,
            velocities: &self.velocities,
            held_pressure_gradients: &unloaded,
        };
        let found = self.fluid.start(&mut self.accepted, start, size, &structure);
        found.map_err(|error| self.explain(&error, start))
    }

    fn window_limit(&self, state: &State<D, F::Memory>, time: f64) -> f64 {
        self.fluid.stable_step(state, time, &self.velocities).min(self.max_time_step)
    }

    /// What is told of the accepted state, or of the trial's, at a time (s).
    fn scalars(&self, of_trial: bool, time: f64) -> Vec<f64> {
        let (state, ledger, passed) = if of_trial {
            (&self.trial, &self.trial_ledger, &self.trial_passed)
        } else {
            (&self.accepted, &self.accepted_ledger, &self.accepted_passed)
        };
        let mut scalars = ledger.values();
        let any = |of: fn(&Place<D>) -> bool| self.probes.iter().any(|probe| of(&probe.place));
        let (properties, walls) = (self.fluid.properties(), self.fluid.walls());
        let smoothing_length = self.fluid.smoothing_length();
        let at = any(Place::is_interpolated).then(|| probes::Probe::new(state, smoothing_length));
        let solids = [(&walls.positions[..], &walls.volumes[..]), (&self.positions, &self.volumes)];
        let fluid = (&state.positions[..], properties.particle_volume);
        let along = any(|place| matches!(place, Place::Line { .. }))
            .then(|| gauge::Gauge::new(fluid, &solids, properties.spacing, smoothing_length));
        let mut passed = passed.iter();
        for Watched { probe, place, frame } in &self.probes {
            let quantity = probe.quantity;
            let pose = frame.as_ref().map(|frame| frame.pose(time));
            let pose = pose.as_ref();
            let turned_back = |vector: Vector<D>| pose.map_or(vector, |pose| pose.turned_back(&vector));
            let here = |point: &Vector<D>| pose.map_or(*point, |pose| pose.moved(point));
            match place {
                Place::Level(level) => scalars.extend(state.hydrostatic_error(properties, level)),
                Place::Point(point) => {
                    let probe = at.as_ref().expect("there is a probe at a point");
                    let point = here(point);
                    let value = probe.at(&point);
                    let of_frame = frame.as_ref().map(|frame| frame.twist(time).at(&point));
                    let velocity = of_frame.map_or(value.velocity, |own| value.velocity - own);
                    match quantity {
                        ProbeQuantity::Velocity => scalars.extend(turned_back(velocity).iter()),
                        _ => scalars.push(value.pressure),
                    }
                }
                Place::Sensor(area) => {
                    let probe = at.as_ref().expect("there is a probe over an area");
                    let mean = |area: &_| probe.mean_over(area, properties.spacing);
                    scalars.push(pose.map_or_else(|| mean(area), |pose| mean(&area.moved(pose))));
                }
                Place::Line { at, direction } => {
                    let gauge = along.as_ref().expect("there is a gauge along a line");
                    let at = here(at);
                    let direction = pose.map_or(*direction, |pose| pose.turned(direction));
                    let length = gauge::length_within(&at, &direction, &properties.domain);
                    scalars.extend(gauge.heights(&at, &direction, length));
                }
                Place::Crossed(_) => {
                    let [last, whole] = passed.next().expect("there is an entry for each flux");
                    let rate = if state.last_dt > 0.0 { last / state.last_dt } else { 0.0 };
                    scalars.extend([rate, *whole]);
                }
                Place::Box(corners) => {
                    // All of the fluid is in the domain, but not in one that has turned.
                    let all = match pose {
                        Some(_) => [f64::NEG_INFINITY, f64::INFINITY].map(Vector::repeat).into(),
                        None => properties.domain,
                    };
                    let body = state.body_in(properties.spacing, corners.unwrap_or(all), pose);
                    match quantity {
                        ProbeQuantity::Extent => {
                            scalars.extend((0..D).flat_map(|i| [body.low[i], body.high[i]]));
                        }
                        ProbeQuantity::Centroid => scalars.extend(body.centroid.iter()),
                        _ => scalars.extend(body.spread.iter()),
                    }
                }
                Place::WallAbout(name, about) => {
                    let moment = self.fluid.wall_moment(name, &here(about));
                    let moment = moment.expect("a checked case names walls that are there");
                    // Frames turn about the third axis.
                    match D {
                        2 => scalars.push(moment[2]),
                        _ => scalars.extend(turned_back(Vector::from_fn(|i, _| moment[i])).iter()),
                    }
                }
                Place::Wall(name) => {
                    let force =
                        self.fluid.wall_force(name).expect("a checked case names walls that are there");
                    scalars.extend(turned_back(force).iter());
                }
            }
        }
        scalars
    }

    /// Counts what has crossed areas on the way from the accepted state to the trial.
    fn count_passed(&mut self, window: &TimeWindow) {
        let Self { fluid, probes, accepted, trial, by_id, .. } = self;
        let properties = fluid.properties();
        let period = Period::new(&properties.periodic, &properties.domain);
        let fluxes = probes.iter().filter_map(|probe| match &probe.place {
            Place::Crossed(area) => Some((area, &probe.frame)),
            _ => None,
        });
        for ((area, frame), (before, after)) in
            fluxes.zip(self.accepted_passed.iter().zip(&mut self.trial_passed))
        {
            let poses = frame.as_ref().map(|frame| [frame.pose(window.start), frame.pose(window.end())]);
            let net = flux::crossings(area, (accepted, trial), poses.as_ref(), &period, by_id);
            let volume = net * properties.particle_volume;
            *after = [volume, before[1] + volume];
        }
    }

    fn give_load(&self, outputs: &mut Fields) {
        let given = self.fluid.output();
        for (name, values) in [
            (names::PRESSURE_GRADIENT, &given.pressure_gradients),
            (names::PAIR_REACTION, &given.pair_reactions),
            (names::NORMAL, &given.normals),
        ] {
            if let Some(field) = outputs.get_mut(name) {
                for (to, from) in field.chunks_exact_mut(D).zip(values) {
                    to.copy_from_slice(from.as_slice());
                }
            }
        }
        if let Some(field) = outputs.get_mut(names::PRESSURE) {
            field.copy_from_slice(&given.pressures);
        }
    }
}

impl<const D: usize, F: Fluid<D>> Participant for FluidParticipant<D, F> {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        self.take_motion(inputs);
        self.volumes = inputs.get(names::REFERENCE_VOLUME).unwrap_or_default().to_vec();
        let interface = InterfaceParticles {
            positions: self.positions.clone(),
            volumes: self.volumes.clone(),
            densities: inputs.get(names::DENSITY).unwrap_or_default().to_vec(),
        };
        let Self { fluid, accepted, .. } = self;
        let (properties, options, walls) = (fluid.properties(), fluid.options(), fluid.walls());
        *fluid = F::new(properties.clone(), options.clone(), walls.clone(), interface, accepted)
            .map_err(failed)?;
        self.find_initial_pressure(start)?;
        self.give_load(outputs);
        self.accepted_ledger = Ledger::at_start(self.fluid.properties(), &self.accepted);
        self.shown_walls.move_to(start, (1.0, 0.0));
        self.snapshots.write_walls(start, &self.shown_walls)?;
        self.snapshots.write(start, &self.accepted)?;
        let scalars = self.scalars(false, start);
        self.ready = Readiness { window_limit: self.window_limit(&self.accepted, start), scalars };
        Ok(self.ready.clone())
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        let started = Instant::now();
        self.take_motion(inputs);
        let structure = InterfaceInput {
            positions: &self.positions,
            velocities: &self.velocities,
            held_pressure_gradients: &self.held,
        };
        let step = self.fluid.step(&self.accepted, window.start, window.size, &structure, &mut self.trial);
        let step = step.map_err(|error| self.explain(&error, window.start))?;
        self.lost = step.first_lost.filter(|_| self.fluid.refuses_lost_particles()).map(|(id, at)| {
            let time = window.end();
            format!(
                "particle {id} was lost at {:?} m in the step to t = {time} s: it is inside a wall or the structure. \
                 Solids that run into each other, or too long a step (fluid.numerics.courant), are the usual cause; \
                 fluid.numerics.lost_particles = \"counted\" goes on without it",
                at.as_slice()
            )
        });
        self.trial_ledger = self.accepted_ledger.after(&step, &self.trial);
        self.end_of_trial = window.end();
        self.count_passed(window);
        self.ready = Readiness {
            window_limit: self.window_limit(&self.trial, self.end_of_trial),
            scalars: self.scalars(true, self.end_of_trial),
        };
        self.report = Some(WindowReport {
            sub_steps: 1,
            window_limit: self.ready.window_limit,
            scalars: self.ready.scalars.clone(),
            compute_seconds: started.elapsed().as_secs_f64(),
        });
        Ok(())
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        self.give_load(outputs);
        Ok(self.report.take().expect("the table of legal calls puts a start before every finish"))
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        if let Some(lost) = self.lost.take() {
            return Err(failed(lost));
        }
        std::mem::swap(&mut self.accepted, &mut self.trial);
        self.accepted_ledger = self.trial_ledger.clone();
        self.accepted_passed.clone_from(&self.trial_passed);
        if snapshot.is_some() {
            self.snapshots.write(self.end_of_trial, &self.accepted)?;
            if self.shown_walls.moves() {
                self.shown_walls.move_to(self.end_of_trial, (1.0, 0.0));
                self.snapshots.write_walls(self.end_of_trial, &self.shown_walls)?;
            }
        }
        Ok(())
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        let own = F::save(&self.accepted);
        let told = (&self.accepted_ledger, &self.accepted_passed[..]);
        Ok(saved::to_bytes(&self.ready, self.fluid.output(), told, self.snapshots.times(), &own))
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        let read = saved::from_bytes(state, self.fluid.output(), self.accepted_passed.len());
        let (ready, output, (ledger, passed), shown, own) = read.map_err(failed)?;
        self.accepted = F::restore(own).map_err(failed)?;
        self.snapshots.go_on(shown)?;
        (self.accepted_ledger, self.accepted_passed) = (ledger, passed);
        *self.fluid.output_mut() = output;
        self.ready.clone_from(&ready);
        self.give_load(outputs);
        Ok(ready)
    }

    fn terminate(&mut self) -> Result<()> {
        Ok(())
    }
}

fn read<const D: usize>(field: Option<&[f64]>, vectors: &mut Vec<Vector<D>>) {
    vectors.clear();
    vectors.extend(field.unwrap_or_default().chunks_exact(D).map(Vector::from_column_slice));
}

fn describe<const D: usize>(method: &str, probes: &[Watched<D>]) -> Description {
    let port = |name, quantity, direction| Port::new(name, quantity, D, None, direction);
    let mut scalars: Vec<Scalar> = Ledger::NAMES
        .iter()
        .map(|(name, unit, meaning)| Scalar::new(*name, unit, ScalarKind::Balance).meaning(*meaning))
        .collect();
    for watched in probes {
        scalars.extend(watched.probe.scalars(D));
    }
    Description {
        role: Role::Fluid,
        solver: format!("meniscus fluid ({method})"),
        dimension: D,
        ports: vec![
            port(names::REFERENCE_VOLUME, Quantity::ReferenceVolume, Direction::In).constant(),
            port(names::DENSITY, Quantity::Density, Direction::In).constant(),
            port(names::POSITION, Quantity::Position, Direction::In),
            port(names::VELOCITY, Quantity::Velocity, Direction::In),
            port(names::HELD_PRESSURE_GRADIENT, Quantity::PressureGradient, Direction::In).optional(),
            port(names::PRESSURE_GRADIENT, Quantity::PressureGradient, Direction::Out),
            port(names::PRESSURE, Quantity::Pressure, Direction::Out),
            port(names::PAIR_REACTION, Quantity::PairReaction, Direction::Out),
            port(names::NORMAL, Quantity::Normal, Direction::Out),
        ],
        scalars,
        saves: true,
        notes: vec![],
    }
}
