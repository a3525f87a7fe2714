//! Fluids of particles between walls and elastic structures. One method stands: incompressible SPH (ISPH,
//! projection method) with free surfaces.
//!
//! | what | where |
//! |---|---|
//! | particles of any fluid: state, neighbours and kernel sums, order in memory, balances | [`particles`] |
//! | what bounds them: walls and their motion, periodic sides, contact | [`boundaries`] |
//! | the structure's particles as the fluid sees them, and what it gives back | [`interface`] |
//! | values at points, the fluid in a box | [`probes`] |
//! | the method: time step, pressure, surface, viscosity, shifting | [`isph`] |
//! | what a method has to be for the participant to run it | [`Fluid`] in [`method`] |
//! | case, messages, snapshots: the only files that know the world outside | [`participant`] |
//!
//! Start reading at [`Isph::step_watched`] in [`isph::step`]: it is the algorithm of the paper (Salehizadeh
//! and Shafiei 2022, "A coupled ISPH-TLSPH method for simulating fluid-elastic structure interaction
//! problems"), a line each stage; [`isph`] says in which file each stage stands. A [`State`] holds all that
//! the next step depends on, the method's memory included: [`Fluid::step`] takes an accepted state and makes
//! a trial state, as often as wanted, with the same bits each time and for any number of threads. Nothing but
//! the participant knows a process, a file, a clock or a message.
//!
//! Where the method departs from the paper and what forced it, what was tried, and what a step costs stand
//! with their numbers in `docs/fluid.md`.
//!
//! # Notation
//!
//! | symbol | meaning | unit | shape |
//! |---|---|---|---|
//! | `a`, `b` | fluid particles; `w` wall, `s` structure particle | – | index |
//! | `r_ab = r_a − r_b`, `e_ab` | offset, its unit vector | m, – | `Vector<D>` |
//! | `∇W_ab` | kernel gradient with respect to `r_a`: points towards `b` | m⁻ᴰ⁻¹ | `Vector<D>` |
//! | `V`, `V_w`, `V_s` | volumes (one metre of depth in two dimensions) | m³ | scalar |
//! | `n`, `n₀` | `Σ V W`, the same on the lattice | 1 | scalar |
//! | `∇·r` | `−Σ V r_ab·∇W_ab`, `D` inside | 1 | scalar |
//! | `α` | surface smoothing, 0 on the surface, 1 inside | 1 | scalar |
//! | `B` | correction of kernel gradients | 1 | `Matrix<D>` |
//! | `D u` | divergence | 1/s | scalar per particle |
//! | `A`, `L` | `D M⁻¹ Dᵀ`; compact Laplacian times `1/ρ` | m³/kg/m² | operator |
//! | `u*` | velocity without pressure at the step's end | m/s | `Vector<D>` |
//! | `g_s`, `R_s` | load on the structure and reaction as pressure gradients: forces `−V_s g_s` on it, `+V_s R_s` on the fluid | Pa/m | `Vector<D>` |
//! | `φ`, `θ` | share of Eq. (18) that surroundings and energy allow | 1 | scalar |
//!
//! # The structure in a step
//!
//! The interface brings positions at the window's start, the mean velocity over the window that the structure
//! is predicted to have under the load held from the last window, and that load. The held load is taken back,
//! `u*_s = u_s + ½Δt g_held/ρ_s`, and the structure takes part in the pressure solve with its mass: it yields
//! by `−½Δt g_s/ρ_s` (`compliance`). With the velocity at the window's end ([`StructureVelocity::End`]) the
//! halves are ones; why the mean is met by default stands in `docs/decisions/0003-mean-velocity.md`. The load
//! is the transpose of the divergence through which `u_s` enters, with the share φ of Eq. (18) as a sum over
//! the structure's surface ([`isph::interface_load`]), so [`InterfaceOutput`] holds `R_s = g_s` to rounding.
//! Contact (particles of known pressure that would run into the structure) and no-slip friction are counted
//! in `R_s` and are **not** part of `g_s`. How boundaries carry the pressure, and why water at rest stays at
//! rest beside them, is in `docs/decisions/0013-boundary-gradient.md`.

pub mod boundaries;
pub mod error;
pub mod interface;
pub mod isph;
pub mod method;
// Left out of unit tests, none of which needs it: it compiles every method for every dimension once more.
#[cfg(not(test))]
pub mod participant;
pub mod particles;
pub mod probes;
pub mod properties;
pub mod report;

pub use boundaries::wall_motion::{Law, Motion};
pub use boundaries::walls::{Side, SurfacePoint, WallPart, WallShape, Walls};
pub use error::Error;
pub use interface::{InterfaceInput, InterfaceOutput, InterfaceParticles};
pub use isph::options::{
    Load, LostParticles, Options, Preconditioner, Scheme, ShiftingLaw, StructureVelocity, Tearing,
    ViscousOperator,
};
pub use isph::solver::Isph;
pub use isph::state::State;
pub use isph::step::Stage;
pub use method::Fluid;
pub use particles::class::SurfaceClass;
pub use probes::{Probe, ProbeValue};
pub use properties::FluidProperties;
pub use report::{Outcome, StepReport};
