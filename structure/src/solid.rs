//! What a method for solids gives: the seam between a participant and the method behind it.

use crate::error::{Error, SetupError};
use crate::loads::Load;
use crate::particles::Particles;
use crate::setup::Setup;
use crate::state::{Derived, Report, State};

/// A solid by some method. It holds what never changes in a run, and scratch memory (hence `&mut` where it
/// computes); what does change is a [`State`], so a window can be solved again from where it began.
pub trait Solid<const D: usize>: Sized {
    /// The method, as a participant names it.
    const METHOD: &'static str;

    /// Checks the setup, builds the operators in the reference configuration and computes the stable step.
    ///
    /// # Errors
    /// All mistakes of the setup.
    fn new(setup: Setup<D>) -> Result<Self, SetupError>;

    /// Its particles.
    fn particles(&self) -> &Particles<D>;

    /// The state at rest in the reference configuration at a time (s), clamps where they are then.
    fn state_at_rest(&self, time: f64) -> State<D>;

    /// Sets the kinetic and strain energy and the stable step of a state made by hand (with initial
    /// velocities, say); the works are left as they are.
    ///
    /// # Errors
    /// A state of other particles, or one that is not finite.
    fn evaluate(&mut self, state: &mut State<D>) -> Result<(), Error>;

    /// Solves one window of length `dt` (s) in `sub_steps` equal steps from the accepted state `from`, which
    /// is not changed, to `to`, whose memory is used again. The load belongs to the interface particles.
    /// Repeatable to the bit, whatever the number of threads.
    ///
    /// # Errors
    /// A window, sub-step or load that cannot be solved with, an inverted particle; `to` then holds nothing
    /// of use.
    fn advance(
        &mut self,
        from: &State<D>,
        to: &mut State<D>,
        dt: f64,
        sub_steps: usize,
        load: &Load<D>,
    ) -> Result<Report, Error>;

    /// Stresses, energy density and deformation gradient of a state; the vectors given are filled anew.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    fn derive(&mut self, state: &State<D>, out: &mut Derived<D>) -> Result<(), Error>;
}
