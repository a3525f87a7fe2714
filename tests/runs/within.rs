//! What happens within a window, and what ends a run before its end time: loads that go linearly over a
//! window, ends asked for, steady states.

use coupler::acceleration::Acceleration;
use coupler::acceleration::quasi_newton::{Choice, QuasiNewton};
use coupler::convergence::Measures;
use coupler::schedule::Schedule;
use coupler::schemes::extrapolation::Extrapolation;
use coupler::schemes::implicit::{Implicit, Unknowns};
use coupler::schemes::serial_explicit::SerialExplicit;
use coupler::schemes::{Coupled, Onward, Pair, Run};
use coupler::side::Side;
use interfaces::case::coupling::LoadInWindow::{self, Held, Linear};
use interfaces::case::coupling::StructureVelocity::{self, End, Mean};
use interfaces::case::coupling::{AtLimit, SteadyQuantity, SteadyState};
use interfaces::{Guarded, SubSteps};
use partners::{Log, Recording, build};
use std::f64::consts::TAU;

const EXPLICIT: SerialExplicit = SerialExplicit { relaxation: 1.0, enforce: true, predict: true };

fn pair(fluid: &str, structure: &str, log: &Log) -> Pair {
    let side = |words: &str| {
        let recorded = Recording::new(build(words).expect("a mock"), log.clone());
        Side::new(Box::new(Guarded::new(recorded)))
    };
    Pair::initialize(side(fluid), side(structure), 0.0, Mean).expect("mocks that fit")
}

/// A mass of 1 kg on a spring of 400 N/m that is pushed by −sin(2π t) N: its height at 0.4 s after windows of
/// `size` (s).
fn height(structure: &str, load_in_window: LoadInWindow, size: f64, scheme: &SerialExplicit) -> f64 {
    let words = format!("spring-mass stiffness=400 {structure}");
    let mut pair = pair("harmonic gradient=0,1e3 frequency=1", &words, &Log::default());
    pair.load_in_window = load_in_window;
    let mut driven = Run {
        solver: Coupled::new(pair, *scheme),
        schedule: Schedule::new(0.0, 0.4, 0.4, size, SubSteps::Fixed(100)),
    };
    driven.drive(|_, _| Ok(Onward::Continue)).expect("mocks do not fail");
    let Run { solver: Coupled { pair, .. }, .. } = driven;
    pair.structure.scalars[1]
}

/// From rest, `u = F/(k − m ω²) (sin ωt − ω/ω₀ sin ω₀t)` with `F` = −1 N, `ω` = 2π/s, `ω₀` = 20/s.
fn exact() -> f64 {
    let (omega, own, t) = (TAU, 20.0, 0.4);
    -1.0 / (400.0 - omega * omega) * ((omega * t).sin() - omega / own * (own * t).sin())
}

#[test]
fn a_load_that_is_linear_within_a_window_raises_the_order() {
    let order = |structure: &str, load_in_window| {
        let error = |size| (height(structure, load_in_window, size, &EXPLICIT) - exact()).abs();
        let (coarse, fine) = (error(0.01), error(0.005));
        (fine, (coarse / fine).log2())
    };
    let (held, first) = order("", Held);
    // The load of a window's end all over it comes half a window too early: first order. Between two right
    // values, second.
    assert!((first - 1.0).abs() < 0.1, "{first}");
    for structure in ["load=linear", "load=linear integration=rk4"] {
        let (linear, second) = order(structure, Linear);
        assert!((second - 2.0).abs() < 0.1, "{structure}: {second}");
        assert!(linear < 0.02 * held, "{structure}: {linear} {held}");
    }
    // A structure that asks for the load at the start, in a case that holds it, gets the same at both ends.
    let asked = height("load=linear", Held, 0.01, &EXPLICIT);
    assert!((asked - height("", Held, 0.01, &EXPLICIT)).abs() < 1e-15, "{asked}");
}

/// A mass of 1 kg on a spring under a column of `mass_ratio` times its mass, against a moving wall and
/// iterated: the largest height (m) over the last of a hundred windows, of 0.1 of the structure's own phase,
/// from 1 cm.
fn last_height(mass_ratio: f64, load_in_window: LoadInWindow, velocity: StructureVelocity) -> f64 {
    let side = |words: &str| Side::new(Box::new(Guarded::new(build(words).expect("a mock"))));
    let fluid = side(&format!("added-mass-column wall=moving mass={mass_ratio}"));
    let structure = side("spring-mass stiffness=4e3 displacement=0,0.01 load=linear");
    let mut pair = Pair::initialize(fluid, structure, 0.0, velocity).expect("they fit");
    pair.load_in_window = load_in_window;
    let choice =
        Choice { relaxation: 0.1, reused_windows: 0, multi_vector: false, filter: 1e-3, columns: 100 };
    let scheme = Implicit {
        parallel: false,
        enforce: true,
        measures: Measures { absolute: None, relative: Some(1e-8), residual_relative: None, all: false },
        iterations_limit: 50,
        at_limit: AtLimit::Stop,
        acceleration: Acceleration::QuasiNewton(Box::new(QuasiNewton::new(choice))),
        extrapolation: Extrapolation::new(0),
        unknowns: Unknowns::default(),
    };
    let size = 0.1 / 4e3_f64.sqrt();
    let mut largest = 0.0_f64;
    let mut driven = Run {
        solver: Coupled::new(pair, scheme),
        schedule: Schedule::new(0.0, 100.0 * size, 100.0 * size, size, SubSteps::Stable),
    };
    let run = driven.drive(|accepted, Coupled { pair, .. }| {
        if accepted.window.index >= 90 {
            largest = largest.max(pair.structure.scalars[1].abs());
        }
        Ok(Onward::Continue)
    });
    run.expect("every window converges");
    largest
}

/// To a held load answers the mean velocity, to a linear one that at the end: each pair is stable at every
/// added mass. The linear load with the mean velocity has `a₁ = −μ (a₋₁ + 4 a₀ + a₁)/6` for slow modes, which
/// grows over μ = 3.
#[test]
fn a_linear_load_goes_with_the_velocity_at_the_end() {
    for mass_ratio in [0.5, 2.5, 9.0, 100.0] {
        // A tenth more than at the start: the fluid's load at the very start is none, of which the first
        // window's ramp takes half.
        assert!(last_height(mass_ratio, Held, Mean) < 0.011, "{mass_ratio}");
        assert!(last_height(mass_ratio, Linear, End) < 0.011, "{mass_ratio}");
    }
    assert!(last_height(2.5, Linear, Mean) < 0.011);
    // By 1.29 a window at μ = 4: (1 + 4/6) z² + 16/6 z + 4/6 = 0.
    assert!(last_height(4.0, Linear, Mean) > 1.0);
}

/// Without a prediction the load comes a window late: first order whatever is done within the window, and
/// each solves once.
#[test]
fn a_staggered_window_is_solved_once_by_each() {
    let staggered = SerialExplicit { predict: false, ..EXPLICIT };
    let log = Log::default();
    let pair = pair("constant gradient=0,10", "spring-mass", &log);
    let mut driven = Run {
        solver: Coupled::new(pair, staggered),
        schedule: Schedule::new(0.0, 0.2, 0.1, 0.1, SubSteps::Fixed(3)),
    };
    driven.drive(|_, _| Ok(Onward::Continue)).expect("mocks do not fail");
    let window = |n: u32| {
        [
            format!("structure start {n}.0"),
            "structure finish".to_owned(),
            format!("fluid start {n}.0"),
            "fluid finish".to_owned(),
            format!("fluid accept #{}", n + 1),
            format!("structure accept #{}", n + 1),
        ]
    };
    assert_eq!(log.brief()[2..], [window(0), window(1)].concat());
    let error = |size| (height("", Held, size, &staggered) - exact()).abs();
    let order = (error(0.01) / error(0.005)).log2();
    assert!((order - 1.0).abs() < 0.15, "{order}");
}

#[test]
fn a_participant_that_asks_for_an_end_gets_it_with_an_output() {
    let log = Log::default();
    let pair = pair("constant gradient=0,10 end_after=0.25", "spring-mass", &log);
    let mut outputs = Vec::new();
    let mut driven = Run {
        solver: Coupled::new(pair, EXPLICIT),
        schedule: Schedule::new(0.0, 1.0, 0.5, 0.1, SubSteps::Stable),
    };
    let run = driven.drive(|accepted, _| {
        outputs.push((accepted.time, accepted.output));
        Ok(Onward::Continue)
    });
    let Run { solver: Coupled { pair, .. }, .. } = driven;
    run.expect("mocks do not fail");
    // Windows of 0.1 s: the third is the first to end after 0.25 s.
    assert_eq!(outputs.iter().map(|(_, output)| *output).collect::<Vec<_>>(), [None, None, Some(1)]);
    assert!((outputs[2].0 - 0.3).abs() < 1e-15);
    assert_eq!(pair.ending.as_deref(), Some("the fluid asked for it"));
    assert_eq!(log.brief().last().map(String::as_str), Some("structure accept #1"));
}

#[test]
fn one_side_alone_may_ask_too() {
    let mock = build("constant gradient=0,10 end_after=0.25").expect("a mock");
    let mut side = Side::new(Box::new(Guarded::new(mock)));
    side.initialize(0.0, 5, None).expect("a mock");
    let mut driven = Run { solver: side, schedule: Schedule::new(0.0, 1.0, 0.5, 0.1, SubSteps::Stable) };
    driven.drive(|_, _| Ok(Onward::Continue)).expect("a mock does not fail");
    assert_eq!((driven.schedule.windows(), driven.schedule.finished()), (3, true));
}

#[test]
fn a_run_ends_where_the_interface_is_steady() {
    // m = 1 kg, k = 400 N/m, c = 20 N s/m: half of critical damping, the displacement settles as e^(−10 t).
    let mut pair = pair("constant gradient=0,1e3", "spring-mass stiffness=400 damping=20", &Log::default());
    let quantities = vec![SteadyQuantity::Position, SteadyQuantity::Velocity, SteadyQuantity::Load];
    pair.end_when_steady(SteadyState { quantities, rate: 1e-3, duration: 0.2 });
    let mut driven = Run {
        solver: Coupled::new(pair, EXPLICIT),
        schedule: Schedule::new(0.0, 100.0, 100.0, 0.01, SubSteps::Stable),
    };
    driven.drive(|_, _| Ok(Onward::Continue)).expect("mocks do not fail");
    let Run { solver: Coupled { pair, .. }, schedule } = driven;
    assert!(pair.ending.as_deref().is_some_and(|why| why.starts_with("a steady state")), "{:?}", pair.ending);
    // Velocity and its rate are largest, 20² e^(−10 t) of the departure: below 1e-3 after ln(4e5)/10 = 1.29 s
    // at the latest, give or take a period of 2π/17.3 s; the 0.2 s on top.
    assert!(schedule.time() > 0.7 && schedule.time() < 1.29 + 0.37 + 0.2, "{}", schedule.time());
    let rest = -1.0 / 400.0;
    assert!((pair.structure.scalars[1] / rest - 1.0).abs() < 1e-3, "{:?}", pair.structure.scalars);
}
