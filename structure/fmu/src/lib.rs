//! The TLSPH structure of a case as a functional mock-up unit (FMU) for co-simulation, FMI 3.0 and FMI 2.0.
//!
//! One shared library serves both standards. An exported unit is an archive ([`package`]) with that library,
//! the case in `resources/case.toml`, and a `modelDescription.xml` ([`description`]) that is made of the same
//! table of [`variables`] that the library answers from.
//!
//! | layer | module |
//! |---|---|
//! | C functions of the standards | `fmi3`, `fmi2`, over `boundary` |
//! | one instance: life cycle, messages, states | [`instance`], [`phase`], [`saved`] |
//! | the structure, stepped | [`model`] |
//! | what can be read and set | [`variables`] |
//! | a few points that stand for all particles | [`reduction`] |
//! | the archive | [`package`], [`description`], [`library`], [`icon`] |
//! | the archive as a system (SSP) | [`system`] |
//!
//! A step of the master is a time window: the load given is held over it, and the structure sub-steps inside
//! it, as many times as the case's `coupling.sub_steps` says or as stability asks. Outputs are those at the
//! window's end; they do not depend on the inputs of the same instant, so there is no direct feed-through.
//! Nothing is given between a step's ends (`providesIntermediateUpdate` is false), and no directional
//! derivatives are: that of a step would be a second structure solver.
//!
//! No panic crosses the C boundary, and a pointer that is no living instance is answered with an error.

mod boundary;
pub mod description;
mod fmi2;
mod fmi3;
pub mod icon;
pub mod instance;
pub mod library;
pub mod model;
pub mod package;
pub mod phase;
pub mod reduction;
pub mod resources;
pub mod saved;
pub mod system;
pub mod variables;

/// The name of the shared library without the platform's ending, and the `modelIdentifier` of every unit.
pub const MODEL_IDENTIFIER: &str = "meniscus_structure";
