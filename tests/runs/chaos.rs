//! Runs that are long, and runs that are disturbed at random for long: named commands, not part of the usual
//! tests.
//!
//! ```sh
//! SOAK_WINDOWS=1000000 cargo test --release --test runs a_million_windows -- --ignored --nocapture
//! CHAOS_SECONDS=3600 CHAOS_SEED=1 cargo test --release --test runs chaos_leaves -- --ignored --nocapture
//! ```

use crate::restart::{Case, FLUID, Random, SCHEMES, STRUCTURE, assert_equal, set};
use crate::support::{Bench, Running, mock, until};
use crate::unit::spring_unit::case_text;
use coupler::status::Status;
use interfaces::Role;
use rustix::process::{Signal, kill_process};
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

fn number(variable: &str, usual: u64) -> u64 {
    std::env::var(variable).ok().and_then(|n| n.parse().ok()).unwrap_or(usual)
}

fn entries(folder: &Path) -> usize {
    fs::read_dir(folder).map_or(0, Iterator::count)
}

/// What a run holds while it goes on.
#[derive(Debug)]
struct Held {
    /// Largest memory so far (bytes): coupler, fluid, structure.
    memory: [u64; 3],
    /// Open files of the coupler.
    files: usize,
    /// Files in shared memory.
    shared: usize,
}

impl Held {
    fn of(bench: &Bench, status: &Status) -> Self {
        let of =
            |role: Role| status.participants.iter().find(|party| party.role == role).map(|p| p.memory_bytes);
        Self {
            memory: [status.memory_bytes, of(Role::Fluid).unwrap_or(0), of(Role::Structure).unwrap_or(0)],
            files: entries(Path::new(&format!("/proc/{}/fd", status.process))),
            shared: bench.left().len(),
        }
    }
}

/// Nothing grows with the number of windows but the tables.
#[test]
#[ignore = "minutes; see the head of this file"]
fn a_million_windows_hold_no_more_than_the_first() {
    let windows = number("SOAK_WINDOWS", 1_000_000);
    let bench = Bench::new();
    let size = 1.0 / windows as f64;
    let coupling = format!("[coupling]\nmax_window = {size:e}\nsub_steps = 1\nrelaxation = 0.5");
    let text = case_text(&mock(FLUID), &mock(STRUCTURE), 1.0, &coupling);
    fs::write(bench.path("case.toml"), text).expect("a case");
    let case = bench.path("case.toml").display().to_string();
    let words = [case.as_str(), "--no-report", "--quiet", "--set", "case.record_interval=1e-3"];
    let mut run = bench.start_run("out", &words);
    let wait = |run: &mut Running, windows: u64| loop {
        if let Some(status) = Status::read(&bench.path("out")).ok().filter(|status| status.windows >= windows)
        {
            return status;
        }
        assert!(!run.has_ended(), "{}", run.printed("err"));
        std::thread::sleep(Duration::from_millis(20));
    };
    let first = Held::of(&bench, &wait(&mut run, windows / 10));
    let last = Held::of(&bench, &wait(&mut run, windows / 10 * 9));
    println!("{windows} windows: after a tenth {first:?}, after nine {last:?}");
    let running = Instant::now();
    while !run.has_ended() {
        assert!(running.elapsed() < Duration::from_secs(3600), "it does not end");
        std::thread::sleep(Duration::from_millis(20));
    }
    let ended = run.wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    let summary = bench.outputs("out").summary();
    println!("{} windows in {:.1} s", summary.windows, summary.wall_seconds);
    assert!(summary.windows >= windows);
    for (first, last) in first.memory.iter().zip(last.memory) {
        assert!(last < first + (2 << 20), "memory grew from {first} to {last} bytes");
    }
    assert_eq!((first.files, first.shared), (last.files, last.shared));
}

/// Whoever is killed, stopped or told to end, and whenever: what ended is named, nothing is left, and what
/// goes on comes to the bits of the run that nobody disturbed.
#[test]
#[ignore = "as long as CHAOS_SECONDS says, an hour; see the head of this file"]
fn chaos_leaves_every_result_as_it_is() {
    let (seconds, seed) = (number("CHAOS_SECONDS", 3600), number("CHAOS_SEED", 1));
    let mut random = Random(seed);
    let case = Case::of_mocks("0.001");
    let wholes: Vec<_> = SCHEMES.iter().map(|(name, settings)| case.whole(name, &set(settings))).collect();
    let started = Instant::now();
    let (mut runs, mut blows) = (0, [0_u64; 4]);
    while started.elapsed() < Duration::from_secs(seconds) {
        let which = random.below(SCHEMES.len() as u64) as usize;
        let out = format!("chaos-{runs}");
        disturbed(&case, &out, &set(SCHEMES[which].1), &mut random, &mut blows);
        assert_equal(&case.bench.outputs(&out), &wholes[which]);
        fs::remove_dir_all(case.bench.path(&out)).expect("its folder");
        runs += 1;
    }
    let [killed, stopped, told, lost] = blows;
    println!(
        "seed {seed}: {runs} runs in {:.0} s: coupler killed {killed} times, told to end {told}, participants killed {lost}, stopped {stopped}",
        started.elapsed().as_secs_f64()
    );
}

/// A run that is disturbed some times, and goes on each time until it completes.
fn disturbed(case: &Case, out: &str, settings: &[&str], random: &mut Random, blows: &mut [u64; 4]) {
    let dir = case.bench.path(out).display().to_string();
    let first = ["run", &case.file, "--out", &dir, "--set", "checkpoints.every=0.003"];
    for part in 0..20 {
        let goes_on = !case.checkpoints(out).is_empty();
        let words = if goes_on { vec!["run", "--resume", &dir] } else { [&first, settings].concat() };
        let quiet = part >= 4;
        let name = format!("{out}-{part}");
        let mut run = case.bench.start(&name, &[&words[..], &["--no-report", "--quiet"]].concat());
        std::thread::sleep(Duration::from_millis(random.below(250)));
        let blow = random.below(4) as usize;
        let role = if random.below(2) == 0 { Role::Fluid } else { Role::Structure };
        if !quiet && !run.has_ended() {
            blows[blow] += 1;
            match blow {
                0 => run.signal(Signal::KILL),
                1 => {
                    let pause = Duration::from_millis(random.below(300));
                    if let Some(process) = run.participant_if_any(role)
                        && kill_process(process, Signal::STOP).is_ok()
                    {
                        std::thread::sleep(pause);
                        let _ = kill_process(process, Signal::CONT);
                    }
                }
                2 => run.signal(Signal::TERM),
                _ => {
                    let process = run.participant_if_any(role);
                    let _ = process.map(|process| kill_process(process, Signal::KILL));
                }
            }
        }
        let ended = run.wait();
        match (ended.status.code(), blow) {
            // What was left by one that was killed before its guard stood goes with the next of its domain.
            (Some(0), _) => {
                return until("an empty shared memory", || case.bench.left().is_empty().then_some(()));
            }
            (None, 0) | (Some(130), 2) => {}
            (Some(1), 3) => assert!(ended.errors.contains("signal 9"), "{}", ended.errors),
            (code, _) => panic!("{out}, part {part}, blow {blow}: exit code {code:?}: {}", ended.errors),
        }
    }
    panic!("{out} does not come to its end");
}
