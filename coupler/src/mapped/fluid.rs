//! A fluid whose points are not those of the structure, behind a mapping: to the coupling it is a fluid that
//! meets the structure's particles.
//!
//! The fluid names its own points, such as the wetted vertices of its mesh, where they are at the start
//! (`own_position`). Each window it takes their displacement since then at the window's start, and their
//! velocity over the window; it gives the force on each. Motion comes from the structure's particles by the
//! weights of a [mapping](crate::mapping) (`u_t = Σ W_ts u_s`); forces go to them by the transpose, as the
//! pressure gradients `∇p_s = −F_s/V_s`: force, moment and power are kept.

use super::shell::{Shell, Side};
use super::weights::Weights;
use crate::mapping::{Method, POINTS_PER_CLUSTER, Settings};
use crate::phase::Announce;
use interfaces::case::coupling::{FluidMapping, FluidMappingMethod};
use interfaces::port::names;
use interfaces::{
    Description, Direction, Exchange, Fields, Participant, ParticipantError, Port, Quantity, Result,
};

/// A fluid behind a mapping.
pub type MappedFluid<P> = Shell<P, Fluid>;

/// The fluid's side of a mapping, from the structure's particles to its own points.
pub struct Fluid {
    choice: FluidMapping,
    dimension: usize,
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
        let side = Fluid { choice, dimension: d, volumes: Vec::new() };
        Ok(Self::around(inner, description, side, announce))
    }
}

impl Fluid {
    fn method(&self) -> Method {
        match self.choice.method {
            FluidMappingMethod::NearestNeighbour => Method::NearestNeighbour,
            FluidMappingMethod::NearestNeighbourGradient => Method::NearestNeighbourGradient,
            FluidMappingMethod::RadialBasis => Method::RadialBasis { points_per_cluster: POINTS_PER_CLUSTER },
        }
    }
}

impl Side for Fluid {
    const BETWEEN: &'static str = "the structure's particles and the fluid's points";

    fn rebuilds(&self) -> bool {
        self.choice.rebuild
    }

    fn settings(&self, dimension: usize, _own: &Fields) -> Result<Settings> {
        Ok(Settings { dimension, reach: self.choice.reach, method: self.method() })
    }

    fn points(&mut self, given: &Fields, own: &Fields) -> Result<[Vec<f64>; 2]> {
        self.volumes = given.get(names::REFERENCE_VOLUME).unwrap_or(&[]).to_vec();
        if let Some(particle) = self.volumes.iter().position(|volume| *volume <= 0.0) {
            return Err(ParticipantError::failed(format!(
                "particle {particle} of the structure has the volume {}: a fluid behind a mapping needs positive ones",
                self.volumes[particle]
            )));
        }
        let targets = own.get(names::OWN_POSITION).unwrap_or(&[]).to_vec();
        Ok([Self::sources(given, own).to_vec(), targets])
    }

    fn sources<'f>(given: &'f Fields, _own: &'f Fields) -> &'f [f64] {
        given.get(names::POSITION).unwrap_or(&[])
    }

    /// The fluid's points' motion from that of the particles.
    fn take(
        &mut self,
        weights: &mut Weights,
        given: &Fields,
        own: &Fields,
        taken: &mut Fields,
    ) -> Result<()> {
        if let (Some(now), Some(displacement)) =
            (given.get(names::POSITION), taken.get_mut(names::DISPLACEMENT))
        {
            weights.displacement(now, displacement);
            // What they had moved before the weights were made.
            let start = own.get(names::OWN_POSITION).unwrap_or(&[]);
            for ((u, then), start) in displacement.iter_mut().zip(weights.targets_made_at()).zip(start) {
                *u += then - start;
            }
        }
        if let (Some(given), Some(taken)) = (given.get(names::VELOCITY), taken.get_mut(names::VELOCITY)) {
            weights.mapping().consistent(self.dimension, given, taken);
        }
        Ok(())
    }

    /// The particles' load from the forces on the fluid's points.
    fn give(&self, weights: &mut Weights, own: &Fields, given: &mut Fields) {
        if let (Some(force), Some(load)) = (own.get(names::FORCE), given.get_mut(names::PRESSURE_GRADIENT)) {
            weights.mapping().conservative(self.dimension, force, load);
            for (gradient, volume) in load.chunks_exact_mut(self.dimension).zip(&self.volumes) {
                gradient.iter_mut().for_each(|g| *g = -*g / volume);
            }
        }
    }
}
