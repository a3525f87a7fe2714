//! A fluid whose points are not those of the structure, behind a mapping: to the coupling it is a fluid that
//! meets the structure's particles.
//!
//! The fluid names its own points, such as the wetted vertices of its mesh, where they are at the start
//! (`own_position`). Each window it takes their displacement since then at the window's start, and their
//! velocity over the window; it gives the force on each. Motion comes from the structure's particles by the
//! weights of a [mapping](crate::mapping) (`u_t = Σ W_ts u_s`); forces go to them by the transpose, as the
//! pressure gradients `∇p_s = −F_s/V_s`: force, moment and power are kept.

use super::weights::{Weights, initialised};
use crate::mapping::{Method, POINTS_PER_CLUSTER, Settings};
use crate::phase::{Announce, Phase};
use interfaces::case::coupling::{FluidMapping, FluidMappingMethod};
use interfaces::port::names;
use interfaces::{
    Description, Direction, Exchange, Fields, Participant, ParticipantError, Port, Quantity, Readiness,
    Result, TimeWindow, WindowReport,
};

/// A fluid behind a mapping.
pub struct MappedFluid<P> {
    inner: P,
    description: Description,
    choice: FluidMapping,
    announce: Announce,
    threads: usize,
    /// The fluid's own fields.
    inputs: Fields,
    outputs: Fields,
    /// From the structure's particles to the fluid's points; made at initialisation.
    weights: Option<Weights>,
    /// Whether the next window starts with weights that are made anew.
    stale: bool,
    /// Reference volumes of the structure's particles (m³).
    volumes: Vec<f64>,
}

impl<P: Participant> MappedFluid<P> {
    /// Puts a fluid behind a mapping from the structure's particles.
    ///
    /// # Errors
    /// Where the fluid lacks what it needs for that: `own_position` and `force` given, `displacement` or
    /// `velocity` taken, at its own number of points.
    pub fn new(inner: P, choice: FluidMapping, announce: Announce) -> Result<Self> {
        let own = inner.describe();
        let port = |name, direction| {
            let mut ports = own.ports.iter();
            ports.find(|p| p.name == name && p.direction == direction && p.points.is_some())
        };
        let missing = |what: &str| {
            let remedy = "leave out coupling.fluid_mapping, or mend the participant";
            ParticipantError::failed(format!("a fluid behind a mapping {what}: {remedy}"))
        };
        let at = port(names::OWN_POSITION, Direction::Out);
        if at.is_none_or(|position| position.exchange != Exchange::Constant) {
            return Err(missing("gives `own_position`, once, and says at how many points"));
        }
        if port(names::FORCE, Direction::Out).is_none() {
            return Err(missing("gives `force` at these points"));
        }
        if [names::DISPLACEMENT, names::VELOCITY].iter().all(|name| port(name, Direction::In).is_none()) {
            return Err(missing("takes `displacement` or `velocity` of these points"));
        }
        let d = own.dimension;
        let of = |name, quantity, direction| Port::new(name, quantity, d, None, direction);
        let mut ports = vec![
            of(names::REFERENCE_VOLUME, Quantity::ReferenceVolume, Direction::In).constant(),
            of(names::POSITION, Quantity::Position, Direction::In),
            of(names::PRESSURE_GRADIENT, Quantity::PressureGradient, Direction::Out),
        ];
        if port(names::VELOCITY, Direction::In).is_some() {
            ports.push(of(names::VELOCITY, Quantity::Velocity, Direction::In));
        }
        let description = Description { ports, solver: format!("{}, mapped", own.solver), ..own.clone() };
        Ok(Self {
            inner,
            description,
            choice,
            announce,
            threads: 1,
            inputs: Fields::default(),
            outputs: Fields::default(),
            weights: None,
            stale: false,
            volumes: Vec::new(),
        })
    }

    /// Lets the weights be made with so many threads.
    pub fn use_threads(&mut self, threads: usize) {
        self.threads = threads;
    }

    fn method(&self) -> Method {
        match self.choice.method {
            FluidMappingMethod::NearestNeighbour => Method::NearestNeighbour,
            FluidMappingMethod::NearestNeighbourGradient => Method::NearestNeighbourGradient,
            FluidMappingMethod::RadialBasis => Method::RadialBasis { points_per_cluster: POINTS_PER_CLUSTER },
        }
    }

    /// The fluid's points' motion from that of the particles.
    fn take_motion(&mut self, given: &Fields) {
        let Self { inputs, outputs, weights, description, .. } = self;
        let weights = initialised(weights);
        if let (Some(now), Some(displacement)) =
            (given.get(names::POSITION), inputs.get_mut(names::DISPLACEMENT))
        {
            weights.displacement(now, displacement);
            // What they had moved before the weights were made.
            let start = outputs.get(names::OWN_POSITION).unwrap_or(&[]);
            for ((u, then), start) in displacement.iter_mut().zip(weights.targets_made_at()).zip(start) {
                *u += then - start;
            }
        }
        if let (Some(of_particles), Some(own)) = (given.get(names::VELOCITY), inputs.get_mut(names::VELOCITY))
        {
            weights.mapping().consistent(description.dimension, of_particles, own);
        }
    }

    /// The particles' load from the forces on the fluid's points.
    fn give_load(&mut self, given: &mut Fields) {
        let Self { outputs, weights, volumes, description, .. } = self;
        let (mapping, d) = (initialised(weights).mapping(), description.dimension);
        if let (Some(force), Some(load)) =
            (outputs.get(names::FORCE), given.get_mut(names::PRESSURE_GRADIENT))
        {
            mapping.conservative(d, force, load);
            for (gradient, volume) in load.chunks_exact_mut(d).zip(&*volumes) {
                gradient.iter_mut().for_each(|g| *g = -*g / volume);
            }
        }
    }
}

fn failed(error: impl std::fmt::Display) -> ParticipantError {
    ParticipantError::failed(format!(
        "failed to map between the structure's particles and the fluid's points: {error}"
    ))
}

impl<P: Participant> Participant for MappedFluid<P> {
    fn describe(&self) -> &Description {
        &self.description
    }

    /// The fluid is initialised with its points at rest where they are: what it gives decides the weights.
    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        self.inputs = self.inner.describe().fields(Direction::In, 0);
        self.outputs = self.inner.describe().fields(Direction::Out, 0);
        let ready = self.inner.initialize(start, &self.inputs, &mut self.outputs)?;
        let settings = Settings {
            dimension: self.description.dimension,
            reach: self.choice.reach,
            method: self.method(),
        };
        let particles = inputs.get(names::POSITION).unwrap_or(&[]).to_vec();
        let own = self.outputs.get(names::OWN_POSITION).unwrap_or(&[]).to_vec();
        self.volumes = inputs.get(names::REFERENCE_VOLUME).unwrap_or(&[]).to_vec();
        if let Some(particle) = self.volumes.iter().position(|volume| *volume <= 0.0) {
            return Err(ParticipantError::failed(format!(
                "particle {particle} of the structure has the volume {}: a fluid behind a mapping needs positive ones",
                self.volumes[particle]
            )));
        }
        let announce = self.announce.clone();
        announce.during(Phase::Mapping, || {
            let weights = Weights::build(settings, [particles, own], self.threads).map_err(failed)?;
            self.weights = Some(weights);
            self.stale = self.choice.rebuild;
            self.give_load(outputs);
            Ok::<_, ParticipantError>(())
        })?;
        Ok(ready)
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        let announce = self.announce.clone();
        announce.during(Phase::Mapping, || {
            // Every iteration of a window begins at the same positions, so the weights of the first serve
            // all.
            if std::mem::take(&mut self.stale) {
                let now = inputs.get(names::POSITION).unwrap_or(&[]);
                initialised(&mut self.weights).follow(now).map_err(failed)?;
            }
            self.take_motion(inputs);
            Ok::<_, ParticipantError>(())
        })?;
        self.inner.start(window, &self.inputs)
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        let report = self.inner.finish(&mut self.outputs)?;
        let announce = self.announce.clone();
        announce.during(Phase::Mapping, || self.give_load(outputs));
        Ok(report)
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        self.stale = self.choice.rebuild;
        self.inner.accept(snapshot)
    }

    /// The fluid's state, and where the weights were made.
    fn save(&mut self) -> Result<Vec<u8>> {
        let own = self.inner.save()?;
        Ok(initialised(&mut self.weights).save(&own))
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        let announce = self.announce.clone();
        let weights = initialised(&mut self.weights);
        let own = announce.during(Phase::Mapping, || weights.restore(state)).map_err(failed)?;
        let ready = self.inner.restore(own, &mut self.outputs)?;
        announce.during(Phase::Mapping, || self.give_load(outputs));
        self.stale = self.choice.rebuild;
        Ok(ready)
    }

    fn terminate(&mut self) -> Result<()> {
        self.inner.terminate()
    }
}
