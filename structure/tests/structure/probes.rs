//! Stresses, strains, forces and moments that are read of a structure, by hand.

use sph::{Matrix, Vector};
use structure::probes::{Reading, Seen, What};
use structure::{Body, Derived, Law, Material, MaterialPoint, Plane, Setup, Solid, TotalLagrangian};
use words::motion::Law as Course;
use words::probe::ProbeQuantity;
use words::rigid::Motion;

type V = Vector<2>;

const SPACING: f64 = 0.1;

fn block() -> TotalLagrangian<2> {
    let material = Material::new(Law::StVenantKirchhoff, 1e6, 0.3, Plane::Strain);
    let body = Body::block(V::zeros(), V::from([1.0, 0.5]), SPACING, material, 1000.0);
    TotalLagrangian::new(Setup::new(vec![body])).unwrap()
}

/// A quarter turn about the point (0.3, 0.1).
fn quarter() -> Motion<2> {
    let table = vec![[0.0, 0.0], [1.0, std::f64::consts::FRAC_PI_2]];
    Motion::Rotation { pivot: [0.3, 0.1], law: Course::Table { table } }
}

fn read(of: What<2>, frame: Option<Motion<2>>, seen: &Seen<'_, 2>) -> Vec<f64> {
    let mut values = Vec::new();
    Reading { of, frame }.push(seen, ProbeQuantity::places(2), &mut values);
    values
}

fn near(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    let close = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
    assert!(close, "{found:?} and not {expected:?}");
}

/// A block under `x = F X`: `E = (FᵀF − 1)/2`, `S = λ tr E 1 + 2 μ E` with `E_zz = 0`, `σ = F S Fᵀ/J`, by
/// hand, at a corner as inside. The operators reproduce linear fields to round-off.
#[test]
fn stress_and_strain_of_a_homogeneous_deformation_by_hand() {
    let mut solid = block();
    let f = Matrix::<2>::new(1.2, 0.1, -0.05, 0.9);
    let mut state = solid.state_at_rest(1.0);
    for (x, at) in state.positions.iter_mut().zip(&solid.particles().reference_positions) {
        *x = f * at;
    }
    let mut derived = Derived::default();
    solid.derive(&state, &mut derived).unwrap();
    let (mu, lambda) = (1e6 / 2.6, 1e6 * 0.3 / (1.3 * 0.4));
    let e = (f.transpose() * f - Matrix::<2>::identity()) * 0.5;
    let s = Matrix::<2>::identity() * (lambda * e.trace()) + e * (2.0 * mu);
    let sigma = f * s * f.transpose() / f.determinant();
    let out = lambda * e.trace() / f.determinant();
    let (x, y) = (sigma[(0, 0)], sigma[(1, 1)]);
    let squares = (x - y).powi(2) + (y - out).powi(2) + (out - x).powi(2);
    let von_mises = (0.5 * squares + 3.0 * sigma[(0, 1)].powi(2)).sqrt();
    let seen = Seen { particles: solid.particles(), state: &state, derived: &derived, load: &[] };
    for at in [[1.0, 0.5], [0.42, 0.21]].map(V::from) {
        let point = MaterialPoint::new(at, &seen.particles.reference_positions, SPACING).unwrap();
        let strain = read(What::Strain(point.clone()), None, &seen);
        near(&strain, &[e[(0, 0)], e[(1, 1)], e[(0, 1)]], 1e-12);
        let stress = read(What::Stress(point.clone()), None, &seen);
        near(&stress, &[x, y, sigma[(0, 1)]], 1e-6);
        // Seen by who has made a quarter turn, what was along y is along x.
        let turned = read(What::Stress(point.clone()), Some(quarter()), &seen);
        near(&turned, &[y, x, -sigma[(0, 1)]], 1e-6);
        near(&read(What::VonMisesStress(point), None, &seen), &[von_mises], 1e-6);
    }
}

/// 3 N upwards and 1 N to the left at one particle, by hand; the forces of all under a load that is the
/// same everywhere act at the middle.
#[test]
fn moments_by_hand() {
    let solid = block();
    let state = solid.state_at_rest(1.0);
    let particles = solid.particles();
    let volume = SPACING * SPACING;
    let mut load = vec![V::zeros(); particles.interface.len()];
    load[7] = -V::from([-1.0, 3.0]) / volume;
    let at = particles.reference_positions[7];
    let body = 0..particles.len();
    let about = V::from([2.0, -1.0]);
    let arm = at - about;
    let expected = arm.x * 3.0 + arm.y;
    let derived = Derived::default();
    let seen = Seen { particles, state: &state, derived: &derived, load: &load };
    near(&read(What::Moment(body.clone(), about), None, &seen), &[expected], 1e-12);
    // The point goes along with the frame: from (2, −1) by a quarter turn about (0.3, 0.1) to (1.4, 1.8).
    let arm = at - V::from([1.4, 1.8]);
    let expected = arm.x * 3.0 + arm.y;
    near(&read(What::Moment(body.clone(), about), Some(quarter()), &seen), &[expected], 1e-12);
    let load = vec![V::from([0.0, -4.0]); particles.interface.len()];
    let seen = Seen { load: &load, ..seen };
    near(&read(What::Force(body.clone()), None, &seen), &[0.0, 2.0], 1e-12);
    near(&read(What::Moment(body.clone(), V::from([0.5, 0.25])), None, &seen), &[0.0], 1e-12);
    near(&read(What::Moment(body, V::zeros()), None, &seen), &[1.0], 1e-12);
}
