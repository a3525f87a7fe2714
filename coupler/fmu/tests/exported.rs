//! The exported structure as a participant: the contract that the native one keeps too, and the same bits.

use interfaces::case::Case;
use interfaces::{Direction, Exchange, Fields, Guarded, Participant, Role, SubSteps, TimeWindow};
use meniscus_structure::description::Version;
use meniscus_structure::package::{Library, export, library_name, this_platform};
use partners::conformance;
use std::cell::Cell;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A plate of 4 × 30 particles, clamped at its left end, that a fluid may load.
const PLATE: &str = r#"
[case]
title = "Plate"
dimension = 2
end_time = 0.1
output_interval = 0.01
particle_spacing = 5e-3
gravity = [0.0, -9.81]
threads = 1

[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
domain = { low = [0.0, 0.0], high = [1.0, 1.0] }
participant = { start = "by-hand" }

[structure]
#participant

[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 2e6
poisson_ratio = 0.4
density = 1000.0

[[structure.body]]
name = "plate"
box = { low = [0.0, -0.01], high = [0.15, 0.01] }

[[structure.clamp]]
name = "root"
body = "plate"
face = "left"

[coupling]
sub_steps = 20

[[probe]]
name = "tip"
on = "structure"
quantity = "displacement"
at = [0.15, 0.0]
"#;

fn case(participant: &str, overrides: &[&str]) -> Case {
    let overrides: Vec<String> = overrides.iter().map(|&setting| setting.to_owned()).collect();
    let text = PLATE.replace("#participant", participant);
    Case::parse(&text, Path::new("/case.toml"), &overrides, &[]).unwrap_or_else(|errors| panic!("{errors}"))
}

/// The shared library that cargo made for these tests.
fn library() -> Library {
    let executable = std::env::current_exe().expect("a test is a file");
    let file = executable.parent().expect("in a folder").join(library_name());
    Library { platform: this_platform(), file }
}

struct Workshop {
    folder: TempDir,
    count: Cell<u32>,
}

impl Workshop {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a folder"), count: Cell::new(0) }
    }

    fn export(&self, version: Version, points: Option<usize>) -> PathBuf {
        let unit = self.folder.path().join(format!("{version:?}-{points:?}.fmu"));
        export(&case("", &[]), version, points, &[library()], &unit).expect("a unit");
        unit
    }

    fn folder(&self) -> PathBuf {
        self.count.set(self.count.get() + 1);
        let folder = self.folder.path().join(self.count.get().to_string());
        std::fs::create_dir(&folder).expect("a folder");
        folder
    }

    fn open(&self, case: &Case) -> Box<dyn Participant> {
        fmu_host::open(case, Role::Structure, &self.folder()).unwrap_or_else(|error| panic!("{error}"))
    }

    fn native(&self, case: &Case) -> Box<dyn Participant> {
        structure::participant::from_case(case, &self.folder()).expect("a structure")
    }
}

/// Windows that the sub-steps are stable with: 20 of them reach 1.8 ms.
fn options() -> conformance::Options<'static> {
    conformance::Options { size: 2e-4, sub_steps: SubSteps::Fixed(20), ..Default::default() }
}

#[test]
fn unit_and_native_participant_keep_the_same_contract() {
    let workshop = Workshop::new();
    let own = case("", &[]);
    conformance::check(|| workshop.native(&own), &options())
        .unwrap_or_else(|broken| panic!("native: {broken}"));
    for (version, points) in KINDS {
        let unit = workshop.export(version, points);
        // The case says nothing of its variables.
        let case = case(&format!("participant = {{ fmu = \"{}\" }}", unit.display()), &[]);
        conformance::check(|| workshop.open(&case), &options())
            .unwrap_or_else(|broken| panic!("{version:?}, {points:?}: {broken}"));
    }
}

/// What a case can be exported as.
const KINDS: [(Version, Option<usize>); 3] =
    [(Version::Fmi3, None), (Version::Fmi3, Some(4)), (Version::Fmi2, Some(4))];

/// What an importer sees without stepping: probes are outputs, numbers have ranges and sizes, and points say
/// where they lie.
#[test]
fn the_description_of_an_exported_unit_says_what_its_variables_are() {
    use fmu_host::description::{Causality, Description};
    let workshop = Workshop::new();
    for (version, points) in KINDS {
        let unit = std::fs::File::open(workshop.export(version, points)).expect("a unit");
        let mut archive = zip::ZipArchive::new(unit).expect("an archive");
        let mut text = |name: &str| {
            let member = archive.by_name(name).ok()?;
            Some(std::io::read_to_string(member).expect("text"))
        };
        let described = text("modelDescription.xml").expect("a description");
        let found = Description::parse(&described).expect("a description that can be read");
        let probe = found.variable("tip.uy").expect("the case's probe");
        assert_eq!(probe.causality, Causality::Output, "{version:?}");
        let energy = found.variable("kinetic_energy").expect("an energy");
        assert_eq!(energy.causality, Causality::Local, "{version:?}");
        let element = |name: &str| {
            let at = described.find(&format!("name=\"{name}\"")).unwrap_or_else(|| panic!("no {name}"));
            described[at..].lines().next().unwrap_or_default()
        };
        let ratio = element("poisson_ratio");
        assert!(ratio.contains("min=\"-1.0\" max=\"0.5\" nominal=\"0.4\""), "{ratio}");
        assert!(element("sub_steps").contains("min=\"0\""));
        if let Some(points) = points {
            // The farthest from the middle of the plate comes first: a corner particle of 4 layers 5 mm
            // apart, any.
            let force = element("point[1].force.x");
            let (_, at) = force.split_once("of the material at (").expect("a place");
            assert!(at.starts_with("0.1475, ") || at.starts_with("0.0025, "), "{force}");
            assert!(at.contains("0.0075) m at the start"), "{force}");
            let far = element("point[1].position.x");
            assert!(far.contains("nominal=\"0.1475\""), "{far}");
            assert!(found.variable(&format!("point[{}].force.x", points + 1)).is_none());
        }
        let terminals = text("terminalsAndIcons/terminalsAndIcons.xml");
        assert_eq!(terminals.is_some(), version == Version::Fmi3);
        let member = if points.is_some() { "point[2].velocity.y" } else { "velocity" };
        assert!(terminals.is_none_or(|xml| xml.contains(&format!("variableName=\"{member}\""))));
    }
}

/// What a life of windows, some of them solved twice, gave: all fields and numbers, as bits.
fn life(participant: Box<dyn Participant>) -> Vec<Vec<u64>> {
    let mut participant = Guarded::new(participant);
    let description = participant.describe().clone();
    let [mut inputs, mut outputs] = [Direction::In, Direction::Out].map(|d| description.fields(d, 0));
    let bits = |fields: &Fields, numbers: &[f64]| -> Vec<u64> {
        let mut ports: Vec<_> = fields.iter().collect();
        ports.sort_by(|one, other| one.0.name.cmp(&other.0.name));
        let fields = ports.into_iter().filter(|(port, _)| port.exchange == Exchange::EveryWindow);
        fields.flat_map(|(_, array)| array).chain(numbers).map(|value| value.to_bits()).collect()
    };
    // The scalars that both have: energies and the probe.
    let shared = 7;
    let ready = participant.initialize(0.0, &inputs, &mut outputs).expect("it begins");
    assert!(ready.window_limit < 1e-2, "{}", ready.window_limit);
    let mut found = vec![bits(&outputs, &[&ready.scalars[..shared], &[ready.window_limit]].concat())];
    let mut start = 0.0;
    for index in 0..8_u64 {
        let size = [2e-4, 1e-4, 1.7e-4][index as usize % 3];
        for iteration in 0..=(index as u32 % 2) {
            conformance::plausible(start, iteration, &mut inputs);
            let window = TimeWindow { index, iteration, start, size, sub_steps: SubSteps::Fixed(20) };
            participant.start(&window, &inputs).expect("it solves");
            let report = participant.finish(&mut outputs).expect("it solved");
            let numbers = [f64::from(report.sub_steps), report.window_limit];
            found.push(bits(&outputs, &[&report.scalars[..shared], &numbers].concat()));
        }
        participant.accept(None).expect("it is taken");
        start += size;
    }
    found
}

#[test]
fn unit_and_native_participant_give_the_same_bits() {
    let workshop = Workshop::new();
    let unit = workshop.export(Version::Fmi3, None);
    let participant = format!("participant = {{ fmu = \"{}\" }}", unit.display());
    let native = life(workshop.native(&case("", &[])));
    assert_eq!(life(workshop.open(&case(&participant, &[]))), native);
    // With a parameter of the unit in the place of a key of the case.
    let softer = participant.replace("\" }", "\", parameters = { youngs_modulus = 1e6 } }");
    let native_softer = life(workshop.native(&case("", &["structure.material.youngs_modulus=1e6"])));
    assert_ne!(native_softer, native);
    assert_eq!(life(workshop.open(&case(&softer, &[]))), native_softer);
}
