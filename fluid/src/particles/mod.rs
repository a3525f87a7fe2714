//! The particles of any fluid: what they carry, who surrounds whom, their order in memory, their balances.

pub mod accounting;
pub mod class;
pub mod neighbourhood;
pub mod order;
pub mod rows;
pub mod state;
