//! Scenarios: what crosses is changed, participants fail when they are told to, and the records say so.

use crate::support::{Bench, COARSE, Ended, Outputs, assert_same};
use std::path::PathBuf;

fn scenario(bench: &Bench, name: &str, text: &str) -> PathBuf {
    let path = bench.path(name);
    std::fs::write(&path, text).expect("a file in the bench's folder");
    path
}

/// The coarse gate under a scenario.
fn run(bench: &Bench, out: &str, text: &str, words: &[&str]) -> Ended {
    let path = scenario(bench, &format!("{out}.scenario.toml"), text).display().to_string();
    bench.start_run(out, &[&COARSE, ["--scenario", &path].as_slice(), words].concat()).wait()
}

fn completed(bench: &Bench, out: &str, text: &str, words: &[&str]) {
    let ended = run(bench, out, text, words);
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
}

const HALF_FOR_A_WHILE: &str = "\
[[change]]
given = 'fluid.pressure_gradient'
from = 0.005
until = 0.015
scale = 0.5

[[change]]
taken = 'fluid.velocity'
from = 0.01
delay = 0.0015
";

/// And the motion that the structure gives.
const MORE: &str = "\
[[change]]
given = 'structure.position'
from = 0.004
noise = 1e-7
seed = 3

[[change]]
given = 'structure.velocity'
until = 0.003
drop = true

";

#[test]
fn what_is_changed_reaches_the_other_side_however_it_is_run() {
    let bench = Bench::new();
    bench.coarse_gate("plain", &[]);
    completed(&bench, "same", "[[change]]\ngiven = 'fluid.pressure_gradient'\nscale = 1.0", &[]);
    assert_same(&bench.outputs("plain"), &bench.outputs("same"));
    completed(&bench, "half", HALF_FOR_A_WHILE, &[]);
    completed(&bench, "within", HALF_FOR_A_WHILE, &["--in-process"]);
    assert_same(&bench.outputs("half"), &bench.outputs("within"));

    let (plain, half) = (bench.outputs("plain"), bench.outputs("half"));
    let before = |outputs: &Outputs| {
        let table = outputs.table("windows.csv");
        let (_, values) = table.iter().find(|(name, _)| *name == "force_before_x").expect("a column");
        values.to_vec()
    };
    // Until it begins nothing is other, and what it changes first is half of what it would be, to the bit.
    let (of_plain, of_half) = (before(&plain), before(&half));
    let first = (0..of_plain.len()).find(|&row| of_plain[row] != of_half[row]).expect("a difference");
    assert_eq!(of_half[first], 0.5 * of_plain[first]);
    let notes = half.summary().notes;
    for part in [
        "scenario: pressure_gradient given by the fluid: times 0.5, in ",
        "scenario: velocity taken by the fluid: late by 0.0015 s, in ",
    ] {
        assert!(notes.iter().any(|note| note.starts_with(part)), "`{part}` is not in {notes:?}");
    }
}

#[test]
fn a_run_that_a_fault_ended_goes_on_under_its_changes_without_it() {
    for scheme in ["serial-explicit", "parallel-implicit"] {
        let bench = Bench::new();
        let changes = format!("{HALF_FOR_A_WHILE}{MORE}");
        let scheme = format!("coupling.scheme={scheme}");
        let words = ["--set", &scheme, "--checkpoint-every", "0.005"];
        completed(&bench, "whole", &changes, &words);
        let fault = "[[fault]]\nof = 'structure'\nat = 0.012\nkind = 'kill'";
        let ended = run(&bench, "cut", &format!("{changes}{fault}"), &words);
        assert_eq!(ended.status.code(), Some(1), "{}", ended.errors);
        let summary = bench.outputs("cut").summary();
        let message = summary.message.expect("a failed run says why");
        assert!(message.contains("the structure failed while") && message.contains("signal 9"), "{message}");
        let told = "scenario: the structure's process was killed with window ";
        assert!(summary.notes.iter().any(|note| note.starts_with(told)), "{:?}", summary.notes);
        let cut = bench.path("cut").display().to_string();
        let ended = bench.call(&["run", "--resume", &cut, "--no-report"]);
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        assert_same(&bench.outputs("whole"), &bench.outputs("cut"));
    }
}

/// What is spoilt on purpose is caught where it would be by accident.
#[test]
fn spoilt_values_and_told_errors_end_a_run_in_words() {
    let nan = |way: &str| {
        format!("[[change]]\n{way}\nfrom = 0.01\npoints = [3]\ncomponent = 'y'\ncorrupt = 'not-a-number'")
    };
    let error = "[[fault]]\nof = 'fluid'\nat = 0.01\nkind = 'error: out of licences'";
    for (text, parts) in [
        (
            nan("given = 'fluid.pressure_gradient'"),
            ["the fluid failed while solving window", "pressure_gradient"],
        ),
        (nan("taken = 'structure.pressure_gradient'"), ["the structure failed while", "pressure_gradient"]),
        (error.to_owned(), ["the fluid failed while", "out of licences (by the scenario)"]),
    ] {
        for words in [&[][..], &["--in-process"]] {
            let bench = Bench::new();
            let ended = run(&bench, "out", &text, words);
            assert_eq!(ended.status.code(), Some(1), "{}", ended.errors);
            let message = bench.outputs("out").summary().message.expect("a failed run says why");
            assert!(parts.iter().all(|part| message.contains(part)), "{parts:?} are not in: {message}");
        }
    }
}

/// A stop that ends in time is survived, and changes nothing.
#[test]
fn a_stop_within_the_deadline_is_survived() {
    let bench = Bench::new();
    bench.coarse_gate("plain", &[]);
    completed(&bench, "held", "[[fault]]\nof = 'fluid'\nat = 0.01\nkind = 'stop'\nfor = 0.3", &[]);
    assert_same(&bench.outputs("plain"), &bench.outputs("held"));
    assert!(bench.outputs("held").summary().notes.iter().any(|note| note.contains("was stopped for 0.3 s")));
}

#[test]
fn a_scenario_that_is_none_is_refused() {
    let bench = Bench::new();
    let ended = run(&bench, "out", "[[change]]\ngiven = 'fluid.presure'\nbias = 1\nscale = 2", &[]);
    assert_eq!(ended.status.code(), Some(2), "{}", ended.errors);
    assert!(ended.errors.contains("change.0.override, bias, scale"), "{}", ended.errors);
    assert!(!bench.path("out").exists(), "nothing was begun");
    let ended = run(&bench, "out", "[[change]]\ngiven = 'fluid.presure'\nbias = 1", &[]);
    assert_eq!(ended.status.code(), Some(1), "{}", ended.errors);
    let words = "change.0.given = \"fluid.presure\": there is no such quantity; write one of ";
    assert!(ended.errors.contains(words), "{}", ended.errors);
    assert!(!bench.path("out").exists(), "nothing was begun");
    let ended = run(&bench, "out", "[[change]]\ngiven = 'fluid.position'\nbias = 1", &[]);
    assert_eq!(ended.status.code(), Some(1), "{}", ended.errors);
    assert!(ended.errors.contains("gives no such quantity every window; it gives "), "{}", ended.errors);
    assert!(ended.errors.contains("pressure_gradient"), "{}", ended.errors);
}

/// Of sides and processes that the run does not have nothing can be changed, and it says so before it begins.
#[test]
fn a_scenario_of_what_is_not_there_is_refused() {
    let bench = Bench::new();
    let kill = scenario(&bench, "kill.toml", "[[fault]]\nof = 'structure'\nat = 0.1\nkind = 'kill'");
    let kill = kill.display().to_string();
    for (case, words, what) in [
        ("cases/dam_break", &["--end-time", "0.01"][..], "the case has no structure that it could change"),
        (COARSE[0], &["--in-process"], "the structure has no process that could be killed or stopped"),
    ] {
        let ended = bench.start_run("out", &[&[case, "--scenario", &kill], words].concat()).wait();
        assert_eq!(ended.status.code(), Some(1), "{}", ended.errors);
        assert!(ended.errors.contains(what), "{}", ended.errors);
        assert!(!bench.path("out").exists(), "nothing was begun");
    }
}
