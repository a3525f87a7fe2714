//! Walls from boxes and polylines.

use fluid::{Side, WallPart, WallShape, Walls};
use sph::Vector;

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
