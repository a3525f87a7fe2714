//! Mock structures: they take loads and give motion.

mod points;
mod prescribed;
mod rigid;
mod spring_mass;

pub use points::Points;
pub(crate) use points::components;
pub use prescribed::{Law, Prescribed};
pub use rigid::Rigid;
pub use spring_mass::{Integration, SpringMass};
