//! Choices of the method: the default is the energy-consistent recipe, the paper's steps are options.

/// Which projection moves the fluid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Gradient as the negative transpose of the divergence, `A = D M⁻¹ Dᵀ + S`: projection cannot add
    /// kinetic energy.
    EnergyConsistent,
    /// The paper's: compact Laplacian of Eq. (15) without its `B` (symmetric), velocity correction of Eq.
    /// (18) with `B`.
    Paper,
}

/// Discrete Laplacian of the velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViscousOperator {
    /// Morris, Fox and Zhu 1997: symmetric, so it conserves momentum and only dissipates.
    Morris,
    /// The paper's Eqs. (4), (6), (7), (13): Fatehi and Manzari 2012, exact for quadratic fields, neither
    /// symmetric nor surely dissipative.
    FatehiManzari,
}

/// Where particles are shifted to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShiftingLaw {
    /// Down the concentration gradient (Lind et al. 2012).
    Concentration,
    /// The paper's Eqs. (21)–(23) (Xu et al. 2009).
    Paper,
    /// None.
    Off,
}

/// Where fluid that would be pulled, its pressure below that of the surface, is torn instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tearing {
    /// Nowhere: it bears any tension.
    Off,
    /// Where air can come in: with the surface, or torn fluid, within reach.
    AtSurface,
    /// Wherever there is a surface at all: in cavities, too, that have closed.
    Everywhere,
}

/// Load on the structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// Transpose of the divergence through which the structure's velocity enters: equal and opposite by
    /// construction.
    Transpose,
    /// The paper's Eq. (48): pressure gradient over fluid and structure, `p = 0` on dry structure particles.
    PressureGradient,
}

/// Which velocity of the structure the fluid meets over a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StructureVelocity {
    /// Its mean over the step, the displacement over Δt: a force held over the step changes it by half of
    /// `Δt F/m`.
    Mean,
    /// That at the step's end, which the force changes by `Δt F/m`.
    End,
}

impl StructureVelocity {
    /// Share of `Δt F/m` by which a force held over a step changes this velocity of a free particle.
    pub fn compliance(self) -> f64 {
        match self {
            Self::Mean => 0.5,
            Self::End => 1.0,
        }
    }
}

/// How the conjugate gradients are preconditioned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preconditioner {
    /// The operator's diagonal.
    Jacobi,
    /// Algebraic multigrid on the compact Laplacian.
    Multigrid,
}

/// All choices of the method. Lengths and velocities are in units of the spacing or derived from the case, so
/// that one set serves all resolutions.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Projection.
    pub scheme: Scheme,
    /// `h/Δx` (the paper's 1.2).
    pub smoothing_ratio: f64,
    /// `∇·r/D` up to which a particle is on the surface (α = 0) and from which on it is inside (α = 1), Eq.
    /// (17). The paper has 0.7 and 0.8.
    pub surface_thresholds: (f64, f64),
    /// How far `∇·r/D` of a particle that was not on the surface has to fall below the first threshold until
    /// it is ([`surface`](crate::isph::surface::detection)).
    pub surface_hysteresis: f64,
    /// Share of the compact Laplacian added to `D M⁻¹ Dᵀ` (it is blind to checkerboards).
    pub laplacian_share: f64,
    /// Compressibility κ of the fluid in units of `1/(ρΔx²)`: keeps the operator regular.
    pub regularisation: f64,
    /// The same for pockets of fluid without a particle of known pressure.
    pub pocket_regularisation: f64,
    /// Preconditioner of the pressure solves.
    pub preconditioner: Preconditioner,
    /// Relative residual of the pressure solve: by the default 1e-3 it leaves a three-hundredth of the
    /// density error that the position projection keeps (`docs/fluid.md`).
    pub pressure_tolerance: f64,
    /// Relative residual of the position projection.
    pub position_tolerance: f64,
    /// Iterations after which a solve has failed.
    pub iteration_limit: usize,
    /// Whether the density error is taken back by a projection of positions.
    pub position_projection: bool,
    /// Blend of the corrected gradient of Eq. (18) into the symmetric one, as far as energy allows
    /// (energy-consistent scheme only).
    pub corrected_gradient: bool,
    /// Pressure of the layer outside particles on and near the surface
    /// ([`surface_offset`](crate::isph::surface::surface_offset)).
    pub surface_offset: bool,
    /// Where fluid that would be pulled is torn ([`tearing`](crate::isph::surface::tearing)).
    pub tearing: Tearing,
    /// Shifting law.
    pub shifting: ShiftingLaw,
    /// Shifting coefficient: times `2h u Δt` of [`ShiftingLaw::Concentration`], the paper's `C` of
    /// [`ShiftingLaw::Paper`].
    pub shifting_coefficient: f64,
    /// Largest shift in units of `h`.
    pub shifting_limit: f64,
    /// Relocation next to the structure, Eqs. (27)–(30).
    pub interface_shifting: bool,
    /// Taylor correction of velocity and pressure after shifting, Eqs. (20), (31), (32).
    pub taylor_correction: bool,
    /// Viscous operator.
    pub viscous_operator: ViscousOperator,
    /// Smagorinsky constant of the sub-particle-scale viscosity, Eq. (10); zero switches it off. The paper
    /// has 0.1.
    pub smagorinsky: f64,
    /// Added viscosity between approaching particles in units of `h` times the reference velocity.
    pub approach_viscosity: f64,
    /// Whether walls hold the fluid's tangential velocity back.
    pub no_slip_walls: bool,
    /// Whether the structure holds the fluid's tangential velocity back.
    pub no_slip_structure: bool,
    /// Distance from a wall's or the structure's surface in units of `Δx` below which no particle may come.
    pub contact_distance: f64,
    /// `Δt ≤ courant · h/u_max` (the paper's Eq. (49) has 0.1).
    pub courant: f64,
    /// `Δt` grows at most by this factor a step.
    pub growth: f64,
    /// Velocity (m/s) that stands for the flow's scale while it is slow; `√(gH)` of the initial fluid when
    /// none is given.
    pub reference_velocity: Option<f64>,
    /// Whether the structure's own compliance enters the pressure operator; without it the structure is a
    /// moving wall.
    pub compliance: bool,
    /// Which velocity of the structure the interface brings.
    pub structure_velocity: StructureVelocity,
    /// Load on the structure.
    pub load: Load,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            scheme: Scheme::EnergyConsistent,
            smoothing_ratio: 1.2,
            surface_thresholds: (0.8, 0.9),
            surface_hysteresis: 0.04,
            laplacian_share: 0.1,
            regularisation: 1e-6,
            pocket_regularisation: 1e-2,
            preconditioner: Preconditioner::Multigrid,
            pressure_tolerance: 1e-3,
            position_tolerance: 5e-2,
            iteration_limit: 1000,
            position_projection: true,
            corrected_gradient: true,
            surface_offset: true,
            tearing: Tearing::Off,
            shifting: ShiftingLaw::Concentration,
            shifting_coefficient: 0.5,
            shifting_limit: 0.2,
            interface_shifting: false,
            taylor_correction: false,
            viscous_operator: ViscousOperator::Morris,
            smagorinsky: 0.1,
            approach_viscosity: 0.02,
            no_slip_walls: false,
            no_slip_structure: false,
            contact_distance: 0.25,
            courant: 0.2,
            growth: 1.2,
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
            laplacian_share: 1.0,
            position_projection: false,
            corrected_gradient: true,
            surface_offset: false,
            shifting: ShiftingLaw::Paper,
            shifting_coefficient: 0.04,
            interface_shifting: true,
            taylor_correction: true,
            viscous_operator: ViscousOperator::FatehiManzari,
            smagorinsky: 0.1,
            approach_viscosity: 0.0,
            courant: 0.1,
            load: Load::PressureGradient,
            ..Self::default()
        }
    }
}
