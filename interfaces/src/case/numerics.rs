//! Numerical parameters of our own solvers: as written, where every key may be left out, and as resolved.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which family of ISPH steps the fluid takes. It sets what all other keys are when they are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FluidScheme {
    /// Divergence and gradient as an adjoint pair: the projection cannot add energy.
    #[default]
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

/// Preconditioner of the pressure Poisson equation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Preconditioner {
    /// Algebraic multigrid on the compact Laplacian.
    Multigrid,
    /// The operator's diagonal.
    Jacobi,
}

/// Law of particle shifting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shifting {
    /// Down the concentration gradient (Lind et al. 2012).
    Concentration,
    /// The paper's Eqs. (21)–(23) (Xu et al. 2009).
    Paper,
    /// None.
    Off,
}

/// Where fluid that would be pulled is torn open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Tearing {
    /// Nowhere: it bears any tension.
    Off,
    /// Where air can come in: with the surface, or fluid that is torn, within reach.
    AtSurface,
    /// In cavities, too, that have closed.
    Everywhere,
}

/// Numerics of the ISPH fluid, as written.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FluidNumericsKeys {
    /// Family of steps.
    pub scheme: FluidScheme,
    /// Smoothing length over particle spacing, h/Δx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub smoothing_ratio: Option<f64>,
    /// Time step is at most this times h/u_max.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub courant: Option<f64>,
    /// A time step is at most this times the one before.
    #[schemars(extend("exclusiveMinimum" = 1))]
    pub time_step_growth: Option<f64>,
    /// Form of the viscous term.
    pub viscosity_operator: Option<ViscosityOperator>,
    /// Kinematic viscosity added between approaching particles, as a factor of h times the characteristic
    /// speed. It dissipates.
    #[schemars(extend("minimum" = 0))]
    pub artificial_viscosity: Option<f64>,
    /// Smagorinsky constant of the sub-particle-scale (large-eddy) viscosity, Eq. (10); 0 leaves it out.
    #[schemars(extend("minimum" = 0))]
    pub smagorinsky: Option<f64>,
    /// Residual of the pressure Poisson equation over its right-hand side, below which its iteration ends.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub pressure_tolerance: Option<f64>,
    /// Iterations of the pressure Poisson equation at most; more are an error.
    #[schemars(extend("minimum" = 1))]
    pub pressure_iterations_limit: Option<u32>,
    /// Factor of the compact Laplacian that is added to the exact projection operator.
    #[schemars(extend("minimum" = 0))]
    pub pressure_stabilization: Option<f64>,
    /// Preconditioner of the pressure Poisson equation.
    pub preconditioner: Option<Preconditioner>,
    /// Whether positions are projected to remove the error of the number density (velocities are left alone).
    pub position_projection: Option<bool>,
    /// Residual of the position projection over its right-hand side, below which its iteration ends.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub position_tolerance: Option<f64>,
    /// Whether the corrected gradient of Eq. (18) is blended into the symmetric one, as far as energy allows.
    pub corrected_gradient: Option<bool>,
    /// Divergence of position over the dimension, between which a particle passes from surface (lower) to
    /// interior (upper), Eq. (17).
    pub surface_thresholds: Option<[f64; 2]>,
    /// Whether the pressure of surface particles carries half a spacing of the pressure gradient.
    pub surface_offset: Option<bool>,
    /// Where fluid that would be pulled, its pressure below that of the surface, is torn open instead.
    pub tearing: Option<Tearing>,
    /// Law of particle shifting.
    pub shifting: Option<Shifting>,
    /// Factor of the shifting vector.
    #[schemars(extend("minimum" = 0))]
    pub shifting_coefficient: Option<f64>,
    /// Shifting displacement at most, as a factor of h.
    #[schemars(extend("minimum" = 0))]
    pub shifting_limit: Option<f64>,
    /// Whether shifting beside a structure follows Eqs. (27)–(30).
    pub interface_shifting: Option<bool>,
    /// Whether velocities are corrected by a Taylor expansion after shifting, Eqs. (20) and (31). It adds
    /// energy at ragged surfaces.
    pub taylor_correction: Option<bool>,
    /// Distance from a wall or structure below which no particle may come, as a factor of Δx.
    #[schemars(extend("minimum" = 0))]
    pub contact_distance: Option<f64>,
}

/// Numerics of the ISPH fluid, as resolved.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FluidNumerics {
    /// Family of steps.
    pub scheme: FluidScheme,
    /// Smoothing length over particle spacing, h/Δx.
    pub smoothing_ratio: f64,
    /// Time step is at most this times h/u_max.
    pub courant: f64,
    /// A time step is at most this times the one before.
    pub time_step_growth: f64,
    /// Form of the viscous term.
    pub viscosity_operator: ViscosityOperator,
    /// Kinematic viscosity added between approaching particles, as a factor of h times the characteristic
    /// speed. It dissipates.
    pub artificial_viscosity: f64,
    /// Smagorinsky constant of the sub-particle-scale (large-eddy) viscosity, Eq. (10); 0 leaves it out.
    pub smagorinsky: f64,
    /// Residual of the pressure Poisson equation over its right-hand side, below which its iteration ends.
    pub pressure_tolerance: f64,
    /// Iterations of the pressure Poisson equation at most; more are an error.
    pub pressure_iterations_limit: u32,
    /// Factor of the compact Laplacian that is added to the exact projection operator.
    pub pressure_stabilization: f64,
    /// Preconditioner of the pressure Poisson equation.
    pub preconditioner: Preconditioner,
    /// Whether positions are projected to remove the error of the number density (velocities are left alone).
    pub position_projection: bool,
    /// Residual of the position projection over its right-hand side, below which its iteration ends.
    pub position_tolerance: f64,
    /// Whether the corrected gradient of Eq. (18) is blended into the symmetric one, as far as energy allows.
    pub corrected_gradient: bool,
    /// Divergence of position over the dimension, between which a particle passes from surface (lower) to
    /// interior (upper), Eq. (17).
    pub surface_thresholds: [f64; 2],
    /// Whether the pressure of surface particles carries half a spacing of the pressure gradient.
    pub surface_offset: bool,
    /// Where fluid that would be pulled, its pressure below that of the surface, is torn open instead.
    pub tearing: Tearing,
    /// Law of particle shifting.
    pub shifting: Shifting,
    /// Factor of the shifting vector.
    pub shifting_coefficient: f64,
    /// Shifting displacement at most, as a factor of h.
    pub shifting_limit: f64,
    /// Whether shifting beside a structure follows Eqs. (27)–(30).
    pub interface_shifting: bool,
    /// Whether velocities are corrected by a Taylor expansion after shifting, Eqs. (20) and (31). It adds
    /// energy at ragged surfaces.
    pub taylor_correction: bool,
    /// Distance from a wall or structure below which no particle may come, as a factor of Δx.
    pub contact_distance: f64,
}

impl FluidNumerics {
    /// What a scheme is when nothing else is written.
    pub fn of(scheme: FluidScheme) -> Self {
        let energy_consistent = Self {
            scheme,
            smoothing_ratio: 1.2,
            courant: 0.2,
            time_step_growth: 1.2,
            viscosity_operator: ViscosityOperator::Morris,
            artificial_viscosity: 0.02,
            smagorinsky: 0.1,
            pressure_tolerance: 1e-3,
            pressure_iterations_limit: 1000,
            pressure_stabilization: 0.1,
            preconditioner: Preconditioner::Multigrid,
            position_projection: true,
            position_tolerance: 0.05,
            corrected_gradient: true,
            surface_thresholds: [0.8, 0.9],
            surface_offset: true,
            tearing: Tearing::Off,
            shifting: Shifting::Concentration,
            shifting_coefficient: 0.5,
            shifting_limit: 0.2,
            interface_shifting: false,
            taylor_correction: false,
            contact_distance: 0.25,
        };
        match scheme {
            FluidScheme::EnergyConsistent => energy_consistent,
            FluidScheme::Paper => Self {
                courant: 0.1,
                viscosity_operator: ViscosityOperator::Corrected,
                artificial_viscosity: 0.0,
                pressure_stabilization: 1.0,
                position_projection: false,
                surface_thresholds: [0.7, 0.8],
                surface_offset: false,
                shifting: Shifting::Paper,
                shifting_coefficient: 0.04,
                interface_shifting: true,
                taylor_correction: true,
                ..energy_consistent
            },
        }
    }
}

impl FluidNumericsKeys {
    /// Fills in what was left out.
    pub fn resolve(&self) -> FluidNumerics {
        let of_scheme = FluidNumerics::of(self.scheme);
        FluidNumerics {
            scheme: self.scheme,
            smoothing_ratio: self.smoothing_ratio.unwrap_or(of_scheme.smoothing_ratio),
            courant: self.courant.unwrap_or(of_scheme.courant),
            time_step_growth: self.time_step_growth.unwrap_or(of_scheme.time_step_growth),
            viscosity_operator: self.viscosity_operator.unwrap_or(of_scheme.viscosity_operator),
            artificial_viscosity: self.artificial_viscosity.unwrap_or(of_scheme.artificial_viscosity),
            smagorinsky: self.smagorinsky.unwrap_or(of_scheme.smagorinsky),
            pressure_tolerance: self.pressure_tolerance.unwrap_or(of_scheme.pressure_tolerance),
            pressure_iterations_limit: self
                .pressure_iterations_limit
                .unwrap_or(of_scheme.pressure_iterations_limit),
            pressure_stabilization: self.pressure_stabilization.unwrap_or(of_scheme.pressure_stabilization),
            preconditioner: self.preconditioner.unwrap_or(of_scheme.preconditioner),
            position_projection: self.position_projection.unwrap_or(of_scheme.position_projection),
            position_tolerance: self.position_tolerance.unwrap_or(of_scheme.position_tolerance),
            corrected_gradient: self.corrected_gradient.unwrap_or(of_scheme.corrected_gradient),
            surface_thresholds: self.surface_thresholds.unwrap_or(of_scheme.surface_thresholds),
            surface_offset: self.surface_offset.unwrap_or(of_scheme.surface_offset),
            tearing: self.tearing.unwrap_or(of_scheme.tearing),
            shifting: self.shifting.unwrap_or(of_scheme.shifting),
            shifting_coefficient: self.shifting_coefficient.unwrap_or(of_scheme.shifting_coefficient),
            shifting_limit: self.shifting_limit.unwrap_or(of_scheme.shifting_limit),
            interface_shifting: self.interface_shifting.unwrap_or(of_scheme.interface_shifting),
            taylor_correction: self.taylor_correction.unwrap_or(of_scheme.taylor_correction),
            contact_distance: self.contact_distance.unwrap_or(of_scheme.contact_distance),
        }
    }
}

/// Gradient operator of the structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GradientOperator {
    /// Quadratic gradient and Hessian with a strain-gradient energy: right in bending from three particles
    /// through the thickness on.
    #[default]
    Quadratic,
    /// First-order-consistent corrected kernel gradient, Eqs. (35)–(36) and (42): the paper's, too soft in
    /// bending.
    FirstOrder,
}

impl GradientOperator {
    /// Smoothing length over spacing where none is written.
    pub fn smoothing_ratio(self) -> f64 {
        match self {
            Self::Quadratic => 1.0,
            Self::FirstOrder => 1.2,
        }
    }

    /// Rows of fixed particles beyond a clamped face where none are written; 0 are fixed points on the face
    /// itself.
    pub fn clamp_rows(self) -> usize {
        match self {
            Self::Quadratic => 0,
            Self::FirstOrder => 3,
        }
    }
}

/// Numerics of the TLSPH structure, as written. It is integrated by the classical Runge–Kutta method of
/// fourth order, Eqs. (43)–(45).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StructureNumericsKeys {
    /// Gradient operator.
    pub gradient: GradientOperator,
    /// Smoothing length over particle spacing, h/Δx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub smoothing_ratio: Option<f64>,
    /// Factor of the hourglass penalty of Ganzenmüller 2015; 0 leaves it out.
    #[schemars(extend("minimum" = 0))]
    pub hourglass: f64,
    /// Mass-proportional damping: the acceleration is lessened by this times the velocity (1/s).
    #[schemars(extend("minimum" = 0))]
    pub damping: f64,
    /// Largest sub-step over the limit of stability of the Runge–Kutta method, at most 0.9; less keeps energy
    /// better, with its fifth power.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 0.9))]
    pub step_fraction: Option<f64>,
}

/// Numerics of the TLSPH structure, as resolved.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StructureNumerics {
    /// Gradient operator.
    pub gradient: GradientOperator,
    /// Smoothing length over particle spacing, h/Δx.
    pub smoothing_ratio: f64,
    /// Factor of the hourglass penalty of Ganzenmüller 2015; 0 leaves it out.
    pub hourglass: f64,
    /// Mass-proportional damping: the acceleration is lessened by this times the velocity (1/s).
    pub damping: f64,
    /// Largest sub-step over the limit of stability of the Runge–Kutta method, at most 0.9; less keeps energy
    /// better, with its fifth power.
    pub step_fraction: f64,
}

impl StructureNumericsKeys {
    /// Fills in what was left out.
    pub fn resolve(&self) -> StructureNumerics {
        StructureNumerics {
            gradient: self.gradient,
            smoothing_ratio: self.smoothing_ratio.unwrap_or(self.gradient.smoothing_ratio()),
            hourglass: self.hourglass,
            damping: self.damping,
            step_fraction: self.step_fraction.unwrap_or(0.9),
        }
    }
}
