//! Mock fluids: they take motion and give loads.

mod added_mass_column;
mod constant;
mod harmonic;
mod hydrostatic;
mod load;
mod surface_pressure;

pub use added_mass_column::{AddedMassColumn, GivenVelocity, WallModel};
pub use constant::Constant;
pub use harmonic::Harmonic;
pub use hydrostatic::Hydrostatic;
pub use load::Load;
pub use surface_pressure::SurfacePressure;
