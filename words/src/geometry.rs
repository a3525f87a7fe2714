//! Axes, faces and sides.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A face of a box. In two dimensions `left`, `right`, `bottom` and `top`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Face {
    /// Least x.
    Left,
    /// Greatest x.
    Right,
    /// Least y.
    Bottom,
    /// Greatest y.
    Top,
    /// Least z; three dimensions only.
    Back,
    /// Greatest z; three dimensions only.
    Front,
}

impl Face {
    /// Axis that the face stands across: 0, 1 or 2.
    pub fn axis(self) -> usize {
        match self {
            Self::Left | Self::Right => 0,
            Self::Bottom | Self::Top => 1,
            Self::Back | Self::Front => 2,
        }
    }

    /// Direction of the outward normal along [`Self::axis`]: −1 or +1.
    pub fn sign(self) -> f64 {
        match self {
            Self::Left | Self::Bottom | Self::Back => -1.0,
            Self::Right | Self::Top | Self::Front => 1.0,
        }
    }
}

/// An axis of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third; three dimensions only.
    Z,
}

impl Axis {
    /// 0, 1 or 2.
    pub fn index(self) -> usize {
        match self {
            Self::X => 0,
            Self::Y => 1,
            Self::Z => 2,
        }
    }
}

/// On which side of a polyline the solid is, for one who walks it from its first point to its last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// The solid is to the left.
    Left,
    /// The solid is to the right.
    Right,
}
