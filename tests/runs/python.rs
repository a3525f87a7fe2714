//! A foreign program joins a run by what `docs/protocol.md` says: `docs/examples/spring_structure.py`,
//! started by its case's `command` and told in its environment where to connect.
//!
//! Runs where `MENISCUS_PYTHON` names an interpreter with the package `iceoryx2` 0.10.0:
//! `MENISCUS_PYTHON=python3 cargo test --test runs python`. Elsewhere it is skipped, and says so.

use crate::support::{Bench, COARSE, MENISCUS, assert_same};

/// The two participants as settings of a case, where there is an interpreter.
pub fn participants() -> Option<[String; 2]> {
    let Some(python) = std::env::var("MENISCUS_PYTHON").ok() else {
        eprintln!("skipped: MENISCUS_PYTHON names no interpreter");
        return None;
    };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/examples/spring_structure.py");
    Some([
        format!("structure.participant.command=[\"{python}\", \"{script}\"]"),
        format!("fluid.participant.command=[\"{MENISCUS}\", \"mock\", \"constant\", \"gradient=0,4e3\"]"),
    ])
}

/// Its state is JSON, whose decimals tell doubles to the bit.
#[test]
fn a_run_with_a_structure_in_python_goes_on_to_the_bit() {
    let Some([structure, fluid]) = participants() else { return };
    let bench = Bench::new();
    let set = ["--set", &structure, "--set", &fluid, "--set", "case.output_interval=2.5e-3"];
    let run = |out: &str, words: &[&str]| {
        let ended = bench.start_run(out, &[&COARSE, set.as_slice(), words].concat()).wait();
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        bench.outputs(out)
    };
    let whole = run("whole", &[]);
    let half = "case.end_time=0.01";
    let gone_on = run("half", &["--set", half, "--checkpoint-every", "0.004"]);
    let dir = gone_on.0.display().to_string();
    let ended = bench.call(&["run", "--resume", &dir, "--end-time", "0.02", "--no-report"]);
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    assert_same(&gone_on, &whole);
}

#[test]
fn a_structure_in_python_joins_by_its_environment() {
    let Some([structure, fluid]) = participants() else { return };
    let bench = Bench::new();
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
