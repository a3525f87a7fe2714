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
use coupler::schemes::{Coupled, Onward, Pair, Run, Scheme, Solver};
use coupler::side::Side;
use interfaces::case::coupling::{AtLimit, LoadInWindow, SteadyQuantity, SteadyState, StructureVelocity};
use interfaces::{Guarded, SubSteps};
use partners::build;

/// Windows of a run, and how many of them before the state is taken.
const WINDOWS: u64 = 24;
const BEFORE: u64 = 11;

fn side(words: &str) -> Side {
    Side::new(Box::new(Guarded::new(build(words).expect("a mock"))))
}

fn schedule() -> Schedule {
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
fn schemes() -> Vec<(String, Box<dyn Fn() -> Scheme>)> {
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
fn windows(run: &mut Run<Coupled>, until: u64) -> Vec<Vec<u64>> {
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
                let state = first.save().expect("mocks can be saved");
                let mut second = coupled(scheme(), load_in_window);
                second.restore(&state).expect("a state of the same case");
                assert_eq!(second.save().expect("mocks can be saved"), state, "{name}, {before}");
                let rest = windows(&mut second, WINDOWS);
                assert!(rest == undisturbed[before as usize..], "{name}, {load_in_window:?}, from {before}");
                // What was saved is the state, not where the second has gone since; and it goes back.
                second.restore(&state).expect("a state of the same case");
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
    second.restore(&first.save().expect("a mock can be saved")).expect("a state of the same case");
    assert_eq!(drive(&mut second, WINDOWS), undisturbed[BEFORE as usize..]);
}

#[test]
fn what_is_no_state_of_this_run_is_refused() {
    let scheme = || implicit(quasi_newton(3, true), false, 1);
    let mut run = coupled(scheme(), LoadInWindow::Held);
    windows(&mut run, BEFORE);
    let state = run.save().expect("mocks can be saved");
    for length in 0..state.len() {
        let cut = coupled(scheme(), LoadInWindow::Held).restore(&state[..length]);
        assert!(cut.is_err(), "{length} of {} bytes", state.len());
    }
    for other in [
        implicit(quasi_newton(3, true), true, 1),
        implicit(quasi_newton(3, true), false, 0),
        implicit(quasi_newton(3, false), false, 1),
        implicit(Acceleration::Constant(0.3), false, 1),
        SerialExplicit { relaxation: 1.0, enforce: true, predict: true }.into(),
    ] {
        let refused = coupled(other, LoadInWindow::Held).restore(&state).expect_err("another scheme's");
        assert!(refused.to_string().contains("state"), "{refused}");
    }
}

#[test]
fn the_records_say_how_many_rows_they_had_and_their_sums_go_on() {
    let folder = || tempfile::tempdir().expect("a folder");
    let make = |folder: &tempfile::TempDir| {
        let run = coupled(implicit(quasi_newton(3, true), false, 1), LoadInWindow::Held);
        let wanted = Wanted { iterations: true, ..Wanted::default() };
        Recorded::create(run, folder.path(), &wanted, Announce::nobody()).expect("tables")
    };
    let drive = |recorded: &mut Recorded<Coupled>, until: u64| {
        let mut iterations = 0;
        let driven = recorded.drive(|accepted, solver| {
            iterations += solver.residuals().len() as u64;
            if accepted.window.index + 1 == until { Onward::Stop } else { Onward::Continue }
        });
        driven.expect("mocks do not fail");
        iterations
    };
    let (one, other) = (folder(), folder());
    let mut first = make(&one);
    let iterations = drive(&mut first, BEFORE);
    let state = first.save().expect("mocks can be saved");
    let mut second = make(&other);
    let rows = second.restore(&state).expect("a state of the same case");
    // Both mocks have probes or none: a row of the start and one of each window.
    assert_eq!(rows[0], Some(BEFORE));
    assert!(rows[1].is_none_or(|rows| rows == BEFORE + 1), "{rows:?}");
    assert_eq!(rows[2], Some(iterations));
    assert_eq!(second.save().expect("mocks can be saved"), state);
    let last = |folder: &tempfile::TempDir, recorded: Recorded<Coupled>| {
        drop(recorded);
        let table = std::fs::read_to_string(folder.path().join("windows.csv")).expect("a table");
        let header: Vec<String> =
            table.lines().next().expect("a header").split(',').map(str::to_owned).collect();
        let row: Vec<String> = table.lines().last().expect("a row").split(',').map(str::to_owned).collect();
        let timed = |column: &str| column.ends_with("_seconds");
        header.into_iter().zip(row).filter(|(column, _)| !timed(column)).collect::<Vec<_>>()
    };
    drive(&mut first, WINDOWS);
    drive(&mut second, WINDOWS);
    assert_eq!(last(&one, first), last(&other, second), "the sums over the windows among them");
}
