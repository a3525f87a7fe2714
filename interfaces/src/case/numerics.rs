//! Numerical parameters of our own solvers. Every key has a default, so one type serves as written and as resolved.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which family of ISPH steps the fluid takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FluidScheme {
    /// Divergence and gradient as an adjoint pair: the projection cannot add energy.
    EnergyConsistent,
    /// The steps of Salehizadeh and Shafiei 2022 as printed (slips mended).
    Paper,
}

/// Form of the viscous term.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ViscosityOperator {
    /// Morris, Fox and Zhu 1997.
    Morris,
    /// The corrected Laplacian of Fatehi and Manzari 2012, Eqs. (4)–(7) of the paper.
    Corrected,
}

/// Numerics of the ISPH fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FluidNumerics {
    /// Family of steps.
    pub scheme: FluidScheme,
    /// Smoothing length over particle spacing, h/Δx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub smoothing_ratio: f64,
    /// Time step is at most this times h/u_max.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub courant: f64,
    /// A time step is at most this times the one before.
    #[schemars(extend("exclusiveMinimum" = 1))]
    pub time_step_growth: f64,
    /// Form of the viscous term.
    pub viscosity_operator: ViscosityOperator,
    /// Kinematic viscosity added between approaching particles, as a factor of h times the characteristic speed. It dissipates.
    #[schemars(extend("minimum" = 0))]
    pub artificial_viscosity: f64,
    /// Whether the sub-particle-scale (large-eddy) viscosity acts, Eqs. (8)–(11).
    pub sub_particle_scale: bool,
    /// Smagorinsky constant of the sub-particle-scale viscosity.
    #[schemars(extend("minimum" = 0))]
    pub smagorinsky: f64,
    /// Residual of the pressure Poisson equation over its right-hand side, below which its iteration ends.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub pressure_tolerance: f64,
    /// Iterations of the pressure Poisson equation at most.
    #[schemars(extend("minimum" = 1))]
    pub pressure_iterations_limit: u32,
    /// Factor of the compact Laplacian that is added to the exact projection operator.
    #[schemars(extend("minimum" = 0))]
    pub pressure_stabilization: f64,
    /// Whether positions are projected to remove the error of the number density (velocities are left alone).
    pub position_projection: bool,
    /// Relative error of the number density that one position projection takes on, at most.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density_error_limit: f64,
    /// Displacement of one position projection at most, as a factor of Δx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub position_projection_limit: f64,
    /// Factor γ of the density error in the pressure equation's source; 0 leaves it out. It pumps energy where it is large.
    #[schemars(extend("minimum" = 0))]
    pub density_source: f64,
    /// Divergence of position between which a particle passes from surface (lower) to interior (upper).
    pub surface_thresholds: [f64; 2],
    /// Whether the pressure of surface particles carries half a spacing of the pressure gradient.
    pub surface_offset: bool,
    /// Factor of the shifting vector.
    #[schemars(extend("minimum" = 0))]
    pub shifting_coefficient: f64,
    /// Shifting displacement at most, as a factor of h.
    #[schemars(extend("minimum" = 0))]
    pub shifting_limit: f64,
    /// Whether shifting beside a structure follows Eqs. (27)–(30).
    pub interface_shifting: bool,
    /// Whether velocities are corrected by a Taylor expansion after shifting, Eqs. (20) and (31). It adds energy at ragged surfaces.
    pub taylor_correction: bool,
    /// Distance from a wall within which an approaching normal velocity is removed, as a factor of Δx.
    #[schemars(extend("minimum" = 0))]
    pub wall_distance: f64,
}

impl Default for FluidNumerics {
    fn default() -> Self {
        Self {
            scheme: FluidScheme::EnergyConsistent,
            smoothing_ratio: 1.2,
            courant: 0.2,
            time_step_growth: 1.2,
            viscosity_operator: ViscosityOperator::Morris,
            artificial_viscosity: 0.02,
            sub_particle_scale: true,
            smagorinsky: 0.1,
            pressure_tolerance: 1e-4,
            pressure_iterations_limit: 1000,
            pressure_stabilization: 0.1,
            position_projection: true,
            density_error_limit: 0.05,
            position_projection_limit: 0.1,
            density_source: 0.0,
            surface_thresholds: [1.6, 1.8],
            surface_offset: true,
            shifting_coefficient: 0.5,
            shifting_limit: 0.2,
            interface_shifting: true,
            taylor_correction: false,
            wall_distance: 0.7,
        }
    }
}

/// Gradient operator of the structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GradientOperator {
    /// First-order-consistent corrected kernel gradient, Eqs. (35)–(37).
    FirstOrder,
}

/// Time integrator of the structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StructureIntegrator {
    /// Classical Runge–Kutta of fourth order, Eqs. (44)–(45).
    Rk4,
}

/// Numerics of the TLSPH structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StructureNumerics {
    /// Gradient operator.
    pub gradient: GradientOperator,
    /// Smoothing length over particle spacing, h/Δx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub smoothing_ratio: f64,
    /// Time integrator.
    pub integrator: StructureIntegrator,
    /// A stable step is this times h over the dilatational wave speed.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub courant: f64,
    /// Factor of the hourglass penalty of Ganzenmüller 2015; 0 leaves it out.
    #[schemars(extend("minimum" = 0))]
    pub hourglass: f64,
    /// Mass-proportional damping: the acceleration is lessened by this times the velocity (1/s).
    #[schemars(extend("minimum" = 0))]
    pub damping: f64,
}

impl Default for StructureNumerics {
    fn default() -> Self {
        Self {
            gradient: GradientOperator::FirstOrder,
            smoothing_ratio: 1.2,
            integrator: StructureIntegrator::Rk4,
            courant: 0.8,
            hourglass: 0.0,
            damping: 0.0,
        }
    }
}
