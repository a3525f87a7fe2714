//! External accelerations: gravity, dead loads, and the fluid's load, Eq. (48).

use crate::tlsph::total_lagrangian::Structure;
use crate::{Error, Load};
use sph::Vector;

impl<const D: usize> Structure<D> {
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
            || self.hourglass.is_some()
            || self.setup.dead_loads.iter().any(|d| !d.history.is_constant(from, to))
    }

    /// Whether there is any external acceleration.
    pub(crate) fn is_loaded(&self, load: &Load<D>) -> bool {
        !matches!(load, Load::None)
            || self.hourglass.is_some()
            || self.setup.gravity.amax() > 0.0
            || !self.setup.dead_loads.is_empty()
    }

    /// Fills the external accelerations (m/s²) of the free particles at a time (s), `fraction` of the window
    /// being over; those of the hourglass control are among them, and so its work is among that of the loads.
    pub(crate) fn fill_external(&mut self, load: &Load<D>, time: f64, fraction: f64) {
        let external = &mut self.fields.external;
        let mut first = 0;
        let mut next = 0;
        for body in &self.setup.bodies {
            for user in first..first + body.positions.len() {
                if self.clamped[user] {
                    continue;
                }
                let gradient = match load {
                    Load::None => Vector::zeros(),
                    Load::Held(held) => held[next],
                    Load::Linear(start, end) => start[next] + (end[next] - start[next]) * fraction,
                };
                next += 1;
                let acceleration = self.setup.gravity - gradient / body.density;
                external.set_vector(self.numbering.internal_of[user] as usize, &acceleration);
            }
            first += body.positions.len();
        }
        for dead in &self.setup.dead_loads {
            let force = dead.force * dead.history.at(time);
            for &(user, share) in dead.particles.iter().filter(|(user, _)| !self.clamped[*user]) {
                let internal = self.numbering.internal_of[user] as usize;
                let more = force * (share / self.masses[user]);
                let sum = external.vector::<D>(internal) + more;
                external.set_vector(internal, &sum);
            }
        }
        if self.hourglass.is_some() {
            let mut field = std::mem::take(&mut self.fields.external);
            self.add_hourglass(&mut field);
            self.fields.external = field;
        }
    }
}
