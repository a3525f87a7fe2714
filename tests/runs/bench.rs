//! `meniscus bench exchange`, and what a trace and an early end leave, as a user runs them.

use crate::support::{Bench, Ended, MENISCUS, Outputs, assert_same};
use output::summary::Status;

#[test]
fn the_exchange_is_measured_and_leaves_nothing() {
    let bench = Bench::new();
    let ended = bench.call(&["bench", "exchange", "50", "--windows", "40"]);
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    for series in [
        "serial-explicit",
        "100 interpolated sub-steps",
        "serial-explicit, predicted",
        "serial-implicit, 2 IQN-ILS iterations",
        "serial-implicit, 4 IQN-ILS iterations",
    ] {
        let line = ended.text.lines().find(|line| line.trim_start().starts_with(&format!("{series}  ")));
        let numbers: Vec<f64> = line
            .unwrap_or_else(|| panic!("{series} is not in {}", ended.text))
            .rsplit("  ")
            .filter_map(|word| word.trim().parse().ok())
            .collect();
        assert!(numbers.len() >= 8 && numbers.iter().all(|x| *x >= 0.0), "{line:?}");
    }
}

/// A run between these mocks, with more settings, which must complete.
fn completed(bench: &Bench, out: &str, fluid: &str, structure: &str, settings: &[&str]) -> (Outputs, Ended) {
    let mocks = [mock("fluid", fluid), mock("structure", structure)];
    let settings = mocks.iter().map(String::as_str).chain(settings.iter().copied());
    let words: Vec<_> = ["cases/elastic_gate", "--no-report", "--trace"]
        .into_iter()
        .chain(settings.flat_map(|setting| ["--set", setting]))
        .collect();
    let ended = bench.start_run(out, &words).wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    (bench.outputs(out), ended)
}

/// `<role>.participant.command` for `meniscus mock <words>`.
fn mock(role: &str, words: &str) -> String {
    let words: Vec<_> = words.split_whitespace().map(|word| format!("\"{word}\"")).collect();
    format!("{role}.participant.command=[\"{MENISCUS}\", \"mock\", {}]", words.join(", "))
}

#[test]
fn a_run_that_a_participant_ends_completes_and_says_why() {
    let bench = Bench::new();
    let fluid = "constant gradient=0,1e3 end_after=0.015";
    let (outputs, ended) = completed(&bench, "out", fluid, "spring-mass", &["case.output_interval=0.01"]);
    let summary = outputs.summary();
    assert_eq!(summary.status, Status::Completed);
    assert_eq!(summary.message.as_deref(), Some("the fluid asked for it"));
    assert_eq!((summary.windows, summary.simulated_seconds), (2, 0.02));
    assert!(ended.text.contains("the fluid asked for it"), "{}", ended.text);
    let coupler = &summary.roles["coupler"].extra;
    for phase in ["sending", "waiting", "mapping", "condition_46", "acceleration", "records", "coupling"] {
        let seconds = coupler[&format!("{phase}_seconds")].as_f64();
        assert!(seconds.is_some_and(|s| s >= 0.0), "{phase}: {coupler:?}");
    }
}

#[test]
fn a_steady_state_of_the_case_ends_the_run() {
    let bench = Bench::new();
    let settings = [
        "coupling.steady_state={ rate = 1e-3, duration = 0.1 }",
        "case.end_time=100",
        "coupling.max_window=0.01",
    ];
    let structure = "spring-mass stiffness=400 damping=20";
    let (outputs, _) = completed(&bench, "out", "constant gradient=0,1e3", structure, &settings);
    let summary = outputs.summary();
    assert_eq!(summary.status, Status::Completed);
    assert!(summary.message.is_some_and(|why| why.starts_with("a steady state")));
    assert!(summary.simulated_seconds < 5.0, "{}", summary.simulated_seconds);
}

#[test]
fn where_processes_are_executed_changes_no_result() {
    let bench = Bench::new();
    let run = |out: &str, share: &str| {
        let settings = ["case.end_time=1", "coupling.max_window=1e-3", share];
        let fluid = "harmonic gradient=0,1e3 frequency=1";
        let (outputs, _) = completed(&bench, out, fluid, "spring-mass stiffness=400", &settings);
        let together = outputs.summary().roles["coupler"].extra["windows_on_one_core"].as_u64();
        (outputs, together.expect("a number"))
    };
    let (tried, together) = run("tried", "coupling.share_core=true");
    let (apart, never) = run("apart", "coupling.share_core=false");
    assert_same(&tried, &apart);
    // How many there are otherwise is for the machine to say. A block of them is tried wherever windows take
    // less than a millisecond.
    println!("{together} of 1000 windows on one core");
    assert_eq!(never, 0);
}
