//! Functional mock-up units in a coupling of processes: the exported structure, and one of another hand that
//! may misbehave.

#[path = "../../coupler/fmu/tests/spring_unit/mod.rs"]
pub mod spring_unit;

use crate::support::{Bench, COARSE, MENISCUS, Outputs};
use output::summary::Status;
use spring_unit::{Spring, case_text};
use std::fs;
use std::time::{Duration, Instant};

/// `meniscus export-fmu <words> -o <bench>/<name>`.
fn export(bench: &Bench, name: &str, words: &[&str]) -> String {
    let unit = bench.path(name).display().to_string();
    let ended = bench.call(&[&["export-fmu"], words, &["-o", &unit]].concat());
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    unit
}

/// Tables and the fluid's snapshots, without what the two cannot share: the columns of one alone, and the
/// structure's snapshots, whose particles are all with our solver and those of the interface with a unit.
fn shared(one: &Outputs, other: &Outputs) -> usize {
    let (one, other) = (one.result(), other.result());
    let mut compared = 0;
    for (name, values) in one.iter().filter(|(name, _)| !name.starts_with("structure_")) {
        let Some((_, others)) = other.iter().find(|(o, _)| o == name) else {
            assert!(name.ends_with("end_requested"), "{name} is of one run alone");
            continue;
        };
        assert!(values == others, "{name} differs");
        compared += 1;
    }
    compared
}

#[test]
fn the_gate_with_its_structure_as_a_unit_is_the_gate_to_the_bit() {
    let bench = Bench::new();
    let unit = export(&bench, "gate.fmu", &COARSE[..7]);
    let setting = format!("structure.participant.fmu={unit}");
    let with_unit = bench.coarse_gate("unit", &["--set", &setting]);
    let native = bench.coarse_gate("native", &[]);
    let compared = shared(&with_unit, &native);
    // Windows' and probes' columns, and the fluid's snapshots.
    assert!(compared > 50, "{compared}");
    let (one, other) = (with_unit.summary(), native.summary());
    assert_eq!((one.windows, one.sub_steps), (other.windows, other.sub_steps));
    // The unit's points are drawn, and what was unpacked is gone.
    assert!(!with_unit.snapshots().is_empty() && with_unit.0.join("structure.pvd").exists());
    assert!(!with_unit.0.join("structure_fmu").exists());

    // Iterated, each window solved again and again from the unit's kept state.
    let iterated = ["--set", "coupling.scheme=serial-implicit", "--set", "case.end_time=0.005"];
    let native = bench.coarse_gate("native-implicit", &iterated);
    let with_unit = bench.coarse_gate("unit-implicit", &[&iterated, ["--set", &setting].as_slice()].concat());
    assert!(native.summary().iterations.is_some());
    shared(&with_unit, &native);
}

/// A case of nothing but what mocks and units need.
fn case(bench: &Bench, fluid: &str, structure: &str) -> String {
    let words: Vec<String> = fluid.split_whitespace().map(|word| format!("\"{word}\"")).collect();
    case_of(bench, &format!("{{ command = [\"{MENISCUS}\", \"mock\", {}] }}", words.join(", ")), structure)
}

fn case_of(bench: &Bench, fluid: &str, structure: &str) -> String {
    let coupling = "[coupling]\nmax_window = 0.004\nsub_steps = 10\ndeadline = 1.0";
    let text = case_text(fluid, structure, 0.2, coupling);
    let file = bench.path("case.toml");
    fs::write(&file, text).expect("a case");
    file.display().to_string()
}

const COLUMN: &str = "added-mass-column mass=0.5 wall=compliant gravity=9.81";

/// A unit in C beside a mock fluid, against the mock structure of the same equation: explicit and iterated.
#[test]
fn a_foreign_unit_is_a_structure_like_any_other() {
    let bench = Bench::new();
    let mock = format!(
        "{{ command = [\"{MENISCUS}\", \"mock\", \"spring-mass\", \"points=5\", \"spacing=0.01\", \"density=1000\", \"stiffness=400\", \"integration=rk4\"] }}"
    );
    for scheme in ["serial-explicit", "parallel-implicit"] {
        let scheme_words = ["--set", &format!("coupling.scheme={scheme}"), "--no-report"];
        let run = |out: &str, participant: &str| {
            let file = case(&bench, COLUMN, participant);
            let words = [&[file.as_str()], &scheme_words[..]].concat();
            let ended = bench.start_run(out, &words).wait();
            assert_eq!(ended.status.code(), Some(0), "{out}: {}", ended.errors);
            bench.outputs(out)
        };
        let force =
            |outputs: &Outputs| outputs.table("windows.csv").get("fluid.force").expect("a column").to_vec();
        let expected = force(&run(&format!("mock-{scheme}"), &mock));
        for version in [2, 3] {
            let spring = Spring::of(version);
            let unit = spring.build(bench.path("").as_path());
            let found = force(&run(
                &format!("unit{version}-{scheme}"),
                &spring.participant(&unit, "stiffness = 400"),
            ));
            assert_eq!(found.len(), expected.len());
            for (one, other) in found.iter().zip(&expected) {
                // Round-off of about fifty windows; iterated, amplified by the quasi-Newton method up to its
                // convergence of 1e-3.
                let tolerance = if scheme == "serial-explicit" { 1e-9 } else { 2e-3 };
                assert!((one - other).abs() < tolerance * 10.0, "{scheme}, FMI {version}: {one} {other}");
            }
        }
    }
}

/// Whatever foreign code does is told as its own doing, soon, and takes nobody along.
#[test]
fn a_unit_that_misbehaves_is_named_and_nothing_is_left() {
    let bench = Bench::new();
    let spring = Spring::of(3);
    let unit = spring.build(bench.path("").as_path());
    for (fault, code, words) in [
        (1, 1, "answered Error: the spring broke"),
        (2, 1, "structure"),
        (3, 1, "deadline"),
        (4, 1, "NaN"),
        (5, 0, ""),
    ] {
        let participant = spring.participant(&unit, &format!("fault = {fault}, fault_time = 0.1"));
        let started = Instant::now();
        let out = format!("fault{fault}");
        let ended = bench.start_run(&out, &[&case(&bench, COLUMN, &participant), "--no-report"]).wait();
        assert_eq!(ended.status.code(), Some(code), "{fault}: {}{}", ended.text, ended.errors);
        assert!(ended.errors.contains(words), "{fault}: {}", ended.errors);
        let summary = bench.outputs(&out).summary();
        let expected = if code == 0 { Status::Completed } else { Status::Failed };
        assert_eq!(summary.status, expected);
        // The windows before the fault are whole.
        let rows = bench.outputs(&out).table("windows.csv").rows();
        assert!((24..=26).contains(&rows), "{fault}: {rows}");
        if fault == 5 {
            assert_eq!(summary.message.as_deref(), Some("the structure asked for it"));
        }
        if fault == 2 {
            assert!(ended.errors.contains("signal 6"), "{}", ended.errors);
        }
        // The deadline of a second, and a few for starting on a loaded machine.
        assert!(started.elapsed() < Duration::from_secs(20), "{fault}");
        assert!(bench.left().is_empty(), "{fault}: {:?}", bench.left());
        assert!(!bench.path(&out).join("structure_fmu").exists(), "{fault}");
    }
}

#[test]
fn a_unit_that_does_not_fit_is_refused_before_anything_starts() {
    let bench = Bench::new();
    let unit = Spring::of(3).build(bench.path("").as_path());
    let participant = format!("{{ fmu = \"{}\", record = [\"nothing\"] }}", unit.display());
    let file = case(&bench, COLUMN, &participant);
    for words in
        [["run", &file, "--out", &bench.path("out").display().to_string()].as_slice(), &["check", &file]]
    {
        let ended = bench.call(words);
        assert_ne!(ended.status.code(), Some(0));
        for expected in ["spring3.fmu", "variables.position", "record: there is no variable `nothing`"] {
            assert!(ended.errors.contains(expected), "{expected}: {}", ended.errors);
        }
    }
    assert!(!bench.path("out").exists());
    // In the coupler's process a foreign library has no place.
    let spring = Spring::of(3);
    let file = case(&bench, COLUMN, &spring.participant(&unit, ""));
    let ended = bench.start_run("out", &[&file, "--in-process"]).wait();
    assert_eq!(ended.status.code(), Some(1));
    assert!(ended.errors.contains("leave out --in-process"), "{}", ended.errors);
    let ended = bench.call(&["check", &file]);
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    for expected in ["Spring (FMI 3.0)", "5 points"] {
        assert!(ended.text.contains(expected), "{expected}: {}", ended.text);
    }
}

/// A unit of scalar variables knows a few points; the fluid meets the particles of its bodies through a
/// mapping. The case says neither where its variables are nor how they are mapped.
#[test]
fn a_reduced_unit_meets_our_fluid_and_the_case_says_no_more_than_its_name() {
    let bench = Bench::new();
    let whole = bench.coarse_gate("native", &[]);
    let tip = |outputs: &Outputs| {
        outputs.table("probes.csv").get("tip.ux").expect("a probe").last().copied().expect("rows")
    };
    for kind in [["--fmi", "2"].as_slice(), &["--scalars"]] {
        let unit = export(&bench, "gate.fmu", &[&COARSE[..7], kind, &["--points", "16"]].concat());
        let outputs = bench.coarse_gate("out", &["--set", &format!("structure.participant.fmu={unit}")]);
        let table = outputs.table("windows.csv");
        let column = |name: &str| table.get(name).expect("a column").to_vec();
        let (given, applied) = (column("force_after_x"), column("force_applied_x"));
        // Water of 0.14 m pushes the gate; what it gives arrives.
        assert!(given.iter().any(|f| *f > 5.0), "{given:?}");
        assert!(
            given.iter().zip(&applied).all(|(g, a)| (g - a).abs() <= 1e-9 * g.abs()),
            "{given:?} {applied:?}"
        );
        // The gate bends as with all 64 particles of its interface: a smooth load at sixteen points is nearly
        // the same load. Measured: 3e-5.
        let (reduced, whole) = (tip(&outputs), tip(&whole));
        assert!((reduced / whole - 1.0).abs() < 3e-4, "{kind:?}: {reduced} {whole}");
        let notes = outputs.summary().notes.join("; ");
        assert!(notes.contains("a mapping by radial basis functions"), "{notes}");
    }
}

/// What keeps a unit from taking part is told by `check`, with what the system or the unit says of it, and in
/// the same words by a run.
#[test]
fn a_unit_that_cannot_take_part_is_told_with_the_reason() {
    let bench = Bench::new();
    let spring = Spring::of(3);
    for (spring, scheme, words) in [
        (Spring { define: "UNRESOLVED", ..spring }, "serial-explicit", "undefined symbol: nowhere"),
        (
            Spring { define: "WITHOUT_STATE", ..spring },
            "serial-explicit",
            "undefined symbol: fmi3GetFMUState",
        ),
        (Spring { keeps_state: false, ..spring }, "serial-implicit", "canGetAndSetFMUState is false"),
    ] {
        let unit = spring.build(bench.path("").as_path());
        let file = case(&bench, COLUMN, &spring.participant(&unit, ""));
        let scheme = format!("coupling.scheme={scheme}");
        let checked = bench.call(&["check", &file, "--set", &scheme]);
        let run = bench.start_run("out", &[&file, "--no-report", "--set", &scheme]).wait();
        for ended in [checked, run] {
            assert_ne!(ended.status.code(), Some(0), "{words}: {}", ended.text);
            assert!(ended.errors.contains(words), "`{words}` is not in: {}", ended.errors);
            assert!(!ended.text.contains("no mistakes found"), "{words}");
        }
    }
}

/// A probe that the unit does not have, and one on a structure of another program's, are told before a run
/// and after it.
#[test]
fn a_probe_that_a_foreign_structure_does_not_have_is_told() {
    let bench = Bench::new();
    let spring = Spring::of(3);
    let unit = spring.build(bench.path("").as_path());
    let mock = format!(
        "{{ command = [\"{MENISCUS}\", \"mock\", \"spring-mass\", \"points=5\", \"spacing=0.01\"] }}"
    );
    for (structure, said) in [
        (spring.participant(&unit, ""), "the case's probe `tip.stress_xx` is none of its variables"),
        (mock, "probe \"tip\" is recorded if it reports tip.stress_xx, tip.stress_yy, tip.stress_xy"),
    ] {
        let file = case(&bench, COLUMN, &structure);
        let probe = "probe=[{ name = \"tip\", on = \"structure\", quantity = \"stress\", at = [0.0, 0.0] }]";
        let checked = bench.call(&["check", &file, "--set", probe]);
        let run = bench.start_run("out", &[&file, "--no-report", "--set", probe]).wait();
        for (ended, told) in [(checked, said), (run, "probe \"tip\" is not recorded: the structure, ")] {
            assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
            assert!(ended.text.contains(told), "`{told}` is not in: {}", ended.text);
        }
    }
}

/// Units on both sides, of another hand both: meniscus as nothing but the coupling.
#[test]
fn two_foreign_units_are_coupled() {
    let bench = Bench::new();
    let spring = Spring::of(3);
    let structure =
        spring.participant(&spring.build(bench.path("").as_path()), "stiffness = 400, swing = 0.1");
    let fluid = format!("{{ fmu = \"{}\" }}", spring_unit::drag(bench.path("").as_path()).display());
    let file = case_of(&bench, &fluid, &structure);
    let ended = bench.start_run("out", &[&file, "--no-report", "--set", "coupling.max_window=1e-3"]).wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    let table = bench.outputs("out").table("windows.csv");
    let column = |name: &str| table.get(name).expect("a column").to_vec();
    let (kinetic, dissipated) = (column("structure.kinetic_energy"), column("fluid.dissipated_energy"));
    // 0.5 kg on 400 N/m, 10 cm to the side, has 2 J, and loses of it exp(-2 gamma t), gamma = 2.5 N s/m / (2
    // · 0.5 kg).
    let largest = kinetic.iter().copied().fold(0.0, f64::max);
    assert!((1.5..2.0).contains(&largest), "{largest}");
    let lost = 2.0 * (1.0 - (-5.0 * 0.2_f64).exp());
    // Where it swings, its loss goes up and down about that by gamma/omega = 0.09; windows of 1 ms add a
    // hundredth.
    let found = dissipated.last().copied().expect("rows");
    assert!((found / lost - 1.0).abs() < 0.15, "{found} {lost}");
}
