//! Walls from boxes and polylines.

use fluid::*;
use sph::Vector;
use sph::kernel::CubicSpline;
use sph::lattice::Lattice;

fn v(x: f64, y: f64) -> Vector<2> {
    Vector::from([x, y])
}

fn part(name: &str, shape: WallShape<2>) -> WallPart<2> {
    WallPart { name: name.into(), shape, velocity: Vector::zeros(), motion: None }
}

#[test]
fn a_box_keeps_only_what_a_kernel_reaches() {
    let shape = WallShape::Box { low: v(0.0, 0.0), high: v(10.0, 10.0) };
    let walls = Walls::new(vec![part("block", shape)], 1.0, 2.4).unwrap();
    // A frame three cells deep: 10² − 4².
    assert_eq!(walls.positions.len(), 84);
    assert!(walls.volumes.iter().all(|v| (v - 1.0).abs() < 1e-12));
}

#[test]
fn overlapping_boxes_fill_once() {
    let floor = WallShape::Box { low: v(0.0, -3.0), high: v(10.0, 0.0) };
    let post = WallShape::Box { low: v(4.0, -3.0), high: v(6.0, 5.0) };
    let walls = Walls::new(vec![part("floor", floor), part("post", post)], 1.0, 2.4).unwrap();
    assert_eq!(walls.positions.len(), 30 + 10);
    assert_eq!(walls.part("post"), Some(1));
    assert_eq!(walls.part_of.iter().filter(|p| **p == 1).count(), 10);
}

/// Mitred corners: layers behind a closed square tile the frame around it exactly, outside and inside.
#[test]
fn layers_behind_a_polyline_meet_on_the_mitre() {
    let square = vec![v(0.0, 0.0), v(8.0, 0.0), v(8.0, 8.0), v(0.0, 8.0), v(0.0, 0.0)];
    for (solid, area) in [(Side::Right, 14.0 * 14.0 - 64.0), (Side::Left, 64.0 - 4.0)] {
        let shape = WallShape::Polyline { points: square.clone(), solid };
        let walls = Walls::new(vec![part("tank", shape.clone())], 1.0, 2.4).unwrap();
        let volume: f64 = walls.volumes.iter().sum();
        assert!((volume - area).abs() < 1e-9, "{volume} {area}");
        for p in &walls.positions {
            let d = shape.surface_point(p).distance;
            // At a mitre a row's last particle is as far as the row is deep, at most 2.5.
            assert!(d < -0.4 && d > -2.6 * std::f64::consts::SQRT_2, "{p} {d}");
        }
    }
}

#[test]
fn distances_and_normals_by_hand() {
    let shape = WallShape::Box { low: v(0.0, 0.0), high: v(2.0, 1.0) };
    let beside = shape.surface_point(&v(3.0, 0.5));
    assert_eq!((beside.distance, beside.normal), (1.0, v(1.0, 0.0)));
    let corner = shape.surface_point(&v(5.0, 5.0));
    assert_eq!((corner.distance, corner.normal), (5.0, v(0.6, 0.8)));
    let inside = shape.surface_point(&v(1.0, 0.9));
    assert!((inside.distance + 0.1).abs() < 1e-15 && inside.normal == v(0.0, 1.0));
    // A hook: bed along x, then up. The solid is below and to the right.
    let line =
        WallShape::Polyline { points: vec![v(0.0, 0.0), v(2.0, 0.0), v(2.0, 2.0)], solid: Side::Right };
    let above = line.surface_point(&v(1.0, 0.5));
    assert_eq!((above.distance, above.normal), (0.5, v(0.0, 1.0)));
    assert_eq!(line.surface_point(&v(1.0, -0.25)).distance, -0.25);
    assert!(line.surface_point(&v(2.3, -0.3)).distance < 0.0, "behind the corner is solid");
    assert!(line.surface_point(&v(1.9, 0.1)).distance > 0.0);
}

#[test]
fn impossible_shapes_are_refused() {
    let inside_out = WallShape::Box { low: v(0.0, 1.0), high: v(1.0, 0.0) };
    let error = Walls::new(vec![part("lid", inside_out)], 0.1, 0.24).unwrap_err().to_string();
    assert!(error.contains("lid") && error.contains("above the first"), "{error}");
    let point = WallShape::Polyline { points: vec![v(0.0, 0.0)], solid: Side::Left };
    assert!(Walls::new(vec![part("dot", point)], 0.1, 0.24).is_err());
}

fn solid(low: [f64; 2], high: [f64; 2]) -> WallShape<2> {
    WallShape::Box { low: low.into(), high: high.into() }
}

fn line(points: &[[f64; 2]], solid: Side) -> WallShape<2> {
    WallShape::Polyline { points: points.iter().map(|&p| p.into()).collect(), solid }
}

fn filled(shapes: &[WallShape<2>], spacing: f64) -> Walls<2> {
    let parts = shapes.iter().enumerate().map(|(i, shape)| part(&i.to_string(), shape.clone()));
    Walls::new(parts.collect(), spacing, 2.4 * spacing).unwrap()
}

/// Coordinates that are off by a last bit settle no tie: walls that are moved or mirrored have the same
/// particles.
#[test]
fn walls_are_filled_alike_wherever_they_are() {
    let gate = |spacing: f64| {
        let tank = line(&[[0.0, 0.2], [0.0, 0.0], [0.5, 0.0]], Side::Right);
        (vec![tank, solid([0.1, 0.079], [0.105, 0.2])], spacing)
    };
    let cases = [
        gate(0.0025),
        gate(0.002),
        gate(0.00125),
        // Half a cell over, thinner than a cell, edges on the middles of the other's cells.
        (vec![solid([0.1, 0.1], [0.125, 0.355])], 0.01),
        (vec![solid([0.1, 0.1], [0.105, 0.3]), line(&[[0.1, 0.0], [0.1, 0.1]], Side::Left)], 0.01),
        (vec![solid([0.0, 0.0], [0.1, 0.1]), solid([0.05, 0.05], [0.155, 0.155])], 0.01),
        // Corners of every kind.
        (vec![line(&[[0.0, 0.1], [0.0, 0.0], [0.105, 0.0], [0.2, 0.1], [0.3, 0.1]], Side::Right)], 0.01),
        (vec![line(&[[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1], [0.0, 0.0]], Side::Left)], 0.01),
        (vec![line(&[[0.3, 0.3], [0.0, 0.0]], Side::Left), solid([0.0, -0.1], [0.04, 0.0])], 0.01),
    ];
    for (shapes, spacing) in cases {
        let here = filled(&shapes, spacing);
        let same = |there: &Walls<2>, back: &dyn Fn(&Vector<2>) -> Vector<2>, what: &str| {
            assert_eq!(here.positions.len(), there.positions.len(), "{what}: {shapes:?}");
            for p in there.positions.iter().map(back) {
                let nearest = here.positions.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-9, "{what}: {p}, {shapes:?}");
            }
        };
        for shift in [v(1.0, 0.0), v(0.1, 0.1), v(-0.3, 0.7), v(1000.0, -1000.0)] {
            let moved = shapes.iter().map(|shape| match shape {
                WallShape::Box { low, high } => WallShape::Box { low: low + shift, high: high + shift },
                WallShape::Polyline { points, solid } => {
                    let points = points.iter().map(|p| p + shift).collect();
                    WallShape::Polyline { points, solid: *solid }
                }
            });
            let there = filled(&moved.collect::<Vec<_>>(), spacing);
            same(&there, &|p| p - shift, &format!("moved by {shift:?}"));
        }
        let mirror = |p: &Vector<2>| v(0.35 - p[0], p[1]);
        let mirrored = shapes.iter().map(|shape| match shape {
            WallShape::Box { low, high } => {
                WallShape::Box { low: v(0.35 - high[0], low[1]), high: v(0.35 - low[0], high[1]) }
            }
            WallShape::Polyline { points, solid } => {
                let solid = if *solid == Side::Left { Side::Right } else { Side::Left };
                WallShape::Polyline { points: points.iter().map(mirror).collect(), solid }
            }
        });
        same(&filled(&mirrored.collect::<Vec<_>>(), spacing), &mirror, "mirrored");
    }
}

/// Tanks of water 0.2 m wide, whose lower right corner is made in every way: a polyline that ends at a box,
/// on it, in it, at another polyline, whichever comes first. The first is of boxes alone.
fn tanks() -> Vec<(&'static str, Vec<WallShape<2>>)> {
    let left_and_bed = |to: f64| line(&[[-0.2, 0.4], [-0.2, 0.0], [to, 0.0]], Side::Right);
    let plate = solid([0.0, 0.0], [0.04, 0.24]);
    let long_plate = solid([0.0, -0.1], [0.04, 0.24]);
    let (left, bed) = (solid([-0.24, 0.0], [-0.2, 0.4]), solid([-0.24, -0.04], [0.0, 0.0]));
    let right = line(&[[0.0, 0.0], [0.0, 0.4]], Side::Right);
    vec![
        ("boxes", vec![left.clone(), solid([-0.24, -0.04], [0.04, 0.0]), plate.clone()]),
        ("one polyline", vec![line(&[[-0.2, 0.4], [-0.2, 0.0], [0.0, 0.0], [0.0, 0.4]], Side::Right)]),
        ("at a box's corner", vec![left_and_bed(0.0), plate.clone()]),
        ("at a box's corner, the box first", vec![plate.clone(), left_and_bed(0.0)]),
        ("at a box's face", vec![left_and_bed(0.0), long_plate.clone()]),
        ("in a box", vec![left_and_bed(0.02), long_plate.clone()]),
        ("in a box that comes first", vec![long_plate, left_and_bed(0.02)]),
        ("under a box", vec![left_and_bed(0.02), plate]),
        ("at another polyline", vec![left_and_bed(0.0), right.clone()]),
        ("at another polyline, which comes first", vec![right.clone(), left_and_bed(0.0)]),
        ("behind another polyline", vec![left_and_bed(0.02), right.clone()]),
        ("a polyline on a bed's corner", vec![left, bed.clone(), right.clone()]),
        ("a bed in two", vec![left_and_bed(-0.1), line(&[[-0.1, 0.0], [0.0, 0.0]], Side::Right), right]),
    ]
}

/// All around the water there is wall, once: sums of the kernel over water and walls are those of a lattice.
#[test]
fn corners_are_filled_once() {
    let dx = 0.01;
    let kernel = CubicSpline::<2>::new(1.2 * dx);
    let water = Lattice::<2>::fill_box(v(-0.2, 0.0), v(0.0, 0.2), dx).positions;
    let whole = |at: Vector<2>, walls: &Walls<2>| {
        let of_water: f64 = water.iter().map(|r| dx * dx * kernel.value((r - at).norm())).sum();
        let of_walls = walls.positions.iter().zip(&walls.volumes);
        of_water + of_walls.map(|(r, volume)| volume * kernel.value((r - at).norm())).sum::<f64>()
    };
    let tanks = tanks();
    let lattice = whole(v(-0.105, 0.105), &filled(&tanks[0].1, dx));
    for (name, shapes) in tanks {
        let walls = filled(&shapes, dx);
        for at in water.iter().filter(|at| at[1] < 0.15) {
            let sum = whole(*at, &walls);
            assert!((sum / lattice - 1.0).abs() < 1e-9, "{name}: {sum} of {lattice} at {at:?}");
        }
    }
}

/// And the water in such tanks rests as between boxes, where it moves with 0.008 m/s at most; in the quarter
/// that the corner at a box had open the particles circled at 0.5 m/s.
#[test]
fn water_rests_in_corners_of_every_kind() {
    let dx = 0.01;
    let fastest = |shapes: &[WallShape<2>]| {
        let positions = Lattice::<2>::fill_box(v(-0.2, 0.0), v(0.0, 0.2), dx).positions;
        let properties = FluidProperties {
            density: 1000.0,
            kinematic_viscosity: 1e-6,
            gravity: v(0.0, -9.81),
            spacing: dx,
            particle_volume: dx * dx,
            domain: (v(-0.3, -0.1), v(0.4, 0.6)),
            periodic: [false; 2],
        };
        let at_rest = vec![Vector::zeros(); positions.len()];
        let mut state = State::new(positions, at_rest);
        let none = InterfaceParticles::default();
        let walls = filled(shapes, dx);
        let mut fluid = Isph::new(properties, Options::default(), walls, none, &state).unwrap();
        let (mut time, mut trial, mut fastest) = (0.0, State::default(), 0.0f64);
        while time < 0.5 {
            let dt = fluid.stable_step(&state, time, &[]);
            let report = fluid.step(&state, time, dt, &InterfaceInput::NONE, &mut trial).unwrap();
            std::mem::swap(&mut state, &mut trial);
            time += dt;
            if time > 0.05 {
                fastest = fastest.max(report.max_speed);
            }
        }
        fastest
    };
    let tanks = tanks();
    let between_boxes = fastest(&tanks[0].1);
    for (name, shapes) in &tanks[1..] {
        let speed = fastest(shapes);
        assert!(speed < 1.5 * between_boxes + 0.005, "{name}: {speed} m/s, between boxes {between_boxes}");
    }
}

/// Beyond the ends of a polyline there is no solid, on either side of the line.
#[test]
fn a_drop_passes_over_the_end_of_a_wall() {
    let points = [[0.0, 0.0], [0.0, 1.0]].map(Vector::<2>::from).to_vec();
    let shape = WallShape::Polyline { points, solid: Side::Right };
    let at = |x: f64, y: f64| shape.surface_point(&[x, y].into());
    for x in [-0.003, 0.003] {
        let over = at(x, 1.004);
        assert!((over.distance - 0.005).abs() < 1e-12, "{x}: {over:?}");
        assert!((over.normal - Vector::from([x, 0.004]) / 0.005).norm() < 1e-9, "{x}: {over:?}");
        assert_eq!(at(x, 0.5).distance, -x, "beside it");
    }
}
