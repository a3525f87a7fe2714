//! What a transport does for a connection: one side of a link between the coupler and one participant.
//!
//! [`super::Connection`] is the same over every link: deadlines, the handshake's forms, counts of what went
//! through. A link carries messages whole, in order and without loss, lends their memory on both ends, and
//! knows as much of the other side as its means tell.

use super::Address;
use crate::Result;
use crate::protocol::{MessageHeader, Payload};
use std::time::Duration;

/// Says what was being done, for an error.
pub type During<'a> = &'a dyn Fn() -> String;

/// One side of a link. Nothing here waits without a limit.
pub trait Link: Sized {
    /// A received message, which lies where the transport put it and goes back when it is dropped.
    type Received: Received;

    /// The coupler's side, which the other one can find from then on.
    fn create(address: &Address) -> Result<Self>;

    /// The participant's side. `again` is called after each attempt that did not find the coupler: it waits a
    /// moment, or says why there shall be no other.
    fn open(address: &Address, again: &mut dyn FnMut() -> Result<()>) -> Result<Self>;

    /// Sends a message, its payload written straight into the memory that travels. Does not wait, and does
    /// not wake the other side. Says whether anybody takes it. A field with a value that is not finite is an
    /// error ([`Field`](crate::ParticipantError::Field)), and nothing is sent.
    fn send(&mut self, header: &MessageHeader, payload: &Payload<'_>, during: During<'_>) -> Result<bool>;

    /// Wakes the other side where it [waits](Link::wait).
    fn wake(&self, during: During<'_>) -> Result<()>;

    /// The next message that is there. One is held at a time: what it lends has to be dropped before the
    /// next.
    fn take(&mut self, during: During<'_>) -> Result<Option<Self::Received>>;

    /// Sleeps until the other side wakes this one, at most so long. Says whether it did; an interrupt by a
    /// signal is no wake-up.
    fn wait(&mut self, at_most: Duration) -> bool;

    /// How the other side ended, as far as the transport can tell; nothing while it lives, or was never seen.
    fn peer_end(&mut self) -> Option<String>;

    /// Removes what a peer left that has ended.
    fn clean_up(&self);
}

/// What was received.
pub trait Received {
    /// The header.
    fn header(&self) -> &MessageHeader;

    /// The doubles behind it.
    fn payload(&self) -> &[f64];
}
