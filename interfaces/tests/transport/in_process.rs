//! The protocol within one process, over the link within a process: a participant served by a thread,
//! and one that speaks the protocol by hand and wrongly.

use crate::support::{Domain, Echo, HASH, exchange, expectations, load, long, window};
use interfaces::protocol::{Hello, Kind, MessageHeader, PIECE, Payload, Selection, VERSION, Welcome};
use interfaces::remote::Listening;
use interfaces::transport::{Alive, Connection, Message, SharedMemory, WithinProcess};
use interfaces::{
    Address, Deadlines, Direction, Guarded, Participant, ParticipantError, RemoteParticipant, Result, Role,
    ServeError, new_run, serve_over,
};
use std::sync::Arc;
use std::thread::{JoinHandle, spawn};
use std::time::Duration;

type Remote = RemoteParticipant<WithinProcess>;

fn address(domain: &Domain) -> Address {
    Address::new(new_run(), Role::Structure).in_domain(&domain.0)
}

fn listen(address: &Address) -> Listening<WithinProcess> {
    Listening::over(address, expectations(), long(), &Arc::default()).unwrap()
}

fn accept_hello(listening: Listening<WithinProcess>) -> Result<Remote> {
    listening.wait_for_hello(Box::new(|| None))
}

fn serving(address: &Address, mut echo: Echo) -> JoinHandle<Result<(), ServeError>> {
    let address = address.clone();
    spawn(move || {
        serve_over::<WithinProcess>(&mut echo, &address, HASH, long(), &Arc::default(), Box::new(|| None))
    })
}

#[test]
fn a_participant_is_the_same_here_and_behind_the_protocol() {
    let domain = Domain::new();
    for points in [1, 100, 10_000] {
        exchange(&mut Guarded::new(Echo::new(points, "none")), points, 10).unwrap();
        let address = address(&domain);
        let listening = listen(&address);
        let served = serving(&address, Echo::new(points, "none"));
        let mut structure = Guarded::new(accept_hello(listening).unwrap());
        exchange(&mut structure, points, 10).unwrap();
        structure.terminate().unwrap();
        drop(structure);
        served.join().unwrap().unwrap();
    }
}

#[test]
fn traffic_is_counted_on_the_way() {
    let domain = Domain::new();
    let address = address(&domain);
    let listening = listen(&address);
    let served = serving(&address, Echo::new(50, "none"));
    let mut structure = accept_hello(listening).unwrap();
    let before = structure.meter().get();
    exchange(&mut structure, 50, 4).unwrap();
    let after = structure.meter().get();
    // `Initialize` names the points of 4 ports and carries 50 × 2 doubles, `Start` carries those alone;
    // `Accept` carries nothing.
    assert_eq!(after.bytes_sent - before.bytes_sent, 8 * (4 + 100 + 4 * 100));
    assert_eq!(after.messages_sent - before.messages_sent, 1 + 4 + 4);
    // `Ready` and `Solved` carry one scalar and position and velocity, `Ready` the density too.
    assert_eq!(after.bytes_received - before.bytes_received, 8 * (1 + 250 + 4 * (1 + 200)));
    assert_eq!(after.messages_received - before.messages_received, 1 + 4);
    assert!(after.waiting_seconds > 0.0 && after.copying_seconds > 0.0);
    structure.terminate().unwrap();
    drop(structure);
    served.join().unwrap().unwrap();
}

#[test]
fn a_participant_that_does_not_fit_the_points_says_so() {
    let domain = Domain::new();
    let address = address(&domain);
    let listening = listen(&address);
    let served = serving(&address, Echo::new(5, "none"));
    let mut structure = accept_hello(listening).unwrap();
    let other = Echo::new(6, "none");
    let inputs = other.describe().fields(Direction::In, 6);
    let mut outputs = other.describe().fields(Direction::Out, 6);
    let error = structure.initialize(0.0, &inputs, &mut outputs).unwrap_err().to_string();
    assert!(error.ends_with("it names 6 points for port `position`, which has 5"), "{error}");
    drop(structure);
    assert_eq!(served.join().unwrap(), Err(ServeError::Failed(error)));
}

#[test]
fn calls_out_of_order_are_refused_by_the_table_on_the_other_side_too() {
    let domain = Domain::new();
    let address = address(&domain);
    let listening = listen(&address);
    let served = serving(&address, Echo::new(5, "none"));
    let mut structure = accept_hello(listening).unwrap();
    let error = structure.save().unwrap_err().to_string();
    assert_eq!(error, "`save` is not legal when the participant is created: `accept` the window first");
    assert!(structure.terminate().is_ok(), "a participant that failed has nothing left to end");
    drop(structure);
    served.join().unwrap().unwrap_err();
}

#[test]
fn a_coupler_that_is_silent_too_long_is_given_up() {
    let domain = Domain::new();
    let address = address(&domain);
    let listening = listen(&address);
    let served = spawn({
        let address = address.clone();
        let deadlines = Deadlines { hello: Duration::from_secs(2), answer: Duration::from_millis(50) };
        move || {
            let mut echo = Echo::new(5, "none");
            serve_over::<WithinProcess>(
                &mut echo,
                &address,
                HASH,
                deadlines,
                &Arc::default(),
                Box::new(|| None),
            )
        }
    });
    let structure = accept_hello(listening).unwrap();
    let during = "while waiting for a request after 0 accepted windows".to_owned();
    let error = ParticipantError::TimedOut { during, seconds: 2.1 };
    assert_eq!(served.join().unwrap(), Err(ServeError::Coupler(error)));
    drop(structure);
}

/// Who takes nothing is mostly at its end, which is seen a moment later: then the end is told.
#[test]
fn a_message_that_nobody_takes_waits_for_the_reason() {
    let domain = Domain::new();
    let mut coupler = Connection::<WithinProcess>::create(&address(&domain), Arc::default()).unwrap();
    let accept = MessageHeader::new(Kind::Accept, 65);
    let mut refused = |alive: Alive| {
        coupler.watch(alive);
        coupler.send(accept, &Payload::default(), true, || "while accepting".to_owned()).unwrap_err()
    };
    let error = refused(Box::new(|| None)).to_string();
    assert!(
        error.contains(
            "nobody takes `Accept` 65 of window 0, iteration 0: not connected, or its buffer is full"
        ),
        "{error}"
    );
    let mut looks = 0;
    let dying = Box::new(move || {
        looks += 1;
        (looks > 3).then(|| "signal 15".to_owned())
    });
    assert_eq!(refused(dying), ParticipantError::Died { during: "while accepting (signal 15)".to_owned() });
}

#[test]
fn wake_ups_that_nobody_waited_for_do_no_harm() {
    let domain = Domain::new();
    let address = address(&domain);
    let during = || "while sending to itself".to_owned();
    let mut coupler = Connection::<SharedMemory>::create(&address, Arc::default()).unwrap();
    let mut participant =
        Connection::<SharedMemory>::open(&address, long().hello, Arc::default(), Box::new(|| None)).unwrap();
    // Whoever answers before it is waited for leaves its wake-up behind; more of them than a socket holds.
    for sequence in 0..20_000 {
        coupler.send(MessageHeader::new(Kind::Save, sequence), &Payload::default(), true, during).unwrap();
        let message = participant.receive(long().answer, during).unwrap();
        assert_eq!(message.header().sequence, sequence);
    }
}

/// What a participant that speaks by hand answers to the first `Start`.
type Reply = fn(&MessageHeader) -> (MessageHeader, usize);

/// Says hello with that version, is ready, and gives that answer to the first `Start`.
fn by_hand(address: &Address, version: u32, reply: Reply) -> JoinHandle<()> {
    let address = address.clone();
    spawn(move || {
        let during = || "by hand".to_owned();
        let deadline = long().answer;
        let mut connection =
            Connection::<WithinProcess>::open(&address, deadline, Arc::default(), Box::new(|| None)).unwrap();
        let description = Echo::new(3, "none").describe().clone();
        let outputs = description.fields(Direction::Out, 3);
        let hello = serde_json::to_string(&Hello { case_hash: HASH.to_owned(), description }).unwrap();
        let header = MessageHeader { version, ..MessageHeader::new(Kind::Hello, 0) };
        connection.send(header, &Payload::text(hello.as_bytes()), true, during).unwrap();
        let next = |connection: &mut Connection<WithinProcess>| -> Option<MessageHeader> {
            let message: Message<WithinProcess> = connection.receive(deadline, during).ok()?;
            (message.kind() != Kind::Goodbye).then(|| *message.header())
        };
        let welcome = next(&mut connection).unwrap();
        if welcome.kind() == Some(Kind::Refused) {
            connection.send(MessageHeader::new(Kind::Goodbye, 0), &Payload::default(), true, during).unwrap();
            return;
        }
        let initialize = next(&mut connection).unwrap();
        let payload =
            Payload { scalars: &[0.25], fields: Some((&outputs, Selection::All)), ..Payload::default() };
        let header = MessageHeader { size: 2.5, ..MessageHeader::new(Kind::Ready, initialize.sequence) };
        connection.send(header, &payload, true, during).unwrap();
        let (header, doubles) = reply(&next(&mut connection).unwrap());
        let numbers = vec![0.0; doubles];
        // The first double is the scalar that is described, as far as there is one; the rest are fields, sent
        // here as text.
        let (scalars, fields) = numbers.split_at(doubles.min(1));
        let text = vec![0; 8 * fields.len()];
        let payload = Payload { scalars, fields: None, text: &text };
        connection.send(header, &payload, true, during).unwrap();
        while next(&mut connection).is_some() {}
    })
}

fn told(version: u32, reply: Reply) -> String {
    let domain = Domain::new();
    let address = address(&domain);
    let listening = listen(&address);
    let other = by_hand(&address, version, reply);
    let error = (|| {
        let mut structure = accept_hello(listening)?;
        let mut inputs = structure.describe().fields(Direction::In, 3);
        let mut outputs = structure.describe().fields(Direction::Out, 3);
        structure.initialize(2.0, &inputs, &mut outputs)?;
        load(&mut inputs, 0);
        structure.start(&window(0), &inputs)?;
        structure.finish(&mut outputs)
    })()
    .unwrap_err();
    other.join().unwrap();
    error.to_string()
}

#[test]
fn another_version_is_refused_with_both_numbers() {
    for version in [2, 99] {
        assert_eq!(
            told(version, |start| (*start, 0)),
            format!(
                "the handshake found 1 mismatch(es):\n  protocol version: the coupler has 3, the participant has {version}"
            )
        );
    }
    // And the other way round: a participant of ours, a coupler of another version.
    let domain = Domain::new();
    let address = address(&domain);
    let during = || "by hand".to_owned();
    let mut coupler = Connection::<WithinProcess>::create(&address, Arc::default()).unwrap();
    let served = serving(&address, Echo::new(3, "none"));
    drop(coupler.receive(long().hello, during).unwrap());
    let welcome = serde_json::to_string(&Welcome { case_hash: HASH.to_owned(), dimension: 2 }).unwrap();
    let header = MessageHeader { version: 2, ..MessageHeader::new(Kind::Welcome, 0) };
    coupler.send(header, &Payload::text(welcome.as_bytes()), true, during).unwrap();
    let refused = vec!["protocol version: the coupler has 2, the participant has 3".to_owned()];
    assert_eq!(served.join().unwrap(), Err(ServeError::Refused(refused)));
}

#[test]
fn answers_that_do_not_fit_the_request_are_refused_with_both_sides_named() {
    let broke = "it broke the protocol while solving window 0, iteration 0: ";
    let cases: [(Reply, &str); 6] = [
        (
            |s| (MessageHeader { window: 4, ..MessageHeader::new(Kind::Solved, s.sequence) }, 13),
            "`Solved` 2 of window 4, iteration 0 came where `Solved` 2 of window 0, iteration 0 belongs",
        ),
        (
            |s| (MessageHeader::new(Kind::Solved, s.sequence + 5), 13),
            "`Solved` 7 of window 0, iteration 0 came where `Solved` 2 of window 0, iteration 0 belongs",
        ),
        (
            |s| (MessageHeader::new(Kind::Saved, s.sequence), 13),
            "`Saved` 2 came where `Solved` 2 of window 0, iteration 0 belongs",
        ),
        (
            |s| (MessageHeader { version: 7, ..MessageHeader::new(Kind::Solved, s.sequence) }, 13),
            "`Solved` 2 of window 0, iteration 0 has protocol version 7 where 3 belongs",
        ),
        (
            |s| (MessageHeader { kind: 77, ..MessageHeader::new(Kind::Solved, s.sequence) }, 13),
            "a message of unknown kind 77 2 came",
        ),
        (
            |s| (MessageHeader::new(Kind::Solved, s.sequence), 0),
            "`Solved` 2 of window 0, iteration 0 has 0 scalars where 1 are described",
        ),
    ];
    for (reply, what) in cases {
        assert_eq!(told(VERSION, reply), format!("{broke}{what}"));
    }
    assert_eq!(
        told(VERSION, |s| (MessageHeader::new(Kind::Solved, s.sequence), 1)),
        format!(
            "{broke}in `Solved` 2 of window 0, iteration 0, fields of 0 doubles came where 12 belong \
             (points × components: `position` 3 × 2, `velocity` 3 × 2)"
        )
    );
}

/// A state of two and a half pieces and one of exactly two, there and back, which is saved again.
#[test]
fn a_state_crosses_in_pieces() {
    let domain = Domain::new();
    // Of a state of 32 bytes and 16 a point.
    for points in [5 * PIECE / 32, 2 * PIECE / 16 - 2] {
        let make = || {
            let address = address(&domain);
            let listening = listen(&address);
            let served = serving(&address, Echo::new(points, "none"));
            (accept_hello(listening).unwrap(), served)
        };
        let (mut structure, served) = make();
        exchange(&mut structure, points, 2).unwrap();
        let sent = structure.meter().get().messages_sent;
        let state = structure.save().unwrap();
        assert_eq!(structure.meter().get().messages_sent - sent, state.len().div_ceil(PIECE) as u64);
        assert!(state.len() >= 2 * PIECE && structure.save().unwrap() == state);
        let (mut other, other_served) = make();
        let description = other.describe().clone();
        let fields = |direction| description.fields(direction, points);
        other.initialize(0.0, &fields(Direction::In), &mut fields(Direction::Out)).unwrap();
        other.restore(&state, &mut fields(Direction::Out)).unwrap();
        assert!(other.save().unwrap() == state);
        for (mut participant, served) in [(structure, served), (other, other_served)] {
            participant.terminate().unwrap();
            drop(participant);
            served.join().unwrap().unwrap();
        }
    }
}
