//! Recordings: either side of a run is played back where its program is not there, and what departs is named.

use crate::support::{Bench, COARSE, Ended, MENISCUS, assert_same, command, mock};
use crate::unit::spring_unit::{Spring, case_text};
use std::fs;

/// `--set` of the program of a side: the recording played back.
fn replay(role: &str, recording: &str, words: &[&str]) -> String {
    let words = [&[MENISCUS, "mock", "--replay", recording], words].concat();
    format!("{role}.participant={}", command(&words))
}

#[test]
fn either_side_of_the_gate_is_played_back_to_the_bit() {
    let bench = Bench::new();
    let file = bench.path("gate.record").display().to_string();
    let recorded = bench.coarse_gate("recorded", &["--record", &file]);
    let told = &recorded.summary().roles["coupler"].extra["recording"];
    let length = fs::metadata(&file).expect("a recording").len();
    assert!(
        told["file"] == file.as_str() && told["bytes"] == length && told["blocks"].as_u64() > Some(0),
        "{told}"
    );
    let in_process = bench.path("in-process.record").display().to_string();
    assert_same(&recorded, &bench.coarse_gate("in-process", &["--in-process", "--record", &in_process]));
    assert_same(&recorded, &bench.coarse_gate("not-recorded", &["--in-process"]));
    for (role, of) in [("fluid", &file), ("structure", &file), ("fluid", &in_process)] {
        let replayed = bench.coarse_gate("replayed", &["--set", &replay(role, of, &[])]);
        assert!(replayed.tables() == recorded.tables(), "{role} of {of}");
        let log = fs::read_to_string(replayed.0.join(format!("{role}.log"))).expect("a log");
        assert!(log.contains("all of them as recorded, to the bit"), "{log}");
        let notes = replayed.summary().notes;
        assert!(notes.iter().any(|note| note.contains("it is replayed from")), "{notes:?}");
    }
    let short = bench.path("short.record").display().to_string();
    let limited = bench.coarse_gate("limited", &["--record", &short, "--record-limit", "6kB"]);
    let notes = limited.summary().notes;
    assert!(notes.iter().any(|note| note.contains("limit of 6000 bytes")), "{notes:?}");
    assert!(fs::metadata(&short).expect("a recording").len() <= 6000);
    assert_same(&limited, &recorded);
    // Over a recording nothing is written, and of a run that goes on there is none.
    let over = bench.start_run("over", &[&COARSE[..], &["--record", &file]].concat()).wait();
    assert!(over.status.code() == Some(1) && over.errors.contains("it is there already"), "{}", over.errors);
    assert!(!bench.path("over").exists() && fs::metadata(&file).expect("a recording").len() == length);
    let nowhere = bench.path("nowhere").join("a.record").display().to_string();
    let refused = bench.start_run("over", &[&COARSE[..], &["--record", &nowhere]].concat()).wait();
    assert!(
        refused.status.code() == Some(1) && refused.errors.contains("folder is not"),
        "{}",
        refused.errors
    );
    assert!(!bench.path("over").exists());
    let resumed = bench.call(&["run", "--resume", "out", "--record", "other.record"]);
    assert_eq!(resumed.status.code(), Some(2), "{}", resumed.errors);
}

/// A recorded coupling of a mock and a unit.
struct Recorded {
    bench: Bench,
    file: String,
    recording: String,
}

impl Recorded {
    fn new() -> Self {
        let (bench, folder) = (Bench::new(), tempfile::tempdir().expect("a folder"));
        let unit = Spring::of(3).build(folder.path());
        let structure = Spring::of(3).participant(&unit, "stiffness = 400");
        let coupling = "[coupling]\nmax_window = 1e-3\nsub_steps = 4";
        let text = case_text(&mock(FLUID), &structure, 0.02, coupling);
        let path = bench.path("case.toml");
        fs::write(&path, text).expect("a case");
        let file = path.display().to_string();
        let recording = bench.path("a.record").display().to_string();
        let recorded = Self { bench, file, recording };
        let ended = recorded.run("recorded", &["--record", &recorded.recording]);
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        // The unit goes with its folder.
        recorded
    }

    fn run(&self, out: &str, words: &[&str]) -> Ended {
        self.bench
            .start_run(out, &[&[self.file.as_str()], words, &["--no-report", "--quiet"]].concat())
            .wait()
    }
}

const FLUID: &str = "added-mass-column wall=moving mass=0.1 gravity=9.81";

#[test]
fn what_is_not_there_any_more_is_played_back_and_a_bit_that_differs_is_named() {
    let recorded = Recorded::new();
    let Recorded { bench, recording, .. } = &recorded;
    assert_ne!(recorded.run("no-unit", &[]).status.code(), Some(0), "the unit is there no more");
    let structure = |words: &[&str]| replay("structure", recording, words);
    let replayed = recorded.run("replayed", &["--set", &structure(&[])]);
    assert_eq!(replayed.status.code(), Some(0), "{}", replayed.errors);
    assert!(bench.outputs("replayed").tables() == bench.outputs("recorded").tables());

    let other: Vec<&str> = FLUID.split_whitespace().chain(["--fault", "bit:2@7"]).collect();
    let other = [&[MENISCUS, "mock"], &other[..]].concat();
    let other = format!("fluid.participant.command={other:?}");
    let ended = recorded.run("ended", &["--set", &structure(&[]), "--set", &other]);
    let said = "in window 7 (iteration 1) from t = 0.007 s, field `pressure_gradient`, point 2, component 0: recorded";
    assert!(ended.status.code() == Some(1) && ended.errors.contains(said), "{}", ended.errors);
    let message = bench.outputs("ended").summary().message.expect("a reason");
    assert!(message.contains(said) && message.contains("difference"), "{message}");

    let on = structure(&["--on-departure", "continue"]);
    let went_on = recorded.run("went-on", &["--set", &on, "--set", &other]);
    assert_eq!(went_on.status.code(), Some(0), "{}", went_on.errors);
    let log = fs::read_to_string(bench.path("went-on").join("structure.log")).expect("a log");
    assert!(log.contains(said) && log.contains("largest departure: in window 7"), "{log}");
}

#[test]
fn what_is_no_recording_is_refused_by_name() {
    let bench = Bench::new();
    for (file, said) in [("Cargo.toml", "it is no recording"), ("none.record", "No such file")] {
        let refused =
            bench.call(&["mock", "--replay", file, "--role", "fluid", "--case", "none", "--run", "none"]);
        assert!(refused.status.code() == Some(1) && refused.errors.contains(said), "{}", refused.errors);
        assert!(refused.errors.contains(file), "{}", refused.errors);
    }
}
