//! The case as resolved: checked, every default filled in, nothing optional left. Plain data; the solvers
//! make particles of it.

use super::coupling::Coupling;
use super::geometry::{AxisBox, Ball};
use super::region::Region;
use super::typed::{self, Slip};
use super::unit::{Parameters, Variables};
use super::velocity::InitialVelocity;
use crate::participant::{Role, Scalar, ScalarKind};
use serde::Serialize;
use std::path::PathBuf;
use toml::Table;
use words::geometry::{Axis, Face, Side};
use words::motion::Law;
use words::probe::ProbeQuantity;

/// A checked case. SI units; vectors have as many numbers as `general.dimension`; in two dimensions volumes
/// and forces are for one metre of depth. It is read by [`Case::load`] or [`Case::parse`], and written by
/// [`Case::to_toml`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// What concerns the whole: `[case]`.
    #[serde(rename = "case")]
    pub general: General,
    /// The fluid, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluid: Option<Fluid>,
    /// The structure, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub structure: Option<Structure>,
    /// The coupling: there exactly where fluid and structure both are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coupling: Option<Coupling>,
    /// Probes.
    #[serde(rename = "probe")]
    pub probes: Vec<Probe>,
    /// Values from elsewhere that the report draws beside probes.
    #[serde(rename = "reference")]
    pub references: Vec<Reference>,
}

impl Case {
    /// Who solves a side, where there is one.
    pub fn start(&self, role: Role) -> Option<&Start> {
        match role {
            Role::Fluid => self.fluid.as_ref().map(|fluid| &fluid.participant),
            Role::Structure => self.structure.as_ref().map(|structure| &structure.participant),
        }
    }
}

/// `[case]`: what concerns the whole.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct General {
    /// Title, one line.
    pub title: String,
    /// Space dimension, 2 or 3.
    pub dimension: usize,
    /// Time at which the run ends (s); it starts at 0.
    pub end_time: f64,
    /// Time between snapshots (s).
    pub output_interval: f64,
    /// Time between rows of the tables at least (s); 0 is a row for every window.
    #[serde(default)]
    pub record_interval: f64,
    /// Acceleration of gravity on fluid and structure (m/s²).
    pub gravity: Vec<f64>,
    /// Threads of each solver; 0 is as many as the machine has. No result depends on it.
    pub threads: usize,
    /// Particle spacing Δx of both solvers where they do not set their own (m).
    pub particle_spacing: f64,
}

/// `[fluid]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fluid {
    /// Density (kg/m³).
    pub density: f64,
    /// Kinematic viscosity (m²/s).
    pub kinematic_viscosity: f64,
    /// Particle spacing Δx (m).
    pub particle_spacing: f64,
    /// Largest time step (s).
    pub max_time_step: f64,
    /// Speed that scales artificial viscosity, shifting and the first time step (m/s); by default √(g H), H
    /// the fluid's height along gravity. Zero where another solver needs none.
    #[serde(skip_serializing_if = "is_zero")]
    pub characteristic_speed: f64,
    /// Where particles live: one that leaves this box has left the run.
    pub domain: AxisBox,
    /// Axes along which the domain repeats.
    pub periodic: Vec<Axis>,
    /// Water at the start.
    #[serde(rename = "region")]
    pub regions: Vec<Region>,
    /// Rigid walls.
    #[serde(rename = "wall")]
    pub walls: Vec<Wall>,
    /// Numerics of its solver, as that wants them.
    pub numerics: Table,
    /// Who solves it.
    pub participant: Start,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

/// `[[fluid.wall]]`: a rigid wall.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Wall {
    /// Name.
    pub name: String,
    /// Its shape.
    #[serde(flatten)]
    pub shape: WallShape,
    /// What the fluid's tangential velocity does at it.
    pub slip: Slip,
    /// Velocity of its surface (m/s) along itself: a belt, a lid.
    pub velocity: Vec<f64>,
    /// How the wall moves, if it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<WallMotion>,
}

/// How a wall moves: a number over time along a direction or about a pivot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WallMotion {
    /// Where it leads.
    #[serde(flatten)]
    pub path: MotionPath,
    /// The number over time: m or rad.
    #[serde(flatten)]
    pub law: Law,
}

/// Where a motion leads.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum MotionPath {
    /// Along a line.
    Along {
        /// Direction, of any length.
        direction: Vec<f64>,
    },
    /// About a point, in three dimensions the line through it along z.
    About {
        /// The point (m).
        pivot: Vec<f64>,
    },
}

/// Shape of a wall.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum WallShape {
    /// A solid box.
    Box {
        /// The box.
        #[serde(rename = "box")]
        bounds: AxisBox,
    },
    /// The border of a solid, as a line through points; two dimensions only.
    Polyline {
        /// At least two points (m).
        #[serde(rename = "polyline")]
        points: Vec<Vec<f64>>,
        /// Where the solid is.
        solid_side: Side,
    },
}

/// `[structure]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Structure {
    /// Particle spacing Δx (m).
    pub particle_spacing: f64,
    /// Material of all bodies, as the solver wants it.
    pub material: Table,
    /// Bodies.
    #[serde(rename = "body")]
    pub bodies: Vec<Body>,
    /// What is held fast.
    #[serde(rename = "clamp")]
    pub clamps: Vec<Clamp>,
    /// Dead loads.
    #[serde(rename = "load")]
    pub loads: Vec<Load>,
    /// Numerics of its solver, as that wants them.
    pub numerics: Table,
    /// Who solves it.
    pub participant: Start,
}

impl Structure {
    /// Density of the material (kg/m³), which the fluid meets too; NaN where the material names none.
    pub fn density(&self) -> f64 {
        let density = self.material.get("density");
        density.and_then(|d| d.as_float().or(d.as_integer().map(|d| d as f64))).unwrap_or(f64::NAN)
    }
}

/// `[[structure.body]]`: a box of solid in the reference configuration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Body {
    /// Name.
    pub name: String,
    /// Its box.
    #[serde(rename = "box")]
    pub bounds: AxisBox,
    /// Velocity at the start.
    pub velocity: InitialVelocity,
    /// Angle of the lattice of its particles to the axes (rad), counter-clockwise.
    pub lattice_angle: f64,
    /// Random displacement of its particles from the lattice, at most this times Δx along each axis.
    pub jitter: f64,
    /// Seed of the random displacement.
    pub seed: u32,
    /// Times that the particles move to the centroids of their Voronoi cells.
    pub relaxation: u32,
}

/// `[[structure.clamp]]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Clamp {
    /// Name.
    pub name: String,
    /// Body that it holds.
    pub body: String,
    /// What is held.
    #[serde(flatten)]
    pub region: ClampRegion,
}

/// What a clamp holds.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ClampRegion {
    /// The body goes on beyond the face by rows of fixed particles, at the body's own lattice distance;
    /// without rows, points of the face itself are fixed.
    Face {
        /// The face.
        face: Face,
        /// Rows.
        rows: usize,
    },
    /// The body's particles in this box are fixed.
    Box {
        /// The box.
        #[serde(rename = "box")]
        bounds: AxisBox,
    },
    /// The body ends on the circle's arc, and points of the arc are fixed.
    Circle {
        /// The circle.
        circle: Ball,
    },
}

/// `[[structure.load]]`: a force that keeps its direction (a dead load).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Load {
    /// Name.
    pub name: String,
    /// Body on which it acts.
    pub body: String,
    /// Where it acts.
    #[serde(flatten)]
    pub target: LoadTarget,
    /// Total force (N; in two dimensions N per metre of depth).
    pub force: Vec<f64>,
    /// Pairs of time (s) and factor of the force: linear between them, constant before the first and after
    /// the last.
    pub ramp: Vec<[f64; 2]>,
}

/// Where a load acts.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum LoadTarget {
    /// Evenly on a face.
    Face {
        /// The face.
        face: Face,
    },
    /// At a point of the reference configuration.
    Point {
        /// The point (m).
        at: Vec<f64>,
    },
    /// Evenly in the whole body.
    Body {},
}

/// Who solves a side.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(into = "typed::Participant")]
pub enum Start {
    /// Our own solver, started by the coupler.
    Own,
    /// Another command, started by the coupler: the program and its arguments.
    Command(Vec<String>),
    /// A functional mock-up unit, in a process started by the coupler.
    Fmu(Box<Unit>),
    /// A process that somebody starts by hand.
    ByHand,
}

/// A functional mock-up unit (FMU) that solves a side.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// Its file.
    pub file: PathBuf,
    /// Variables behind its ports, as far as they have other names.
    pub variables: Variables,
    /// Parameters to set before it is initialised.
    pub parameters: Parameters,
    /// Variables to record besides its energies and the case's probes.
    pub record: Vec<String>,
}

/// `[[probe]]`: a quantity recorded at every window.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(into = "typed::Probe")]
pub struct Probe {
    /// Name; the columns are `<name>.<component>`.
    pub name: String,
    /// Where it looks.
    pub target: ProbeTarget,
    /// What it records.
    pub quantity: ProbeQuantity,
}

/// Where a probe looks. Which quantities it may record stands beside each.
#[derive(Clone, Debug, PartialEq)]
pub enum ProbeTarget {
    /// A point of a body's reference configuration (m): displacement, position, velocity.
    StructurePoint {
        /// The body.
        body: String,
        /// The point (m).
        at: Vec<f64>,
    },
    /// A whole body: the force of the fluid on it.
    Body(String),
    /// A point of space in the fluid (m): pressure, velocity.
    FluidPoint(Vec<f64>),
    /// The fluid in a box, or all of it: extent, centroid, spread.
    FluidBox(Option<AxisBox>),
    /// A point on a wall (m): pressure.
    WallPoint {
        /// The wall.
        wall: String,
        /// The point (m).
        at: Vec<f64>,
    },
    /// A whole wall: the force of the fluid on it.
    Wall(String),
}

impl Probe {
    /// Its columns in `probes.csv`: `<name>.<component>`.
    pub fn columns(&self, dimension: usize) -> Vec<String> {
        self.quantity
            .components(dimension)
            .iter()
            .map(|component| format!("{}.{component}", self.name))
            .collect()
    }

    /// The scalars that the participant which records it describes, one a column.
    pub fn scalars(&self, dimension: usize) -> impl Iterator<Item = Scalar> {
        let (unit, meaning) = (self.quantity.unit(), self.meaning());
        let scalar = move |name| Scalar::new(name, unit, ScalarKind::Probe).meaning(meaning.clone());
        self.columns(dimension).into_iter().map(scalar)
    }

    /// What it records, in words.
    fn meaning(&self) -> String {
        let quantity = self.quantity;
        match &self.target {
            ProbeTarget::StructurePoint { body, at } => format!("{quantity} of {body} at {at:?} m"),
            ProbeTarget::Body(body) => format!("{quantity} of the fluid on {body}"),
            ProbeTarget::FluidPoint(at) => format!("{quantity} of the fluid at {at:?} m"),
            ProbeTarget::FluidBox(None) => format!("{quantity} of the fluid"),
            ProbeTarget::FluidBox(Some(within)) => {
                format!("{quantity} of the fluid between {:?} and {:?} m", within.low, within.high)
            }
            ProbeTarget::WallPoint { wall, at } => format!("{quantity} on {wall} at {at:?} m"),
            ProbeTarget::Wall(wall) => format!("{quantity} of the fluid on {wall}"),
        }
    }

    /// Whether the structure records it (otherwise the fluid does).
    pub fn is_on_structure(&self) -> bool {
        matches!(self.target, ProbeTarget::StructurePoint { .. } | ProbeTarget::Body(_))
    }
}

/// `[[reference]]`: values from elsewhere for one column of a probe.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reference {
    /// The column: `<probe>.<component>`.
    pub probe: String,
    /// What the report's legend says.
    pub label: String,
    /// Where it is from.
    pub source: String,
    /// Times (s), growing.
    pub time: Vec<f64>,
    /// Values at the times, in the probe's unit.
    pub value: Vec<f64>,
    /// Lower border of the values; the values themselves where the source gives none.
    pub low: Vec<f64>,
    /// Upper border of the values.
    pub high: Vec<f64>,
}

impl From<Start> for typed::Participant {
    fn from(start: Start) -> Self {
        match start {
            Start::Own => Self { start: Some(typed::StartWord::Own), ..Self::default() },
            Start::ByHand => Self { start: Some(typed::StartWord::ByHand), ..Self::default() },
            Start::Command(command) => Self { command: Some(command), ..Self::default() },
            Start::Fmu(unit) => {
                let Unit { file, variables, parameters, record } = *unit;
                Self { fmu: Some(file), variables, parameters, record, ..Self::default() }
            }
        }
    }
}

impl From<Probe> for typed::Probe {
    fn from(probe: Probe) -> Self {
        let empty = Self {
            name: probe.name,
            on: typed::ProbeSide::Fluid,
            quantity: probe.quantity,
            at: None,
            bounds: None,
            body: None,
            wall: None,
        };
        let (structure, wall_side) = (typed::ProbeSide::Structure, typed::ProbeSide::Wall);
        match probe.target {
            ProbeTarget::StructurePoint { body, at } => {
                Self { on: structure, at: Some(at), body: Some(body), ..empty }
            }
            ProbeTarget::Body(body) => Self { on: structure, body: Some(body), ..empty },
            ProbeTarget::FluidPoint(at) => Self { at: Some(at), ..empty },
            ProbeTarget::FluidBox(bounds) => Self { bounds, ..empty },
            ProbeTarget::WallPoint { wall, at } => {
                Self { on: wall_side, at: Some(at), wall: Some(wall), ..empty }
            }
            ProbeTarget::Wall(wall) => Self { on: wall_side, wall: Some(wall), ..empty },
        }
    }
}
