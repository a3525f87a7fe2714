//! What ISPH remembers from step to step, and its state as bytes.

use crate::error::Error;
use crate::isph::pressure::hierarchy::Hierarchy;
use crate::particles::class::SurfaceClass;
use crate::particles::state::{self, sieve};
use sph::Vector;
use words::bytes::{Reader, Writer};

/// The fluid's state with what ISPH remembers.
pub type State<const D: usize> = state::State<D, Memory<D>>;

/// What ISPH remembers besides its particles, one entry each in the arrays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory<const D: usize> {
    /// Acceleration (m/s²) by pressure in the last step, from which the surface offset is taken.
    pub pressure_accelerations: Vec<Vector<D>>,
    /// Unknowns (Pa s², as a pressure over Δt²) of the last position projection: where the next one starts.
    pub position_potentials: Vec<f64>,
    /// Energy (J) by which the fluid stands above the least that it had so far, works of walls and structure
    /// taken out: what [`velocity_correction`](crate::isph::pressure::velocity_correction) has given it too
    /// much.
    pub energy_excess: f64,
    /// The preconditioner that the next step takes; a new one where there is none.
    pub hierarchy: Option<Hierarchy<D>>,
}

const MAGIC: &[u8; 8] = b"mnscflu5";

impl<const D: usize> State<D> {
    /// Particles at rest or moving, without pressure.
    pub fn new(positions: Vec<Vector<D>>, velocities: Vec<Vector<D>>) -> Self {
        let count = positions.len();
        let memory = Memory {
            pressure_accelerations: vec![Vector::zeros(); count],
            position_potentials: vec![0.0; count],
            ..Memory::default()
        };
        Self::at_start(positions, velocities, memory)
    }

    /// Makes `self` equal to `other`, allocations used again.
    pub fn copy_from(&mut self, other: &Self) {
        self.copy_particles(other);
        let (memory, others) = (&mut self.memory, &other.memory);
        memory.pressure_accelerations.clone_from(&others.pressure_accelerations);
        memory.position_potentials.clone_from(&others.position_potentials);
        memory.energy_excess = others.energy_excess;
        memory.hierarchy.clone_from(&others.hierarchy);
    }

    /// Keeps the particles for which `keep` holds, in their order. A hierarchy of others serves no longer.
    pub fn retain(&mut self, keep: &[bool]) {
        self.retain_particles(keep);
        sieve(&mut self.memory.pressure_accelerations, keep);
        sieve(&mut self.memory.position_potentials, keep);
        self.memory.hierarchy = None;
    }

    /// The state as bytes: a restart from them is identical to the bit.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut state = Writer::new(MAGIC);
        state.usize(D);
        state.usize(self.len());
        state.u64(self.left);
        state.u64(self.lost);
        state.f64(self.last_dt);
        state.f64(self.memory.energy_excess);
        state.u32s(&self.ids);
        state.list(&self.classes, |state, class| state.u8(*class as u8));
        for field in [&self.positions, &self.velocities, &self.memory.pressure_accelerations] {
            state.vectors(field);
        }
        state.f64s(&self.pressures);
        state.f64s(&self.memory.position_potentials);
        state.option(self.memory.hierarchy.as_ref(), |state, hierarchy| hierarchy.write(state));
        state.finish()
    }

    /// The state that [`to_bytes`](Self::to_bytes) wrote.
    ///
    /// # Errors
    /// [`Error::Restore`] when the bytes are not such a state, of another dimension, or cut off.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let mut state = Reader::new("fluid's state", MAGIC, bytes)?;
        let dimension = state.usize("dimension")?;
        if dimension != D {
            return Err(state.refuse("particles", format!("{dimension}-dimensional ones")).into());
        }
        let count = state.usize("particles")?;
        let (left, lost) = (state.u64("particles that left")?, state.u64("particles lost")?);
        let (last_dt, energy_excess) = (state.f64("last step")?, state.f64("energy excess")?);
        let ids = state.u32s("numbers", Some(count))?;
        let classes = SurfaceClass::read(&mut state, "classes", count)?;
        let positions = state.vectors("positions", Some(count))?;
        let velocities = state.vectors("velocities", Some(count))?;
        let pressure_accelerations = state.vectors("pressure accelerations", Some(count))?;
        let pressures = state.f64s("pressures", Some(count))?;
        let memory = Memory {
            pressure_accelerations,
            position_potentials: state.f64s("position potentials", Some(count))?,
            energy_excess,
            hierarchy: state.option("preconditioner", |state| Hierarchy::read(state, count))?,
        };
        state.finish()?;
        Ok(Self { ids, positions, velocities, pressures, classes, last_dt, left, lost, memory })
    }
}
