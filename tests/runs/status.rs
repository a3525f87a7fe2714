//! A run that goes on, seen and asked from outside; and what is told when a deadline has passed.

use crate::support::{Bench, COARSE, Outputs, Running, until};
use coupler::request::Request;
use coupler::status::{self, Status};
use interfaces::Role;
use rustix::process::{Signal, kill_process};

/// A run of the coarse gate that does not end by itself while a test looks.
fn endless(bench: &Bench, words: &[&str]) -> Running {
    bench.start_run("out", &[&COARSE, ["--set", "case.end_time=60"].as_slice(), words].concat())
}

/// Waits until the run tells of so many windows.
fn wait_for_windows(bench: &Bench, windows: u64) -> Status {
    until("the windows", || Status::read(&bench.path("out")).ok().filter(|status| status.windows >= windows))
}

fn meniscus(bench: &Bench, words: &[&str]) -> (Option<i32>, String) {
    let ended = bench.call(words);
    (ended.status.code(), ended.text + &ended.errors)
}

#[test]
fn a_run_tells_what_it_is_at_and_takes_up_what_is_asked() {
    let bench = Bench::new();
    let run = endless(&bench, &[]);
    let out = bench.path("out").display().to_string();
    let told = wait_for_windows(&bench, 10);
    assert!(told.participants.iter().all(|party| party.process.is_some() && party.memory_bytes > 1 << 20));

    let fluid = run.participant(Role::Fluid);
    kill_process(fluid, Signal::STOP).expect("it runs");
    let waits = until("a stopped fluid in the status", || {
        let (code, text) = meniscus(&bench, &["status", &out]);
        assert_eq!(code, Some(0), "{text}");
        text.contains("its process is stopped").then_some(text)
    });
    assert!(waits.contains("coupler     waits for the fluid to solve window "), "{waits}");
    assert!(waits.contains("structure   waits for the coupler; it solved window "), "{waits}");
    let (code, text) = meniscus(&bench, &["ask", &out, "--output-interval", "0.25", "--wait", "0.1"]);
    assert!(code == Some(1) && text.contains("it has not been taken up yet"), "{text}");
    kill_process(fluid, Signal::CONT).expect("it is there");

    let (code, text) = meniscus(&bench, &["ask", &out, "--checkpoint", "--wait", "60"]);
    assert!(code == Some(0) && text.contains("a checkpoint was written, after "), "{text}");
    // It went together with the request before it, or after it.
    until("the other interval", || {
        Status::read(&bench.path("out")).ok().filter(|status| status.output_interval == 0.25)
    });
    std::fs::write(bench.path("out").join("request.json"), "nonsense").expect("a file in the folder");
    let warned = until("a warning", || {
        let status = Status::read(&bench.path("out")).ok()?;
        status.warnings.first().cloned()
    });
    assert!(warned.starts_with("request.json was not taken up"), "{warned}");

    let (code, text) = meniscus(&bench, &["ask", &out, "--stop", "--wait", "60"]);
    assert_eq!(code, Some(0), "{text}");
    let ended = run.wait();
    assert_eq!(ended.status.code(), Some(130), "{}", ended.errors);
    let summary = bench.outputs("out").summary();
    assert!(
        summary.notes.iter().any(|note| note.contains("outputs came every 0.25 s")),
        "{:?}",
        summary.notes
    );
    assert!(!bench.path("out").join(status::FILE).exists(), "a run that has ended has a summary");
    let (code, text) = meniscus(&bench, &["status", &out]);
    assert_eq!(code, Some(1));
    assert!(text.contains("interrupted") && text.contains("meniscus run --resume"), "{text}");
    let (code, text) = meniscus(&bench, &["ask", &out, "--checkpoint"]);
    assert!(code == Some(1) && text.contains("no run goes on in"), "{text}");
}

#[test]
fn a_killed_run_is_told_from_one_that_lives() {
    let bench = Bench::new();
    let run = endless(&bench, &[]);
    let out = bench.path("out").display().to_string();
    wait_for_windows(&bench, 1);
    run.signal(Signal::KILL);
    run.wait();
    let (code, text) = meniscus(&bench, &["status", &out]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.starts_with("killed ") && text.contains("there is no checkpoint"), "{text}");
    let (code, text) = meniscus(&bench, &["status", &bench.path("nowhere").display().to_string()]);
    assert!(code == Some(1) && text.contains("failed to find a run in"), "{text}");
    // The guard ends those who are left.
    until("the end of all", || bench.left().is_empty().then_some(()));
}

/// Whoever does not answer in time is named with what it is at, and those who wait for it.
#[test]
fn a_deadline_that_passes_names_who_waits_for_whom() {
    let implicit = ["--set", "coupling.scheme=parallel-implicit"];
    let rows = [
        (Role::Fluid, &[][..], "\nstructure   waits for the coupler; it "),
        (Role::Structure, &implicit[..], " (its answer is taken after that of the structure)"),
    ];
    for (victim, words, other) in rows {
        let bench = Bench::new();
        let run = endless(&bench, &[&["--set", "coupling.deadline=1"], words].concat());
        wait_for_windows(&bench, 1);
        kill_process(run.participant(victim), Signal::STOP).expect("it runs");
        let ended = run.wait();
        assert_eq!(ended.status.code(), Some(1), "{}", ended.errors);
        let message = Outputs(bench.path("out")).summary().message.expect("a failed run says why");
        for part in [
            format!("the {victim} failed while "),
            "gave no answer within its deadline of 1 s".to_owned(),
            format!("\ncoupler     waits for the {victim} to "),
            format!("\n{:<12}was asked 1.", victim.to_string()),
            "its process is stopped".to_owned(),
            other.to_owned(),
            "coupling.deadline".to_owned(),
        ] {
            assert!(message.contains(&part), "`{part}` is not in: {message}");
        }
        assert_eq!(bench.left(), Vec::<String>::new());
    }
}

/// Requests are of a form that older and newer programs may write; nobody else's keys are guessed at.
#[test]
fn a_request_is_small_and_plain() {
    let request = Request { number: 1, checkpoint: true, ..Request::default() };
    let dir = tempfile::tempdir().expect("a folder");
    request.write(dir.path()).expect("written");
    let text = std::fs::read_to_string(dir.path().join("request.json")).expect("read");
    assert_eq!(text, r#"{"number":1,"checkpoint":true,"stop":false,"output_interval":null}"#);
}
