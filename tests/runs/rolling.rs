//! A small tank of oil that rolls with a baffle clamped to its bed, coarse: the clamp goes with the wall, and
//! probes go with both.

use crate::support::{Bench, Outputs, assert_same};

/// 200 particles of oil, three by fifteen in the baffle; it has rolled 4° by 0.1 s.
const TANK: &str = r#"
[case]
title = "Rolling tank"
dimension = 2
end_time = 0.1
output_interval = 0.05
gravity = [0.0, -9.81]
particle_spacing = 8e-3

[motion.roll]
pivot = [0.106, 0.0]
amplitude = 0.07
period = 0.4
ramp = 0.1

[fluid]
density = 917.0
kinematic_viscosity = 5e-5
domain = { low = [-0.1, -0.1], high = [0.3, 0.3] }

[[fluid.region]]
name = "left"
box = { low = [0.0, 0.0], high = [0.1, 0.064] }

[[fluid.region]]
name = "right"
box = { low = [0.112, 0.0], high = [0.212, 0.064] }

[[fluid.wall]]
name = "tank"
polyline = [[0.0, 0.15], [0.0, 0.0], [0.212, 0.0], [0.212, 0.15]]
solid_side = "right"
slip = "no-slip"
motion = "roll"

[structure]
particle_spacing = 4e-3

[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 1e6
poisson_ratio = 0.4
density = 1100.0

[[structure.body]]
name = "baffle"
box = { low = [0.1, 0.0], high = [0.112, 0.06] }

[[structure.clamp]]
name = "bed"
body = "baffle"
face = "bottom"
with_wall = "tank"

[[probe]]
name = "foot"
on = "structure"
quantity = "displacement"
at = [0.106, 0.0]
relative_to = "tank"

[[probe]]
name = "foot-speed"
on = "structure"
quantity = "velocity"
at = [0.106, 0.0]
relative_to = "roll"

[[probe]]
name = "tip"
on = "structure"
quantity = "displacement"
at = [0.106, 0.06]
relative_to = "bed"

[[probe]]
name = "tip-at-rest"
on = "structure"
quantity = "displacement"
at = [0.106, 0.06]

[[probe]]
name = "oil"
on = "fluid"
quantity = "extent"
relative_to = "tank"

[[probe]]
name = "corner"
on = "wall"
quantity = "pressure"
at = [0.0, 0.004]
relative_to = "tank"
"#;

fn run(bench: &Bench, out: &str, words: &[&str]) -> Outputs {
    let file = bench.path("case.toml");
    std::fs::write(&file, TANK).expect("a case");
    let file = file.display().to_string();
    let ended = bench.start_run(out, &[&[file.as_str(), "--no-report"], words].concat()).wait();
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    bench.outputs(out)
}

#[test]
fn a_baffle_rolls_with_its_tank() {
    let bench = Bench::new();
    let tank = run(&bench, "processes", &[]);
    assert_same(&tank, &run(&bench, "in-process", &["--in-process"]));
    let (windows, probes) = (tank.table("windows.csv"), tank.table("probes.csv"));
    let probe = |name: &str| probes.get(name).unwrap_or_else(|| panic!("{name}")).to_vec();
    let largest = |name: &str| probe(name).iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    // The fixed nodes nearest to the foot are at it; the point between particles is read to the second order.
    for (name, tolerance) in [("foot.ux", 1e-5), ("foot.uy", 1e-5), ("foot-speed.vx", 2e-3)] {
        assert!(largest(name) < tolerance, "{name}: {}", largest(name));
    }
    // Rolled by 0.07 rad to the left, the tip has gone 4.2 mm to the left, and less or more as it bends.
    let (tip, at_rest) = (probe("tip.ux"), probe("tip-at-rest.ux"));
    let end = tip.len() - 1;
    let carried = -0.06 * 0.07_f64.sin();
    assert!((at_rest[end] - tip[end] - carried).abs() < 2e-4, "{} {}", at_rest[end], tip[end]);
    let column = |name: &str| windows.get(&format!("structure.{name}")).expect("a column").to_vec();
    let (kinetic, strain) = (column("kinetic_energy"), column("strain_energy"));
    let (loads, clamps) = (column("load_work"), column("clamp_work"));
    let off = (0..loads.len()).map(|n| (kinetic[n] + strain[n] - loads[n] - clamps[n]).abs());
    let off = off.fold(0.0, f64::max);
    let most = clamps.iter().fold(0.0_f64, |most, work| most.max(work.abs()));
    // The integrator's loss in the modes that each window's load strikes: 1.5e-7 J of 1.3e-3 J with 100
    // sub-steps a window; with as few as are stable 5.7e-6 J, and 8.2e-6 J where the same tank stands still.
    assert!(most > 1e-4 && off < 5e-4 * most, "{off} J of {most} J");
    // The bed is where it was, seen from the tank, to a fraction of a spacing; without the frame its corners
    // are 7 mm off.
    let bed = probe("oil.bottom");
    assert!(bed.iter().all(|y| y.abs() < 2e-3), "{bed:?}");
    assert!(probe("oil.left").iter().all(|x| x.abs() < 2e-3));
    assert!(probe("corner.p").iter().all(|p| (0.0..2e3).contains(p)));
    let fluid = tank.summary().fluid.expect("a fluid");
    assert!(fluid.particles_lost == 0, "{fluid:?}");
}
