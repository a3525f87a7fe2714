//! The particles of a setup as flat arrays: what every method moves, and what loads and probes refer to.

use crate::error::SetupError;
use crate::setup::Setup;
use crate::state::State;
use sph::Vector;

/// The particles of all bodies, in the setup's order, in the reference configuration. Nothing of it changes
/// in a run.
#[derive(Clone, Debug)]
pub struct Particles<const D: usize> {
    /// The setup that they were made of.
    pub setup: Setup<D>,
    /// Reference positions `X` (m).
    pub reference_positions: Vec<Vector<D>>,
    /// Reference volumes `V` (m³).
    pub volumes: Vec<f64>,
    /// Reference densities `ρ_s` (kg/m³).
    pub densities: Vec<f64>,
    /// Masses `ρ_s V` (kg).
    pub masses: Vec<f64>,
    /// Which particles are fixed: they stay, or move by a law of the setup.
    pub clamped: Vec<bool>,
    /// The particles that are not fixed, ascending.
    pub free: Vec<u32>,
    /// The interface particles: all that have a volume, fixed or not, ascending. Loads of the fluid come in
    /// this order; on fixed ones the clamp bears them.
    pub interface: Vec<u32>,
}

impl<const D: usize> Particles<D> {
    /// Checks the setup and lines up its particles.
    ///
    /// # Errors
    /// All mistakes of the setup.
    pub fn new(setup: Setup<D>) -> Result<Self, SetupError> {
        setup.check()?;
        let bodies = &setup.bodies;
        let volumes: Vec<f64> = bodies.iter().flat_map(|b| b.volumes.iter().copied()).collect();
        let clamped: Vec<bool> = bodies.iter().flat_map(|b| b.clamped.iter().copied()).collect();
        let densities: Vec<f64> =
            bodies.iter().flat_map(|b| std::iter::repeat_n(b.density, b.positions.len())).collect();
        Ok(Self {
            reference_positions: bodies.iter().flat_map(|b| b.positions.iter().copied()).collect(),
            masses: densities.iter().zip(&volumes).map(|(density, volume)| density * volume).collect(),
            free: (0..clamped.len() as u32).filter(|&i| !clamped[i as usize]).collect(),
            interface: (0..clamped.len() as u32).filter(|&i| volumes[i as usize] > 0.0).collect(),
            volumes,
            densities,
            clamped,
            setup,
        })
    }

    /// Number of particles, fixed ones included.
    pub fn len(&self) -> usize {
        self.reference_positions.len()
    }

    /// Whether there are no particles (there always are).
    pub fn is_empty(&self) -> bool {
        self.reference_positions.is_empty()
    }

    /// Whether any fixed particle moves by a law.
    pub fn clamps_move(&self) -> bool {
        !self.setup.motions.is_empty()
    }

    /// Calls `place(particle, displacement, velocity)` (m, m/s) for each fixed particle that moves by a law,
    /// with what the law says at a time (s).
    pub fn follow_clamps(&self, time: f64, mut place: impl FnMut(usize, Vector<D>, Vector<D>)) {
        for moving in &self.setup.motions {
            let (pose, twist) = (moving.motion.pose(time), moving.motion.twist(time));
            for &particle in &moving.particles {
                let reference = self.reference_positions[particle];
                let moved = pose.moved(&reference);
                place(particle, moved - reference, twist.at(&moved));
            }
        }
    }

    /// Puts the fixed particles that move by a law where it says at a state's time.
    pub fn put_clamps(&self, state: &mut State<D>) {
        self.follow_clamps(state.time, |particle, displacement, velocity| {
            state.positions[particle] = self.reference_positions[particle] + displacement;
            state.velocities[particle] = velocity;
        });
    }

    /// Momentum (kg m/s) of the free particles.
    pub fn momentum(&self, velocities: &[Vector<D>]) -> Vector<D> {
        self.free().fold(Vector::zeros(), |sum, i| sum + velocities[i] * self.masses[i])
    }

    /// Potential energy (J) of the free particles in the setup's gravity, zero at the origin.
    pub fn potential_energy(&self, positions: &[Vector<D>]) -> f64 {
        self.free().map(|i| -self.masses[i] * self.setup.gravity.dot(&positions[i])).sum()
    }

    /// Displacements `U` (m).
    pub fn displacements(&self, positions: &[Vector<D>]) -> Vec<Vector<D>> {
        positions.iter().zip(&self.reference_positions).map(|(x, reference)| x - reference).collect()
    }

    fn free(&self) -> impl Iterator<Item = usize> + '_ {
        self.free.iter().map(|&i| i as usize)
    }
}
