//! What a method has to be for the participant to run it. Another one is a folder beside
//! [`isph`](crate::isph) over the same particles and boundaries, whose type implements [`Fluid`].

use crate::boundaries::walls::Walls;
use crate::error::Error;
use crate::interface::{InterfaceInput, InterfaceOutput, InterfaceParticles};
use crate::particles::state::State;
use crate::properties::FluidProperties;
use crate::report::StepReport;
use sph::Vector;

/// A fluid of particles between walls and interface particles. It remembers nothing from step to step but
/// what stands in a [`State`].
pub trait Fluid<const D: usize>: Sized {
    /// Name of the method.
    const METHOD: &'static str;
    /// Choices of the method.
    type Options: Clone;
    /// What the method remembers from step to step besides its particles.
    type Memory: Clone + Sync;

    /// A fluid between walls and interface particles, which starts from `initial`.
    ///
    /// # Errors
    /// [`Error::Setting`] for values that cannot be.
    fn new(
        properties: FluidProperties<D>,
        options: Self::Options,
        walls: Walls<D>,
        interface: InterfaceParticles<D>,
        initial: &State<D, Self::Memory>,
    ) -> Result<Self, Error>;

    /// Properties as given.
    fn properties(&self) -> &FluidProperties<D>;

    /// Options as given.
    fn options(&self) -> &Self::Options;

    /// Walls as given, where the last step has brought them.
    fn walls(&self) -> &Walls<D>;

    /// Smoothing length `h` (m).
    fn smoothing_length(&self) -> f64;

    /// The longest stable step (s) from `state` at `time` (s) beside a structure of these velocities (m/s).
    fn stable_step(
        &self,
        state: &State<D, Self::Memory>,
        time: f64,
        structure_velocities: &[Vector<D>],
    ) -> f64;

    /// Gives `initial`, which has none, the pressure with which a first step of `dt` (s) from `time` (s)
    /// begins, and [`output`](Self::output) and the forces on walls what goes with it; nothing moves.
    ///
    /// # Errors
    /// Those of [`step`](Self::step).
    fn start(
        &mut self,
        initial: &mut State<D, Self::Memory>,
        time: f64,
        dt: f64,
        structure: &InterfaceInput<'_, D>,
    ) -> Result<(), Error>;

    /// Advances `accepted` by `dt` (s) into `trial`, memory of `trial` used again. `time` (s) says where
    /// walls that move are. Nothing but `accepted`, `time`, `dt` and `structure` decides the result: calling
    /// twice gives the same bits.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::InterfaceLength`] for what came in or out, [`Error::Solve`] when a
    /// solve failed.
    fn step(
        &mut self,
        accepted: &State<D, Self::Memory>,
        time: f64,
        dt: f64,
        structure: &InterfaceInput<'_, D>,
        trial: &mut State<D, Self::Memory>,
    ) -> Result<StepReport<D>, Error>;

    /// Whether a run ends that loses particles inside walls or structure.
    fn refuses_lost_particles(&self) -> bool;

    /// What the structure gets of the last step.
    fn output(&self) -> &InterfaceOutput<D>;

    /// The same, to be set to what it was when a saved state is gone back to.
    fn output_mut(&mut self) -> &mut InterfaceOutput<D>;

    /// Force (N) of the fluid on each part of the walls in the last step, or at the start; nothing before.
    fn wall_forces(&self) -> &[Vector<D>];

    /// Force (N) of the fluid on a named part of the walls in the last step, or at the start, zero before;
    /// nothing where no part has this name.
    fn wall_force(&self, name: &str) -> Option<Vector<D>> {
        let of = |part: usize| self.wall_forces().get(part).copied().unwrap_or_else(Vector::zeros);
        self.walls().part(name).map(of)
    }

    /// Moment (N m) about the origin of the force on each part of the walls; in two dimensions about the
    /// third axis alone.
    fn wall_moments(&self) -> &[[f64; 3]];

    /// Moment (N m) about a point (m) of the force on a named part of the walls, as
    /// [`wall_force`](Self::wall_force) has it.
    fn wall_moment(&self, name: &str, about: &Vector<D>) -> Option<[f64; 3]> {
        let force = self.wall_force(name)?;
        let part = self.walls().part(name)?;
        let about_origin = self.wall_moments().get(part).copied().unwrap_or_default();
        let of = |i: usize, j: usize| about[i] * force[j] - about[j] * force[i];
        let shifted = if D == 3 { [of(1, 2), of(2, 0), of(0, 1)] } else { [0.0, 0.0, of(0, 1)] };
        Some(std::array::from_fn(|i| about_origin[i] - shifted[i]))
    }

    /// What shows why a solve failed, by name, one entry a particle: where it stopped on its way to `trial`,
    /// its residual as the equations have it.
    fn failed_solve<'a>(&'a self, trial: &'a State<D, Self::Memory>) -> Vec<(&'static str, &'a [f64])>;

    /// The state as bytes: a restart from them is identical to the bit.
    fn save(state: &State<D, Self::Memory>) -> Vec<u8>;

    /// The state that [`save`](Self::save) wrote.
    ///
    /// # Errors
    /// [`Error::Restore`] when the bytes are not such a state.
    fn restore(bytes: &[u8]) -> Result<State<D, Self::Memory>, Error>;
}
