//! Incompressible SPH fluid (ISPH, projection method).

pub mod conjugate_gradients;
pub mod multigrid;
