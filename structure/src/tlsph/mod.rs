//! Total-Lagrangian SPH: neighbours, weights and stresses in the reference configuration.
//!
//! Start at [`step`], the Runge–Kutta step over the sub-steps of one window. Below it: `kernels` (stresses
//! from displacements, accelerations from stresses), on [`total_lagrangian`]'s arrays in the order of
//! `numbering`, with the neighbours and weights of `stencil`, which one of the operators in `gradient` has
//! made; `patches` keep nearly incompressible bodies from locking. `stability` finds the stable step;
//! `clamps` moves what is fixed, `contacts` adds what surfaces do to each other. `transfer` and `derived`
//! lead from a state to those arrays and back.

mod clamps;
mod contacts;
mod derived;
mod field;
mod ganzenmuller2015;
mod gradient;
mod kernels;
mod numbering;
mod patches;
mod stability;
mod stencil;
pub mod step;
mod tasks;
pub mod total_lagrangian;
mod transfer;
