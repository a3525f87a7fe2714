//! Mocks, the conformance suite over them, and the added-mass instability between them.

mod added_mass;
mod conformance;
mod mocks;
