//! Real processes over real shared memory: exchange without loss, and every way in which one of them can end.
//!
//! A process of a test is this executable again, told by an environment variable what to be. Each test has a
//! domain of shared memory of its own, which must be empty afterwards. Deadlines are a minute where a test
//! expects that something else ends the wait.

use crate::support::{Domain, Echo, HASH, exchange, expectations, load, long, window};
use interfaces::transport::Alive;
use interfaces::{
    Address, Deadlines, Direction, Guarded, Participant, ParticipantError, Readiness, RemoteParticipant,
    Result, Role, new_run, remove_stale, serve,
};
use rustix::process::{Pid, Signal, kill_process};
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

const TASK: &str = "MENISCUS_TRANSPORT_TEST_TASK";
/// What the coupler's process says when it is well under way.
const SOLVED: &str = "20 windows solved";

/// Not a test, but what the processes of the tests run.
#[test]
fn child() {
    let Ok(task) = std::env::var(TASK) else { return };
    let words: Vec<&str> = task.split_whitespace().collect();
    let [role, connect, points, misdeed, hash, dimension] = words[..] else { panic!("no task: {task}") };
    let address = Address::parse(connect, Role::Structure);
    let points = points.parse().unwrap();
    let ended = if role == "coupler" {
        coupler(&address, points)
    } else {
        let mut echo = Echo::new(points, misdeed);
        echo.description.dimension = dimension.parse().unwrap();
        serve(&mut echo, &address, hash, long(), &Arc::default(), Box::new(|| None))
            .map_err(|e| e.to_string())
    };
    if let Err(error) = &ended {
        eprintln!("{error}");
    }
    std::process::exit(i32::from(ended.is_err()));
}

/// A coupler that solves windows until it is killed, and says when it has solved some.
fn coupler(address: &Address, points: usize) -> Result<(), String> {
    let listening = RemoteParticipant::listen(address, expectations(), long(), &Arc::default()).unwrap();
    let mut structure = listening.wait_for_hello(Box::new(|| None)).map_err(|e| e.to_string())?;
    let mut inputs = structure.describe().fields(Direction::In, points);
    let mut outputs = structure.describe().fields(Direction::Out, points);
    structure.initialize(0.0, &inputs, &mut outputs).unwrap();
    for index in 0.. {
        load(&mut inputs, index);
        structure.start(&window(index), &inputs).map_err(|e| e.to_string())?;
        structure.finish(&mut outputs).map_err(|e| e.to_string())?;
        structure.accept(None).map_err(|e| e.to_string())?;
        if index == 20 {
            println!("{SOLVED}");
        }
    }
    unreachable!("windows are not exhausted")
}

fn spawn(task: &str) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args(["processes::child", "--exact", "--nocapture"])
        .env(TASK, task)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// A process of a test; killed with it.
#[derive(Clone)]
struct Process(Arc<Mutex<Child>>);

impl Process {
    fn alive(&self) -> Alive {
        let child = Arc::clone(&self.0);
        Box::new(move || child.lock().unwrap().try_wait().unwrap().map(|status| status.to_string()))
    }

    fn signal(&self, signal: Signal) {
        let pid = Pid::from_raw(self.0.lock().unwrap().id() as i32).unwrap();
        kill_process(pid, signal).unwrap();
    }

    /// Stops it, and returns when none of its threads runs any more.
    fn stop(&self) {
        self.signal(Signal::STOP);
        let id = self.0.lock().unwrap().id();
        let stopped = |task: &std::path::Path| {
            std::fs::read_to_string(task.join("status")).is_ok_and(|s| s.contains("State:\tT"))
        };
        let tasks = || std::fs::read_dir(format!("/proc/{id}/task")).unwrap().flatten();
        while !tasks().all(|task| stopped(&task.path())) {
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Waits, but not for ever, and returns what it said last.
    fn wait(&self) -> (ExitStatus, String) {
        let started = Instant::now();
        let mut child = self.0.lock().unwrap();
        loop {
            if let Some(status) = child.try_wait().unwrap() {
                let mut words = String::new();
                child.stderr.take().unwrap().read_to_string(&mut words).unwrap();
                return (status, words);
            }
            if started.elapsed() > WATCHDOG {
                child.kill().unwrap();
                panic!("the process did not end");
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

/// Far more than anything takes that is not stuck, and less than the deadlines of [`long`].
const WATCHDOG: Duration = Duration::from_secs(30);

fn connect(
    domain: &Domain,
    points: usize,
    misdeed: &str,
    deadlines: Deadlines,
) -> (Guarded<RemoteParticipant>, Process, Address) {
    let address = Address::new(new_run(), Role::Structure).in_domain(&domain.0);
    let listening = RemoteParticipant::listen(&address, expectations(), deadlines, &Arc::default()).unwrap();
    let task = format!("structure {} {points} {misdeed} {HASH} 2", address.connect());
    let process = Process(Arc::new(Mutex::new(spawn(&task))));
    let remote = listening.wait_for_hello(process.alive()).unwrap();
    (Guarded::new(remote), process, address)
}

fn told_once_within_the_watchdog(result: Result<()>, started: Instant) -> String {
    assert!(started.elapsed() < WATCHDOG, "it was not the event, but the deadline, that ended the wait");
    result.unwrap_err().to_string()
}

#[test]
fn arrays_of_any_length_arrive_whole() {
    let domain = Domain::new();
    for (points, windows) in [(1, 50), (100, 200), (10_000, 50), (100_000, 10)] {
        let (mut structure, process, _) = connect(&domain, points, "none", long());
        exchange(&mut structure, points, windows).unwrap();
        structure.terminate().unwrap();
        drop(structure);
        let (status, words) = process.wait();
        assert!(status.success(), "{words}");
        assert_eq!(domain.left(), Vec::<String>::new());
    }
}

#[test]
fn mismatches_are_named_on_both_sides() {
    let domain = Domain::new();
    let address = Address::new(new_run(), Role::Structure).in_domain(&domain.0);
    let listening = RemoteParticipant::listen(&address, expectations(), long(), &Arc::default()).unwrap();
    let task = format!("structure {} 3 none other 3", address.connect());
    let process = Process(Arc::new(Mutex::new(spawn(&task))));
    let Err(ParticipantError::Mismatch(lines)) = listening.wait_for_hello(process.alive()) else {
        panic!("the handshake passed");
    };
    let expected = [
        "case hash: the coupler has 5d41402abc4b2a76, the participant has other",
        "dimension: the coupler has 2, the participant has 3",
    ];
    assert_eq!(lines, expected);
    let (status, words) = process.wait();
    assert_eq!(status.code(), Some(1));
    for line in expected {
        assert!(words.contains(line), "{words}");
    }
}

#[test]
fn a_participant_killed_while_it_solves_is_missed_at_once() {
    let domain = Domain::new();
    let (mut structure, process, _) = connect(&domain, 1000, "hang@2", long());
    let killer = {
        let process = process.clone();
        std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(500));
            process.signal(Signal::KILL);
        })
    };
    let started = Instant::now();
    let message = told_once_within_the_watchdog(exchange(&mut structure, 1000, 10), started);
    killer.join().unwrap();
    assert!(message.starts_with("its process died while solving window 2, iteration 0 ("), "{message}");
    assert!(message.ends_with("(signal: 9 (SIGKILL))"), "{message}");
    structure.terminate().unwrap();
    process.wait();
    drop(structure);
}

#[test]
fn a_participant_that_exits_is_named_with_its_status() {
    let domain = Domain::new();
    let (mut structure, process, _) = connect(&domain, 5, "exit@1", long());
    let message = told_once_within_the_watchdog(exchange(&mut structure, 5, 10), Instant::now());
    assert!(message.starts_with("its process died while solving window 1, iteration 0 ("), "{message}");
    process.wait();
}

#[test]
fn a_participant_that_never_connects_is_named_with_its_status() {
    let domain = Domain::new();
    let address = Address::new(new_run(), Role::Structure).in_domain(&domain.0);
    let listening = RemoteParticipant::listen(&address, expectations(), long(), &Arc::default()).unwrap();
    let child = Process(Arc::new(Mutex::new(Command::new("false").stderr(Stdio::piped()).spawn().unwrap())));
    let error = listening.wait_for_hello(child.alive()).err().unwrap();
    assert_eq!(error.to_string(), "its process died while connecting (exit status: 1)");
}

#[test]
fn a_stopped_participant_is_given_up_at_its_deadline() {
    let domain = Domain::new();
    let deadlines = Deadlines { answer: Duration::from_secs(1), ..long() };
    let (mut structure, process, address) = connect(&domain, 100, "none", deadlines);
    let mut inputs = structure.describe().fields(Direction::In, 100);
    let mut outputs = structure.describe().fields(Direction::Out, 100);
    load(&mut inputs, 0);
    structure.initialize(2.0, &inputs, &mut outputs).unwrap();
    process.stop();
    structure.start(&window(0), &inputs).unwrap();
    let error = structure.finish(&mut outputs).unwrap_err();
    let during = "while solving window 0, iteration 0".to_owned();
    assert_eq!(error, ParticipantError::TimedOut { during, seconds: 1.0 });
    structure.terminate().unwrap();
    drop(structure);
    process.signal(Signal::KILL);
    process.wait();
    remove_stale(&address).unwrap();
}

#[test]
fn a_participant_whose_coupler_is_killed_ends_and_leaves_nothing() {
    let domain = Domain::new();
    let address = Address::new(new_run(), Role::Structure).in_domain(&domain.0);
    let structure =
        Process(Arc::new(Mutex::new(spawn(&format!("structure {} 100 none {HASH} 2", address.connect())))));
    let coupler =
        Process(Arc::new(Mutex::new(spawn(&format!("coupler {} 100 none {HASH} 2", address.connect())))));
    let stdout = coupler.0.lock().unwrap().stdout.take().unwrap();
    let mut lines = BufReader::new(stdout).lines();
    assert!(lines.any(|line| line.unwrap().contains(SOLVED)), "the coupler solved no windows");
    coupler.signal(Signal::KILL);
    coupler.wait();
    let (status, words) = structure.wait();
    assert_eq!(status.code(), Some(1), "{words}");
    assert!(
        words.contains("lost the coupler: its process died while waiting for a request after "),
        "{words}"
    );
    assert!(words.contains("accepted windows (its node in shared memory is dead)"), "{words}");
}

#[test]
fn what_a_run_killed_as_a_whole_left_is_removed_by_the_next() {
    let domain = Domain::new();
    let address = Address::new(new_run(), Role::Structure).in_domain(&domain.0);
    let both: Vec<Process> = ["coupler", "structure"]
        .map(|role| {
            Process(Arc::new(Mutex::new(spawn(&format!("{role} {} 100 none {HASH} 2", address.connect())))))
        })
        .into();
    let stdout = both[0].0.lock().unwrap().stdout.take().unwrap();
    assert!(BufReader::new(stdout).lines().any(|line| line.unwrap().contains(SOLVED)));
    // Stopped first, so that neither notices the other's death.
    both.iter().for_each(Process::stop);
    both.iter().for_each(|process| process.signal(Signal::KILL));
    both.iter().for_each(|process| drop(process.wait()));
    assert!(!domain.left().is_empty(), "nothing was left, so that nothing is shown");
    let (mut structure, process, _) = connect(&domain, 3, "none", long());
    exchange(&mut structure, 3, 2).unwrap();
    structure.terminate().unwrap();
    drop(structure);
    process.wait();
}

#[test]
fn failures_panics_and_fields_that_are_not_finite_arrive_in_words() {
    let domain = Domain::new();
    for (misdeed, expected) in [
        ("fail@3", "particle 3 is inverted at t = 0.5 s"),
        ("panic@3", "it panicked: index 7 out of bounds"),
        ("nan@3", "field `velocity` is not finite: component 1 at point 2 is NaN"),
        ("accept@3", "cannot write snapshot Some(3)"),
    ] {
        let (mut structure, process, _) = connect(&domain, 4, misdeed, long());
        let message = told_once_within_the_watchdog(exchange(&mut structure, 4, 10), Instant::now());
        assert_eq!(message, expected);
        structure.terminate().unwrap();
        drop(structure);
        let (status, words) = process.wait();
        assert_eq!(status.code(), Some(1));
        assert!(words.contains(expected), "{words}");
        assert_eq!(domain.left(), Vec::<String>::new(), "after {misdeed}");
    }
}

#[test]
fn a_run_is_not_disturbed_by_one_that_dies_beside_it() {
    let domain = Domain::new();
    std::thread::scope(|scope| {
        let domain = &domain;
        let undisturbed = scope.spawn(move || {
            let (mut structure, process, _) = connect(domain, 500, "none", long());
            exchange(&mut structure, 500, 2000).unwrap();
            structure.terminate().unwrap();
            drop(structure);
            assert!(process.wait().0.success());
        });
        for _ in 0..3 {
            let (mut structure, process, _) = connect(domain, 700, "hang@5", long());
            let killer = scope.spawn({
                let process = process.clone();
                move || {
                    std::thread::sleep(Duration::from_millis(100));
                    process.signal(Signal::KILL);
                }
            });
            exchange(&mut structure, 700, 10).unwrap_err();
            killer.join().unwrap();
            process.wait();
        }
        undisturbed.join().unwrap();
    });
}

#[test]
fn a_wait_ends_when_the_run_is_told_to_stop() {
    let domain = Domain::new();
    let address = Address::new(new_run(), Role::Structure).in_domain(&domain.0);
    let stop = Arc::new(AtomicBool::new(false));
    let listening = RemoteParticipant::listen(&address, expectations(), long(), &stop).unwrap();
    let setter = std::thread::spawn({
        let stop = Arc::clone(&stop);
        move || {
            std::thread::sleep(Duration::from_millis(200));
            stop.store(true, std::sync::atomic::Ordering::Relaxed);
        }
    });
    let error = listening.wait_for_hello(Box::new(|| None)).err().unwrap();
    setter.join().unwrap();
    assert_eq!(error.to_string(), "the run was interrupted while connecting");
}

#[test]
fn a_participant_told_to_end_while_it_solves_ends_in_order() {
    let domain = Domain::new();
    let (mut structure, process, _) = connect(&domain, 10, "none", long());
    let mut inputs = structure.describe().fields(Direction::In, 10);
    let mut outputs = structure.describe().fields(Direction::Out, 10);
    load(&mut inputs, 0);
    structure.initialize(2.0, &inputs, &mut outputs).unwrap();
    structure.start(&window(0), &inputs).unwrap();
    structure.terminate().unwrap();
    drop(structure);
    let (status, words) = process.wait();
    assert!(status.success(), "{words}");
}

#[test]
fn a_participant_whose_coupler_leaves_early_says_so() {
    let domain = Domain::new();
    let (mut structure, process, _) = connect(&domain, 10, "none", long());
    exchange(&mut structure, 10, 3).unwrap();
    drop(structure);
    let (status, words) = process.wait();
    assert_eq!(status.code(), Some(1));
    assert!(words.contains("the coupler ended the run early"), "{words}");
}

#[test]
fn a_state_is_saved_and_restored() {
    let domain = Domain::new();
    let (mut structure, process, _) = connect(&domain, 10, "none", long());
    exchange(&mut structure, 10, 3).unwrap();
    let mut inputs = structure.describe().fields(Direction::In, 10);
    let mut outputs = structure.describe().fields(Direction::Out, 10);
    let (mut state, mut given) = (Vec::new(), outputs.clone());
    for index in 3..6 {
        load(&mut inputs, index);
        structure.start(&window(index), &inputs).unwrap();
        structure.finish(&mut outputs).unwrap();
        structure.accept(None).unwrap();
        if index == 3 {
            (state, given) = (structure.save().unwrap(), outputs.clone());
        }
    }
    let ahead = structure.save().unwrap();
    let ready = structure.restore(&state, &mut outputs).unwrap();
    assert_eq!(ready, Readiness { window_limit: f64::INFINITY, scalars: vec![3.0] });
    for name in ["position", "velocity"] {
        assert_eq!(outputs.get(name), given.get(name), "as they were when the state was saved");
    }
    assert_eq!(structure.save().unwrap(), state);
    structure.start(&window(4), &inputs).unwrap();
    structure.finish(&mut outputs).unwrap();
    structure.restore(&ahead, &mut outputs).unwrap();
    structure.start(&window(6), &inputs).unwrap();
    structure.finish(&mut outputs).unwrap();
    structure.terminate().unwrap();
    drop(structure);
    let (status, words) = process.wait();
    assert!(status.success(), "{words}");
}
