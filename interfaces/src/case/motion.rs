//! How walls and clamps move: `[motion.NAME]`, and `motion` of a wall or clamp.

use super::geometry::{PerAxis, array};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use words::motion::Law;
use words::rigid;

/// A number over time, from a `table`, a sine (`amplitude`, `period`) or a constant `speed`, times a
/// `direction` (m) or about a `pivot` (rad).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Direction along which it goes; its length does not count.
    #[schemars(with = "Option<PerAxis<f64>>")]
    pub direction: Option<Vec<f64>>,
    /// Point about which it turns from x to y (m); in three dimensions about the line through it along z.
    #[schemars(with = "Option<PerAxis<f64>>")]
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
    /// Constant speed (m/s or rad/s).
    pub speed: Option<f64>,
    /// When it begins (s), at rest until then: the law's own time counts from it; 0 if left out.
    #[schemars(extend("minimum" = 0))]
    pub start: Option<f64>,
    /// How long a smooth start takes (s): over it the law (of a constant speed, the speed) is multiplied by
    /// 10 x³ − 15 x⁴ + 6 x⁵ with x from 0 to 1. None if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub ramp: Option<f64>,
}

impl Motion {
    /// The number over time: m or rad. None of a motion without a law, which no checked case has.
    pub fn law(&self) -> Option<Law> {
        let sine = || {
            let phase = self.phase.unwrap_or(0.0);
            Some(Law::Sine { amplitude: self.amplitude?, period: self.period?, phase })
        };
        let speed = || self.speed.map(|speed| Law::Speed { speed });
        let law = self.table.clone().map(|table| Law::Table { table }).or_else(sine).or_else(speed)?;
        Some(match (self.start, self.ramp) {
            (None, None) => law,
            (start, ramp) => {
                Law::Late { start: start.unwrap_or(0.0), ramp: ramp.unwrap_or(0.0), law: Box::new(law) }
            }
        })
    }

    /// The rigid motion. None of one that leads nowhere or has no law, which no checked case has.
    pub fn rigid<const D: usize>(&self) -> Option<rigid::Motion<D>> {
        let law = self.law()?;
        match (&self.direction, &self.pivot) {
            (Some(direction), _) => Some(rigid::Motion::along(array(direction), law)),
            (None, Some(pivot)) => Some(rigid::Motion::Rotation { pivot: array(pivot), law }),
            (None, None) => None,
        }
    }
}

/// How a wall or clamp moves: as said on the spot, or by the name of a motion. In a case as resolved no name
/// is left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Moving {
    /// Name of a `[motion.NAME]`.
    Named(String),
    /// A motion of its own.
    Own(Motion),
}

impl Moving {
    /// The motion; none of a name, of which a checked case has none.
    pub fn motion(&self) -> Option<&Motion> {
        match self {
            Self::Named(_) => None,
            Self::Own(motion) => Some(motion),
        }
    }
}
