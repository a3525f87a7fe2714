//! Every way in which a process of a run can end, and what the others make of it.
//!
//! No test asserts a time. Where a death must be noticed, the deadline of an answer is the usual minute, and
//! [`noticed`] allows a fraction of it.

use crate::support::{Bench, COARSE, Ended, Outputs, Running, assert_same, gone, until};
use interfaces::Role;
use output::summary::Status;
use rustix::process::{Pid, Signal, kill_process};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A run of the coarse gate that does not end by itself while a test looks.
fn endless(bench: &Bench, out: &str, words: &[&str]) -> Running {
    bench.start_run(out, &[&COARSE, ["--set", "case.end_time=60"].as_slice(), words].concat())
}

/// Waits until so many windows are recorded.
fn wait_for_windows(bench: &Bench, out: &str, windows: usize) {
    let file = bench.path(out).join("windows.csv");
    until("the windows", || {
        let rows = output::table::read(&file).map_or(0, |table| table.rows());
        (rows >= windows).then_some(())
    });
}

/// Waits for the end, which must come from the event and not from the deadline of a minute.
fn noticed(run: Running) -> Ended {
    let started = Instant::now();
    let ended = run.wait();
    let seconds = started.elapsed().as_secs_f64();
    println!("ended after {seconds:.2} s: {}", ended.errors);
    assert!(seconds < 20.0, "{seconds} s: the deadline ended it: {}", ended.errors);
    ended
}

/// A failed run has its exit code, names what is in `words`, and leaves everything readable and nobody
/// behind.
pub fn failed_in_order(bench: &Bench, out: &str, ended: &Ended, words: &[&str]) -> Outputs {
    assert_eq!(ended.status.code(), Some(1), "{}", ended.errors);
    let outputs = bench.outputs(out);
    let summary = outputs.summary();
    let message = summary.message.expect("a failed run says why");
    assert_eq!(summary.status, Status::Failed);
    assert!(ended.errors.contains(&format!("error: {message}")), "{}", ended.errors);
    for word in words {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
    assert_eq!(bench.left(), Vec::<String>::new(), "after: {message}");
    outputs
}

/// What stands in the tables is whole and begins like the run that was not disturbed.
fn readable(outputs: &Outputs, windows: usize) {
    let table = outputs.table("windows.csv");
    assert!(table.rows() >= windows, "{} windows of {windows}", table.rows());
    assert!(outputs.table("probes.csv").rows() >= windows);
    // The start, and the output due in the meantime.
    assert!(outputs.snapshots().len() >= 2);
}

#[test]
fn a_killed_participant_is_named_and_nothing_is_left() {
    for victim in [Role::Fluid, Role::Structure] {
        for windows in [0, 10, 60] {
            let bench = Bench::new();
            let run = endless(&bench, "out", &[]);
            let others = [Role::Fluid, Role::Structure].map(|role| run.participant(role));
            if windows > 0 {
                wait_for_windows(&bench, "out", windows);
            }
            kill_process(run.participant(victim), Signal::KILL).expect("it runs");
            let ended = noticed(run);
            let name = format!("the {victim} failed while");
            let outputs = failed_in_order(&bench, "out", &ended, &[&name, "signal 9"]);
            if windows > 0 {
                assert!(ended.errors.contains("window "), "{}", ended.errors);
                readable(&outputs, windows);
            }
            assert!(others.into_iter().all(gone));
            let report = bench.call(&["report", &outputs.0.display().to_string()]);
            assert_eq!(report.status.code(), Some(0), "{}", report.errors);
        }
    }
}

/// While a process makes its node, services and ports, iceoryx2 cannot remove what it leaves; a kill at that
/// moment must leave nothing all the same.
#[test]
fn who_is_killed_while_connecting_leaves_nothing() {
    for millisecond in 0..12 {
        let bench = Bench::new();
        let victim = [Role::Fluid, Role::Structure][millisecond % 2];
        let run = endless(&bench, "out", &[]);
        let process = run.participant(victim);
        sleep(Duration::from_millis(millisecond as u64));
        kill_process(process, Signal::KILL).expect("it runs");
        let ended = noticed(run);
        failed_in_order(&bench, "out", &ended, &[&format!("the {victim} failed while"), "signal 9"]);
    }
    for milliseconds in [8, 16, 24, 32] {
        let bench = Bench::new();
        let run = endless(&bench, "out", &[]);
        sleep(Duration::from_millis(milliseconds));
        // The coupler. Participants that it has started end by themselves; if there are none, the next run
        // finds what it left.
        run.signal(Signal::KILL);
        drop(run);
        bench.coarse_gate("next", &[]);
        until("an empty shared memory", || bench.left().is_empty().then_some(()));
    }
}

#[test]
fn participants_of_a_killed_coupler_end_by_themselves() {
    for windows in [0, 10, 60] {
        let bench = Bench::new();
        let run = endless(&bench, "out", &[]);
        let participants = [Role::Fluid, Role::Structure].map(|role| run.participant(role));
        if windows > 0 {
            wait_for_windows(&bench, "out", windows);
        }
        run.signal(Signal::KILL);
        let killed = Instant::now();
        assert_eq!(noticed(run).status.code(), None);
        for participant in participants {
            until("the participant's end", || gone(participant).then_some(()));
        }
        println!("participants ended {:.2} s after the coupler", killed.elapsed().as_secs_f64());
        assert!(killed.elapsed() < Duration::from_secs(20), "a deadline ended them");
        let outputs = bench.outputs("out");
        assert!(!outputs.0.join("summary.json").exists());
        if windows > 0 {
            readable(&outputs, windows);
            for role in ["fluid", "structure"] {
                let log = std::fs::read_to_string(outputs.0.join(format!("{role}.log"))).expect("a log");
                assert!(log.contains("error: lost the coupler: its process died"), "{log}");
            }
            let report = bench.call(&["report", &outputs.0.display().to_string()]);
            assert_eq!(report.status.code(), Some(0), "{}", report.errors);
        }
        assert_eq!(bench.left(), Vec::<String>::new());
    }
}

#[test]
fn a_stopped_participant_is_given_up_at_the_deadline() {
    for victim in [Role::Fluid, Role::Structure] {
        let bench = Bench::new();
        let run = endless(&bench, "out", &["--set", "coupling.deadline=1"]);
        wait_for_windows(&bench, "out", 10);
        let others = [Role::Fluid, Role::Structure].map(|role| run.participant(role));
        kill_process(run.participant(victim), Signal::STOP).expect("it runs");
        let name = format!("the {victim} failed while solving window ");
        let deadline = "it gave no answer within its deadline of 1 s while solving window ";
        let ended = noticed(run);
        readable(&failed_in_order(&bench, "out", &ended, &[&name, deadline]), 10);
        assert!(others.into_iter().all(gone));
    }
}

#[test]
fn a_stopped_coupler_is_given_up_and_ends_when_it_wakes() {
    let bench = Bench::new();
    let run = endless(&bench, "out", &["--set", "coupling.deadline=1"]);
    wait_for_windows(&bench, "out", 10);
    let participants = [Role::Fluid, Role::Structure].map(|role| run.participant(role));
    run.signal(Signal::STOP);
    // They are children of a stopped process, which does not ask for their exit codes: they stay as zombies.
    for participant in participants {
        until("the participant's end", || gone(participant).then_some(()));
    }
    for role in ["fluid", "structure"] {
        let log = std::fs::read_to_string(bench.path("out").join(format!("{role}.log"))).expect("a log");
        assert!(log.contains("it gave no answer within its deadline of 3 s"), "{log}");
    }
    run.signal(Signal::CONT);
    let ended = noticed(run);
    readable(&failed_in_order(&bench, "out", &ended, &["failed while", "exit code 1"]), 10);
}

#[test]
fn an_interrupted_run_ends_in_order() {
    for (windows, signal) in [(0, Signal::INT), (10, Signal::INT), (10, Signal::TERM)] {
        let bench = Bench::new();
        let run = endless(&bench, "out", &[]);
        let participants = [Role::Fluid, Role::Structure].map(|role| run.participant(role));
        if windows > 0 {
            wait_for_windows(&bench, "out", windows);
        }
        run.signal(signal);
        let ended = noticed(run);
        assert_eq!(ended.status.code(), Some(130), "{}", ended.errors);
        assert!(participants.into_iter().all(gone));
        assert_eq!(bench.left(), Vec::<String>::new());
        let outputs = bench.outputs("out");
        let summary = outputs.summary();
        assert_eq!((summary.status, summary.message.is_some()), (Status::Interrupted, true));
        if windows > 0 {
            readable(&outputs, windows);
            assert_eq!(summary.windows as usize, outputs.table("windows.csv").rows());
        }
    }
}

#[test]
fn an_interrupted_run_without_processes_ends_after_its_window() {
    let bench = Bench::new();
    let run = endless(&bench, "out", &["--in-process"]);
    wait_for_windows(&bench, "out", 10);
    run.signal(Signal::INT);
    let ended = noticed(run);
    assert_eq!(ended.status.code(), Some(130), "{}", ended.errors);
    let outputs = bench.outputs("out");
    assert_eq!(outputs.summary().status, Status::Interrupted);
    readable(&outputs, 10);
}

#[test]
fn a_second_interrupt_ends_the_run_at_once() {
    let bench = Bench::new();
    let run = endless(&bench, "out", &[]);
    wait_for_windows(&bench, "out", 10);
    let participants = [Role::Fluid, Role::Structure].map(|role| run.participant(role));
    // A participant that hangs keeps the first one waiting.
    kill_process(participants[0], Signal::STOP).expect("it runs");
    run.signal(Signal::INT);
    sleep(Duration::from_millis(50));
    run.signal(Signal::INT);
    assert_eq!(noticed(run).status.code(), Some(130));
    // Nobody is left to kill it; it ends when it goes on.
    let _ = kill_process(participants[0], Signal::CONT);
    for participant in participants {
        until("the participant's end", || gone(participant).then_some(()));
    }
    // The guard looks once more when they have gone.
    until("an empty shared memory", || bench.left().is_empty().then_some(()));
}

/// Both sides as mocks in processes: `fluid` and `structure` are the words after `meniscus mock`.
fn mocks(bench: &Bench, out: &str, fluid: &str, structure: &str, words: &[&str]) -> Running {
    let [fluid, structure] = [(Role::Fluid, fluid), (Role::Structure, structure)].map(|(role, words)| {
        let words: Vec<_> = words.split_whitespace().map(|word| format!("\"{word}\"")).collect();
        format!(
            "{role}.participant.command=[\"{}\", \"mock\", {}]",
            crate::support::MENISCUS,
            words.join(", ")
        )
    });
    let set = ["--set", &fluid, "--set", &structure, "--set", "case.end_time=0.2"];
    bench.start_run(out, &[&COARSE, set.as_slice(), words].concat())
}

#[test]
fn whatever_a_participant_does_wrong_is_named() {
    let bench = Bench::new();
    for (fault, words) in [
        ("abort@5", ["window 5", "signal 6"].as_slice()),
        ("kill@5.0/start", &["window 5", "signal 9"]),
        ("panic@5", &["window 5", "it panicked: fault as told"]),
        ("error@5", &["window 5", "fault as told: an error in `finish`"]),
        ("nan:2@5", &["window 5", "is not finite: component 0 at point 2"]),
        ("nan:2@initialize", &["while initialising", "is not finite: component 0 at point 2"]),
        ("no-points@5", &["window 5"]),
        ("scalars@5", &["window 5", "scalars where"]),
        ("limit:0@5", &["window 5", "a next window of 0 s"]),
        ("limit:-1@initialize", &["while initialising", "a next window of -1 s"]),
        ("hang@5", &["window 5", "no answer within its deadline of 1 s"]),
        ("stop@5", &["window 5", "no answer within its deadline of 1 s"]),
        ("error@initialize", &["while initialising", "fault as told"]),
        ("abort@initialize", &["while initialising", "signal 6"]),
        ("hang@initialize", &["while initialising", "no answer within its deadline of 1 s"]),
        ("error@5/accept", &["window 6", "fault as told: an error in `accept`, window 5"]),
        ("abort@5/accept", &["signal 6"]),
        ("error@terminate", &["while ending", "fault as told: an error in `terminate`"]),
        ("abort@terminate", &["while ending", "signal 6"]),
    ] {
        for victim in [Role::Fluid, Role::Structure] {
            let (mut fluid, mut structure) = ("constant gradient=1e3".to_owned(), "spring-mass".to_owned());
            let faulty = if victim == Role::Fluid { &mut fluid } else { &mut structure };
            *faulty += &format!(" --fault {fault}");
            let run = mocks(&bench, "out", &fluid, &structure, &["--set", "coupling.deadline=1"]);
            println!("{victim} {fault}");
            let ended = noticed(run);
            let name = format!("the {victim} failed while");
            let outputs = failed_in_order(&bench, "out", &ended, &[&[name.as_str()], words].concat());
            if fault.contains("@5") {
                assert_eq!(
                    outputs.summary().windows,
                    if fault.contains("accept") { 6 } else { 5 },
                    "{fault}"
                );
                assert_eq!(outputs.table("windows.csv").rows() as u64, outputs.summary().windows);
            }
        }
    }
}

#[test]
fn who_cannot_be_started_leaves_nobody_behind() {
    let bench = Bench::new();
    for victim in [Role::Fluid, Role::Structure] {
        // A program that the system finds and cannot start: of no format that it knows, and no script.
        let program = bench.path("solver");
        std::fs::write(&program, [0x7f, b'E', b'L', b'F', 0]).expect("a file");
        let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
        std::fs::set_permissions(&program, mode).expect("a mode");
        let program = program.display().to_string();
        for (command, words) in [
            (program.as_str(), ["while shaking hands", "exit code 127", &program].as_slice()),
            ("false", &["while shaking hands", "exit code 1"]),
        ] {
            let set = format!("{victim}.participant.command=[\"{command}\"]");
            let ended = noticed(bench.start_run("out", &[&COARSE, ["--set", &set].as_slice()].concat()));
            failed_in_order(&bench, "out", &ended, &[&[victim.to_string().as_str()], words].concat());
        }
    }
}

#[test]
fn a_folder_takes_one_run_at_a_time() {
    let bench = Bench::new();
    let run = endless(&bench, "out", &[]);
    wait_for_windows(&bench, "out", 1);
    let second = endless(&bench, "out", &["--in-process"]).wait();
    assert_eq!(second.status.code(), Some(1), "{}", second.errors);
    assert!(
        second.errors.contains("another run writes to it; choose another with --out"),
        "{}",
        second.errors
    );
    wait_for_windows(&bench, "out", 10);
    run.signal(Signal::INT);
    assert_eq!(noticed(run).status.code(), Some(130));
    readable(&bench.outputs("out"), 10);
}

#[test]
fn another_run_at_the_same_time_is_undisturbed() {
    let bench = Bench::new();
    let words = ["--set", "case.end_time=0.06"];
    let alone = bench.coarse_gate("alone", &words);
    // Of the same user and domain: others die and are cleaned up after while it goes on, and a pause does it
    // no harm.
    let run = bench.start_run("beside", &[&COARSE, words.as_slice()].concat());
    let other = endless(&bench, "other", &[]);
    let participants: [Pid; 2] = [Role::Fluid, Role::Structure].map(|role| other.participant(role));
    kill_process(participants[1], Signal::KILL).expect("it runs");
    other.signal(Signal::KILL);
    run.signal(Signal::STOP);
    let ended =
        bench.start_run("third", &[&COARSE, ["--set", "case.end_time=0.01"].as_slice()].concat()).wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    run.signal(Signal::CONT);
    let ended = run.wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    assert_same(&alone, &bench.outputs("beside"));
    for participant in participants {
        until("the participant's end", || gone(participant).then_some(()));
    }
    drop(other);
    // The last to end removes what the killed left.
    bench.coarse_gate("last", &[]);
}

/// What another user planted where the domain's folder has to be ends the run in words, and is left as it is.
#[test]
fn a_planted_folder_ends_the_run_in_words() {
    let bench = Bench::new();
    let root = interfaces::Address::new("any", Role::Fluid).in_domain(&bench.domain).root();
    let elsewhere = bench.path("elsewhere");
    std::fs::create_dir(&elsewhere).expect("a folder");
    std::os::unix::fs::symlink(&elsewhere, &root).expect("a link");
    let started = Instant::now();
    let ended = bench.start_run("out", &COARSE).wait();
    let took = started.elapsed();
    std::fs::remove_file(&root).expect("the link");
    failed_in_order(&bench, "out", &ended, &[&root, "a symbolic link"]);
    assert!(took < Duration::from_secs(20), "{took:?}");
    assert_eq!(std::fs::read_dir(&elsewhere).expect("the folder").count(), 0);
}

/// Two mocks, ten thousand windows under an implicit scheme.
pub const MANY_WINDOWS: &str = r#"
[case]
title = "Many windows"
dimension = 2
end_time = 1.0
output_interval = 0.5
particle_spacing = 0.01

[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
domain = { low = [0.0, 0.0], high = [1.0, 1.0] }
participant = { command = ["MENISCUS", "mock", "constant", "gradient=0,1e3"] }

[structure]
material = { law = "saint-venant-kirchhoff", youngs_modulus = 1e6, poisson_ratio = 0.3, density = 1000.0 }
participant = { command = ["MENISCUS", "mock", "spring-mass", "stiffness=400"] }

[coupling]
scheme = "serial-implicit"
max_window = 1e-4
"#;

/// A coupler that is killed takes all that it started with it: participants in the middle of a long window,
/// programs of another make that never look, and what those started.
#[test]
fn whoever_outlives_a_killed_coupler_is_ended() {
    let bench = Bench::new();
    let number = bench.path("number");
    let script = format!("sleep 300 & echo $! > {}; exec sleep 300", number.display());
    let setting = format!("structure.participant={{ command = [\"sh\", \"-c\", \"{script}\"] }}");
    let run = bench.start_run("out", &[&COARSE, ["--set", &setting].as_slice()].concat());
    let others = [Role::Fluid, Role::Structure].map(|role| run.participant(role));
    let grandchild = until("the grandchild", || {
        Pid::from_raw(std::fs::read_to_string(&number).ok()?.trim().parse().ok()?)
    });
    run.signal(Signal::KILL);
    for process in others.into_iter().chain([grandchild]) {
        until("its end", || gone(process).then_some(()));
    }
    until("an empty shared memory", || bench.left().is_empty().then_some(()));
}

/// Our own structure in one window of a million sub-steps, which lets nobody wait for it.
#[test]
fn a_long_window_does_not_outlive_a_killed_coupler() {
    let bench = Bench::new();
    let long = ["--set", "coupling.sub_steps=1000000", "--set", "coupling.prediction=false"];
    let run = bench.start_run("out", &[&COARSE, long.as_slice()].concat());
    let others = [Role::Fluid, Role::Structure].map(|role| run.participant(role));
    run.signal(Signal::KILL);
    let killed = Instant::now();
    for process in others {
        until("its end", || gone(process).then_some(()));
    }
    assert!(killed.elapsed() < Duration::from_secs(10), "{:?}", killed.elapsed());
    until("an empty shared memory", || bench.left().is_empty().then_some(()));
}

/// Who interrupts a run ends what a program of another make has started, too.
#[test]
fn an_interrupt_reaches_what_a_command_started() {
    let bench = Bench::new();
    let number = bench.path("number");
    let script = format!("sleep 300 & echo $! > {}; exec sleep 300", number.display());
    let setting = format!("structure.participant={{ command = [\"sh\", \"-c\", \"{script}\"] }}");
    let run = bench.start_run("out", &[&COARSE, ["--set", &setting].as_slice()].concat());
    let grandchild = until("the grandchild", || {
        Pid::from_raw(std::fs::read_to_string(&number).ok()?.trim().parse().ok()?)
    });
    run.signal(Signal::INT);
    assert_ne!(run.wait().status.code(), Some(0));
    until("its end", || gone(grandchild).then_some(()));
}

/// A program of another make is started by a process that becomes it when the coupler says so, after its
/// guard knows of it: of a coupler that is killed before, nothing is left.
#[test]
fn no_program_starts_that_the_guard_does_not_know_of() {
    let bench = Bench::new();
    let file = bench.path("number");
    let script = format!("echo $$ > {}; exec cat", file.display());
    let start = |name: &str, word: Option<&[u8]>| {
        let mut command = bench.command(&["become", "sh", "-c", &script]);
        let errors = std::fs::File::create(bench.path(name)).expect("a file");
        command.stdin(std::process::Stdio::piped()).stderr(errors);
        let mut child = command.spawn().expect("it starts");
        let mut told = child.stdin.take().expect("a pipe");
        std::io::Write::write_all(&mut told, word.unwrap_or_default()).expect("it reads");
        drop(told);
        let id = child.id();
        (
            id,
            child.wait().expect("a child of ours"),
            std::fs::read_to_string(bench.path(name)).expect("words"),
        )
    };
    let (_, status, errors) = start("killed", None);
    assert_eq!(status.code(), Some(1));
    assert!(errors.contains("the coupler ended before the start") && !file.exists(), "{errors}");
    // It is the same process, and reads nothing more of the pipe.
    let (id, status, errors) = start("told", Some(b"\nmore"));
    assert_eq!((status.code(), errors.as_str()), (Some(0), ""));
    assert_eq!(std::fs::read_to_string(&file).expect("its number").trim(), id.to_string());
    for milliseconds in (4..24).step_by(4) {
        let bench = Bench::new();
        let number = bench.path("number");
        let script = format!("echo $$ > {}; exec sleep 300", number.display());
        let setting = format!("structure.participant={{ command = [\"sh\", \"-c\", \"{script}\"] }}");
        let run = bench.start_run("out", &[&COARSE, ["--set", &setting].as_slice()].concat());
        sleep(Duration::from_millis(milliseconds));
        run.signal(Signal::KILL);
        drop(run);
        // What it left before there was a guard, the next run removes.
        bench.coarse_gate("next", &[]);
        until("an empty shared memory", || bench.left().is_empty().then_some(()));
        let left = std::fs::read_to_string(&number).ok().and_then(|text| text.trim().parse().ok());
        if let Some(process) = left.and_then(Pid::from_raw) {
            until("its end", || gone(process).then_some(()));
        }
    }
}

/// What happens after the last answer is part of the run.
#[test]
fn a_participant_that_ends_badly_after_its_last_answer_is_told() {
    let bench = Bench::new();
    let script = format!("{} mock spring-mass stiffness=400; exit 7", crate::support::MENISCUS);
    let case = bench.path("case.toml");
    let text = MANY_WINDOWS
        .replace(
            "\"MENISCUS\", \"mock\", \"spring-mass\", \"stiffness=400\"",
            &format!("\"sh\", \"-c\", \"{script}\""),
        )
        .replace("MENISCUS", crate::support::MENISCUS)
        .replace("end_time = 1.0", "end_time = 0.01");
    std::fs::write(&case, text).expect("a case");
    let ended = bench.start_run("out", &[&case.display().to_string(), "--no-report"]).wait();
    failed_in_order(&bench, "out", &ended, &["the structure failed after its last answer", "exit code 7"]);
}
