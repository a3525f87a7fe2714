//! Mock partners for either side of a coupling, and the conformance suite that every participant passes.
//!
//! A mock is a [`Model`] (a few lines of physics whose state is one vector) inside a [`StandIn`], which keeps
//! the accepted state and the trial and so fulfils the contract of [`interfaces::Participant`]. Start at
//! [`stand_in`], then [`structure`] and [`fluid`]; [`spec`] makes any of them from command-line words. Around
//! any participant: [`Recording`] keeps its calls, [`Faulty`] breaks it at a chosen place. [`Scripted`] plays
//! a fixed part and complains when the coupler leaves it. [`conformance::check`] holds a participant to the
//! contract, ours or a user's.
//!
//! Mocks do not watch the order of calls: put them behind [`interfaces::Guarded`], as every participant.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `V`, `ρ` | reference volume and density of an interface point | m³, kg/m³ |
//! | `m_s = Σ ρ V` | mass of the structure | kg |
//! | `k`, `c` | spring and damper of the structure | N/m, N s/m |
//! | `m_a`, `μ = m_a/m_s` | mass of the fluid that moves along, and its ratio to the structure's | kg, 1 |
//! | `∇p`, `F = −Σ V ∇p` | load, and its force on the structure | Pa/m, N |
//! | `r` | relaxation of the load | 1 |
//! | `Δt`, `ω` | time window; angular frequency of the wet structure | s, 1/s |

pub mod conformance;
pub mod faulty;
pub mod fluid;
pub mod idle;
pub mod recording;
pub mod scripted;
pub mod spec;
pub mod stand_in;
pub mod structure;

pub use faulty::{Fault, Faulty};
pub use fluid::{
    AddedMassColumn, Constant, GivenVelocity, Harmonic, Hydrostatic, SurfacePressure, WallModel,
};
pub use idle::Idle;
pub use recording::{Log, Recorded, Recording};
pub use scripted::{Script, Scripted};
pub use spec::{MockSpec, build, help};
pub use stand_in::{Model, StandIn};
pub use structure::{Integration, Law, Points, Prescribed, Rigid, SpringMass};
