//! Ports: the fields that a participant takes and gives.

use serde::{Deserialize, Serialize};
use std::fmt;

/// What a field is. The unit follows from it; all are SI.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Current position of an interface point.
    Position,
    /// Velocity of an interface point.
    Velocity,
    /// Pressure gradient at a structure particle: the fluid's load. The particle of reference volume `V`
    /// feels the force `−V ∇p`, its acceleration is `−∇p/ρ` (Eq. (48) of the paper).
    PressureGradient,
    /// Pressure at an interface point.
    Pressure,
    /// What the fluid received from a structure particle: force on the fluid divided by the particle's
    /// reference volume. Condition (46) asks that its normal part equal that of the pressure gradient.
    PairReaction,
    /// Unit normal out of the structure; zero for a particle without an exposed side.
    Normal,
    /// Volume of an interface particle in the reference configuration (two dimensions: for one metre of
    /// depth).
    ReferenceVolume,
    /// Density of an interface particle in the reference configuration, 0 for one that does not yield.
    Density,
    /// Displacement of an interface point since the start.
    Displacement,
    /// Force on an interface point that stands for no volume, such as the vertex of a boundary mesh.
    Force,
    /// Facet of a boundary mesh: the numbers of its vertices among the interface points, as many as there are
    /// dimensions.
    Facet,
}

impl Quantity {
    /// The SI unit, as it stands on the wire and in files.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Position | Self::Displacement => "m",
            Self::Velocity => "m/s",
            Self::PressureGradient | Self::PairReaction => "Pa/m",
            Self::Pressure => "Pa",
            Self::Normal => "1",
            Self::ReferenceVolume => "m3",
            Self::Density => "kg/m3",
            Self::Force => "N",
            Self::Facet => "1",
        }
    }

    /// Components of one value in `dimension` dimensions.
    pub fn components(self, dimension: usize) -> usize {
        match self {
            Self::Position
            | Self::Displacement
            | Self::Velocity
            | Self::PressureGradient
            | Self::PairReaction
            | Self::Normal
            | Self::Force
            | Self::Facet => dimension,
            Self::Pressure | Self::ReferenceVolume | Self::Density => 1,
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Position => "position",
            Self::Displacement => "displacement",
            Self::Velocity => "velocity",
            Self::PressureGradient => "pressure-gradient",
            Self::Pressure => "pressure",
            Self::PairReaction => "pair-reaction",
            Self::Normal => "normal",
            Self::ReferenceVolume => "reference-volume",
            Self::Density => "density",
            Self::Force => "force",
            Self::Facet => "facet",
        })
    }
}

/// Whether the participant takes the field or gives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// The participant takes it.
    In,
    /// The participant gives it.
    Out,
}

/// When a field is exchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Exchange {
    /// Once, at initialisation.
    Constant,
    /// At initialisation, and in every solution of a window.
    EveryWindow,
}

/// One field at the interface points of a participant. On the wire it is `points × components` doubles, point
/// by point.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Port {
    /// Name, unique in its participant and direction; fields are paired by it.
    pub name: String,
    /// What it is.
    pub quantity: Quantity,
    /// Its SI unit, compared in the handshake.
    pub unit: String,
    /// Doubles a point.
    pub components: usize,
    /// Number of interface points, or nothing where the participant takes as many as its partner has.
    pub points: Option<usize>,
    /// Taken or given.
    pub direction: Direction,
    /// Once or every window.
    pub exchange: Exchange,
    /// For a field taken: whether the participant cannot do without it. What is not required and not given
    /// stays zero.
    pub required: bool,
}

impl Port {
    /// A required port of the quantity's own unit and components, exchanged every window.
    pub fn new(
        name: &str,
        quantity: Quantity,
        dimension: usize,
        points: Option<usize>,
        direction: Direction,
    ) -> Self {
        Self {
            name: name.to_owned(),
            quantity,
            unit: quantity.unit().to_owned(),
            components: quantity.components(dimension),
            points,
            direction,
            exchange: Exchange::EveryWindow,
            required: true,
        }
    }

    /// The same port, exchanged once at initialisation.
    pub fn constant(self) -> Self {
        Self { exchange: Exchange::Constant, ..self }
    }

    /// The same port, not required.
    pub fn optional(self) -> Self {
        Self { required: false, ..self }
    }
}

/// Names of the ports that the meniscus solvers and their stand-ins use, and of the balances that records and
/// report look for. All are optional to give; see `docs/protocol.md` for which side needs which.
pub mod names {
    pub use words::balances::{
        CLAMP_WORK, CONTACT_ENERGY, DISSIPATED_ENERGY, ENERGIES, FRICTION_LOSS, KINETIC_ENERGY, LEFT_ENERGY,
        LOAD_WORK, PARTICLES_LEFT, PARTICLES_LOST, POTENTIAL_ENERGY, STRAIN_ENERGY, VOLUME_DRIFT, WALL_WORK,
    };

    /// Structure → fluid: position of the interface particles.
    pub const POSITION: &str = "position";
    /// Structure → fluid: velocity of the interface particles.
    pub const VELOCITY: &str = "velocity";
    /// Structure → fluid, once: reference volume of the interface particles.
    pub const REFERENCE_VOLUME: &str = "reference_volume";
    /// Structure → fluid, once: density of the interface particles, 0 for those that are held and do not
    /// yield.
    pub const DENSITY: &str = "density";
    /// Fluid → structure: pressure gradient at the interface particles.
    pub const PRESSURE_GRADIENT: &str = "pressure_gradient";
    /// Fluid → structure: pressure at the interface particles.
    pub const PRESSURE: &str = "pressure";
    /// Fluid → coupler: force received by the fluid, for condition (46).
    pub const PAIR_REACTION: &str = "pair_reaction";
    /// Fluid → coupler: normals of the interface particles, for condition (46).
    pub const NORMAL: &str = "normal";
    /// Coupler → fluid: the pressure gradient under which the structure was predicted.
    pub const HELD_PRESSURE_GRADIENT: &str = "held_pressure_gradient";
    /// Coupler → structure: the load at the window's start, from which it goes linearly to
    /// [`PRESSURE_GRADIENT`] at the end.
    pub const START_PRESSURE_GRADIENT: &str = "start_pressure_gradient";
    /// A fluid with points of its own → coupler, once: where they are at the start.
    pub const OWN_POSITION: &str = "own_position";
    /// Coupler → a fluid with points of its own: their displacement since then.
    pub const DISPLACEMENT: &str = "displacement";
    /// Coupler → a structure with points of its own: the force on each. A fluid with points of its own →
    /// coupler: the same of its points.
    pub const FORCE: &str = "force";
    /// Coupler → a structure with points of its own: the force on each at the window's start, from which it
    /// goes linearly to [`FORCE`].
    pub const START_FORCE: &str = "start_force";
    /// A structure with points of its own → coupler, once: the facets of its boundary.
    pub const FACETS: &str = "facets";
}
