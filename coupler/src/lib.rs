//! Couples a fluid and a structure: time windows, sub-steps, condition (46), launching of participants,
//! records.
//!
//! Start at [`schemes::serial_explicit`], what is done in a window, [`schemes::implicit`], the same iterated,
//! and [`schemes::run`], the loop over windows, whose run is a value that can be saved between two of them.
//! They see participants and slices: no socket, no file, no wall clock, and neither solver by name.
//! [`schedule`] keeps the time, [`condition46`] the balance along the normals. [`mapping`] carries motion and
//! forces between point sets that do not match; [`mapped`] puts a structure behind one, or a fluid. The loop
//! announces its [`phase`]s, and [`timing`] has the clock. [`placement`] puts the processes on one core where
//! that is faster. [`board`] keeps what everybody is at, [`status`] tells it, [`request`] is what a run may
//! be asked for while it goes on. [`scenario`] changes what crosses, and has participants fail. [`mod@bench`]
//! measures what all of it takes.
//! [`recording`] keeps what crosses to a participant, and plays it back in its place.

pub mod acceleration;
pub mod bench;
pub mod board;
pub mod condition46;
pub mod convergence;
pub mod flat;
pub mod launch;
pub mod mapped;
pub mod mapping;
pub mod phase;
pub mod placement;
pub mod progress;
pub mod recording;
pub mod records;
pub mod request;
pub mod run;
pub mod scenario;
pub mod schedule;
pub mod schemes;
pub mod side;
pub mod status;
pub mod steady_state;
pub mod timing;
pub mod trace;
