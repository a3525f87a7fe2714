//! A structure or a fluid with points of its own, the vertices of a boundary mesh, beside a partner that
//! meets particles in the bodies.

use crate::support::{Bench, MENISCUS};
use coupler::mapped::fluid::MappedFluid;
use coupler::mapped::{Filling, Mapped};
use coupler::phase::Announce;
use coupler::schedule::Schedule;
use coupler::schemes::serial_explicit::SerialExplicit;
use coupler::schemes::{Coupled, Onward, Pair, Run};
use coupler::side::Side;
use interfaces::case::coupling::StructureVelocity::Mean;
use interfaces::case::coupling::{FluidMapping, FluidMappingMethod, Mapping, MappingMethod};
use interfaces::port::names;
use interfaces::{Call, Fields, Guarded, Participant, Result, Role, SubSteps};
use output::summary::Status;
use partners::{Log, Recorded, Recording, build};

/// Particles in a plate of 0.2 m × 0.02 m, four through it.
fn filling() -> Filling {
    let spacing = 5e-3;
    let positions: Vec<f64> = (0..160)
        .flat_map(|i| [spacing * (f64::from(i % 40) + 0.5), spacing * (f64::from(i / 40) + 0.5)])
        .collect();
    Filling { volumes: vec![spacing * spacing; 160], positions, densities: vec![1000.0; 160] }
}

fn choice(method: MappingMethod, rebuild: bool) -> Mapping {
    Mapping { method, spacing: 5e-3, reach: 0.01, rebuild }
}

fn mapped(words: &str, choice: Mapping, log: &Log) -> Result<Side> {
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

/// A plate that swings by a right angle about a corner: every particle stays where it is in the plate, with
/// the weights made once or anew every window, for all methods that carry linear fields.
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
        let pair = Pair::initialize(fluid("constant"), structure, 0.0, Mean).expect("they fit");
        let mut driven = Run {
            solver: Coupled::new(pair, EXPLICIT),
            schedule: Schedule::new(0.0, 0.1, 0.1, 0.01, SubSteps::Stable),
        };
        driven.drive(|_, _| Ok(Onward::Continue)).expect("mocks do not fail");
        let Run { solver: Coupled { pair, .. }, .. } = driven;
        let found = pair.accepted_position().expect("given");
        for (x, reference) in found.chunks_exact(2).zip(filling().positions.chunks_exact(2)) {
            // (x, y) turned by 90° is (−y, x); round-off of sums of a few terms of up to 0.2 m, ten windows
            // of them where weights are made anew.
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

/// The force that the mesh feels is the one that the fluid's load is, and so is its moment, while the plate
/// swings: end to end, through condition (46).
#[test]
fn force_and_moment_survive_the_way_to_the_mesh() {
    for rebuild in [false, true] {
        let log = Log::default();
        let words = format!("prescribed {MESH} law=swing duration=0.1");
        let structure =
            mapped(&words, choice(MappingMethod::NearestProjection, rebuild), &log).expect("a mesh");
        // Hydrostatic on a submerged body: a load that is another at every particle once the plate has
        // turned.
        let fluid = fluid("hydrostatic level=0.3 plate_thickness=0.02 reaction_factor=0.9");
        let pair = Pair::initialize(fluid, structure, 0.0, Mean).expect("they fit");
        let mut applied = Vec::new();
        let mut driven = Run {
            solver: Coupled::new(pair, EXPLICIT),
            schedule: Schedule::new(0.0, 0.1, 0.1, 0.01, SubSteps::Stable),
        };
        let run = driven.drive(|accepted, _| {
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

/// Our fluid beside a boundary mesh in a process of its own: water on a plate that hangs on a spring, for
/// 0.02 s.
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
    // 400 N of water on 0.2 m are on the plate, within what it swings: the spring is hardly loaded at once,
    // and the water falls after the plate.
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

fn mapped_fluid(words: &str, choice: FluidMapping, log: &Log) -> Result<Side> {
    let recorded = Recording::new(build(words).expect("a mock"), log.clone());
    let mapped = MappedFluid::new(Guarded::new(recorded), choice, Announce::nobody())?;
    Ok(Side::new(Box::new(Guarded::new(mapped))))
}

/// The outline of a plate whose particles lie half a spacing within it.
const WETTED: &str = "surface-pressure outline=20x2 spacing=0.01 level=0.3";
/// A plate of those particles, four through it.
const PARTICLES: &str = "grid=40x4 spacing=5e-3 origin=2.5e-3,2.5e-3";

/// While the plate swings by a right angle about a corner, every point of the fluid stays where it is on the
/// plate, and the particles feel force and moment of the pressure on these points.
#[test]
fn a_fluid_with_points_of_its_own_goes_with_the_particles_and_pushes_them_as_hard() {
    use FluidMappingMethod::{NearestNeighbourGradient, RadialBasis};
    for (method, rebuild) in [(NearestNeighbourGradient, false), (RadialBasis, false), (RadialBasis, true)] {
        let log = Log::default();
        let fluid = mapped_fluid(WETTED, FluidMapping { method, reach: 0.01, rebuild }, &log)
            .expect("a fluid that fits");
        let structure = Side::new(Box::new(Guarded::new(
            build(&format!("prescribed {PARTICLES} law=swing duration=0.1")).expect("a mock"),
        )));
        let pair = Pair::initialize(fluid, structure, 0.0, Mean).expect("they fit");
        let mut loads = Vec::new();
        let mut driven = Run {
            solver: Coupled::new(pair, EXPLICIT),
            schedule: Schedule::new(0.0, 0.1, 0.1, 0.01, SubSteps::Stable),
        };
        let run = driven.drive(|_, Coupled { pair, .. }| {
            let position = pair.accepted_position().expect("given").to_vec();
            loads.push((position, pair.fluid.outputs.get(names::PRESSURE_GRADIENT).expect("given").to_vec()));
            Ok(Onward::Continue)
        });
        run.expect("mocks do not fail");
        let calls = log.calls();
        let field = |wanted: Call, of: fn(&Recorded) -> &Option<Fields>, name: &str| -> Vec<Vec<f64>> {
            let found = calls.iter().filter(move |call| call.call == wanted);
            found
                .map(|call| of(call).as_ref().expect("fields").get(name).expect("a field of it").to_vec())
                .collect()
        };
        let start = &field(Call::Initialize, |call| &call.outputs, names::OWN_POSITION)[0];
        let displacement = field(Call::Start, |call| &call.inputs, names::DISPLACEMENT);
        let forces = field(Call::Finish, |call| &call.outputs, names::FORCE);
        assert_eq!((displacement.len(), forces.len()), (10, 10));
        for window in 0..10 {
            // The plate's angle at the window's start, as the mock has it: the smooth step of a swing.
            let particle = if window == 0 { vec![2.5e-3, 2.5e-3] } else { loads[window - 1].0[..2].to_vec() };
            let (sin, cos) = (particle[1].atan2(particle[0]) - 0.25 * std::f64::consts::PI).sin_cos();
            let moved: Vec<f64> = start.iter().zip(&displacement[window]).map(|(x, u)| x + u).collect();
            for (x, at) in moved.chunks_exact(2).zip(start.chunks_exact(2)) {
                let expected = [cos * at[0] - sin * at[1], sin * at[0] + cos * at[1]];
                // Round-off of the angle's own computation, and of sums over up to 50 particles.
                let error = (x[0] - expected[0]).hypot(x[1] - expected[1]);
                assert!(error < 2e-13, "{method:?} {rebuild} {window}: {error}");
            }
            // Arms of the window's start, for both.
            let of_points = resultant(&moved, &forces[window]);
            let before = if window == 0 {
                (0..160_u8)
                    .flat_map(|i| [5e-3 * (f64::from(i % 40) + 0.5), 5e-3 * (f64::from(i / 40) + 0.5)])
                    .collect()
            } else {
                loads[window - 1].0.clone()
            };
            let of_particles: Vec<f64> = loads[window].1.iter().map(|g| -25e-6 * g).collect();
            let of_particles = resultant(&before, &of_particles);
            // 4e-3 m² of water weigh 39 N; pressures of 3 kPa cancel in it.
            for (one, other) in of_points.iter().zip(of_particles) {
                assert!(
                    (one - other).abs() < 1e-10,
                    "{method:?} {rebuild} {window}: {of_points:?} {of_particles:?}"
                );
            }
        }
    }
}

/// Solving again from a saved state gives the same bits, weights made anew or not.
#[test]
fn a_mapped_fluid_conforms() {
    let around_the_particles = |time: f64, variant: u32, inputs: &mut Fields| {
        partners::conformance::plausible(time, variant, inputs);
        if let Some(positions) = inputs.get_mut(names::POSITION) {
            for (i, x) in positions.chunks_exact_mut(2).enumerate() {
                let wave = 1e-4 * (1.0 + f64::from(variant) + 10.0 * time + i as f64).sin();
                x.copy_from_slice(&[
                    5e-3 * ((i % 40) as f64 + 0.5) + wave,
                    5e-3 * ((i / 40) as f64 + 0.5) - wave,
                ]);
            }
        }
    };
    for rebuild in [false, true] {
        let make = || -> Box<dyn Participant> {
            let choice = FluidMapping { method: FluidMappingMethod::RadialBasis, reach: 0.01, rebuild };
            let inner = build(WETTED).expect("a mock");
            Box::new(MappedFluid::new(inner, choice, Announce::nobody()).expect("a fluid that fits"))
        };
        let options = partners::conformance::Options {
            points: 160,
            inputs: &around_the_particles,
            ..Default::default()
        };
        partners::conformance::check(make, &options).unwrap_or_else(|broken| panic!("{rebuild}: {broken}"));
    }
}

#[test]
fn what_a_fluid_behind_a_mapping_needs_is_named() {
    let choice = || FluidMapping { method: FluidMappingMethod::RadialBasis, reach: 0.01, rebuild: false };
    let error = mapped_fluid("constant", choice(), &Log::default()).err().expect("it has no points");
    assert!(error.to_string().contains("gives `own_position`"), "{error}");
    // Its mesh is beside the plate.
    let far = "surface-pressure outline=20x2 spacing=0.01 origin=0,1 level=2";
    let fluid = mapped_fluid(far, choice(), &Log::default()).expect("a fluid that fits");
    let structure = Side::new(Box::new(Guarded::new(build(&format!("rigid {PARTICLES}")).expect("a mock"))));
    let error = Pair::initialize(fluid, structure, 0.0, Mean).err().expect("too far");
    assert!(
        error.to_string().contains("between the structure's particles and the fluid's points"),
        "{error}"
    );
}

/// Our structure beside such a fluid, in processes of their own: a beam that a heavy liquid lifts bends as
/// under the same force at all its particles.
#[test]
fn our_structure_meets_a_fluid_with_points_of_its_own() {
    let beam = |rest: &str, load: &str| {
        format!(
            r#"
[case]
title = "A beam that is lifted"
dimension = 2
end_time = 1.5e-3
output_interval = 5e-4
particle_spacing = 2.5e-3
[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 210e9
poisson_ratio = 0.3
density = 7850.0
assumption = "plane-stress"
[[structure.body]]
name = "beam"
box = {{ low = [0.0, -0.005], high = [0.1, 0.005] }}
[[structure.clamp]]
name = "root"
body = "beam"
face = "left"
{load}
[[probe]]
name = "tip"
on = "structure"
quantity = "displacement"
at = [0.1, 0.0]
{rest}
"#
        )
    };
    // 1000 kg/m³ times 1.75e5 m/s² on 1e-3 m² (for one metre of depth).
    let load = "[[structure.load]]\nname = \"lift\"\nbody = \"beam\"\nforce = [0.0, 1.75e5]";
    let fluid = format!(
        r#"
[coupling]
max_window = 1e-5
sub_steps = "stable"
fluid_mapping = {{}}
[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
characteristic_speed = 1.0
domain = {{ low = [-1.0, -1.0], high = [1.0, 1.0] }}
[fluid.participant]
command = ["{MENISCUS}", "mock", "surface-pressure", "outline=40x4", "spacing=2.5e-3", "origin=0,-0.005", "gravity=1.75e5", "level=0.02"]
"#
    );
    let tip = |text: String| {
        let bench = Bench::new();
        let case = bench.path("case.toml");
        std::fs::write(&case, text).expect("a case");
        let ended = bench.start_run("out", &[&case.display().to_string(), "--no-report"]).wait();
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        let table = bench.outputs("out").table("probes.csv");
        *table.get("tip.uy").expect("the probe").last().expect("rows")
    };
    let (lifted, loaded) = (tip(beam(&fluid, "")), tip(beam("", load)));
    println!("lifted {lifted} m, loaded {loaded} m");
    assert!(loaded > 1e-3, "{loaded}");
    // 0.2 % less was measured: the pressure turns with the beam's surface, the load at its particles does
    // not.
    assert!((lifted / loaded - 1.0).abs() < 5e-3, "{lifted} {loaded}");
}
