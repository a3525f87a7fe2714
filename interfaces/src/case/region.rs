//! How fluid is at the start: where it is, and how it moves.

use super::geometry::{AxisBox, Ball};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// `[[fluid.region]]`: a box or a ball full of fluid at the start.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Region {
    /// Name.
    pub name: String,
    /// Its shape.
    #[serde(flatten)]
    pub shape: RegionShape,
    /// Velocity at the start.
    pub velocity: FluidVelocity,
    /// Gradient `G` of the velocity at the start (1/s), row by row: `G·(r − centre)` is added to the
    /// velocity.
    pub velocity_gradient: Vec<Vec<f64>>,
    /// A standing wave at rest at its greatest height, on the box's upper face.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wave: Option<StandingWave>,
    /// Random displacement of its particles from the lattice, at most this times Δx along each axis.
    pub jitter: f64,
    /// Seed of the random displacement.
    pub seed: u32,
}

/// Shape of a region.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum RegionShape {
    /// A box.
    Box {
        /// The box.
        #[serde(rename = "box")]
        bounds: AxisBox,
    },
    /// A ball; in two dimensions a disc.
    Ball {
        /// The ball.
        ball: Ball,
    },
}

impl RegionShape {
    /// The box that just holds it.
    pub fn bounds(&self) -> AxisBox {
        match self {
            Self::Box { bounds } => bounds.clone(),
            Self::Ball { ball } => ball.bounds(),
        }
    }
}

/// Velocity of the fluid of a region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum FluidVelocity {
    /// The same everywhere (m/s).
    Uniform(Vec<f64>),
    /// A shape.
    Mode(TaylorGreen),
}

/// Vortices of Taylor and Green in two dimensions, from the region's lower corner:
/// `u = −U cos(2πx/λ) sin(2πy/λ)`, `v = U sin(2πx/λ) cos(2πy/λ)`. In a periodic domain they decay as
/// `exp(−8π² ν t/λ²)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TaylorGreen {
    /// Which shape; `taylor-green` is the one there is.
    pub mode: FluidVelocityMode,
    /// Greatest speed U (m/s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub speed: f64,
    /// Wavelength λ (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub wavelength: f64,
}

/// Shape of the fluid's velocity at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FluidVelocityMode {
    /// Vortices of Taylor and Green.
    TaylorGreen,
}

impl TaylorGreen {
    /// Velocity (m/s) at `x`, `y` (m) from the region's lower corner.
    pub fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let (x, y) = (TAU * x / self.wavelength, TAU * y / self.wavelength);
        [-self.speed * x.cos() * y.sin(), self.speed * x.sin() * y.cos()]
    }
}

/// A linear standing wave on water as deep as the region's box is high, crest at its left face, at the
/// instant at which all rests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StandingWave {
    /// Height a of the crests over the level (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub amplitude: f64,
    /// Wavelength λ (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub wavelength: f64,
}

impl StandingWave {
    /// Displacement (m) of the water that rests at `x`, `y` from the lower left corner of a box `depth` (m)
    /// high, by linear theory (Lamb 1932, § 228) with k = 2π/λ: `−a sin(kx) cosh(ky)/sinh(kH)`,
    /// `a cos(kx) sinh(ky)/sinh(kH)`. It keeps volumes to first order in ka.
    pub fn displacement(&self, x: f64, y: f64, depth: f64) -> [f64; 2] {
        let k = 2.0 * PI / self.wavelength;
        let scale = self.amplitude / (k * depth).sinh();
        [-scale * (k * x).sin() * (k * y).cosh(), scale * (k * x).cos() * (k * y).sinh()]
    }
}

/// Greatest speed (m/s) of a region at the start, that of its velocity and of its velocity gradient at the
/// corners of its box added up (for a ball, at the ends of its axes).
pub fn greatest_speed(
    velocity: Option<&FluidVelocity>,
    gradient: Option<&[Vec<f64>]>,
    shape: Option<&RegionShape>,
) -> f64 {
    let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let uniform = match velocity {
        Some(FluidVelocity::Uniform(v)) => norm(v),
        Some(FluidVelocity::Mode(mode)) => mode.speed,
        None => 0.0,
    };
    let (Some(gradient), Some(shape)) = (gradient, shape) else { return uniform };
    let half: Vec<f64> = shape.bounds().extent().iter().map(|length| 0.5 * length).collect();
    let axes = half.len();
    let times = |r: &[f64]| -> Vec<f64> {
        gradient.iter().map(|row| row.iter().zip(r).map(|(g, x)| g * x).sum()).collect()
    };
    let arms: Vec<Vec<f64>> = match shape {
        RegionShape::Box { .. } => (0..1usize << axes)
            .map(|corner| (0..axes).map(|i| if corner >> i & 1 == 1 { half[i] } else { -half[i] }).collect())
            .collect(),
        RegionShape::Ball { .. } => {
            (0..axes).map(|axis| (0..axes).map(|i| if i == axis { half[i] } else { 0.0 }).collect()).collect()
        }
    };
    uniform + arms.iter().map(|arm| norm(&times(arm))).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_at_the_start_are_those_of_the_edge() {
        let ball = RegionShape::Ball { ball: Ball { centre: vec![3.0, 1.0], radius: 2.0 } };
        let bounds = AxisBox { low: vec![0.0, 0.0], high: vec![6.0, 8.0] };
        let gradient = [vec![-1.0, 0.0], vec![0.0, 1.0]];
        assert_eq!(greatest_speed(None, Some(&gradient), Some(&ball)), 2.0);
        let v = FluidVelocity::Uniform(vec![0.6, 0.8]);
        assert_eq!(greatest_speed(Some(&v), Some(&gradient), Some(&RegionShape::Box { bounds })), 6.0);
    }

    #[test]
    fn a_wave_is_highest_at_its_crest_and_rests_on_the_bed() {
        let wave = StandingWave { amplitude: 0.1, wavelength: 2.0 };
        assert!((wave.displacement(0.0, 1.0, 1.0)[1] - 0.1).abs() < 1e-15);
        assert!((wave.displacement(1.0, 1.0, 1.0)[1] + 0.1).abs() < 1e-15);
        assert_eq!(wave.displacement(0.3, 0.0, 1.0)[1], 0.0);
        assert!(wave.displacement(1.0, 0.5, 1.0)[0].abs() < 1e-15);
    }
}
