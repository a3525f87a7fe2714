//! A fluid whose points are not those of the structure, behind a mapping: to the coupling it is a fluid that
//! meets the structure's particles.
//!
//! The fluid names its own points, such as the wetted vertices of its mesh, where they are at the start
//! (`own_position`). Each window it takes their displacement since then at the window's start, and their
//! velocity over the window; it gives the force on each. Motion comes from the structure's particles by the
//! weights of a [`Mapping`] (`u_t = Σ W_ts u_s`); forces go to them by the transpose, as the pressure
//! gradients `∇p_s = −F_s/V_s`: force, moment and power are kept.

use super::initialised;
use crate::mapping::{Mapping, MappingError, Method, POINTS_PER_CLUSTER, Settings};
use crate::phase::{Announce, Phase};
use interfaces::case::coupling::{FluidMapping, FluidMappingMethod};
use interfaces::port::names;
use interfaces::{
    Description, Direction, Exchange, Fields, Participant, ParticipantError, Port, Quantity, Readiness,
    TimeWindow, WindowReport,
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
    /// Made at initialisation.
    mapping: Option<Mapping>,
    /// Positions for which the weights were made (m): the structure's particles', the fluid's points'.
    made_at: [Vec<f64>; 2],
    /// Reference volumes of the structure's particles (m³).
    volumes: Vec<f64>,
    /// Displacements of the structure's particles, and of the fluid's points, since the weights were made
    /// (m).
    scratch: [Vec<f64>; 2],
}

impl<P: Participant> MappedFluid<P> {
    /// Puts a fluid behind a mapping from the structure's particles.
    ///
    /// # Errors
    /// Where the fluid lacks what it needs for that: `own_position` and `force` given, `displacement` or
    /// `velocity` taken, at its own number of points.
    pub fn new(inner: P, choice: FluidMapping, announce: Announce) -> Result<Self, ParticipantError> {
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
            mapping: None,
            made_at: [Vec::new(), Vec::new()],
            volumes: Vec::new(),
            scratch: [Vec::new(), Vec::new()],
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
        let Self { inputs, outputs, mapping, made_at, scratch, description, .. } = self;
        let (mapping, d) = (initialised(mapping), description.dimension);
        if let (Some(now), Some(displacement)) =
            (given.get(names::POSITION), inputs.get_mut(names::DISPLACEMENT))
        {
            let moved = &mut scratch[0];
            moved.clear();
            moved.extend(now.iter().zip(&made_at[0]).map(|(now, then)| now - then));
            mapping.consistent(d, moved, displacement);
            // What they had moved before the weights were made.
            let start = outputs.get(names::OWN_POSITION).unwrap_or(&[]);
            for ((u, then), start) in displacement.iter_mut().zip(&made_at[1]).zip(start) {
                *u += then - start;
            }
        }
        if let (Some(of_particles), Some(own)) = (given.get(names::VELOCITY), inputs.get_mut(names::VELOCITY))
        {
            mapping.consistent(d, of_particles, own);
        }
    }

    /// The particles' load from the forces on the fluid's points.
    fn give_load(&self, given: &mut Fields) {
        let Self { outputs, mapping, volumes, description, .. } = self;
        let (mapping, d) = (initialised(mapping), description.dimension);
        if let (Some(force), Some(load)) =
            (outputs.get(names::FORCE), given.get_mut(names::PRESSURE_GRADIENT))
        {
            mapping.conservative(d, force, load);
            for (gradient, volume) in load.chunks_exact_mut(d).zip(volumes) {
                gradient.iter_mut().for_each(|g| *g = -*g / volume);
            }
        }
    }

    /// Makes the weights for where the points are at the window's start.
    fn rebuild(&mut self, given: &Fields) -> Result<(), ParticipantError> {
        let (d, mapping) = (self.description.dimension, self.mapping.as_mut());
        let mapping = mapping.expect("a mapping is made at initialisation, which comes before all else");
        let ([source, target], [moved, follow]) = (&mut self.made_at, &mut self.scratch);
        let now = given.get(names::POSITION).unwrap_or(&[]);
        moved.clear();
        moved.extend(now.iter().zip(&*source).map(|(now, then)| now - then));
        follow.resize(target.len(), 0.0);
        mapping.consistent(d, moved, follow);
        target.iter_mut().zip(&*follow).for_each(|(x, u)| *x += u);
        source.copy_from_slice(now);
        mapping.update(source, target).map_err(failed)
    }
}

#[expect(clippy::needless_pass_by_value, reason = "what map_err gives")]
fn failed(error: MappingError) -> ParticipantError {
    ParticipantError::failed(format!(
        "failed to map between the structure's particles and the fluid's points: {error}"
    ))
}

impl<P: Participant> Participant for MappedFluid<P> {
    fn describe(&self) -> &Description {
        &self.description
    }

    /// The fluid is initialised with its points at rest where they are: what it gives decides the weights.
    fn initialize(
        &mut self,
        start: f64,
        inputs: &Fields,
        outputs: &mut Fields,
    ) -> Result<Readiness, ParticipantError> {
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
            let mut mapping = Mapping::build(settings, &particles, &own).map_err(failed)?;
            mapping.use_threads(self.threads);
            self.mapping = Some(mapping);
            self.made_at = [particles, own];
            self.give_load(outputs);
            Ok::<_, ParticipantError>(())
        })?;
        Ok(ready)
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<(), ParticipantError> {
        let announce = self.announce.clone();
        announce.during(Phase::Mapping, || {
            // Every iteration of a window begins at the same positions, so the weights of the first serve
            // all.
            if self.choice.rebuild && window.iteration == 0 {
                self.rebuild(inputs)?;
            }
            self.take_motion(inputs);
            Ok::<_, ParticipantError>(())
        })?;
        self.inner.start(window, &self.inputs)
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport, ParticipantError> {
        let report = self.inner.finish(&mut self.outputs)?;
        let announce = self.announce.clone();
        announce.during(Phase::Mapping, || self.give_load(outputs));
        Ok(report)
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<(), ParticipantError> {
        self.inner.accept(snapshot)
    }

    /// The fluid's state, and where the weights were made.
    fn save(&mut self) -> Result<Vec<u8>, ParticipantError> {
        let mut state = super::bytes_of(&self.made_at);
        state.extend(self.inner.save()?);
        Ok(state)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), ParticipantError> {
        let own = super::read_positions(&mut self.made_at, state)?;
        let [source, target] = &self.made_at;
        if let Some(mapping) = &mut self.mapping {
            mapping.update(source, target).map_err(failed)?;
        }
        self.inner.restore(own)
    }

    fn terminate(&mut self) -> Result<(), ParticipantError> {
        self.inner.terminate()
    }
}
