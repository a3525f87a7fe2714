//! External accelerations: gravity, dead loads, and the fluid's load, Eq. (48).

use crate::error::Error;
use crate::loads::Load;
use crate::particles::Particles;
use sph::Vector;

impl<const D: usize> Particles<D> {
    /// Refuses loads of the wrong length or with numbers that are none.
    pub(crate) fn check_load(&self, load: &Load<D>, time: f64) -> Result<(), Error> {
        let expected = self.interface.len();
        let arrays: &[&[Vector<D>]] = match load {
            Load::None => &[],
            Load::Held(held) => &[held],
            Load::Linear(start, end) => &[start, end],
        };
        for array in arrays {
            if array.len() != expected {
                return Err(Error::Length { what: "pressure gradient", given: array.len(), expected });
            }
            if let Some(i) = array.iter().position(|g| !g.iter().all(|c| c.is_finite())) {
                return Err(Error::Load { particle: self.interface[i] as usize, time });
            }
        }
        Ok(())
    }

    /// Whether external accelerations change between two times (s) of a window.
    pub(crate) fn load_varies(&self, load: &Load<D>, from: f64, to: f64) -> bool {
        matches!(load, Load::Linear(..))
            || self.setup.dead_loads.iter().any(|d| !d.history.is_constant(from, to))
    }

    /// Whether there is any external acceleration.
    pub(crate) fn is_loaded(&self, load: &Load<D>) -> bool {
        !matches!(load, Load::None) || self.setup.gravity.amax() > 0.0 || !self.setup.dead_loads.is_empty()
    }

    /// Fills the external accelerations (m/s²) of the free particles at a time (s), `fraction` of the window
    /// being over; those of fixed ones are left as they are.
    pub(crate) fn accelerate(&self, load: &Load<D>, time: f64, fraction: f64, out: &mut [Vector<D>]) {
        for (n, &particle) in self.interface.iter().enumerate() {
            let gradient = match load {
                Load::None => Vector::zeros(),
                Load::Held(held) => held[n],
                Load::Linear(start, end) => start[n] + (end[n] - start[n]) * fraction,
            };
            let particle = particle as usize;
            if self.clamped[particle] {
                continue;
            }
            out[particle] = self.setup.gravity - gradient / self.densities[particle];
        }
        for dead in &self.setup.dead_loads {
            let force = dead.force * dead.history.at(time);
            for &(particle, share) in dead.particles.iter().filter(|(particle, _)| !self.clamped[*particle]) {
                out[particle] += force * (share / self.masses[particle]);
            }
        }
    }
}
