//! A structure whose points are not those of the fluid, behind a mapping: to the coupling it is a structure
//! whose particles fill its bodies.
//!
//! The structure names its own points, such as the vertices of a boundary mesh, and its facets. The fluid
//! meets particles on a lattice in the bodies of the case. Motion goes to them by the weights of a
//! [mapping](crate::mapping) (`u_t = Σ W_ts u_s`, of displacements since the weights were made); loads on
//! them come back by the transpose, as forces: force, moment and power are kept. A rigid motion stays one.
//! Everything between fluid and structure is on the fluid's side of the mapping: condition (46),
//! acceleration, records.

pub mod fluid;
mod weights;

use crate::mapping::{Method, POINTS_PER_CLUSTER, Settings};
use crate::phase::{Announce, Phase};
use interfaces::case::Case;
use interfaces::case::coupling::{self, MappingMethod};
use interfaces::port::names;
use interfaces::{
    Description, Direction, Fields, Participant, ParticipantError, Port, Quantity, Readiness, Result,
    TimeWindow, WindowReport,
};
use weights::{Weights, initialised};

/// Particles that fill the bodies of a case.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filling {
    /// Positions in the reference configuration (m), flat.
    pub positions: Vec<f64>,
    /// Volumes (m³).
    pub volumes: Vec<f64>,
    /// Density (kg/m³).
    pub density: f64,
}

impl Filling {
    /// On lattices of about `spacing` (m) in the bodies' boxes.
    pub fn of(case: &Case, spacing: f64) -> Self {
        let mut filling = Self::default();
        let Some(structure) = &case.structure else { return filling };
        filling.density = structure.density();
        for body in &structure.bodies {
            let (counts, extent) = (body.bounds.lattice_counts(spacing), body.bounds.extent());
            let cell: Vec<f64> = extent.iter().zip(&counts).map(|(length, n)| length / *n as f64).collect();
            for point in 0..counts.iter().product() {
                let mut rest: usize = point;
                for axis in 0..counts.len() {
                    let at = (rest % counts[axis]) as f64 + 0.5;
                    filling.positions.push(body.bounds.low[axis] + at * cell[axis]);
                    rest /= counts[axis];
                }
                filling.volumes.push(cell.iter().product());
            }
        }
        filling
    }
}

/// A structure behind a mapping.
pub struct Mapped<P> {
    inner: P,
    description: Description,
    choice: coupling::Mapping,
    filling: Filling,
    announce: Announce,
    threads: usize,
    /// The structure's own fields.
    inputs: Fields,
    outputs: Fields,
    /// From the structure's points to the particles; made at initialisation.
    weights: Option<Weights>,
    /// Whether the next window starts with weights that are made anew.
    stale: bool,
    /// Forces on the particles (N).
    forces: Vec<f64>,
}

/// Which of the structure's ports takes the load that the coupling has under that name.
const LOADS: [(&str, &str); 2] =
    [(names::PRESSURE_GRADIENT, names::FORCE), (names::START_PRESSURE_GRADIENT, names::START_FORCE)];

impl<P: Participant> Mapped<P> {
    /// Puts a structure behind a mapping to the particles.
    ///
    /// # Errors
    /// Where the structure lacks what it needs for that: positions of its own number of points, and a port
    /// for the force.
    pub fn new(inner: P, choice: coupling::Mapping, filling: Filling, announce: Announce) -> Result<Self> {
        let own = inner.describe();
        let port = |name, direction| own.ports.iter().find(|p| p.name == name && p.direction == direction);
        let missing = |what: &str| {
            let remedy = "leave out coupling.mapping, or mend the participant";
            ParticipantError::failed(format!("a structure behind a mapping {what}: {remedy}"))
        };
        if port(names::POSITION, Direction::Out).is_none_or(|position| position.points.is_none()) {
            return Err(missing("gives `position` and says at how many points"));
        }
        let takes = |name| port(name, Direction::In).is_some();
        if !takes(names::FORCE) && !takes(names::PRESSURE_GRADIENT) {
            return Err(missing("takes `force`, or `pressure_gradient` where its points have volumes"));
        }
        if !takes(names::FORCE) && port(names::REFERENCE_VOLUME, Direction::Out).is_none() {
            return Err(missing("that takes `pressure_gradient` gives `reference_volume`"));
        }
        let (d, n) = (own.dimension, Some(filling.volumes.len()));
        let of = |name, quantity, direction| Port::new(name, quantity, d, n, direction);
        let mut ports = vec![
            of(names::REFERENCE_VOLUME, Quantity::ReferenceVolume, Direction::Out).constant(),
            of(names::DENSITY, Quantity::Density, Direction::Out).constant(),
            of(names::POSITION, Quantity::Position, Direction::Out),
            of(names::PRESSURE_GRADIENT, Quantity::PressureGradient, Direction::In),
        ];
        if port(names::VELOCITY, Direction::Out).is_some() {
            ports.push(of(names::VELOCITY, Quantity::Velocity, Direction::Out));
        }
        if takes(names::START_FORCE) || takes(names::START_PRESSURE_GRADIENT) {
            ports.push(of(names::START_PRESSURE_GRADIENT, Quantity::PressureGradient, Direction::In));
        }
        let description = Description { ports, solver: format!("{}, mapped", own.solver), ..own.clone() };
        Ok(Self {
            inner,
            description,
            choice,
            filling,
            announce,
            threads: 1,
            inputs: Fields::default(),
            outputs: Fields::default(),
            weights: None,
            stale: false,
            forces: Vec::new(),
        })
    }

    /// Lets the weights be made with so many threads.
    pub fn use_threads(&mut self, threads: usize) {
        self.threads = threads;
    }

    fn method(&self) -> Result<Method> {
        Ok(match self.choice.method {
            MappingMethod::NearestNeighbour => Method::NearestNeighbour,
            MappingMethod::NearestNeighbourGradient => Method::NearestNeighbourGradient,
            MappingMethod::RadialBasis => Method::RadialBasis { points_per_cluster: POINTS_PER_CLUSTER },
            MappingMethod::NearestProjection => {
                let facets = self.outputs.get(names::FACETS).ok_or_else(|| {
                    ParticipantError::failed(
                        "coupling.mapping.method = \"nearest-projection\" needs the structure's `facets`, which it does not give; take \"radial-basis\"",
                    )
                })?;
                let vertex = |number: &f64| {
                    let whole = *number >= 0.0 && number.fract() == 0.0 && *number < 1e15;
                    whole.then_some(*number as usize).ok_or_else(|| {
                        ParticipantError::failed(format!(
                            "field `facets` has {number}, which is the number of no point"
                        ))
                    })
                };
                Method::NearestProjection { facets: facets.iter().map(vertex).collect::<Result<_, _>>()? }
            }
        })
    }

    /// The structure's loads from those on the particles.
    fn take_loads(&mut self, given: &Fields) -> Result<()> {
        let Self { inputs, outputs, filling, weights, forces, description, .. } = self;
        let (mapping, d) = (initialised(weights).mapping(), description.dimension);
        for (name, force_name) in LOADS {
            let Some(load) = given.get(name) else { continue };
            if let Some(force) = inputs.get_mut(force_name) {
                forces.resize(load.len(), 0.0);
                let each = forces.chunks_exact_mut(d).zip(load.chunks_exact(d)).zip(&filling.volumes);
                for ((force, gradient), volume) in each {
                    for (f, g) in force.iter_mut().zip(gradient) {
                        *f = -volume * g;
                    }
                }
                mapping.conservative(d, forces, force);
            } else if let Some(gradient) = inputs.get_mut(name) {
                let volumes = outputs.get(names::REFERENCE_VOLUME).unwrap_or(&[]);
                mapping
                    .conservative_per_volume(d, &filling.volumes, load, volumes, gradient)
                    .map_err(failed)?;
            }
        }
        Ok(())
    }

    /// The particles' motion from that of the structure.
    fn give_motion(&mut self, given: &mut Fields) {
        let Self { outputs, weights, description, .. } = self;
        let weights = initialised(weights);
        if let (Some(own), Some(field)) = (outputs.get(names::POSITION), given.get_mut(names::POSITION)) {
            weights.position(own, field);
        }
        if let (Some(own), Some(field)) = (outputs.get(names::VELOCITY), given.get_mut(names::VELOCITY)) {
            weights.mapping().consistent(description.dimension, own, field);
        }
    }
}

fn failed(error: impl std::fmt::Display) -> ParticipantError {
    ParticipantError::failed(format!(
        "failed to map between the structure's points and those in its bodies: {error}"
    ))
}

impl<P: Participant> Participant for Mapped<P> {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn initialize(&mut self, start: f64, _inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        self.inputs = self.inner.describe().fields(Direction::In, 0);
        self.outputs = self.inner.describe().fields(Direction::Out, 0);
        let ready = self.inner.initialize(start, &self.inputs, &mut self.outputs)?;
        let settings = Settings {
            dimension: self.description.dimension,
            reach: self.choice.reach,
            method: self.method()?,
        };
        let own = self.outputs.get(names::POSITION).unwrap_or(&[]).to_vec();
        let announce = self.announce.clone();
        announce.during(Phase::Mapping, || {
            let made_at = [own, self.filling.positions.clone()];
            self.weights = Some(Weights::build(settings, made_at, self.threads).map_err(failed)?);
            self.give_motion(outputs);
            Ok::<_, ParticipantError>(())
        })?;
        if let Some(field) = outputs.get_mut(names::REFERENCE_VOLUME) {
            field.copy_from_slice(&self.filling.volumes);
        }
        if let Some(field) = outputs.get_mut(names::DENSITY) {
            field.fill(self.filling.density);
        }
        Ok(ready)
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        let announce = self.announce.clone();
        announce.during(Phase::Mapping, || {
            if std::mem::take(&mut self.stale) {
                let own = self.outputs.get(names::POSITION).unwrap_or(&[]);
                initialised(&mut self.weights).follow(own).map_err(failed)?;
            }
            self.take_loads(inputs)
        })?;
        self.inner.start(window, &self.inputs)
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        let report = self.inner.finish(&mut self.outputs)?;
        let announce = self.announce.clone();
        announce.during(Phase::Mapping, || self.give_motion(outputs));
        Ok(report)
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        self.stale = self.choice.rebuild;
        self.inner.accept(snapshot)
    }

    /// The structure's state, and where the weights were made.
    fn save(&mut self) -> Result<Vec<u8>> {
        let own = self.inner.save()?;
        Ok(initialised(&mut self.weights).save(&own))
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        let announce = self.announce.clone();
        let weights = initialised(&mut self.weights);
        let own = announce.during(Phase::Mapping, || weights.restore(state)).map_err(failed)?;
        let ready = self.inner.restore(own, &mut self.outputs)?;
        announce.during(Phase::Mapping, || self.give_motion(outputs));
        // Of a state before the first window, weights made anew are the same.
        self.stale = self.choice.rebuild;
        Ok(ready)
    }

    fn terminate(&mut self) -> Result<()> {
        self.inner.terminate()
    }
}
