//! A foreign program joins a run by what `docs/protocol.md` says: `docs/examples/spring_structure.py`,
//! started by its case's `command` and told in its environment where to connect.
//!
//! Runs where `MENISCUS_PYTHON` names an interpreter with the package `iceoryx2` 0.10.0:
//! `MENISCUS_PYTHON=python3 cargo test --test runs python`. Elsewhere it is skipped, and says so.

use crate::support::{Bench, COARSE, MENISCUS};

#[test]
fn a_structure_in_python_joins_by_its_environment() {
    let Some(python) = std::env::var("MENISCUS_PYTHON").ok() else {
        eprintln!("skipped: MENISCUS_PYTHON names no interpreter");
        return;
    };
    let bench = Bench::new();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/examples/spring_structure.py");
    let structure = format!("structure.participant.command=[\"{python}\", \"{script}\"]");
    let fluid =
        format!("fluid.participant.command=[\"{MENISCUS}\", \"mock\", \"constant\", \"gradient=0,4e3\"]");
    let set = ["--set", &structure, "--set", &fluid];
    let ended = bench.start_run("out", &[&COARSE, set.as_slice()].concat()).wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    let windows = bench.outputs("out").table("windows.csv");
    let [times, energies] = ["time", "structure.energy"].map(|name| windows.get(name).expect("a column"));
    assert!(times.len() > 1);
    for (t, energy) in times.iter().zip(energies) {
        // ρ u'' = −ρ ω² u − ∇p from rest, with ρ = 1000 and ω = 20: u = −∇p/(ρ ω²) (1 − cos ωt), of which
        // (ρ/2) (u'² + ω² u²) is (∇p)²/(ρ ω²) (1 − cos ωt); five particles of 1 m³.
        let exact = 5.0 * 4e3 * 4e3 / (1000.0 * 400.0) * (1.0 - (20.0 * t).cos());
        // Leapfrog in 100 sub-steps of a window of at most 1 ms: (ω Δt)²/24 is below 1e-8.
        assert!((energy - exact).abs() < 1e-6 * exact, "t = {t}: {energy} {exact}");
    }
}
