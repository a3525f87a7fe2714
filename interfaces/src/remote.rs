//! The coupler's side of a participant in another process.

use crate::protocol::{
    Hello, Kind, MessageHeader, NO_SNAPSHOT, PIECE, Payload, ReadError, Selection, VERSION, Welcome,
};
use crate::transport::{Address, Alive, Connection, Deadlines, Link, Message, SharedMemory, Traffic};
use crate::{
    Description, Fields, Participant, ParticipantError, Readiness, Result, TimeWindow, WindowReport,
};
use std::cell::Cell;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use words::text::{EXPLANATION, NAME, tame};

/// Longest description of a participant that is read (bytes).
const HELLO: u64 = 16 << 20;

/// What the coupler knows of the case, for a participant to fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expectations {
    /// Hash of the case.
    pub case_hash: String,
    /// Space dimension.
    pub dimension: usize,
}

/// A coupler that a participant can find, before there is one.
pub struct Listening<L: Link = SharedMemory> {
    connection: Connection<L>,
    address: Address,
    expectations: Expectations,
    deadlines: Deadlines,
}

/// A participant in another process. It asks that process and checks the form of what comes back, and that
/// all fields that cross are finite; put it behind [`crate::Guarded`], as any other participant, for the
/// order of calls.
///
/// Dropped without [`Participant::terminate`], it tells the process that nothing more is wanted.
pub struct RemoteParticipant<L: Link = SharedMemory> {
    connection: Connection<L>,
    description: Description,
    deadlines: Deadlines,
    sequence: u64,
    window: Option<TimeWindow>,
    ended: bool,
}

impl RemoteParticipant {
    /// Creates what the participant connects to. Do this before its process is started.
    pub fn listen(
        address: &Address,
        expectations: Expectations,
        deadlines: Deadlines,
        stop: &Arc<AtomicBool>,
    ) -> Result<Listening> {
        Listening::over(address, expectations, deadlines, stop)
    }
}

impl<L: Link> Listening<L> {
    /// [`RemoteParticipant::listen`], over any link: tests use the one within a process.
    pub fn over(
        address: &Address,
        expectations: Expectations,
        deadlines: Deadlines,
        stop: &Arc<AtomicBool>,
    ) -> Result<Self> {
        let connection = Connection::create(address, Arc::clone(stop))?;
        Ok(Self { connection, address: address.clone(), expectations, deadlines })
    }

    /// Waits for the participant and shakes hands. `alive` says how its process ended, where the caller
    /// started one; it is asked about fifty times a second in this and all later waits.
    pub fn wait_for_hello(mut self, alive: Alive) -> Result<RemoteParticipant<L>> {
        let during = || "while connecting".to_owned();
        self.connection.watch(alive);
        let message = self.connection.receive(self.deadlines.hello, during)?;
        if message.kind() != Kind::Hello {
            return Err(unexpected(&message, "`Hello`", during()));
        }
        match self.check(&message) {
            Ok(description) => {
                let Expectations { case_hash, dimension } = self.expectations;
                let welcome = serde_json::to_string(&Welcome { case_hash, dimension })
                    .expect("a string and a number have no value that JSON cannot hold");
                drop(message);
                let payload = Payload::text(welcome.as_bytes());
                self.connection.send(MessageHeader::new(Kind::Welcome, 0), &payload, true, during)?;
                Ok(RemoteParticipant {
                    connection: self.connection,
                    description,
                    deadlines: self.deadlines,
                    sequence: 0,
                    window: None,
                    ended: false,
                })
            }
            Err(mismatches) => {
                let lines = mismatches.join("\n");
                let payload = Payload::text(lines.as_bytes());
                // The mismatch is the error to report, whether or not the participant still hears of it.
                let _ = self.connection.send(MessageHeader::new(Kind::Refused, 0), &payload, true, during);
                // It hears of it for certain only while we are here; it answers with `Goodbye`.
                let _ = self.connection.receive(self.deadlines.hello, during);
                Err(ParticipantError::Mismatch(mismatches))
            }
        }
    }

    /// The participant's description, or every mismatch with both sides' values.
    fn check(&self, message: &Message<L>) -> Result<Description, Vec<String>> {
        let mut mismatches = Vec::new();
        let mut compare = |what: &str, ours: &str, theirs: &str| {
            if ours != theirs {
                mismatches.push(format!("{what}: the coupler has {ours}, the participant has {theirs}"));
            }
        };
        compare("protocol version", &VERSION.to_string(), &message.header().version.to_string());
        if message.header().text_bytes > HELLO {
            let bytes = message.header().text_bytes;
            mismatches
                .push(format!("description: it has {bytes} bytes, more than the {HELLO} that are read"));
            return Err(mismatches);
        }
        let hello: Hello = match serde_json::from_slice(&message.text()) {
            Ok(hello) => hello,
            Err(error) => {
                let error = tame(&error.to_string(), EXPLANATION);
                mismatches.push(format!("description: it cannot be read: {error}"));
                return Err(mismatches);
            }
        };
        let theirs = hello.description;
        compare("role", &self.address.role.to_string(), &theirs.role.to_string());
        compare("case hash", &self.expectations.case_hash, &tame(&hello.case_hash, NAME));
        compare("dimension", &self.expectations.dimension.to_string(), &theirs.dimension.to_string());
        mismatches.extend(theirs.mistakes());
        if mismatches.is_empty() { Ok(theirs) } else { Err(mismatches) }
    }
}

impl<L: Link> RemoteParticipant<L> {
    /// What went through the connection, seen from here and kept up to date; stays readable after the
    /// participant has moved into a box.
    pub fn meter(&self) -> Rc<Cell<Traffic>> {
        self.connection.meter()
    }

    /// Sends a request.
    fn request(
        &mut self,
        header: impl Fn(u64) -> MessageHeader,
        payload: &Payload<'_>,
        wake: bool,
        during: impl Fn() -> String,
    ) -> Result<()> {
        if self.ended {
            return Err(ParticipantError::Protocol {
                during: during(),
                what: "the connection has ended".into(),
            });
        }
        self.sequence += 1;
        match self.connection.send(header(self.sequence), payload, wake, during) {
            // Nothing was sent, and the other process knows of nothing.
            Err(error @ ParticipantError::Field(_)) => {
                self.sequence -= 1;
                Err(error)
            }
            Err(error) => {
                // The reason may have come before the end did.
                let failed = self.connection.left().filter(|message| message.kind() == Kind::Failed);
                let error = failed.map_or(error, |message| ParticipantError::Failed(message.words()));
                Err(self.broken(error))
            }
            Ok(()) => Ok(()),
        }
    }

    /// Waits for the answer to an `Initialize` or `Restore`, and takes what it gives.
    fn ready(
        &mut self,
        kind: Kind,
        selection: Selection,
        outputs: &mut Fields,
        during: impl Fn() -> String,
    ) -> Result<Readiness> {
        let message = self.answer(kind, &during)?;
        let scalars = scalars(&message, &self.description, &during)?;
        let readiness = Readiness { window_limit: message.header().size, scalars };
        read(&self.connection, &message, selection, outputs, during)?;
        Ok(readiness)
    }

    /// Waits for the answer to the last request; for `Solved`, of the window that was started.
    fn answer(&mut self, kind: Kind, during: impl Fn() -> String) -> Result<Message<L>> {
        self.matching(kind, during).map_err(|error| self.broken(error))
    }

    fn matching(&mut self, kind: Kind, during: impl Fn() -> String) -> Result<Message<L>> {
        let mut expected = MessageHeader::new(kind, self.sequence);
        if let (Kind::Solved, Some(window)) = (kind, self.window) {
            (expected.window, expected.iteration) = (window.index, window.iteration);
        }
        loop {
            let message = self.connection.receive(self.deadlines.answer, &during)?;
            let found = *message.header();
            let fits = message.kind() == kind
                && (found.sequence, found.window, found.iteration)
                    == (expected.sequence, expected.window, expected.iteration);
            match message.kind() {
                _ if fits => return Ok(message),
                Kind::Failed => return Err(ParticipantError::Failed(message.words())),
                // Told to end while it solved, a participant still gives its solution first.
                Kind::Solved if kind == Kind::Terminated && found.sequence < self.sequence => {}
                _ => return Err(unexpected(&message, &expected.name(), during())),
            }
        }
    }

    /// Ends the connection after an error, so that nobody waits for another deadline. A run that is
    /// interrupted may still end its participants in order.
    fn broken(&mut self, error: ParticipantError) -> ParticipantError {
        if !matches!(error, ParticipantError::Interrupted { .. }) {
            self.goodbye();
        }
        error
    }

    /// Ends the connection for the participant, whatever it does.
    fn goodbye(&mut self) {
        if !self.ended {
            self.ended = true;
            // Who is gone cannot be told; and nothing more is wanted of it.
            let header = MessageHeader::new(Kind::Goodbye, self.sequence);
            let _ = self.connection.send(header, &Payload::default(), true, String::new);
        }
    }
}

impl<L: Link> Participant for RemoteParticipant<L> {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        let during = || "while initialising".to_owned();
        let ports = inputs.ports().iter().chain(outputs.ports());
        let points: Vec<f64> = ports.map(|port| port.points.unwrap_or(0) as f64).collect();
        let payload = Payload { scalars: &points, fields: Some((inputs, Selection::All)), text: &[] };
        let header =
            |sequence| MessageHeader { time: start, ..MessageHeader::new(Kind::Initialize, sequence) };
        self.request(header, &payload, true, during)?;
        self.ready(Kind::Ready, Selection::All, outputs, during)
    }

    fn refuses_not_finite(&self) -> bool {
        true
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        let payload = Payload { fields: Some((inputs, Selection::EveryWindow)), ..Payload::default() };
        let header = |sequence| MessageHeader::start(sequence, window);
        self.request(header, &payload, true, || solving(window))?;
        self.window = Some(*window);
        Ok(())
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        let Some(window) = self.window else {
            let during = "while finishing a window".to_owned();
            return Err(ParticipantError::Protocol { during, what: "no window was started".to_owned() });
        };
        let during = || solving(&window);
        let message = self.answer(Kind::Solved, during)?;
        let header = message.header();
        let seconds = header.compute_seconds;
        if !(seconds >= 0.0 && seconds.is_finite()) {
            let what = format!("{} says that it took {seconds} s", header.name());
            return Err(ParticipantError::Protocol { during: during(), what });
        }
        let report = header.window_report(&scalars(&message, &self.description, during)?);
        read(&self.connection, &message, Selection::EveryWindow, outputs, during)?;
        Ok(report)
    }

    /// Does not wait: what goes wrong in the other process is the answer to the next request. Without a
    /// snapshot to write, the other process is not even woken, since the next request will do that.
    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        let (window, iteration) = self.window.take().map_or((0, 0), |w| (w.index, w.iteration));
        let during = || format!("while accepting window {window}");
        let header = |sequence| MessageHeader {
            window,
            iteration,
            snapshot: snapshot.unwrap_or(NO_SNAPSHOT),
            ..MessageHeader::new(Kind::Accept, sequence)
        };
        self.request(header, &Payload::default(), snapshot.is_some(), during)
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        let during = || "while saving its state".to_owned();
        let mut state = Vec::new();
        loop {
            let from = state.len() as u64;
            let header = |n| MessageHeader { window: from, ..MessageHeader::new(Kind::Save, n) };
            self.request(header, &Payload::default(), true, during)?;
            let message = self.answer(Kind::Saved, during)?;
            let (piece, total) = (message.text(), message.header().snapshot);
            drop(message);
            let (bytes, reached) = (piece.len(), from + piece.len() as u64);
            if reached > total || bytes == 0 && reached < total {
                let what = format!("{bytes} bytes of its state came from byte {from} on, and it has {total}");
                let error = ParticipantError::Protocol { during: during(), what };
                return Err(self.broken(error));
            }
            state.extend(piece);
            if reached == total {
                return Ok(state);
            }
        }
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        let during = || "while restoring its state".to_owned();
        let mut from = 0;
        loop {
            let end = state.len().min(from + PIECE);
            let header = |n| MessageHeader {
                window: from as u64,
                snapshot: state.len() as u64,
                ..MessageHeader::new(Kind::Restore, n)
            };
            self.request(header, &Payload::text(&state[from..end]), true, during)?;
            if end == state.len() {
                return self.ready(Kind::Restored, Selection::EveryWindow, outputs, during);
            }
            self.answer(Kind::Restored, during)?;
            from = end;
        }
    }

    /// Ends the process in order. Where a call failed before, the connection has ended, and nothing is left
    /// to do.
    fn terminate(&mut self) -> Result<()> {
        if self.ended {
            return Ok(());
        }
        let during = || "while terminating".to_owned();
        self.request(|n| MessageHeader::new(Kind::Terminate, n), &Payload::default(), true, during)?;
        self.answer(Kind::Terminated, during)?;
        self.goodbye();
        Ok(())
    }
}

impl<L: Link> Drop for RemoteParticipant<L> {
    fn drop(&mut self) {
        self.goodbye();
    }
}

fn solving(window: &TimeWindow) -> String {
    format!("while solving window {}, iteration {}", window.index, window.iteration)
}

fn unexpected<L: Link>(message: &Message<L>, expected: &str, during: String) -> ParticipantError {
    ParticipantError::Protocol {
        during,
        what: format!("{} came where {expected} belongs", message.header().name()),
    }
}

fn scalars<L: Link>(
    message: &Message<L>,
    description: &Description,
    during: impl Fn() -> String,
) -> Result<Vec<f64>> {
    let (found, expected) = (message.scalars().len(), description.scalars.len());
    if found != expected {
        let what = format!("{} has {found} scalars where {expected} are described", message.header().name());
        return Err(ParticipantError::Protocol { during: during(), what });
    }
    Ok(message.scalars().to_vec())
}

fn read<L: Link>(
    connection: &Connection<L>,
    message: &Message<L>,
    selection: Selection,
    outputs: &mut Fields,
    during: impl Fn() -> String,
) -> Result<()> {
    let started = Instant::now();
    selection.read(message.fields(), outputs).map_err(|error| match error {
        ReadError::Field(error) => ParticipantError::Field(error),
        wrong => ParticipantError::Protocol {
            during: during(),
            what: format!("in {}, {wrong}", message.header().name()),
        },
    })?;
    connection.copied(started);
    Ok(())
}
