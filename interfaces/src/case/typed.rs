//! The case file as users write it: what may be left out is an `Option` or has a default. The key names are
//! the fields' names, the JSON schema (descriptions included) is made of these types, and `super::conform`
//! holds the text against that schema.

use super::geometry::{AxisBox, Ball};
use super::region::{FluidVelocity, StandingWave};
use super::unit::{Parameters, Variables};
use super::velocity::InitialVelocity;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::Table;
use words::geometry::{Axis, Face, Side};
use words::probe::ProbeQuantity;

/// A table that another than this file describes.
type AnyTable = BTreeMap<String, serde_json::Value>;

/// A meniscus case. SI units throughout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CaseFile {
    /// What concerns the whole.
    pub case: General,
    /// The fluid; a case without it runs the structure alone.
    pub fluid: Option<Fluid>,
    /// The structure; a case without it runs the fluid alone.
    pub structure: Option<Structure>,
    /// The coupling of fluid and structure.
    #[schemars(with = "Option<AnyTable>")]
    pub coupling: Option<Table>,
    /// Quantities recorded at every window.
    #[serde(default)]
    pub probe: Vec<Probe>,
    /// Values from elsewhere, drawn beside probes in the report.
    #[serde(default)]
    pub reference: Vec<Reference>,
}

impl CaseFile {
    /// Makes the files that the case names absolute: they are sought from where `file`, the case file, is.
    pub(super) fn seek_files_from(&mut self, file: &Path) {
        let folder = file.parent().unwrap_or(Path::new(""));
        let participants = [
            self.fluid.as_mut().map(|fluid| &mut fluid.participant),
            self.structure.as_mut().map(|structure| &mut structure.participant),
        ];
        for unit in participants.into_iter().flatten().filter_map(|participant| participant.fmu.as_mut()) {
            let found = folder.join(&unit);
            *unit = std::path::absolute(&found).unwrap_or(found);
        }
    }
}

/// What concerns the whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct General {
    /// Title, one line.
    pub title: String,
    /// Space dimension, 2 or 3.
    #[schemars(extend("enum" = [2, 3]))]
    pub dimension: u32,
    /// Time at which the run ends (s); it starts at 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub end_time: f64,
    /// Time between snapshots (s); of a run that is shorter, its end time.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub output_interval: f64,
    /// Time between rows of the tables at least (s); 0, the default, is a row for every window. An output
    /// always has a row.
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub record_interval: f64,
    /// Acceleration of gravity on fluid and structure (m/s²); none if left out.
    pub gravity: Option<Vec<f64>>,
    /// Threads of each solver; 0, the default, is as many as the machine has, and more than four for each of
    /// its cores are not started.
    #[serde(default)]
    #[schemars(extend("maximum" = 4096))]
    pub threads: u32,
    /// Particle spacing Δx of both solvers (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub particle_spacing: f64,
}

/// The fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// Density (kg/m³).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density: f64,
    /// Kinematic viscosity (m²/s).
    #[schemars(extend("minimum" = 0))]
    pub kinematic_viscosity: f64,
    /// Particle spacing Δx (m); that of `[case]` if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub particle_spacing: Option<f64>,
    /// Largest time step (s); the output interval if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub max_time_step: Option<f64>,
    /// Speed that scales artificial viscosity, shifting and the first time step (m/s); √(g H) if left out, H
    /// the extent of all regions along gravity; without gravity the greatest speed at the start.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub characteristic_speed: Option<f64>,
    /// Where particles live: one that leaves this box has left the run.
    pub domain: AxisBox,
    /// Axes along which the domain repeats; none if left out.
    #[serde(default)]
    pub periodic: Vec<Axis>,
    /// Boxes and balls full of fluid at the start.
    #[serde(default)]
    pub region: Vec<Region>,
    /// Rigid walls.
    #[serde(default)]
    pub wall: Vec<Wall>,
    /// Numerics of its solver, which brings the keys.
    #[serde(default)]
    #[schemars(with = "AnyTable")]
    pub numerics: Table,
    /// Who solves the fluid; our own solver if left out.
    #[serde(default)]
    pub participant: Participant,
}

/// A box or a ball full of fluid at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Name.
    pub name: String,
    /// Its box.
    #[serde(rename = "box")]
    pub bounds: Option<AxisBox>,
    /// Its ball; in two dimensions a disc.
    pub ball: Option<Ball>,
    /// Velocity at the start: a vector (m/s) or a shape; at rest if left out.
    pub velocity: Option<FluidVelocity>,
    /// Gradient of the velocity at the start (1/s), row by row: G·r is added to the velocity, r from the
    /// region's centre.
    pub velocity_gradient: Option<Vec<Vec<f64>>>,
    /// A standing wave at rest at its greatest height, on the box's upper face; two dimensions only.
    pub wave: Option<StandingWave>,
    /// Random displacement of its particles from the lattice, at most this times Δx along each axis.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "maximum" = 0.5))]
    pub jitter: f64,
    /// Seed of the random displacement.
    #[serde(default)]
    pub seed: u32,
}

/// A rigid wall: a solid box, or the border of a solid as a polyline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Name.
    pub name: String,
    /// A solid box.
    #[serde(rename = "box")]
    pub bounds: Option<AxisBox>,
    /// Points of a polyline (m); two dimensions only.
    pub polyline: Option<Vec<Vec<f64>>>,
    /// On which side of the polyline the solid is, walking from its first point to its last.
    pub solid_side: Option<Side>,
    /// Tangential velocity at the wall; free-slip if left out.
    pub slip: Option<Slip>,
    /// Velocity of its surface (m/s) along itself: a belt, a lid. At rest if left out.
    pub velocity: Option<Vec<f64>>,
    /// How the wall moves: a gate that lifts, a tank that rolls. It stays in its place if left out.
    pub motion: Option<WallMotion>,
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

/// A number over time, from a `table` or a sine (`amplitude`, `period`), times a `direction` (m) or about a
/// `pivot` (rad).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallMotion {
    /// Direction along which the wall moves; its length does not count.
    pub direction: Option<Vec<f64>>,
    /// Point about which the wall turns from x to y (m); in three dimensions about the line through it along
    /// z.
    pub pivot: Option<Vec<f64>>,
    /// Pairs of time (s) and distance (m) or angle (rad), a smooth curve between; at rest before and after.
    pub table: Option<Vec<[f64; 2]>>,
    /// Amplitude of a sine (m or rad).
    pub amplitude: Option<f64>,
    /// Period of the sine (s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub period: Option<f64>,
    /// Phase of the sine (rad): amplitude · (sin(2πt/period + phase) − sin(phase)); 0 if left out.
    pub phase: Option<f64>,
}

/// Who solves a side: `start`, `command` or `fmu`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Participant {
    /// Our own solver, or one that somebody starts by hand.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<StartWord>,
    /// A command that the coupler starts: the program and its arguments.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<Vec<String>>,
    /// A functional mock-up unit (FMI 2.0 or 3.0): its file, sought from where the case file is. A process
    /// that the coupler starts serves it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fmu: Option<PathBuf>,
    /// Variables behind the ports of an FMU, and numbers that it tells.
    #[serde(default, skip_serializing_if = "Variables::is_empty")]
    pub variables: Variables,
    /// Parameters of an FMU and their values, by name: `{ youngs_modulus = 1e6, nodes = 40 }`; its own if
    /// left out.
    #[serde(default, skip_serializing_if = "Parameters::is_empty")]
    pub parameters: Parameters,
    /// Variables of an FMU that are recorded besides its energies and the case's probes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub record: Vec<String>,
}

/// Who starts a participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StartWord {
    /// The coupler starts our own solver.
    Own,
    /// Somebody starts it by hand.
    ByHand,
}

/// The structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Structure {
    /// Particle spacing Δx (m); that of `[case]` if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub particle_spacing: Option<f64>,
    /// Material of all bodies; the solver brings the keys.
    #[schemars(with = "AnyTable")]
    pub material: Table,
    /// Bodies.
    #[serde(default)]
    pub body: Vec<Body>,
    /// What is held fast.
    #[serde(default)]
    pub clamp: Vec<Clamp>,
    /// Dead loads.
    #[serde(default)]
    pub load: Vec<Load>,
    /// Numerics of its solver, which brings the keys.
    #[serde(default)]
    #[schemars(with = "AnyTable")]
    pub numerics: Table,
    /// Who solves the structure; our own solver if left out.
    #[serde(default)]
    pub participant: Participant,
}

/// A box of solid in the reference configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Name.
    pub name: String,
    /// Its box.
    #[serde(rename = "box")]
    pub bounds: AxisBox,
    /// Velocity at the start: a vector (m/s) or a shape; at rest if left out.
    pub velocity: Option<InitialVelocity>,
    /// Angle of the lattice of its particles to the axes (rad), counter-clockwise; two dimensions only.
    #[serde(default)]
    pub lattice_angle: f64,
    /// Random displacement of its particles from the lattice, at most this times Δx along each axis; two
    /// dimensions only.
    #[serde(default)]
    #[schemars(extend("minimum" = 0, "maximum" = 0.5))]
    pub jitter: f64,
    /// Seed of the random displacement.
    #[serde(default)]
    pub seed: u32,
    /// Times that the particles move to the centroids of their Voronoi cells; if left out, 10 where they are
    /// no lattice along the axes.
    #[schemars(extend("maximum" = 100))]
    pub relaxation: Option<u32>,
}

impl Body {
    /// Whether its particles are no lattice along the axes: each has its own cell then.
    pub fn is_off_lattice(&self, clamps: &[Clamp]) -> bool {
        let is_cut = clamps.iter().any(|clamp| clamp.body == self.name && clamp.circle.is_some());
        self.lattice_angle != 0.0 || self.jitter != 0.0 || is_cut || self.relaxation.is_some_and(|n| n > 0)
    }
}

/// What is held fast: a `face`, beyond which the body goes on by fixed rows, the body's particles in a `box`,
/// or the arc of a `circle` that cuts it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Clamp {
    /// Name.
    pub name: String,
    /// Body that it holds.
    pub body: String,
    /// Face beyond which the body goes on by fixed rows.
    pub face: Option<Face>,
    /// Fixed rows beyond the face; they may lie in a wall, but not in fluid. 0 are fixed points on the face
    /// itself. If left out 0 with the quadratic gradient, 3 with the first-order one.
    #[schemars(extend("minimum" = 0))]
    pub rows: Option<u32>,
    /// Box in which the body's particles are fixed.
    #[serde(rename = "box")]
    pub bounds: Option<AxisBox>,
    /// Ball on whose arc the body ends, held there by fixed points: what of the body is inside is left out;
    /// quadratic gradient, two dimensions only.
    pub circle: Option<Ball>,
}

/// A force that keeps its direction (a dead load): on a `face`, at a point (`at`), or, with neither, in the
/// whole body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// Name.
    pub name: String,
    /// Body on which it acts.
    pub body: String,
    /// Face on which it acts evenly.
    pub face: Option<Face>,
    /// Point of the reference configuration at which it acts (m).
    pub at: Option<Vec<f64>>,
    /// Total force (N; in two dimensions N per metre of depth).
    pub force: Vec<f64>,
    /// Pairs of time (s) and factor of the force, linear between; the full force from the start if left out.
    pub ramp: Option<Vec<[f64; 2]>>,
}

/// A quantity recorded at every window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Name; the columns of `probes.csv` are `<name>.<component>`.
    pub name: String,
    /// What it looks at.
    pub on: ProbeSide,
    /// What it records.
    pub quantity: ProbeQuantity,
    /// The point (m), on the structure in the reference configuration; none for a force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<Vec<f64>>,
    /// Box in which the fluid's extent, centroid or spread is taken; all of the fluid if left out.
    #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
    pub bounds: Option<AxisBox>,
    /// The body, where the structure has more than one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// The wall, where the fluid has more than one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall: Option<String>,
}

/// What a probe looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ProbeSide {
    /// The structure: displacement, position and velocity at a point; force of the fluid on a body.
    Structure,
    /// The fluid: pressure and velocity at a point; extent, centroid and spread of the fluid in a box.
    Fluid,
    /// A wall: pressure at a point; force of the fluid on the wall.
    Wall,
}

/// Values from elsewhere for one column of a probe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// The column: `<probe>.<component>`.
    pub probe: String,
    /// What the report's legend says.
    pub label: String,
    /// Where it is from.
    pub source: String,
    /// Times (s), growing.
    pub time: Vec<f64>,
    /// Values at the times, in the probe's SI unit.
    pub value: Vec<f64>,
    /// Lower border of the values; the values themselves if left out.
    pub low: Option<Vec<f64>>,
    /// Upper border of the values; the values themselves if left out.
    pub high: Option<Vec<f64>>,
}
