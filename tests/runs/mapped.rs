//! A structure with points of its own, the vertices of a boundary mesh, beside a fluid that meets particles in its bodies.

use crate::support::{Bench, MENISCUS};
use coupler::mapped::{Filling, Mapped};
use coupler::phase::Announce;
use coupler::schedule::Schedule;
use coupler::schemes::serial_explicit::SerialExplicit;
use coupler::schemes::{Onward, Pair};
use coupler::side::Side;
use interfaces::case::coupling::StructureVelocity::Mean;
use interfaces::case::coupling::{Mapping, MappingMethod};
use interfaces::port::names;
use interfaces::{Call, Guarded, Participant, ParticipantError, Role, SubSteps};
use output::summary::Status;
use partners::{Log, Recorded, Recording, build};

/// Particles in a plate of 0.2 m × 0.02 m, four through it.
fn filling() -> Filling {
    let spacing = 5e-3;
    let positions: Vec<f64> = (0..160)
        .flat_map(|i| [spacing * (f64::from(i % 40) + 0.5), spacing * (f64::from(i / 40) + 0.5)])
        .collect();
    Filling { volumes: vec![spacing * spacing; 160], positions, density: 1000.0 }
}

fn choice(method: MappingMethod, rebuild: bool) -> Mapping {
    Mapping { method, spacing: 5e-3, reach: 0.01, rebuild }
}

fn mapped(words: &str, choice: Mapping, log: &Log) -> Result<Side, ParticipantError> {
    let recorded = Recording::new(build(words).expect("a mock"), log.clone());
    let mapped = Mapped::new(Guarded::new(recorded), choice, filling(), Announce::nobody())?;
    Ok(Side::new(Box::new(Guarded::new(mapped))))
}

fn fluid(words: &str) -> Side {
    Side::new(Box::new(Guarded::new(build(words).expect("a mock"))))
}

const EXPLICIT: SerialExplicit = SerialExplicit { relaxation: 1.0, enforce: true, predict: true };
/// The plate's outline in cells of 1 cm: 44 vertices.
const MESH: &str = "outline=20x2 spacing=0.01";

/// A plate that swings by a right angle about a corner: every particle stays where it is in the plate, with the weights made once or anew every window, for
/// all methods that carry linear fields.
#[test]
fn a_rigid_motion_of_the_mesh_is_one_of_the_particles() {
    use MappingMethod::{NearestNeighbourGradient, NearestProjection};
    for (method, rebuild) in
        [(NearestProjection, false), (NearestProjection, true), (NearestNeighbourGradient, false)]
    {
        let structure = mapped(
            &format!("prescribed {MESH} law=swing duration=0.1"),
            choice(method, rebuild),
            &Log::default(),
        )
        .expect("a mesh");
        let mut pair = Pair::initialize(fluid("constant"), structure, 0.0, Mean).expect("they fit");
        let mut schedule = Schedule::new(0.0, 0.1, 0.1, 0.01, SubSteps::Stable);
        EXPLICIT.run(&mut pair, &mut schedule, |_, _| Ok(Onward::Continue)).expect("mocks do not fail");
        let found = pair.accepted_position().expect("given");
        for (x, reference) in found.chunks_exact(2).zip(filling().positions.chunks_exact(2)) {
            // (x, y) turned by 90° is (−y, x); round-off of sums of a few terms of up to 0.2 m, ten windows of them where weights are made anew.
            assert!(
                (x[0] + reference[1]).abs() < 1e-13 && (x[1] - reference[0]).abs() < 1e-13,
                "{method:?} {rebuild}: {x:?} {reference:?}"
            );
        }
    }
}

/// Force on points, and moment about the origin.
fn resultant(positions: &[f64], forces: &[f64]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (x, f) in positions.chunks_exact(2).zip(forces.chunks_exact(2)) {
        sum[0] += f[0];
        sum[1] += f[1];
        sum[2] += x[0] * f[1] - x[1] * f[0];
    }
    sum
}

/// The force that the mesh feels is the one that the fluid's load is, and so is its moment, while the plate swings: end to end, through condition (46).
#[test]
fn force_and_moment_survive_the_way_to_the_mesh() {
    for rebuild in [false, true] {
        let log = Log::default();
        let words = format!("prescribed {MESH} law=swing duration=0.1");
        let structure =
            mapped(&words, choice(MappingMethod::NearestProjection, rebuild), &log).expect("a mesh");
        // Hydrostatic on a submerged body: a load that is another at every particle once the plate has turned.
        let fluid = fluid("hydrostatic level=0.3 plate_thickness=0.02 reaction_factor=0.9");
        let mut pair = Pair::initialize(fluid, structure, 0.0, Mean).expect("they fit");
        let mut schedule = Schedule::new(0.0, 0.1, 0.1, 0.01, SubSteps::Stable);
        let mut applied = Vec::new();
        let run = EXPLICIT.run(&mut pair, &mut schedule, |accepted, _| {
            let condition = accepted.condition46.expect("a coupled window");
            // On the fluid's side of the mapping it is enforced as ever.
            assert!(condition.residual_before > 0.05 && condition.residual_after < 1e-13, "{condition:?}");
            applied.push(accepted.applied.expect("a coupled window"));
            Ok(Onward::Continue)
        });
        run.expect("mocks do not fail");
        let field = |call: &Recorded, name: &str| {
            let fields = call.inputs.as_ref().or(call.outputs.as_ref()).expect("fields");
            fields.get(name).expect("a field of it").to_vec()
        };
        let calls = log.calls();
        let of = |wanted: Call| calls.iter().filter(move |call| call.call == wanted).collect::<Vec<_>>();
        // Two solutions a window: the load of the second, with the motion of the first, is what was measured.
        let (starts, finishes) = (of(Call::Start), of(Call::Finish));
        for (window, applied) in applied.iter().enumerate() {
            let force = field(starts[2 * window + 1], names::FORCE);
            let [fx, fy, moment] = resultant(&field(finishes[2 * window], names::POSITION), &force);
            let scale = applied.force[0].hypot(applied.force[1]);
            // Sums over 160 particles; arms of at most 0.2 m.
            assert!((fx - applied.force[0]).abs() < 1e-12 * scale, "{rebuild} {window}");
            assert!((fy - applied.force[1]).abs() < 1e-12 * scale, "{rebuild} {window}");
            assert!(
                (moment - applied.moment[2]).abs() < 1e-12 * scale,
                "{rebuild} {window}: {moment} {applied:?}"
            );
        }
    }
}

/// Solving again from a saved state gives the same bits, weights made anew or not.
#[test]
fn a_mapped_structure_conforms() {
    for rebuild in [false, true] {
        for words in ["spring-mass load=linear stiffness=100", "prescribed law=heave"] {
            let make = || -> Box<dyn Participant> {
                let inner = build(&format!("{words} {MESH}")).expect("a mock");
                let choice = choice(MappingMethod::NearestProjection, rebuild);
                Box::new(Mapped::new(inner, choice, filling(), Announce::nobody()).expect("a mesh"))
            };
            let options = partners::conformance::Options { points: 160, ..Default::default() };
            partners::conformance::check(make, &options).unwrap_or_else(|broken| panic!("{words}: {broken}"));
        }
    }
}

#[test]
fn what_a_mapping_needs_is_named() {
    let refused = |words: &str, choice| {
        mapped(words, choice, &Log::default())
            .and_then(|mut side| side.initialize(0.0, 0, None).map_err(|error| error.source))
    };
    let projection = choice(MappingMethod::NearestProjection, false);
    let error =
        refused("rigid points=40 spacing=5e-3", projection.clone()).expect_err("a cloud has no facets");
    assert!(error.to_string().contains("coupling.mapping.method"), "{error}");
    let error = refused("constant", projection.clone()).expect_err("no structure");
    assert!(error.to_string().contains("gives `position`"), "{error}");
    // A mesh that ends before the plate does.
    let error = refused("rigid outline=10x2 spacing=0.01", projection).expect_err("too far");
    assert!(error.to_string().contains("failed to map"), "{error}");
}

/// Our fluid beside a boundary mesh in a process of its own: water on a plate that hangs on a spring, for 0.02 s.
#[test]
fn our_fluid_meets_a_boundary_mesh() {
    let bench = Bench::new();
    let words =
        ["spring-mass", "outline=20x2", "spacing=0.01", "origin=0,-0.02", "density=1100", "stiffness=1e6"];
    let words: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
    let command = format!("structure.participant.command=[\"{MENISCUS}\", \"mock\", {}]", words.join(", "));
    let ended = bench
        .start_run(
            "out",
            &[
                "cases/hydrostatic_column_soft",
                "--set",
                &command,
                "--set",
                "case.particle_spacing=0.01",
                "--set",
                "structure.particle_spacing=0.005",
                "--set",
                "coupling.mapping={ method = \"nearest-projection\" }",
                "--set",
                "case.end_time=0.02",
                "--trace",
                "--no-report",
            ],
        )
        .wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    let outputs = bench.outputs("out");
    let summary = outputs.summary();
    assert_eq!(summary.status, Status::Completed);
    // 400 N of water on 0.2 m are on the plate, within what it swings: the spring is hardly loaded at once, and the water falls after the plate.
    let table = outputs.table("windows.csv");
    let column = |name: &str| table.get(name).expect("a column").to_vec();
    let (given, applied) = (column("force_after_y"), column("force_applied_y"));
    assert!(given.iter().any(|f| *f < -100.0), "{given:?}");
    // Not relaxed: the structure gets what the fluid gave.
    assert!(
        given.iter().zip(&applied).all(|(g, a)| (g - a).abs() <= 1e-9 * g.abs()),
        "{given:?} {applied:?}"
    );
    // Mapping was done, and its time taken.
    let mapping = summary.roles["coupler"].extra["mapping_seconds"].as_f64().expect("seconds");
    assert!(mapping > 0.0);
    assert!(summary.roles.contains_key(&Role::Structure.to_string()));
    let trace = std::fs::read_to_string(outputs.0.join("trace.json")).expect("a trace");
    let events: Vec<serde_json::Value> = serde_json::from_str(&trace).expect("JSON");
    let named = |name: &str| events.iter().filter(|event| event["name"] == name).count();
    let windows = summary.windows as usize;
    // Two solutions of the structure a window, loads in and motion out.
    assert!(named("mapping") >= 4 * windows, "{} {windows}", named("mapping"));
    assert!(named("records") >= windows && named("waiting") >= 3 * windows);
    let fluid = events.iter().filter(|event| event["tid"] == 1 && event["ph"] == "X").count();
    assert_eq!(fluid, windows, "the fluid solves a window once");
}
