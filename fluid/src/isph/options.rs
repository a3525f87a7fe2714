//! Choices of the method: the default is the energy-consistent recipe, the paper's steps are options.
//!
//! Comments, types, ranges and defaults of the options that are keys of `[fluid.numerics]` are those of the
//! case file, its schema and its documentation.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
pub use words::coupling::{LoadForm as Load, StructureVelocity};

/// Which family of steps moves the fluid. It sets what all other keys are when they are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// Gradient as the negative transpose of the divergence, `A = D M⁻¹ Dᵀ + S`: projection cannot add
    /// kinetic energy.
    EnergyConsistent,
    /// The paper's as printed, its slips mended: compact Laplacian of Eq. (15) without its `B` (symmetric),
    /// velocity correction of Eq. (18) with `B`.
    Paper,
}

/// Form of the viscous stress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ViscousOperator {
    /// Monaghan and Gingold 1983: along the line that joins two particles. It conserves momentum and angular
    /// momentum, only dissipates, and leaves a free surface free of traction.
    MonaghanGingold,
    /// Morris, Fox and Zhu 1997: symmetric, so it conserves momentum and only dissipates. A free surface has
    /// `∂u/∂n = 0`, and a wave decays at half its rate.
    Morris,
    /// The paper's Eqs. (4), (6), (7), (13): Fatehi and Manzari 2012, exact for quadratic fields, neither
    /// symmetric nor surely dissipative.
    #[serde(rename = "corrected")]
    FatehiManzari,
}

/// Where particles are shifted to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ShiftingLaw {
    /// Down the concentration gradient (Lind et al. 2012).
    Concentration,
    /// The paper's Eqs. (21)–(23) (Xu et al. 2009).
    Paper,
    /// None.
    Off,
}

/// Where fluid that would be pulled, its pressure below what it bears, is torn instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Tearing {
    /// Nowhere: it bears any tension.
    Off,
    /// Where air can come in: with the surface, or torn fluid, within reach.
    AtSurface,
    /// Wherever there is a surface at all: in cavities, too, that have closed.
    Everywhere,
}

/// How the conjugate gradients are preconditioned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Preconditioner {
    /// The operator's diagonal.
    Jacobi,
    /// Algebraic multigrid on the compact Laplacian.
    Multigrid,
}

/// What becomes of a run in which particles are lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LostParticles {
    /// It ends, and the message says which particle, where and when: water that is gone is not conserved.
    Refused,
    /// It goes on without them, and counts them (`fluid.particles_lost`).
    Counted,
}

/// All choices of the method: `[fluid.numerics]`, and what other keys of the case say. Lengths and velocities
/// are in units of the spacing or derived from the case, so that one set serves all resolutions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Family of steps. What the other keys are when they are left out follows from it.
    pub scheme: Scheme,
    /// Smoothing length over particle spacing, h/Δx.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub smoothing_ratio: f64,
    /// Time step is at most this times h/u_max (the paper's Eq. (49) has 0.1).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub courant: f64,
    /// A time step is at most this times the one before.
    #[schemars(extend("exclusiveMinimum" = 1))]
    pub time_step_growth: f64,
    /// Form of the viscous term.
    pub viscosity_operator: ViscousOperator,
    /// Kinematic viscosity that approaching particles have at least, as a factor of h times the
    /// characteristic speed. It dissipates.
    #[schemars(extend("minimum" = 0))]
    pub artificial_viscosity: f64,
    /// Smagorinsky constant of the sub-particle-scale (large-eddy) viscosity, Eq. (10); 0 leaves it out.
    #[schemars(extend("minimum" = 0))]
    pub smagorinsky: f64,
    /// Residual of the pressure Poisson equation over its right-hand side, below which its iteration ends;
    /// with an implicit coupling scheme a tenth of `coupling.convergence.relative` saves iterations of that.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub pressure_tolerance: f64,
    /// Iterations of the pressure Poisson equation at most; more are an error.
    #[schemars(extend("minimum" = 1))]
    pub pressure_iterations_limit: usize,
    /// Share of the compact Laplacian that is added to the exact projection operator `D M⁻¹ Dᵀ`, which is
    /// blind to checkerboards.
    #[schemars(extend("minimum" = 0))]
    pub pressure_stabilization: f64,
    /// Preconditioner of the pressure Poisson equation.
    pub preconditioner: Preconditioner,
    /// Whether positions are projected to remove the error of the number density (velocities are left alone).
    pub position_projection: bool,
    /// Residual of the position projection over its right-hand side, below which its iteration ends.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub position_tolerance: f64,
    /// Displacement by the position projection at most, as a factor of Δx.
    #[schemars(extend("minimum" = 0))]
    pub position_limit: f64,
    /// Whether the corrected gradient of Eq. (18) is blended into the symmetric one, as far as energy allows
    /// (energy-consistent scheme only).
    pub corrected_gradient: bool,
    /// Divergence of position over the dimension, between which a particle passes from surface (lower) to
    /// interior (upper), Eq. (17).
    #[schemars(with = "[f64; 2]")]
    pub surface_thresholds: (f64, f64),
    /// How far below the lower threshold a particle has to fall that was not on the surface until it is.
    #[schemars(extend("minimum" = 0))]
    pub surface_hysteresis: f64,
    /// Whether the pressure of surface particles carries half a spacing of the pressure gradient.
    pub surface_offset: bool,
    /// Where fluid that would be pulled below what it bears is torn open instead.
    pub tearing: Tearing,
    /// Pressure (Pa) over that of the air below which fluid tears: 0 where air can come in or is shut in,
    /// that at which it boils (−0.1 MPa for water) where there is none. Cavities that `tearing =
    /// "everywhere"` opens have this pressure, those at the surface that of the air.
    #[schemars(extend("maximum" = 0))]
    pub tensile_limit: f64,
    /// Law of particle shifting.
    pub shifting: ShiftingLaw,
    /// Factor of the shifting vector: times `2h u Δt` of the law `"concentration"`, the paper's `C` of its
    /// own.
    #[schemars(extend("minimum" = 0))]
    pub shifting_coefficient: f64,
    /// Shifting displacement at most, as a factor of h.
    #[schemars(extend("minimum" = 0))]
    pub shifting_limit: f64,
    /// Whether shifting beside a structure follows Eqs. (27)–(30).
    pub interface_shifting: bool,
    /// Whether velocity and pressure are corrected by a Taylor expansion after shifting, Eqs. (20), (31) and
    /// (32). It adds energy at ragged surfaces.
    pub taylor_correction: bool,
    /// Distance from a wall or structure below which no particle may come, as a factor of Δx.
    #[schemars(extend("minimum" = 0))]
    pub contact_distance: f64,
    /// What becomes of a run in which particles are lost inside walls or structure.
    pub lost_particles: LostParticles,
    /// Compressibility κ of the fluid in units of `1/(ρΔx²)`: keeps the operator regular.
    #[serde(skip)]
    pub regularisation: f64,
    /// The same for pockets of fluid without a particle of known pressure.
    #[serde(skip)]
    pub pocket_regularisation: f64,
    /// Whether walls hold the fluid's tangential velocity back.
    #[serde(skip)]
    pub no_slip_walls: bool,
    /// Whether the structure holds the fluid's tangential velocity back.
    #[serde(skip)]
    pub no_slip_structure: bool,
    /// Velocity (m/s) that stands for the flow's scale while it is slow; `√(gH)` of the initial fluid when
    /// none is given.
    #[serde(skip)]
    pub reference_velocity: Option<f64>,
    /// Whether the structure's own compliance enters the pressure operator; without it the structure is a
    /// moving wall.
    #[serde(skip)]
    pub compliance: bool,
    /// Which velocity of the structure the interface brings.
    #[serde(skip)]
    pub structure_velocity: StructureVelocity,
    /// Load on the structure.
    #[serde(skip)]
    pub load: Load,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            scheme: Scheme::EnergyConsistent,
            smoothing_ratio: 1.2,
            surface_thresholds: (0.8, 0.9),
            surface_hysteresis: 0.04,
            pressure_stabilization: 0.1,
            regularisation: 1e-6,
            pocket_regularisation: 1e-2,
            preconditioner: Preconditioner::Multigrid,
            // Measured in docs/fluid.md.
            pressure_tolerance: 1e-3,
            position_tolerance: 5e-2,
            position_limit: 0.1,
            lost_particles: LostParticles::Refused,
            pressure_iterations_limit: 1000,
            position_projection: true,
            corrected_gradient: true,
            surface_offset: true,
            tearing: Tearing::AtSurface,
            tensile_limit: 0.0,
            shifting: ShiftingLaw::Concentration,
            shifting_coefficient: 0.5,
            shifting_limit: 0.2,
            interface_shifting: false,
            taylor_correction: false,
            viscosity_operator: ViscousOperator::MonaghanGingold,
            smagorinsky: 0.1,
            artificial_viscosity: 0.02,
            no_slip_walls: false,
            no_slip_structure: false,
            contact_distance: 0.25,
            courant: 0.2,
            time_step_growth: 1.2,
            reference_velocity: None,
            compliance: true,
            structure_velocity: StructureVelocity::Mean,
            load: Load::Transpose,
        }
    }
}

impl Options {
    /// The paper's choices throughout, its slips mended: thresholds 1.4/1.6, shifting by Eqs. (21)–(24) with
    /// `C = 0.04`, Eqs. (27)–(32), Eq. (13), `c_s = 0.1`, `Cr = 0.1`. It does not hold a hydrostatic tank
    /// (see `docs/fluid.md`).
    pub fn paper() -> Self {
        Self {
            scheme: Scheme::Paper,
            surface_thresholds: (0.7, 0.8),
            surface_hysteresis: 0.0,
            pressure_stabilization: 1.0,
            position_projection: false,
            corrected_gradient: true,
            surface_offset: false,
            tearing: Tearing::Off,
            shifting: ShiftingLaw::Paper,
            shifting_coefficient: 0.04,
            interface_shifting: true,
            taylor_correction: true,
            viscosity_operator: ViscousOperator::FatehiManzari,
            smagorinsky: 0.1,
            artificial_viscosity: 0.0,
            courant: 0.1,
            load: Load::PressureGradient,
            ..Self::default()
        }
    }
}
