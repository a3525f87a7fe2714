//! Implicit schemes on partners whose fixed point is known: a mass on a spring under a column of fluid.

use crate::support::Bench;
use coupler::acceleration::Acceleration;
use coupler::acceleration::aitken::Aitken;
use coupler::acceleration::quasi_newton::{Choice, QuasiNewton};
use coupler::convergence::Measures;
use coupler::schedule::Schedule;
use coupler::schemes::extrapolation::Extrapolation;
use coupler::schemes::implicit::{Implicit, Unknowns};
use coupler::schemes::parallel_explicit::ParallelExplicit;
use coupler::schemes::{Accepted, Coupled, Onward, Pair, Run, SchemeError};
use coupler::side::Side;
use interfaces::case::coupling::AtLimit;
use interfaces::case::coupling::StructureVelocity::{self, End, Mean};
use interfaces::port::names;
use interfaces::{Call, Guarded, Participant, Role, SubSteps};
use partners::{Log, Recording, build};

/// Of the structure (kg): ten points of 0.01 m² at 1000 kg/m³.
const MASS: f64 = 1.0;
const STIFFNESS: f64 = 4e3;

fn side(participant: impl Participant + 'static) -> Side {
    Side::new(Box::new(Guarded::new(participant)))
}

/// A mass on a spring let go at 1 cm, under a moving wall's column of `mass_ratio` times its mass.
fn column(mass_ratio: f64, velocity: StructureVelocity, log: &Log) -> Pair {
    let mock = |words: &str| side(Recording::new(build(words).expect("a mock"), log.clone()));
    let fluid = mock(&format!("added-mass-column wall=moving mass={}", mass_ratio * MASS));
    let structure = mock(&format!("spring-mass stiffness={STIFFNESS} displacement=0,0.01"));
    Pair::initialize(fluid, structure, 0.0, velocity).expect("mocks that fit")
}

fn quasi_newton(reused_windows: usize, multi_vector: bool) -> Acceleration {
    let choice = Choice { relaxation: 0.1, reused_windows, multi_vector, filter: 1e-3, columns: 100 };
    Acceleration::QuasiNewton(Box::new(QuasiNewton::new(choice)))
}

fn scheme(acceleration: Acceleration, parallel: bool) -> Implicit {
    Implicit {
        parallel,
        enforce: true,
        measures: Measures { absolute: None, relative: Some(1e-8), residual_relative: None, all: false },
        iterations_limit: 50,
        at_limit: AtLimit::Stop,
        acceleration,
        extrapolation: Extrapolation::new(0),
        unknowns: Unknowns::default(),
    }
}

/// Runs `windows` windows of `size` (s), and gives them with the heights over rest (m) at their ends and the
/// pair as it is then.
fn run(pair: Pair, scheme: Implicit, windows: usize, size: f64) -> (Vec<Accepted>, Vec<f64>, Pair) {
    let end = windows as f64 * size;
    let (mut accepted, mut heights) = (Vec::new(), Vec::new());
    let mut driven = Run {
        solver: Coupled::new(pair, scheme),
        schedule: Schedule::new(0.0, end, end, size, SubSteps::Stable),
    };
    let result = driven.drive(|window, Coupled { pair, .. }| {
        accepted.push(*window);
        heights.push(pair.structure.scalars[1]);
        Ok(Onward::Continue)
    });
    result.expect("every window converges");
    (accepted, heights, driven.solver.pair)
}

fn iterations(accepted: &[Accepted]) -> Vec<u32> {
    accepted.iter().map(|a| a.window.iteration + 1).collect()
}

/// One unknown in truth: every point feels the same. The residual contracts by `1 − r (1 + μ)` with constant
/// relaxation, and two residuals tell the secant methods all there is to know: the third iterate is exact.
#[test]
fn added_mass_that_diverges_explicitly_converges_in_known_numbers_of_iterations() {
    let windows = 20;
    for mass_ratio in [0.5, 1.0, 9.0, 100.0] {
        let count = |acceleration, parallel| {
            let pair = column(mass_ratio, End, &Log::default());
            iterations(&run(pair, scheme(acceleration, parallel), windows, 1e-4).0)
        };
        assert!(count(Acceleration::Aitken(Aitken::new(0.1)), false).iter().all(|&n| n <= 3), "{mass_ratio}");
        assert!(count(quasi_newton(0, false), false).iter().all(|&n| n <= 3), "{mass_ratio}");
        // With what earlier windows told, one image is enough to know the next iterate.
        for multi_vector in [false, true] {
            let reused = count(quasi_newton(8, multi_vector), false);
            // What is left when the first window's difference is forgotten after 8 windows are differences of
            // 1e-8, right to 1e-8: a third image.
            let mean = f64::from(reused.iter().sum::<u32>()) / windows as f64;
            assert!(reused.iter().all(|&n| n <= 3) && mean <= 2.2, "{mass_ratio}: {reused:?}");
        }
        // Load and velocity: two unknowns.
        let parallel = count(quasi_newton(8, false), true);
        assert!(parallel[0] <= 5 && parallel[3..].iter().all(|&n| n <= 3), "{mass_ratio}: {parallel:?}");
    }
    // H(x) = y₀ − 9 x with the fixed point y₀/10: residuals y₀ 2⁻ᵏ of iterates near y₀/10 are below 1e-8 of
    // them at k = log₂ 1e9 = 29.9, the 31st iteration.
    let pair = column(9.0, End, &Log::default());
    let (accepted, ..) = run(pair, scheme(Acceleration::Constant(0.05), false), 1, 1e-4);
    assert_eq!(iterations(&accepted), [31]);
    // 1 − 0.3 · 10 = −2: it diverges.
    let pair = column(9.0, End, &Log::default());
    let diverging = scheme(Acceleration::Constant(0.3), false);
    let mut driven = Run {
        solver: Coupled::new(pair, diverging),
        schedule: Schedule::new(0.0, 1e-4, 1e-4, 1e-4, SubSteps::Stable),
    };
    let error = driven.drive(|_, _| Ok(Onward::Continue)).expect_err("it diverges");
    let SchemeError::NotConverged { window: 0, iterations: 50, .. } = error else { panic!("{error}") };
    assert!(error.to_string().contains("coupling.convergence.max_iterations"), "{error}");
}

/// All methods and both orders come to the same motion: the fixed point is the window's, not the method's.
#[test]
fn every_acceleration_comes_to_the_same_motion() {
    for velocity in [Mean, End] {
        let heights = |acceleration, parallel| {
            let pair = column(9.0, velocity, &Log::default());
            // Constant relaxation against the mean velocity, which answers half as much: 1 − 0.05 · 5.5 an
            // iteration, 58 to 1e-8.
            let scheme = Implicit { iterations_limit: 80, ..scheme(acceleration, parallel) };
            run(pair, scheme, 100, 1e-3).1
        };
        let reference = heights(quasi_newton(0, false), false);
        for (acceleration, parallel) in [
            (Acceleration::Constant(0.05), false),
            (Acceleration::Aitken(Aitken::new(0.1)), false),
            (quasi_newton(8, false), false),
            (quasi_newton(8, true), false),
            (quasi_newton(8, false), true),
            (quasi_newton(8, true), true),
        ] {
            let found = heights(acceleration.clone(), parallel);
            for (a, b) in found.iter().zip(&reference) {
                // Residuals of 1e-8 of the load, 40 N over 1 kg (1 + μ) and 1e-3 s a window, over a hundred
                // windows.
                assert!((a - b).abs() < 1e-7, "{velocity:?} {acceleration:?} {parallel}: {a} {b}");
            }
        }
    }
}

#[test]
fn a_window_is_solved_again_with_growing_iterations_and_only_the_last_is_accepted() {
    let log = Log::default();
    let pair = column(9.0, End, &log);
    let (accepted, _, pair) = run(pair, scheme(Acceleration::Aitken(Aitken::new(0.1)), false), 1, 1e-4);
    let count = iterations(&accepted)[0];
    let mut expected = vec!["structure initialize".to_owned(), "fluid initialize".to_owned()];
    for iteration in 0..count {
        for role in ["structure", "fluid"] {
            expected.extend([format!("{role} start 0.{iteration}"), format!("{role} finish")]);
        }
    }
    expected.extend(["fluid accept #1".to_owned(), "structure accept #1".to_owned()]);
    assert_eq!(log.brief(), expected);
    assert_eq!(pair.residuals.len(), count as usize);
    assert!(pair.residuals.windows(2).all(|pair| pair[1].relative < pair[0].relative));
    // The load of the window is the one under which the structure was solved, and the fluid answers with the
    // same.
    for (x, y) in pair.load.iter().zip(pair.new_load()) {
        assert!((x - y).abs() <= 1e-8 * y.abs());
    }
    let calls = log.calls();
    let given = calls.iter().rev().find(|call| (call.role, call.call) == (Role::Structure, Call::Start));
    let given = given.and_then(|start| start.inputs.as_ref()).expect("it was started");
    assert_eq!(given.get(names::PRESSURE_GRADIENT), Some(pair.load.as_slice()));
}

#[test]
fn a_parallel_window_starts_both_before_it_waits_for_either() {
    let log = Log::default();
    run(column(0.5, End, &log), scheme(quasi_newton(0, false), true), 1, 1e-4);
    let order = ["structure start 0.0", "fluid start 0.0", "structure finish", "fluid finish"];
    assert_eq!(log.brief()[2..6], order);
}

#[test]
fn the_limit_continues_stops_or_shrinks_as_the_case_says() {
    // Contraction 1 − 0.19 · 10 = −0.9: 175 iterations to 1e-8 at any size of the window.
    let slow = |at_limit, iterations_limit| Implicit {
        at_limit,
        iterations_limit,
        ..scheme(Acceleration::Constant(0.19), false)
    };
    let pair = column(9.0, End, &Log::default());
    let (accepted, _, pair) = run(pair, slow(AtLimit::Continue, 10), 3, 1e-4);
    assert_eq!(iterations(&accepted), [10; 3]);
    assert!(pair.residuals.len() == 10 && pair.residuals.iter().all(|left| !left.converged));
    let pair = column(9.0, End, &Log::default());
    let shrinking = slow(AtLimit::Shrink, 10);
    let mut driven = Run {
        solver: Coupled::new(pair, shrinking),
        schedule: Schedule::new(0.0, 1e-4, 1e-4, 1e-4, SubSteps::Stable),
    };
    let error = driven.drive(|_, _| Ok(Onward::Continue)).expect_err("it is no better when small");
    let SchemeError::NotConverged { size, .. } = error else { panic!("{error}") };
    assert_eq!(size, 1e-4 / 1024.0);
    // r = 0.1 suits a window in which the spring hardly moves; in 0.02 s it does (ω Δt = 1.3), and 12
    // iterations do not converge. The window shrinks until they do, and the next starts from what the
    // schedule allows.
    let fluid = side(build("added-mass-column wall=moving mass=9").expect("a mock"));
    let structure = side(build("spring-mass stiffness=4e3 displacement=0,0.01").expect("a mock"));
    let pair = Pair::initialize(fluid, structure, 0.0, End).expect("they fit");
    let mut shrinking = Implicit {
        measures: Measures { absolute: None, relative: Some(1e-6), residual_relative: None, all: false },
        ..slow(AtLimit::Shrink, 12)
    };
    shrinking.acceleration = Acceleration::Constant(0.1);
    let (accepted, ..) = run(pair, shrinking, 4, 0.02);
    assert!(accepted.iter().any(|a| a.window.size < 0.02), "{:?}", iterations(&accepted));
    let end: f64 = accepted.last().expect("windows").time;
    assert_eq!(end, 0.08);
}

#[test]
fn a_parallel_explicit_window_solves_both_at_once_with_what_the_last_one_gave() {
    let log = Log::default();
    let pair = column(0.1, End, &log);
    let scheme = ParallelExplicit { relaxation: 1.0, enforce: true };
    let (mut velocities, mut heights) = (Vec::new(), Vec::new());
    let mut driven = Run {
        solver: Coupled::new(pair, scheme),
        schedule: Schedule::new(0.0, 1.0, 1.0, 1e-3, SubSteps::Stable),
    };
    let run = driven.drive(|_, Coupled { pair, .. }| {
        velocities.push(pair.new_velocity[1]);
        heights.push(pair.structure.scalars[1].abs());
        Ok(Onward::Continue)
    });
    run.expect("mocks do not fail");
    let order = [
        "structure start 0.0",
        "fluid start 0.0",
        "structure finish",
        "fluid finish",
        "fluid accept",
        "structure accept",
    ];
    assert_eq!(log.brief()[2..8], order);
    let calls = log.calls();
    let starts = calls.iter().filter(|call| (call.role, call.call) == (Role::Fluid, Call::Start));
    let met = starts
        .map(|start| start.inputs.as_ref().and_then(|fields| fields.get(names::VELOCITY)).expect("taken")[1]);
    assert!(
        met.skip(1).eq(velocities[..velocities.len() - 1].iter().copied()),
        "the fluid meets the velocity that the structure had in the last window"
    );
    // A tenth of the mass as added mass: the lag by two windows neither grows nor, in 16 periods, takes more
    // than half.
    let largest = |part: &[f64]| part.iter().fold(0.0_f64, |m, h| m.max(*h));
    let (first, last) = (largest(&heights[..200]), largest(&heights[800..]));
    assert!(last < 1.5 * first && last > 0.5 * first, "{first} {last}");
}

/// A column of water that falls on a dry baffle.
const FIRST_CONTACT: &str = r#"
[case]
title = "First contact"
dimension = 2
end_time = 0.08
output_interval = 0.04
gravity = [0.0, -9.81]
particle_spacing = 6e-3

[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
domain = { low = [-0.02, -0.02], high = [0.604, 1.0] }

[[fluid.region]]
name = "column"
box = { low = [0.0, 0.0], high = [0.12, 0.15] }

[[fluid.wall]]
name = "tank"
polyline = [[0.0, 0.9], [0.0, 0.0], [0.584, 0.0], [0.584, 0.9]]
solid_side = "right"

[structure]
particle_spacing = 3e-3

[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 1e6
poisson_ratio = 0.0
density = 2500.0

[[structure.body]]
name = "baffle"
box = { low = [0.156, 0.0], high = [0.168, 0.048] }

[[structure.clamp]]
name = "bed"
body = "baffle"
face = "bottom"

[[probe]]
name = "corner"
on = "structure"
quantity = "displacement"
at = [0.156, 0.048]
"#;

/// What quasi-Newton methods learnt while the baffle was dry threw the first iterates after the contact so
/// far that the structure was torn, 0.069 s after the start.
#[test]
fn quasi_newton_survives_the_first_contact_of_water_and_structure() {
    let bench = Bench::new();
    let case = bench.path("case.toml");
    std::fs::write(&case, FIRST_CONTACT).expect("a case");
    let case = case.display().to_string();
    let tip = |out: &str, words: &[&str]| {
        let ended =
            bench.start_run(out, &[&[&case[..], "--in-process", "--no-report"], words].concat()).wait();
        assert_eq!(ended.status.code(), Some(0), "{out}: {}", ended.errors);
        *bench.outputs(out).table("probes.csv").get("corner.ux").expect("a probe").last().expect("rows")
    };
    let explicit = tip("explicit", &[]);
    for method in ["iqn-ils", "iqn-imvj"] {
        let method_key = format!("coupling.acceleration.method={method}");
        let found = tip(method, &["--set", "coupling.scheme=serial-implicit", "--set", &method_key]);
        // Windows of 1 ms after a blow: 2 % of millimetres.
        assert!((found / explicit - 1.0).abs() < 0.02 && explicit > 1e-3, "{method}: {found} of {explicit}");
    }
}
