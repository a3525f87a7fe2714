//! The time step: order, conservation, repeatability, loads, and refusals.

use sph::Vector;
use structure::{
    Body, DeadLoad, Error, ErrorKind, Gradient, History, Law, Load, Material, Options, Plane, Setup, Side,
    Solid, State, TotalLagrangian,
};

type V = Vector<2>;

const GRADIENTS: [Gradient; 2] = [Gradient::FirstOrder, Gradient::Quadratic];

fn setup(gradient: Gradient, length: f64, clamped: bool) -> Setup<2> {
    let material = Material::new(Law::StVenantKirchhoff, 1e6, 0.3, Plane::Strain);
    let mut body = Body::block(V::zeros(), V::from([length, 0.4]), 0.1, material, 1000.0);
    if clamped {
        body = body.clamp(0, Side::Low, gradient, gradient.default_smoothing_ratio());
    }
    let mut setup = Setup::new(vec![body]);
    setup.options = Options::of(gradient);
    setup
}

fn swinging(structure: &mut TotalLagrangian<2>, amount: f64) -> State<2> {
    let mut state = structure.state_at_rest(0.0);
    for i in 0..structure.particles().len() {
        let x = structure.particles().reference_positions[i].x;
        if !structure.particles().clamped[i] {
            state.velocities[i] = V::from([0.0, amount * x * x]);
        }
    }
    structure.evaluate(&mut state).unwrap();
    state
}

#[test]
fn runge_kutta_is_of_fourth_order() {
    for gradient in GRADIENTS {
        let mut structure = TotalLagrangian::new(setup(gradient, 1.0, true)).unwrap();
        let from = swinging(&mut structure, 1.0);
        let dt = 8.0 * structure.stable_time_step();
        let mut solve = |sub_steps| {
            let mut to = from.clone();
            structure.advance(&from, &mut to, dt, sub_steps, &Load::None).unwrap();
            to
        };
        let exact = solve(512);
        let error = |state: &State<2>| {
            state.positions.iter().zip(&exact.positions).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
        };
        let order = (error(&solve(32)) / error(&solve(64))).log2();
        assert!((order - 4.0).abs() < 0.3, "{gradient:?}: {order}");
    }
}

#[test]
fn energy_is_kept_over_many_swings() {
    for gradient in GRADIENTS {
        let mut structure = TotalLagrangian::new(setup(gradient, 2.0, true)).unwrap();
        let from = swinging(&mut structure, 0.5);
        let mut to = from.clone();
        let dt = 0.1 * structure.stable_time_step();
        structure.advance(&from, &mut to, 4000.0 * dt, 4000, &Load::None).unwrap();
        let drift = (to.energy.balance() - from.energy.balance()) / from.energy.balance();
        // RK4 takes (ω Δt)⁶/72 of a mode's energy a step: with ω Δt ≤ 0.26 at most 4e-6 a step for the
        // roughest, which holds next to none.
        assert!(drift.abs() < 1e-5, "{gradient:?}: {drift}");
        assert!(to.energy.strain > 0.0);
    }
}

#[test]
fn windows_repeat_to_the_bit_and_do_not_depend_on_what_was_solved_before() {
    for gradient in GRADIENTS {
        let mut structure = TotalLagrangian::new(setup(gradient, 1.0, true)).unwrap();
        let from = swinging(&mut structure, 1.0);
        let dt = 10.0 * structure.stable_time_step();
        let (mut first, mut other, mut again) = (from.clone(), from.clone(), from.clone());
        let load = vec![V::from([3e3, -1e3]); structure.particles().interface.len()];
        structure.advance(&from, &mut first, dt, 20, &Load::Held(&load)).unwrap();
        structure.advance(&first, &mut other, dt, 13, &Load::None).unwrap();
        structure.advance(&from, &mut again, dt, 20, &Load::Held(&load)).unwrap();
        assert_eq!(first, again);
        assert_eq!(from.energy.kinetic, swinging(&mut structure, 1.0).energy.kinetic);
    }
}

#[test]
fn results_are_the_same_to_the_bit_for_any_number_of_threads() {
    for gradient in GRADIENTS {
        let solve = |threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
                // 0.4 by 120 at 0.1: 4,800 particles, over the size from which threads share a pass.
                let mut structure = TotalLagrangian::new(setup(gradient, 120.0, true)).unwrap();
                let from = swinging(&mut structure, 1e-3);
                let mut to = from.clone();
                let dt = 5.0 * structure.stable_time_step();
                structure.advance(&from, &mut to, dt, 6, &Load::None).unwrap();
                to
            })
        };
        let one = solve(1);
        assert_eq!(one, solve(2), "{gradient:?}");
        assert_eq!(one, solve(5), "{gradient:?}");
    }
}

/// A free body under gravity and a uniform pressure gradient falls as a point: x = ½ a t², exactly for a
/// fourth-order scheme.
#[test]
fn a_free_body_falls_and_the_work_of_loads_is_its_kinetic_energy() {
    for gradient in GRADIENTS {
        let mut setup = setup(gradient, 1.0, false);
        setup.gravity = V::from([0.0, -9.81]);
        let mut structure = TotalLagrangian::new(setup).unwrap();
        let from = structure.state_at_rest(2.0);
        let mut to = from.clone();
        let (dt, steps) = (20.0 * structure.stable_time_step(), 40);
        let load = vec![V::from([-2000.0, 0.0]); structure.particles().interface.len()];
        structure.advance(&from, &mut to, dt, steps, &Load::Held(&load)).unwrap();
        let fall = V::from([0.5 * 2.0 * dt * dt, -0.5 * 9.81 * dt * dt]);
        for (a, b) in to.positions.iter().zip(&from.positions) {
            assert!((a - b - fall).norm() < 1e-12 * fall.norm() + 1e-15);
        }
        assert!((to.energy.load_work / to.energy.kinetic - 1.0).abs() < 1e-11);
        assert_eq!(to.time, 2.0 + dt);
        // Linear loads between equal ends are held loads, up to round-off of the interpolation.
        let mut linear = from.clone();
        structure.advance(&from, &mut linear, dt, steps, &Load::Linear(&load, &load)).unwrap();
        assert!((linear.energy.kinetic / to.energy.kinetic - 1.0).abs() < 1e-13);
        // From nothing to the load, the momentum is half of it.
        let zero = vec![V::zeros(); load.len()];
        structure.advance(&from, &mut linear, dt, steps, &Load::Linear(&zero, &load)).unwrap();
        let speed = structure.particles().momentum(&linear.velocities).x
            / structure.particles().masses.iter().sum::<f64>();
        assert!((speed - dt).abs() < 1e-12 * dt, "{speed} {dt}");
    }
}

#[test]
fn viscous_damping_slows_a_free_body_exponentially() {
    let mut setup = setup(Gradient::FirstOrder, 1.0, false);
    setup.options.damping = 40.0;
    let mut structure = TotalLagrangian::new(setup).unwrap();
    let mut from = structure.state_at_rest(0.0);
    from.velocities.iter_mut().for_each(|u| *u = V::from([1.0, 0.0]));
    structure.evaluate(&mut from).unwrap();
    let mut to = from.clone();
    let dt = 20.0 * structure.stable_time_step();
    structure.advance(&from, &mut to, dt, 200, &Load::None).unwrap();
    // Fourth order: (c Δt)⁵/120 a step.
    assert!((to.velocities[0].x / (-40.0 * dt).exp() - 1.0).abs() < 1e-8);
    assert!((to.energy.balance() / from.energy.balance() - 1.0).abs() < 1e-8);
}

#[test]
fn refusals_name_particle_time_and_remedy() {
    let mut structure = TotalLagrangian::new(setup(Gradient::FirstOrder, 1.0, true)).unwrap();
    let rest = structure.state_at_rest(1.5);
    let mut to = rest.clone();
    let stable = structure.stable_time_step();
    let error = structure.advance(&rest, &mut to, 10.0 * stable, 5, &Load::None).unwrap_err();
    assert!(matches!(error, Error::Unstable { remedy: 10, .. }), "{error}");
    assert!(error.to_string().contains("at least 10 sub-steps"), "{error}");
    assert!(matches!(
        structure.advance(&rest, &mut to, 0.0, 5, &Load::None).unwrap_err(),
        Error::Window { .. }
    ));
    let count = structure.particles().interface.len();
    let mut load = vec![V::zeros(); count];
    assert!(matches!(
        structure.advance(&rest, &mut to, stable, 1, &Load::Held(&load[1..])).unwrap_err(),
        Error::Length { expected, given, .. } if expected == count && given == count - 1
    ));
    load[7].y = f64::NAN;
    let error = structure.advance(&rest, &mut to, stable, 1, &Load::Held(&load)).unwrap_err();
    assert!(matches!(error, Error::Load { particle: 7, time: 1.5 }), "{error}");
    // Pull one free particle through its neighbours.
    let mut torn = rest.clone();
    torn.positions[25] += V::from([0.0, 0.5]);
    let error = structure.advance(&torn, &mut to, stable, 1, &Load::None).unwrap_err();
    assert!(matches!(error, Error::Inverted { jacobian, .. } if jacobian <= 0.0), "{error}");
    // A load far beyond what a sub-step can follow.
    let mut hit = vec![V::zeros(); count];
    hit[12] = V::from([1e14, 0.0]);
    let error = structure.advance(&rest, &mut to, 20.0 * stable, 20, &Load::Held(&hit)).unwrap_err();
    assert!(matches!(error, Error::Inverted { .. } | Error::NotFinite { .. }), "{error}");
}

#[test]
fn all_mistakes_of_a_setup_are_reported_at_once() {
    let mut bad = setup(Gradient::FirstOrder, 1.0, true);
    bad.bodies[0].density = -1.0;
    bad.bodies[0].material.poisson_ratio = 0.5;
    bad.options.damping = f64::NAN;
    bad.dead_loads.push(DeadLoad {
        particles: vec![(999, 1.0)],
        force: V::zeros(),
        history: History::constant(),
    });
    let error = TotalLagrangian::new(bad).unwrap_err();
    assert_eq!(error.mistakes.len(), 4, "{error}");
    let line = setup(Gradient::FirstOrder, 1.0, false).bodies.remove(0);
    let mut thin = line.clone();
    for p in &mut thin.positions {
        p.y = 0.0;
    }
    thin.positions.iter_mut().enumerate().for_each(|(i, p)| p.x = 0.1 * i as f64);
    let mut thin = Setup::new(vec![thin]);
    let error = TotalLagrangian::new(thin.clone()).unwrap_err();
    assert!(matches!(error.mistakes[..], [ErrorKind::Layers { body: 0, axis: 1, layers: 1 }]), "{error}");
    thin.options = Options::of(Gradient::FirstOrder);
    let error = TotalLagrangian::new(thin).unwrap_err();
    assert!(error.to_string().contains("do not span"), "{error}");
}
