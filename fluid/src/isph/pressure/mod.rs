//! The pressure Poisson equation: its operator, its solution, and what its pressure does to velocities and
//! positions.

pub mod adjoint_pair;
pub mod along;
pub mod conjugate_gradients;
pub mod hierarchy;
pub mod multigrid;
pub mod position_projection;
pub mod preconditioner;
pub mod pressure_operator;
pub mod velocity_correction;
