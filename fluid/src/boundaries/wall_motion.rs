//! Walls that move by a prescribed law: a gate that lifts, a tank that rolls.
//!
//! The law is a number over time: a distance (m) along a direction, or an angle (rad) about a pivot. A wall's
//! particles and its shape are where the law puts them at the start of a step, and meet the fluid with their
//! mean velocity over it.

pub use words::motion::Law;
pub use words::rigid::{Motion, Pose};
