//! Clamps that move: what they hold follows exactly, bodies go along unstrained, and works close the account.

use sph::Vector;
use structure::{
    Body, ClampMotion, ErrorKind, Gradient, Law as Material, Load, Options, Plane, Setup, Side, Solid, State,
    TotalLagrangian,
};
use words::motion::Law;
use words::rigid::Motion;

const GRADIENTS: [Gradient; 2] = [Gradient::FirstOrder, Gradient::Quadratic];

fn material() -> structure::Material {
    structure::Material::new(Material::StVenantKirchhoff, 1e6, 0.3, Plane::Strain)
}

/// The motion on all fixed particles.
fn moved<const D: usize>(mut setup: Setup<D>, motion: Motion<D>) -> Setup<D> {
    let clamped: Vec<bool> = setup.bodies.iter().flat_map(|b| b.clamped.iter().copied()).collect();
    let particles = (0..clamped.len()).filter(|&n| clamped[n]).collect();
    setup.motions.push(ClampMotion { particles, motion });
    setup
}

/// A plate four by one, clamped at its left end.
fn plate(gradient: Gradient) -> Setup<2> {
    let body = Body::block(Vector::zeros(), Vector::from([1.0, 0.3]), 0.1, material(), 1000.0);
    let mut setup = Setup::new(vec![body.clamp(0, Side::Low, gradient, gradient.default_smoothing_ratio())]);
    setup.options = Options::of(gradient);
    setup
}

fn smooth(law: Law, ramp: f64) -> Law {
    Law::Late { start: 0.0, ramp, law: Box::new(law) }
}

/// From rest at time 0 over windows of 20 sub-steps of so much of the stable step.
fn run<const D: usize>(structure: &mut TotalLagrangian<D>, windows: usize, fraction: f64) -> State<D> {
    let dt = 20.0 * fraction * structure.stable_time_step();
    let mut from = structure.state_at_rest(0.0);
    let mut to = from.clone();
    for _ in 0..windows {
        structure.advance(&from, &mut to, dt, 20, &Load::None).unwrap();
        std::mem::swap(&mut from, &mut to);
    }
    from
}

#[test]
fn what_is_clamped_follows_its_law_and_the_account_closes() {
    let rolls = Law::Sine { amplitude: 0.1, period: 0.4, phase: 0.0 };
    for gradient in GRADIENTS {
        for motion in [
            Motion::along([0.6, 0.8], smooth(rolls.clone(), 0.2)),
            Motion::Rotation { pivot: [0.3, -0.5], law: smooth(rolls.clone(), 0.2) },
        ] {
            let mut structure = TotalLagrangian::new(moved(plate(gradient), motion.clone())).unwrap();
            let end = run(&mut structure, 30, 0.25);
            let (pose, twist) = (motion.pose(end.time), motion.twist(end.time));
            let particles = structure.particles();
            for n in (0..particles.len()).filter(|&n| particles.clamped[n]) {
                let at = pose.moved(&particles.reference_positions[n]);
                assert!((end.positions[n] - at).norm() < 1e-15, "{gradient:?}");
                assert!((end.velocities[n] - twist.at(&at)).norm() < 1e-15, "{gradient:?}");
            }
            let energy = end.energy;
            assert!(energy.load_work == 0.0 && energy.clamp_work > 1.0 && energy.strain > 0.01, "{energy:?}");
            // The integrator's, at a quarter of the stable step: 9e-7 of the energies with the first-order
            // gradient, 1e-8 with the quadratic one.
            let gained = energy.kinetic + energy.strain;
            assert!(energy.balance().abs() < 1e-5 * gained, "{gradient:?}: {energy:?}");
        }
    }
}

/// Driven at both ends by the same slow motion, a body stays what it was up to its inertia; in two and three
/// dimensions.
#[test]
fn a_body_whose_clamps_all_turn_together_keeps_its_shape() {
    // The step alone, so that it ends as smoothly as it begins.
    let slow = |turn: f64| smooth(Law::Table { table: vec![[-1.0, turn], [0.0, turn]] }, 2.5);
    for gradient in GRADIENTS {
        let ratio = gradient.default_smoothing_ratio();
        let mut setup = plate(gradient);
        setup.bodies =
            setup.bodies.into_iter().map(|body| body.clamp(0, Side::High, gradient, ratio)).collect();
        let motion = Motion::Rotation { pivot: [-1.0, 2.0], law: slow(1.0) };
        keeps_its_shape(moved(setup, motion.clone()), &motion);
    }
    let law = Material::StVenantKirchhoff;
    let material = structure::Material { law, assumption: Plane::ThreeDimensional, ..material() };
    let block = Body::block(Vector::zeros(), Vector::from([0.4, 0.3, 0.3]), 0.1, material, 1000.0);
    let (axis, gradient) = (2, Gradient::Quadratic);
    let ratio = gradient.default_smoothing_ratio();
    let block = block.clamp(axis, Side::Low, gradient, ratio).clamp(axis, Side::High, gradient, ratio);
    let motion = Motion::Rotation { pivot: [-1.0, 2.0, 7.0], law: slow(1.0) };
    keeps_its_shape(moved(Setup::new(vec![block]), motion.clone()), &motion);
}

fn keeps_its_shape<const D: usize>(setup: Setup<D>, motion: &Motion<D>) {
    let mut structure = TotalLagrangian::new(setup).unwrap();
    let windows = (2.6 / (16.0 * structure.stable_time_step())).ceil() as usize;
    let end = run(&mut structure, windows, 0.8);
    let pose = motion.pose(end.time);
    let mut most = 0.0_f64;
    for (x, reference) in end.positions.iter().zip(&structure.particles().reference_positions) {
        let off = (x - pose.moved(reference)).norm();
        most = most.max(off);
    }
    // It swings to and fro by the jerk at the law's end, 60/2.5³ rad/s³ at 2.5 m, over the cube of its lowest
    // frequency, some 30 to 60 rad/s: 4e-4 m at most, of 2 m that it has gone.
    assert!(most < 5e-4 && end.energy.strain < 1e-2, "{most} m, {:?}", end.energy);
}

/// Seen from its base, a plate on a base that moves by `b(t)` is one that stands still under gravity `−b″`:
/// here constant, of a law by pairs that is `½ g t²`.
#[test]
fn an_accelerated_base_is_gravity() {
    let g = 5.0;
    for gradient in GRADIENTS {
        let (mut at_rest, fraction) = (plate(gradient), 0.5);
        at_rest.gravity = Vector::from([0.0, -g]);
        let mut at_rest = TotalLagrangian::new(at_rest).unwrap();
        let end = run(&mut at_rest, 30, fraction);
        // Rows of a parabola: a cubic with mean slopes is exact on it where rows are evenly apart; the first
        // piece, which begins at rest, too, when a row before it has the parabola's value.
        let row = |k: i32| {
            let t = 0.05 * f64::from(k);
            [t, 0.5 * g * t * t]
        };
        let law = Law::Table { table: (-2..60).map(row).collect() };
        let motion = Motion::along([0.0, 1.0], law);
        let mut driven = TotalLagrangian::new(moved(plate(gradient), motion.clone())).unwrap();
        // It begins at the table's value at 0, which is none, and rests.
        let moved = run(&mut driven, 30, fraction);
        let pose = motion.pose(moved.time);
        assert!(moved.time < 2.5, "within the table");
        let largest = |state: &State<2>, at: &dyn Fn(&Vector<2>) -> Vector<2>| {
            let ends = state.positions.iter().zip(&end.positions);
            ends.map(|(x, other)| (at(x) - other).norm()).fold(0.0, f64::max)
        };
        let rest = driven.state_at_rest(0.0);
        let swing = largest(&rest, &|x| *x);
        let off = largest(&moved, &|x| pose.at_rest(x));
        // The integrator's error in two frames: 5e-8 m of 0.18 m.
        assert!(swing > 1e-3 && off < 1e-6 * swing, "{gradient:?}: {off} of {swing}");
    }
}

#[test]
fn a_saved_state_goes_on_to_the_bit_and_time_is_part_of_it() {
    let law = smooth(Law::Sine { amplitude: 0.1, period: 0.4, phase: 0.0 }, 0.2);
    let motion = Motion::Rotation { pivot: [0.0, 0.0], law };
    let mut structure = TotalLagrangian::new(moved(plate(Gradient::Quadratic), motion)).unwrap();
    let half = run(&mut structure, 4, 1.0);
    let saved = State::<2>::from_bytes(&half.to_bytes(), structure.particles().len()).unwrap();
    assert_eq!(saved, half);
    let dt = 10.0 * structure.stable_time_step();
    let mut solve = |from: &State<2>| {
        let mut to = from.clone();
        structure.advance(from, &mut to, dt, 20, &Load::None).unwrap();
        to
    };
    let onward = solve(&half);
    let mut later = half.clone();
    later.time += 0.01;
    assert_ne!(solve(&later).positions, onward.positions);
    assert_eq!(solve(&saved), onward);
}

#[test]
fn only_fixed_particles_are_moved() {
    let mut setup = plate(Gradient::Quadratic);
    let motion = Motion::along([1.0, 0.0], Law::Speed { speed: 1.0 });
    setup.motions.push(ClampMotion { particles: vec![3], motion });
    let error = TotalLagrangian::new(setup).unwrap_err();
    assert!(matches!(error.mistakes[..], [ErrorKind::MovedParticle { index: 0, particle: 3 }]), "{error}");
}
