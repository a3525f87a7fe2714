//! What several rooms have to spell alike, once: words that a case and a solver both know, and states as bytes.
//!
//! This room knows no other, and any may know it.

pub mod bytes;
