//! A unit that another hand wrote in C, as a participant: the contract, the physics, and what does not fit.

mod spring_unit;

use coupler::schedule::Schedule;
use coupler::schemes::serial_explicit::SerialExplicit;
use coupler::schemes::{Coupled, Onward, Pair, Run};
use coupler::side::Side;
use interfaces::case::Case;
use interfaces::case::coupling::StructureVelocity::Mean;
use interfaces::port::names;
use interfaces::{Guarded, Participant, Role, SubSteps};
use partners::{build, conformance};
use spring_unit::{Spring, case_text};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A case whose structure a unit solves.
fn case(participant: &str) -> Case {
    case_of("{ start = \"by-hand\" }", participant)
}

fn case_of(fluid: &str, structure: &str) -> Case {
    let text = case_text(fluid, structure, 1.0, "");
    Case::parse(&text, Path::new("/case.toml"), &[], &[]).unwrap_or_else(|errors| panic!("{errors}"))
}

struct Workshop {
    folder: TempDir,
    count: std::cell::Cell<u32>,
}

impl Workshop {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a folder"), count: std::cell::Cell::new(0) }
    }

    fn unit(&self, spring: Spring) -> PathBuf {
        spring.build(self.folder.path())
    }

    /// Opens the unit of a case in a folder of its own.
    fn open(&self, case: &Case) -> Result<Box<dyn Participant>, fmu_host::Error> {
        self.open_side(case, Role::Structure)
    }

    fn open_side(&self, case: &Case, role: Role) -> Result<Box<dyn Participant>, fmu_host::Error> {
        self.count.set(self.count.get() + 1);
        fmu_host::open(case, role, &self.folder.path().join(self.count.get().to_string()))
    }
}

#[test]
fn it_keeps_the_contract() {
    let workshop = Workshop::new();
    for version in [2, 3] {
        let spring = Spring::of(version);
        let unit = workshop.unit(spring);
        let case = case(&spring.participant(&unit, "stiffness = 400"));
        let make = || workshop.open(&case).expect("a unit");
        conformance::check(make, &conformance::Options::default())
            .unwrap_or_else(|broken| panic!("FMI {version}: {broken}"));
        // Whatever a participant unpacks goes with it.
        let left = walk(workshop.folder.path()).filter(|file| file.ends_with("modelDescription.xml")).count();
        assert_eq!(left, 0);
    }
}

fn walk(folder: &Path) -> Box<dyn Iterator<Item = PathBuf>> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    Box::new(
        entries.flat_map(|path| if path.is_dir() { walk(&path) } else { Box::new(std::iter::once(path)) }),
    )
}

/// Five points of 0.1 kg with 0.5 kg of fluid that rides on them: the mock of the same equation, in Rust, and
/// the unit, in C, move alike.
#[test]
fn it_moves_as_the_mock_of_its_equation() {
    let tip = |structure: Box<dyn Participant>| {
        let side = |participant| Side::new(Box::new(Guarded::new(participant)));
        let fluid = build("added-mass-column mass=0.5 wall=compliant gravity=9.81").expect("a mock");
        let pair = Pair::initialize(side(fluid), side(structure), 0.0, Mean).expect("they fit");
        let mut path = Vec::new();
        let explicit = SerialExplicit { relaxation: 1.0, enforce: true, predict: true };
        let mut driven = Run {
            solver: Coupled::new(pair, explicit),
            schedule: Schedule::new(0.0, 0.5, 0.1, 0.004, SubSteps::Fixed(10)),
        };
        let ended = driven.drive(|_, Coupled { pair, .. }| {
            path.push(pair.structure.outputs.get(names::POSITION).expect("given")[1]);
            Ok(Onward::Continue)
        });
        ended.expect("nothing fails");
        path
    };
    let mock = build("spring-mass points=5 spacing=0.01 density=1000 stiffness=400 integration=rk4")
        .expect("a mock");
    let expected = tip(mock);
    let workshop = Workshop::new();
    for version in [2, 3] {
        let spring = Spring::of(version);
        let unit = workshop.unit(spring);
        let found = tip(workshop.open(&case(&spring.participant(&unit, "stiffness = 400"))).expect("a unit"));
        assert_eq!(found.len(), expected.len());
        // It sinks and swings: 9.81 m/s² of 0.5 kg on 400 N/m are 12 mm at rest.
        assert!(found.iter().any(|y| *y < -0.015), "{found:?}");
        for (n, (one, other)) in found.iter().zip(&expected).enumerate() {
            // The same formulas in another order of sums: round-off of 125 windows.
            assert!((one - other).abs() < 1e-13, "FMI {version}, window {n}: {one} {other}");
        }
    }
}

/// More nodes than the unit starts with: said in configuration mode.
#[test]
fn a_structural_parameter_sizes_its_arrays() {
    let workshop = Workshop::new();
    let spring = Spring::of(3);
    let unit = workshop.unit(spring);
    let case = case(&spring.participant(&unit, "nodes = 12, steps = 3"));
    let options = conformance::Options { points: 12, ..Default::default() };
    let participant = workshop.open(&case).expect("a unit");
    let position = participant.describe().ports.iter().find(|port| port.name == names::POSITION);
    assert_eq!(position.expect("a structure gives it").points, Some(12));
    drop(participant);
    let make = || workshop.open(&case).expect("a unit");
    conformance::check(make, &options).unwrap_or_else(|broken| panic!("{broken}"));
}

#[test]
fn all_that_does_not_fit_is_told_at_once() {
    let workshop = Workshop::new();
    let unit = workshop.unit(Spring::of(3));
    let refused = |participant: &str| match workshop.open(&case(participant)) {
        Ok(_) => panic!("it should be refused"),
        Err(error) => error.to_string(),
    };
    let file = unit.display();
    let words = refused(&format!(
        "{{ fmu = \"{file}\", variables = {{ position = \"R\", velocity = \"stiffness\", pressure_gradient = \"v\", pair_reaction = \"v\", density = \"steps\" }}, parameters = {{ stifness = 1.0, steps = 1.5, kinetic_energy = 1.0 }}, record = [\"energy\"] }}"
    ));
    for expected in [
        "9 place(s)",
        "structure.participant.variables.position: there is no variable `R`; did you mean `r`?",
        "structure.participant.variables.velocity: `stiffness` is a scalar; name an array",
        "structure.participant.variables.pressure_gradient: `v` is no input",
        "structure.participant.variables.pair_reaction: a structure has no such port",
        "structure.participant.variables.density: `steps` is of type Int32",
        "structure.participant.parameters.stifness: there is no variable `stifness`",
        "structure.participant.parameters.steps: 1.5 is no whole number",
        "structure.participant.parameters.kinetic_energy: it is no parameter",
        "structure.participant.record: there is no variable `energy`; did you mean `kinetic_energy`?",
    ] {
        assert!(words.contains(expected), "`{expected}` is not in: {words}");
    }
    let words = refused(&format!("{{ fmu = \"{file}\" }}"));
    assert!(words.contains("variables.position: nothing is behind port `position`"), "{words}");
    assert!(words.contains("`pressure_gradient` or `force`"), "{words}");
    // A pattern of scalars that are not there, in a unit that has none.
    let words = refused(&format!(
        "{{ fmu = \"{file}\", variables = {{ position = \"node[{{point}}].r{{axis}}\" }} }}"
    ));
    assert!(words.contains("there is neither `node[1].rx` nor that of point 0"), "{words}");
}

#[test]
fn a_file_that_is_no_unit_is_named() {
    let workshop = Workshop::new();
    let refused = |file: &Path| {
        let found = workshop.open(&case(&format!("{{ fmu = \"{}\" }}", file.display())));
        found.err().expect("it is refused").to_string()
    };
    let missing = workshop.folder.path().join("missing.fmu");
    let words = refused(&missing);
    assert!(words.contains("missing.fmu") && words.contains("No such file"), "{words}");
    let text = workshop.folder.path().join("text.fmu");
    std::fs::write(&text, "no archive").expect("a file");
    let words = refused(&text);
    assert!(words.contains("failed to unpack the FMU") && words.contains("text.fmu"), "{words}");
}

/// A unit whose state leaves something out would give wrong numbers wherever a window is solved again.
#[test]
fn a_unit_whose_state_is_not_whole_is_found_out() {
    use interfaces::TimeWindow;
    let workshop = Workshop::new();
    for version in [2, 3] {
        let spring = Spring::of(version);
        let unit = workshop.unit(spring);
        let case = case(&spring.participant(&unit, "fault = 6"));
        let mut participant = Guarded::new(workshop.open(&case).expect("a unit"));
        let description = participant.describe().clone();
        let [mut inputs, mut outputs] =
            [interfaces::Direction::In, interfaces::Direction::Out].map(|d| description.fields(d, 5));
        participant.initialize(0.0, &inputs, &mut outputs).expect("it begins");
        inputs.get_mut("pressure_gradient").expect("taken").fill(1e3);
        let window = |iteration| TimeWindow {
            index: 0,
            iteration,
            start: 0.0,
            size: 0.01,
            sub_steps: SubSteps::Fixed(10),
        };
        participant.start(&window(0), &inputs).expect("a first solution");
        participant.finish(&mut outputs).expect("a solution");
        let words = participant.start(&window(1), &inputs).expect_err("it is not whole").to_string();
        for expected in
            ["steps again from the state that it kept", "in window 0", "coupling.prediction = false"]
        {
            assert!(words.contains(expected), "`{expected}` is not in: {words}");
        }
    }
}

/// What the description of a unit makes of a structure's ports, its variables being these.
fn wired(definitions: &str, variables: &str) -> Result<fmu_host::wiring::Wiring, String> {
    let text = format!(
        r#"<fmiModelDescription fmiVersion="3.0" modelName="M" instantiationToken="t"><CoSimulation modelIdentifier="m" canGetAndSetFMUState="true"/><UnitDefinitions>{definitions}</UnitDefinitions><ModelVariables>{variables}</ModelVariables></fmiModelDescription>"#
    );
    let description = fmu_host::description::Description::parse(&text)?;
    let shaken = "[[structure.body]]\nname = \"plate\"\nbox = { low = [0.0, 0.0], high = [0.1, 0.2] }\n\
                  [[structure.clamp]]\nname = \"foot\"\nbody = \"plate\"\nface = \"bottom\"\n\
                  motion = { direction = [1.0, 0.0], speed = 1.0, ramp = 0.1 }\n";
    let text = case_text("{ start = \"by-hand\" }", "{ fmu = \"unit.fmu\" }", 1.0, shaken);
    let case = Case::parse(&text, Path::new("/case.toml"), &[], &[]).unwrap_or_else(|e| panic!("{e}"));
    let unit = fmu_host::participant::unit_of(&case, Role::Structure).expect("it has one");
    fmu_host::wiring::wire(unit, &description, &case, Role::Structure).map_err(|error| error.to_string())
}

/// Three vectors in a plane, with this in their elements.
fn vectors(position: &str, velocity: &str, force: &str) -> String {
    let vector = |name: &str, reference: u32, causality: &str, more: &str| {
        format!(
            r#"<Float64 name="{name}" valueReference="{reference}" causality="{causality}" {more}><Dimension start="3"/><Dimension start="2"/></Float64>"#
        )
    };
    vector("position", 1, "output", position)
        + &vector("velocity", 2, "output", velocity)
        + &vector("force", 3, "input", force)
}

#[test]
fn units_are_converted_or_refused() {
    let definitions = r#"<Unit name="mm"><BaseUnit m="1" factor="1e-3"/></Unit><Unit name="kN"><BaseUnit kg="1" m="1" s="-2" factor="1000"/></Unit><Unit name="K"><BaseUnit K="1"/></Unit>"#;
    let wiring = wired(definitions, &vectors("unit=\"mm\"", "unit=\"m/s\"", "unit=\"kN\"")).unwrap();
    let factor = |name: &str| wiring.wires.iter().find(|wire| wire.port.name == name).unwrap().factor;
    assert_eq!(["position", "velocity", "force"].map(factor), [1e-3, 1.0, 1e3]);
    assert!(wiring.notes.iter().any(|note| note.contains("`position` is in `mm`")), "{:?}", wiring.notes);
    // What the case says of clamps is not what a unit does.
    assert!(wiring.notes.iter().any(|note| note.contains("the clamp \"foot\" moves")), "{:?}", wiring.notes);
    for (position, what) in [
        (
            "unit=\"K\"",
            "variables.position: `position` is in `K`, which is 1e0 kg^0 m^0 s^0 and more; m belongs here",
        ),
        ("unit=\"ft\"", "`position` is in `ft`, of which the unit does not say what it is in SI units"),
    ] {
        let error = wired(definitions, &vectors(position, "", "")).unwrap_err();
        assert!(error.contains(what), "`{what}` is not in: {error}");
    }
}

/// What is recorded and what limits windows is in SI units as well, or told with its own.
#[test]
fn records_and_the_limit_of_windows_are_converted() {
    let definitions = r#"<Unit name="kJ"><BaseUnit kg="1" m="2" s="-2" factor="1000"/></Unit><Unit name="ms"><BaseUnit s="1" factor="1e-3"/></Unit><Unit name="K"><BaseUnit K="1"/></Unit>"#;
    let scalar = |name: &str, reference: u32, unit: &str| {
        format!(r#"<Float64 name="{name}" valueReference="{reference}" causality="output" unit="{unit}"/>"#)
    };
    let variables = |limit: &str| {
        vectors("", "", "")
            + &scalar("kinetic_energy", 4, "kJ")
            + &scalar("strain_energy", 5, "K")
            + &scalar("largest_step", 6, limit)
    };
    let wiring = wired(definitions, &variables("ms")).unwrap();
    let record = |name: &str| {
        let record = wiring.records.iter().find(|record| record.scalar.name == name).unwrap();
        (record.factor, record.scalar.unit.as_str())
    };
    assert_eq!((record("kinetic_energy"), record("strain_energy")), ((1e3, "J"), (1.0, "K")));
    assert!(wiring.notes.iter().any(|note| note.contains("it is recorded as it is")), "{:?}", wiring.notes);
    assert_eq!(wiring.window_limit.unwrap().1, 1e-3);
    let error = wired(definitions, &variables("K")).unwrap_err();
    assert!(error.contains("variables.window_limit: `largest_step` is in `K`"), "{error}");
}

#[test]
fn variables_that_would_lose_a_value_or_claim_too_much_are_refused() {
    let twice = vectors("", "", "") + r#"<Float64 name="force" valueReference="9"/>"#;
    assert!(wired("", &twice).unwrap_err().contains("two variables have the name `force`"));
    let shared = vectors("", "", "")
        + r#"<Float64 name="start_force" valueReference="3" causality="input"><Dimension start="3"/><Dimension start="2"/></Float64>"#;
    let error = wired("", &shared).unwrap_err();
    assert!(error.contains("(value reference 3) takes a value of `force` already"), "{error}");
    for sizes in ["4000000000000", "18446744073709551615"] {
        let huge = vectors("", "", "").replace("start=\"3\"", &format!("start=\"{sizes}\""));
        let error = wired("", &huge).unwrap_err();
        assert!(error.contains("values are taken at most"), "{error}");
    }
}

/// Archives that lead elsewhere, link, or have no end when they are unpacked.
#[test]
fn a_hostile_archive_is_refused_and_leaves_nothing_elsewhere() {
    use std::io::Write as _;
    use zip::write::SimpleFileOptions;
    let workshop = Workshop::new();
    let elsewhere = workshop.folder.path().join("elsewhere");
    let description = r#"<fmiModelDescription fmiVersion="3.0" modelName="M" instantiationToken="t"><CoSimulation modelIdentifier="m"/><ModelVariables/></fmiModelDescription>"#;
    type Fill = fn(&mut zip::ZipWriter<std::fs::File>);
    let rows: [(&str, Fill); 3] = [
        ("leads out of the folder", |zip| {
            zip.start_file("../elsewhere", SimpleFileOptions::default()).unwrap();
        }),
        ("leads out of the folder", |zip| {
            zip.add_symlink("resources", "/etc", SimpleFileOptions::default()).unwrap();
        }),
        ("unpacked it has more than the 2147483648 bytes", |zip| {
            let zeros = vec![0_u8; 1 << 20];
            zip.start_file("resources/bomb", SimpleFileOptions::default().large_file(true)).unwrap();
            for _ in 0..2049 {
                zip.write_all(&zeros).unwrap();
            }
        }),
    ];
    for (what, fill) in rows {
        let file = workshop.folder.path().join("hostile.fmu");
        let mut archive = zip::ZipWriter::new(std::fs::File::create(&file).unwrap());
        let platform = format!("binaries/x86_64-linux/m.{}", std::env::consts::DLL_EXTENSION);
        for (name, text) in [("modelDescription.xml", description), (platform.as_str(), "")] {
            archive.start_file(name, SimpleFileOptions::default()).unwrap();
            archive.write_all(text.as_bytes()).unwrap();
        }
        fill(&mut archive);
        archive.finish().unwrap();
        let mut archive = fmu_host::archive::Archive::open(&file).unwrap();
        let described = archive.description().unwrap();
        let error = archive.unpack(&described, &workshop.folder.path().join("unpacked")).unwrap_err();
        assert!(error.to_string().contains(what), "{error}");
        assert!(!elsewhere.exists());
    }
}

/// What a unit cannot do is refused with what to do about it.
#[test]
fn a_unit_without_state_solves_no_window_again() {
    use interfaces::TimeWindow;
    let workshop = Workshop::new();
    let window = |index: u64, iteration: u32, size: f64| TimeWindow {
        index,
        iteration,
        start: 0.01 * index as f64,
        size,
        sub_steps: SubSteps::Fixed(10),
    };
    for version in [2, 3] {
        // It says that it has no functions for its state, and has none.
        let define = "WITHOUT_STATE";
        let spring = Spring { keeps_state: false, variable_steps: false, define, ..Spring::of(version) };
        let unit = workshop.unit(spring);
        // Where the case has windows solved again it is refused before it is opened.
        let refused = workshop.open(&case(&spring.participant(&unit, ""))).err().expect("it is refused");
        assert!(refused.to_string().contains("coupling.prediction = false"), "{refused}");
        let case = |structure: &str| {
            let text = case_text("{ start = \"by-hand\" }", structure, 1.0, "[coupling]\nprediction = false");
            Case::parse(&text, Path::new("/case.toml"), &[], &[]).unwrap_or_else(|errors| panic!("{errors}"))
        };
        let mut participant =
            Guarded::new(workshop.open(&case(&spring.participant(&unit, ""))).expect("a unit"));
        let description = participant.describe().clone();
        let [inputs, mut outputs] =
            [interfaces::Direction::In, interfaces::Direction::Out].map(|d| description.fields(d, 5));
        participant.initialize(0.0, &inputs, &mut outputs).expect("it begins");
        for index in 0..2 {
            participant.start(&window(index, 0, 0.01), &inputs).expect("a first solution");
            participant.finish(&mut outputs).expect("a solution");
            participant.accept(None).expect("it is taken");
        }
        let words = participant.save().expect_err("it cannot be saved").to_string();
        assert!(words.contains("canSerializeFMUState is false"), "{words}");
        let mut participant =
            Guarded::new(workshop.open(&case(&spring.participant(&unit, ""))).expect("a unit"));
        participant.initialize(0.0, &inputs, &mut outputs).expect("it begins");
        participant.start(&window(0, 0, 0.01), &inputs).expect("a first solution");
        participant.finish(&mut outputs).expect("a solution");
        let words = participant.start(&window(0, 1, 0.01), &inputs).expect_err("not again").to_string();
        assert!(words.contains("coupling.prediction = false"), "{words}");
        let mut participant =
            Guarded::new(workshop.open(&case(&spring.participant(&unit, ""))).expect("a unit"));
        participant.initialize(0.0, &inputs, &mut outputs).expect("it begins");
        participant.start(&window(0, 0, 0.01), &inputs).expect("a first solution");
        participant.finish(&mut outputs).expect("a solution");
        participant.accept(None).expect("it is taken");
        let words = participant.start(&window(1, 0, 0.005), &inputs).expect_err("another size").to_string();
        assert!(words.contains("steps of one size only") && words.contains("coupling.max_window"), "{words}");
    }
}

/// A step that fails is the end of the participant, with the unit's own words.
#[test]
fn a_step_that_fails_is_told_in_the_units_words() {
    let workshop = Workshop::new();
    for version in [2, 3] {
        let spring = Spring::of(version);
        let unit = workshop.unit(spring);
        let case = case(&spring.participant(&unit, "fault = 1, fault_time = 0.015"));
        let mut participant = Guarded::new(workshop.open(&case).expect("a unit"));
        let description = participant.describe().clone();
        let [inputs, mut outputs] =
            [interfaces::Direction::In, interfaces::Direction::Out].map(|d| description.fields(d, 5));
        participant.initialize(0.0, &inputs, &mut outputs).expect("it begins");
        let mut solve = |index: u32| {
            let start = 0.01 * f64::from(index);
            let window = interfaces::TimeWindow {
                index: index.into(),
                iteration: 0,
                start,
                size: 0.01,
                sub_steps: SubSteps::Stable,
            };
            participant.start(&window, &inputs)?;
            participant.finish(&mut outputs)?;
            participant.accept(None)
        };
        solve(0).expect("before the fault");
        let words = solve(1).expect_err("the fault").to_string();
        // In FMI 2.0 the unit gives the words, a number and the time for the places of its message.
        let said = ["answered Error: the spring broke of 5 at 0.01", "answered Error: the spring broke"];
        assert!(words.contains("DoStep") && words.contains(said[version as usize - 2]), "{words}");
    }
}

/// A unit as the fluid: it takes what a structure gives, volumes once, and its drag makes a mass on a spring
/// swing out as the damped one does.
#[test]
fn a_unit_may_be_the_fluid() {
    let workshop = Workshop::new();
    let unit = spring_unit::drag(workshop.folder.path());
    let case = case_of(&format!("{{ fmu = \"{}\" }}", unit.display()), "{ start = \"by-hand\" }");
    let make = || workshop.open_side(&case, Role::Fluid).expect("a unit");
    conformance::check(make, &conformance::Options::default()).unwrap_or_else(|broken| panic!("{broken}"));

    let side = |participant| Side::new(Box::new(Guarded::new(participant)));
    // 0.5 kg on 400 N/m, 10 cm to the side; five points of 0.5 N s/m.
    let structure = "spring-mass points=5 spacing=0.01 density=1000 stiffness=400 displacement=0.1,0";
    let pair =
        Pair::initialize(side(make()), side(build(structure).expect("a mock")), 0.0, Mean).expect("they fit");
    let explicit = SerialExplicit { relaxation: 1.0, enforce: true, predict: true };
    let mut driven = Run {
        solver: Coupled::new(pair, explicit),
        schedule: Schedule::new(0.0, 1.0, 0.1, 1e-4, SubSteps::Fixed(1)),
    };
    driven.drive(|_, _| Ok(Onward::Continue)).expect("nothing fails");
    let Run { solver: Coupled { pair, .. }, .. } = driven;
    let found = pair.structure.outputs.get(names::POSITION).expect("given")[0];
    // u = u0 exp(-gamma t) (cos wt + gamma/w sin wt), gamma = c/2m = 2.5 1/s, w^2 = k/m - gamma^2.
    let (gamma, omega) = (2.5_f64, (800.0_f64 - 2.5 * 2.5).sqrt());
    let expected = 0.1 * (-gamma).exp() * (omega.cos() + gamma / omega * omega.sin());
    // The drag of a window is that of the mean velocity that was predicted under the last one: first order in
    // windows of 1e-4 s, c dt/m = 5e-4.
    assert!((found - expected).abs() < 1e-3 * 0.1, "{found} {expected}");
}
