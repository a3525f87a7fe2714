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
mod shell;
mod weights;

use crate::mapping::{Method, POINTS_PER_CLUSTER, Settings};
use crate::phase::Announce;
use interfaces::case::Case;
use interfaces::case::coupling::{self, MappingMethod};
use interfaces::port::names;
use interfaces::{Description, Direction, Fields, Participant, ParticipantError, Port, Quantity, Result};
use shell::{Shell, Side, failed};
use weights::Weights;

/// Particles that fill the bodies of a case.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filling {
    /// Positions in the reference configuration (m), flat.
    pub positions: Vec<f64>,
    /// Volumes (m³).
    pub volumes: Vec<f64>,
    /// Densities (kg/m³).
    pub densities: Vec<f64>,
}

impl Filling {
    /// On lattices of about `spacing` (m) in the bodies' boxes.
    pub fn of(case: &Case, spacing: f64) -> Self {
        let mut filling = Self::default();
        let Some(structure) = &case.structure else { return filling };
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
                filling.densities.push(structure.density_of(body));
            }
        }
        filling
    }
}

/// A structure behind a mapping.
pub type Mapped<P> = Shell<P, Structure>;

/// The structure's side of a mapping, from its points to the particles in its bodies.
pub struct Structure {
    choice: coupling::Mapping,
    filling: Filling,
    dimension: usize,
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
        let side = Structure { choice, filling, dimension: d, forces: Vec::new() };
        Ok(Self::around(inner, description, side, announce))
    }
}

impl Structure {
    fn method(&self, own: &Fields) -> Result<Method> {
        Ok(match self.choice.method {
            MappingMethod::NearestNeighbour => Method::NearestNeighbour,
            MappingMethod::NearestNeighbourGradient => Method::NearestNeighbourGradient,
            MappingMethod::RadialBasis => Method::RadialBasis { points_per_cluster: POINTS_PER_CLUSTER },
            MappingMethod::NearestProjection => {
                let facets = own.get(names::FACETS).ok_or_else(|| {
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
}

impl Side for Structure {
    const BETWEEN: &'static str = "the structure's points and those in its bodies";

    fn rebuilds(&self) -> bool {
        self.choice.rebuild
    }

    fn settings(&self, dimension: usize, own: &Fields) -> Result<Settings> {
        Ok(Settings { dimension, reach: self.choice.reach, method: self.method(own)? })
    }

    fn points(&mut self, given: &Fields, own: &Fields) -> Result<[Vec<f64>; 2]> {
        Ok([Self::sources(given, own).to_vec(), self.filling.positions.clone()])
    }

    fn sources<'f>(_given: &'f Fields, own: &'f Fields) -> &'f [f64] {
        own.get(names::POSITION).unwrap_or(&[])
    }

    /// The structure's loads from those on the particles.
    fn take(
        &mut self,
        weights: &mut Weights,
        given: &Fields,
        own: &Fields,
        taken: &mut Fields,
    ) -> Result<()> {
        let Self { filling, forces, dimension: d, .. } = self;
        for (name, force_name) in LOADS {
            let Some(load) = given.get(name) else { continue };
            if let Some(force) = taken.get_mut(force_name) {
                forces.resize(load.len(), 0.0);
                let each = forces.chunks_exact_mut(*d).zip(load.chunks_exact(*d)).zip(&filling.volumes);
                for ((force, gradient), volume) in each {
                    for (f, g) in force.iter_mut().zip(gradient) {
                        *f = -volume * g;
                    }
                }
                weights.mapping().conservative(*d, forces, force);
            } else if let Some(gradient) = taken.get_mut(name) {
                let volumes = own.get(names::REFERENCE_VOLUME).unwrap_or(&[]);
                weights
                    .mapping()
                    .conservative_per_volume(*d, &filling.volumes, load, volumes, gradient)
                    .map_err(failed::<Self>)?;
            }
        }
        Ok(())
    }

    /// The particles' motion from that of the structure.
    fn give(&self, weights: &mut Weights, own: &Fields, given: &mut Fields) {
        if let (Some(own), Some(field)) = (own.get(names::POSITION), given.get_mut(names::POSITION)) {
            weights.position(own, field);
        }
        if let (Some(own), Some(field)) = (own.get(names::VELOCITY), given.get_mut(names::VELOCITY)) {
            weights.mapping().consistent(self.dimension, own, field);
        }
    }

    fn constants(&self, given: &mut Fields) {
        if let Some(field) = given.get_mut(names::REFERENCE_VOLUME) {
            field.copy_from_slice(&self.filling.volumes);
        }
        if let Some(field) = given.get_mut(names::DENSITY) {
            field.copy_from_slice(&self.filling.densities);
        }
    }
}
