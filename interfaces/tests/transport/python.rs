//! The protocol's page against an implementation that shares no code with ours:
//! `docs/examples/spring_structure.py`.
//!
//! Runs where `MENISCUS_PYTHON` names an interpreter with the package `iceoryx2` 0.10.0:
//! `MENISCUS_PYTHON=python3 cargo test -p interfaces python`. Elsewhere it passes without a check, and says
//! so.

use crate::support::{Domain, HASH, expectations, long};
use interfaces::{
    Address, Direction, Guarded, Participant, RemoteParticipant, Role, SubSteps, TimeWindow, new_run,
    remove_stale,
};
use std::process::Command;
use std::sync::Arc;

#[test]
fn springs_in_python_swing_as_they_should() {
    let Some(python) = std::env::var_os("MENISCUS_PYTHON") else {
        eprintln!("not checked: MENISCUS_PYTHON names no interpreter");
        return;
    };
    let domain = Domain::new();
    let address = Address::new(new_run(), Role::Structure).in_domain(&domain.0);
    let listening = RemoteParticipant::listen(&address, expectations(), long(), &Arc::default()).unwrap();
    let mut process = Command::new(python)
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/examples/spring_structure.py"))
        .args(["--connect", &address.connect(), "--case-hash", HASH, "--points", "300"])
        .spawn()
        .unwrap();
    let mut structure = Guarded::new(listening.wait_for_hello(Box::new(|| None)).unwrap());
    let mut load = structure.describe().fields(Direction::In, 0);
    let mut motion = structure.describe().fields(Direction::Out, 0);
    structure.initialize(0.0, &load, &mut motion).unwrap();
    assert_eq!(motion.get("density").unwrap(), vec![1000.0; 300]);
    let rest = motion.get("position").unwrap().to_vec();

    // The solution of ρ x'' = −ρ ω² (x − X) − ∇p from rest is x = X − ∇p / (ρ ω²) (1 − cos ω t), with ω = 20
    // and ρ = 1000.
    let gradient = 4000.0;
    load.get_mut("pressure_gradient").unwrap().fill(gradient);
    let size = 0.01;
    let mut saved = Vec::new();
    for index in 0..12 {
        let mut solve = |iteration| {
            let window = TimeWindow {
                index,
                iteration,
                start: index as f64 * size,
                size,
                sub_steps: SubSteps::Fixed(20),
            };
            structure.start(&window, &load).unwrap();
            assert_eq!(structure.finish(&mut motion).unwrap().sub_steps, 20);
            motion.get("position").unwrap().to_vec()
        };
        let first = solve(0);
        assert_eq!(first, solve(1), "a window solved again from the same state gives the same");
        structure.accept(None).unwrap();
        let exact = -gradient / (1000.0 * 400.0) * (1.0 - (20.0 * (index + 1) as f64 * size).cos());
        for (position, rest) in first.iter().zip(&rest) {
            // Leapfrog shifts the frequency by (ω Δt)²/24 = 4e-6 of it, and starts and ends without error.
            assert!((position - rest - exact).abs() < 1e-5 * gradient / (1000.0 * 400.0), "window {index}");
        }
        if index == 5 {
            saved = structure.save().unwrap();
        }
    }
    structure.restore(&saved, &mut motion).unwrap();
    assert_eq!(structure.save().unwrap(), saved);
    structure.terminate().unwrap();
    drop(structure);
    assert!(process.wait().unwrap().success());
    // The last to leave was not ours, and left the library's counter of nodes.
    remove_stale(&address).unwrap();
}
