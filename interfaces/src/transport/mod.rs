//! The way between the coupler and one participant.
//!
//! A [`Connection`] carries the messages of [`crate::protocol`] both ways, without loss and in order, wakes
//! the other side, and never waits without a deadline and a look at whether the other side lives. What a
//! transport has to do for it is a [`Link`]; [`SharedMemory`] is the one between processes, [`WithinProcess`]
//! the same within one, for tests. Both are iceoryx2's, which no module but `iceoryx2` knows.
//!
//! The coupler creates a link before it starts the participant; the participant opens it.

mod address;
mod connection;
mod iceoryx2;
mod link;
mod peer;

pub use self::iceoryx2::{SharedMemory, WithinProcess, remove_stale};
pub use address::{Address, FOLDER, new_run};
pub use connection::{Connection, Message};
pub use link::{During, Link, Received};
pub use peer::Alive;

use std::time::Duration;

/// How long one side waits for the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deadlines {
    /// For the other side to appear and for the handshake.
    pub hello: Duration,
    /// For the answer to a request.
    pub answer: Duration,
}

impl Default for Deadlines {
    fn default() -> Self {
        Self { hello: Duration::from_secs(30), answer: Duration::from_secs(60) }
    }
}

impl Deadlines {
    /// For the first request. After a participant's handshake the coupler may have to wait for the other one
    /// to appear and to answer; twice, where that one initialises before it solves.
    pub fn first_request(&self) -> Duration {
        self.hello + 2 * self.answer
    }

    /// For every other request, between two of which the coupler may have to wait for two answers of the
    /// other participant, and needs a moment for its own work.
    pub fn next_request(&self) -> Duration {
        2 * self.answer + Duration::from_secs(1)
    }
}

/// What went through one connection, seen from one side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traffic {
    /// Wall time spent waiting for messages (s).
    pub waiting_seconds: f64,
    /// Wall time spent copying fields into and out of shared memory, and sending (s).
    pub copying_seconds: f64,
    /// Messages sent.
    pub messages_sent: u64,
    /// Messages received.
    pub messages_received: u64,
    /// Bytes of payload sent.
    pub bytes_sent: u64,
    /// Bytes of payload received.
    pub bytes_received: u64,
}
