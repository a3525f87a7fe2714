//! What a step reports: solves, energy, momentum, volume.

use crate::boundaries::period::Period;
use crate::isph::pressure::conjugate_gradients::Outcome;
use crate::isph::solver::FluidProperties;
use crate::isph::state::State;
use crate::isph::surface::detection::Surface;
use crate::particles::neighbourhood::Neighbourhood;
use sph::kernel::CubicSpline;
use sph::{Vector, parallel};

/// Report of a step. Energies in J, impulses and momenta in kg m/s, of one metre of depth in two dimensions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepReport<const D: usize> {
    /// Length of the step (s).
    pub dt: f64,
    /// The pressure solve.
    pub pressure_solve: Outcome,
    /// The position projection's solve.
    pub position_solve: Outcome,
    /// θ: share of Eq. (18) that energy allowed.
    pub gradient_share: f64,
    /// Kinetic energy at the end.
    pub kinetic_energy: f64,
    /// Potential energy `−m g·r` at the end.
    pub potential_energy: f64,
    /// Change of kinetic and potential energy over the step, particles that left not counted out.
    pub energy_change: f64,
    /// Work of the structure's pressure on the fluid, with its velocity halfway through the projection,
    /// `½(u*_s + u_s)`.
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
}

impl<const D: usize> Default for StepReport<D> {
    fn default() -> Self {
        Self {
            dt: 0.0,
            pressure_solve: Outcome::default(),
            position_solve: Outcome::default(),
            gradient_share: 0.0,
            kinetic_energy: 0.0,
            potential_energy: 0.0,
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
        }
    }
}

/// `√(gH)` of the initial fluid, and at least its largest speed; H is its extent along gravity.
pub fn reference_velocity<const D: usize>(properties: &FluidProperties<D>, initial: &State<D>) -> f64 {
    let g = properties.gravity.norm();
    let mut extent = (f64::INFINITY, f64::NEG_INFINITY);
    for r in &initial.positions {
        let height = if g > 0.0 { -r.dot(&properties.gravity) / g } else { 0.0 };
        extent = (extent.0.min(height), extent.1.max(height));
    }
    let depth = if initial.is_empty() { 0.0 } else { extent.1 - extent.0 + properties.spacing };
    let fastest = initial.velocities.iter().map(Vector::norm).fold(0.0, f64::max);
    (g * depth).sqrt().max(fastest)
}

/// `n₀ = Σ V W` on the lattice of spacing Δx.
pub fn lattice_concentration<const D: usize>(kernel: &CubicSpline<D>, spacing: f64) -> f64 {
    let reach = (kernel.support() / spacing).ceil() as i64;
    let side = 2 * reach + 1;
    let sum: f64 = (0..side.pow(D as u32))
        .map(|mut n| {
            let offset: Vector<D> = Vector::from_fn(|_, _| {
                let k = n % side - reach;
                n /= side;
                k as f64 * spacing
            });
            kernel.value(offset.norm())
        })
        .sum();
    sum * spacing.powi(D as i32)
}

/// Energies and momenta at the end, and what is left of their changes.
pub fn balance<const D: usize>(
    properties: &FluidProperties<D>,
    period: &Period<D>,
    mass: f64,
    before: &State<D>,
    after: &State<D>,
    report: &mut StepReport<D>,
) {
    let kinetic = |s: &State<D>| 0.5 * mass * parallel::sum(s.len(), |a| s.velocities[a].norm_squared());
    let potential =
        |s: &State<D>| -mass * parallel::sum(s.len(), |a| properties.gravity.dot(&s.positions[a]));
    let momentum = |s: &State<D>| parallel::sum(s.len(), |a| s.velocities[a]) * mass;
    report.kinetic_energy = kinetic(after);
    report.potential_energy = potential(after);
    // By displacements: a particle that went through a periodic side has not lost its height.
    let displacement = |a: usize| period.nearest(after.positions[a] - before.positions[a]);
    let fallen = parallel::sum(before.len(), |a| properties.gravity.dot(&displacement(a)));
    report.energy_change = report.kinetic_energy - kinetic(before) - mass * fallen;
    report.projection_work = report.energy_change
        - report.structure_work
        - report.wall_work
        - report.viscous_work
        - report.contact_work
        - report.displacement_work;
    report.momentum = momentum(after);
    report.momentum_error =
        report.momentum - momentum(before) - properties.gravity * (mass * before.len() as f64 * report.dt);
    report.max_speed = parallel::max(after.len(), 0.0, |a| after.velocities[a].norm());
}

/// Mean and largest `(n − n₀)/n₀` over particles inside (α = 1).
pub fn density_errors<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    surface: &Surface<D>,
    lattice_concentration: f64,
) -> (f64, f64) {
    let inside = |a: usize| surface.alpha[a] == 1.0;
    let error = |a: usize| {
        let sums = &neighbourhood.surroundings[a];
        if inside(a) { sums.concentration / lattice_concentration - 1.0 } else { 0.0 }
    };
    let count = surface.alpha.len();
    let counted: usize = parallel::sum(count, |a| usize::from(inside(a)));
    let mean = parallel::sum(count, error) / counted.max(1) as f64;
    (mean, parallel::max(count, 0.0, |a| error(a).abs()))
}
