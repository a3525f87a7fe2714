//! How fluid is at the start: where it is, and how it moves.

use super::geometry::{AxisBox, Ball, PerAxis};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

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
    #[schemars(with = "Option<FluidVelocity>")]
    pub velocity: FluidVelocity,
    /// Gradient of the velocity at the start (1/s), row by row: G·r is added to the velocity, r from the
    /// region's centre.
    #[schemars(with = "Option<PerAxis<PerAxis<f64>>>")]
    pub velocity_gradient: Vec<Vec<f64>>,
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

impl Region {
    /// The box that just holds it; none of a region without a shape, which no checked case has.
    pub fn shape(&self) -> Option<AxisBox> {
        self.bounds.clone().or_else(|| Some(self.ball.as_ref()?.bounds()))
    }

    /// Greatest speed (m/s) at the start, that of its velocity and of its velocity gradient at the corners of
    /// its box added up (for a ball, at the ends of its axes).
    pub fn greatest_speed(&self) -> f64 {
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let uniform = match &self.velocity {
            FluidVelocity::Uniform(v) => norm(v),
            FluidVelocity::Mode(mode) => mode.speed,
        };
        let Some(shape) = self.shape() else { return uniform };
        let half: Vec<f64> = shape.extent().iter().map(|length| 0.5 * length).collect();
        let axes = half.len();
        let times = |r: &[f64]| -> Vec<f64> {
            self.velocity_gradient.iter().map(|row| row.iter().zip(r).map(|(g, x)| g * x).sum()).collect()
        };
        let arms: Vec<Vec<f64>> = if self.bounds.is_some() {
            let end = |corner: usize, i: usize| if corner >> i & 1 == 1 { half[i] } else { -half[i] };
            (0..1usize << axes).map(|corner| (0..axes).map(|i| end(corner, i)).collect()).collect()
        } else {
            let end = |axis: usize, i: usize| if i == axis { half[i] } else { 0.0 };
            (0..axes).map(|axis| (0..axes).map(|i| end(axis, i)).collect()).collect()
        };
        uniform + arms.iter().map(|arm| norm(&times(arm))).fold(0.0, f64::max)
    }
}

/// Velocity of the fluid of a region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum FluidVelocity {
    /// The same everywhere (m/s).
    Uniform(#[schemars(with = "PerAxis<f64>")] Vec<f64>),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_at_the_start_are_those_of_the_edge() {
        let region = |shape: &str, velocity: [f64; 2]| -> Region {
            let gradient = "velocity_gradient = [[-1.0, 0.0], [0.0, 1.0]]";
            let text = format!("name = \"drop\"\n{shape}\nvelocity = {velocity:?}\n{gradient}");
            toml::from_str(&text).unwrap()
        };
        let ball = region("ball = { centre = [3.0, 1.0], radius = 2.0 }", [0.0, 0.0]);
        assert_eq!(ball.greatest_speed(), 2.0);
        let bounds = region("box = { low = [0.0, 0.0], high = [6.0, 8.0] }", [0.6, 0.8]);
        assert_eq!(bounds.greatest_speed(), 6.0);
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
