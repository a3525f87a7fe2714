//! The same messages without the protocol: what the transport alone takes, for `meniscus bench exchange` to
//! hold the exchange against.
//!
//! A message is copied into shared memory and out of it, and wakes the other side; nothing is checked, and
//! nobody is looked after.

use super::{Connection, SLICE};
use crate::protocol::{Kind, MessageHeader, Payload};
use crate::transport::link::{Link, Received};
use crate::{ParticipantError, Result};
use std::time::{Duration, Instant};

impl<L: Link> Connection<L> {
    /// Copies `values` into shared memory and sends them; wakes the other side if `wake`.
    pub fn send_raw(&mut self, kind: Kind, values: &[f64], wake: bool) -> Result<()> {
        let during = || "while sending".to_owned();
        let header = MessageHeader { kind: kind as u32, ..MessageHeader::default() };
        self.link.send(&header, &Payload { scalars: values, ..Payload::default() }, &during)?;
        if wake { self.link.wake(&during) } else { Ok(()) }
    }

    /// Waits for the next message and copies it into `values`, which are of its length; gives its kind.
    pub fn receive_raw(&mut self, deadline: Duration, values: &mut [f64]) -> Result<Kind> {
        let during = || "while waiting".to_owned();
        // The clock is looked at only where nothing has come: a wait that is woken costs what the transport
        // costs.
        let mut since = None;
        loop {
            if let Some(received) = self.link.take(&during)? {
                let kind = received.header().kind().ok_or_else(|| ParticipantError::Transport {
                    during: during(),
                    what: "a message of unknown kind".to_owned(),
                })?;
                let payload = received.payload();
                if !payload.is_empty() {
                    values.copy_from_slice(payload);
                }
                return Ok(kind);
            }
            if !self.link.wait(SLICE) && since.get_or_insert_with(Instant::now).elapsed() > deadline {
                return Err(ParticipantError::TimedOut { during: during(), seconds: deadline.as_secs_f64() });
            }
        }
    }
}
