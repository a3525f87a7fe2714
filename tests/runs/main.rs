//! The `meniscus` command as a user runs it: the case file with all its sections, results, ends of every
//! kind, mistakes, and the coupling loop on partners that are known.
//!
//! One executable, so that the tests share the cores and the support. Every run has a folder and a domain of
//! shared memory of its own, which must be empty afterwards; every process has a watchdog.

mod bench;
mod case;
mod chaos;
mod check;
mod column;
mod command;
mod coupling;
mod faults;
mod gate;
mod implicit;
mod mapped;
mod outputs;
mod probes;
mod processes;
mod python;
mod record;
mod resources;
mod restart;
mod rolling;
mod scenario;
mod solvers;
mod status;
mod support;
mod sweep;
mod unit;
mod within;
