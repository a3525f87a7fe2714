//! The pressure of the initial state, and the loads that go with it.
//!
//! One solve does not find it. The surface's pressure is taken from the acceleration by pressure of the step
//! before ([`surface_offset`](crate::isph::surface::surface_offset)). A velocity that is free of divergence
//! where the particles are is so no longer where they are a step later, and that is what the projection
//! meets: in its first step a drop or a patch that turns has no pressure. What a velocity must lose at once,
//! as where it runs into a wall, is lost in the first step and belongs to no pressure later. So the state
//! goes on for some short steps, and keeps nothing of them but the pressure.

use crate::error::Error;
use crate::interface::InterfaceInput;
use crate::isph::solver::Isph;
use crate::isph::state::State;

/// Short steps, together as long as the first. Near the surface, where a pressure is drawn towards the
/// surface's (Eq. (16)) and averaged with its last value, it takes a few to settle.
const STEPS: usize = 8;

impl<const D: usize> Isph<D> {
    /// Gives `initial` the pressure with which a first step of `dt` (s) from `time` (s) begins, beside a
    /// structure that moves so under no load but its weight; and the output, the loads. All motion is
    /// discarded, and so is what the steps remember of energy: the solver starts from the same particles, in
    /// the same order.
    ///
    /// # Errors
    /// Those of [`step`](crate::method::Fluid::step).
    pub(crate) fn find_initial_pressure(
        &mut self,
        initial: &mut State<D>,
        (time, dt): (f64, f64),
        structure: &InterfaceInput<'_, D>,
    ) -> Result<(), Error> {
        let short = dt / STEPS as f64;
        let (mut ahead, mut trial) = (initial.clone(), State::default());
        let (mut positions, mut velocities) = (structure.positions.to_vec(), structure.velocities.to_vec());
        let gravity = self.properties.gravity;
        // A structure that yields goes on under weight and load; it is not yet strained. Met is its mean
        // velocity, or that at the end, under its weight alone. One that does not yield goes on as it does:
        // under a load that knows nothing of it, it would be thrown about.
        let yields = !self.compliance.is_empty();
        let fall = gravity * (self.options.structure_velocity.compliance() * short);
        let mut unloaded = velocities.clone();
        for step in 0..STEPS {
            let is_free = self.interface.densities.iter().map(|density| yields && *density > 0.0);
            for ((unloaded, u), free) in unloaded.iter_mut().zip(&velocities).zip(is_free) {
                *unloaded = if free { u + fall } else { *u };
            }
            let met = InterfaceInput { positions: &positions, velocities: &unloaded, ..*structure };
            self.step_watched(&ahead, time + step as f64 * short, short, &met, &mut trial, |_| ())?;
            std::mem::swap(&mut ahead, &mut trial);
            let loads = self.output.pressure_gradients.iter().zip(&self.interface.densities);
            for (((r, u), (load, density)), unloaded) in
                positions.iter_mut().zip(&mut velocities).zip(loads).zip(&unloaded)
            {
                *r += unloaded * short;
                if yields && *density > 0.0 {
                    *u += (gravity - load / *density) * short;
                }
            }
        }
        initial.take_pressure(&ahead);
        Ok(())
    }
}

impl<const D: usize> State<D> {
    /// Takes pressures, classes, and what is remembered of pressures from a state of the same particles.
    fn take_pressure(&mut self, other: &Self) {
        let mut place = vec![usize::MAX; self.len()];
        self.ids.iter().enumerate().for_each(|(a, id)| place[*id as usize] = a);
        let (memory, others) = (&mut self.memory, &other.memory);
        for (b, id) in other.ids.iter().enumerate() {
            let a = place[*id as usize];
            self.pressures[a] = other.pressures[b];
            self.classes[a] = other.classes[b];
            memory.pressure_accelerations[a] = others.pressure_accelerations[b];
            memory.position_potentials[a] = others.position_potentials[b];
        }
    }
}
