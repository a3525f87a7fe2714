//! Incompressible SPH by projection (ISPH).

pub mod correction;
pub mod interface_load;
pub mod options;
pub mod pressure;
pub mod shifting;
pub mod solver;
pub mod state;
pub mod step;
pub mod surface;
pub mod taylor;
pub mod viscosity;
