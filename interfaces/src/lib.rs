//! What travels between participants, and what is promised. No physics.
//!
//! Start at [`participant`], the contract every participant fulfils: our solvers in the same process, solvers
//! behind shared memory, mocks, and whatever a user brings. [`lifecycle`] holds the one table of which call
//! is legal when, [`guarded`] holds participants to it, [`port`] and [`fields`] what travels, [`window`]
//! when. [`case`] is the case file. The bytes are in `docs/protocol.md`.
//!
//! | term | meaning |
//! |---|---|
//! | participant | one solver in a coupling: the fluid, the structure, or a stand-in |
//! | coupler | the process that sets the time windows and carries the fields between participants |
//! | time window | the span of time after which fields are exchanged |
//! | iteration | one solution of a window; a window may be solved again from the same accepted state |
//! | sub-step | a participant's own time step inside a window |
//! | port | one field that a participant takes or gives at its interface points |
//! | interface point | a structure particle that the fluid may touch; all ports of an interface have the same points |

pub mod case;
pub mod fields;
pub mod guarded;
pub mod lifecycle;
pub mod pairing;
pub mod participant;
pub mod port;
pub mod protocol;
pub mod remote;
pub mod serve;
pub mod transport;
pub mod window;

pub use case::Case;
pub use fields::{FieldError, Fields};
pub use guarded::{Guarded, Lifecycle};
pub use lifecycle::{Call, IllegalCall, State};
pub use participant::{
    Description, END_REQUESTED, Participant, ParticipantError, Readiness, Result, Role, Scalar, ScalarKind,
    WindowReport,
};
pub use port::{Direction, Exchange, Port, Quantity};
pub use remote::{Expectations, Listening, RemoteParticipant};
pub use serve::{ServeError, serve, serve_over};
pub use transport::{Address, Deadlines, Traffic, new_run, remove_stale};
pub use window::{SubSteps, TimeWindow};
