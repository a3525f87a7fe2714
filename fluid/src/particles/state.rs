//! The fluid's state between two steps: what any fluid's particles have, and what its method remembers.

use crate::particles::class::SurfaceClass;
use sph::Vector;

/// Everything the next step depends on. Particle `i` is the same in all arrays, those in `memory` included; a
/// step may remove particles and rearrange them (see [`order`](crate::particles::order)), never add any.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State<const D: usize, M> {
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
    /// Length (s) of the step that led here; zero at the start.
    pub last_dt: f64,
    /// Particles that left the domain so far.
    pub left: u64,
    /// Particles lost inside walls or structure so far: zero in a sound run.
    pub lost: u64,
    /// What the method remembers besides.
    pub memory: M,
}

impl<const D: usize, M> State<D, M> {
    /// Particles at rest or moving, without pressure, with what the method has to remember of them.
    pub fn at_start(positions: Vec<Vector<D>>, velocities: Vec<Vector<D>>, memory: M) -> Self {
        assert_eq!(positions.len(), velocities.len(), "a velocity a particle");
        let count = positions.len();
        Self {
            ids: (0..count as u32).collect(),
            positions,
            velocities,
            pressures: vec![0.0; count],
            classes: vec![SurfaceClass::Interior; count],
            last_dt: 0.0,
            left: 0,
            lost: 0,
            memory,
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

    /// Makes all but the memory equal to `other`, allocations used again.
    pub fn copy_particles(&mut self, other: &Self) {
        self.ids.clone_from(&other.ids);
        self.positions.clone_from(&other.positions);
        self.velocities.clone_from(&other.velocities);
        self.pressures.clone_from(&other.pressures);
        self.classes.clone_from(&other.classes);
        (self.last_dt, self.left, self.lost) = (other.last_dt, other.left, other.lost);
    }

    /// Keeps the particles for which `keep` holds, in their order; the memory is its method's to sieve.
    pub fn retain_particles(&mut self, keep: &[bool]) {
        sieve(&mut self.ids, keep);
        sieve(&mut self.positions, keep);
        sieve(&mut self.velocities, keep);
        sieve(&mut self.pressures, keep);
        sieve(&mut self.classes, keep);
    }

    /// Places of the particles in the order of their numbers: for whatever is to be seen in the order of the
    /// start.
    pub fn by_id(&self) -> Vec<u32> {
        let mut places: Vec<u32> = (0..self.len() as u32).collect();
        places.sort_unstable_by_key(|&a| self.ids[a as usize]);
        places
    }
}

/// Keeps the values for which `keep` holds, in their order.
pub fn sieve<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut next = keep.iter();
    values.retain(|_| *next.next().expect("a flag a particle"));
}
