//! A run is a value: gone on from a state in a fresh run, it is the undisturbed run to the bit.

use coupler::acceleration::Acceleration;
use coupler::acceleration::aitken::Aitken;
use coupler::acceleration::quasi_newton::{Choice, QuasiNewton};
use coupler::convergence::Measures;
use coupler::phase::Announce;
use coupler::run::{Recorded, Wanted};
use coupler::schedule::Schedule;
use coupler::schemes::extrapolation::Extrapolation;
use coupler::schemes::implicit::{Implicit, Unknowns};
use coupler::schemes::parallel_explicit::ParallelExplicit;
use coupler::schemes::serial_explicit::SerialExplicit;
use coupler::schemes::{Coupled, Onward, Pair, Run, Scheme, SchemeError, Solver};
use coupler::side::Side;
use interfaces::case::coupling::{AtLimit, LoadInWindow, SteadyQuantity, SteadyState, StructureVelocity};
use interfaces::{Guarded, SubSteps};
use partners::build;
use std::collections::BTreeMap;

/// Windows of a run, and how many of them before the state is taken.
pub(super) const WINDOWS: u64 = 24;
const BEFORE: u64 = 11;

/// A run's state: its parts by name.
type Parts = BTreeMap<String, Vec<u8>>;

fn saved<S: Solver>(run: &mut Run<S>) -> Parts {
    let mut parts = Parts::new();
    let kept: Result<(), SchemeError> = run.save(|name, bytes| {
        parts.insert(name.to_owned(), bytes.to_vec());
        Ok(())
    });
    kept.expect("mocks can be saved");
    parts
}

fn restored<S: Solver>(run: &mut Run<S>, parts: &Parts) -> Result<(), SchemeError> {
    run.restore(|name| Ok(parts[name].clone()))
}

fn side(words: &str) -> Side {
    Side::new(Box::new(Guarded::new(build(words).expect("a mock"))))
}

pub(super) fn schedule() -> Schedule {
    // An output in the first and in the second part, no window shorter than the others.
    Schedule::new(0.0, 1e-4 * WINDOWS as f64, 8e-4, 1e-4, SubSteps::Fixed(3))
}

/// A mass on a spring let go at 1 cm, under a column of half its mass that moves along with its wall.
fn coupled(scheme: Scheme, load_in_window: LoadInWindow) -> Run<Coupled> {
    let fluid = side("added-mass-column wall=moving mass=0.5");
    let structure = side("spring-mass stiffness=4e3 displacement=0,0.01 load=linear");
    let mut pair = Pair::initialize(fluid, structure, 0.0, StructureVelocity::Mean).expect("they fit");
    pair.load_in_window = load_in_window;
    let quantities = vec![SteadyQuantity::Position, SteadyQuantity::Velocity, SteadyQuantity::Load];
    pair.end_when_steady(SteadyState { quantities, rate: 1e-12, duration: 1.0 });
    Run { solver: Coupled::new(pair, scheme), schedule: schedule() }
}

fn quasi_newton(reused_windows: usize, multi_vector: bool) -> Acceleration {
    let choice = Choice { relaxation: 0.1, reused_windows, multi_vector, filter: 1e-3, columns: 10 };
    Acceleration::QuasiNewton(Box::new(QuasiNewton::new(choice)))
}

fn implicit(acceleration: Acceleration, parallel: bool, order: usize) -> Scheme {
    Implicit {
        parallel,
        enforce: true,
        measures: Measures { absolute: None, relative: Some(1e-8), residual_relative: None, all: false },
        iterations_limit: 50,
        at_limit: AtLimit::Continue,
        acceleration,
        extrapolation: Extrapolation::new(order),
        unknowns: Unknowns::default(),
    }
    .into()
}

/// Every scheme with every acceleration, and its name.
pub(super) fn schemes() -> Vec<(String, Box<dyn Fn() -> Scheme>)> {
    let mut schemes: Vec<(String, Box<dyn Fn() -> Scheme>)> = Vec::new();
    for (predict, relaxation) in [(true, 0.5), (false, 0.1)] {
        let scheme = SerialExplicit { relaxation, enforce: true, predict };
        schemes.push((format!("{scheme:?}"), Box::new(move || scheme.into())));
    }
    let scheme = ParallelExplicit { relaxation: 0.1, enforce: true };
    schemes.push((format!("{scheme:?}"), Box::new(move || scheme.into())));
    type Make = fn() -> Acceleration;
    let accelerations: [(&str, Make); 5] = [
        ("constant", || Acceleration::Constant(0.3)),
        ("Aitken", || Acceleration::Aitken(Aitken::new(0.1))),
        ("IQN-ILS", || quasi_newton(0, false)),
        ("IQN-ILS, reused", || quasi_newton(4, false)),
        ("IQN-IMVJ", || quasi_newton(3, true)),
    ];
    for (name, acceleration) in accelerations {
        for (parallel, order) in [(false, 0), (false, 2), (true, 1)] {
            let name = format!("{name}, parallel: {parallel}, order {order}");
            schemes.push((name, Box::new(move || implicit(acceleration(), parallel, order))));
        }
    }
    schemes
}

/// All that can be seen of the windows up to one, as bits.
pub(super) fn windows(run: &mut Run<Coupled>, until: u64) -> Vec<Vec<u64>> {
    let mut seen = Vec::new();
    let driven = run.drive(|accepted, Coupled { pair, .. }| {
        let window = accepted.window;
        let found = accepted.condition46.expect("a coupled window");
        let applied = accepted.applied.expect("a coupled window");
        let mut numbers = vec![window.index as f64, f64::from(window.iteration), window.start, window.size];
        numbers.extend([accepted.time, accepted.output.map_or(-1.0, |output| output as f64)]);
        numbers.extend([found.residual_before, found.residual_after, found.given.power, applied.power]);
        numbers.extend(pair.residuals.iter().flat_map(|left| [left.absolute, left.relative, left.of_first]));
        numbers.extend(pair.load.iter().chain(pair.new_load()).chain(&pair.new_velocity));
        numbers.extend(pair.accepted_position().expect("a structure gives positions"));
        numbers.extend(pair.structure.scalars.iter().chain(&pair.fluid.scalars));
        seen.push(numbers.into_iter().map(f64::to_bits).collect());
        Ok(if window.index + 1 == until { Onward::Stop } else { Onward::Continue })
    });
    driven.expect("mocks do not fail");
    seen
}

#[test]
fn a_run_goes_on_from_its_state_to_the_bit_under_every_scheme_and_acceleration() {
    for (name, scheme) in schemes() {
        for load_in_window in [LoadInWindow::Held, LoadInWindow::Linear] {
            let undisturbed = windows(&mut coupled(scheme(), load_in_window), WINDOWS);
            assert_eq!(undisturbed.len() as u64, WINDOWS, "{name}");
            for before in [0, 1, BEFORE] {
                let mut first = coupled(scheme(), load_in_window);
                if before > 0 {
                    windows(&mut first, before);
                }
                let state = saved(&mut first);
                let mut second = coupled(scheme(), load_in_window);
                restored(&mut second, &state).expect("a state of the same case");
                assert_eq!(saved(&mut second), state, "{name}, {before}");
                let rest = windows(&mut second, WINDOWS);
                assert!(rest == undisturbed[before as usize..], "{name}, {load_in_window:?}, from {before}");
                // What was saved is the state, not where the second has gone since; and it goes back.
                restored(&mut second, &state).expect("a state of the same case");
                let again = windows(&mut second, WINDOWS);
                assert!(
                    again == undisturbed[before as usize..],
                    "{name}, {load_in_window:?}, from {before} again"
                );
            }
        }
    }
}

#[test]
fn one_side_alone_goes_on_too() {
    let make = || {
        let mut side = side("spring-mass displacement=0,0.01");
        side.initialize(0.0, 10, None).expect("a mock");
        Run { solver: side, schedule: schedule() }
    };
    let drive = |run: &mut Run<Side>, until: u64| {
        let mut seen = Vec::new();
        let driven = run.drive(|accepted, side| {
            seen.push((accepted.time.to_bits(), side.scalars.clone(), side.sub_steps));
            Ok(if accepted.window.index + 1 == until { Onward::Stop } else { Onward::Continue })
        });
        driven.expect("a mock does not fail");
        seen
    };
    let undisturbed = drive(&mut make(), WINDOWS);
    let mut first = make();
    drive(&mut first, BEFORE);
    let mut second = make();
    restored(&mut second, &saved(&mut first)).expect("a state of the same case");
    assert_eq!(drive(&mut second, WINDOWS), undisturbed[BEFORE as usize..]);
}

#[test]
fn what_is_no_state_of_this_run_is_refused() {
    let scheme = || implicit(quasi_newton(3, true), false, 1);
    let mut run = coupled(scheme(), LoadInWindow::Held);
    windows(&mut run, BEFORE);
    let state = saved(&mut run);
    assert_eq!(state.keys().map(String::as_str).collect::<Vec<_>>(), ["coupler", "fluid", "structure"]);
    for (name, part) in &state {
        for length in 0..part.len() {
            let mut cut = state.clone();
            cut.get_mut(name).expect("it is there").truncate(length);
            let refused = restored(&mut coupled(scheme(), LoadInWindow::Held), &cut);
            assert!(refused.is_err(), "{name}: {length} of {} bytes", part.len());
        }
    }
    for other in [
        implicit(quasi_newton(3, true), true, 1),
        implicit(quasi_newton(3, true), false, 0),
        implicit(quasi_newton(3, false), false, 1),
        implicit(Acceleration::Constant(0.3), false, 1),
        SerialExplicit { relaxation: 1.0, enforce: true, predict: true }.into(),
    ] {
        let refused = restored(&mut coupled(other, LoadInWindow::Held), &state);
        let refused = refused.expect_err("another scheme's");
        assert!(refused.to_string().contains("state"), "{refused}");
    }
}

#[test]
fn records_go_on_in_the_tables_of_an_earlier_run() {
    let folder = || tempfile::tempdir().expect("a folder");
    let make = |folder: &tempfile::TempDir, goes_on: bool| {
        let run = coupled(implicit(quasi_newton(3, true), false, 1), LoadInWindow::Held);
        let wanted = Wanted { iterations: true, goes_on, ..Wanted::default() };
        Recorded::create(run, folder.path(), &wanted, Announce::nobody()).expect("tables")
    };
    let drive =
        |recorded: &mut Recorded<Coupled>, until: u64| {
            let driven = recorded.drive(|accepted, _| {
                if accepted.window.index + 1 == until { Onward::Stop } else { Onward::Continue }
            });
            driven.expect("mocks do not fail");
        };
    let (whole, interrupted) = (folder(), folder());
    drive(&mut make(&whole, false), WINDOWS);
    let mut first = make(&interrupted, false);
    drive(&mut first, BEFORE);
    let lengths = first.sync().expect("tables");
    let mut state = Parts::new();
    let kept: Result<(), SchemeError> = first.save(|name, bytes| {
        state.insert(name.to_owned(), bytes.to_vec());
        Ok(())
    });
    kept.expect("mocks can be saved");
    // What came after the state is cut.
    drive(&mut first, BEFORE + 5);
    drop(first);
    let mut second = make(&interrupted, true);
    let done: Result<(), SchemeError> = second.restore(|name| Ok(state[name].clone()));
    done.expect("a state of the same case");
    second.go_on(&lengths).expect("tables as long as they were");
    drive(&mut second, WINDOWS);
    drop(second);
    for name in ["windows.csv", "iterations.csv"] {
        let table = |folder: &tempfile::TempDir| {
            let mut table = output::table::read(&folder.path().join(name)).expect("a table");
            let timed = table.names.iter().enumerate().filter(|(_, column)| column.ends_with("_seconds"));
            let timed: Vec<usize> = timed.map(|(index, _)| index).collect();
            timed.into_iter().for_each(|index| table.columns[index].clear());
            table
        };
        assert_eq!(table(&interrupted), table(&whole), "{name}");
    }
}
