//! Choices of the method.

/// Largest fraction of the limit of stability that a sub-step may be: the largest frequency rises with
/// deformation within a window, and the iteration for it finds it from below.
pub const SAFETY: f64 = 0.9;

/// The discrete gradient in the reference configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gradient {
    /// Quadratic gradient and Hessian with a strain-gradient energy: right in bending from three particles
    /// through the thickness on.
    Quadratic,
    /// The paper's kernel gradient corrected to first order, Eqs. (35), (36), (42).
    FirstOrder,
}

impl Gradient {
    /// Smoothing length over spacing where none is given: the paper's 1.2; 1.0 for the quadratic gradient.
    pub fn default_smoothing_ratio(self) -> f64 {
        match self {
            Self::FirstOrder => 1.2,
            Self::Quadratic => 1.0,
        }
    }
}

/// Numerics of the structure.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Discrete gradient.
    pub gradient: Gradient,
    /// Smoothing length over spacing.
    pub smoothing_ratio: f64,
    /// Coefficient `ζ` of the hourglass control of Ganzenmüller 2015; others run 0.01 to 0.1. Zero: none.
    pub hourglass: f64,
    /// Viscous damping `c` (1/s): the acceleration `−c u`. Zero: none.
    pub damping: f64,
    /// Largest sub-step over the limit of stability, in (0, 0.9]. The method loses energy with the fifth power
    /// of the step.
    pub step_fraction: f64,
}

impl Options {
    /// What a gradient is run with when nothing else is said.
    pub fn of(gradient: Gradient) -> Self {
        Self {
            gradient,
            smoothing_ratio: gradient.default_smoothing_ratio(),
            hourglass: 0.0,
            damping: 0.0,
            step_fraction: SAFETY,
        }
    }
}

impl Default for Options {
    fn default() -> Self {
        Self::of(Gradient::Quadratic)
    }
}
