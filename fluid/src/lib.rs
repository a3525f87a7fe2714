//! Incompressible SPH fluid (ISPH, projection method).

pub mod accounting;
pub mod conjugate_gradients;
pub mod contact;
pub mod correction;
pub mod error;
pub mod interface;
pub mod interface_load;
pub mod multigrid;
pub mod neighbourhood;
pub mod options;
pub mod participant;
pub mod position_projection;
pub mod preconditioner;
pub mod pressure_operator;
pub mod probes;
pub mod rows;
pub mod shifting;
pub mod state;
pub mod surface;
pub mod surface_offset;
pub mod taylor;
pub mod time_step;
pub mod velocity_correction;
pub mod viscosity;
pub mod walls;

pub use accounting::StepReport;
pub use conjugate_gradients::Outcome;
pub use error::Error;
pub use interface::{InterfaceInput, InterfaceOutput, InterfaceParticles};
pub use options::{Load, Options, Preconditioner, Scheme, ShiftingLaw, StructureVelocity, ViscousOperator};
pub use probes::{Probe, ProbeValue};
pub use state::{State, SurfaceClass};
pub use time_step::{Fluid, FluidProperties};
pub use walls::{Side, SurfacePoint, WallPart, WallShape, Walls};
