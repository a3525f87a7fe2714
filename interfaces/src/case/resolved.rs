//! The case as resolved: checked, every default filled in, nothing optional left. Plain data; the solvers
//! make particles of it.

use super::coupling::Coupling;
use super::geometry::{Axis, AxisBox, Ball, Face, Side};
use super::numerics::{FluidNumerics, StructureNumerics};
pub use super::region::{FluidVelocity, Region, RegionShape};
use super::typed;
use super::unit::{Parameters, Variables};
use crate::{Scalar, ScalarKind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::PathBuf;

/// A checked case. SI units; vectors have as many numbers as `general.dimension`; in two dimensions volumes
/// and forces are for one metre of depth. It is read by [`Case::load`] or [`Case::parse`], and written by
/// [`Case::to_toml`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "typed::CaseFile")]
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
    /// Numerics of the ISPH solver.
    pub numerics: FluidNumerics,
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
    pub law: MotionLaw,
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

/// A number over time.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum MotionLaw {
    /// A smooth curve through pairs of time (s) and value, at rest before and after.
    Table {
        /// The pairs.
        table: Vec<[f64; 2]>,
    },
    /// `amplitude · (sin(2πt/period + phase) − sin(phase))`.
    Sine {
        /// Amplitude.
        amplitude: f64,
        /// Period (s).
        period: f64,
        /// Phase (rad).
        phase: f64,
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

/// Tangential velocity at a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Slip {
    /// No shear stress.
    FreeSlip,
    /// The wall's own velocity.
    NoSlip,
}

/// `[structure]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Structure {
    /// Particle spacing Δx (m).
    pub particle_spacing: f64,
    /// Material of all bodies.
    pub material: Material,
    /// Bodies.
    #[serde(rename = "body")]
    pub bodies: Vec<Body>,
    /// What is held fast.
    #[serde(rename = "clamp")]
    pub clamps: Vec<Clamp>,
    /// Dead loads.
    #[serde(rename = "load")]
    pub loads: Vec<Load>,
    /// Numerics of the TLSPH solver.
    pub numerics: StructureNumerics,
    /// Who solves it.
    pub participant: Start,
}

/// `[structure.material]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Material {
    /// Stress–strain law.
    pub law: MaterialLaw,
    /// Young's modulus E (Pa).
    pub youngs_modulus: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Density in the reference configuration (kg/m³).
    pub density: f64,
    /// Plane strain, plane stress, or neither.
    pub assumption: Assumption,
}

/// Stress–strain law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MaterialLaw {
    /// Cauchy stress linear in the Almansi strain: the paper's Eqs. (38)–(41).
    AlmansiHooke,
    /// Second Piola–Kirchhoff stress linear in the Green–Lagrange strain.
    SaintVenantKirchhoff,
    /// Compressible neo-Hookean solid.
    NeoHookean,
}

/// How two dimensions stand for three.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Assumption {
    /// No strain across the plane.
    PlaneStrain,
    /// No stress across the plane.
    PlaneStress,
    /// Three dimensions: no assumption.
    ThreeDimensional,
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

/// Velocity of a body at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum InitialVelocity {
    /// The same everywhere (m/s).
    Uniform(Vec<f64>),
    /// A shape.
    Mode(CantileverVelocity),
}

/// First bending mode of a clamped beam, Eqs. (51)–(52) of the paper: `v(s) = tip_velocity · f(s)/f(L)`, with
/// s the distance from the clamped face, L the body's length across it, kL = 1.875 and
/// `f(s) = (cos kL + cosh kL)(cosh ks − cos ks) + (sin kL − sinh kL)(sinh ks − sin ks)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CantileverVelocity {
    /// Which shape; `cantilever` is the one there is.
    pub mode: VelocityMode,
    /// Face from which s counts.
    pub clamped_face: Face,
    /// Velocity at the opposite face (m/s).
    pub tip_velocity: Vec<f64>,
}

/// Shape of an initial velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityMode {
    /// First bending mode of a clamped beam.
    Cantilever,
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

/// What a probe records.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ProbeQuantity {
    /// Displacement (m): `ux`, `uy`, `uz`.
    Displacement,
    /// Position (m): `x`, `y`, `z`.
    Position,
    /// Velocity (m/s): `vx`, `vy`, `vz`.
    Velocity,
    /// Pressure (Pa): `p`.
    Pressure,
    /// Total force of the fluid (N; in two dimensions N per metre of depth): `fx`, `fy`, `fz`.
    Force,
    /// Outermost fluid (m), half a spacing beyond its particle's centre, particles that fly alone left out:
    /// `left`, `right`, `bottom`, `top`, `back`, `front`. A box without fluid has its faces exchanged.
    Extent,
    /// Centroid (m): `x`, `y`, `z`; zero without fluid.
    Centroid,
    /// Standard deviation of position along each axis (m), half the semi-axis of an ellipse: `sx`, `sy`,
    /// `sz`.
    Spread,
    /// Departure of the pressure from ρ g·(r − r₀), r₀ a point of the level surface, over the greatest of it
    /// (1): of all fluid deeper than one spacing, `max`, the largest magnitude, and `rms`.
    HydrostaticError,
}

impl ProbeQuantity {
    /// Names of its components in `dimension` dimensions.
    pub fn components(self, dimension: usize) -> &'static [&'static str] {
        match self {
            Self::Displacement => &["ux", "uy", "uz"][..dimension],
            Self::Position => &["x", "y", "z"][..dimension],
            Self::Velocity => &["vx", "vy", "vz"][..dimension],
            Self::Pressure => &["p"],
            Self::Force => &["fx", "fy", "fz"][..dimension],
            Self::Extent => &["left", "right", "bottom", "top", "back", "front"][..2 * dimension],
            Self::Centroid => &["x", "y", "z"][..dimension],
            Self::Spread => &["sx", "sy", "sz"][..dimension],
            Self::HydrostaticError => &["max", "rms"],
        }
    }

    /// Whether it is of the fluid in a box, and of no point.
    pub fn is_of_a_box(self) -> bool {
        matches!(self, Self::Extent | Self::Centroid | Self::Spread)
    }

    /// Its SI unit, in two dimensions that of one metre of depth.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Displacement | Self::Position | Self::Extent | Self::Centroid | Self::Spread => "m",
            Self::Velocity => "m/s",
            Self::Pressure => "Pa",
            Self::Force => "N",
            Self::HydrostaticError => "1",
        }
    }
}

impl fmt::Display for ProbeQuantity {
    /// As the case file writes it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Displacement => "displacement",
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Pressure => "pressure",
            Self::Force => "force",
            Self::Extent => "extent",
            Self::Centroid => "centroid",
            Self::Spread => "spread",
            Self::HydrostaticError => "hydrostatic-error",
        })
    }
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
        let unit = self.quantity.unit();
        let scalar = move |name| Scalar { name, unit: unit.to_owned(), kind: ScalarKind::Probe };
        self.columns(dimension).into_iter().map(scalar)
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
