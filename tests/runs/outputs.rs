//! What a run leaves and says: tables that are thinned, sums over all windows, the closing summary, columns
//! that the docs explain, a report on damaged data.

use crate::support::{Bench, COARSE, MENISCUS, Outputs, assert_same};
use std::fs;

/// The rows of `records_of`, thinned, are rows of all the windows; the sums are over all of these.
fn assert_thinned(all: &Outputs, thinned: &Outputs, interval: f64) {
    let (every, kept) = (all.table("windows.csv"), thinned.table("windows.csv"));
    let (indices, times) = (kept.get("window").unwrap(), kept.get("time").unwrap());
    assert!(2 * kept.rows() < every.rows(), "{} of {}", kept.rows(), every.rows());
    assert_eq!(times.last(), every.get("time").unwrap().last(), "the last window has a row");
    // A row comes with the first window that ends an interval after the row before, or with an output.
    let longest = every.get("size").unwrap().iter().copied().fold(0.0, f64::max);
    for pair in times.windows(2) {
        assert!(pair[1] - pair[0] < interval + longest, "{pair:?}");
    }
    for (name, values) in kept.iter().filter(|(name, _)| !name.ends_with("_seconds")) {
        let column = every.get(name).unwrap();
        for (value, index) in values.iter().zip(indices) {
            assert_eq!(value.to_bits(), column[*index as usize].to_bits(), "{name}, window {index}");
        }
    }
    assert_eq!(thinned.table("probes.csv").rows(), kept.rows() + 1);
    let (one, other) = (all.summary(), thinned.summary());
    assert_eq!((one.windows, one.sub_steps), (other.windows, other.sub_steps));
    assert_eq!((&one.balances, &one.condition_46), (&other.balances, &other.condition_46));
    assert_eq!((&one.probes, &one.fluid, one.iterations), (&other.probes, &other.fluid, other.iterations));
    // What the windows between two rows took is in the later row.
    for role in ["fluid", "structure"] {
        let sum: f64 = kept.get(&format!("{role}.compute_seconds")).unwrap().iter().sum();
        let whole = other.roles[role].compute_seconds;
        assert!((sum / whole - 1.0).abs() < 1e-9, "{role}: {sum} and {whole}");
    }
    if let Some(iterations) = one.iterations {
        let rows = thinned.table("iterations.csv");
        let recorded = rows.get("window").unwrap();
        assert!(recorded.iter().all(|window| indices.contains(window)));
        let solved = all.table("iterations.csv").rows() as f64;
        assert!((iterations.mean - solved / one.windows as f64).abs() < 1e-12);
    }
}

#[test]
fn records_are_thinned_by_the_case_and_the_sums_are_over_all_windows() {
    let bench = Bench::new();
    for scheme in ["serial-explicit", "serial-implicit"] {
        let set = format!("coupling.scheme={scheme}");
        let run = |out: &str, more: &[&str]| bench.coarse_gate(out, &[&["--set", &set], more].concat());
        let all = run("all", &[]);
        let thinned = run("thinned", &["--set", "case.record_interval=0.003"]);
        assert_thinned(&all, &thinned, 0.003);
    }
}

/// A thousand threads would take longer to start than the run takes; no result depends on their number.
#[test]
fn no_more_threads_are_started_than_the_machine_can_use() {
    let bench = Bench::new();
    let cores = std::thread::available_parallelism().unwrap().get();
    let one = bench.coarse_gate("one", &["--set", "case.threads=1"]);
    let many = bench.coarse_gate("many", &["--set", "case.threads=1000"]);
    assert_eq!((one.summary().threads, many.summary().threads), (1, 4 * cores));
    assert_same(&one, &many);
}

/// `check` says how many windows come, from the fluid's speeds, the structure's sub-steps, the limits of the
/// case and its outputs.
#[test]
fn as_many_windows_come_as_check_expects() {
    let bench = Bench::new();
    for (template, words) in [
        ("dam-break", ["--end-time", "0.1", "--set", "case.particle_spacing=0.02"].as_slice()),
        ("coupled", &["--end-time", "0.02"]),
        ("coupled", &["--end-time", "0.01", "--set", "coupling.max_window=3e-4"]),
        ("coupled", &["--end-time", "0.004", "--set", "coupling.sub_steps=2"]),
        ("plate", &["--end-time", "0.02"]),
        ("plate", &["--end-time", "0.02", "--set", "case.output_interval=0.02"]),
    ] {
        let folder = bench.path(template).display().to_string();
        bench.call(&["new", &folder, "--template", template]);
        let ended = bench.call(&[&["check", &folder], words].concat());
        let expected = ended.text.lines().find(|line| line.contains("expected windows")).expect("a line");
        let numbers = expected.split_whitespace().filter_map(|word| word.parse().ok());
        let numbers: Vec<f64> = numbers.collect();
        let ended = bench.start_run("out", &[&[folder.as_str(), "--no-report"], words].concat()).wait();
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        let windows = bench.outputs("out").summary().windows as f64;
        let (least, most) = (numbers[0], numbers[numbers.len() - 1]);
        assert!(least <= windows && windows <= most, "{template} {words:?}: {windows}, {expected}");
    }
}

/// What a run says at its end.
#[test]
fn the_closing_summary_has_digits_units_and_everything_that_was_noted() {
    let bench = Bench::new();
    let folder = bench.path("dam").display().to_string();
    bench.call(&["new", &folder]);
    let ended = bench.start_run("out", &[&folder, "--end-time", "0.001", "--no-report"]).wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    let line = |name: &str| {
        let found = ended.text.lines().find_map(|line| line.strip_prefix(name));
        found.unwrap_or_else(|| panic!("no `{name}` in {}", ended.text))
    };
    // The longest name stands apart, lengths and forces have their units, and a millionth its digits.
    assert!(line("front.bottom").starts_with("  from "), "{}", ended.text);
    assert!(line("front.left ").contains(" m (t = ") && line("tank.fx ").contains(" N (t = "));
    assert!(!ended.text.contains("0.000000"), "{}", ended.text);
    let right = bench.outputs("out").summary().probes["front.right"].clone();
    let moved = right.max - right.min;
    assert!(moved > 0.0 && moved < 1e-4, "{moved}");

    // Windows that do not converge, and a probe that a foreign structure does not report.
    let gate = format!(
        "structure.participant.command=[\"{MENISCUS}\", \"mock\", \"rigid\", \"grid=2x30\", \"spacing=2.5e-3\", \"origin=0.10125,0.00125\"]"
    );
    let unsolvable = "coupling.convergence={ relative = 1e-15, max_iterations = 1 }";
    let stressed =
        "probe=[{ name = \"tip\", on = \"structure\", quantity = \"stress\", at = [0.1025, 0.0] }]";
    let words = ["--set", &gate, "--set", "coupling.scheme=serial-implicit", "--set", unsolvable];
    let words = [&words[..], &["--set", stressed, "--set", "reference=[]"]].concat();
    let ended = bench.start_run("noted", &[&COARSE, words.as_slice()].concat()).wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    let summary = bench.outputs("noted").summary();
    let unconverged = summary.iterations.expect("an implicit scheme").not_converged;
    assert!(unconverged > 0);
    let warning = format!("{unconverged} of {} windows did not converge", summary.windows);
    assert!(ended.text.contains(&warning), "{}", ended.text);
    assert!(!summary.notes.is_empty());
    for note in &summary.notes {
        assert!(ended.text.contains(&format!("note        {note}")), "{note}: {}", ended.text);
    }
    assert!(summary.notes.iter().any(|note| note.contains("probe \"tip\" is not recorded")));
}

#[test]
fn every_column_is_in_the_docs_and_a_report_on_damaged_data_says_so() {
    let bench = Bench::new();
    let outputs = bench.coarse_gate("out", &["--set", "coupling.scheme=serial-implicit"]);
    let page = fs::read_to_string("docs/outputs.md").expect("the page");
    let tables = output::columns::read(&outputs.0).expect("columns");
    for table in ["windows.csv", "iterations.csv"] {
        for (column, content) in &tables[table] {
            let general = column.split('_').map(|part| match part {
                "given" | "before" | "after" | "applied" => "<stage>",
                "x" | "y" | "z" => "<axis>",
                other => other,
            });
            let general = general.collect::<Vec<_>>().join("_");
            let of_a_side = column.replace("fluid.", "<side>.").replace("structure.", "<side>.");
            let documented = |name: &&String| page.contains(&format!("`{name}`"));
            assert!([column, &general, &of_a_side].iter().any(documented), "{table}: `{column}`");
            assert!(!content.unit.is_empty() && !content.meaning.is_empty(), "{column}");
        }
    }

    let dir = outputs.0.display().to_string();
    let shown = ["report", &dir, "--times", "0.01", "--view=-0.1,-0.1,0.3,0.2"];
    let ended = bench.call(&shown);
    assert_eq!((ended.status.code(), ended.errors.as_str()), (Some(0), ""));
    let frames = fs::read_dir(outputs.0.join("frames")).expect("frames").flatten();
    let mut frames: Vec<_> = frames.map(|entry| entry.file_name().into_string().unwrap()).collect();
    frames.sort();
    assert_eq!(frames, ["structure.png", "t0.0100.png"]);
    let refused = bench.call(&["report", &dir, "--view", "0,0,0,1"]);
    assert!(refused.errors.contains("give four numbers"), "{}", refused.errors);

    let table = outputs.0.join("probes.csv");
    let text = fs::read_to_string(&table).expect("a table");
    fs::write(&table, text.replacen("\n0,", "\nbroken,", 1)).expect("a table");
    let ended = bench.call(&["report", &dir]);
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    assert!(ended.errors.contains("warning: ") && ended.errors.contains("`broken`"), "{}", ended.errors);
}

/// A solve that may not iterate fails: the error names a file, and the file is there.
#[test]
fn a_failed_solve_leaves_its_state_in_the_folder_of_the_run() {
    let bench = Bench::new();
    let few = ["--set", "fluid.numerics.pressure_iterations_limit=1", "--end-time", "0.01", "--no-report"];
    let words = [&["cases/hydrostatic_tank"], &few[..]].concat();
    let ended = bench.start_run("out", &words).wait();
    assert_ne!(ended.status.code(), Some(0), "{}", ended.text);
    let file = bench.path("out").join("failed_solve").join("failed_solve_000000.vtu");
    assert!(ended.errors.contains("failed_solve_000000.vtu"), "{}", ended.errors);
    assert!(fs::read(&file).is_ok_and(|bytes| bytes.len() > 1000), "{}", file.display());
}
