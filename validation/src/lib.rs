//! Cases held against references: each is run at several resolutions, and what comes out is compared with the
//! true value and with the paper's.
//!
//! A case folder that holds a `validation.toml` takes part. [`study`] says what stands in it: *series* (a
//! case with overrides, at several resolutions) and *measures* (a number made of a column of `probes.csv`,
//! with its reference and tolerance). [`mod@run`] runs every variant in this process and takes the measures;
//! [`tables`] writes them for the terminal and as `validation.csv`, [`page`] as `validation.html`.
//!
//! Start reading at [`study::Study`], then [`run::run`]. No solver is known here: the caller hands over how a
//! participant is made.
//!
//! | notation | meaning |
//! |---|---|
//! | resolution `n` | particles along the study's `length`: `Δx = length / n` |
//! | error | found / reference − 1: over zero is too much; found − reference where the reference is zero |
//! | order `p` | of the measure's own convergence, `f(Δx) = f0 + C Δxᵖ` through its three finest resolutions |
//! | judged | whether a measure that misses its tolerance fails the command; the default operator's are |

mod course;
mod measure;
mod order;
pub mod page;
pub mod run;
pub mod study;
pub mod sweep;
pub mod tables;

pub use measure::MeasureError;
pub use order::{Convergence, convergence};
pub use run::{Options, run};
pub use study::Study;
