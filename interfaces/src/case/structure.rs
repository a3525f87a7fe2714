//! `[structure]`: its keys.

use super::geometry::{AxisBox, Ball, PerAxis};
use super::motion::{Motion, Moving};
use super::participant::Participant;
use super::section::AnyTable;
use super::velocity::InitialVelocity;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Table;
use words::geometry::Face;

/// The structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Structure {
    /// Particle spacing Δx (m); that of `[case]` if left out.
    #[schemars(with = "Option<f64>", extend("exclusiveMinimum" = 0))]
    pub particle_spacing: f64,
    /// Material of the bodies that name none of their own; the solver brings the keys.
    #[schemars(with = "AnyTable")]
    pub material: Table,
    /// Bodies.
    #[serde(default, rename = "body")]
    pub bodies: Vec<Body>,
    /// What is held fast.
    #[serde(default, rename = "clamp")]
    pub clamps: Vec<Clamp>,
    /// Dead loads.
    #[serde(default, rename = "load")]
    pub loads: Vec<Load>,
    /// Contact with walls, of bodies with each other and with themselves; the solver brings the keys.
    #[serde(default)]
    #[schemars(with = "AnyTable")]
    pub contact: Table,
    /// Numerics of its solver, which brings the keys.
    #[serde(default)]
    #[schemars(with = "AnyTable")]
    pub numerics: Table,
    /// Who solves the structure; our own solver if left out.
    #[serde(default)]
    pub participant: Participant,
}

impl Structure {
    /// Density of a body (kg/m³), which the fluid meets too; NaN where no material of it names one.
    pub fn density_of(&self, body: &Body) -> f64 {
        let density = body.material.get("density").or_else(|| self.material.get("density"));
        density.and_then(|d| d.as_float().or(d.as_integer().map(|d| d as f64))).unwrap_or(f64::NAN)
    }

    /// Density of the lightest body (kg/m³); NaN where no body has one.
    pub fn least_density(&self) -> f64 {
        self.bodies.iter().map(|body| self.density_of(body)).fold(f64::NAN, f64::min)
    }
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
    #[schemars(with = "Option<InitialVelocity>")]
    pub velocity: InitialVelocity,
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
    #[schemars(with = "Option<u32>", extend("maximum" = 100))]
    pub relaxation: u32,
    /// Its own material, laid over `structure.material`: what is left out is as there. A body that names a
    /// law gives that law's constants itself. The solver brings the keys.
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    #[schemars(with = "AnyTable")]
    pub material: Table,
}

impl Body {
    /// Whether its particles are no lattice along the axes: each has its own cell then.
    pub fn is_off_lattice(&self, clamps: &[Clamp]) -> bool {
        let is_cut = clamps.iter().any(|clamp| clamp.body == self.name && clamp.circle.is_some());
        self.lattice_angle != 0.0 || self.jitter != 0.0 || is_cut || self.relaxation > 0
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
    /// How the clamp moves, and what it holds with it: a motion, or the name of one. It stays in its place if
    /// left out.
    pub motion: Option<Moving>,
    /// Wall with which the clamp moves, instead of a motion.
    pub with_wall: Option<String>,
}

/// What a clamp holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClampRegion<'a> {
    /// The body goes on beyond the face by rows of fixed particles, at the body's own lattice distance;
    /// without rows, points of the face itself are fixed.
    Face {
        /// The face.
        face: Face,
        /// Rows.
        rows: usize,
    },
    /// The body's particles in this box are fixed.
    Box(&'a AxisBox),
    /// The body ends on the circle's arc, and points of the arc are fixed.
    Circle(&'a Ball),
}

impl Clamp {
    /// How it moves, where it does.
    pub fn moves(&self) -> Option<&Motion> {
        self.motion.as_ref().and_then(Moving::motion)
    }

    /// What it holds; nothing of a clamp without a region, which no checked case has.
    pub fn region(&self) -> Option<ClampRegion<'_>> {
        let rows = self.rows.unwrap_or(0) as usize;
        let face = self.face.map(|face| ClampRegion::Face { face, rows });
        let bounds = || self.bounds.as_ref().map(ClampRegion::Box);
        face.or_else(bounds).or_else(|| self.circle.as_ref().map(ClampRegion::Circle))
    }

    /// The box beyond the body's face that the fixed rows fill, for a clamp on a face; `cell` is the body's
    /// lattice distance across it (m).
    pub fn rows_box(&self, body: &AxisBox, cell: f64) -> Option<AxisBox> {
        Some(body.beyond(self.face?, f64::from(self.rows.unwrap_or(0)) * cell))
    }
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
    #[schemars(with = "Option<PerAxis<f64>>")]
    pub at: Option<Vec<f64>>,
    /// Total force (N; in two dimensions N per metre of depth).
    #[schemars(with = "PerAxis<f64>")]
    pub force: Vec<f64>,
    /// Pairs of time (s) and factor of the force, linear between; the full force from the start if left out.
    #[schemars(with = "Option<Vec<[f64; 2]>>")]
    pub ramp: Vec<[f64; 2]>,
}
