//! What crossed between the coupler and its participants, kept and played back.
//!
//! A [`Recording`] is the file of a run, a [`Recorder`] the participant before which all that crosses is
//! written to it. A [`Replay`] reads it and stands in for one side: it gives what that side gave, to the bit,
//! and says where what it is given departs from what that side was given. The program of a recorded side
//! need not be there any more.
//!
//! [`mod@file`] has the bytes: blocks with checksums, of which those before a cut are read. [`entry`] is what
//! stands in them, a call each; [`departure`] compares. For users: `docs/record.md`.

pub mod departure;
pub mod entry;
pub mod file;
pub mod recorder;
pub mod replay;

pub use departure::{Departure, Departures};
pub use file::{Error, Header};
pub use recorder::{Kept, Recorder, Recording};
pub use replay::{OnDeparture, Replay};
