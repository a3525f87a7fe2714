//! Functional mock-up units (FMUs) as participants: co-simulation, FMI 2.0 and FMI 3.0.
//!
//! A case names a unit for either side, and, where names differ, the variables behind its ports. The command
//! serves it to the coupler in a process of its own, so that a crash of foreign code is the end of that
//! process alone.
//!
//! ```text
//! unit.fmu ── archive (unpacked) ── description (what there is) ── wiring (ports ↔ variables, all mismatches)
//!                              └─── fmi3, fmi2 (C functions) ───── participant (the contract)
//! ```
//!
//! | module | what it is |
//! |---|---|
//! | [`archive`] | the zip file: unpacked beside the outputs, with the library of this platform |
//! | [`description`] | `modelDescription.xml` of either version, as far as it is needed |
//! | [`wiring`] | which variables are behind which port, and what is recorded |
//! | [`mod@unit`] | what an instance can do, whatever its version: `fmi3` and `fmi2` |
//! | [`participant`] | an instance as an [`interfaces::Participant`]; a window is a step |
//!
//! Solving a window again needs the unit's state back (`canGetAndSetFMUState`). A unit that cannot give it
//! takes part in explicit schemes without prediction; more is refused with a remedy.

pub mod archive;
pub mod description;
mod error;
mod fmi2;
mod fmi3;
mod instantiate;
pub mod participant;
mod saved;
pub mod unit;
pub mod wiring;

pub use error::Error;
pub use participant::{open, preview};
