//! A participant whose claims nobody can mean: refused before anything of that size is made, in words that
//! are short and steer no terminal.

use crate::support::{Domain, Echo, HASH, expectations, long};
use interfaces::protocol::{Hello, Kind, MessageHeader, Payload};
use interfaces::remote::Listening;
use interfaces::transport::{Connection, WithinProcess};
use interfaces::{Address, Direction, Participant, ParticipantError, Role, new_run};
use std::sync::Arc;
use std::thread::spawn;

/// What the coupler makes of a first message with that text, and, where that is no mistake, of `Failed` with
/// `words` after `Initialize`.
fn told(hello: Vec<u8>, words: Vec<u8>) -> Result<(), ParticipantError> {
    let domain = Domain::new();
    let address = Address::new(new_run(), Role::Structure).in_domain(&domain.0);
    let listening =
        Listening::<WithinProcess>::over(&address, expectations(), long(), &Arc::default()).unwrap();
    let other = spawn(move || {
        let during = || "by hand".to_owned();
        let alive = Box::new(|| None);
        let mut connection =
            Connection::<WithinProcess>::open(&address, long().hello, Arc::default(), alive).unwrap();
        let send = |connection: &mut Connection<WithinProcess>, kind, sequence, text: &[u8]| {
            connection.send(MessageHeader::new(kind, sequence), &Payload::text(text), true, during).unwrap();
            let message = connection.receive(long().answer, during).unwrap();
            (message.kind(), message.header().sequence)
        };
        let (answered, _) = send(&mut connection, Kind::Hello, 0, &hello);
        if answered == Kind::Refused {
            let goodbye = MessageHeader::new(Kind::Goodbye, 0);
            connection.send(goodbye, &Payload::default(), true, during).unwrap();
            return;
        }
        let sequence = connection.receive(long().answer, during).unwrap().header().sequence;
        send(&mut connection, Kind::Failed, sequence, &words);
    });
    let heard = listening.wait_for_hello(Box::new(|| None)).and_then(|mut structure| {
        let inputs = structure.describe().fields(Direction::In, 3);
        let mut outputs = structure.describe().fields(Direction::Out, 3);
        structure.initialize(0.0, &inputs, &mut outputs).map(drop)
    });
    other.join().unwrap();
    heard
}

fn hello() -> serde_json::Value {
    let description = Echo::new(3, "none").describe().clone();
    serde_json::to_value(Hello { case_hash: HASH.to_owned(), description }).unwrap()
}

#[test]
fn claims_that_nobody_can_mean_are_refused() {
    let long_name = "x".repeat(1 << 20);
    let rows: [(&str, serde_json::Value, &str); 10] = [
        (
            "/description/ports/0/points",
            1_000_000_000_000_000_000_u64.into(),
            "port `position`: 1000000000000000000 points",
        ),
        ("/description/ports/0/points", 1_000_000_000_u64.into(), "values, 64 a point, are taken at most"),
        ("/description/ports/0/components", 0.into(), "3 points of 0 components"),
        (
            "/description/ports/0/components",
            u64::MAX.into(),
            "port `position`: 3 points of 18446744073709551615",
        ),
        (
            "/description/ports/3/name",
            "position".into(),
            "port `position`: two have this name in one direction",
        ),
        ("/description/ports/0/name", "".into(), "name of a port: `` is none"),
        ("/description/ports/0/name", long_name.into(), "name of a port: `xxx"),
        ("/description/scalars/0/name", "a\u{1b}[2Jb".into(), "name of a scalar: `a\u{fffd}[2Jb` is none"),
        ("/description/solver", "two\nlines".into(), "solver: `two"),
        ("/case_hash", "\u{1b}]0;evil\u{7}".into(), "the participant has \u{fffd}]0;evil\u{fffd}"),
    ];
    for (at, value, what) in rows {
        let mut hello = hello();
        *hello.pointer_mut(at).unwrap() = value;
        let error = told(hello.to_string().into_bytes(), vec![]).unwrap_err().to_string();
        assert!(error.contains(what), "`{what}` is not in: {}", &error[..error.len().min(2000)]);
        assert!(error.len() < 2000 && !error.contains('\u{1b}'), "{} bytes", error.len());
    }
    let mut twice = hello();
    let scalar = twice["description"]["scalars"][0].clone();
    twice["description"]["scalars"].as_array_mut().unwrap().push(scalar);
    let error = told(twice.to_string().into_bytes(), vec![]).unwrap_err().to_string();
    assert!(error.contains("scalar `energy`: two have this name"), "{error}");
}

#[test]
fn a_first_message_that_cannot_be_read_is_told_shortly() {
    for text in [vec![], vec![0xff; 100], b"[".repeat(100_000), vec![b' '; (16 << 20) + 1]] {
        let error = told(text, vec![]).unwrap_err().to_string();
        assert!(error.contains("description: it") && error.len() < 1000, "{error}");
    }
}

#[test]
fn last_words_are_short_and_steer_no_terminal() {
    let mut words = b"particle 3 \x1b[31mis\0 inverted ".to_vec();
    words.extend(vec![b'x'; 50 << 20]);
    let error = told(hello().to_string().into_bytes(), words).unwrap_err().to_string();
    assert!(error.starts_with("particle 3 \u{fffd}[31mis\u{fffd} inverted xxx"), "{}", &error[..100]);
    assert!(error.len() < 20_000 && error.contains("more"), "{}", error.len());
}
