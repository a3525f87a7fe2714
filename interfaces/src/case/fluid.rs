//! `[fluid]`: its keys.

use super::geometry::{AxisBox, PerAxis};
use super::motion::{Motion, Moving};
use super::participant::Participant;
use super::region::Region;
use super::section::AnyTable;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Table;
use words::geometry::{Axis, Side};

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
    #[schemars(with = "Option<f64>", extend("exclusiveMinimum" = 0))]
    pub particle_spacing: f64,
    /// Largest time step (s); the output interval if left out.
    #[schemars(with = "Option<f64>", extend("exclusiveMinimum" = 0))]
    pub max_time_step: f64,
    /// Speed that scales artificial viscosity, shifting and the first time step (m/s); √(g H) if left out, H
    /// the extent of all regions along gravity; without gravity the greatest speed at the start.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(with = "Option<f64>", extend("exclusiveMinimum" = 0))]
    pub characteristic_speed: f64,
    /// Where particles live: one that leaves this box has left the run.
    pub domain: AxisBox,
    /// Axes along which the domain repeats; none if left out.
    #[serde(default)]
    pub periodic: Vec<Axis>,
    /// Boxes and balls full of fluid at the start.
    #[serde(default, rename = "region")]
    pub regions: Vec<Region>,
    /// Rigid walls.
    #[serde(default, rename = "wall")]
    pub walls: Vec<Wall>,
    /// Numerics of its solver, which brings the keys.
    #[serde(default)]
    #[schemars(with = "AnyTable")]
    pub numerics: Table,
    /// Who solves the fluid; our own solver if left out.
    #[serde(default)]
    pub participant: Participant,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
fn is_zero(number: &f64) -> bool {
    *number == 0.0
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
    #[schemars(with = "Option<Vec<PerAxis<f64>>>")]
    pub polyline: Option<Vec<Vec<f64>>>,
    /// On which side of the polyline the solid is, walking from its first point to its last.
    pub solid_side: Option<Side>,
    /// Tangential velocity at the wall; free-slip if left out.
    #[schemars(with = "Option<Slip>")]
    pub slip: Slip,
    /// Velocity of its surface (m/s) along itself: a belt, a lid. At rest if left out.
    #[schemars(with = "Option<PerAxis<f64>>")]
    pub velocity: Vec<f64>,
    /// How the wall moves: a gate that lifts, a tank that rolls; a motion, or the name of one. It stays in
    /// its place if left out.
    pub motion: Option<Moving>,
}

impl Wall {
    /// How it moves, where it does.
    pub fn moves(&self) -> Option<&Motion> {
        self.motion.as_ref().and_then(Moving::motion)
    }
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
