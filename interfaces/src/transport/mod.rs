//! Shared memory between the coupler and one participant, by iceoryx2: no other module knows it.
//!
//! A [`Connection`] carries the messages of [`crate::protocol`] both ways, without loss and in order, wakes
//! the other side by events, and never waits without a deadline and a look at whether the other side lives.
//! The coupler creates the services of a connection before it starts the participant; the participant opens
//! them. Names and settings of the services are in `docs/protocol.md`.
//!
//! Everything a run leaves in shared memory belongs to a *node*, one a connection and side. Whoever finds a
//! dead node removes what it left: the survivors of a run when they notice, and any later run of the same
//! user when it starts. The last of a domain to go, or the first to come, removes what no node accounts for:
//! `presence`.

mod address;
mod connection;
mod peer;
mod presence;

pub use address::{Address, new_run};
pub use connection::{Connection, Message};
pub use iceoryx2::service::{Service, ipc, local};
pub use peer::{Alive, remove_stale};

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
