//! Contact: of bodies with walls, with each other and with themselves; energies, momenta, friction.

use sph::Vector;
use std::f64::consts::PI;
use structure::{
    Body, ClampMotion, DeadLoad, Error, Gradient, History, Law as Material, Load, Options, Plane, Setup,
    Side, Solid, State, TotalLagrangian, Wall, WallShape,
};
use words::motion::Law;
use words::rigid::Motion;

const SPACING: f64 = 0.1;

fn material(assumption: Plane) -> structure::Material {
    structure::Material::new(Material::StVenantKirchhoff, 1e6, 0.3, assumption)
}

fn block(low: [f64; 2], high: [f64; 2]) -> Body<2> {
    Body::block(Vector::from(low), Vector::from(high), SPACING, material(Plane::Strain), 1000.0)
}

fn setup<const D: usize>(bodies: Vec<Body<D>>) -> Setup<D> {
    let mut setup = Setup::new(bodies);
    setup.options = Options { step_fraction: 0.5, ..Options::of(Gradient::FirstOrder) };
    setup
}

fn floor() -> Wall<2> {
    let points = [[-9.0, 0.0], [0.13, 0.0], [9.0, 0.0]].map(Vector::from).to_vec();
    Wall { name: "floor".to_owned(), shape: WallShape::Polyline(points), motion: None }
}

/// A run in windows of two sub-steps, each as long as stability lets it be.
struct Run<const D: usize> {
    solid: TotalLagrangian<D>,
    state: State<D>,
}

impl<const D: usize> Run<D> {
    fn new(setup: Setup<D>, velocity: impl Fn(usize) -> Vector<D>) -> Self {
        let mut solid = TotalLagrangian::new(setup).unwrap();
        let mut state = solid.state_at_rest(0.0);
        for &p in &solid.particles().free.clone() {
            state.velocities[p as usize] = velocity(p as usize);
        }
        solid.evaluate(&mut state).unwrap();
        Self { solid, state }
    }

    fn window(&mut self) -> Result<(), Error> {
        let mut to = self.state.clone();
        let dt = 2.0 * self.state.stability.step;
        self.solid.advance(&self.state, &mut to, dt, 2, &Load::None)?;
        self.state = to;
        Ok(())
    }

    fn until(&mut self, time: f64) {
        while self.state.time < time {
            self.window().unwrap();
        }
    }

    fn momentum(&self) -> Vector<D> {
        self.solid.particles().momentum(&self.state.velocities)
    }

    /// About the third axis, of free particles.
    fn moment(&self) -> f64 {
        let particles = self.solid.particles();
        let of = |p: usize| {
            let (x, u) = (self.state.positions[p], self.state.velocities[p]);
            particles.masses[p] * (x[0] * u[1] - x[1] * u[0])
        };
        particles.free.iter().map(|&p| of(p as usize)).sum()
    }

    fn mean(&self, particles: std::ops::Range<usize>, of: &[Vector<D>]) -> Vector<D> {
        let count = particles.len() as f64;
        of[particles].iter().fold(Vector::zeros(), |sum, v| sum + v / count)
    }
}

#[test]
fn a_block_dropped_on_a_wall_keeps_its_energy_and_bounces() {
    let mut falls = setup(vec![block([0.0, 0.05], [0.5, 0.45])]);
    falls.contact.walls = vec![floor()];
    falls.gravity = Vector::from([0.0, -10.0]);
    let mut run = Run::new(falls, |_| Vector::from([0.3, -2.0]));
    let start = run.state.energy.balance();
    let energy = run.state.energy.kinetic;
    let (mut touched, mut lowest) = (0.0_f64, f64::INFINITY);
    while run.state.time < 0.12 {
        run.window().unwrap();
        touched = touched.max(run.state.energy.contact);
        lowest = lowest.min(run.state.positions.iter().map(|x| x[1]).fold(f64::INFINITY, f64::min));
    }
    let lost = run.state.energy.balance() / start - 1.0;
    println!("dropped: contact {touched} J of {energy}, lowest {lowest}, energy {lost}");
    assert!(touched > 1e-3 * energy && run.state.energy.contact == 0.0);
    assert!(lost.abs() < 0.01 && run.momentum()[1] > 0.0 && lowest > 0.3 * SPACING);
    // The wall is smooth: what goes along it goes on, over the joint of its pieces too.
    assert!((run.momentum()[0] / (200.0 * 0.3) - 1.0).abs() < 1e-12);
}

#[test]
fn blocks_that_collide_keep_momentum_and_energy_and_part() {
    for (aside, spin) in [(0.0, 0.0), (0.23, 0.0), (0.17, 4.0)] {
        for gradient in [Gradient::FirstOrder, Gradient::Quadratic] {
            let mut two =
                setup(vec![block([0.0, 0.0], [0.4, 0.4]), block([0.45, aside], [0.85, aside + 0.4])]);
            two.options = Options { step_fraction: 0.5, ..Options::of(gradient) };
            let positions: Vec<_> = two.bodies.iter().flat_map(|b| b.positions.clone()).collect();
            let centre = Vector::from([0.2, 0.2]);
            let mut run = Run::new(two, |p| {
                let r = positions[p] - centre;
                if p < 16 { Vector::from([3.0 - spin * r[1], spin * r[0]]) } else { Vector::zeros() }
            });
            let (momentum, moment) = (run.momentum(), run.moment());
            let (energy, scale) = (run.state.energy.balance(), run.momentum().norm());
            let mut touched = 0.0_f64;
            while run.state.time < 0.06 {
                run.window().unwrap();
                touched = touched.max(run.state.energy.contact);
            }
            // Forces keep the moment to round-off (the potential's own test); the Runge–Kutta method does not.
            let (dp, dm) = ((run.momentum() - momentum).norm(), (run.moment() - moment).abs());
            let lost = run.state.energy.balance() / energy - 1.0;
            println!(
                "collide {aside} {gradient:?}: {dp} {dm} of {scale}, contact {touched} of {energy}, {lost}"
            );
            assert!(dp < 1e-12 * scale && dm < 1e-6 * scale && touched > 1e-3 * energy);
            assert!(lost.abs() < 0.01 && run.state.energy.contact == 0.0);
            let gone = |own: std::ops::Range<usize>| run.mean(own, &run.state.velocities)[0];
            assert!(gone(16..32) > gone(0..16), "they part");
        }
    }
}

#[test]
fn stacked_blocks_rest_and_what_only_touches_has_no_force() {
    let mut stack = setup(vec![block([0.0, 0.0], [0.5, 0.3]), block([0.07, 0.3], [0.47, 0.6])]);
    stack.contact.walls = vec![floor()];
    let still = Run::new(stack.clone(), |_| Vector::zeros());
    assert_eq!(still.state.energy.contact, 0.0);
    stack.gravity = Vector::from([0.0, -10.0]);
    stack.options.damping = 20.0;
    // Without friction the upper block slides off the lower one's bulge.
    stack.contact.options.friction = 0.3;
    let mut run = Run::new(stack, |_| Vector::zeros());
    run.until(2.0);
    let sunk = run.mean(15..27, &run.state.positions)[1] - 0.45;
    println!("stacked: {} J, upper sunk {sunk}", run.state.energy.kinetic);
    // Weight over modulus: 27 blocks' heights 0.45 m, 4.5 kPa of 1 MPa; contact adds to the strain's own.
    assert!(run.state.energy.kinetic < 1e-10 && sunk < 0.0 && sunk > -0.02 * SPACING * 3.0);
}

/// Gravity is turned instead of the floor. At μ = 0.5 a slope of 0.4 holds and of 0.7 does not.
#[test]
fn a_block_on_an_incline_sticks_or_slides_as_coulomb_says() {
    let (mu, g) = (0.5, 10.0);
    for slope in [0.4_f64, 0.7] {
        let mut rests = setup(vec![block([0.0, 0.0], [0.5, 0.3])]);
        rests.contact.walls = vec![floor()];
        rests.contact.options.friction = mu;
        let angle = slope.atan();
        // Softly, so that it does not bounce: 150 kg, evenly.
        let weight = Vector::from([angle.sin(), -angle.cos()]) * (g * 150.0);
        let evenly = (0..15).map(|p| (p, 1.0 / 15.0)).collect();
        rests.dead_loads.push(DeadLoad { particles: evenly, force: weight, history: History::ramp(0.3) });
        rests.options.damping = if slope < mu { 60.0 } else { 0.0 };
        let mut run = Run::new(rests, |_| Vector::zeros());
        let at = |run: &Run<2>| {
            (
                run.state.time,
                run.mean(0..15, &run.state.positions)[0],
                run.mean(0..15, &run.state.velocities)[0],
            )
        };
        if slope < mu {
            run.until(1.0);
            let (_, before, _) = at(&run);
            let stuck = run.state.sticks.len();
            run.until(2.0);
            let (_, after, speed) = at(&run);
            println!("sticks: {} m, {speed} m/s, {stuck} springs", after - before);
            assert!((after - before).abs() < 1e-9 && speed.abs() < 1e-9 && stuck > 0);
        } else {
            run.until(0.5);
            let (start, _, before) = at(&run);
            run.until(2.0);
            let (end, _, after) = at(&run);
            let speed = after - before;
            let expected = g * (angle.sin() - mu * angle.cos()) * (end - start);
            let energy = run.state.energy;
            println!(
                "slides: {speed} m/s for {expected}, lost {} J, account {}",
                energy.friction_loss,
                energy.balance()
            );
            assert!((speed / expected - 1.0).abs() < 0.02);
            assert!(energy.friction_loss > 0.0 && energy.balance().abs() < 0.01 * energy.friction_loss);
        }
    }
}

/// Friction between bodies keeps momentum and its moment, takes energy and gives none.
#[test]
fn friction_between_bodies_keeps_momenta_and_takes_energy() {
    let mut two = setup(vec![block([0.0, 0.0], [0.8, 0.3]), block([0.1, 0.31], [0.5, 0.61])]);
    two.contact.options.friction = 0.3;
    let mut run = Run::new(two, |p| if p < 24 { Vector::zeros() } else { Vector::from([2.0, -1.0]) });
    let (momentum, moment, energy) = (run.momentum(), run.moment(), run.state.energy);
    let mut lost = 0.0;
    while run.state.time < 0.06 {
        run.window().unwrap();
        let now = run.state.energy.friction_loss;
        assert!(now >= lost - 1e-6 * energy.kinetic, "{lost} {now}");
        lost = now;
    }
    let (dp, dm) = ((run.momentum() - momentum).norm(), (run.moment() - moment).abs());
    let account = run.state.energy.balance() / energy.kinetic - 1.0;
    println!("rubbing: {dp} {dm}, lost {lost} of {}, account {account}", energy.kinetic);
    assert!(dp < 1e-10 && dm < 1e-4 && lost > 0.01 * energy.kinetic && account.abs() < 0.01);
}

/// Pressed by a dead load, a clamped plate bends onto a wall and stays on its side of it.
#[test]
fn a_plate_pushed_onto_a_wall_lies_on_it() {
    let gradient = Gradient::FirstOrder;
    let body = block([0.0, 0.1], [1.2, 0.4]).clamp(0, Side::Low, gradient, 1.2);
    let mut plate = setup(vec![body]);
    let corners = (Vector::from([0.6, -1.0]), Vector::from([2.0, 0.0]));
    let shape = WallShape::Box { low: corners.0, high: corners.1 };
    plate.contact.walls = vec![Wall { name: "anvil".to_owned(), shape, motion: None }];
    plate.options.damping = 40.0;
    let tip = (0..36).map(|p| (p, 1.0 / 36.0)).collect();
    let force = Vector::from([0.0, -1e4]);
    plate.dead_loads.push(DeadLoad { particles: tip, force, history: History::ramp(0.1) });
    let mut run = Run::new(plate, |_| Vector::zeros());
    run.until(0.3);
    let lowest = (0..36).map(|p| run.state.positions[p]).filter(|x| x[0] > 0.6).map(|x| x[1]);
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    println!("pushed: lowest centre {lowest}, {:?}", run.state.energy);
    assert!(lowest < 0.5 * SPACING && lowest > 0.3 * SPACING && run.state.energy.contact > 0.0);
}

/// A wall that goes through a plate clamped above pushes it along; its work closes the account.
#[test]
fn a_wall_that_moves_pushes_a_plate_and_its_work_closes_the_account() {
    let gradient = Gradient::FirstOrder;
    let mut plate = setup(vec![block([0.0, 0.0], [0.4, 1.2]).clamp(1, Side::High, gradient, 1.2)]);
    let law = Law::Late { start: 0.0, ramp: 0.05, law: Box::new(Law::Speed { speed: 2.0 }) };
    let shape = WallShape::Box { low: Vector::from([-0.5, 0.1]), high: Vector::from([-0.02, 0.4]) };
    let motion = Some(Motion::along([1.0, 0.0], law));
    plate.contact.walls = vec![Wall { name: "piston".to_owned(), shape, motion }];
    let mut run = Run::new(plate, |_| Vector::zeros());
    run.until(0.15);
    let face = -0.02 + 2.0 * (run.state.time - 0.025);
    let free = run.solid.particles().free.clone();
    let before = |p: &&u32| {
        let x = run.state.positions[**p as usize];
        (0.1..0.4).contains(&x[1]) && x[0] < face
    };
    let behind = free.iter().filter(before).count();
    let energy = run.state.energy;
    println!("pushed by a wall: {behind} behind, {energy:?}, account {}", energy.balance());
    assert!(behind == 0 && energy.wall_work > 100.0 && energy.balance().abs() < 0.01 * energy.wall_work);
}

/// The same by a body that its clamps drive, and the other way round: the body is driven into a clamped one.
#[test]
fn clamps_that_move_press_bodies_and_their_work_closes_the_account() {
    let mut driver = block([-0.4, 0.0], [-0.02, 0.4]);
    driver.clamped.fill(true);
    let moved = (0..driver.positions.len()).collect();
    let mut pushed = setup(vec![driver, block([0.0, 0.0], [0.4, 0.4])]);
    let law = Law::Late { start: 0.0, ramp: 0.02, law: Box::new(Law::Speed { speed: 1.0 }) };
    pushed.motions.push(ClampMotion { particles: moved, motion: Motion::along([1.0, 0.0], law) });
    let mut run = Run::new(pushed, |_| Vector::zeros());
    run.until(0.1);
    let energy = run.state.energy;
    println!("driven: {energy:?}, account {}", energy.balance());
    assert!(energy.clamp_work > 50.0 && energy.balance().abs() < 0.01 * energy.clamp_work);
}

#[test]
fn a_block_falls_on_a_floor_in_three_dimensions() {
    let low = Vector::from([0.0, 0.02, 0.0]);
    let body = Body::block(
        low,
        low + Vector::from([0.4, 0.3, 0.3]),
        SPACING,
        material(Plane::ThreeDimensional),
        1000.0,
    );
    let beside = Body::block(
        Vector::from([0.13, 0.34, 0.07]),
        Vector::from([0.43, 0.64, 0.37]),
        SPACING,
        material(Plane::ThreeDimensional),
        1000.0,
    );
    let mut falls = setup(vec![body, beside]);
    let shape = WallShape::Box { low: Vector::repeat(-5.0), high: Vector::from([5.0, 0.0, 5.0]) };
    falls.contact.walls = vec![Wall { name: "floor".to_owned(), shape, motion: None }];
    falls.options.step_fraction = 0.25;
    let mut run = Run::new(falls, |_| Vector::from([0.0, -2.0, 0.0]));
    let start = run.state.energy.balance();
    let aside = run.momentum();
    let mut touched = 0.0_f64;
    while run.state.time < 0.06 {
        run.window().unwrap();
        touched = touched.max(run.state.energy.contact);
    }
    let lost = run.state.energy.balance() / start - 1.0;
    println!("in three dimensions: contact {touched} of {start}, energy {lost}, momentum {}", run.momentum());
    assert!(touched > 1e-3 * start && lost.abs() < 0.01 && run.momentum()[1] > 0.0);
    assert!((run.momentum() - aside)[0].abs() < 1e-10 && (run.momentum() - aside)[2].abs() < 1e-10);
}

/// The two legs of a hairpin are driven towards each other: they meet and do not pass.
#[test]
fn a_strip_bent_onto_itself_meets_itself() {
    let spacing = SPACING;
    let mut hairpin = block([0.0, 0.0], [1.5, 0.8]);
    let keep: Vec<bool> = hairpin.positions.iter().map(|x| (x[1] - 0.4).abs() > 0.1 || x[0] < 0.3).collect();
    let mut n = 0;
    hairpin.positions.retain(|_| {
        n += 1;
        keep[n - 1]
    });
    hairpin.volumes.truncate(hairpin.positions.len());
    hairpin.clamped.truncate(hairpin.positions.len());
    let upper: Vec<bool> = hairpin.positions.iter().map(|x| x[1] > 0.4 && x[0] > 1.0).collect();
    let lower: Vec<bool> = hairpin.positions.iter().map(|x| x[1] < 0.4 && x[0] > 1.0).collect();
    let mut strip = setup(vec![hairpin]);
    strip.options.step_fraction = 0.25;
    let mut run = Run::new(strip, |p| {
        let speed = 3.0;
        Vector::from([
            0.0,
            if upper[p] {
                -speed
            } else if lower[p] {
                speed
            } else {
                0.0
            },
        ])
    });
    let start = run.state.energy.balance();
    let momentum = run.momentum();
    let (mut touched, mut least) = (0.0_f64, f64::INFINITY);
    while run.state.time < 0.12 {
        run.window().unwrap();
        touched = touched.max(run.state.energy.contact);
        for (p, x) in run.state.positions.iter().enumerate().filter(|(p, _)| upper[*p]) {
            for (q, y) in run.state.positions.iter().enumerate().filter(|(q, _)| lower[*q]) {
                assert!(p != q);
                least = least.min((x - y).norm());
            }
        }
    }
    let lost = run.state.energy.balance() / start - 1.0;
    println!("hairpin: contact {touched} of {start}, least distance {least}, energy {lost}");
    assert!(touched > 1e-3 * start && least > 0.5 * spacing && lost.abs() < 0.01);
    assert!((run.momentum() - momentum).norm() < 1e-10);
}

/// Two baffles clamped beside each other: one is thrown at the other, they touch, swing and part.
#[test]
fn two_baffles_touch_and_part() {
    let gradient = Gradient::FirstOrder;
    let baffle = |x: f64| block([x, 0.0], [x + 0.3, 1.2]).clamp(1, Side::Low, gradient, 1.2);
    let mut two = setup(vec![baffle(0.0), baffle(0.35)]);
    two.options.step_fraction = 0.25;
    let count = two.bodies[0].positions.len();
    let heights: Vec<f64> = two.bodies.iter().flat_map(|b| &b.positions).map(|x| x[1]).collect();
    let mut run = Run::new(two, |p| {
        let speed = if p < count { 4.0 * (heights[p] / 1.2).powi(2) } else { 0.0 };
        Vector::from([speed, 0.0])
    });
    let start = run.state.energy.balance();
    let (mut touched, mut apart_again) = (0.0_f64, false);
    while run.state.time < 0.25 {
        run.window().unwrap();
        touched = touched.max(run.state.energy.contact);
        apart_again |= touched > 0.0 && run.state.energy.contact == 0.0;
    }
    let lost = run.state.energy.balance() / start - 1.0;
    println!("baffles: contact {touched} of {start}, energy {lost}");
    assert!(touched > 1e-4 * start && apart_again && lost.abs() < 0.01);
}

#[test]
fn a_saved_state_in_contact_goes_on_to_the_bit_whatever_the_threads() {
    let mut stack = setup(vec![block([0.0, 0.0], [4.8, 2.4]), block([0.07, 2.4], [4.07, 4.8])]);
    stack.contact.walls = vec![floor()];
    stack.contact.options.friction = 0.4;
    stack.gravity = Vector::from([4.0, -10.0]);
    let in_pool = |threads: usize, windows: (usize, usize)| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut run = Run::new(stack.clone(), |p| Vector::from([(p as f64 * 0.7).sin(), -0.5]));
            (0..windows.0).for_each(|_| run.window().unwrap());
            let bytes = run.state.to_bytes();
            let mut again = Run::new(stack.clone(), |_| Vector::zeros());
            again.state = State::from_bytes(&bytes, again.solid.particles().len()).unwrap();
            assert_eq!(again.state, run.state);
            (0..windows.1).for_each(|_| run.window().unwrap());
            (0..windows.1).for_each(|_| again.window().unwrap());
            assert_eq!(again.state, run.state);
            run.state
        })
    };
    let one = in_pool(1, (2, 2));
    assert!(one.sticks.len() > 10 && one.energy.contact > 0.0);
    assert_eq!(one, in_pool(3, (2, 2)));
    assert_eq!(one, in_pool(2, (3, 1)));
}

/// Speeds of a part of the wave speed, 37 m/s, are held; what is faster ends the run and says where.
#[test]
fn what_is_too_fast_is_told() {
    let mut falls = setup(vec![block([0.0, 0.05], [0.5, 0.45])]);
    falls.contact.walls = vec![floor()];
    falls.contact.names = vec!["hammer".to_owned()];
    let mut run = Run::new(falls.clone(), |_| Vector::from([0.0, -5.0]));
    run.until(0.02);
    assert!(run.momentum()[1] > 0.0);
    let mut run = Run::new(falls, |_| Vector::from([0.0, -60.0]));
    let error = (0..200).find_map(|_| run.window().err()).expect("no surface holds that");
    let said = error.to_string();
    println!("{said}");
    assert!(matches!(error, Error::Passed { .. } | Error::Inverted { .. }), "{said}");
}

/// Far from everything contact changes nothing, to the bit.
#[test]
fn nothing_near_changes_nothing() {
    let body = block([0.0, 0.0], [1.2, 0.4]).clamp(0, Side::Low, Gradient::Quadratic, 1.0);
    let mut alone = setup(vec![body]);
    alone.options = Options::of(Gradient::Quadratic);
    alone.gravity = Vector::from([0.0, -10.0]);
    let run = |walls: Vec<Wall<2>>, on: bool| {
        let mut setup = alone.clone();
        setup.contact.walls = walls;
        setup.contact.options.itself = on;
        let mut run = Run::new(setup, |_| Vector::from([0.0, 0.5 * PI]));
        run.until(0.05);
        run.state
    };
    let mut far = floor();
    far.shape = WallShape::Box { low: Vector::from([-9.0, -9.0]), high: Vector::from([9.0, -3.0]) };
    assert_eq!(run(vec![far], true), run(Vec::new(), false));
}
