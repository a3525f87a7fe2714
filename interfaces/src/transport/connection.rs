//! One side of a connection: send, and wait with a deadline.

mod raw;

use super::link::{Link, Received};
use super::peer::{Alive, Peer};
use super::{Address, Traffic};
use crate::protocol::{Kind, MessageHeader, Payload, VERSION, unpack, words};
use crate::{ParticipantError, Result};
use ::words::text::{EXPLANATION, tame};
use std::cell::Cell;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Between two looks at whether the other side lives and the run goes on.
const SLICE: Duration = Duration::from_millis(20);
/// For the end of one who takes no messages any more to be seen.
const LEAVING: Duration = Duration::from_millis(1500);
/// Between two attempts to open a link that is not there yet.
const RETRY: Duration = Duration::from_millis(20);

/// Both directions between the coupler and one participant, seen from one of them.
pub struct Connection<L: Link> {
    link: L,
    peer: Peer,
    stop: Arc<AtomicBool>,
    meter: Rc<Cell<Traffic>>,
}

impl<L: Link> Connection<L> {
    /// The coupler's side; it creates the link.
    pub fn create(address: &Address, stop: Arc<AtomicBool>) -> Result<Self> {
        Ok(Self::over(L::create(address)?, stop))
    }

    /// The participant's side; it opens the link, and waits for it until the deadline, or the end of the
    /// coupler as `alive` tells it.
    pub fn open(
        address: &Address,
        deadline: Duration,
        stop: Arc<AtomicBool>,
        mut alive: Alive,
    ) -> Result<Self> {
        let end = Instant::now() + deadline;
        let during = || format!("while looking for the coupler of {address}");
        let link = L::open(address, &mut || {
            if stop.load(Ordering::Relaxed) {
                return Err(ParticipantError::Interrupted { during: during() });
            }
            if Instant::now() >= end {
                let seconds = deadline.as_secs_f64();
                return Err(ParticipantError::TimedOut { during: during(), seconds });
            }
            if let Some(how) = alive() {
                return Err(ParticipantError::Died { during: format!("{} ({how})", during()) });
            }
            sleep(RETRY);
            Ok(())
        })?;
        let mut connection = Self::over(link, stop);
        connection.watch(alive);
        Ok(connection)
    }

    fn over(link: L, stop: Arc<AtomicBool>) -> Self {
        Self { link, peer: Peer::default(), stop, meter: Rc::default() }
    }

    /// Asks this of the process on the other side, besides what the link knows of it.
    pub fn watch(&mut self, alive: Alive) {
        self.peer.watch(alive);
    }

    /// What went through, kept up to date; stays readable after the connection has moved elsewhere.
    pub fn meter(&self) -> Rc<Cell<Traffic>> {
        Rc::clone(&self.meter)
    }

    fn count(&self, add: impl FnOnce(&mut Traffic)) {
        let mut traffic = self.meter.get();
        add(&mut traffic);
        self.meter.set(traffic);
    }

    /// Sends a message, and wakes the other side if `wake`. Does not wait. Counts of the payload are filled
    /// into the header. A field with a value that is not finite is an error ([`ParticipantError::Field`]),
    /// and nothing is sent.
    pub fn send(
        &mut self,
        header: MessageHeader,
        payload: &Payload<'_>,
        wake: bool,
        during: impl Fn() -> String,
    ) -> Result<()> {
        let started = Instant::now();
        let header = MessageHeader {
            scalars: payload.scalars.len() as u64,
            text_bytes: payload.text.len() as u64,
            ..header
        };
        if !self.link.send(&header, payload, &during)? {
            // Who takes nothing is mostly at its end, which is seen a moment after its ports are gone.
            let deadline = Instant::now() + LEAVING;
            self.look();
            while self.peer.end().is_none() && Instant::now() < deadline {
                sleep(RETRY);
                self.look();
            }
            return Err(match self.peer.end() {
                Some(how) => ParticipantError::Died { during: format!("{} ({how})", during()) },
                None => ParticipantError::Transport {
                    during: during(),
                    what: format!("nobody takes {}: not connected, or its buffer is full", header.name()),
                },
            });
        }
        if wake {
            self.link.wake(&during)?;
        }
        self.count(|traffic| {
            traffic.copying_seconds += started.elapsed().as_secs_f64();
            traffic.messages_sent += 1;
            traffic.bytes_sent += 8 * payload.len() as u64;
        });
        Ok(())
    }

    /// The next message that is there, whoever sent it and has gone.
    pub fn left(&mut self) -> Option<Message<L>> {
        let message = self.link.take(&String::new).ok().flatten().map(Message)?;
        message.check().is_ok().then_some(message)
    }

    /// Waits for the next message. `during` names what is waited for.
    pub fn receive(&mut self, deadline: Duration, during: impl Fn() -> String) -> Result<Message<L>> {
        let started = Instant::now();
        let message = self.wait(started, deadline, &during);
        self.count(|traffic| traffic.waiting_seconds += started.elapsed().as_secs_f64());
        let message = message?;
        self.count(|traffic| {
            traffic.messages_received += 1;
            traffic.bytes_received += 8 * message.payload().len() as u64;
        });
        message.check().map_err(|what| ParticipantError::Protocol { during: during(), what })?;
        Ok(message)
    }

    fn wait(
        &mut self,
        started: Instant,
        deadline: Duration,
        during: &impl Fn() -> String,
    ) -> Result<Message<L>> {
        loop {
            if let Some(received) = self.link.take(during)? {
                return Ok(Message(received));
            }
            // Before the other side's end: what interrupts a run often ends its participants too.
            if self.stop.load(Ordering::Relaxed) {
                return Err(ParticipantError::Interrupted { during: during() });
            }
            if let Some(how) = self.peer.end() {
                return Err(ParticipantError::Died { during: format!("{} ({how})", during()) });
            }
            let Some(left) = deadline.checked_sub(started.elapsed()).filter(|left| !left.is_zero()) else {
                return Err(ParticipantError::TimedOut { during: during(), seconds: deadline.as_secs_f64() });
            };
            // An interrupt by a signal is no wake-up: the flag says whether it concerns us.
            if !self.link.wait(left.min(SLICE)) {
                // What it sent before its end is still taken, by the look at the buffer that comes next.
                self.look();
            }
        }
    }

    /// Looks whether the other side has ended. What it left is removed.
    fn look(&mut self) {
        if self.peer.look(|| self.link.peer_end()) {
            self.link.clean_up();
        }
    }

    /// Counts time spent on copying a received message.
    pub(crate) fn copied(&self, since: Instant) {
        self.count(|traffic| traffic.copying_seconds += since.elapsed().as_secs_f64());
    }
}

/// A received message; its memory goes back to the sender when it is dropped.
pub struct Message<L: Link>(L::Received);

impl<L: Link> Message<L> {
    /// Its header.
    pub fn header(&self) -> &MessageHeader {
        self.0.header()
    }

    /// Its kind; [`Connection::receive`] refuses messages without one.
    pub fn kind(&self) -> Kind {
        self.header().kind().expect("a message of unknown kind is refused when it is received")
    }

    /// The doubles before the fields.
    pub fn scalars(&self) -> &[f64] {
        &self.payload()[..self.header().scalars as usize]
    }

    /// The doubles of the fields.
    pub fn fields(&self) -> &[f64] {
        let header = self.header();
        &self.payload()[header.scalars as usize..self.payload().len() - words(header.text_bytes as usize)]
    }

    /// The bytes of the text.
    pub fn text(&self) -> Vec<u8> {
        let bytes = self.header().text_bytes as usize;
        unpack(&self.payload()[self.payload().len() - words(bytes)..], bytes)
    }

    /// The text, for people: what a terminal can show, and no more than people read.
    pub fn words(&self) -> String {
        // A character has at most four bytes.
        let bytes = (self.header().text_bytes as usize).min(4 * EXPLANATION);
        let text =
            unpack(&self.payload()[self.payload().len() - words(self.header().text_bytes as usize)..], bytes);
        let mut tamed = tame(&String::from_utf8_lossy(&text), EXPLANATION);
        let left = self.header().text_bytes as usize - bytes;
        if left > 0 {
            tamed.push_str(&format!(" … ({left} more bytes)"));
        }
        tamed
    }

    fn payload(&self) -> &[f64] {
        self.0.payload()
    }

    /// Refuses a header whose counts do not fit the payload, and a kind that this version does not know. A
    /// handshake of another version is let through, for the version to be reported as what it is.
    fn check(&self) -> Result<(), String> {
        let header = self.header();
        let length = self.payload().len() as u64;
        let text = header.text_bytes.div_ceil(8);
        if header.scalars > length || text > length - header.scalars {
            return Err(format!(
                "{} of {length} doubles cannot hold {} scalars and {} bytes of text",
                header.name(),
                header.scalars,
                header.text_bytes
            ));
        }
        match header.kind() {
            Some(Kind::Hello | Kind::Welcome | Kind::Refused) => Ok(()),
            Some(_) if header.version == VERSION => Ok(()),
            Some(_) => Err(format!(
                "{} has protocol version {} where {VERSION} belongs",
                header.name(),
                header.version
            )),
            None => Err(format!("a {} came", header.name())),
        }
    }
}
