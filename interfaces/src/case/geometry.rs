//! Boxes and their faces. Vectors in the case are lists of as many numbers as the case has dimensions; the
//! check has compared their lengths.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A box along the axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisBox {
    /// Corner with the least coordinates (m).
    pub low: Vec<f64>,
    /// Corner with the greatest coordinates (m).
    pub high: Vec<f64>,
}

impl AxisBox {
    /// Edge lengths (m).
    pub fn extent(&self) -> Vec<f64> {
        self.low.iter().zip(&self.high).map(|(low, high)| high - low).collect()
    }

    /// Cells that a lattice of about `spacing` (m) has along each axis: `round(length/spacing)`, at least
    /// one; the rule of `sph::lattice`.
    pub fn lattice_counts(&self, spacing: f64) -> Vec<usize> {
        self.extent().iter().map(|length| ((length / spacing).round() as usize).max(1)).collect()
    }

    /// Particles on the lattice of [`Self::lattice_counts`].
    pub fn particle_count(&self, spacing: f64) -> usize {
        self.lattice_counts(spacing).iter().product()
    }

    /// Whether the boxes share more than `tolerance` (m) along every axis; touching is not overlapping.
    pub fn overlaps(&self, other: &Self, tolerance: f64) -> bool {
        let before = |low: f64, high: f64| low < high - tolerance;
        let axes = self.low.iter().zip(&self.high).zip(other.low.iter().zip(&other.high));
        axes.into_iter().all(|((low, high), (other_low, other_high))| {
            before(*low, *other_high) && before(*other_low, *high)
        })
    }

    /// Whether the point is farther than `tolerance` (m) from the box along some axis.
    pub fn is_clear_of(&self, point: &[f64], tolerance: f64) -> bool {
        let axes = point.iter().zip(self.low.iter().zip(&self.high));
        axes.into_iter().any(|(x, (low, high))| *x < low - tolerance || *x > high + tolerance)
    }
}

/// A ball; in two dimensions a disc.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ball {
    /// Centre (m).
    pub centre: Vec<f64>,
    /// Radius (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: f64,
}

impl Ball {
    /// The box that just holds it.
    pub fn bounds(&self) -> AxisBox {
        let shifted = |by: f64| self.centre.iter().map(|c| c + by).collect();
        AxisBox { low: shifted(-self.radius), high: shifted(self.radius) }
    }
}

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

    /// Where the face stands on its axis (m).
    pub fn coordinate(self, of: &AxisBox) -> f64 {
        if self.sign() < 0.0 { of.low[self.axis()] } else { of.high[self.axis()] }
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

/// The list as an array.
///
/// # Panics
/// Where the list has not `D` numbers: the case's vectors have as many as its dimension, so `D` is not that.
pub fn array<const D: usize>(vector: &[f64]) -> [f64; D] {
    vector.try_into().expect("a checked case has vectors of its own dimension")
}
