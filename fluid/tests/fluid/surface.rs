//! Free-surface detection on a lattice block.

use fluid::isph::surface::detection::{KNOWN, Surface, smoothing};
use fluid::isph::surface::surface_offset;
use fluid::particles::neighbourhood::{Bodies, Neighbourhood};
use fluid::{Options, SurfaceClass};
use sph::Vector;
use sph::kernel::CubicSpline;
use sph::lattice::Lattice;
use sph::neighbours::CellGrid;

#[test]
fn smoothing_runs_from_surface_to_interior_with_the_factor_pi() {
    assert_eq!(smoothing(0.6, (0.7, 0.8)), 0.0);
    assert_eq!(smoothing(0.81, (0.7, 0.8)), 1.0);
    assert!((smoothing(0.75, (0.7, 0.8)) - 0.5).abs() < 1e-12);
    // A quarter of the way: ½ (1 − cos(π/4)).
    assert!((smoothing(0.725, (0.7, 0.8)) - 0.5 * (1.0 - 0.5f64.sqrt())).abs() < 1e-12);
}

/// Neighbourhood and surface of points without bodies, unit spacing.
fn detect<const D: usize>(points: &[Vector<D>]) -> (Neighbourhood<D>, Surface<D>) {
    let kernel = CubicSpline::new(1.2);
    let none = CellGrid::new(&[], 2.4);
    let bodies = Bodies {
        wall_positions: &[],
        wall_volumes: &[],
        wall_grid: &none,
        structure_positions: &[],
        structure_volumes: &[],
    };
    let (mut neighbourhood, mut surface) = (Neighbourhood::default(), Surface::default());
    neighbourhood.update(&kernel, 1.0, 1.0, points, &bodies);
    let mut corrections = Vec::new();
    neighbourhood.corrections(0.25, &mut corrections);
    let before = vec![SurfaceClass::Interior; points.len()];
    surface.detect(&neighbourhood, &corrections, points, &before, &Options::default(), 1.2);
    (neighbourhood, surface)
}

/// The second layer of a block, whose `∇·r/D` is 0.02 below the threshold, comes onto the surface from 0.04
/// below only, and has not left it yet.
#[test]
fn a_particle_comes_onto_the_surface_later_than_off_it() {
    let points = Lattice::<2>::fill_box(Vector::zeros(), [10.0, 10.0].into(), 1.0).positions;
    let (neighbourhood, mut surface) = detect(&points);
    let second = points.iter().position(|p| *p == Vector::from([5.5, 8.5])).unwrap();
    let divergence = neighbourhood.surroundings[second].moment.trace() / 2.0;
    let mut corrections = Vec::new();
    neighbourhood.corrections(0.25, &mut corrections);
    let mut class = |before: SurfaceClass, above: f64| {
        let thresholds = (divergence + above, divergence + above + 0.1);
        let options =
            Options { surface_thresholds: thresholds, surface_hysteresis: 0.04, ..Options::default() };
        surface.detect(&neighbourhood, &corrections, &points, &vec![before; points.len()], &options, 1.2);
        (surface.classes[second], surface.alpha[second])
    };
    assert_eq!(class(SurfaceClass::NearSurface, 0.02), (SurfaceClass::NearSurface, KNOWN));
    assert_eq!(class(SurfaceClass::Interior, 0.05), (SurfaceClass::Surface, 0.0));
    assert_eq!(class(SurfaceClass::Surface, 0.02), (SurfaceClass::Surface, 0.0));
}

fn block_classes<const D: usize>(side: usize) {
    let high = Vector::repeat(side as f64);
    let mut points = Lattice::<D>::fill_box(Vector::zeros(), high, 1.0).positions;
    let count = points.len();
    points.push(Vector::repeat(3.0 * side as f64));
    let (_, surface) = detect(&points);
    for (a, p) in points.iter().enumerate().take(count) {
        let layer = p.iter().map(|x| (x - 0.5).min(side as f64 - 0.5 - x) as usize).min().unwrap();
        let expected =
            [SurfaceClass::Surface, SurfaceClass::NearSurface, SurfaceClass::Interior][layer.min(2)];
        assert_eq!(surface.classes[a], expected, "{p} in layer {layer}");
        assert_eq!(surface.free[a], layer > 0);
        if layer == 0 {
            // Outward: away from the middle along the axes where it stands outermost.
            let middle = Vector::repeat(0.5 * side as f64);
            assert!(surface.normals[a].dot(&(p - middle)) > 0.0);
        }
    }
    assert_eq!(surface.classes[count], SurfaceClass::Splash);
    assert!(!surface.free[count]);
    assert_eq!(surface.pocket_particles, 0);
}

#[test]
fn a_block_has_a_surface_layer_a_layer_beneath_it_and_an_inside() {
    block_classes::<2>(8);
    block_classes::<3>(7);
}

#[test]
fn normals_of_a_flat_surface_are_square_to_it() {
    let points = Lattice::<2>::fill_box(Vector::zeros(), Vector::from([20.0, 10.0]), 1.0).positions;
    let (neighbourhood, surface) = detect(&points);
    let top = points.iter().position(|p| *p == Vector::from([10.5, 9.5])).unwrap();
    assert!((surface.normals[top] - Vector::from([0.0, 1.0])).norm() < 1e-12);
    // What the surface offset calls flat (0.55 and more) and ragged (0.45 and less).
    let divergence = |x, y| {
        let a = points.iter().position(|p| *p == Vector::from([x, y])).unwrap();
        neighbourhood.surroundings[a].moment.trace() / 2.0
    };
    assert!(divergence(10.5, 9.5) > 0.55, "{}", divergence(10.5, 9.5));
    assert!(divergence(0.5, 9.5) < 0.45, "{}", divergence(0.5, 9.5));
}

/// In a half space of fine grain (fifty particles to `h`, in three dimensions ten), `∇·r/D` tells how deep a
/// particle is.
#[test]
fn the_divergence_of_position_tells_the_depth_under_a_flat_surface() {
    fn found<const D: usize>(depth: f64, grain: f64) -> f64 {
        let kernel = CubicSpline::<D>::new(1.0);
        let reach = Vector::repeat(2.0);
        let lattice = Lattice::<D>::fill_box(-reach, reach, grain);
        let inside = lattice.positions.iter().filter(|r| r[D - 1] < depth);
        let divergence: f64 =
            inside.map(|r| r.dot(&kernel.gradient(&(-r)))).sum::<f64>() * grain.powi(D as i32);
        surface_offset::depth::<D>(divergence / D as f64)
    }
    for depth in [0.0, 0.2, 0.4, 0.6, 0.8, 1.0] {
        // Measured within 0.025 and 0.039 h, most at 0.4 and 0.6.
        let (plane, space) = (found::<2>(depth, 0.02), found::<3>(depth, 0.1));
        assert!((plane - depth).abs() < 0.03, "{plane} for {depth}");
        assert!((space - depth).abs() < 0.045, "{space} for {depth}");
    }
}

#[test]
fn the_half_layer_outside_weighs_as_in_a_wave_or_as_it_is_accelerated() {
    let g = 9.81;
    let carried = |by_pressure: f64| surface_offset::carried(g, by_pressure * g, g) / g;
    // Quiet: gravity. A fifth further, half way; from two fifths on what accelerates it, which is nothing in
    // free fall and counts up to 2 g.
    for (by_pressure, expected) in
        [(1.0, 1.0), (1.2, 1.0), (0.8, 1.0), (0.7, 0.8), (0.6, 0.6), (1.4, 1.4), (0.0, 0.0), (9.0, 2.0)]
    {
        assert!((carried(by_pressure) - expected).abs() < 1e-12, "{by_pressure}: {}", carried(by_pressure));
    }
    // A column's side: gravity has no part in it. Beneath a ceiling of air, nothing holds water up.
    assert!((surface_offset::carried(0.0, 1.5 * g, g) - 1.5 * g).abs() < 1e-12);
    assert_eq!(surface_offset::carried(-g, 0.0, g), 0.0);
}
