//! What a step reports: solves, energy, momentum, volume.

use sph::Vector;

/// What a solve did. Whether a residual above the tolerance is acceptable is the caller's to decide.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Iterations taken, one application of the operator each (and one more for a start that is not zero).
    pub iterations: usize,
    /// `‖b − A x‖ / ‖b‖` as the recurrence carries it; zero where `b` is zero. Not finite if the operator,
    /// the preconditioner or the right-hand side was not.
    pub residual: f64,
    /// Whether the residual met the tolerance.
    pub converged: bool,
}

/// Report of a step; what a method does not have stays zero. Energies in J, impulses and momenta in kg m/s,
/// of one metre of depth in two dimensions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepReport<const D: usize> {
    /// Length of the step (s).
    pub dt: f64,
    /// The solve of implicit viscosity; nothing where it was explicit.
    pub viscous_solve: Outcome,
    /// The pressure solve.
    pub pressure_solve: Outcome,
    /// The position projection's solve.
    pub position_solve: Outcome,
    /// θ: share of Eq. (18) that energy allowed.
    pub gradient_share: f64,
    /// Kinetic energy at the end, of the particles that stay.
    pub kinetic_energy: f64,
    /// Potential energy `−m g·r` at the end, of the particles that stay.
    pub potential_energy: f64,
    /// Kinetic and potential energy that particles took along which left or were lost; and potential energy
    /// by which particles seem to rise or fall that pass a periodic side.
    pub left_energy: f64,
    /// Change of kinetic and potential energy over the step, with what left: `left_energy` and the changes of
    /// the two.
    pub energy_change: f64,
    /// Work of the structure's load on the fluid, with the velocity that it comes to have under it.
    pub structure_work: f64,
    /// Work of walls that move.
    pub wall_work: f64,
    /// Work of viscosity: not positive.
    pub viscous_work: f64,
    /// Change of kinetic energy by contact with walls and structure.
    pub contact_work: f64,
    /// Part of it that a moving structure or wall gave.
    pub contact_structure_work: f64,
    /// Potential energy by displacements that are not the velocity's: position projection, shifting, and what
    /// contact kept back.
    pub displacement_work: f64,
    /// What is left of `energy_change` when all works above are taken out: projection and time integration.
    pub projection_work: f64,
    /// Momentum at the end.
    pub momentum: Vector<D>,
    /// Momentum that the structure gave, `Δt Σ V_s R_s`.
    pub structure_impulse: Vector<D>,
    /// Momentum that the walls gave, by pairs of fluid and wall and by contact.
    pub wall_impulse: Vector<D>,
    /// Change of momentum that gravity, structure and those pairs do not explain: Eq. (18) does not conserve
    /// it. Forces on walls hold it ([`WallForces::lay`](crate::isph::interface_load::WallForces::lay)).
    pub momentum_error: Vector<D>,
    /// Mean of `(n − n₀)/n₀` over interior particles: the volume drift with its sign turned.
    pub mean_density_error: f64,
    /// Its largest magnitude.
    pub largest_density_error: f64,
    /// Largest speed (m/s).
    pub max_speed: f64,
    /// Largest shift (m).
    pub largest_shift: f64,
    /// Particles at the end.
    pub particles: usize,
    /// Particles without fluid neighbours.
    pub splashes: usize,
    /// Particles in pockets without a surface.
    pub pocket_particles: usize,
    /// Particles that would be pulled and were torn.
    pub torn: usize,
    /// Particles that left the domain so far.
    pub left: u64,
    /// Particles lost so far.
    pub lost: u64,
    /// The first that was lost in this step, by number, and where (m).
    pub first_lost: Option<(u32, Vector<D>)>,
}

impl<const D: usize> Default for StepReport<D> {
    fn default() -> Self {
        Self {
            dt: 0.0,
            viscous_solve: Outcome::default(),
            pressure_solve: Outcome::default(),
            position_solve: Outcome::default(),
            gradient_share: 0.0,
            kinetic_energy: 0.0,
            potential_energy: 0.0,
            left_energy: 0.0,
            energy_change: 0.0,
            structure_work: 0.0,
            wall_work: 0.0,
            viscous_work: 0.0,
            contact_work: 0.0,
            contact_structure_work: 0.0,
            displacement_work: 0.0,
            projection_work: 0.0,
            momentum: Vector::zeros(),
            structure_impulse: Vector::zeros(),
            wall_impulse: Vector::zeros(),
            momentum_error: Vector::zeros(),
            mean_density_error: 0.0,
            largest_density_error: 0.0,
            max_speed: 0.0,
            largest_shift: 0.0,
            particles: 0,
            splashes: 0,
            pocket_particles: 0,
            torn: 0,
            left: 0,
            lost: 0,
            first_lost: None,
        }
    }
}
