//! From a state to the internal order of particles and back, with its energies.

use crate::error::Error;
use crate::lanes::{LANES, cofactor, plus_identity};
use crate::state::State;
use crate::tlsph::kernels::{self, row};
use crate::tlsph::total_lagrangian::TotalLagrangian;
use sph::Vector;

impl<const D: usize> TotalLagrangian<D> {
    /// Internal order from a state.
    pub(super) fn load_state(&mut self, state: &State<D>) -> Result<(), Error> {
        for (what, given) in
            [("state.positions", state.positions.len()), ("state.velocities", state.velocities.len())]
        {
            if given != self.particles.len() {
                return Err(Error::Length { what, given, expected: self.particles.len() });
            }
        }
        self.fields.step.clear();
        for (user, internal) in self.numbering.pairs() {
            let displacement = state.positions[user] - self.particles.reference_positions[user];
            let velocity =
                if self.particles.clamped[user] { Vector::zeros() } else { state.velocities[user] };
            let finite = |v: &Vector<D>| v.iter().all(|c| c.is_finite());
            if !(finite(&displacement) && finite(&velocity)) {
                return Err(Error::NotFinite { particle: user, time: state.time });
            }
            self.fields.displacement.set_vector(internal, &displacement);
            for i in 0..D {
                self.fields.step.set(row::START_DISPLACEMENT * D + i, internal, displacement[i]);
                self.fields.step.set(row::START_VELOCITY * D + i, internal, velocity[i]);
                self.fields.step.set(row::STAGE_VELOCITY * D + i, internal, velocity[i]);
            }
        }
        Ok(())
    }

    /// Positions, velocities and energies to a state from the internal order, the works added to those of
    /// `from`.
    pub(super) fn store_state(&mut self, from: &State<D>, to: &mut State<D>, dt: f64) -> Result<(), Error> {
        to.time = from.time + dt;
        to.positions.resize(self.particles.len(), Vector::zeros());
        to.velocities.resize(self.particles.len(), Vector::zeros());
        for (user, internal) in self.numbering.pairs() {
            let row =
                |r: usize| -> Vector<D> { Vector::from_fn(|i, _| self.fields.step.get(r * D + i, internal)) };
            let (displacement, velocity) = (row(row::START_DISPLACEMENT), row(row::START_VELOCITY));
            if !displacement.iter().chain(velocity.iter()).all(|c| c.is_finite()) {
                return Err(Error::NotFinite { particle: user, time: to.time });
            }
            to.positions[user] = self.particles.reference_positions[user] + displacement;
            to.velocities[user] = velocity;
        }
        to.energy.kinetic = self.kinetic_energy();
        to.energy.strain = self.strain_energy();
        to.energy.load_work = from.energy.load_work + self.work(row::WORK);
        to.energy.dissipated = from.energy.dissipated + self.work(row::DISSIPATION);
        to.stability = self.stability(to, from.stability);
        Ok(())
    }

    /// The error for a slice in which `J` is not positive.
    pub(super) fn inversion(&self, slice: usize, time: f64) -> Error {
        let mut found = None;
        kernels::visit_gradients::<D>(
            self.particles.setup.options.gradient,
            &self.stencil,
            &self.fields,
            |s, l, _| {
                if s == slice {
                    let jacobian = cofactor(&plus_identity(l)).1;
                    found = (0..LANES)
                        .find(|&lane| jacobian.0[lane].is_nan() || jacobian.0[lane] <= 0.0)
                        .map(|lane| (self.numbering.user_of[s * LANES + lane], jacobian.0[lane]));
                }
            },
        );
        let (user, jacobian) = found.unwrap_or((0, f64::NAN));
        let particle = user as usize;
        let position = self.particles.reference_positions[particle].as_slice().to_vec();
        if jacobian.is_nan() {
            Error::NotFinite { particle, time }
        } else {
            Error::Inverted { particle, time, jacobian, position }
        }
    }

    /// Kinetic energy (J) of the free particles in the stage.
    pub(super) fn kinetic_energy(&self) -> f64 {
        let internal_of = &self.numbering.internal_of;
        sph::parallel::sum(self.particles.len(), |user| {
            if self.particles.clamped[user] {
                return 0.0;
            }
            let a = internal_of[user] as usize;
            let square: f64 =
                (0..D).map(|i| self.fields.step.get(row::START_VELOCITY * D + i, a).powi(2)).sum();
            0.5 * self.particles.masses[user] * square
        })
    }

    fn work(&self, row: usize) -> f64 {
        let internal_of = &self.numbering.internal_of;
        sph::parallel::sum(self.particles.len(), |user| {
            if self.particles.clamped[user] {
                return 0.0;
            }
            let a = internal_of[user] as usize;
            self.particles.masses[user] * (0..D).map(|i| self.fields.step.get(row * D + i, a)).sum::<f64>()
        })
    }

    /// Strain energy (J) of the stage.
    pub(super) fn strain_energy(&mut self) -> f64 {
        let (gradient, stencil) = (self.particles.setup.options.gradient, &self.stencil);
        kernels::energy_pass(D, gradient, stencil, &mut self.passes, &mut self.fields);
        let internal_of = &self.numbering.internal_of;
        sph::parallel::sum(self.particles.len(), |user| {
            self.particles.volumes[user] * self.fields.energy.get(0, internal_of[user] as usize)
        })
    }
}
