//! What a participant sends: its hello, and the fields behind a header.
#![no_main]

use interfaces::protocol::{Hello, Selection};
use interfaces::{Direction, Fields, Port, Quantity};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(hello) = serde_json::from_slice::<Hello>(bytes)
        && hello.description.mistakes().is_empty()
    {
        // What passed is small enough to be made.
        let points = hello.description.ports.iter().filter_map(|port| port.points).max().unwrap_or(0);
        if points < 1 << 16 {
            let _ = hello.description.fields(Direction::Out, points.min(1000));
        }
    }
    let doubles: Vec<f64> =
        bytes.chunks_exact(8).map(|eight| f64::from_ne_bytes(eight.try_into().expect("eight"))).collect();
    let port = |name, quantity| Port::new(name, quantity, 2, Some(3), Direction::Out);
    let ports = [port("position", Quantity::Position), port("velocity", Quantity::Velocity).constant()];
    for selection in [Selection::All, Selection::EveryWindow] {
        let mut fields = Fields::new(&ports, Direction::Out, 3);
        if selection.read(&doubles, &mut fields).is_ok() {
            assert!(fields.check_finite().is_ok(), "what is not finite does not cross");
        }
    }
});
