//! Scales, energies, momenta and densities of the particles taken together.

use crate::boundaries::period::Period;
use crate::particles::neighbourhood::Neighbourhood;
use crate::particles::state::State;
use crate::properties::FluidProperties;
use crate::report::StepReport;
use sph::kernel::CubicSpline;
use sph::{Vector, parallel};

/// `√(gH)` of the initial fluid, and at least its largest speed; H is its extent along gravity.
pub fn reference_velocity<const D: usize, M>(properties: &FluidProperties<D>, initial: &State<D, M>) -> f64 {
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

/// Takes the particles that are not kept out of the energies at the end.
pub fn leave<const D: usize, M>(
    properties: &FluidProperties<D>,
    mass: f64,
    after: &State<D, M>,
    keep: &[bool],
    report: &mut StepReport<D>,
) {
    for a in (0..keep.len()).filter(|a| !keep[*a]) {
        let kinetic = 0.5 * mass * after.velocities[a].norm_squared();
        let potential = -mass * properties.gravity.dot(&after.positions[a]);
        report.kinetic_energy -= kinetic;
        report.potential_energy -= potential;
        report.left_energy += kinetic + potential;
    }
}

/// Energies and momenta at the end, and what is left of their changes.
pub fn balance<const D: usize, M: Sync>(
    properties: &FluidProperties<D>,
    period: &Period<D>,
    mass: f64,
    before: &State<D, M>,
    after: &State<D, M>,
    report: &mut StepReport<D>,
) {
    let kinetic = |s: &State<D, M>| 0.5 * mass * parallel::sum(s.len(), |a| s.velocities[a].norm_squared());
    let potential =
        |s: &State<D, M>| -mass * parallel::sum(s.len(), |a| properties.gravity.dot(&s.positions[a]));
    let momentum = |s: &State<D, M>| parallel::sum(s.len(), |a| s.velocities[a]) * mass;
    report.kinetic_energy = kinetic(after);
    report.potential_energy = potential(after);
    // By displacements: a particle that went through a periodic side has not lost its height.
    let displacement = |a: usize| period.nearest(after.positions[a] - before.positions[a]);
    let fallen = parallel::sum(before.len(), |a| properties.gravity.dot(&displacement(a)));
    report.energy_change = report.kinetic_energy - kinetic(before) - mass * fallen;
    if !period.is_none() {
        let passed =
            parallel::sum(before.len(), |a| displacement(a) - (after.positions[a] - before.positions[a]));
        report.left_energy = -mass * properties.gravity.dot(&passed);
    }
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

/// Mean and largest `(n − n₀)/n₀` over particles inside (`alpha` = 1).
pub fn density_errors<const D: usize>(
    neighbourhood: &Neighbourhood<D>,
    alpha: &[f64],
    lattice_concentration: f64,
) -> (f64, f64) {
    let inside = |a: usize| alpha[a] == 1.0;
    let error = |a: usize| {
        let sums = &neighbourhood.surroundings[a];
        if inside(a) { sums.concentration / lattice_concentration - 1.0 } else { 0.0 }
    };
    let count = alpha.len();
    let counted: usize = parallel::sum(count, |a| usize::from(inside(a)));
    let mean = parallel::sum(count, error) / counted.max(1) as f64;
    (mean, parallel::max(count, 0.0, |a| error(a).abs()))
}
