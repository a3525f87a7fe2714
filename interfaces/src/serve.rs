//! The participant's side: any participant, served to a coupler in another process.

use crate::guarded::caught;
use crate::participant::MOST_VALUES;
use crate::protocol::{
    Hello, Kind, MessageHeader, NO_SNAPSHOT, PIECE, Payload, ReadError, Selection, VERSION, Welcome,
};
use crate::transport::{Address, Alive, Connection, Deadlines, Link, Message, SharedMemory};
use crate::{
    Call, Description, Direction, Fields, Lifecycle, Participant, ParticipantError, Port, Readiness, Result,
    State,
};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use thiserror::Error;

/// Why a participant's process ends otherwise than in order.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ServeError {
    /// The participant failed, and the coupler was told.
    #[error("{0}")]
    Failed(String),
    /// The handshake did not fit; one line a mismatch.
    #[error("the coupler refused the handshake:\n  {}", .0.join("\n  "))]
    Refused(Vec<String>),
    /// The coupler is gone, silent, or breaks the protocol.
    #[error("lost the coupler: {0}")]
    Coupler(ParticipantError),
    /// The coupler ended the run before its end.
    #[error("the coupler ended the run early")]
    Abandoned,
}

/// Serves the participant to the coupler at that address until it is terminated. Blocks for the whole run.
///
/// `coupler` says how the coupler's process ended, where the caller knows it: nothing else tells of a coupler
/// that ended before there was a connection. Errors and panics of the participant are told to the coupler and
/// end the service. Nothing is printed.
pub fn serve(
    participant: &mut dyn Participant,
    address: &Address,
    case_hash: &str,
    deadlines: Deadlines,
    stop: &Arc<AtomicBool>,
    coupler: Alive,
) -> Result<(), ServeError> {
    serve_over::<SharedMemory>(participant, address, case_hash, deadlines, stop, coupler)
}

/// [`serve`], over any link: tests use the one within a process.
pub fn serve_over<L: Link>(
    participant: &mut dyn Participant,
    address: &Address,
    case_hash: &str,
    deadlines: Deadlines,
    stop: &Arc<AtomicBool>,
    coupler: Alive,
) -> Result<(), ServeError> {
    let opened = Connection::<L>::open(address, deadlines.hello, Arc::clone(stop), coupler);
    let mut connection = opened.map_err(ServeError::Coupler)?;
    let description = participant.describe().clone();
    shake_hands(&mut connection, &description, case_hash, deadlines)?;
    let mut session = Session {
        participant,
        life: Lifecycle::default(),
        restored: false,
        state: Vec::new(),
        inputs: Fields::default(),
        outputs: Fields::default(),
        description,
    };
    let ended = session.run(&mut connection, deadlines);
    if !matches!(ended, Ok(())) {
        // The error that ended the session is the one to report; a participant that fails again on its way
        // out adds nothing.
        let _ = caught(|| session.participant.terminate());
    }
    ended
}

fn shake_hands<L: Link>(
    connection: &mut Connection<L>,
    description: &Description,
    case_hash: &str,
    deadlines: Deadlines,
) -> Result<(), ServeError> {
    let during = || "while connecting".to_owned();
    let hello = Hello { case_hash: case_hash.to_owned(), description: description.clone() };
    let hello = serde_json::to_string(&hello).expect("a description has no value that JSON cannot hold");
    connection
        .send(MessageHeader::new(Kind::Hello, 0), &Payload::text(hello.as_bytes()), true, during)
        .map_err(ServeError::Coupler)?;
    let message = connection.receive(deadlines.hello, during).map_err(ServeError::Coupler)?;
    let refused = |mismatches| Err(ServeError::Refused(mismatches));
    match message.kind() {
        Kind::Welcome => {
            let mut mismatches = Vec::new();
            let mut compare = |what: &str, coupler: &str, participant: &str| {
                if coupler != participant {
                    mismatches.push(format!(
                        "{what}: the coupler has {coupler}, the participant has {participant}"
                    ));
                }
            };
            compare("protocol version", &message.header().version.to_string(), &VERSION.to_string());
            match serde_json::from_slice::<Welcome>(&message.text()) {
                Ok(welcome) => {
                    compare("case hash", &welcome.case_hash, case_hash);
                    compare("dimension", &welcome.dimension.to_string(), &description.dimension.to_string());
                }
                Err(error) => mismatches.push(format!("the coupler's welcome cannot be read: {error}")),
            }
            if mismatches.is_empty() { Ok(()) } else { refused(mismatches) }
        }
        Kind::Refused => {
            let lines = message.words().lines().map(str::to_owned).collect();
            drop(message);
            // The coupler stays until it knows that we know.
            let _ = connection.send(MessageHeader::new(Kind::Goodbye, 0), &Payload::default(), true, during);
            refused(lines)
        }
        _ => Err(ServeError::Coupler(ParticipantError::Protocol {
            during: during(),
            what: format!("{} came where `Welcome` belongs", message.header().name()),
        })),
    }
}

/// A participant between its handshake and its end.
struct Session<'a> {
    participant: &'a mut dyn Participant,
    description: Description,
    life: Lifecycle,
    /// Whether the state was restored and no window started since: the next window says how many were
    /// accepted.
    restored: bool,
    /// A state on its way, which comes or goes in pieces.
    state: Vec<u8>,
    inputs: Fields,
    outputs: Fields,
}

/// An answer, but for the fields, which are the session's outputs and checked when they are sent.
struct Answer {
    header: MessageHeader,
    scalars: Vec<f64>,
    fields: Option<Selection>,
    text: Vec<u8>,
}

impl Answer {
    fn of(header: MessageHeader) -> Self {
        Self { header, scalars: Vec::new(), fields: None, text: Vec::new() }
    }

    fn ready(header: MessageHeader, readiness: Readiness, fields: Selection) -> Self {
        Self { scalars: readiness.scalars, fields: Some(fields), ..Self::of(header) }
    }
}

impl Session<'_> {
    fn run<L: Link>(
        &mut self,
        connection: &mut Connection<L>,
        deadlines: Deadlines,
    ) -> Result<(), ServeError> {
        loop {
            let accepted = self.life.accepted();
            let during = || format!("while waiting for a request after {accepted} accepted windows");
            let deadline = match self.life.state() {
                State::Created => deadlines.first_request(),
                _ => deadlines.next_request(),
            };
            let message = connection.receive(deadline, during).map_err(ServeError::Coupler)?;
            let (kind, sequence) = (message.kind(), message.header().sequence);
            if kind == Kind::Goodbye {
                return Err(ServeError::Abandoned);
            }
            let answered = caught(|| self.answer(connection, message)).and_then(|answer| {
                let Some(answer) = answer else { return Ok(Ok(())) };
                let payload = Payload {
                    scalars: &answer.scalars,
                    fields: answer.fields.map(|selection| (&self.outputs, selection)),
                    text: &answer.text,
                };
                let during = || format!("while answering {kind} {sequence}");
                match connection.send(answer.header, &payload, true, during) {
                    // A field that must not cross is the participant's failure, and the connection is sound.
                    Err(error @ ParticipantError::Field(_)) => Err(error),
                    sent => Ok(sent),
                }
            });
            match answered {
                Ok(sent) => {
                    sent.map_err(ServeError::Coupler)?;
                    if kind == Kind::Terminate {
                        wait_for_goodbye(connection, deadlines);
                        return Ok(());
                    }
                }
                Err(error) => {
                    let words = error.to_string();
                    let header = MessageHeader::new(Kind::Failed, sequence);
                    let during = || "while telling why it failed".to_owned();
                    if connection.send(header, &Payload::text(words.as_bytes()), true, during).is_ok() {
                        wait_for_goodbye(connection, deadlines);
                    }
                    return Err(ServeError::Failed(words));
                }
            }
        }
    }

    /// Does what the message asks. An error is the participant's end.
    fn answer<L: Link>(&mut self, connection: &Connection<L>, message: Message<L>) -> Result<Option<Answer>> {
        let request = *message.header();
        match message.kind() {
            Kind::Initialize => self.initialize(&message).map(Some),
            Kind::Start => {
                let started = Instant::now();
                let window = request.time_window();
                if std::mem::take(&mut self.restored) {
                    self.life.restored(window.index);
                }
                self.life.check_window(&window)?;
                self.take(Selection::EveryWindow, &message)?;
                drop(message);
                connection.copied(started);
                self.participant.start(&window, &self.inputs)?;
                self.life.done(Call::Start, Some(&window));
                let report = self.participant.finish(&mut self.outputs)?;
                self.life.done(Call::Finish, None);
                Ok(Some(Answer {
                    header: request.solved(&report),
                    scalars: report.scalars,
                    fields: Some(Selection::EveryWindow),
                    text: Vec::new(),
                }))
            }
            Kind::Accept => {
                self.life.check(Call::Accept)?;
                if request.window != self.life.accepted() {
                    return Err(wrong(&request, &format!("window {} was solved", self.life.accepted())));
                }
                self.participant.accept((request.snapshot != NO_SNAPSHOT).then_some(request.snapshot))?;
                self.life.done(Call::Accept, None);
                Ok(None)
            }
            Kind::Save => {
                self.life.check(Call::Save)?;
                if request.window == 0 {
                    self.state = self.participant.save()?;
                    self.life.done(Call::Save, None);
                }
                let (text, total) = self.piece(&request)?;
                let header = MessageHeader::new(Kind::Saved, request.sequence);
                Ok(Some(Answer { text, ..Answer::of(MessageHeader { snapshot: total, ..header }) }))
            }
            Kind::Restore => {
                self.life.check(Call::Restore)?;
                if !self.gathered(&message)? {
                    return Ok(Some(Answer::of(MessageHeader::new(Kind::Restored, request.sequence))));
                }
                drop(message);
                let state = std::mem::take(&mut self.state);
                let readiness = self.participant.restore(&state, &mut self.outputs)?;
                self.life.restored(0);
                self.restored = true;
                Ok(Some(Answer::ready(
                    request.ready(Kind::Restored, &readiness),
                    readiness,
                    Selection::EveryWindow,
                )))
            }
            Kind::Terminate => {
                self.life.check(Call::Terminate)?;
                self.participant.terminate()?;
                self.life.done(Call::Terminate, None);
                Ok(Some(Answer::of(MessageHeader::new(Kind::Terminated, request.sequence))))
            }
            _ => Err(wrong(&request, "it is no request")),
        }
    }

    /// The piece of the saved state that is asked for, and how many bytes the state has. It is given up with
    /// its last piece.
    fn piece(&mut self, request: &MessageHeader) -> Result<(Vec<u8>, u64)> {
        let total = self.state.len();
        let from = usize::try_from(request.window).unwrap_or(usize::MAX);
        if from > 0 && from >= total {
            return Err(wrong(request, &format!("it asks for byte {from} of a state of {total}")));
        }
        let end = total.min(from + PIECE);
        let piece = self.state[from..end].to_vec();
        if end == total {
            self.state = Vec::new();
        }
        Ok((piece, total as u64))
    }

    /// Adds a piece to the state that comes. Says whether it is whole then.
    fn gathered<L: Link>(&mut self, message: &Message<L>) -> Result<bool> {
        let header = *message.header();
        if header.window == 0 {
            self.state.clear();
        }
        let piece = message.text();
        let (before, total) = (self.state.len() as u64, header.snapshot);
        if header.window != before || before + piece.len() as u64 > total {
            let (from, bytes) = (header.window, piece.len());
            return Err(wrong(
                &header,
                &format!("it brings {bytes} bytes from byte {from} on where {before} of {total} have come"),
            ));
        }
        self.state.extend(piece);
        Ok(self.state.len() as u64 == total)
    }

    /// Copies the message's fields to the inputs, finite as they are.
    fn take<L: Link>(&mut self, selection: Selection, message: &Message<L>) -> Result<()> {
        selection.read(message.fields(), &mut self.inputs).map_err(|error| match error {
            ReadError::Field(error) => error.into(),
            other => wrong(message.header(), &other.to_string()),
        })
    }

    fn initialize<L: Link>(&mut self, message: &Message<L>) -> Result<Answer> {
        self.life.check(Call::Initialize)?;
        let request = *message.header();
        let points = message.scalars();
        let of = |direction| self.description.ports.iter().filter(move |p| p.direction == direction).cloned();
        let ports: Vec<Port> = of(Direction::In).chain(of(Direction::Out)).collect();
        if points.len() != ports.len() {
            let what =
                format!("it names the points of {} ports where {} are described", points.len(), ports.len());
            return Err(wrong(&request, &what));
        }
        let mut resolved = Vec::with_capacity(ports.len());
        for (port, &points) in ports.into_iter().zip(points) {
            let count = points as usize;
            let fits = count.checked_mul(port.components).is_some_and(|values| values <= MOST_VALUES);
            if port.points.is_some_and(|own| own != count) || count as f64 != points || !fits {
                let own = port.points.unwrap_or(0);
                let what = format!("it names {points} points for port `{}`, which has {own}", port.name);
                return Err(wrong(&request, &what));
            }
            resolved.push(Port { points: Some(count), ..port });
        }
        self.inputs = Fields::new(&resolved, Direction::In, 0);
        self.outputs = Fields::new(&resolved, Direction::Out, 0);
        self.take(Selection::All, message)?;
        let readiness = self.participant.initialize(request.time, &self.inputs, &mut self.outputs)?;
        self.life.done(Call::Initialize, None);
        Ok(Answer::ready(request.ready(Kind::Ready, &readiness), readiness, Selection::All))
    }
}

/// Stays until the coupler has our last message: connections form when the receiver looks, and what a sender
/// that is gone had sent before is lost. Messages that were under way are ignored; a coupler that is gone
/// wants no answer.
fn wait_for_goodbye<L: Link>(connection: &mut Connection<L>, deadlines: Deadlines) {
    let during = || "while leaving".to_owned();
    while connection
        .receive(deadlines.next_request(), during)
        .is_ok_and(|message| message.kind() != Kind::Goodbye)
    {}
}

fn wrong(request: &MessageHeader, what: &str) -> ParticipantError {
    ParticipantError::Protocol { during: format!("with {}", request.name()), what: what.to_owned() }
}
