//! Boundaries: walls that move, periodic sides; and free surfaces that break in three dimensions.

use crate::support::{Run, filled, solid, v, water};
use fluid::*;
use sph::Vector;

fn gate_tank(dx: f64, law: Law) -> Run<2> {
    let t = 4.0 * dx;
    let mut gate = solid("gate", v(0.1, 0.0), v(0.1 + t, 0.3));
    gate.motion = Some(Motion::Translation { direction: [0.0, 1.0], law });
    let walls = vec![
        solid("bed", v(-t, -t), v(0.5 + t, 0.0)),
        solid("left", v(-t, 0.0), v(0.0, 0.6)),
        solid("right", v(0.5, 0.0), v(0.5 + t, 0.6)),
        gate,
    ];
    filled((v(0.0, 0.0), v(0.1, 0.2)), dx, water(dx), walls, Options::default())
}

#[test]
fn a_gate_that_lifts_lets_the_water_out_beneath_it() {
    let dx = 0.01;
    let law = Law::Table { table: vec![[0.0, 0.0], [0.1, 0.0], [0.2, 0.1], [0.3, 0.3]] };
    let mut run = gate_tank(dx, law.clone());
    let mut excess: f64 = 0.0;
    run.to(0.35, |time, state, report| {
        assert_eq!((report.left, report.lost), (0, 0));
        excess = excess.max(state.memory.energy_excess);
        let gate = law.at(time);
        for r in &state.positions {
            let inside = r.x > 0.1 && r.x < 0.1 + 4.0 * dx && r.y > gate && r.y < gate + 0.3;
            assert!(!inside, "{r} is in the gate, which is at {gate}");
            assert!(time > 0.1 || r.x < 0.1, "{r} has leaked at {time}");
        }
    });
    let front = run.state.positions.iter().map(|r| r.x).fold(0.0, f64::max);
    assert!(front > 0.3, "{front}");
    // The gate slides along the water without friction, and what it gives is not counted as the fluid's own:
    // measured 0.0033, ten particles wide.
    let scale = 0.5 * 1000.0 * 9.81 * 0.1 * 0.2 * 0.2;
    assert!(excess < 5e-3 * scale, "{excess} of {scale}");
}

#[test]
fn a_step_with_a_wall_that_moves_repeats_to_the_bit() {
    let law = Law::Table { table: vec![[0.0, 0.0], [0.1, 0.1]] };
    let (mut run, mut again) = (gate_tank(0.01, law.clone()), gate_tank(0.01, law));
    run.to(0.05, |_, _, _| ());
    let (mut first, mut second) = (State::default(), State::default());
    let step = |fluid: &mut Isph<2>, time: f64, out: &mut State<2>| {
        fluid.step(&run.state, time, 1e-4, &InterfaceInput::NONE, out).unwrap();
    };
    step(&mut run.fluid, 0.05, &mut first);
    step(&mut again.fluid, 0.3, &mut second);
    step(&mut again.fluid, 0.05, &mut second);
    assert!(first.to_bytes() == second.to_bytes());
}

/// A piston far faster than anything else in the tank: no step lets it go farther than fluid may, not the one
/// in which it starts either.
#[test]
fn a_step_is_short_enough_for_walls_that_move() {
    let dx = 0.01;
    let speed = 20.0;
    let law = Law::Table { table: vec![[0.0, 0.0], [0.1, 0.0], [0.11, 0.1], [0.12, 0.3], [0.13, 0.5]] };
    let run = gate_tank(dx, law.clone());
    let options = run.fluid.options();
    let farthest = options.courant * options.smoothing_ratio * dx;
    for i in 0..1300 {
        let time = 1e-4 * f64::from(i);
        let dt = run.fluid.stable_step(&run.state, time, &[]);
        let gone = (law.at(time + dt) - law.at(time)).abs();
        assert!(gone <= farthest, "{gone} in {dt} from {time}");
        // Never shorter than the fastest motion asks for (the cubic may be a half faster than its rows), with
        // the tenth that a round takes.
        assert!(dt > 0.9 * farthest / (1.5 * speed), "{dt} at {time}");
    }
    // Before and after, the walls rest and the fluid alone counts.
    let at_rest = run.fluid.stable_step(&run.state, 1.0, &[]);
    assert_eq!(run.fluid.stable_step(&run.state, 0.0, &[]), at_rest);
    assert!(run.fluid.stable_step(&run.state, 0.12, &[]) < 0.2 * at_rest);
}

/// A tank that rolls by 5° about the middle of its bed: nothing is lost, and the surface stays level while
/// the tank tilts.
#[test]
fn a_tank_that_rolls_keeps_its_water() {
    let dx = 0.02;
    let (width, height) = (0.4, 0.2);
    let t = 4.0 * dx;
    let law = Law::Sine { amplitude: 0.0873, period: 2.0, phase: 0.0 };
    let motion = Motion::Rotation { pivot: [0.5 * width, 0.0], law: law.clone() };
    let mut walls = vec![
        solid("bed", v(-t, -t), v(width + t, 0.0)),
        solid("left", v(-t, 0.0), v(0.0, 0.5)),
        solid("right", v(width, 0.0), v(width + t, 0.5)),
    ];
    walls.iter_mut().for_each(|wall| wall.motion = Some(motion.clone()));
    let mut run = filled((v(0.0, 0.0), v(width, height)), dx, water(dx), walls, Options::default());
    let mut tilted = 0;
    run.to(0.6, |time, state, report| {
        assert_eq!((report.left, report.lost), (0, 0));
        assert!(report.mean_density_error.abs() < 0.01);
        let pose = motion.pose(time);
        for r in &state.positions {
            let own = pose.at_rest(r);
            assert!(own.x > 0.0 && own.x < width && own.y > 0.0, "{own} is in a wall at {time}");
        }
        // At the greatest tilt (counter-clockwise) the water has run to the tank's left by H tan(angle)
        // W²/12H of its own frame, 6 mm, and more as it is in motion.
        if (time - 0.5).abs() < 0.02 {
            let mean = state.positions.iter().map(|r| pose.at_rest(r).x).sum::<f64>() / state.len() as f64;
            let level = 0.5 * width - law.at(time).tan() * width * width / (12.0 * height);
            assert!((mean - level).abs() < 0.006, "{mean} for {level}");
            tilted += 1;
        }
    });
    assert!(tilted > 0);
}

#[test]
fn a_domain_too_short_to_repeat_is_refused() {
    let properties =
        FluidProperties { periodic: [true, false], domain: (v(0.0, 0.0), v(0.2, 1.0)), ..water(0.05) };
    let walls = Walls::new(Vec::new(), 0.05, 0.12).unwrap();
    let state = State::new(vec![v(0.1, 0.1)], vec![v(0.0, 0.0)]);
    let made = Isph::new(properties, Options::default(), walls, InterfaceParticles::default(), &state);
    assert!(made.err().unwrap().to_string().contains("fluid.periodic"));
}

/// A cube of water collapses in a box: the same code in three dimensions.
#[test]
fn a_dam_breaks_in_three_dimensions() {
    let dx = 0.1;
    let p = |x: f64, y: f64, z: f64| Vector::<3>::from([x, y, z]);
    let t = 3.0 * dx;
    let (length, width) = (1.5, 0.5);
    let walls = vec![
        solid("bed", p(-t, -t, -t), p(length + t, width + t, 0.0)),
        solid("west", p(-t, -t, 0.0), p(0.0, width + t, 2.0)),
        solid("east", p(length, -t, 0.0), p(length + t, width + t, 2.0)),
        solid("south", p(0.0, -t, 0.0), p(length, 0.0, 2.0)),
        solid("north", p(0.0, width, 0.0), p(length, width + t, 2.0)),
    ];
    let mut run = filled((p(0.0, 0.0, 0.0), p(0.5, width, 1.0)), dx, water(dx), walls, Options::default());
    let start = 0.5 * 9810.0 * 0.5 * width;
    let (mut front, mut highest) = (0.0f64, 0.0f64);
    run.to(0.6, |time, state, report| {
        assert_eq!(report.lost, 0);
        assert!(report.mean_density_error.abs() < 0.01, "{}", report.mean_density_error);
        highest = highest.max(report.kinetic_energy + report.potential_energy);
        if time < 0.3 {
            front = state.positions.iter().map(|r| r.x).fold(0.0, f64::max) + 0.5 * dx;
        }
    });
    assert!(highest < 1.001 * start, "{highest} of {start}");
    // Martin and Moyce: T = 0.3 √(2g/a) = 1.88 at Z = 2.17, which is 1.09; coarse as it is, between 1.0 and
    // 1.35.
    assert!(front > 1.0 && front < 1.35, "{front}");
}
