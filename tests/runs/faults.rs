//! The table of faults: who fails, how and when, and what the others make of it. `docs/faults.md` shows the
//! same rows, and a test holds the two together.
//!
//! `cargo test --test runs how_soon -- --ignored --nocapture` measures how soon a kill is named.

use crate::processes::failed_in_order;
use crate::support::{Bench, MENISCUS, Running, gone, until};
use coupler::status::Status;
use interfaces::Role;
use output::summary;
use rustix::process::{Pid, Signal, kill_process};
use std::fs;
use std::time::{Duration, Instant};

/// What a participant does.
enum Does {
    /// A mock with this fault.
    Mock(&'static str),
    /// A script in which `MOCK` stands for the mock's command.
    Script(&'static str),
}
use Does::{Mock, Script};

/// A way in which a participant fails.
struct Row {
    fault: &'static str,
    when: &'static str,
    does: Does,
    /// What the coupler says, besides whose failure it is.
    words: &'static [&'static str],
    /// Windows in the tables and the summary afterwards, of [`WINDOWS`].
    windows: u64,
    /// In every scheme on both sides, rather than on one side that changes with the scheme.
    everywhere: bool,
}

const WINDOWS: u64 = 20;

const fn killed(when: &'static str, does: Does, words: &'static [&'static str], windows: u64) -> Row {
    Row { fault: "SIGKILL", when, does, words, windows, everywhere: true }
}

const fn row(
    fault: &'static str,
    when: &'static str,
    does: Does,
    words: &'static [&'static str],
    windows: u64,
) -> Row {
    Row { fault, when, does, words, windows, everywhere: false }
}

const ROWS: &[Row] = &[
    killed("handshake", Script("kill -9 $$"), &["while shaking hands", "signal 9"], 0),
    killed("initialising", Mock("kill@initialize"), &["while initialising", "signal 9"], 0),
    killed("first window", Mock("kill@0"), &["window 0", "signal 9"], 0),
    killed("middle", Mock("kill@10"), &["window 10", "signal 9"], 10),
    killed("last window", Mock("kill@19"), &["window 19", "signal 9"], 19),
    killed("ending", Mock("kill@terminate"), &["while ending", "signal 9"], 20),
    killed("after the last answer", Script("MOCK; kill -9 $$"), &["after its last answer", "signal 9"], 20),
    row("SIGTERM", "handshake", Script("kill -TERM $$"), &["while shaking hands", "signal 15"], 0),
    row(
        "SIGTERM",
        "after the last answer",
        Script("MOCK; kill -TERM $$"),
        &["after its last answer", "signal 15"],
        20,
    ),
    row("SIGSTOP", "first window", Mock("stop@0"), &["window 0", "no answer within its deadline of 1 s"], 0),
    row("SIGSTOP", "middle", Mock("stop@10"), &["window 10", "no answer within its deadline of 1 s"], 10),
    row("exit 0", "handshake", Script("exit 0"), &["while shaking hands", "exit code 0"], 0),
    row("exit 0", "middle", Mock("exit@10"), &["window 10", "exit code 0"], 10),
    row("exit 0", "last window", Mock("exit@19"), &["window 19", "exit code 0"], 19),
    row("panic", "first window", Mock("panic@0"), &["window 0", "it panicked: fault as told"], 0),
    row("panic", "middle", Mock("panic@10"), &["window 10", "it panicked: fault as told"], 10),
    row("abort", "middle", Mock("abort@10"), &["window 10", "signal 6"], 10),
    row("abort", "ending", Mock("abort@terminate"), &["while ending", "signal 6"], 20),
    row(
        "abort",
        "after the last answer",
        Script("MOCK; kill -ABRT $$"),
        &["after its last answer", "signal 6"],
        20,
    ),
    row(
        "not a number",
        "initialising",
        Mock("nan:2@initialize"),
        &["while initialising", "is not finite: component 0 at point 2"],
        0,
    ),
    row(
        "not a number",
        "middle",
        Mock("nan:2@10"),
        &["window 10", "is not finite: component 0 at point 2"],
        10,
    ),
    row("infinite", "middle", Mock("inf:2@10"), &["window 10", "is not finite: component 0 at point 2"], 10),
    row("wrong shape", "middle", Mock("no-points@10"), &["window 10"], 10),
    row(
        "never starts",
        "handshake",
        Script("exec /no/such/solver"),
        &["while shaking hands", "exit code 127"],
        0,
    ),
    row(
        "another case",
        "handshake",
        Script("sed s/1000/1001/ $MENISCUS_CASE > $MENISCUS_CASE.2; MENISCUS_CASE=$MENISCUS_CASE.2 MOCK"),
        &["while shaking hands", "case hash: the coupler has"],
        0,
    ),
];

const SCHEMES: [(&str, &[&str]); 3] = [
    ("explicit", &["coupling.scheme=serial-explicit"]),
    ("implicit", &["coupling.scheme=serial-implicit"]),
    ("parallel", &["coupling.scheme=parallel-explicit", "coupling.relaxation=0.1"]),
];

/// What stands in `docs/faults.md` for each row: a fault, the moment, the words, the windows on the disk.
fn documented(row: &Row) -> String {
    let words = row.words.iter().map(|words| format!("`{words}`")).collect::<Vec<_>>().join(", ");
    format!("| {} | {} | {words} | {} |", row.fault, row.when, row.windows)
}

/// Rows held by tests elsewhere, as `docs/faults.md` names them: ``` `file`: `test` ```.
fn named_tests(text: &str) -> Vec<(String, String)> {
    let tick =
        |cell: &str| -> Vec<String> { cell.split('`').skip(1).step_by(2).map(str::to_owned).collect() };
    let rows = text.lines().filter(|line| line.starts_with("| ") && line.contains(".rs`: `"));
    rows.filter_map(|line| {
        let cell = line.trim_end_matches(" |").rsplit(" | ").next()?;
        let [file, test] = <[String; 2]>::try_from(tick(cell)).ok()?;
        Some((file, test))
    })
    .collect()
}

#[test]
fn the_documented_faults_are_those_of_the_tests() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(root.join("docs/faults.md")).expect("the page of faults");
    let part = text.split("<!-- faults -->").nth(1).expect("the table, between two marks");
    let found: Vec<&str> = part.lines().filter(|line| line.starts_with("| ")).skip(1).collect();
    let expected: Vec<String> = ROWS.iter().map(documented).collect();
    assert!(found == expected, "docs/faults.md has to say:\n{}", expected.join("\n"));
    let named = named_tests(&text);
    assert!(named.len() > 10, "{named:?}");
    for (file, test) in named {
        let source = fs::read_to_string(root.join(&file)).expect("the file of a test that the page names");
        assert!(source.contains(&format!("fn {test}(")), "{file} has no test {test}");
    }
}

/// A case of mocks: [`WINDOWS`] windows, or without an end, in which a solution takes some milliseconds.
fn case(bench: &Bench, victim: Option<(Role, &Does)>, endless: bool) -> String {
    let participant = |role: Role, words: &str| {
        let slow = if endless { " fault=slow:0.003@*/start" } else { "" };
        let mock = format!("{MENISCUS} mock {words}{slow}");
        let script = match victim.filter(|(of, _)| *of == role) {
            Some((_, Mock(fault))) => format!("exec {mock} fault={fault}"),
            Some((_, Script(script))) => script.replace("MOCK", &mock),
            None => format!("exec {mock}"),
        };
        format!("{{ command = [\"sh\", \"-c\", '{script}'] }}")
    };
    let text = crate::unit::spring_unit::case_text(
        &participant(Role::Fluid, "constant gradient=0,1e3"),
        &participant(Role::Structure, "spring-mass points=5 stiffness=400"),
        if endless { 60.0 } else { 0.02 },
        "[coupling]\nmax_window = 1e-3\nsub_steps = 4\ndeadline = 1.0",
    );
    let file = bench.path("case.toml");
    fs::write(&file, text).expect("a case");
    file.display().to_string()
}

fn start(bench: &Bench, out: &str, file: &str, scheme: &[&str]) -> Running {
    let settings: Vec<&str> = scheme.iter().flat_map(|setting| ["--set", setting]).collect();
    bench.start_run(out, &[&[file], settings.as_slice(), &["--no-report", "--quiet"]].concat())
}

fn rows_under(scheme: usize) {
    let (name, settings) = SCHEMES[scheme];
    for (index, row) in ROWS.iter().enumerate() {
        for (side, victim) in [Role::Fluid, Role::Structure].into_iter().enumerate() {
            if !row.everywhere && side != (index + scheme) % 2 {
                continue;
            }
            eprintln!("{name}: {} of the {victim}, {}", row.fault, row.when);
            let bench = Bench::new();
            let file = case(&bench, Some((victim, &row.does)), false);
            let ended = start(&bench, "out", &file, settings).wait();
            let failed = format!("the {victim} failed");
            let outputs = failed_in_order(&bench, "out", &ended, &[&[failed.as_str()], row.words].concat());
            let table = outputs.0.join("windows.csv");
            let rows = if table.exists() { outputs.table("windows.csv").rows() as u64 } else { 0 };
            assert_eq!((outputs.summary().windows, rows), (row.windows, row.windows));
        }
    }
    assert_eq!(ROWS.iter().map(|row| row.windows).max(), Some(WINDOWS));
}

#[test]
fn every_fault_of_a_participant_is_named_under_an_explicit_scheme() {
    rows_under(0);
}

#[test]
fn every_fault_of_a_participant_is_named_under_an_implicit_scheme() {
    rows_under(1);
}

#[test]
fn every_fault_of_a_participant_is_named_under_a_parallel_scheme() {
    rows_under(2);
}

fn wait_for_windows(bench: &Bench, windows: usize) {
    let file = bench.path("out").join("windows.csv");
    until("the windows", || {
        output::table::read(&file).is_ok_and(|table| table.rows() >= windows).then_some(())
    });
}

fn participants(run: &Running) -> [Pid; 2] {
    [Role::Fluid, Role::Structure].map(|role| run.participant(role))
}

/// The run's guard, which enters the domain once more after all others have left: before it has ended, an
/// empty domain is none for good.
fn guard(run: &Running) -> Pid {
    let id = run.pid().as_raw_nonzero();
    until("the guard", || {
        let children = fs::read_to_string(format!("/proc/{id}/task/{id}/children")).ok()?;
        let guard = children.split_whitespace().find(|child| {
            let words = fs::read(format!("/proc/{child}/cmdline")).unwrap_or_default();
            words.split(|&byte| byte == 0).nth(1) == Some(b"guard".as_slice())
        })?;
        Pid::from_raw(guard.parse().ok()?)
    })
}

/// Killed or told to end, under every scheme, from the first window on.
#[test]
fn a_coupler_that_ends_takes_its_participants_along_under_every_scheme() {
    for (name, settings) in SCHEMES {
        for (signal, windows) in
            [(Signal::KILL, 1), (Signal::KILL, 10), (Signal::TERM, 1), (Signal::TERM, 10)]
        {
            let bench = Bench::new();
            let run = start(&bench, "out", &case(&bench, None, true), settings);
            let (others, guard) = (participants(&run), guard(&run));
            wait_for_windows(&bench, windows);
            run.signal(signal);
            let ended = run.wait();
            for process in others.into_iter().chain([guard]) {
                until("its end", || gone(process).then_some(()));
            }
            until("an empty shared memory", || bench.left().is_empty().then_some(()));
            let outputs = bench.outputs("out");
            assert!(outputs.table("windows.csv").rows() >= windows, "{name}");
            if signal == Signal::TERM {
                assert_eq!(ended.status.code(), Some(130), "{name}: {}", ended.errors);
                assert_eq!(outputs.summary().status, summary::Status::Interrupted);
                continue;
            }
            assert_eq!(ended.status.code(), None, "{name}");
            assert!(!outputs.0.join("summary.json").exists());
            for role in ["fluid", "structure"] {
                let log = fs::read_to_string(outputs.0.join(format!("{role}.log"))).expect("a log");
                assert!(log.contains("error: lost the coupler: its process died"), "{name}: {log}");
            }
        }
    }
}

/// All of a run at once: its guard removes what they left.
#[test]
fn all_three_killed_at_once_leave_nothing() {
    let bench = Bench::new();
    let run = start(&bench, "out", &case(&bench, None, true), SCHEMES[0].1);
    let (others, guard) = (participants(&run), guard(&run));
    wait_for_windows(&bench, 3);
    run.signal(Signal::KILL);
    for process in others {
        kill_process(process, Signal::KILL).expect("it runs");
    }
    assert_eq!(run.wait().status.code(), None);
    until("the guard's end", || gone(guard).then_some(()));
    until("an empty shared memory", || bench.left().is_empty().then_some(()));
}

/// The guard as well: what is left then goes with the next command, whichever it is.
#[test]
fn what_nobody_is_left_to_remove_goes_with_the_next_command() {
    let bench = Bench::new();
    let run = start(&bench, "out", &case(&bench, None, true), SCHEMES[0].1);
    participants(&run);
    wait_for_windows(&bench, 3);
    let coupler = run.pid().as_raw_nonzero();
    let children = fs::read_to_string(format!("/proc/{coupler}/task/{coupler}/children")).expect("children");
    let children: Vec<Pid> =
        children.split_whitespace().filter_map(|id| Pid::from_raw(id.parse().ok()?)).collect();
    assert!(children.len() >= 3, "two participants and a guard");
    // Stopped first, so that none sees another's end.
    for signal in [Signal::STOP, Signal::KILL] {
        run.signal(signal);
        for child in &children {
            kill_process(*child, signal).expect("it is there");
        }
    }
    run.wait();
    until("their ends", || children.iter().copied().all(gone).then_some(()));
    assert!(!bench.left().is_empty(), "who was there to remove it?");
    let ended = bench.call(&["status", &bench.path("out").display().to_string()]);
    assert_eq!(ended.status.code(), Some(1), "{}", ended.errors);
    assert_eq!(bench.left(), Vec::<String>::new());
}

/// One that ends while the other is waited for is not left to be found out at its turn.
#[test]
fn who_ends_while_the_other_is_waited_for_is_named() {
    let initialising = (Mock("hang@initialize"), "while the structure was initialising");
    let solving = (Mock("hang@3"), "while the structure was solving window 3");
    for (name, settings) in SCHEMES {
        for (does, words) in [&initialising, &solving] {
            let bench = Bench::new();
            let file = case(&bench, Some((Role::Structure, does)), true);
            let run = start(&bench, "out", &file, settings);
            let fluid = run.participant(Role::Fluid);
            until("the structure's silence", || {
                let status = Status::read(&bench.path("out")).ok()?;
                let waits = status.waits_for == Some(Role::Structure);
                (waits && status.waits_seconds > Some(0.1)).then_some(())
            });
            kill_process(fluid, Signal::KILL).expect("it runs");
            let ended = run.wait();
            let words = ["the fluid failed", words, "before its turn", "signal 9"];
            // A deadline, of a second here, names the structure.
            failed_in_order(&bench, "out", &ended, &words);
            assert!(!ended.errors.contains("deadline"), "{name}: {}", ended.errors);
        }
    }
}

/// A queue tells all processes of a job to end, and the coupler then still wants its checkpoint.
#[test]
fn a_participant_that_alone_is_told_to_end_goes_on_for_a_while() {
    let bench = Bench::new();
    let run = start(&bench, "out", &case(&bench, None, true), SCHEMES[0].1);
    wait_for_windows(&bench, 1);
    for process in participants(&run) {
        kill_process(process, Signal::TERM).expect("it runs");
    }
    let windows = || output::table::read(&bench.path("out").join("windows.csv")).map_or(0, |t| t.rows());
    wait_for_windows(&bench, windows() + 20);
    run.signal(Signal::TERM);
    assert_eq!(run.wait().status.code(), Some(130));
}

/// Twenty kills in each phase, or `FAULT_KILLS`: until the run says whose failure it is, and until everybody
/// has ended.
#[test]
#[ignore = "measures; half a minute"]
fn how_soon_a_kill_is_named() {
    let kills: usize = std::env::var("FAULT_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(20);
    for (phase, windows) in [("handshake", None), ("initialising", Some(0)), ("window", Some(3))] {
        for (name, settings) in SCHEMES {
            let (mut named, mut ended) = (Vec::new(), Vec::new());
            for kill in 0..kills {
                let bench = Bench::new();
                let victim = [Role::Fluid, Role::Structure][kill % 2];
                let waits = match windows {
                    None => Some(Script("sleep 60")),
                    Some(0) => Some(Mock("hang@initialize")),
                    Some(_) => None,
                };
                let file = case(&bench, waits.as_ref().map(|does| (victim, does)), true);
                let mut run = start(&bench, "out", &file, settings);
                let others = participants(&run);
                match windows {
                    Some(windows) if windows > 0 => wait_for_windows(&bench, windows),
                    // Long enough for both to be started and short of the deadline of a second.
                    _ => std::thread::sleep(Duration::from_millis(300)),
                }
                kill_process(others[kill % 2], Signal::KILL).expect("it runs");
                let killed = Instant::now();
                until("words", || run.printed("err").contains("failed").then_some(()));
                named.push(killed.elapsed());
                until("the end", || (run.has_ended() && others.into_iter().all(gone)).then_some(()));
                ended.push(killed.elapsed());
            }
            for times in [&mut named, &mut ended] {
                times.sort();
            }
            let tell =
                |times: &[Duration]| (times[times.len() / 2].as_millis(), times[times.len() - 1].as_millis());
            println!(
                "{phase}, {name}: named {:?} ms, all ended {:?} ms (median, largest)",
                tell(&named),
                tell(&ended)
            );
        }
    }
}
