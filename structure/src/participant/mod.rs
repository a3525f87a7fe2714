//! The structure as a participant: the one module of this crate that knows the case, messages and outputs.
//!
//! Case → [`crate::Setup`]; interface fields ↔ arrays of vectors; accepted state → snapshots, probes and
//! energies.

mod error;
mod section;
mod setup;
mod snapshot;

use crate::bodies::point::MaterialPoint;
use crate::loads::Load;
use crate::particles::Particles;
use crate::probes::{Reading, Seen, What};
use crate::solid::Solid;
use crate::state::{Derived, State};
use crate::tlsph::total_lagrangian::TotalLagrangian;
use error::failed;
use interfaces::case::Case;
use interfaces::case::coupling::LoadInWindow;
use interfaces::case::motion::Motion;
use interfaces::case::probe::{Probe, ProbeTarget};
use interfaces::port::names;
use interfaces::{
    Description, Direction, Fields, Participant, Port, Quantity, Readiness, Result, Role, Scalar, ScalarKind,
    TimeWindow, WindowReport,
};
pub use section::SECTIONS;
use snapshot::Snapshots;
use sph::Vector;
use std::path::Path;
use std::time::Instant;
use words::bytes;
use words::probe::ProbeQuantity;

/// Most sub-steps in a window of a structure without a partner, which nobody else limits: its stable step is
/// found between windows.
const SUB_STEPS_ALONE: u32 = 100;

/// The structure of `case`, writing its snapshots to the folder `out`.
///
/// # Errors
/// What the setup refuses, with all its mistakes; a folder that cannot be written.
pub fn from_case(case: &Case, out: &Path) -> Result<Box<dyn Participant>> {
    Ok(match case.general.dimension {
        2 => Box::new(StructureParticipant::<TotalLagrangian<2>, 2>::new(case, Some(out))?),
        _ => Box::new(StructureParticipant::<TotalLagrangian<3>, 3>::new(case, Some(out))?),
    })
}

/// The structure as a participant that also says how it is stressed, and how far it could step.
pub trait Stressed: Participant {
    /// The largest stable sub-step (s) from the accepted state.
    fn stable_time_step(&self) -> f64;

    /// The largest von Mises stress (Pa) of the particles in the accepted state.
    ///
    /// # Errors
    /// A state that is not finite.
    fn largest_von_mises_stress(&mut self) -> Result<f64>;
}

/// The structure of `case`, which writes no snapshots.
///
/// # Errors
/// What the setup refuses, with all its mistakes.
pub fn without_snapshots(case: &Case) -> Result<Box<dyn Stressed + Send>> {
    Ok(match case.general.dimension {
        2 => Box::new(StructureParticipant::<TotalLagrangian<2>, 2>::new(case, None)?),
        _ => Box::new(StructureParticipant::<TotalLagrangian<3>, 3>::new(case, None)?),
    })
}

/// What the structure of `case` would be: pairs of what and value, for `meniscus check`.
///
/// # Errors
/// What the setup refuses, with all its mistakes.
pub fn preview(case: &Case) -> Result<Vec<(String, String)>> {
    match case.general.dimension {
        2 => preview_in::<TotalLagrangian<2>, 2>(case),
        _ => preview_in::<TotalLagrangian<3>, 3>(case),
    }
}

fn preview_in<S: Solid<D>, const D: usize>(case: &Case) -> Result<Vec<(String, String)>> {
    let (solid, state) = build::<S, D>(case)?;
    let stable = state.stability.step;
    let particles = solid.particles();
    let free = particles.free.len();
    let line = |what: &str, value: String| (what.to_owned(), value);
    let mut lines = vec![
        line("particles", format!("{} ({free} free)", particles.len())),
        line("stable sub-step", format!("{stable:.3e} s")),
    ];
    if let Some(count) = most_sub_steps(case) {
        lines
            .push(line("largest window", format!("{:.3e} s ({count} sub-steps)", stable * f64::from(count))));
    }
    Ok(lines)
}

/// Sub-steps of the largest window, unless windows may be of any size.
pub fn most_sub_steps(case: &Case) -> Option<u32> {
    case.coupling.as_ref().map_or(Some(SUB_STEPS_ALONE), |coupling| coupling.sub_steps.count())
}

/// The largest stable sub-step (s) of the structure of `case` at the start.
///
/// # Errors
/// A setting that cannot be used.
pub fn stable_sub_step(case: &Case) -> Result<f64> {
    Ok(match case.general.dimension {
        2 => build::<TotalLagrangian<2>, 2>(case)?.1.stability.step,
        _ => build::<TotalLagrangian<3>, 3>(case)?.1.stability.step,
    })
}

fn build<S: Solid<D>, const D: usize>(case: &Case) -> Result<(S, State<D>)> {
    let made = setup::from_case::<D>(case)?;
    let mut solid = S::new(made.setup).map_err(failed)?;
    let mut state = solid.state_at_rest(0.0);
    for &particle in &solid.particles().free {
        let particle = particle as usize;
        state.velocities[particle] = made.velocities[particle];
    }
    solid.evaluate(&mut state).map_err(failed)?;
    Ok((solid, state))
}

/// First bytes of a saved state; the last is the version of its layout.
const MAGIC: &[u8; 8] = b"mnscstp2";

struct StructureParticipant<S: Solid<D>, const D: usize> {
    description: Description,
    solid: S,
    accepted: State<D>,
    trial: State<D>,
    /// Pressure gradient at the interface particles (Pa/m).
    load: Vec<Vector<D>>,
    /// The same at the window's start, where the case says that the load is linear within a window.
    start_load: Option<Vec<Vector<D>>>,
    /// Sub-steps of the largest window, unless windows may be of any size.
    most_sub_steps: Option<u32>,
    readings: Vec<Reading<D>>,
    report: Option<WindowReport>,
    /// Limit and scalars at the end of the last solution: between windows, of the accepted state. Some depend
    /// on the load, which the state does not have.
    ready: Readiness,
    derived: Derived<D>,
    snapshots: Option<Snapshots<D>>,
}

impl<S: Solid<D>, const D: usize> StructureParticipant<S, D> {
    fn new(case: &Case, out: Option<&Path>) -> Result<Self> {
        let (solid, accepted) = build::<S, D>(case)?;
        let particles = solid.particles();
        let points = particles.interface.len();
        Ok(Self {
            description: describe(case, S::METHOD, points, particles),
            trial: accepted.clone(),
            accepted,
            load: vec![Vector::zeros(); points],
            most_sub_steps: most_sub_steps(case),
            start_load: linear_load(case).then(|| vec![Vector::zeros(); points]),
            readings: readings(case, particles)?,
            report: None,
            ready: Readiness { window_limit: f64::INFINITY, scalars: Vec::new() },
            derived: Derived::default(),
            snapshots: out.map(|out| Snapshots::create(out, particles)).transpose()?,
            solid,
        })
    }

    /// The largest window (s) from a state: what its number of sub-steps can do stably.
    fn window_limit(&self, state: &State<D>) -> f64 {
        self.most_sub_steps.map_or(f64::INFINITY, |count| state.stability.step * f64::from(count))
    }

    fn give_motion(&self, state: &State<D>, outputs: &mut Fields) {
        let particles = &self.solid.particles().interface;
        for (name, values) in [(names::POSITION, &state.positions), (names::VELOCITY, &state.velocities)] {
            if let Some(field) = outputs.get_mut(name) {
                for (to, &particle) in field.chunks_exact_mut(D).zip(particles) {
                    to.copy_from_slice(values[particle as usize].as_slice());
                }
            }
        }
    }

    /// What is told of the accepted state, or of the trial's.
    fn scalars(&mut self, of_trial: bool) -> Result<Vec<f64>> {
        let state = if of_trial { &self.trial } else { &self.accepted };
        if self.readings.iter().any(|reading| reading.of.is_derived()) {
            self.solid.derive(state, &mut self.derived).map_err(failed)?;
        }
        let (energy, particles) = (&state.energy, self.solid.particles());
        let potential = particles.potential_energy(&state.positions);
        let mut scalars = vec![energy.kinetic, energy.strain, potential, energy.load_work];
        let contact = Touching::of(particles);
        scalars.extend(particles.clamps_move().then_some(energy.clamp_work));
        scalars.extend(contact.walls_that_move.then_some(energy.wall_work));
        scalars.extend(contact.anything.then_some(energy.contact));
        scalars.push(energy.dissipated);
        scalars.extend(contact.with_friction.then_some(energy.friction_loss));
        let seen = Seen { particles, state, derived: &self.derived, load: &self.load };
        for reading in &self.readings {
            reading.push(&seen, ProbeQuantity::places(D), &mut scalars);
        }
        Ok(scalars)
    }

    fn write_snapshot(&mut self) -> Result<()> {
        match &mut self.snapshots {
            Some(snapshots) => snapshots.write(&mut self.solid, &self.accepted),
            None => Ok(()),
        }
    }
}

impl<S: Solid<D>, const D: usize> Stressed for StructureParticipant<S, D> {
    fn stable_time_step(&self) -> f64 {
        self.accepted.stability.step
    }

    fn largest_von_mises_stress(&mut self) -> Result<f64> {
        self.solid.derive(&self.accepted, &mut self.derived).map_err(failed)?;
        Ok(self.derived.von_mises.iter().copied().fold(0.0, f64::max))
    }
}

impl<S: Solid<D>, const D: usize> Participant for StructureParticipant<S, D> {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn initialize(&mut self, start: f64, _inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        self.accepted.time = start;
        let particles = self.solid.particles();
        particles.put_clamps(&mut self.accepted);
        if let Some(field) = outputs.get_mut(names::REFERENCE_VOLUME) {
            for (to, &particle) in field.iter_mut().zip(&particles.interface) {
                *to = particles.volumes[particle as usize];
            }
        }
        if let Some(field) = outputs.get_mut(names::DENSITY) {
            for (to, &particle) in field.iter_mut().zip(&particles.interface) {
                // A particle of no density does not yield to its load.
                let held = particles.clamped[particle as usize];
                *to = if held { 0.0 } else { particles.densities[particle as usize] };
            }
        }
        self.give_motion(&self.accepted, outputs);
        self.write_snapshot()?;
        self.ready =
            Readiness { window_limit: self.window_limit(&self.accepted), scalars: self.scalars(false)? };
        Ok(self.ready.clone())
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        let started = Instant::now();
        take_vectors(inputs, names::PRESSURE_GRADIENT, &mut self.load);
        if let Some(start_load) = &mut self.start_load {
            take_vectors(inputs, names::START_PRESSURE_GRADIENT, start_load);
        }
        let sub_steps = window.sub_steps.count().map(|count| count as usize);
        let sub_steps = sub_steps.unwrap_or_else(|| self.accepted.stable_sub_steps(window.size));
        self.accepted.time = window.start;
        let load = match &self.start_load {
            Some(start_load) => Load::Linear(start_load, &self.load),
            None => Load::Held(&self.load),
        };
        self.solid.advance(&self.accepted, &mut self.trial, window.size, sub_steps, &load).map_err(failed)?;
        self.ready = Readiness { window_limit: self.window_limit(&self.trial), scalars: self.scalars(true)? };
        self.report = Some(WindowReport {
            sub_steps: sub_steps as u32,
            window_limit: self.ready.window_limit,
            scalars: self.ready.scalars.clone(),
            compute_seconds: started.elapsed().as_secs_f64(),
        });
        Ok(())
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        self.give_motion(&self.trial, outputs);
        Ok(self.report.take().expect("the table of legal calls puts a start before every finish"))
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        std::mem::swap(&mut self.accepted, &mut self.trial);
        if snapshot.is_some() {
            self.write_snapshot()?;
        }
        Ok(())
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        let mut state = bytes::Writer::new(MAGIC);
        state.f64(self.ready.window_limit);
        state.f64s(&self.ready.scalars);
        state.f64s(self.snapshots.as_ref().map_or(&[], Snapshots::times));
        state.bytes(&self.accepted.to_bytes());
        Ok(state.finish())
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        let read = || {
            let mut state = bytes::Reader::new("structure's state", MAGIC, state)?;
            let window_limit = state.f64("window limit")?;
            let scalars = state.f64s("scalars", Some(self.description.scalars.len()))?;
            let times = state.f64s("times of snapshots", None)?;
            let own = state.bytes("particles")?;
            state.finish().map(|()| (Readiness { window_limit, scalars }, times, own))
        };
        let (ready, times, own) = read().map_err(|error: bytes::Error| failed(error))?;
        if let Some(snapshots) = &mut self.snapshots {
            snapshots.go_on(times)?;
        }
        self.accepted = State::from_bytes(own, self.solid.particles().len()).map_err(failed)?;
        self.ready.clone_from(&ready);
        self.give_motion(&self.accepted, outputs);
        Ok(ready)
    }

    fn terminate(&mut self) -> Result<()> {
        Ok(())
    }
}

/// Whether the sub-steps are to see the load go linearly from its value at the window's start to that at its
/// end.
fn linear_load(case: &Case) -> bool {
    case.coupling.as_ref().is_some_and(|coupling| coupling.load_in_window == LoadInWindow::Linear)
}

/// Copies the field of that name, if it is given.
fn take_vectors<const D: usize>(inputs: &Fields, name: &str, vectors: &mut [Vector<D>]) {
    if let Some(field) = inputs.get(name) {
        for (to, from) in vectors.iter_mut().zip(field.chunks_exact(D)) {
            *to = Vector::from_column_slice(from);
        }
    }
}

/// What a structure may touch, which decides on what it tells of that.
struct Touching {
    anything: bool,
    walls_that_move: bool,
    with_friction: bool,
}

impl Touching {
    fn of<const D: usize>(particles: &Particles<D>) -> Self {
        let contact = &particles.setup.contact;
        let anything = contact.acts(particles.setup.bodies.len());
        Self {
            anything,
            walls_that_move: contact.walls_move(),
            with_friction: anything && contact.options.friction > 0.0,
        }
    }
}

fn describe<const D: usize>(
    case: &Case,
    method: &str,
    points: usize,
    particles: &Particles<D>,
) -> Description {
    let port = |name, quantity, direction| Port::new(name, quantity, D, Some(points), direction);
    let clamps = (names::CLAMP_WORK, "work of the clamps that move since the start");
    let walls = (names::WALL_WORK, "work of the walls that move on the structure since the start");
    let of_contact = (names::CONTACT_ENERGY, "energy of contact");
    let friction = (names::FRICTION_LOSS, "energy that friction took since the start");
    let contact = Touching::of(particles);
    let balances = [
        Some((names::KINETIC_ENERGY, "kinetic energy")),
        Some((names::STRAIN_ENERGY, "elastic energy of strain")),
        Some((names::POTENTIAL_ENERGY, "potential energy of gravity")),
        Some((names::LOAD_WORK, "work of all loads since the start, gravity among them")),
        particles.clamps_move().then_some(clamps),
        contact.walls_that_move.then_some(walls),
        contact.anything.then_some(of_contact),
        Some((names::DISSIPATED_ENERGY, "energy that damping took since the start")),
        contact.with_friction.then_some(friction),
    ];
    let balance = |(name, meaning)| Scalar::new(name, "J", ScalarKind::Balance).meaning(meaning);
    let mut scalars: Vec<Scalar> = balances.into_iter().flatten().map(balance).collect();
    for probe in case.probes.iter().filter(|p| p.is_on_structure()) {
        scalars.extend(probe.scalars(D));
    }
    let mut ports = vec![
        port(names::REFERENCE_VOLUME, Quantity::ReferenceVolume, Direction::Out).constant(),
        port(names::DENSITY, Quantity::Density, Direction::Out).constant(),
        port(names::POSITION, Quantity::Position, Direction::Out),
        port(names::VELOCITY, Quantity::Velocity, Direction::Out),
        port(names::PRESSURE_GRADIENT, Quantity::PressureGradient, Direction::In),
    ];
    if linear_load(case) {
        ports.push(port(names::START_PRESSURE_GRADIENT, Quantity::PressureGradient, Direction::In));
    }
    Description {
        role: Role::Structure,
        solver: format!("meniscus structure ({method})"),
        dimension: D,
        ports,
        scalars,
        saves: true,
        notes: vec![],
    }
}

fn readings<const D: usize>(case: &Case, particles: &Particles<D>) -> Result<Vec<Reading<D>>> {
    let bodies = &case.structure.as_ref().expect("a structure is made of a case that has one").bodies;
    let on_structure = case.probes.iter().filter(|p| p.is_on_structure());
    on_structure
        .map(|probe| {
            let frame = case.frame_of(probe).and_then(Motion::rigid);
            Ok(Reading { of: read(probe, bodies, particles)?, frame })
        })
        .collect()
}

fn read<const D: usize>(
    probe: &Probe,
    bodies: &[interfaces::case::structure::Body],
    particles: &Particles<D>,
) -> Result<What<D>> {
    let made = &particles.setup.bodies;
    let body_of = |name: &str| {
        let index =
            bodies.iter().position(|b| b.name == name).expect("a checked case names bodies that are there");
        let first: usize = made[..index].iter().map(|b| b.positions.len()).sum();
        (index, first)
    };
    match probe.target() {
        ProbeTarget::StructurePoint { body, at } => {
            let (index, first) = body_of(body);
            let body = &made[index];
            let at = Vector::from_column_slice(at);
            let mut point = MaterialPoint::new(at, &body.positions, body.spacing())
                .expect("a body of a checked case has particles");
            point.weights.iter_mut().for_each(|(particle, _)| *particle += first);
            Ok(match probe.quantity {
                ProbeQuantity::Displacement => What::Displacement(point),
                ProbeQuantity::Position => What::Position(point),
                ProbeQuantity::Velocity => What::Velocity(point),
                ProbeQuantity::Stress => What::Stress(point),
                ProbeQuantity::Strain => What::Strain(point),
                ProbeQuantity::VonMisesStress => What::VonMisesStress(point),
                other => {
                    return Err(failed(format!(
                        "probe `{}`: a point of the structure has no {other:?}",
                        probe.name
                    )));
                }
            })
        }
        ProbeTarget::Body(name) | ProbeTarget::BodyAbout { body: name, .. } => {
            let (index, first) = body_of(name);
            let body = first..first + made[index].positions.len();
            Ok(match probe.target() {
                ProbeTarget::BodyAbout { at, .. } => What::Moment(body, Vector::from_column_slice(at)),
                _ => What::Force(body),
            })
        }
        other => Err(failed(format!("probe `{}`: {other:?} is not on the structure", probe.name))),
    }
}
