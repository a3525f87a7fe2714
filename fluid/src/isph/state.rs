//! The fluid's state between two steps: all that the next step depends on, the solver's memory included.

use crate::Error;
use crate::isph::pressure::hierarchy::Hierarchy;
use sph::Vector;

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
    /// Within the fluid, but without pressure, since it would be pulled ([`tearing`](crate::isph::surface::tearing)).
    Torn = 4,
}

impl SurfaceClass {
    /// The class that `byte` stands for in a saved state.
    pub fn from_byte(byte: u8) -> Option<Self> {
        [Self::Interior, Self::NearSurface, Self::Surface, Self::Splash, Self::Torn]
            .get(usize::from(byte))
            .copied()
    }
}

/// Everything the next step depends on. Particle `i` is the same in all arrays; a step may remove particles
/// and rearrange them (see [`order`](crate::particles::order)), never add any.
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
    /// taken out: what [`velocity_correction`](crate::isph::pressure::velocity_correction) has given it too much.
    pub energy_excess: f64,
    /// The preconditioner that the next step takes; a new one where there is none.
    pub hierarchy: Option<Hierarchy<D>>,
    /// Particles that left the domain so far.
    pub left: u64,
    /// Particles lost inside walls or structure so far: zero in a sound run.
    pub lost: u64,
}

const MAGIC: &[u8; 8] = b"mnscflu4";

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

    /// The state as bytes (little endian): a restart from them is identical to the bit.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(72 + self.len() * (8 * (3 * D + 2) + 5));
        bytes.extend_from_slice(MAGIC);
        for n in [D as u64, self.len() as u64, self.left, self.lost] {
            bytes.extend_from_slice(&n.to_le_bytes());
        }
        for x in [self.last_dt, self.energy_excess] {
            bytes.extend_from_slice(&x.to_le_bytes());
        }
        for id in &self.ids {
            bytes.extend_from_slice(&id.to_le_bytes());
        }
        bytes.extend(self.classes.iter().map(|c| *c as u8));
        for field in [&self.positions, &self.velocities, &self.pressure_accelerations] {
            for x in field.iter().flat_map(|v| v.iter()) {
                bytes.extend_from_slice(&x.to_le_bytes());
            }
        }
        for field in [&self.pressures, &self.position_potentials] {
            for x in field {
                bytes.extend_from_slice(&x.to_le_bytes());
            }
        }
        if let Some(hierarchy) = &self.hierarchy {
            bytes.extend(hierarchy.to_bytes());
        }
        bytes
    }

    /// The state that [`to_bytes`](Self::to_bytes) wrote.
    ///
    /// # Errors
    /// [`Error::Restore`] when the bytes are not such a state, of another dimension, or cut off.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let mut rest = bytes;
        let mut take = |n: usize| -> Result<&[u8], Error> {
            if rest.len() < n {
                return Err(Error::Restore(format!("it ends {} bytes early", n - rest.len())));
            }
            let (head, tail) = rest.split_at(n);
            rest = tail;
            Ok(head)
        };
        fn words<const N: usize>(bytes: &[u8]) -> impl Iterator<Item = [u8; N]> + '_ {
            bytes.chunks_exact(N).map(|c| c.try_into().expect("chunks have this length"))
        }
        if take(8)? != MAGIC {
            return Err(Error::Restore("it is not a fluid's state of this version".into()));
        }
        let head: Vec<u64> = words(take(32)?).map(u64::from_le_bytes).collect();
        if head[0] != D as u64 {
            return Err(Error::Restore(format!("it is {}-dimensional, the fluid {D}-dimensional", head[0])));
        }
        let n = head[1] as usize;
        let mut number =
            || Ok(words(take(8)?).map(f64::from_le_bytes).next().expect("eight bytes make a number"));
        let (last_dt, energy_excess) = (number()?, number()?);
        let ids = words(take(4 * n)?).map(u32::from_le_bytes).collect();
        let mut classes = Vec::with_capacity(n);
        for &c in take(n)? {
            let class = SurfaceClass::from_byte(c);
            classes.push(class.ok_or_else(|| Error::Restore(format!("{c} is no surface class")))?);
        }
        let mut vectors = || -> Result<Vec<Vector<D>>, Error> {
            let flat: Vec<f64> = words(take(8 * n * D)?).map(f64::from_le_bytes).collect();
            Ok(flat.chunks_exact(D).map(Vector::from_column_slice).collect())
        };
        let (positions, velocities, pressure_accelerations) = (vectors()?, vectors()?, vectors()?);
        let pressures = words(take(8 * n)?).map(f64::from_le_bytes).collect();
        let position_potentials = words(take(8 * n)?).map(f64::from_le_bytes).collect();
        let hierarchy = match rest {
            [] => None,
            rest => {
                let saved = Hierarchy::from_bytes(rest).filter(|h| h.origin.positions.len() == n);
                Some(saved.ok_or_else(|| {
                    Error::Restore("its preconditioner is not that of its particles".into())
                })?)
            }
        };
        let (left, lost) = (head[2], head[3]);
        Ok(Self {
            ids,
            positions,
            velocities,
            pressures,
            classes,
            pressure_accelerations,
            position_potentials,
            last_dt,
            energy_excess,
            hierarchy,
            left,
            lost,
        })
    }
}
