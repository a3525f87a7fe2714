//! The total-Lagrangian method.

mod external;
mod field;
mod ganzenmuller2015;
mod gradient;
mod kernels;
mod numbering;
mod stability;
mod stencil;
pub mod step;
pub mod total_lagrangian;
