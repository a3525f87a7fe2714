//! The fluid's state between two steps: all that the next step depends on, the solver's memory included.

use crate::Error;
use crate::hierarchy::Hierarchy;
use sph::Vector;
use words::bytes::{Reader, Writer};

/// What a particle is by its surroundings (the paper's Fig. 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum SurfaceClass {
    /// Surrounded.
    #[default]
    Interior = 0,
    /// Within `h` of a surface particle.
    NearSurface = 1,
    /// On the surface: its pressure is known.
    Surface = 2,
    /// Without fluid neighbours: flies freely.
    Splash = 3,
    /// Within the fluid, but without pressure, since it would be pulled ([`tearing`](crate::tearing)).
    Torn = 4,
}

impl SurfaceClass {
    /// The classes of so many particles in a saved state.
    pub fn read(
        state: &mut Reader,
        field: &'static str,
        particles: usize,
    ) -> Result<Vec<Self>, words::bytes::Error> {
        let all = [Self::Interior, Self::NearSurface, Self::Surface, Self::Splash, Self::Torn];
        state.list(field, Some(particles), |state| {
            state.tag(field, |byte| all.get(usize::from(byte)).copied())
        })
    }
}

/// Everything the next step depends on. Particle `i` is the same in all arrays; a step may remove particles
/// and rearrange them (see [`order`](crate::order)), never add any.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State<const D: usize> {
    /// Number of each particle in the initial state, which stays with it.
    pub ids: Vec<u32>,
    /// Positions (m).
    pub positions: Vec<Vector<D>>,
    /// Velocities (m/s).
    pub velocities: Vec<Vector<D>>,
    /// Pressures (Pa), those of the step that led here.
    pub pressures: Vec<f64>,
    /// Class by surroundings at the start of the step that led here.
    pub classes: Vec<SurfaceClass>,
    /// Acceleration (m/s²) by pressure in that step, from which the surface offset is taken.
    pub pressure_accelerations: Vec<Vector<D>>,
    /// Unknowns (Pa s², as a pressure over Δt²) of the last position projection: where the next one starts.
    pub position_potentials: Vec<f64>,
    /// Length (s) of the step that led here; zero at the start.
    pub last_dt: f64,
    /// Energy (J) by which the fluid stands above the least that it had so far, works of walls and structure
    /// taken out: what [`velocity_correction`](crate::velocity_correction) has given it too much.
    pub energy_excess: f64,
    /// The preconditioner that the next step takes; a new one where there is none.
    pub hierarchy: Option<Hierarchy<D>>,
    /// Particles that left the domain so far.
    pub left: u64,
    /// Particles lost inside walls or structure so far: zero in a sound run.
    pub lost: u64,
}

const MAGIC: &[u8; 8] = b"mnscflu5";

impl<const D: usize> State<D> {
    /// Particles at rest or moving, without pressure.
    pub fn new(positions: Vec<Vector<D>>, velocities: Vec<Vector<D>>) -> Self {
        assert_eq!(positions.len(), velocities.len(), "a velocity a particle");
        let count = positions.len();
        Self {
            ids: (0..count as u32).collect(),
            positions,
            velocities,
            pressures: vec![0.0; count],
            classes: vec![SurfaceClass::Interior; count],
            pressure_accelerations: vec![Vector::zeros(); count],
            position_potentials: vec![0.0; count],
            last_dt: 0.0,
            energy_excess: 0.0,
            hierarchy: None,
            left: 0,
            lost: 0,
        }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether no particle is left.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Makes `self` equal to `other`, memory used again.
    pub fn copy_from(&mut self, other: &Self) {
        self.ids.clone_from(&other.ids);
        self.positions.clone_from(&other.positions);
        self.velocities.clone_from(&other.velocities);
        self.pressures.clone_from(&other.pressures);
        self.classes.clone_from(&other.classes);
        self.pressure_accelerations.clone_from(&other.pressure_accelerations);
        self.position_potentials.clone_from(&other.position_potentials);
        (self.last_dt, self.energy_excess) = (other.last_dt, other.energy_excess);
        self.hierarchy.clone_from(&other.hierarchy);
        (self.left, self.lost) = (other.left, other.lost);
    }

    /// Keeps the particles for which `keep` holds, in their order. A hierarchy of others serves no longer.
    pub fn retain(&mut self, keep: &[bool]) {
        fn sieve<T>(values: &mut Vec<T>, keep: &[bool]) {
            let mut next = keep.iter();
            values.retain(|_| *next.next().expect("a flag a particle"));
        }
        sieve(&mut self.ids, keep);
        sieve(&mut self.positions, keep);
        sieve(&mut self.velocities, keep);
        sieve(&mut self.pressures, keep);
        sieve(&mut self.classes, keep);
        sieve(&mut self.pressure_accelerations, keep);
        sieve(&mut self.position_potentials, keep);
        self.hierarchy = None;
    }

    /// Places of the particles in the order of their numbers: for whatever is to be seen in the order of the
    /// start.
    pub fn by_id(&self) -> Vec<u32> {
        let mut places: Vec<u32> = (0..self.len() as u32).collect();
        places.sort_unstable_by_key(|&a| self.ids[a as usize]);
        places
    }

    /// The state as bytes: a restart from them is identical to the bit.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut state = Writer::new(MAGIC);
        state.usize(D);
        state.usize(self.len());
        state.u64(self.left);
        state.u64(self.lost);
        state.f64(self.last_dt);
        state.f64(self.energy_excess);
        state.u32s(&self.ids);
        state.list(&self.classes, |state, class| state.u8(*class as u8));
        for field in [&self.positions, &self.velocities, &self.pressure_accelerations] {
            state.vectors(field);
        }
        state.f64s(&self.pressures);
        state.f64s(&self.position_potentials);
        state.option(self.hierarchy.as_ref(), |state, hierarchy| hierarchy.write(state));
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
        let read = Self {
            left: state.u64("particles that left")?,
            lost: state.u64("particles lost")?,
            last_dt: state.f64("last step")?,
            energy_excess: state.f64("energy excess")?,
            ids: state.u32s("numbers", Some(count))?,
            classes: SurfaceClass::read(&mut state, "classes", count)?,
            positions: state.vectors("positions", Some(count))?,
            velocities: state.vectors("velocities", Some(count))?,
            pressure_accelerations: state.vectors("pressure accelerations", Some(count))?,
            pressures: state.f64s("pressures", Some(count))?,
            position_potentials: state.f64s("position potentials", Some(count))?,
            hierarchy: state.option("preconditioner", |state| Hierarchy::read(state, count))?,
        };
        state.finish()?;
        Ok(read)
    }
}
