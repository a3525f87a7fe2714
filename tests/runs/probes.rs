//! Probes as an experimenter has them: over intervals and low-passed, of a line, an area, a moment, stresses;
//! and those of another program's structure.

use crate::support::{Bench, COARSE, MENISCUS, Outputs, assert_same};
use std::fs;

/// What the coarse gate is watched by besides its own probes.
const WATCHED: &str = r#"
[[probe]]
name = "sensor"
on = "wall"
wall = "tank"
quantity = "pressure"
at = [0.0, 0.05]
span = [[0.0, 0.02]]
interval = 0.0025
low_pass = 200.0

[[probe]]
name = "point"
on = "wall"
wall = "tank"
quantity = "pressure"
at = [0.0, 0.05]

[[probe]]
name = "column"
on = "fluid"
quantity = "surface-height"
at = [0.05, 0.0]

[[probe]]
name = "sinking"
on = "fluid"
quantity = "flux"
at = [0.05, 0.0972]
span = [[0.12, 0.0]]
direction = [0.0, -1.0]

[[probe]]
name = "turning"
on = "structure"
quantity = "moment"
at = [0.0, 0.0]
interval = 0.005

[[probe]]
name = "held"
on = "structure"
quantity = "von-mises-stress"
at = [0.1, 0.075]

[[probe]]
name = "bent"
on = "structure"
quantity = "strain"
at = [0.1, 0.075]
"#;

fn column(outputs: &Outputs, table: &str, name: &str) -> Vec<f64> {
    outputs.table(table).get(name).unwrap_or_else(|| panic!("{table} has no {name}")).to_vec()
}

/// Means are those of the rows by hand, moments those of the windows' table, heights and heights and pressures those of still
/// water; and all of it is the same in one process as in three, explicit and iterated.
#[test]
fn the_gate_is_watched_the_same_however_it_runs() {
    let bench = Bench::new();
    let file = bench.path("gate.toml");
    let gate = fs::read_to_string("cases/elastic_gate/case.toml").expect("the case");
    fs::write(&file, gate + WATCHED).expect("a case");
    let file = file.display().to_string();
    for scheme in ["serial-explicit", "serial-implicit"] {
        let run = |out: &str, more: &[&str]| {
            let scheme = format!("coupling.scheme={scheme}");
            let words = [&[file.as_str()], &COARSE[1..], &["--set", &scheme], more].concat();
            let ended = bench.start_run(out, &words).wait();
            assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
            bench.outputs(out)
        };
        let outputs = run(&format!("three-{scheme}"), &[]);
        assert_same(&outputs, &run(&format!("one-{scheme}"), &["--in-process"]));

        let (time, size) = (column(&outputs, "windows.csv", "time"), column(&outputs, "windows.csv", "size"));
        let values = column(&outputs, "probes.csv", "sensor.p");
        let ends = column(&outputs, "probes_intervals.csv", "t");
        let means = column(&outputs, "probes_intervals.csv", "sensor.p_mean");
        let largest = column(&outputs, "probes_intervals.csv", "sensor.p_max");
        // Eight intervals of 2.5 ms, which cut windows of 1 ms; with each second one ends one of 5 ms.
        assert_eq!(ends.len(), 8, "{ends:?}");
        let turning = column(&outputs, "probes_intervals.csv", "turning.mz_mean");
        assert_eq!(turning.iter().filter(|mean| mean.is_nan()).count(), 4, "{turning:?}");
        for (k, end) in ends.iter().enumerate() {
            let cut = |i: usize| (time[i].min(*end) - (time[i] - size[i]).max(end - 0.0025)).max(0.0);
            let mean = (0..time.len()).map(|i| cut(i) * values[i + 1]).sum::<f64>() / 0.0025;
            assert!((means[k] / mean - 1.0).abs() < 1e-9, "{} and not {mean} at {end}", means[k]);
            let most = (0..time.len()).filter(|&i| cut(i) > 1e-9).map(|i| values[i + 1]).fold(0.0, f64::max);
            assert_eq!(largest[k], most);
        }
        // Linear over its two centimetres but for a part of the spacing of 5 mm.
        let point = column(&outputs, "probes.csv", "point.p");
        for (mean, middle) in values.iter().zip(point) {
            assert!((mean / middle - 1.0).abs() < 0.02, "{mean} {middle}");
        }
        let extremes = outputs.summary().probes;
        let (all, passed) = (&extremes["sensor.p"], &extremes["sensor.p_butterworth"]);
        assert!(passed.max < all.max && passed.min >= 0.0, "{passed:?} {all:?}");

        let heights = column(&outputs, "probes.csv", "column.height");
        // The lattice at the start is right to a hundredth of a spacing; it sinks as the gate lets out water.
        assert!((heights[0] - 0.14).abs() < 0.01 * 5e-3, "{}", heights[0]);
        assert!(heights.last().expect("rows") < &heights[0]);

        let rates = column(&outputs, "probes.csv", "sinking.rate");
        let volumes = column(&outputs, "probes.csv", "sinking.volume");
        let sum: f64 = rates[1..].iter().zip(&size).map(|(rate, size)| rate * size).sum();
        let last = volumes.last().expect("rows");
        let count = last / 25e-6;
        assert!((sum - last).abs() < 1e-12 && (count - count.round()).abs() < 1e-9, "{sum} {last}");
        // A row of twenty particles was 0.3 mm above the segment.
        assert!(count > 0.0, "{count}");

        let applied = column(&outputs, "windows.csv", "moment_applied_z");
        let turning = column(&outputs, "probes.csv", "turning.mz");
        for (one, other) in turning[1..].iter().zip(&applied) {
            assert!((one - other).abs() < 1e-9 * applied.iter().fold(1.0, |most, m| m.abs().max(most)));
        }
        // At the wet face of the clamp the gate is stretched.
        assert!(column(&outputs, "probes.csv", "held.von_mises").last().expect("rows") > &1e3);
        assert!(column(&outputs, "probes.csv", "bent.strain_yy").last().expect("rows") > &1e-4);
        let contents = output::columns::read(&outputs.0).expect("columns");
        for (table, column, unit) in [
            ("probes.csv", "sinking.rate", "m3/s"),
            ("probes.csv", "turning.mz", "N*m"),
            ("probes.csv", "sensor.p_butterworth", "Pa"),
            ("probes.csv", "bent.strain_xy", "1"),
            ("probes_intervals.csv", "turning.mz_min", "N*m"),
        ] {
            assert_eq!(contents[table][column].unit, unit, "{column}");
        }
    }
}

/// A block of 0.1 m × 0.1 m that drifts at 1 m/s, with no gravity, for 0.05 s through a gate in front of it:
/// half of it, counted by columns of particles 5 mm wide; nothing passes beside it.
#[test]
fn half_of_a_block_drifts_through_a_segment() {
    let bench = Bench::new();
    let text = r#"
[case]
title = "Drift"
dimension = 2
end_time = 0.05
output_interval = 0.05
particle_spacing = 5e-3

[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
domain = { low = [0.0, 0.0], high = [0.5, 0.5] }

[[fluid.region]]
name = "block"
box = { low = [0.1, 0.1], high = [0.2, 0.2] }
velocity = [1.0, 0.0]

[[probe]]
name = "through"
on = "fluid"
quantity = "flux"
at = [0.2, 0.15]
span = [[0.0, 0.2]]
direction = [1.0, 0.0]

[[probe]]
name = "beside"
on = "fluid"
quantity = "flux"
at = [0.2, 0.4]
span = [[0.0, 0.2]]
direction = [1.0, 0.0]
"#;
    let file = bench.path("drift.toml");
    fs::write(&file, text).expect("a case");
    let ended = bench.start_run("out", &[&file.display().to_string(), "--no-report"]).wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    let outputs = bench.outputs("out");
    let last = |name: &str| *column(&outputs, "probes.csv", name).last().expect("rows");
    assert!((last("through.volume") - 0.005).abs() < 0.1 * 5e-3 * 1.001, "{}", last("through.volume"));
    assert_eq!(last("beside.volume"), 0.0);
}

/// A mock structure that reports nothing of it: the coupler has its displacement and the force on it, and
/// draws it.
#[test]
fn a_foreign_structure_is_recorded_and_drawn() {
    let bench = Bench::new();
    let text = format!(
        r#"
[case]
title = "Spring"
dimension = 2
end_time = 0.2
output_interval = 0.02
particle_spacing = 0.01

[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
domain = {{ low = [0.0, 0.0], high = [1.0, 1.0] }}
participant = {{ command = ["{MENISCUS}", "mock", "added-mass-column", "mass=0.5", "wall=compliant", "gravity=9.81"] }}

[structure]
participant = {{ command = ["{MENISCUS}", "mock", "spring-mass", "points=5", "spacing=0.01", "density=1000", "stiffness=400", "integration=rk4"] }}

[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 1e6
poisson_ratio = 0.3
density = 1000.0

[coupling]
max_window = 0.004
sub_steps = 10

[[probe]]
name = "tip"
on = "structure"
quantity = "displacement"
at = [0.0, 0.0]
interval = 0.1

[[probe]]
name = "push"
on = "structure"
quantity = "force"

[[probe]]
name = "inside"
on = "structure"
quantity = "stress"
at = [0.0, 0.0]
"#
    );
    let file = bench.path("spring.toml");
    fs::write(&file, text).expect("a case");
    let file = file.display().to_string();
    let checked = bench.call(&["check", &file]);
    for said in [
        "probe \"tip\" is recorded from the interface points, unless it reports tip.ux, tip.uy",
        "probe \"inside\" is recorded if it reports inside.stress_xx, inside.stress_yy, inside.stress_xy",
    ] {
        assert!(checked.text.contains(said), "{}", checked.text);
    }
    let run = |out: &str, scheme: &str| {
        let ended = bench.start_run(out, &[&file, "--set", &format!("coupling.scheme={scheme}")]).wait();
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        assert!(ended.text.contains("probe \"inside\" is not recorded"), "{}", ended.text);
        assert!(!ended.text.contains("probe \"tip\" is not recorded"), "{}", ended.text);
        bench.outputs(out)
    };
    for scheme in ["serial-explicit", "parallel-explicit", "serial-implicit"] {
        let outputs = run(scheme, scheme);
        let push = column(&outputs, "probes.csv", "push.fy");
        // Nobody knows of a force at the start; then it is the one that the windows' table has.
        assert!(push[0].is_nan());
        for (one, other) in push[1..].iter().zip(column(&outputs, "windows.csv", "force_applied_y")) {
            assert!((one - other).abs() <= 1e-12 * other.abs(), "{scheme}: {one} {other}");
        }
        let series = output::pvd::read(&outputs.0.join("structure.pvd")).expect("a series");
        assert_eq!(series.len(), 11, "the start and ten outputs");
        let moved = column(&outputs, "probes.csv", "tip.uy");
        assert!(moved.iter().any(|u| u.abs() > 1e-4), "{moved:?}");
        let drawn = output::vtu::read(&outputs.0.join(&series[10].file)).expect("a snapshot");
        let start = output::vtu::read(&outputs.0.join(&series[0].file)).expect("a snapshot");
        // All points of the mock move as one.
        let found = drawn.positions[1] - start.positions[1];
        assert!((found - moved.last().expect("rows")).abs() < 1e-12, "{scheme}: {found}");
        let frames = fs::read_dir(outputs.0.join("frames")).expect("frames").count();
        assert!(frames >= 11, "{frames}");
        assert_eq!(outputs.table("probes_intervals.csv").rows(), 2);
    }
}
