//! A writer killed at any moment leaves files that can be read.

use output::checkpoint::{Checkpoint, Writing};
use output::{ParticleFrame, Series, Summary, Table, pvd, table, vtu};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Tells this test program, started once more, to write into the folder until it is killed.
const WRITE_INTO: &str = "OUTPUT_TEST_WRITE_INTO";

#[test]
fn files_are_whole_after_a_kill() {
    if let Some(dir) = std::env::var_os(WRITE_INTO) {
        write_until_killed(Path::new(&dir));
        return;
    }
    for round in 0..4 {
        let dir = tempfile::tempdir().unwrap();
        let mut writer = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "killed::files_are_whole_after_a_kill"])
            .env(WRITE_INTO, dir.path())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        // Killed at a different place of its work each time, once it has written something.
        let deadline = Instant::now() + Duration::from_secs(20);
        while table::read(&dir.path().join("t.csv")).map_or(0, |t| t.rows()) < 50 * (round + 1) {
            assert!(Instant::now() < deadline, "the writer has written nothing in 20 s");
            std::thread::sleep(Duration::from_millis(3));
        }
        writer.kill().unwrap();
        writer.wait().unwrap();

        let entries = pvd::read(&dir.path().join("fluid.pvd")).unwrap();
        assert!(!entries.is_empty());
        for entry in &entries {
            assert_eq!(vtu::read(&entry.file).unwrap().particles(), 5000);
        }
        let rows = table::read(&dir.path().join("t.csv")).unwrap();
        assert!(rows.columns[0].iter().enumerate().all(|(row, &value)| value == row as f64));
        let checkpoints = std::fs::read_dir(dir.path()).unwrap().map(|entry| entry.unwrap().path());
        for path in checkpoints.filter(|path| path.extension().is_some_and(|ending| ending == "checkpoint")) {
            assert_eq!(Checkpoint::open(&path).unwrap().part("state").unwrap().len(), 200_000);
        }
        assert!(Summary::read(&dir.path().join("summary.json")).unwrap().windows > 0);
        output::write_report(dir.path(), &output::report::Shown::default()).unwrap();
    }
}

/// Bounded, should nobody kill it.
fn write_until_killed(dir: &Path) {
    let mut series = Series::create(dir, "fluid").unwrap();
    let mut rows = Table::create(&dir.join("t.csv"), &["row", "x"]).unwrap();
    let positions = vec![0.5; 10_000];
    for step in 0..20_000u32 {
        let summary = Summary { windows: u64::from(step) + 1, ..Summary::default() };
        summary.write(&dir.join("summary.json")).unwrap();
        let time = f64::from(step);
        if step % 5 == 0 {
            series.write(&ParticleFrame { time, dimension: 2, positions: &positions, arrays: &[] }).unwrap();
        }
        rows.row(&[time, 1.0 / (time + 1.0)]).unwrap();
        let mut checkpoint = Writing::begin(&dir.join(format!("{}.checkpoint", step % 2))).unwrap();
        checkpoint.part("state", &[7; 200_000]).unwrap();
        checkpoint.finish().unwrap();
    }
}
