//! The state of a structure: plain arrays, to keep, compare, send and restore.

use sph::Vector;
use words::bytes::{self, Reader, Writer};

const MAGIC: &[u8; 8] = b"mnscsol3";

/// Positions, velocities and energies at one time, particles in the order of the setup.
#[derive(Clone, Debug, PartialEq)]
pub struct State<const D: usize> {
    /// Time (s).
    pub time: f64,
    /// Positions `x` (m).
    pub positions: Vec<Vector<D>>,
    /// Velocities `u` (m/s); zero for clamped particles that stay.
    pub velocities: Vec<Vector<D>>,
    /// Energies.
    pub energy: Energy,
    /// How long the next sub-steps may be.
    pub stability: Stability,
    /// Springs of friction, by particle and partner, ascending.
    pub sticks: Vec<Stick<D>>,
}

/// The tangential spring by which a particle sticks to what it touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stick<const D: usize> {
    /// The particle.
    pub particle: u32,
    /// What it touches: a body, or after all bodies a wall.
    pub partner: u32,
    /// How far the spring is stretched (m).
    pub spring: Vector<D>,
}

impl<const D: usize> State<D> {
    /// The number of sub-steps in a window of length `dt` (s) from this state that stability asks for.
    pub fn stable_sub_steps(&self, dt: f64) -> usize {
        ((dt / (self.stability.step * STEP_TOLERANCE)).ceil() as usize).max(1)
    }

    /// The state as bytes, for a restart that is identical to the bit.
    pub fn to_bytes(&self) -> Vec<u8> {
        let Energy { kinetic, strain, contact, load_work, clamp_work, wall_work, dissipated, friction_loss } =
            self.energy;
        let Stability { strain: found_at, step } = self.stability;
        let mut state = Writer::new(MAGIC);
        state.usize(D);
        let works = [load_work, clamp_work, wall_work, dissipated, friction_loss];
        for number in [self.time, kinetic, strain, contact].into_iter().chain(works).chain([found_at, step]) {
            state.f64(number);
        }
        state.vectors(&self.positions);
        state.vectors(&self.velocities);
        state.usize(self.sticks.len());
        for stick in &self.sticks {
            state.usize(stick.particle as usize);
            state.usize(stick.partner as usize);
        }
        let springs: Vec<Vector<D>> = self.sticks.iter().map(|stick| stick.spring).collect();
        state.vectors(&springs);
        state.finish()
    }

    /// The state of `particles` particles that [`to_bytes`](Self::to_bytes) wrote.
    ///
    /// # Errors
    /// Bytes that are no such state.
    pub fn from_bytes(bytes: &[u8], particles: usize) -> Result<Self, bytes::Error> {
        let mut state = Reader::new("structure's state", MAGIC, bytes)?;
        let dimension = state.usize("dimension")?;
        if dimension != D {
            return Err(state.refuse("dimension", dimension.to_string()));
        }
        let mut read = Self {
            time: state.f64("time")?,
            energy: Energy {
                kinetic: state.f64("kinetic energy")?,
                strain: state.f64("strain energy")?,
                contact: state.f64("energy of contact")?,
                load_work: state.f64("load work")?,
                clamp_work: state.f64("clamp work")?,
                wall_work: state.f64("wall work")?,
                dissipated: state.f64("dissipated energy")?,
                friction_loss: state.f64("loss by friction")?,
            },
            stability: Stability {
                strain: state.f64("strain of the stable step")?,
                step: state.f64("stable step")?,
            },
            positions: state.vectors("positions", Some(particles))?,
            velocities: state.vectors("velocities", Some(particles))?,
            sticks: Vec::new(),
        };
        let count = state.usize("number of springs")?;
        let mut ends = Vec::new();
        for _ in 0..count {
            let (particle, partner) = (state.usize("particle that sticks")?, state.usize("what it touches")?);
            if particle >= particles || partner > u32::MAX as usize {
                return Err(state.refuse("particle that sticks", particle.to_string()));
            }
            ends.push((particle as u32, partner as u32));
        }
        let springs: Vec<Vector<D>> = state.vectors("springs", Some(count))?;
        let sticks = ends.into_iter().zip(springs);
        read.sticks =
            sticks.map(|((particle, partner), spring)| Stick { particle, partner, spring }).collect();
        state.finish()?;
        Ok(read)
    }
}

/// A sub-step may exceed the stable one by round-off of the division that made it.
pub(crate) const STEP_TOLERANCE: f64 = 1.0 + 1e-9;

/// The stable sub-step of a state, and the strain that it was found at: large strains stiffen the structure
/// or soften it. It is kept with the state, so that whatever is computed from a state depends on nothing
/// else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stability {
    /// Largest component of the Green–Lagrange strain, in magnitude, when `step` was found.
    pub strain: f64,
    /// Stable sub-step (s).
    pub step: f64,
}

/// Energies and works (J; in two dimensions for one metre of depth).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Kinetic energy of the free particles.
    pub kinetic: f64,
    /// Strain energy.
    pub strain: f64,
    /// Energy of contact: of what lies in each other, and of the springs of friction.
    pub contact: f64,
    /// Work that gravity, dead loads and the fluid's load have done since the start.
    pub load_work: f64,
    /// Work that clamps which move have done on the structure since the start. What acts on the fixed
    /// particles themselves they bear, and it is in neither work.
    pub clamp_work: f64,
    /// Work that walls which move have done on the structure since the start.
    pub wall_work: f64,
    /// Energy that damping has taken since the start.
    pub dissipated: f64,
    /// Energy that friction has taken since the start.
    pub friction_loss: f64,
}

impl Energy {
    /// `kinetic + strain + contact + dissipated + friction's loss − load work − clamp work − wall work`:
    /// constant up to the error of the time integration, for laws with a potential.
    pub fn balance(&self) -> f64 {
        self.kinetic + self.strain + self.contact + self.dissipated + self.friction_loss
            - self.load_work
            - self.clamp_work
            - self.wall_work
    }
}

/// What one call of [`crate::Solid::advance`] did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Sub-steps taken.
    pub sub_steps: usize,
    /// Their length (s).
    pub sub_step: f64,
}

/// Derived fields, particles in the order of the setup.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Derived<const D: usize> {
    /// Cauchy stress `σ` (Pa).
    pub cauchy_stress: Vec<sph::Matrix<D>>,
    /// Von Mises stress (Pa), with the stress out of the plane.
    pub von_mises: Vec<f64>,
    /// Strain energy per reference volume (J/m³).
    pub strain_energy_density: Vec<f64>,
    /// Deformation gradient `F`.
    pub deformation_gradient: Vec<sph::Matrix<D>>,
}
