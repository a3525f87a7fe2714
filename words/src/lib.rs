//! What several rooms have to spell alike, once: words that a case and a solver both know, names of balances,
//! states as bytes, and what text from outside may hold.
//!
//! This room knows no other, and any may know it.

pub mod balances;
pub mod bytes;
pub mod coupling;
pub mod geometry;
pub mod motion;
pub mod probe;
pub mod rigid;
pub mod text;
