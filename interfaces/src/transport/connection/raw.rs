//! The same messages without the protocol: what the transport alone takes, for `meniscus bench exchange` to
//! hold the exchange against.
//!
//! A message is copied into shared memory and out of it, and wakes the other side; nothing is checked, and
//! nobody is looked after.

use super::{Connection, SLICE};
use crate::ParticipantError;
use crate::protocol::{Kind, MessageHeader};
use iceoryx2::service::Service;
use std::time::{Duration, Instant};

impl<S: Service> Connection<S> {
    /// Copies `values` into shared memory and sends them; wakes the other side if `wake`.
    pub fn send_raw(&mut self, kind: Kind, values: &[f64], wake: bool) -> Result<(), ParticipantError> {
        let failed = |what: String| ParticipantError::Transport { during: "while sending".to_owned(), what };
        let loaned = self.publisher.loan_slice_uninit(values.len());
        let mut sample = loaned.map_err(|e| failed(format!("{e:?}")))?;
        sample.user_header_mut().kind = kind as u32;
        let sample = sample.write_from_slice(values);
        sample.send().map_err(|e| failed(format!("{e:?}")))?;
        if wake {
            self.notifier.notify().map_err(|e| failed(format!("{e:?}")))?;
        }
        Ok(())
    }

    /// Waits for the next message and copies it into `values`, which are of its length; gives its kind.
    pub fn receive_raw(&mut self, deadline: Duration, values: &mut [f64]) -> Result<Kind, ParticipantError> {
        let during = || "while waiting".to_owned();
        let failed = |what: String| ParticipantError::Transport { during: during(), what };
        // The clock is looked at only where nothing has come: a wait that is woken costs what the transport
        // costs.
        let mut since = None;
        loop {
            if let Some(sample) = self.subscriber.receive().map_err(|e| failed(format!("{e:?}")))? {
                let header: &MessageHeader = sample.user_header();
                let kind = header.kind().ok_or_else(|| failed("a message of unknown kind".to_owned()))?;
                let payload = sample.payload();
                if !payload.is_empty() {
                    values.copy_from_slice(payload);
                }
                return Ok(kind);
            }
            let woken = self.listener.timed_wait(|_| {}, SLICE).unwrap_or(0);
            if woken == 0 && since.get_or_insert_with(Instant::now).elapsed() > deadline {
                return Err(ParticipantError::TimedOut { during: during(), seconds: deadline.as_secs_f64() });
            }
        }
    }
}
