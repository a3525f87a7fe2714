//! What the case file promises: shipped cases load, what is resolved reads back, overrides reach every key,
//! and the docs tell of all.

mod mistakes;
mod rows;

use interfaces::SubSteps;
use interfaces::case::fluid::Slip;
use interfaces::case::participant::Start;
use interfaces::case::probe::ProbeTarget;
use interfaces::case::structure::ClampRegion;
use interfaces::case::{Case, CaseErrors, Sections, array, docs, region, schema, velocity};
use std::path::{Path, PathBuf};

/// What our own solvers bring to the case file.
pub const SECTIONS: [Sections; 2] = [fluid::participant::SECTIONS, structure::participant::SECTIONS];

/// A small coupled case in which everything is right.
const SOUND: &str = r#"[case]
title = "Column on a plate"
dimension = 2
end_time = 0.1
output_interval = 0.01
gravity = [0.0, -9.81]
particle_spacing = 0.01

[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
domain = { low = [-0.1, -0.2], high = [1.1, 1.0] }

[[fluid.region]]
name = "water"
box = { low = [0.0, 0.0], high = [1.0, 0.5] }

[[fluid.wall]]
name = "left"
polyline = [[0.0, 0.8], [0.0, 0.0]]
solid_side = "right"

[[fluid.wall]]
name = "right"
box = { low = [1.0, -0.1], high = [1.1, 0.8] }

[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 1e6
poisson_ratio = 0.3
density = 2700.0

[[structure.body]]
name = "plate"
box = { low = [0.0, -0.05], high = [1.0, 0.0] }

[[structure.clamp]]
name = "right-end"
body = "plate"
face = "right"

[[structure.load]]
name = "push"
body = "plate"
face = "bottom"
force = [0.0, 10.0]
ramp = [[0.0, 0.0], [0.01, 1.0]]

[[probe]]
name = "middle"
on = "structure"
quantity = "displacement"
at = [0.5, 0.0]

[[reference]]
probe = "middle.uy"
label = "static"
source = "by hand"
time = [0.05, 0.1]
value = [-1e-3, -1e-3]
"#;

fn parse(text: &str, overrides: &[&str]) -> Result<Case, CaseErrors> {
    let overrides: Vec<_> = overrides.iter().map(ToString::to_string).collect();
    Case::parse(text, Path::new("case.toml"), &overrides, &SECTIONS)
}

/// The sound case with one passage changed.
fn changed(from: &str, to: &str) -> String {
    assert!(SOUND.contains(from), "the sound case has no {from:?}");
    SOUND.replacen(from, to, 1)
}

fn mistakes(result: Result<Case, CaseErrors>) -> Vec<String> {
    match result {
        Ok(_) => Vec::new(),
        Err(errors) => errors.errors.iter().map(ToString::to_string).collect(),
    }
}

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("cases").join(name)
}

#[test]
fn shipped_cases_load_and_what_is_resolved_reads_back() {
    for name in [
        "dam_break",
        "elastic_gate",
        "elliptical_drop",
        "hydrostatic_tank",
        "oscillating_plate",
        "standing_wave",
        "taylor_green",
        "sloshing_baffle",
        "viscous_wave",
    ] {
        let case = Case::load(&shipped(name), &[], &SECTIONS).unwrap();
        let again = parse(&case.to_toml(), &[]).unwrap();
        assert_eq!(case, again, "{name}:\n{}", case.to_toml());
        assert_eq!(case.hash(), again.hash());
        let opaque = Case::parse(&case.to_toml(), Path::new("case.toml"), &[], &[]).unwrap();
        assert_eq!(opaque, case, "who has none of the solvers reads the same");
    }
}

#[test]
fn the_gate_is_as_the_benchmark_has_it() {
    let case = Case::load(&shipped("elastic_gate").join("case.toml"), &[], &SECTIONS).unwrap();
    let (fluid, structure) = (case.fluid.unwrap(), case.structure.unwrap());
    assert_eq!(fluid.regions[0].shape().unwrap().lattice_counts(fluid.particle_spacing), [80, 112]);
    assert_eq!(structure.bodies[0].bounds.lattice_counts(structure.particle_spacing), [4, 63]);
    assert_eq!(structure.bodies[0].bounds.particle_count(structure.particle_spacing), 4 * 63);
    // √(9.81 · 0.14)
    assert!((fluid.characteristic_speed - 1.171_921_499).abs() < 1e-9);
    assert_eq!(fluid.max_time_step, 0.005);
    let columns: Vec<_> = case.probes.iter().flat_map(|probe| probe.columns(2)).collect();
    assert_eq!(columns, ["tip.ux", "tip.uy", "gate.fx", "gate.fy", "tank.fx", "tank.fy", "corner.p"]);
    let rows = structure.clamps[0].rows_box(&structure.bodies[0].bounds, 0.00125).unwrap();
    assert_eq!((rows.low, rows.high), (vec![0.1, 0.079], vec![0.105, 0.079 + 3.0 * 0.00125]));
}

#[test]
fn defaults_are_filled_in() {
    let case = parse(SOUND, &[]).unwrap();
    let (fluid, structure, coupling) =
        (case.fluid.unwrap(), case.structure.unwrap(), case.coupling.expect("there are both sides"));
    assert_eq!(fluid.particle_spacing, 0.01);
    assert_eq!(fluid.regions[0].velocity, region::FluidVelocity::Uniform(vec![0.0, 0.0]));
    assert!(fluid.walls[0].polyline.is_some());
    assert!(fluid.walls[1].bounds.is_some());
    assert_eq!(fluid.numerics, toml::Table::try_from(fluid::Options::default()).unwrap());
    assert_eq!(fluid.participant.start(), Start::Own);
    assert_eq!(structure.material["assumption"].as_str(), Some("plane-strain"));
    assert_eq!(
        structure.clamps[0].region(),
        Some(ClampRegion::Face { face: words::geometry::Face::Right, rows: 0 })
    );
    assert_eq!(structure.loads[0].face, Some(words::geometry::Face::Bottom));
    assert_eq!(coupling.sub_steps, SubSteps::Fixed(100));
    assert_eq!(coupling.max_window, 0.01);
    assert_eq!(coupling.deadline, 60.0);
    let body = "plate".to_owned();
    assert_eq!(case.probes[0].target(), ProbeTarget::StructurePoint { body: &body, at: &[0.5, 0.0] });
    assert_eq!(case.references[0].low, case.references[0].value);
}

/// Every form that a key has two of, written and read back.
#[test]
fn every_form_reads_back() {
    let text = changed("face = \"right\"", "box = { low = [0.9, -0.05], high = [1.0, 0.0] }")
        .replacen("face = \"bottom\"", "at = [0.5, -0.05]", 1)
        .replacen("box = { low = [0.0, -0.05]", "velocity = { mode = \"cantilever\", clamped_face = \"right\", tip_velocity = [0, 1] }\nbox = { low = [0.0, -0.05]", 1)
        + r#"
[[structure.load]]
name = "weight"
body = "plate"
force = [0, -1]
[fluid.participant]
start = "by-hand"
[structure.participant]
command = ["mine", "--fast"]
[coupling]
sub_steps = "stable"
[[probe]]
name = "jet"
on = "fluid"
quantity = "velocity"
at = [0.5, 0.2]
[[probe]]
name = "heap"
on = "fluid"
quantity = "extent"
box = { low = [0.0, 0.0], high = [0.5, 0.5] }
[[probe]]
name = "wall"
on = "wall"
wall = "right"
quantity = "force"
[[probe]]
name = "foot"
on = "wall"
wall = "left"
quantity = "pressure"
at = [0.0, 0.0]
[[probe]]
name = "load"
on = "structure"
quantity = "force"
"#;
    let case = parse(&text, &[]).unwrap();
    assert_eq!(parse(&case.to_toml(), &[]).unwrap(), case, "{}", case.to_toml());
    assert_eq!(case.fluid.unwrap().participant.start(), Start::ByHand);
    let structure = case.structure.unwrap();
    assert_eq!(structure.participant.start(), Start::Command(&["mine".to_owned(), "--fast".to_owned()]));
    assert!(matches!(structure.bodies[0].velocity, velocity::InitialVelocity::Mode(_)));
    assert_eq!((structure.loads[1].face, &structure.loads[1].at), (None, &None));
    assert_eq!(case.coupling.unwrap().sub_steps, SubSteps::Stable);
    assert_eq!(case.probes[5].target(), ProbeTarget::Body("plate"));
}

/// What a fluid alone may be: balls, shapes of velocity, periodic sides, walls that move.
#[test]
fn every_form_of_a_fluid_reads_back() {
    let text = r#"
[case]
title = "Fluid"
dimension = 2
end_time = 1
output_interval = 1
particle_spacing = 0.01
[fluid]
density = 1000
kinematic_viscosity = 0
domain = { low = [-1, -1], high = [1, 1] }
periodic = ["x", "y"]
[[fluid.region]]
name = "drop"
ball = { centre = [-0.5, 0], radius = 0.2 }
velocity_gradient = [[-100, 0], [0, 100]]
[[fluid.region]]
name = "vortices"
box = { low = [0, 0], high = [0.5, 0.5] }
velocity = { mode = "taylor-green", speed = 2, wavelength = 0.5 }
wave = { amplitude = 0.01, wavelength = 1 }
[[fluid.wall]]
name = "gate"
box = { low = [0.6, 0], high = [0.7, 1] }
motion = { direction = [0, 1], table = [[0, 0], [1, 0.5]] }
[[fluid.wall]]
name = "flap"
box = { low = [0.8, 0], high = [0.9, 1] }
motion = { pivot = [0.8, 0], amplitude = 0.1, period = 2 }
"#;
    let case = parse(text, &[]).unwrap();
    assert_eq!(parse(&case.to_toml(), &[]).unwrap(), case, "{}", case.to_toml());
    let fluid = case.fluid.unwrap();
    assert_eq!(fluid.characteristic_speed, 20.0);
    assert_eq!(fluid.periodic.iter().map(|axis| axis.index()).collect::<Vec<_>>(), [0, 1]);
    let found = mistakes(parse(
        text,
        &[
            "fluid.wall.gate.motion={ direction = [0, 0], pivot = [0, 0], table = [[1, 0], [0, 1]] }",
            "fluid.wall.flap.motion={ direction = [0, 0], amplitude = 1 }",
            "fluid.region.drop.velocity_gradient=[[1, 0]]",
            "fluid.periodic=[\"z\"]",
        ],
    ));
    for part in [
        "both direction and pivot",
        "not later than the row",
        "is zero",
        "no law",
        "1 rows",
        "three dimensions",
    ] {
        assert!(found.iter().any(|mistake| mistake.contains(part)), "{part}: {found:#?}");
    }
}

/// One motion, named once: by name it is the same case as said on the spot, but for the table of names.
#[test]
fn a_motion_has_a_name_and_is_resolved_where_it_is_used() {
    let named = changed(
        "[fluid]\n",
        "[motion.roll]\npivot = [1.0, 0.0]\namplitude = 0.07\nperiod = 1.2\nstart = 0.1\nramp = 0.2\n[fluid]\n",
    )
    .replacen("name = \"right\"\n", "name = \"right\"\nmotion = \"roll\"\n", 1)
    .replacen("face = \"right\"", "face = \"right\"\nwith_wall = \"right\"", 1)
    .replacen("at = [0.5, 0.0]", "at = [0.5, 0.0]\nrelative_to = \"right\"", 1);
    let case = parse(&named, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(parse(&case.to_toml(), &[]).unwrap(), case, "{}", case.to_toml());
    let roll = &case.motions["roll"];
    let (wall, clamp) = (&case.fluid.as_ref().unwrap().walls[1], &case.structure.as_ref().unwrap().clamps[0]);
    assert_eq!((wall.moves(), clamp.moves(), &clamp.with_wall), (Some(roll), Some(roll), &None));
    assert_eq!(case.frame_of(&case.probes[0]), Some(roll));
    let law = roll.law().expect("it has one");
    assert!(law.at(0.1) == 0.0 && law.rate(0.1) == 0.0 && law.at(0.4) > 0.06);
    let by_clamp = named.replacen("with_wall = \"right\"", "motion = \"roll\"", 1);
    assert_eq!(parse(&by_clamp, &[]).unwrap().hash(), case.hash(), "the same motion by another way");
    assert_ne!(parse(&named, &["motion.roll.ramp=0.3"]).unwrap().hash(), case.hash());
    let unknown = mistakes(parse(&named, &["fluid.wall.right.motion=rol"]));
    assert_eq!(unknown[..1], ["--set: fluid.wall.1.motion = \"rol\": is no motion; did you mean \"roll\"?"]);
    let twice = mistakes(parse(&named, &["structure.clamp.0.name=left", "probe.0.relative_to=left"]));
    let told = "--set: probe.0.relative_to = \"left\": is the name of two that move differently; give each its own name";
    assert_eq!(twice, [told]);
}

#[test]
fn three_dimensions_are_read() {
    let text = r#"
[case]
title = "Cube"
dimension = 3
end_time = 1
output_interval = 1
particle_spacing = 0.1
[structure.material]
law = "neo-hookean"
youngs_modulus = 1e6
poisson_ratio = 0.3
density = 1000
[[structure.body]]
name = "cube"
box = { low = [0, 0, 0], high = [1, 1, 1] }
[[structure.clamp]]
name = "back"
body = "cube"
face = "back"
"#;
    let case = parse(text, &[]).unwrap();
    assert_eq!(case.general.gravity, [0.0; 3]);
    assert_eq!(array::<3>(&case.general.gravity), [0.0; 3]);
    assert!(case.coupling.is_none());
    let structure = case.structure.as_ref().unwrap();
    assert_eq!(structure.material["assumption"].as_str(), Some("three-dimensional"));
    assert_eq!(structure.bodies[0].bounds.particle_count(0.1), 1000);
    assert_eq!(parse(&case.to_toml(), &[]).unwrap(), case);
}

#[test]
fn overrides_reach_every_key() {
    let case = parse(
        SOUND,
        &[
            "case.end_time=1",
            "fluid.wall.left.slip=no-slip",
            "fluid.wall.1.slip=\"no-slip\"",
            "case.gravity.1 = -1.62",
            "fluid.region.water.box.high=[1.0, 0.4]",
            "coupling.sub_steps=stable",
            "fluid.numerics.courant=0.1",
            "case.title=One day on the moon",
        ],
    )
    .unwrap();
    assert_eq!(case.general.end_time, 1.0);
    assert_eq!(case.general.gravity, [0.0, -1.62]);
    assert_eq!(case.general.title, "One day on the moon");
    let fluid = case.fluid.unwrap();
    assert!(fluid.walls.iter().all(|wall| wall.slip == Slip::NoSlip));
    assert_eq!(fluid.regions[0].shape().unwrap().high, [1.0, 0.4]);
    assert_eq!(fluid.numerics["courant"].as_float(), Some(0.1));
    assert_eq!(case.coupling.unwrap().sub_steps, SubSteps::Stable);
}

#[test]
fn overrides_are_checked_like_the_file() {
    let rows = [
        ("fluid.densty=3", "--set: fluid.densty = 3: there is no such key; did you mean \"density\"?"),
        ("fluid.density=-3", "--set: fluid.density = -3: must be over 0; its meaning: density (kg/m³)"),
        (
            "fluid.density=heavy",
            "--set: fluid.density = \"heavy\": is a string, but must be a number; its meaning: density (kg/m³)",
        ),
        (
            "fluid.wall.middle.slip=no-slip",
            "--set: fluid.wall = (2 sections): has no element \"middle\"; write 0 to 1, or \"left\", \"right\"",
        ),
        (
            "fluid.density.x=1",
            "--set: fluid.density = 1000.0: is no section, but 1000.0; set the key itself, without a key below it",
        ),
        ("fluid.density", "--set: \"fluid.density\" has no \"=\"; write --set section.key=value"),
        ("fluid..density=1", "--set: \"fluid..density\" is no key; write --set section.key=value"),
    ];
    for (setting, expected) in rows {
        assert_eq!(mistakes(parse(SOUND, &[setting])), [expected], "{setting}");
    }
}

#[test]
fn the_hash_is_of_what_is_resolved() {
    let hash = |overrides: &[&str]| parse(SOUND, overrides).unwrap().hash();
    let plain = hash(&[]);
    assert_eq!(plain.len(), 64);
    assert_eq!(plain, parse(&format!("# a comment\n{SOUND}"), &[]).unwrap().hash(), "comments do not count");
    assert_eq!(plain, hash(&["coupling.sub_steps=100"]), "a default written out is the same case");
    assert_eq!(plain, hash(&["case.threads=1"]), "no result depends on the threads");
    assert_ne!(plain, hash(&["fluid.density=1000.0000000000001"]), "the last digit counts");
    assert_ne!(plain, hash(&["fluid.wall.left.slip=no-slip"]));
    assert_ne!(plain, hash(&["fluid.numerics.courant=0.1"]), "a section of a solver is hashed as it is");
    for where_only in [
        "case.title=Another",
        "fluid.participant.start=by-hand",
        "fluid.participant.command=[\"/opt/mine\", \"--fast\"]",
    ] {
        assert_eq!(plain, hash(&[where_only]), "{where_only}: no participant depends on it");
    }
    let unit = |file: &str, value: u32| {
        hash(&[&format!("structure.participant={{ fmu = \"{file}\", parameters = {{ nodes = {value} }} }}")])
    };
    assert_eq!(unit("a.fmu", 1), unit("/elsewhere/a.fmu", 1), "where the unit is does not count");
    assert_ne!(unit("a.fmu", 1), unit("a.fmu", 2), "its parameters do");
}

/// Schema and tables of keys in the docs are those of the types. `MENISCUS_REWRITE=1` makes them anew.
#[test]
fn the_docs_are_what_the_types_say() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let schema = schema(&SECTIONS);
    let page = std::fs::read_to_string(folder.join("case-file.md")).unwrap();
    let files = [
        ("case.schema.json", format!("{schema:#}\n")),
        ("case-file.md", docs::filled(&page, &schema).unwrap()),
    ];
    for (name, made) in files {
        let path = folder.join(name);
        if std::env::var_os("MENISCUS_REWRITE").is_some() {
            std::fs::write(&path, &made).unwrap();
        }
        let committed = std::fs::read_to_string(path).unwrap();
        let remedy = "MENISCUS_REWRITE=1 cargo test --test runs the_docs_are_what_the_types_say";
        assert!(committed == made, "docs/{name} is not what the types say: {remedy}");
    }
}

#[test]
fn every_key_is_in_the_docs() {
    fn keys(node: &serde_json::Value, found: &mut Vec<String>) {
        for (name, value) in node.as_object().into_iter().flatten() {
            if name == "properties" {
                found.extend(value.as_object().into_iter().flatten().map(|(key, _)| key.clone()));
            }
            keys(value, found);
        }
    }
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/case-file.md");
    let schema = schema(&SECTIONS);
    let page = docs::filled(&std::fs::read_to_string(page).unwrap(), &schema).unwrap();
    let mut found = Vec::new();
    keys(&schema, &mut found);
    assert!(found.len() > 100, "the walk went wrong: {found:?}");
    let missing: Vec<_> = found.iter().filter(|key| !page.contains(&format!("`{key}`"))).collect();
    assert!(missing.is_empty(), "docs/case-file.md does not tell of {missing:?}");
}

/// A unit in a participant's place: its file is sought from the case file, names and parameters are the
/// unit's own.
#[test]
fn a_unit_reads_back_as_it_was_resolved() {
    use interfaces::case::unit::{ParameterValue, Source};
    let text = r#"
[case]
title = "Unit"
dimension = 2
end_time = 1.0
output_interval = 0.1
particle_spacing = 0.01
gravity = [0.0, -9.81]

[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
domain = { low = [0.0, 0.0], high = [1.0, 1.0] }
participant = { start = "by-hand" }

[structure.material]
law = "neo-hookean"
youngs_modulus = 1e6
poisson_ratio = 0.3
density = 1000.0

[structure.participant]
fmu = "units/plate.fmu"
record = ["stress"]
[structure.participant.variables]
position = "node[{point}].{axis}"
velocity = ["v1", "v2"]
density = 1100
window_limit = "longest"
[structure.participant.parameters]
"body.E" = 2000000
nodes = 12
linear = true
law = "hooke"
weights = [1.0, 0.5]
"#;
    let read = |text: &str| Case::parse(text, Path::new("/cases/plate/case.toml"), &[], &SECTIONS);
    let case = read(text).unwrap_or_else(|errors| panic!("{errors}"));
    // Without gravity's depth or regions a foreign fluid has no speed of its own; it is not asked for one.
    assert_eq!(case.fluid.as_ref().unwrap().characteristic_speed, 0.0);
    let Start::Fmu(unit) = case.structure.as_ref().unwrap().participant.start() else {
        panic!("it is a unit")
    };
    assert_eq!(unit.file, Path::new("/cases/plate/units/plate.fmu"));
    assert_eq!(unit.variables.density, Some(Source::Number(1100.0)));
    assert_eq!(unit.variables.velocity, Some(Source::Names(vec!["v1".to_owned(), "v2".to_owned()])));
    assert_eq!(unit.parameters["body.E"], ParameterValue::Number(2e6));
    assert_eq!(unit.parameters["linear"], ParameterValue::Boolean(true));
    assert_eq!(unit.parameters["law"], ParameterValue::Text("hooke".to_owned()));
    assert_eq!(unit.parameters["weights"], ParameterValue::Numbers(vec![1.0, 0.5]));
    // Read from elsewhere it is the same: the resolved case names the file whole.
    let again = Case::parse(&case.to_toml(), Path::new("/out/case.toml"), &[], &SECTIONS);
    assert_eq!(again.unwrap_or_else(|errors| panic!("{errors}\n{}", case.to_toml())), case);

    for (from, to, message) in [
        (
            "fmu = ",
            "start = \"own\"\nfmu = ",
            "structure.participant: has start and fmu; leave all but one of them out",
        ),
        (
            "fmu = \"units/plate.fmu\"",
            "",
            "structure.participant.parameters: is for functional mock-up units alone",
        ),
        (
            "density = 1100",
            "densty = 1100",
            "structure.participant.variables.densty = 1100: there is no such key; did you mean \"density\"?",
        ),
        (
            "velocity = [\"v1\", \"v2\"]",
            "velocity = true",
            "is true or false, but must be a number or a string or a list of strings",
        ),
        (
            "linear = true",
            "linear = 1979-05-27",
            "is a date, but must be true or false or a number or a string or a list of numbers",
        ),
    ] {
        let words = read(&text.replacen(from, to, 1)).expect_err(message).to_string();
        assert!(words.contains(message), "`{message}` is not in: {words}");
    }
}
