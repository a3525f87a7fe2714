//! Small static deflections of a beam under its weight, by conjugate gradients: scattered particles, a
//! lattice at an angle, and a nearly incompressible material.
//!
//! Beam of 0.35 m by 0.02 m in plane strain, E = 1.4 MPa, gravity 2 mm/s²: the linear range of the benchmark
//! CSM1. References: biquadratic finite elements, 35 × 2, 70 × 4, 140 × 8 of them: 67.16, 67.34, 67.41 µm at
//! ν = 0.4 and 59.64, 60.32, 60.58 µm at ν = 0.49.

use sph::Vector;
use structure::{
    Body, Law, Material, MaterialPoint, Plane, Setup, Side, Solid, TotalLagrangian, relax_to_centroids,
    voronoi_cells,
};

type V = Vector<2>;

const LENGTH: f64 = 0.35;
const THICKNESS: f64 = 0.02;
const GRAVITY: f64 = 2e-3;
const REFERENCE: f64 = 67.41e-6;

fn material(poisson_ratio: f64) -> Material {
    Material { law: Law::StVenantKirchhoff, assumption: Plane::Strain, youngs_modulus: 1.4e6, poisson_ratio }
}

/// Displacements that balance the weight along `gravity` (m/s²), to 1e-7 of it.
fn static_displacements(structure: &mut TotalLagrangian<2>, gravity: V, spacing: f64) -> Vec<V> {
    let rest = structure.state_at_rest(0.0);
    let count = structure.particles().len();
    let masses = structure.particles().masses.clone();
    let dot = |a: &[V], b: &[V]| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
    let mut stiffness_times = |v: &[V]| -> Vec<V> {
        // Central differences over a thousandth of the spacing: the error is of second order.
        let step = 1e-3 * spacing / v.iter().map(Vector::amax).fold(f64::MIN_POSITIVE, f64::max);
        let mut moved = rest.clone();
        let mut out = vec![V::zeros(); count];
        for sign in [1.0, -1.0] {
            for i in 0..count {
                moved.positions[i] = rest.positions[i] + v[i] * (sign * step);
            }
            let accelerations = structure.internal_accelerations(&moved).unwrap();
            for i in 0..count {
                out[i] -= accelerations[i] * (masses[i] * sign / (2.0 * step));
            }
        }
        out
    };
    let clamped = rest.positions.iter().zip(&masses).map(|(_, m)| *m == 0.0);
    let mut residual: Vec<V> =
        clamped.zip(&masses).map(|(fixed, m)| if fixed { V::zeros() } else { gravity * *m }).collect();
    let mut x = vec![V::zeros(); count];
    let mut direction = residual.clone();
    let mut square = dot(&residual, &residual);
    let goal = 1e-14 * square;
    for _ in 0..8000 {
        if square <= goal {
            return x;
        }
        let q = stiffness_times(&direction);
        let alpha = square / dot(&direction, &q);
        for i in 0..count {
            x[i] += direction[i] * alpha;
            residual[i] -= q[i] * alpha;
        }
        let next = dot(&residual, &residual);
        for i in 0..count {
            direction[i] = residual[i] + direction[i] * (next / square);
        }
        square = next;
    }
    panic!("no balance: {square} of {goal}");
}

/// Deflection (m) of the middle of the end face, the beam lying at an angle (radians).
fn deflection(body: Body<2>, angle: f64) -> f64 {
    let (sine, cosine) = angle.sin_cos();
    let spacing = body.spacing();
    let free: Vec<V> = (body.positions.iter().zip(&body.clamped)).filter(|p| !p.1).map(|p| *p.0).collect();
    let end = V::from([LENGTH * cosine - 0.5 * THICKNESS * sine, LENGTH * sine + 0.5 * THICKNESS * cosine]);
    let tip = MaterialPoint::new(end, &free, spacing).unwrap();
    let down = V::from([sine, -cosine]);
    let mut structure = TotalLagrangian::new(Setup::new(vec![body])).unwrap();
    let x = static_displacements(&mut structure, down * GRAVITY, spacing);
    tip.value(&x).dot(&down)
}

fn corners(angle: f64) -> [V; 4] {
    let (sine, cosine) = angle.sin_cos();
    [[0.0, 0.0], [LENGTH, 0.0], [LENGTH, THICKNESS], [0.0, THICKNESS]]
        .map(|[x, y]| V::from([cosine * x - sine * y, sine * x + cosine * y]))
}

/// Fixed nodes on the face at x = 0 of the beam at an angle.
fn clamp_nodes(layers: usize, angle: f64) -> Vec<V> {
    let (sine, cosine) = angle.sin_cos();
    (0..layers).map(|k| V::from([-sine, cosine]) * ((k as f64 + 0.5) * THICKNESS / layers as f64)).collect()
}

fn body_of(positions: Vec<V>, angle: f64, layers: usize, sweeps: usize) -> Body<2> {
    let spacing = THICKNESS / layers as f64;
    let (positions, cells) = relax_to_centroids(positions, &corners(angle), spacing, sweeps);
    Body::from_cells(positions, &cells, spacing, material(0.4), 1000.0)
        .with_fixed_nodes(&clamp_nodes(layers, angle))
}

fn scattered(layers: usize, mut seed: u64) -> Vec<V> {
    let spacing = THICKNESS / layers as f64;
    let mut body = Body::block(V::zeros(), V::from([LENGTH, THICKNESS]), spacing, material(0.4), 1000.0);
    let mut noise = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 33) as f64 / (1u64 << 30) as f64 - 1.0
    };
    for p in &mut body.positions {
        *p += V::from([noise(), noise()]) * (0.1 * spacing);
    }
    body.positions
}

/// Measured: +0.6, +2.1 % (4 layers) and +1.3, +2.2 % (6 layers) as they are, −0.5, −0.4 and +0.4, +0.5 %
/// after one sweep; with the lattice's volumes instead of the cells' +1.0, +6.5 and +3.1, +6.0 %. A lattice
/// has −0.8 and +0.3 %.
#[test]
fn scattered_particles_bend_as_they_should() {
    for layers in [4, 6] {
        for seed in [1, 2] {
            for (sweeps, tolerance) in [(0, 0.025), (1, 0.01)] {
                let found = deflection(body_of(scattered(layers, seed), 0.0, layers, sweeps), 0.0);
                assert!((found / REFERENCE - 1.0).abs() < tolerance, "{layers} {seed} {sweeps}: {found}");
            }
        }
    }
}

/// A lattice at 15° to the beam, six layers. Measured: +13 % as it is (+28 % with equal volumes), +2.8 %
/// after three sweeps, whose cells follow the faces.
#[test]
fn a_lattice_at_an_angle_bends_as_it_should_after_three_sweeps() {
    let (layers, angle) = (6, 15_f64.to_radians());
    let spacing = THICKNESS / layers as f64;
    let (sine, cosine) = angle.sin_cos();
    let lattice = (-10..40).flat_map(|j| (-10..120).map(move |i| (i, j)));
    let inside: Vec<V> = lattice
        .map(|(i, j)| V::from([f64::from(i) + 0.5, f64::from(j) + 0.5]) * spacing)
        .filter(|p| {
            let (x, y) = (cosine * p.x + sine * p.y, -sine * p.x + cosine * p.y);
            x > 0.0 && x < LENGTH && y > 0.0 && y < THICKNESS
        })
        .collect();
    let volume: f64 = voronoi_cells(&inside, &corners(angle), spacing).iter().map(|c| c.volume).sum();
    assert!((volume / (LENGTH * THICKNESS) - 1.0).abs() < 1e-12, "{volume}");
    let found = deflection(body_of(inside, angle, layers, 3), angle);
    assert!((found / REFERENCE - 1.0).abs() < 0.05, "{found}");
}

/// ν = 0.49, six layers: 60.6 µm or a little more is right; measured −3.0 % (four layers lock: −17 %). Goal 5
/// %.
#[test]
fn a_nearly_incompressible_beam_with_six_layers() {
    let body = Body::block(V::zeros(), V::from([LENGTH, THICKNESS]), THICKNESS / 6.0, material(0.49), 1000.0)
        .with_fixed_face(0, Side::Low);
    let found = deflection(body, 0.0);
    assert!((found / 60.58e-6 - 1.0).abs() < 0.05, "{found}");
}
