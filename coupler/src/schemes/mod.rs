//! Coupling schemes, one file each, and a participant without a partner.
//!
//! A [`Solver`] solves and accepts one window; [`Run::drive`] is the loop over them, for a pair under its
//! scheme ([`Coupled`]) and for one side `alone`. A [`Run`] is a value: between two windows it can be saved
//! and gone back to.

pub mod accepted;
mod alone;
pub mod coupled;
pub mod extrapolation;
pub mod implicit;
pub mod pair;
pub mod parallel_explicit;
pub mod run;
pub mod serial_explicit;

pub use accepted::{Accepted, Onward, SchemeError};
pub use coupled::{Coupled, Scheme};
pub use pair::Pair;
pub use run::{InterfaceState, Run, Solver};
