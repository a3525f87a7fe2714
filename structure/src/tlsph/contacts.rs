//! Contact in the time step: its forces among the external accelerations of a stage, its works beside those
//! of the loads.

use crate::contact::{Contact, Passed, Power};
use crate::error::Error;
use crate::state::State;
use crate::tlsph::field::Field;
use crate::tlsph::kernels::row;
use crate::tlsph::total_lagrangian::TotalLagrangian;
use sph::Vector;

/// Contact over the sub-steps of one window; nothing where nothing may meet.
pub(super) struct Meeting<'a, const D: usize> {
    contact: Option<&'a mut Contact<D>>,
    /// Energy (J) of the springs of friction at the window's start.
    springs: f64,
    /// Works (J) since then.
    works: Power,
    /// Energies (J) of contact, and of the springs among it, at its end.
    energies: (f64, f64),
}

impl<'a, const D: usize> Meeting<'a, D> {
    /// At the state that a window begins with, which is in the fields.
    pub fn begin(
        solid: &TotalLagrangian<D>,
        mut contact: Option<&'a mut Contact<D>>,
        from: &State<D>,
        sub_step: f64,
    ) -> Self {
        let mut springs = 0.0;
        if let Some(contact) = &mut contact {
            let (position, velocity) = (|p| solid.position(p), |p| solid.velocity(p));
            contact.begin((from.time, sub_step), &from.sticks, position, velocity);
            springs = contact.energy_of_springs();
        }
        Self { contact, springs, works: Power::default(), energies: (0.0, 0.0) }
    }

    /// Begins a sub-step at a time (s).
    pub fn follow(&mut self, solid: &TotalLagrangian<D>, time: f64) {
        if let Some(contact) = &mut self.contact {
            contact.follow(time, |particle| solid.position(particle));
        }
    }

    /// Adds the forces of a stage at a time (s), of this weight (s) in the sums of a sub-step, to the
    /// external accelerations; whether there are any.
    pub fn act(&mut self, solid: &mut TotalLagrangian<D>, time: f64, weight: f64) -> Result<bool, Error> {
        let Some(contact) = self.contact.as_mut().filter(|contact| contact.is_near()) else {
            return Ok(false);
        };
        let acted =
            contact.act(time, |particle| solid.position(particle), |particle| solid.velocity(particle));
        let Some(power) = acted.map_err(|passed| solid.passed(contact, &passed, time))? else {
            return Ok(false);
        };
        self.works.on_free += power.on_free * weight;
        self.works.clamps += power.clamps * weight;
        self.works.walls += power.walls * weight;
        self.works.friction += power.friction * weight;
        solid.without_contact.clear();
        for (particle, force) in contact.forces() {
            let internal = solid.numbering.internal_of[particle] as usize;
            let given = solid.fields.external.vector::<D>(internal);
            solid.without_contact.push((internal, given));
            let with = given + force / solid.particles.masses[particle];
            solid.fields.external.set_vector(internal, &with);
        }
        Ok(true)
    }

    /// Takes the forces of the stage away.
    pub fn leave(&mut self, solid: &mut TotalLagrangian<D>) {
        for (internal, given) in solid.without_contact.drain(..) {
            solid.fields.external.set_vector(internal, &given);
        }
    }

    /// Ends a sub-step at a time (s).
    pub fn settle(&mut self, solid: &TotalLagrangian<D>, time: f64) -> Result<(), Error> {
        let Some(contact) = &mut self.contact else { return Ok(()) };
        let settled = contact.settle(time, |particle| solid.position(particle));
        settled.map_err(|passed| solid.passed(contact, &passed, time))
    }

    /// Measures the energies at a window's end (s), while its displacements are in the fields.
    pub fn measure(&mut self, solid: &TotalLagrangian<D>, time: f64) -> Result<(), Error> {
        let Some(contact) = &mut self.contact else { return Ok(()) };
        let energies = contact.energy(time, |particle| solid.position(particle));
        self.energies = energies.map_err(|passed| solid.passed(contact, &passed, time))?;
        Ok(())
    }

    /// Ends a window: energies, works and springs of its end.
    pub fn end(self, from: &State<D>, to: &mut State<D>) {
        let (energy, springs) = self.energies;
        to.energy.contact = energy;
        to.energy.wall_work = from.energy.wall_work + self.works.walls;
        to.energy.friction_loss = from.energy.friction_loss;
        to.sticks.clear();
        let Some(contact) = self.contact else { return };
        to.energy.friction_loss += self.works.friction - (springs - self.springs);
        // The step counts all external accelerations as loads.
        to.energy.load_work -= self.works.on_free;
        to.energy.clamp_work += self.works.clamps;
        to.sticks.extend_from_slice(contact.sticks());
    }
}

impl<const D: usize> TotalLagrangian<D> {
    /// Energy (J) of contact of a state whose displacements are in the fields.
    pub(super) fn contact_energy(&mut self, state: &State<D>) -> Result<f64, Error> {
        let Some(mut contact) = self.contact.take() else { return Ok(0.0) };
        let (position, velocity) = (|p| self.position(p), |p| self.velocity(p));
        contact.begin((state.time, state.stability.step), &state.sticks, position, velocity);
        let energies = contact.energy(state.time, |particle| self.position(particle));
        let energies = energies.map_err(|passed| self.passed(&contact, &passed, state.time));
        self.contact = Some(contact);
        Ok(energies?.0)
    }

    /// Where a particle is in the stage (m).
    fn position(&self, particle: usize) -> Vector<D> {
        let internal = self.numbering.internal_of[particle] as usize;
        self.particles.reference_positions[particle] + self.fields.displacement.vector::<D>(internal)
    }

    fn velocity(&self, particle: usize) -> Vector<D> {
        let internal = self.numbering.internal_of[particle] as usize;
        let step: &Field = &self.fields.step;
        Vector::from_fn(|i, _| step.get(row::STAGE_VELOCITY * D + i, internal))
    }

    fn passed(&self, contact: &Contact<D>, passed: &Passed, time: f64) -> Error {
        let names = &self.particles.setup.contact.names;
        Error::Passed {
            particle: passed.particle,
            time,
            position: passed.position.clone(),
            body: contact.name(names, passed.body),
            partner: contact.name(names, passed.partner),
        }
    }
}
