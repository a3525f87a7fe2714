//! Mock fluids: they take motion and give loads.

mod added_mass_column;
mod constant;
mod hydrostatic;
mod load;

pub use added_mass_column::{AddedMassColumn, GivenVelocity, WallModel};
pub use constant::Constant;
pub use hydrostatic::Hydrostatic;
pub use load::Load;
