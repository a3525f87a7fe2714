//! What runs out under a run: disk, folder, shared memory.

use crate::processes::{MANY_WINDOWS, failed_in_order};
use crate::support::{Bench, COARSE, Ended, Running, until};

/// Runs a script among mounts of its own, which it makes with `mount … || exit 77`; nothing where it may not.
fn mounted(bench: &Bench, script: &str) -> Option<Ended> {
    let mut shell = std::process::Command::new("unshare");
    shell.args(["-m", "sh", "-c", script]).env("MENISCUS_DOMAIN", &bench.domain);
    shell.current_dir(env!("CARGO_MANIFEST_DIR"));
    let ended = Running::spawn(shell, &bench.path("printed")).wait();
    if ended.status.code() == Some(77) || ended.errors.contains("unshare failed") {
        eprintln!("not looked at: no file system can be mounted here");
        return None;
    }
    Some(ended)
}

/// A disk that takes no more: a limit on the size of files stands in for it, which cuts a write where it is
/// reached. All tables end in whole rows with the same window, and the summary says why.
#[test]
fn a_full_disk_leaves_whole_tables_of_one_length_and_a_summary() {
    let bench = Bench::new();
    let case = bench.path("case.toml");
    std::fs::write(&case, MANY_WINDOWS.replace("MENISCUS", crate::support::MENISCUS)).expect("a case");
    let out = bench.path("out");
    let command = format!(
        "trap '' XFSZ; ulimit -f 200; exec {} run {} --out {} --no-report",
        crate::support::MENISCUS,
        case.display(),
        out.display()
    );
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &command]).env("MENISCUS_DOMAIN", &bench.domain);
    let ended = Running::spawn(shell, &bench.path("printed")).wait();
    let outputs = failed_in_order(&bench, "out", &ended, &["failed to record window", "windows.csv"]);
    let summary = outputs.summary();
    let windows = outputs.table("windows.csv");
    assert!(windows.rows() > 100, "{}", windows.rows());
    for file in ["windows.csv", "iterations.csv"] {
        let text = std::fs::read_to_string(out.join(file)).expect("a table");
        assert!(text.ends_with('\n'), "{file} ends with {:?}", text.lines().last());
        let table = outputs.table(file);
        let last = table.get("window").and_then(|column| column.last()).expect("rows");
        assert_eq!(*last, windows.rows() as f64 - 1.0, "{file}");
    }
    assert!(summary.windows >= windows.rows() as u64, "{}", summary.windows);
    assert!(!out.join(".room").exists());
}

/// A file system that is full, and a structure with probes: its table is cut where that of the windows is.
#[test]
fn a_full_file_system_cuts_the_probes_where_it_cuts_the_windows() {
    let bench = Bench::new();
    let (small, out) = (bench.path("small"), bench.path("out"));
    std::fs::create_dir(&small).expect("a folder");
    let load = format!("[\"{}\", \"mock\", \"constant\", \"gradient=-1e5,0\"]", crate::support::MENISCUS);
    let command = format!(
        "mount -t tmpfs -o size=600k tmpfs {0} || exit 77
         {1} run {2} --out {0}/out --set 'fluid.participant.command={load}' \
             --set coupling.max_window=2e-6 --set coupling.sub_steps=1
         ended=$?; cp -r {0}/out {3}; exit $ended",
        small.display(),
        crate::support::MENISCUS,
        COARSE.join(" "),
        out.display()
    );
    let Some(ended) = mounted(&bench, &command) else { return };
    let outputs = failed_in_order(&bench, "out", &ended, &["No space left on device"]);
    let (windows, probes) = (outputs.table("windows.csv"), outputs.table("probes.csv"));
    assert!(windows.rows() > 100, "{}", windows.rows());
    assert_eq!(probes.rows(), windows.rows() + 1, "one more for the start");
    for (file, table, time) in [("windows.csv", &windows, "time"), ("probes.csv", &probes, "t")] {
        let text = std::fs::read_to_string(out.join(file)).expect("a table");
        assert!(text.ends_with('\n'), "{file} ends with {:?}", text.lines().last());
        let last = table.get(time).and_then(|column| column.last()).expect("rows");
        assert!((last - 2e-6 * windows.rows() as f64).abs() < 1e-9, "{file}: {last}");
    }
    assert!(outputs.summary().windows >= windows.rows() as u64);
}

/// Who takes the folder away from under a run is told that there is no summary.
#[test]
fn a_folder_that_vanishes_is_told() {
    let bench = Bench::new();
    let run = bench.start_run("out", &[&COARSE, ["--set", "case.end_time=1.0"].as_slice()].concat());
    let out = bench.path("out");
    until("rows", || std::fs::metadata(out.join("windows.csv")).is_ok_and(|it| it.len() > 0).then_some(()));
    // At once: file by file the run could end before, with a summary.
    std::fs::rename(&out, bench.path("away")).expect("the folder");
    let ended = run.wait();
    assert_eq!(ended.status.code(), Some(1), "{}", ended.errors);
    assert!(ended.errors.contains("summary.json"), "{}", ended.errors);
}

/// The shared memory of a container that is nearly full, of a few sizes; only root can have one of its own.
#[test]
fn shared_memory_that_is_full_is_named_with_its_size() {
    for kilobytes in [4, 16, 64, 256] {
        let bench = Bench::new();
        let out = bench.path("out");
        let command = format!(
            "mount -t tmpfs -o size={kilobytes}k tmpfs /dev/shm || exit 77; exec {} run {} --out {}",
            crate::support::MENISCUS,
            COARSE.join(" "),
            out.display()
        );
        let Some(ended) = mounted(&bench, &command) else { return };
        assert_eq!(ended.status.code(), Some(1), "{kilobytes} kB: {}", ended.errors);
        assert!(ended.errors.contains("/dev/shm is full"), "{kilobytes} kB: {}", ended.errors);
        assert!(ended.errors.contains(" kB are free"), "{kilobytes} kB: {}", ended.errors);
    }
}
