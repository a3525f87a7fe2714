//! Choices of contact: `[structure.contact]`.
//!
//! Comments, types, ranges and defaults are those of the case file, its schema and its documentation.

use crate::contact::walls::Wall;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Contact of the structure: with the case's walls, of its bodies with each other and with themselves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactOptions {
    /// Coefficient of Coulomb's friction, the same for sticking and sliding.
    #[schemars(extend("minimum" = 0))]
    pub friction: f64,
    /// Whether bodies meet the walls.
    pub walls: bool,
    /// Whether bodies meet each other.
    pub bodies: bool,
    /// Whether a body meets itself.
    #[serde(rename = "self")]
    pub itself: bool,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self { friction: 0.0, walls: true, bodies: true, itself: true }
    }
}

/// What of a setup meets what.
#[derive(Clone, Debug, Default)]
pub struct ContactSetup<const D: usize> {
    /// Choices.
    pub options: ContactOptions,
    /// Rigid walls.
    pub walls: Vec<Wall<D>>,
    /// Names of the bodies, for messages; a body without one is told by its number.
    pub names: Vec<String>,
}

impl<const D: usize> ContactSetup<D> {
    /// Whether anything may meet anything, of so many bodies.
    pub fn acts(&self, bodies: usize) -> bool {
        let ContactOptions { bodies: each_other, itself, .. } = self.options;
        itself || self.has_walls() || (each_other && bodies > 1)
    }

    /// Whether bodies meet walls that move.
    pub fn walls_move(&self) -> bool {
        self.has_walls() && self.walls.iter().any(|wall| wall.motion.is_some())
    }

    fn has_walls(&self) -> bool {
        self.options.walls && !self.walls.is_empty()
    }
}
