//! What ISPH remembers from step to step, and its state as bytes.

use crate::error::Error;
use crate::isph::pressure::hierarchy::Hierarchy;
use crate::particles::class::SurfaceClass;
use crate::particles::state::{self, sieve};
use sph::Vector;

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

const MAGIC: &[u8; 8] = b"mnscflu4";

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

    /// The state as bytes (little endian): a restart from them is identical to the bit.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(72 + self.len() * (8 * (3 * D + 2) + 5));
        bytes.extend_from_slice(MAGIC);
        for n in [D as u64, self.len() as u64, self.left, self.lost] {
            bytes.extend_from_slice(&n.to_le_bytes());
        }
        for x in [self.last_dt, self.memory.energy_excess] {
            bytes.extend_from_slice(&x.to_le_bytes());
        }
        for id in &self.ids {
            bytes.extend_from_slice(&id.to_le_bytes());
        }
        bytes.extend(self.classes.iter().map(|c| *c as u8));
        for field in [&self.positions, &self.velocities, &self.memory.pressure_accelerations] {
            for x in field.iter().flat_map(|v| v.iter()) {
                bytes.extend_from_slice(&x.to_le_bytes());
            }
        }
        for field in [&self.pressures, &self.memory.position_potentials] {
            for x in field {
                bytes.extend_from_slice(&x.to_le_bytes());
            }
        }
        if let Some(hierarchy) = &self.memory.hierarchy {
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
            last_dt,
            left,
            lost,
            memory: Memory { pressure_accelerations, position_potentials, energy_excess, hierarchy },
        })
    }
}
