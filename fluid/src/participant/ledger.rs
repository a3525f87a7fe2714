//! Balances of the fluid since the start: works and impulses summed over the accepted steps, and the state's
//! own figures.

use crate::particles::state::State;
use crate::properties::FluidProperties;
use crate::report::StepReport;
use interfaces::port::names;
use sph::Vector;
use words::bytes::{Error, Reader, Writer};

/// Figures of an accepted state, in the order of [`Ledger::NAMES`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger {
    figures: [f64; Ledger::NAMES.len()],
}

/// Places in [`Ledger::NAMES`].
mod at {
    pub const KINETIC: usize = 0;
    pub const POTENTIAL: usize = 1;
    pub const STRUCTURE_WORK: usize = 2;
    pub const WALL_WORK: usize = 3;
    pub const VISCOUS_WORK: usize = 4;
    pub const CONTACT_WORK: usize = 5;
    pub const PROJECTION_WORK: usize = 6;
    pub const VOLUME_DRIFT: usize = 7;
    pub const DENSITY_ERROR: usize = 8;
    pub const MAX_SPEED: usize = 9;
    pub const MAX_PRESSURE: usize = 10;
    pub const PARTICLES: usize = 11;
    pub const SPLASHES: usize = 12;
    pub const LEFT: usize = 13;
    pub const LOST: usize = 14;
    pub const PRESSURE_ITERATIONS: usize = 15;
    pub const PRESSURE_RESIDUAL: usize = 16;
    pub const POSITION_ITERATIONS: usize = 17;
    pub const DISPLACEMENT_WORK: usize = 18;
    pub const LEFT_ENERGY: usize = 19;
}

impl Ledger {
    /// Names, units and meanings of its columns.
    pub const NAMES: [(&'static str, &'static str, &'static str); 20] = [
        (names::KINETIC_ENERGY, "J", "kinetic energy"),
        (names::POTENTIAL_ENERGY, "J", "potential energy of gravity"),
        ("structure_work", "J", "work of the structure on the fluid since the start"),
        ("wall_work", "J", "work of moving walls on the fluid since the start"),
        ("viscous_work", "J", "work of viscous forces since the start"),
        ("contact_work", "J", "work of contact with walls and structure since the start"),
        ("projection_work", "J", "energy that the pressure projection took since the start"),
        (names::VOLUME_DRIFT, "1", "mean change of volume over the volume at the start"),
        ("largest_density_error", "1", "largest error of the density over the density"),
        ("max_speed", "m/s", "greatest speed of a particle"),
        ("max_pressure", "Pa", "greatest pressure"),
        ("particles", "1", "particles in the domain"),
        ("splashes", "1", "particles that fly alone"),
        (names::PARTICLES_LEFT, "1", "particles that left the domain since the start"),
        (names::PARTICLES_LOST, "1", "particles lost in walls or structure since the start"),
        ("pressure_iterations", "1", "iterations of the pressure solve"),
        ("pressure_residual", "1", "residual of the pressure solve over its right-hand side"),
        ("position_iterations", "1", "iterations of the position projection"),
        (
            "displacement_work",
            "J",
            "potential energy by position projection, shifting and contact since the start",
        ),
        (names::LEFT_ENERGY, "J", "energy that left with particles, or by periodic sides, since the start"),
    ];

    /// The figures of the initial state.
    pub fn at_start<const D: usize, M>(properties: &FluidProperties<D>, state: &State<D, M>) -> Self {
        let mut ledger = Self::default();
        let (mass, gravity) = (properties.particle_mass(), properties.gravity);
        let f = &mut ledger.figures;
        f[at::KINETIC] = state.velocities.iter().map(|u| 0.5 * mass * u.norm_squared()).sum();
        f[at::POTENTIAL] = state.positions.iter().map(|r| -mass * gravity.dot(r)).sum();
        f[at::MAX_SPEED] = state.velocities.iter().map(Vector::norm).fold(0.0, f64::max);
        f[at::MAX_PRESSURE] = state.pressures.iter().copied().fold(0.0, f64::max);
        f[at::PARTICLES] = state.len() as f64;
        ledger
    }

    /// The figures after one more step, which led to `state`.
    pub fn after<const D: usize, M>(&self, step: &StepReport<D>, state: &State<D, M>) -> Self {
        let mut next = self.clone();
        let f = &mut next.figures;
        f[at::KINETIC] = step.kinetic_energy;
        f[at::POTENTIAL] = step.potential_energy;
        f[at::STRUCTURE_WORK] += step.structure_work;
        f[at::WALL_WORK] += step.wall_work;
        f[at::VISCOUS_WORK] += step.viscous_work;
        f[at::CONTACT_WORK] += step.contact_work;
        f[at::PROJECTION_WORK] += step.projection_work;
        // A volume that grew shows as a density that fell.
        f[at::VOLUME_DRIFT] = -step.mean_density_error;
        f[at::DENSITY_ERROR] = step.largest_density_error;
        f[at::MAX_SPEED] = step.max_speed;
        f[at::MAX_PRESSURE] = state.pressures.iter().copied().fold(0.0, f64::max);
        f[at::PARTICLES] = state.len() as f64;
        f[at::SPLASHES] = step.splashes as f64;
        f[at::LEFT] = state.left as f64;
        f[at::LOST] = state.lost as f64;
        f[at::PRESSURE_ITERATIONS] = step.pressure_solve.iterations as f64;
        f[at::PRESSURE_RESIDUAL] = step.pressure_solve.residual;
        f[at::POSITION_ITERATIONS] = step.position_solve.iterations as f64;
        f[at::DISPLACEMENT_WORK] += step.displacement_work;
        f[at::LEFT_ENERGY] += step.left_energy;
        next
    }

    /// The figures, in the order of the names.
    pub fn values(&self) -> Vec<f64> {
        self.figures.to_vec()
    }

    /// Writes the figures to a saved state.
    pub fn save(&self, state: &mut Writer) {
        state.f64s(&self.figures);
    }

    /// Reads what [`save`](Self::save) wrote.
    ///
    /// # Errors
    /// Bytes that are no such figures.
    pub fn restore(state: &mut Reader<'_>) -> Result<Self, Error> {
        let figures = state.f64s("balances", Some(Self::NAMES.len()))?;
        Ok(Self { figures: figures.try_into().expect("as many were asked for") })
    }
}
