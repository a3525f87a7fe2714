//! Checkpoints: a run that was killed, interrupted or has ended goes on to the bit.
//!
//! `cargo test --release --test runs restart -- --ignored` kills a hundred times instead of a few.

use crate::support::{Bench, COARSE, Ended, Outputs, mock, until};
use crate::unit::spring_unit::{Spring, case_text};
use output::summary::Status;
use rustix::process::{Resource, Rlimit, Signal, prlimit};
use std::fs;
use std::path::PathBuf;
use std::time::Duration;

/// Numbers that follow from a seed alone.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) % limit
    }
}

/// A mock that takes `pause` (s) over every solution.
fn slow(words: &str, pause: &str) -> String {
    mock(&format!("{words} --fault slow:{pause}@*/start"))
}

pub const FLUID: &str = "added-mass-column wall=moving mass=0.1 gravity=9.81";
pub const STRUCTURE: &str = "spring-mass points=5 stiffness=400 displacement=0,0.01";

/// Schemes with what each remembers from window to window.
pub const SCHEMES: [(&str, &[&str]); 6] = [
    ("explicit", &["coupling.relaxation=0.5"]),
    ("parallel", &["coupling.scheme=parallel-explicit", "coupling.relaxation=0.1"]),
    ("ils", &["coupling.scheme=serial-implicit"]),
    ("imvj", &["coupling.scheme=serial-implicit", "coupling.acceleration.method=iqn-imvj"]),
    ("aitken", &["coupling.scheme=serial-implicit", "coupling.acceleration.method=aitken"]),
    ("parallel-ils", &["coupling.scheme=parallel-implicit"]),
];

/// A bench with a case of mocks, or of these participants: 50 windows, of which every third has a checkpoint
/// where a test kills.
pub struct Case {
    pub bench: Bench,
    pub file: String,
}

impl Case {
    fn of(fluid: &str, structure: &str) -> Self {
        let bench = Bench::new();
        let text = case_text(fluid, structure, 0.05, "[coupling]\nmax_window = 1e-3\nsub_steps = 4");
        // The end of a run is met to the bit, and of a longer one this is an output only if it is a multiple.
        let text = text.replace(&format!("output_interval = {}", 0.1 * 0.05), "output_interval = 0.005");
        let file = bench.path("case.toml");
        fs::write(&file, text).expect("a case");
        Self { file: file.display().to_string(), bench }
    }

    /// Of mocks that take `pause` (s) over every solution.
    pub fn of_mocks(pause: &str) -> Self {
        Self::of(&slow(FLUID, pause), &slow(STRUCTURE, pause))
    }

    /// The undisturbed run, without checkpoints.
    pub fn whole(&self, out: &str, settings: &[&str]) -> Outputs {
        self.completed(out, &[&[self.file.as_str()], settings].concat())
    }

    fn completed(&self, out: &str, words: &[&str]) -> Outputs {
        let ended = self.bench.start_run(out, &[words, &["--no-report", "--quiet"]].concat()).wait();
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        self.bench.outputs(out)
    }

    fn resume(&self, out: &str, words: &[&str]) -> Ended {
        let dir = self.bench.path(out).display().to_string();
        self.bench.call(&[&["run", "--resume", &dir, "--no-report", "--quiet"], words].concat())
    }

    pub fn checkpoints(&self, out: &str) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.bench.path(out).join("checkpoints")).into_iter().flatten().flatten();
        let mut paths: Vec<_> = entries.map(|entry| entry.path()).collect();
        paths.retain(|path| path.extension().is_some_and(|ending| ending == "checkpoint"));
        paths.sort();
        paths
    }

    /// A run that is killed so often, each time within so many milliseconds after it has written a
    /// checkpoint, and goes on; in the end it is not disturbed.
    fn killed(
        &self,
        out: &str,
        settings: &[&str],
        (kills, within): (u64, u64),
        random: &mut Random,
    ) -> Outputs {
        let dir = self.bench.path(out).display().to_string();
        let first = ["run", &self.file, "--out", &dir, "--set", "checkpoints.every=0.003"];
        for kill in 0..kills {
            let before = self.checkpoints(out);
            let words = match before.is_empty() {
                true => [&first, settings].concat(),
                false => vec!["run", "--resume", &dir],
            };
            let name = format!("{out}-{kill}");
            let mut run = self.bench.start(&name, &[&words[..], &["--no-report", "--quiet"]].concat());
            until("a checkpoint", || (run.has_ended() || self.checkpoints(out) != before).then_some(()));
            std::thread::sleep(Duration::from_millis(random.below(within)));
            if !run.has_ended() {
                run.signal(Signal::KILL);
            }
            let ended = run.wait();
            if ended.status.success() {
                break;
            }
            assert_eq!(ended.status.code(), None, "{}", ended.errors);
        }
        let ended = self.resume(out, &[]);
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        until("an empty shared memory", || self.bench.left().is_empty().then_some(()));
        self.bench.outputs(out)
    }
}

/// Everything of a run that must not depend on how often it was begun: tables but for columns of seconds,
/// collections and snapshots, byte for byte.
fn result(outputs: &Outputs) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    for name in ["windows.csv", "probes.csv", "probes_intervals.csv", "iterations.csv"] {
        let Ok(text) = fs::read_to_string(outputs.0.join(name)) else { continue };
        let header: Vec<&str> = text.lines().next().expect("a header").split(',').collect();
        let row = |line: &str| {
            let cells = line.split(',').zip(&header).filter(|(_, column)| !column.ends_with("_seconds"));
            cells.map(|(cell, _)| cell.to_owned() + ",").collect::<String>() + "\n"
        };
        found.push((name.to_owned(), text.lines().map(row).collect::<String>().into_bytes()));
    }
    for name in ["fluid", "structure", "walls"] {
        let Ok(collection) = fs::read(outputs.0.join(format!("{name}.pvd"))) else { continue };
        found.push((format!("{name}.pvd"), collection));
        for entry in output::pvd::read(&outputs.0.join(format!("{name}.pvd"))).expect("a series") {
            let file = outputs.0.join(&entry.file);
            found.push((
                file.file_name().unwrap().display().to_string(),
                fs::read(&file).expect("a snapshot"),
            ));
        }
    }
    found
}

/// Names where two results differ.
pub fn assert_equal(one: &Outputs, other: &Outputs) {
    let (one, other) = (result(one), result(other));
    let names = |result: &[(String, Vec<u8>)]| result.iter().map(|r| r.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&one), names(&other));
    for ((name, one), (_, other)) in one.iter().zip(&other) {
        let differs = (0..one.len().max(other.len())).find(|&byte| one.get(byte) != other.get(byte));
        assert_eq!(differs, None, "{name} differs first at this byte");
    }
}

/// `--set` before each.
pub fn set<'a>(settings: &[&'a str]) -> Vec<&'a str> {
    settings.iter().flat_map(|setting| ["--set", setting]).collect()
}

#[test]
fn a_killed_run_goes_on_to_the_bit_under_every_scheme() {
    let mut random = Random(1);
    let case = Case::of_mocks("0.0005");
    for (name, settings) in SCHEMES {
        let settings = set(settings);
        let whole = case.whole(&format!("{name}-whole"), &settings);
        let killed = case.killed(name, &settings, (1, 40), &mut random);
        assert_equal(&killed, &whole);
        assert!(killed.summary().seams.len() <= 1, "{name}");
    }
}

#[test]
fn a_killed_run_with_a_unit_goes_on_to_the_bit() {
    let mut random = Random(2);
    let folder = tempfile::tempdir().expect("a folder");
    let unit = Spring::of(3).build(folder.path());
    let structure = Spring::of(3).participant(&unit, "stiffness = 400");
    let case = Case::of(&slow(FLUID, "0.002"), &structure);
    let settings = set(&["coupling.scheme=serial-implicit"]);
    let whole = case.whole("whole", &settings);
    assert_equal(&case.killed("killed", &settings, (1, 60), &mut random), &whole);
}

/// Both of our solvers: on from a checkpoint in processes, in this process, with other threads, and longer.
#[test]
fn our_solvers_go_on_to_the_bit_wherever_they_are() {
    let case = Case::of_mocks("0");
    let words = [&COARSE[..5], &["--set", "case.output_interval=2.5e-3"]].concat();
    let whole = case.completed("whole", &[&words[..], &["--end-time", "0.02"]].concat());
    let short = ["--end-time", "0.01", "--checkpoint-every", "0.004"];
    case.completed("one", &[&words[..], &short].concat());
    case.completed("other", &[&words[..], &short].concat());
    for (out, how) in [("one", &["--set", "case.threads=1"][..]), ("other", &["--in-process"])] {
        let ended = case.resume(out, &[&["--end-time", "0.02"], how].concat());
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        assert_equal(&case.bench.outputs(out), &whole);
        let summary = case.bench.outputs(out).summary();
        assert_eq!((summary.seams.len(), summary.windows), (1, whole.summary().windows));
        assert!(summary.seams[0].changes.contains(&"case.end_time = 0.02 (was 0.01)".to_owned()));
        assert_eq!(summary.probes, whole.summary().probes, "extremes over all windows");
        assert_eq!(summary.balances, whole.summary().balances);
    }
    let ended = case.resume("one", &[]);
    assert_eq!(ended.status.code(), Some(0));
    assert!(ended.text.contains("nothing to do: the run in"), "{}", ended.text);
}

#[test]
fn what_a_run_that_goes_on_may_not_change_is_told_at_once() {
    let case = Case::of_mocks("0");
    let words = [case.file.as_str(), "--checkpoint-every", "0.004", "--end-time", "0.01"];
    case.completed("out", &words);
    let before = result(&case.bench.outputs("out"));
    let wrong = set(&["coupling.relaxation=0.5", "fluid.density=900", "coupling.deadline=30"]);
    let ended = case.resume("out", &[&["--end-time", "0.02"], &wrong[..]].concat());
    assert_eq!(ended.status.code(), Some(2));
    for told in [
        "  coupling.relaxation = 0.5 (was 1.0)\n  fluid.density = 900.0 (was 1000.0)\n",
        "start another run with --branch",
    ] {
        assert!(ended.errors.contains(told), "{}", ended.errors);
    }
    assert!(!ended.errors.contains("deadline"), "{}", ended.errors);
    assert!(result(&case.bench.outputs("out")) == before, "nothing was touched");

    let dir = case.bench.path("out").display().to_string();
    let branch = case.completed("branch", &[&["--branch", &dir, "--end-time", "0.02"], &wrong[..]].concat());
    let seams = branch.summary().seams;
    assert_eq!((seams.len(), seams[0].windows), (1, 10));
    assert!(seams[0].branch_of.is_some() && seams[0].changes.len() == 4, "{seams:?}");
    let (rows, of_run) = (branch.table("windows.csv"), case.bench.outputs("out").table("windows.csv"));
    assert_eq!((rows.rows(), of_run.rows()), (20, 10));
    assert_eq!(rows.get("time").unwrap()[..10], of_run.get("time").unwrap()[..]);
    assert!(result(&case.bench.outputs("out")) == before, "the run is as it was");
    let probe = "probe=[{ name = \"tip\", on = \"structure\", quantity = \"position\", at = [0.0, 0.0] }]";
    let words = ["run", "--branch", &dir, "--out", &dir, "--end-time", "0.02", "--set", probe];
    let ended = case.bench.call(&words);
    assert_eq!(ended.status.code(), Some(2));
    assert!(ended.errors.contains("other particles, probes or scheme"), "{}", ended.errors);
    let ended = case.bench.call(&words[..7]);
    assert!(ended.errors.contains("give another folder with --out"), "{}", ended.errors);
    assert!(result(&case.bench.outputs("out")) == before, "nothing was touched");
}

/// Cut, flipped, foreign, of another version, none; and tables that do not reach so far.
#[test]
fn a_damaged_checkpoint_is_named_and_the_one_before_it_taken() {
    let case = Case::of_mocks("0");
    let words = [case.file.as_str(), "--checkpoint-every", "0.004", "--end-time", "0.02"];
    let whole = case.whole("whole", &["--end-time", "0.03"]);
    type Damage = fn(&mut Vec<u8>);
    let damages: [(&str, Damage); 5] = [
        ("are left", |bytes| bytes.truncate(bytes.len() / 2)),
        ("checksum", |bytes| {
            let middle = bytes.len() / 2;
            bytes[middle] ^= 4;
        }),
        ("is no checkpoint", |bytes| bytes[..4].copy_from_slice(b"PK34")),
        ("version 9, and 1 is read", |bytes| bytes[7] = b'9'),
        ("cut off", Vec::clear),
    ];
    for (index, (told, damage)) in damages.into_iter().enumerate() {
        let out = format!("out-{index}");
        case.completed(&out, &words);
        let newest = case.checkpoints(&out).pop().expect("two checkpoints");
        let mut bytes = fs::read(&newest).expect("a checkpoint");
        damage(&mut bytes);
        fs::write(&newest, bytes).expect("a damaged one");
        let ended = case.resume(&out, &["--end-time", "0.03"]);
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        for told in [told, &newest.display().to_string(), "the checkpoint before it is taken"] {
            assert!(ended.errors.contains(told), "`{told}` is not in: {}", ended.errors);
        }
        assert_equal(&case.bench.outputs(&out), &whole);
    }
    case.completed("short", &words);
    let table = case.bench.path("short").join("windows.csv");
    let text = fs::read_to_string(&table).expect("a table");
    let kept = text.lines().take(19).map(|line| line.to_owned() + "\n").collect::<String>();
    fs::write(&table, kept).expect("a shorter table");
    let ended = case.resume("short", &["--end-time", "0.03"]);
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    assert!(ended.errors.contains("windows.csv has no row that ends at byte"), "{}", ended.errors);
    assert_equal(&case.bench.outputs("short"), &whole);
    for path in case.checkpoints("short") {
        fs::write(path, "nothing").expect("a damaged one");
    }
    let ended = case.resume("short", &["--end-time", "0.04"]);
    assert_eq!(ended.status.code(), Some(1));
    assert!(ended.errors.contains("failed to find a checkpoint in"), "{}", ended.errors);
    let ended = case.resume("nowhere", &[]);
    assert_eq!(ended.status.code(), Some(1));
    assert!(ended.errors.contains("failed to find a run in"), "{}", ended.errors);
}

/// A queue's warning leaves a checkpoint and lets the run go on; what ends it leaves one, too, also where it
/// goes to all processes.
#[test]
fn signals_leave_a_checkpoint() {
    let case = Case::of_mocks("0.001");
    let whole = case.whole("whole", &[]);
    let dir = case.bench.path("out").display().to_string();
    let mut words = vec!["run", &case.file, "--out", &dir, "--no-report", "--quiet"];
    for (name, signal) in [("first", Signal::TERM), ("second", Signal::INT)] {
        let run = case.bench.start(name, &words);
        let participants =
            [interfaces::Role::Fluid, interfaces::Role::Structure].map(|role| run.participant(role));
        let rows =
            || output::table::read(&case.bench.path("out").join("windows.csv")).map_or(0, |t| t.rows());
        until("windows", || (rows() >= 16).then_some(()));
        let before = case.checkpoints("out");
        run.signal(Signal::USR1);
        until("a checkpoint", || (case.checkpoints("out") != before).then_some(()));
        for participant in participants.into_iter().filter(|_| signal == Signal::TERM) {
            rustix::process::kill_process(participant, signal).expect("it runs");
        }
        run.signal(signal);
        let ended = run.wait();
        assert_eq!(ended.status.code(), Some(130), "{}", ended.errors);
        let summary = case.bench.outputs("out").summary();
        assert_eq!(summary.status, Status::Interrupted);
        let newest = case.checkpoints("out").pop().expect("a checkpoint");
        assert!(newest.ends_with(format!("{:012}.checkpoint", summary.windows)), "{newest:?}");
        words = vec!["run", "--resume", &dir, "--no-report", "--quiet"];
    }
    let ended = case.resume("out", &[]);
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    assert_equal(&case.bench.outputs("out"), &whole);
    assert_eq!(case.bench.outputs("out").summary().seams.len(), 2);
}

/// Who cannot be saved is named at the start where checkpoints are asked for, and the run is what it was.
#[test]
fn who_cannot_be_saved_is_named_and_the_run_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let spring = Spring { keeps_state: false, ..Spring::of(3) };
    let unit = spring.build(folder.path());
    let structure = spring.participant(&unit, "stiffness = 400");
    let case = Case::of(&slow(FLUID, "0"), &structure);
    let settings = set(&["coupling.scheme=parallel-explicit", "coupling.relaxation=0.1"]);
    let dir = case.bench.path("out").display().to_string();
    let words = ["run", &case.file, "--out", &dir, "--checkpoint-every", "0.01", "--no-report", "--quiet"];
    let ended = case.bench.call(&[&words[..], &settings].concat());
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    assert!(ended.errors.contains("there will be no checkpoints: the structure, "), "{}", ended.errors);
    assert!(case.bench.outputs("out").summary().notes.iter().any(|note| note.contains("cannot be saved")));
    assert!(case.checkpoints("out").is_empty());
    let ended = case.resume("out", &["--end-time", "0.2"]);
    assert!(ended.errors.contains("failed to find a checkpoint"), "{}", ended.errors);
}

/// `RESTART_KILLS` kills, or a hundred, of each scheme, a unit and our own solvers in turn.
#[test]
#[ignore = "some minutes"]
fn a_hundred_kills() {
    let kills: u64 = std::env::var("RESTART_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(100);
    let folder = tempfile::tempdir().expect("a folder");
    let unit = Spring::of(3).build(folder.path());
    let structure = Spring::of(3).participant(&unit, "stiffness = 400");
    let (mocks, units) = (Case::of_mocks("0.001"), Case::of(&slow(FLUID, "0.002"), &structure));
    let mut gate = Case::of_mocks("0.001");
    gate.file = COARSE[0].to_owned();
    let mut of_gate = vec!["case.output_interval=2.5e-3"];
    of_gate.extend([COARSE[2], COARSE[4], COARSE[6]]);
    let mut column = Case::of_mocks("0.001");
    "cases/hydrostatic_column_soft".clone_into(&mut column.file);
    let of_column = ["case.particle_spacing=6.666666666666667e-3", "case.end_time=0.03"];
    let mut variants: Vec<(&str, &Case, Vec<&str>)> =
        SCHEMES.iter().map(|(name, settings)| (*name, &mocks, set(settings))).collect();
    variants.push(("unit", &units, set(&["coupling.scheme=serial-implicit"])));
    variants.push(("gate", &gate, set(&of_gate)));
    variants.push(("column", &column, set(&of_column)));
    let python = crate::python::participants();
    if let Some([structure, fluid]) = &python {
        let of_python = [&of_gate[..], &[structure.as_str(), fluid.as_str()]].concat();
        variants.push(("python", &gate, set(&of_python)));
    }
    let (mut random, mut done) = (Random(3), 0);
    let wholes: Vec<_> = variants
        .iter()
        .map(|(name, case, settings)| case.whole(&format!("{name}-whole"), settings))
        .collect();
    while done < kills {
        for ((name, case, settings), whole) in variants.iter().zip(&wholes) {
            let out = format!("{name}-{done}");
            let killed = case.killed(&out, settings, (3, 100), &mut random);
            assert_equal(&killed, whole);
            let seams = killed.summary().seams.len() as u64;
            done += seams;
            println!("{name}: killed {seams} times, {done} in all");
            fs::remove_dir_all(&killed.0).expect("its folder");
        }
    }
}

/// The system ends the coupler (SIGXFSZ) at this very byte of the second checkpoint, or of a table before it:
/// the first is whole, and the run goes on from it to the bit.
#[test]
fn a_death_at_a_byte_of_a_checkpoint_costs_that_one_alone() {
    let mut case = Case::of_mocks("0");
    COARSE[0].clone_into(&mut case.file);
    let settings = set(&[COARSE[2], COARSE[4], COARSE[6], "case.output_interval=2.5e-3"]);
    let whole = case.whole("whole", &settings);
    for share in [0.3, 0.6, 0.99] {
        let out = format!("cut-{share}");
        let dir = case.bench.path(&out).display().to_string();
        let words = ["run", &case.file, "--out", &dir, "--checkpoint-every", "0.008", "--no-report"];
        let run = case.bench.start(&format!("{out}.printed"), &[&words[..], &settings].concat());
        let first = until("a checkpoint", || case.checkpoints(&out).first().cloned());
        let bytes = (share * fs::metadata(&first).expect("its size").len() as f64) as u64;
        let limit = Rlimit { current: Some(bytes), maximum: None };
        prlimit(Some(run.pid()), Resource::Fsize, limit).expect("the run lives");
        let ended = run.wait();
        assert_eq!(ended.status.code(), None, "{}", ended.errors);
        assert!(first.is_file() && case.checkpoints(&out).len() == 1, "the first one alone is there");
        let partial = fs::read_dir(first.parent().expect("a folder")).expect("it is there").flatten();
        let mut partial = partial.filter(|file| file.file_name().to_string_lossy().ends_with(".partial"));
        assert_eq!(
            partial.next().expect("what there is of the second").metadata().expect("its size").len(),
            bytes
        );
        let ended = case.resume(&out, &[]);
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        assert_equal(&case.bench.outputs(&out), &whole);
    }
}

/// While a run lives nobody goes on with it or starts another in its folder, and nothing of it is touched.
#[test]
fn a_living_run_keeps_its_folder() {
    let case = Case::of_mocks("0.02");
    let words = [case.file.as_str(), "--set", "checkpoints.every=0.003", "--no-report"];
    let running = case.bench.start_run("out", &words);
    until("a checkpoint", || (!case.checkpoints("out").is_empty()).then_some(()));
    let out = case.bench.path("out").display().to_string();
    let again = case.bench.call(&["run", &case.file, "--out", &out, "--no-report"]);
    for refused in [case.resume("out", &[]), again] {
        assert_eq!(refused.status.code(), Some(1), "{}", refused.text);
        assert!(refused.errors.contains("another run writes to it"), "{}", refused.errors);
    }
    let ended = running.wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    assert_eq!(case.bench.outputs("out").summary().status, Status::Completed);
}
