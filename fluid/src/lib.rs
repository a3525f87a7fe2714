//! Incompressible SPH fluid (ISPH, projection method).

mod accounting;
mod conjugate_gradients;
mod contact;
mod correction;
mod error;
mod interface;
mod interface_load;
mod neighbourhood;
mod options;
pub mod participant;
mod position_projection;
mod pressure_operator;
mod rows;
mod shifting;
mod state;
mod surface;
mod surface_offset;
mod taylor;
mod time_step;
mod velocity_correction;
mod viscosity;
mod walls;

pub use accounting::StepReport;
pub use conjugate_gradients::Solve;
pub use error::Error;
pub use interface::{InterfaceInput, InterfaceOutput, InterfaceParticles};
pub use options::{Load, Options, Preconditioner, Scheme, ShiftingLaw, ViscousOperator};
pub use state::{State, SurfaceClass};
pub use time_step::{Fluid, FluidProperties};
pub use walls::{Side, SurfacePoint, WallPart, WallShape, Walls};
