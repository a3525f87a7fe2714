//! What can go wrong, each with the particle, the time and the remedy.

use std::fmt;

/// A setup refused, with all its mistakes.
#[derive(Clone, Debug, PartialEq)]
pub struct SetupError {
    /// All mistakes found.
    pub mistakes: Vec<ErrorKind>,
}

impl fmt::Display for SetupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "failed to set up the structure:")?;
        for mistake in &self.mistakes {
            write!(f, "\n  {mistake}")?;
        }
        Ok(())
    }
}

impl std::error::Error for SetupError {}

/// One mistake in a setup.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ErrorKind {
    /// No free particle.
    #[error("no body has a free particle; give at least one body with particles that are not clamped")]
    NothingToMove,
    /// Arrays of a body that do not belong together.
    #[error(
        "body {body} has {positions} positions, {volumes} volumes and {clamped} clamp flags; give one of each a particle"
    )]
    #[expect(missing_docs, reason = "the message names each")]
    Lengths { body: usize, positions: usize, volumes: usize, clamped: usize },
    /// A number of a body out of range.
    #[error(
        "body {body}: {name} = {value} is out of range; moduli, density and cell are positive and -1 < poisson_ratio < 0.5"
    )]
    #[expect(missing_docs, reason = "the message names each")]
    Number { body: usize, name: &'static str, value: f64 },
    /// A particle without a finite position or with a wrong volume.
    #[error(
        "body {body}, particle {particle}: position not finite, or volume {volume} not positive (only clamped particles may have none)"
    )]
    #[expect(missing_docs, reason = "the message names each")]
    Particle { body: usize, particle: usize, volume: f64 },
    /// A body too thin for the quadratic gradient.
    #[error(
        "body {body} has {layers} layers of particles along axis {axis}; the quadratic gradient needs three to bend (two lock, one cannot): use a finer spacing or the first-order gradient"
    )]
    #[expect(missing_docs, reason = "the message names each")]
    Layers { body: usize, axis: usize, layers: usize },
    /// An option out of range.
    #[error(
        "{name} = {value} is out of range; give a finite number that is not negative, for step_fraction one in (0, 0.9]"
    )]
    #[expect(missing_docs, reason = "the message names each")]
    Option { name: &'static str, value: f64 },
    /// A load on a particle that is not there.
    #[error("dead load {load} names particle {particle}, but there are {count}")]
    #[expect(missing_docs, reason = "the message names each")]
    LoadedParticle { load: usize, particle: usize, count: usize },
    /// A motion of a particle that is not fixed.
    #[error("motion {index} moves particle {particle}, which is not fixed; give it fixed particles alone")]
    #[expect(missing_docs, reason = "the message names each")]
    MovedParticle { index: usize, particle: usize },
    /// A particle whose neighbours do not span space.
    #[error(
        "particle {particle} has {neighbours} neighbours that do not span all directions; use at least two particles through the thickness or a larger smoothing_ratio"
    )]
    #[expect(missing_docs, reason = "the message names each")]
    Neighbours { particle: usize, neighbours: usize },
}

/// A window that could not be solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// `J ≤ 0` or not a number at a particle.
    #[error(
        "failed to advance the structure at t = {time} s: particle {particle} (reference position {position:?}) is inverted or torn, J = {jacobian}; use more sub-steps, a finer lattice, or a smaller load"
    )]
    #[expect(missing_docs, reason = "the message names each")]
    Inverted { particle: usize, time: f64, jacobian: f64, position: Vec<f64> },
    /// A position or velocity that is no number.
    #[error(
        "failed to advance the structure at t = {time} s: the state of particle {particle} is not finite; use more sub-steps and look at the load there"
    )]
    #[expect(missing_docs, reason = "the message names each")]
    NotFinite { particle: usize, time: f64 },
    /// A surface that another is about to pass through.
    #[error(
        "failed to advance the structure at t = {time} s: {body} passes through {partner} at {position:?} (particle {particle}), faster or harder pressed than contact can hold; use a stiffer material, a finer lattice, or a smaller speed or load"
    )]
    #[expect(missing_docs, reason = "the message names each")]
    Passed { particle: usize, time: f64, position: Vec<f64>, body: String, partner: String },
    /// A sub-step over the stability limit.
    #[error(
        "failed to advance the structure at t = {time} s: the sub-step {sub_step} s is over the stable step {stable} s; use at least {remedy} sub-steps in a window of {window} s"
    )]
    #[expect(missing_docs, reason = "the message names each")]
    Unstable { time: f64, sub_step: f64, stable: f64, window: f64, remedy: usize },
    /// A window that is not positive or has no sub-steps.
    #[error(
        "failed to advance the structure at t = {time} s: window {window} s with {sub_steps} sub-steps; both must be positive"
    )]
    #[expect(missing_docs, reason = "the message names each")]
    Window { time: f64, window: f64, sub_steps: usize },
    /// Arrays of the wrong length.
    #[error("{what} has {given} entries, but there are {expected}")]
    #[expect(missing_docs, reason = "the message names each")]
    Length { what: &'static str, given: usize, expected: usize },
    /// A load that is no number.
    #[error(
        "the pressure gradient at interface particle {particle} is not finite at t = {time} s; the sender must not send it"
    )]
    #[expect(missing_docs, reason = "the message names each")]
    Load { particle: usize, time: f64 },
}
