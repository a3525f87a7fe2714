//! What the command says: mistakes all at once with their exit codes, help, check, schema, outputs, and
//! partners of a user's own.

use crate::support::{Bench, COARSE, Ended, MENISCUS};
use interfaces::Role;
use output::summary::Status;
use std::fs;

/// A mistake in the case has exit code 2, all else 1; both say `words`, and print nothing else.
fn refused(ended: &Ended, code: i32, words: &[&str]) {
    assert_eq!(ended.status.code(), Some(code), "{}{}", ended.text, ended.errors);
    for word in words {
        assert!(ended.errors.contains(word), "`{word}` is not in: {}", ended.errors);
    }
    assert_eq!(ended.text, "");
}

/// A copy of the gate's case with one passage changed.
fn changed(bench: &Bench, from: &str, to: &str) -> String {
    let text = fs::read_to_string("cases/elastic_gate/case.toml").expect("the gate's case");
    assert!(text.contains(from), "`{from}` is not in the gate's case");
    let file = bench.path("case.toml");
    fs::write(&file, text.replacen(from, to, 1)).expect("a case");
    file.display().to_string()
}

#[test]
fn a_mistake_in_the_case_is_one_clear_error() {
    let bench = Bench::new();
    for (from, to, message) in [
        (
            "density = 1000.0",
            "densty = 1000.0",
            "fluid.densty = 1000.0: there is no such key; did you mean \"density\"?",
        ),
        (
            "density = 1000.0",
            "density = \"water\"",
            "fluid.density = \"water\": is a string, but must be a number",
        ),
        ("density = 1000.0", "density = -1000.0", "fluid.density = -1000.0: must be over 0"),
        (
            "law = \"saint-venant-kirchhoff\"",
            "law = \"granite\"",
            "structure.material.law = \"granite\": is none of \"almansi-hooke\"",
        ),
        ("[structure.material]", "[structure.other]", "structure.material"),
        ("low = [0.1, 0.079]", "low = [0.09, 0.079]", "overlap"),
    ] {
        let case = changed(&bench, from, to);
        for words in [["check", &case].as_slice(), &["run", &case, "--out", "/dev/null/out"]] {
            refused(&bench.call(words), 2, &["case.toml: ", message]);
        }
    }
}

#[test]
fn all_mistakes_are_told_at_once() {
    let bench = Bench::new();
    let ended = bench.call(&[
        "run",
        "cases/elastic_gate",
        "--set",
        "fluid.density=-1",
        "--set",
        "structure.material.law=granite",
        "--set",
        "coupling.relaxaton=0.4",
        "--end-time",
        "0",
    ]);
    let words = ["4 mistakes", "fluid.density = -1", "granite", "relaxaton", "did you mean", "case.end_time"];
    refused(&ended, 2, &words);
}

#[test]
fn what_is_not_there_is_named() {
    let bench = Bench::new();
    refused(&bench.call(&["run", "cases/no_such_case"]), 2, &["cases/no_such_case"]);
    refused(&bench.call(&["report", "/no/such/folder"]), 1, &["/no/such/folder"]);
    refused(&bench.call(&["run", "cases/elastic_gate", "--end-time", "soon"]), 2, &["soon"]);
    refused(&bench.call(&["fluid", "cases/elastic_gate"]), 2, &["--run"]);
    let mock = ["mock", "--case", "cases/elastic_gate", "--run", "none", "spring-mass", "stifness=3"];
    refused(&bench.call(&mock), 1, &["has no option `stifness`"]);
}

#[test]
fn a_folder_that_cannot_take_the_outputs_is_refused_untouched() {
    let bench = Bench::new();
    // A file where the folder should be: nobody may write there, whatever their rights.
    fs::write(bench.path("file"), "mine").expect("a file");
    let out = bench.path("file").join("out").display().to_string();
    let ended = bench.call(&[["run"].as_slice(), &COARSE, &["--out", &out]].concat());
    refused(&ended, 1, &["file/out as the folder of the outputs", "choose another with --out"]);

    fs::create_dir(bench.path("foreign")).expect("a folder");
    fs::write(bench.path("foreign").join("thesis.tex"), "mine").expect("a file");
    refused(&bench.start_run("foreign", &COARSE).wait(), 1, &["files that are not of an earlier run"]);
    assert_eq!(fs::read_dir(bench.path("foreign")).expect("a folder").count(), 1);

    // The folder of a case is no folder of outputs, though it has a case.toml too.
    fs::create_dir(bench.path("case")).expect("a folder");
    let case = bench.path("case").join("case.toml");
    fs::copy("cases/elastic_gate/case.toml", &case).expect("a case");
    let words = [&[case.to_str().expect("a plain path")], &COARSE[1..]].concat();
    refused(&bench.start_run("case", &words).wait(), 1, &["files that are not of an earlier run"]);
    let text = fs::read_to_string(&case).expect("the case");
    assert_eq!(text, fs::read_to_string("cases/elastic_gate/case.toml").expect("the case"));
}

#[test]
fn the_folder_of_an_earlier_run_is_used_again() {
    let bench = Bench::new();
    let first = bench.coarse_gate("out", &["--set", "case.end_time=0.04"]);
    let (windows, snapshots) = (first.table("windows.csv").rows(), first.snapshots().len());
    fs::write(first.0.join("notes.txt"), "mine").expect("a note");
    // The resolved case runs as it is, in the folder of its own outputs too.
    let resolved = first.0.join("case.toml").display().to_string();
    let ended =
        bench.start_run("out", &[&resolved, "--end-time", "0.02", "--in-process", "--no-report"]).wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    let second = bench.outputs("out");
    assert!(second.table("windows.csv").rows() < windows && second.snapshots().len() < snapshots);
    assert!(second.0.join("notes.txt").exists());
    assert!(!second.0.join("fluid.log").exists(), "a log of the earlier run");
    crate::support::assert_same(&second, &bench.coarse_gate("fresh", &[]));
}

#[test]
fn the_schema_is_json_and_every_command_has_help() {
    let bench = Bench::new();
    let schema = bench.call(&["schema"]);
    let schema: serde_json::Value = serde_json::from_str(&schema.text).expect("JSON");
    assert!(schema["properties"]["coupling"].is_object());
    for command in ["run", "check", "report", "fluid", "structure", "mock", "schema"] {
        let help = bench.call(&[command, "--help"]);
        assert_eq!(help.status.code(), Some(0));
        assert!(help.text.contains("Usage: meniscus") && help.text.contains(command), "{}", help.text);
    }
    let help = bench.call(&["mock", "--help"]).text;
    for kind in ["spring-mass", "added-mass-column", "hydrostatic", "scripted", "--fault"] {
        assert!(help.contains(kind), "{kind}: {help}");
    }
    assert_eq!(bench.call(&[]).status.code(), Some(2));
}

#[test]
fn a_run_says_how_it_went_and_reports() {
    let bench = Bench::new();
    let words = [&COARSE[..7], &["--set", "fluid.density=998"]].concat();
    let ended = bench.start_run("out", &words).wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    // No bar where standard error is no terminal.
    assert_eq!(ended.errors, "");
    let outputs = bench.outputs("out");
    for word in ["completed", "windows to t = 0.02 s", "fluid", "structure", "tip.ux", "(46)", "report.html"]
    {
        assert!(ended.text.contains(word), "{word}: {}", ended.text);
    }
    assert!(outputs.0.join("report.html").exists() && outputs.0.join("fluid.log").exists());
    let resolved = fs::read_to_string(outputs.0.join("case.toml")).expect("the case as resolved");
    assert!(resolved.contains("density = 998.0") && resolved.contains("end_time = 0.02"));
    let summary = outputs.summary();
    assert_eq!((summary.status, summary.message), (Status::Completed, None));
    assert_eq!(summary.simulated_seconds, 0.02);
    assert_eq!(summary.windows as usize, outputs.table("windows.csv").rows());
    fs::remove_file(outputs.0.join("report.html")).expect("the report");
    let report = bench.call(&["report", outputs.0.to_str().expect("a plain path")]);
    assert_eq!(report.status.code(), Some(0), "{}", report.errors);
    assert!(outputs.0.join("report.html").exists());
}

#[test]
fn one_side_alone_runs_by_the_same_command() {
    let bench = Bench::new();
    for (case, end_time, absent) in
        [("cases/hydrostatic_tank", "0.02", "structure"), ("cases/oscillating_plate", "0.005", "fluid")]
    {
        let interval = format!("case.output_interval={end_time}");
        let words = [case, "--end-time", end_time, "--set", &interval, "--no-report"];
        let [processes, in_process] =
            [("processes", None), ("in-process", Some("--in-process"))].map(|(out, mode)| {
                let words: Vec<_> = words.into_iter().chain(mode).collect();
                let ended = bench.start_run(out, &words).wait();
                assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
                bench.outputs(out)
            });
        crate::support::assert_same(&processes, &in_process);
        assert!(processes.snapshots().len() >= 2 && processes.table("windows.csv").rows() > 0);
        assert!(!processes.0.join(format!("{absent}.log")).exists());
    }
}

/// `<role>.participant.command` for `meniscus mock <words>`.
fn mock(role: Role, words: &str) -> String {
    let words: Vec<_> = words.split_whitespace().map(|word| format!("\"{word}\"")).collect();
    format!("{role}.participant.command=[\"{MENISCUS}\", \"mock\", {}]", words.join(", "))
}

#[test]
fn a_mock_stands_on_either_side_of_a_solver() {
    let bench = Bench::new();
    // A rigid gate of 2 x 30 particles where the case has its own, before the real fluid.
    let gate = mock(Role::Structure, "rigid grid=2x30 spacing=2.5e-3 origin=0.10125,0.00125");
    let ended = bench.start_run("rigid", &[&COARSE, ["--set", &gate].as_slice()].concat());
    let ended = ended.wait();
    // A mock gives no probes: the coupler reads them from its points, which stay, under the fluid's load.
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    let outputs = bench.outputs("rigid");
    let probes = outputs.table("probes.csv");
    let tip = probes.get("tip.ux").expect("a probe of the points");
    assert!(probes.get("tank.fx").is_some() && tip.iter().all(|u| u.abs() < 1e-12), "{tip:?}");
    let push = probes.get("gate.fx").expect("a probe of the points")[1..].to_vec();
    let windows = outputs.table("windows.csv");
    let applied = windows.get("force_applied_x").expect("a column");
    for (one, other) in push.iter().zip(applied) {
        assert!((one - other).abs() <= 1e-12 * other.abs() && *one > 0.0, "{one} {other}");
    }
    // The first row is the state at the start with its pressure: the bed carries the water's weight.
    let carried = probes.get("tank.fy").expect("a probe of the fluid");
    assert!((carried[0] / carried[1] - 1.0).abs() < 0.2 && carried[0] < -10.0, "{:?}", &carried[..2]);

    // A constant load on the real structure: 100 kPa/m on 0.005 m x 0.079 m push with 39.5 N, and with as
    // much for their length on the three rows that are fixed above, of 0.079 m/32 each.
    let load = mock(Role::Fluid, "constant gradient=-1e5,0");
    let ended = bench.start_run("loaded", &[&COARSE, ["--set", &load].as_slice()].concat()).wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    let outputs = bench.outputs("loaded");
    let force = outputs.table("probes.csv").get("gate.fx").expect("a probe of the structure").to_vec();
    // Before the first window no fluid has been heard of: that is not a force of zero.
    assert!(force[0].is_nan() && force[1..].iter().all(|force| force.is_finite()), "{force:?}");
    let held = *force.last().expect("windows");
    // The lattice tiles the box exactly, and the constant load has passed the relaxation.
    let expected = 39.5 * 35.0 / 32.0;
    assert!((held - expected).abs() < expected * 1e-6, "{held}");

    let in_process =
        bench.start_run("refused", &[&COARSE, ["--set", &load, "--in-process"].as_slice()].concat());
    refused(&in_process.wait(), 1, &["fluid", "participant", "leave out --in-process"]);
    assert!(!bench.path("refused").exists());
}

#[test]
fn a_participant_may_be_started_by_hand() {
    let bench = Bench::new();
    let reference = bench.coarse_gate("reference", &[]);
    let by_hand = ["--set", "structure.participant.start=by-hand"];
    let run = bench.start_run("out", &[&COARSE, by_hand.as_slice()].concat());
    let line = crate::support::until("the coupler's call", || {
        let errors = run.printed("err");
        errors
            .ends_with('\n')
            .then(|| errors.lines().find(|l| l.contains("waiting for the structure")).map(str::to_owned))?
    });
    let mut structure = bench.command(&["structure"]);
    for word in line.split([' ', ',']).filter(|word| word.starts_with("MENISCUS_")) {
        let (key, value) = word.split_once('=').expect("a variable and its value");
        structure.env(key, value);
    }
    let structure = crate::support::Running::spawn(structure, &bench.path("structure"));
    let (ended, structure) = (run.wait(), structure.wait());
    assert_eq!(structure.status.code(), Some(0), "{}", structure.errors);
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    // `start` is a key of the case, but of no result.
    crate::support::assert_same(&reference, &bench.outputs("out"));
}

/// Both versions of the standard, the same to the bit when exported again; names of an archive's members
/// stand in it as they are.
#[test]
fn the_structure_of_a_case_is_exported_as_a_unit() {
    let bench = Bench::new();
    for (version, own) in [("3", "terminalsAndIcons/terminalsAndIcons.xml"), ("2", "resources/points.toml")] {
        let files = ["first.fmu", "second.fmu"].map(|name| bench.path(name).display().to_string());
        for file in &files {
            let ended = bench.call(&["export-fmu", "cases/oscillating_plate", "--fmi", version, "-o", file]);
            assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
            assert!(ended.text.contains("1000 interface particles"), "{}", ended.text);
        }
        let [first, second] = files.map(|file| fs::read(file).expect("an archive"));
        assert!(first == second, "FMI {version}");
        for member in ["modelDescription.xml", "resources/case.toml", "documentation/index.html", own] {
            let found = first.windows(member.len()).any(|bytes| bytes == member.as_bytes());
            assert!(found, "{member} is not in the unit for FMI {version}");
        }
    }
    // Scalars in FMI 3.0 too; as a system with the unit's connectors. What is asked for and cannot be is
    // told.
    let system = bench.path("plate.ssp").display().to_string();
    let words = ["export-fmu", "cases/oscillating_plate", "-o", &system];
    refused(&bench.call(&words), 1, &["SSP 1.0 has no arrays", "--scalars"]);
    refused(&bench.call(&[&words, ["--points", "4"].as_slice()].concat()), 1, &["--points is for scalar"]);
    let scalars = ["--scalars", "--points", "5000", "--set", "case.particle_spacing=6.6e-3"];
    let ended = bench.call(&[words.as_slice(), &scalars].concat());
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    assert!(ended.errors.contains("warning: --points 5000: the unit has"), "{}", ended.errors);
    let mut archive = zip::ZipArchive::new(fs::File::open(&system).expect("a file")).expect("an archive");
    let described = archive.by_name("SystemStructure.ssd").expect("a description");
    let described = std::io::read_to_string(described).expect("text");
    for connector in
        ["point[1].force.x\" kind=\"input", "tip.uy\" kind=\"output", "density\" kind=\"parameter"]
    {
        assert!(
            described.matches(&format!("<ssd:Connector name=\"{connector}\"")).count() == 2,
            "{connector}"
        );
    }
    let mut unit = Vec::new();
    let mut member = archive.by_name("resources/structure.fmu").expect("the unit");
    std::io::Read::read_to_end(&mut member, &mut unit).expect("it can be read");
    let members = zip::ZipArchive::new(std::io::Cursor::new(unit)).expect("an archive");
    assert!(members.file_names().any(|name| name == "modelDescription.xml"));
    let alone = bench.call(&["export-fmu", "cases/hydrostatic_tank"]);
    refused(&alone, 1, &["the case has no structure"]);
}

/// Water that leans on a plate whose middle is held by a clamp, of particles twice as coarse or twice as fine
/// as the fluid's: nothing comes through, and the load is the water's.
#[test]
fn clamped_parts_and_structures_of_any_spacing_hold_the_water() {
    const LEANING: &str = r#"
[case]
title = "water beside a plate held in its middle"
dimension = 2
end_time = 0.15
output_interval = 0.05
gravity = [0.0, -9.81]
particle_spacing = 0.01
threads = 1

[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
domain = { low = [-0.3, -0.1], high = [0.5, 0.6] }

[[fluid.region]]
name = "water"
box = { low = [-0.2, 0.0], high = [0.0, 0.2] }

[[fluid.wall]]
name = "tank"
polyline = [[-0.2, 0.4], [-0.2, 0.0], [0.4, 0.0]]
solid_side = "right"

[structure]
[structure.numerics]
gradient = "first-order"

[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 1e8
poisson_ratio = 0.3
density = 1000.0

[[structure.body]]
name = "plate"
box = { low = [0.0, 0.0], high = [0.04, 0.24] }

[[structure.clamp]]
name = "low"
body = "plate"
face = "bottom"

[[structure.clamp]]
name = "middle"
body = "plate"
box = { low = [-0.01, 0.0799], high = [0.05, 0.1201] }

[[structure.clamp]]
name = "up"
body = "plate"
face = "top"

[[probe]]
name = "load"
on = "structure"
quantity = "force"
"#;
    let bench = Bench::new();
    let case = bench.path("leaning.toml").display().to_string();
    fs::write(&case, LEANING).expect("a case");
    for spacing in ["0.02", "0.01", "0.005"] {
        let out = bench.path(spacing);
        let spacing = format!("structure.particle_spacing={spacing}");
        let ended = bench.call(&[
            "run",
            &case,
            "--in-process",
            "--set",
            &spacing,
            "--out",
            &out.display().to_string(),
        ]);
        assert_eq!(ended.status.code(), Some(0), "{spacing} {}{}", ended.text, ended.errors);
        let probes = fs::read_to_string(out.join("probes.csv")).expect("a table");
        // Names, and the start, when the structure has not heard of the water.
        let loads = probes.lines().skip(2).map(|row| {
            let mut values = row.split(',').map(|value| value.parse::<f64>().expect("a number"));
            (values.next().expect("a time"), values.next().expect("a load"))
        });
        let late: Vec<f64> = loads.filter(|(time, _)| *time > 0.1).map(|(_, load)| load).collect();
        let mean = late.iter().sum::<f64>() / late.len() as f64;
        // ½ ρ g H² = 196.2 N.
        assert!((mean / 196.2 - 1.0).abs() < 0.02, "{spacing}: {mean} N");
    }
}

/// A heavy block that runs through a bed, since solids do not meet: water between the two ends inside one of
/// them. That is a failure with place and time, unless the case says that lost particles count for nothing.
#[test]
fn lost_particles_end_a_run() {
    const LEAKING: &str = r#"
[case]
title = "a block that runs through a bed"
dimension = 2
end_time = 0.004
output_interval = 0.004
gravity = [0.0, -9.81]
particle_spacing = 0.01
threads = 1

[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
domain = { low = [-0.2, -0.2], high = [0.5, 0.6] }

[[fluid.region]]
name = "water"
box = { low = [0.0, 0.0], high = [0.3, 0.05] }

[[fluid.wall]]
name = "tank"
polyline = [[0.0, 0.5], [0.0, 0.0], [0.3, 0.0], [0.3, 0.5]]
solid_side = "right"

[structure]
[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 1e9
poisson_ratio = 0.3
density = 1e5

[[structure.body]]
name = "block"
box = { low = [0.1, 0.06], high = [0.2, 0.12] }
velocity = [0.0, -20.0]
"#;
    let bench = Bench::new();
    let case = bench.path("leaking.toml").display().to_string();
    fs::write(&case, LEAKING).expect("a case");
    let ended =
        bench.call(&["run", &case, "--in-process", "--out", &bench.path("lost").display().to_string()]);
    assert_eq!(ended.status.code(), Some(1), "{}{}", ended.text, ended.errors);
    for word in ["the fluid failed", "was lost at [", "lost_particles"] {
        assert!(ended.errors.contains(word), "`{word}` is not in: {}", ended.errors);
    }
    let counted = "fluid.numerics.lost_particles=counted";
    let out = bench.path("counted").display().to_string();
    let ended = bench.call(&["run", &case, "--in-process", "--set", counted, "--out", &out]);
    assert_eq!(ended.status.code(), Some(0), "{}{}", ended.text, ended.errors);
}

/// Every template is a case without a mistake, which runs.
#[test]
fn new_cases_are_sound_and_run() {
    let bench = Bench::new();
    for template in ["dam-break", "tank", "plate", "coupled"] {
        let folder = bench.path(template).display().to_string();
        let ended = bench.call(&["new", &folder, "--template", template]);
        assert_eq!(ended.status.code(), Some(0), "{template}: {}", ended.errors);
        let ended = bench.call(&["check", &folder]);
        assert_eq!(ended.status.code(), Some(0), "{template}: {}", ended.errors);
        assert!(
            ended.text.trim_end().ends_with(": no mistakes found"),
            "the verdict is last: {}",
            ended.text
        );
        let out = format!("{template}-out");
        let ended = bench.start_run(&out, &[&folder, "--end-time", "0.0007", "--no-report"]).wait();
        assert_eq!(ended.status.code(), Some(0), "{template}: {}", ended.errors);
        // The end is before the first output: there is one, at the end.
        let windows = bench.outputs(&out).table("windows.csv");
        assert_eq!(windows.get("time").and_then(|times| times.last()), Some(&0.0007));
    }
    let folder = bench.path("plate").display().to_string();
    let ended = bench.call(&["new", &folder]);
    assert_eq!(ended.status.code(), Some(1), "a case that is there is not overwritten");
}

/// A place without water has no value: an empty cell, and nothing in the summary.
#[test]
fn probes_without_water_say_nothing() {
    let bench = Bench::new();
    let folder = bench.path("dam").display().to_string();
    bench.call(&["new", &folder]);
    let file = bench.path("dam").join("case.toml");
    let mut text = fs::read_to_string(&file).expect("a case");
    for (name, rest) in [
        ("dry", "quantity = \"pressure\"\nat = [0.9, 0.9]"),
        ("speed", "quantity = \"velocity\"\nat = [0.9, 0.9]"),
        ("box", "quantity = \"extent\"\nbox = { low = [0.8, 0.8], high = [1.0, 1.0] }"),
        ("middle", "quantity = \"centroid\"\nbox = { low = [0.8, 0.8], high = [1.0, 1.0] }"),
        ("spread", "quantity = \"spread\"\nbox = { low = [0.8, 0.8], high = [1.0, 1.0] }"),
    ] {
        text.push_str(&format!("\n[[probe]]\nname = \"{name}\"\non = \"fluid\"\n{rest}\n"));
    }
    fs::write(&file, text).expect("a case");
    let ended = bench.start_run("out", &[&folder, "--end-time", "0.002"]).wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    let outputs = bench.outputs("out");
    let probes = outputs.table("probes.csv");
    for name in ["dry.p", "speed.vx", "speed.vy", "box.x_min", "middle.x", "spread.x"] {
        let found = probes.iter().find(|(column, _)| column.split('.').next() == name.split('.').next());
        let (column, values) = found.expect("a column");
        assert!(values.iter().all(|value| value.is_nan()), "{column}: {values:?}");
        assert!(!outputs.summary().probes.contains_key(column));
    }
    let text = fs::read_to_string(bench.path("out").join("probes.csv")).expect("a table");
    assert!(!text.contains("NaN") && text.lines().last().is_some_and(|line| line.ends_with(",,")), "{text}");
}
