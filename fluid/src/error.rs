//! What can go wrong in the fluid.

/// Failures of the fluid solver.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A setting cannot be used.
    #[error("{key} = {value} cannot be used: {remedy}")]
    Setting {
        /// Name of the setting.
        key: &'static str,
        /// Its value.
        value: String,
        /// What to do instead.
        remedy: &'static str,
    },
    /// An array of the interface has not one entry a particle.
    #[error("the interface's {field} holds {found} entries for {expected} interface particles")]
    InterfaceLength {
        /// The array.
        field: &'static str,
        /// Its length.
        found: usize,
        /// Number of interface particles.
        expected: usize,
    },
    /// A field that came in or that the step gave is not finite.
    #[error("{field} of particle {particle} is not finite in the step from t = {time} s; {remedy}")]
    NotFinite {
        /// The field.
        field: &'static str,
        /// Index of the first such particle.
        particle: usize,
        /// Time at the start of the step (s).
        time: f64,
        /// What to do.
        remedy: &'static str,
    },
    /// A pressure solve did not reach its tolerance.
    #[error(
        "failed to solve for the {unknown} at t = {time} s: relative residual {residual:.3e} after {iterations} iterations (asked {tolerance:.1e}); \
         a smaller time step or a looser tolerance may help, and overlapping bodies are the usual cause"
    )]
    Solve {
        /// What was solved for.
        unknown: &'static str,
        /// Time at the start of the step (s).
        time: f64,
        /// Relative residual reached.
        residual: f64,
        /// Iterations done.
        iterations: usize,
        /// Relative residual asked.
        tolerance: f64,
    },
    /// A saved state is not one of this fluid's.
    #[error("failed to restore a saved state: {0}")]
    Restore(#[from] words::bytes::Error),
}
