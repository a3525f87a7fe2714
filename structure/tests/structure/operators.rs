//! Properties of the discrete operators: the paper's Eq. (42) term by term, patch tests, forces as gradients
//! of the energy, momenta.

use sph::kernel::CubicSpline;
use sph::{Matrix, Vector, tensor};
use structure::bodies::filling::{Filling, rectangle, without_disc};
use structure::{
    Body, Constants, Derived, Gradient, Law, Material, Options, Plane, Setup, Solid, State, TotalLagrangian,
};

const GRADIENTS: [Gradient; 2] = [Gradient::FirstOrder, Gradient::Quadratic];

fn material(law: Law) -> Material {
    Material::new(law, 3.0, 0.3, Plane::Strain)
}

/// Numbers in −1..1, the same at every run.
fn noise(count: usize) -> Vec<f64> {
    let mut seed = 77u64;
    (0..count)
        .map(|_| {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 33) as f64 / (1u64 << 30) as f64 - 1.0
        })
        .collect()
}

/// A free box four cells thick, its particles displaced by a fraction of the spacing.
fn jittered<const D: usize>(fraction: f64, law: Law) -> Body<D> {
    let high = Vector::from_fn(|i, _| if i == 0 { 0.9 } else { 0.4 });
    let mut body = Body::block(Vector::zeros(), high, 0.1, material(law), 2.0);
    let shifts = noise(body.positions.len() * D);
    for (n, p) in body.positions.iter_mut().enumerate() {
        for i in 0..D {
            p[i] += fraction * 0.1 * shifts[n * D + i];
        }
    }
    body
}

/// A free body with cells of its own, offset centroids among them: a lattice at an angle, jittered, in a box
/// without a disc's part.
fn celled(law: Law) -> Body<2> {
    let (low, high) = (Vector::zeros(), Vector::from([0.9, 0.4]));
    let outline = without_disc(&rectangle(low, high), &Vector::from([0.0, 0.2]), 0.23, 0.1).unwrap().0;
    let filling = Filling { spacing: 0.1, lattice_angle: 0.3, jitter: 0.1, seed: 5, sweeps: 0 };
    let (positions, cells) = filling.fill(low, high, &outline);
    assert!(cells.iter().any(|c| c.offset.norm() > 0.02), "offsets worth the name");
    Body::from_cells(positions, &cells, 0.1, material(law), 2.0)
}

/// The body of a material so nearly incompressible that patches bear its change of volume.
fn nearly_incompressible<const D: usize>(mut body: Body<D>) -> Body<D> {
    body.material.poisson_ratio = 0.49;
    body
}

/// Rubber with constants for either kind of law, nearly incompressible.
fn rubber(law: Law, plane: Plane) -> Material {
    let mut material = Material::new(law, 1.0, 0.48, plane);
    material.constants = Constants([0.4, 0.1, 0.0]);
    if law == Law::Ogden {
        material.exponents = Constants([1.5, 3.0, 0.0]);
    }
    material
}

fn structure<const D: usize>(body: Body<D>, gradient: Gradient) -> TotalLagrangian<D> {
    let mut setup = Setup::new(vec![body]);
    setup.options = Options::of(gradient);
    TotalLagrangian::new(setup).unwrap()
}

/// A smooth, large deformation: bending, shear and stretch.
fn deform<const D: usize>(state: &mut State<D>, amount: f64) {
    for p in &mut state.positions {
        let x = *p;
        p[0] += amount * (0.3 * x[0] * x[1] + 0.2 * x[1]);
        p[1] += amount * (0.4 * x[0] * x[0] - 0.1 * x[1]);
        if D == 3 {
            p[D - 1] += amount * 0.3 * x[0] * x[1];
        }
    }
}

/// Eq. (42) by plain loops over all pairs.
fn accelerations_by_definition<const D: usize>(
    body: &Body<D>,
    x: &[Vector<D>],
    ratio: f64,
) -> Vec<Vector<D>> {
    let count = x.len();
    let kernel = CubicSpline::<D>::new(ratio * body.spacing());
    let (big_x, v) = (&body.positions, &body.volumes);
    let grad = |a: usize, b: usize| kernel.gradient(&(big_x[a] - big_x[b]));
    let (e, nu) = (body.material.youngs_modulus, body.material.poisson_ratio);
    let (lambda, mu) = (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
    let mut p_k = Vec::new();
    for a in 0..count {
        let mut k = Matrix::<D>::zeros();
        let mut m = Matrix::<D>::zeros();
        for b in 0..count {
            k += tensor::outer(&(big_x[b] - big_x[a]), &grad(a, b)) * v[b];
            m += tensor::outer(&(x[b] - x[a]), &grad(a, b)) * v[b];
        }
        let k_inverse = tensor::inverse(&k).unwrap();
        let f = m * k_inverse;
        let f_inverse = tensor::inverse(&f).unwrap();
        let strain = (Matrix::identity() - f_inverse.transpose() * f_inverse) * 0.5;
        let sigma = Matrix::identity() * (lambda * strain.trace()) + strain * (2.0 * mu);
        p_k.push(sigma * f_inverse.transpose() * tensor::determinant(&f) * k_inverse);
    }
    (0..count)
        .map(|a| {
            (0..count).fold(Vector::zeros(), |sum, b| sum + (p_k[a] + p_k[b]) * grad(a, b) * v[b])
                / body.density
        })
        .collect()
}

fn first_order_is_the_papers<const D: usize>(fraction: f64) {
    let body = jittered::<D>(fraction, Law::AlmansiHooke);
    let mut structure = structure(body.clone(), Gradient::FirstOrder);
    let mut state = structure.state_at_rest(0.0);
    deform(&mut state, 0.5);
    let expected = accelerations_by_definition(&body, &state.positions, 1.2);
    let scale = expected.iter().map(Vector::norm).fold(0.0, f64::max);
    let found = structure.internal_accelerations(&state).unwrap();
    for (n, (a, b)) in found.iter().zip(&expected).enumerate() {
        // Round-off of about 20 (2-D) to 60 (3-D) terms that nearly cancel.
        assert!((a - b).norm() < 1e-12 * scale, "particle {n}: {a} {b}");
    }
}

#[test]
fn first_order_accelerations_are_equation_42_on_lattices_and_scattered_sets() {
    first_order_is_the_papers::<2>(0.0);
    first_order_is_the_papers::<2>(0.2);
    first_order_is_the_papers::<3>(0.1);
}

fn passes_the_patch_test<const D: usize>(gradient: Gradient, body: Body<D>) {
    let mut structure = structure(body, gradient);
    let map = Matrix::<D>::from_fn(|i, j| if i == j { 1.2 } else { 0.1 * (i as f64 - 0.4 * j as f64) });
    let mut state = structure.state_at_rest(0.0);
    state.positions.iter_mut().for_each(|p| *p = map * *p + Vector::repeat(3.0));
    let mut derived = Derived::default();
    structure.derive(&state, &mut derived).unwrap();
    for f in &derived.deformation_gradient {
        // Conditioning of the local fits times round-off of coordinates near 3 over spacings of 0.1.
        assert!((f - map).norm() < 1e-12, "{gradient:?} {f}");
    }
    let energy = derived.strain_energy_density[0];
    assert!(derived.strain_energy_density.iter().all(|e| (e / energy - 1.0).abs() < 1e-12));
}

#[test]
fn linear_fields_are_exact() {
    for gradient in GRADIENTS {
        let law = Law::StVenantKirchhoff;
        passes_the_patch_test(gradient, jittered::<2>(0.0, law));
        passes_the_patch_test(gradient, jittered::<2>(0.2, law));
        passes_the_patch_test(gradient, jittered::<3>(0.1, law));
        passes_the_patch_test(gradient, celled(law));
        passes_the_patch_test(gradient, nearly_incompressible(jittered::<2>(0.2, law)));
        passes_the_patch_test(gradient, nearly_incompressible(jittered::<3>(0.1, law)));
        passes_the_patch_test(gradient, nearly_incompressible(celled(law)));
    }
}

fn force_is_the_energys_gradient<const D: usize>(gradient: Gradient, body: Body<D>) {
    let mut structure = structure(body, gradient);
    let mut state = structure.state_at_rest(0.0);
    deform(&mut state, 0.5);
    // Its stable step is found once and holds for all states so near.
    structure.evaluate(&mut state).unwrap();
    let found = structure.internal_accelerations(&state).unwrap();
    let scale = found.iter().map(Vector::norm).fold(0.0, f64::max);
    let step = 1e-6;
    for particle in (0..structure.particles().len()).step_by(7) {
        for i in 0..D {
            let mut energy = |sign: f64| {
                let mut moved = state.clone();
                moved.positions[particle][i] += sign * step;
                structure.evaluate(&mut moved).unwrap();
                moved.energy.strain
            };
            let force = -(energy(1.0) - energy(-1.0)) / (2.0 * step);
            let acceleration = force / structure.particles().masses[particle];
            // Central differences: rounding of the total energy over the step, 1e-16/1e-6 on energies of some
            // 1e3 local ones.
            assert!(
                (acceleration - found[particle][i]).abs() < 1e-6 * scale,
                "{gradient:?} {particle} {i}: {acceleration} {}",
                found[particle][i]
            );
        }
    }
}

#[test]
fn forces_are_minus_the_gradient_of_the_energy() {
    for gradient in GRADIENTS {
        let law = Law::StVenantKirchhoff;
        force_is_the_energys_gradient(gradient, jittered::<2>(0.0, law));
        force_is_the_energys_gradient(gradient, jittered::<2>(0.2, law));
        force_is_the_energys_gradient(gradient, jittered::<3>(0.1, law));
        force_is_the_energys_gradient(gradient, celled(law));
    }
    let (gradient, law) = (Gradient::Quadratic, Law::NeoHookean);
    force_is_the_energys_gradient(gradient, nearly_incompressible(jittered::<2>(0.2, law)));
    force_is_the_energys_gradient(gradient, nearly_incompressible(jittered::<3>(0.1, law)));
    force_is_the_energys_gradient(gradient, nearly_incompressible(celled(Law::StVenantKirchhoff)));
    let rubber = |mut body: Body<2>| {
        body.material = rubber(Law::Ogden, Plane::Strain);
        body
    };
    force_is_the_energys_gradient(gradient, rubber(jittered::<2>(0.2, law)));
}

fn keeps_momenta<const D: usize>(gradient: Gradient, law: Law, body: Body<D>) {
    let mut structure = structure(body, gradient);
    let mut state = structure.state_at_rest(0.0);
    deform(&mut state, 0.5);
    let accelerations = structure.internal_accelerations(&state).unwrap();
    let masses = &structure.particles().masses;
    let forces: Vec<Vector<D>> = accelerations.iter().zip(masses).map(|(a, m)| a * *m).collect();
    let total: f64 = forces.iter().map(Vector::norm).sum();
    let sum = forces.iter().fold(Vector::<D>::zeros(), |s, f| s + f);
    // Round-off of sums over all pairs.
    assert!(sum.norm() < 1e-13 * total, "{gradient:?} {sum}");
    for (i, j) in [(0, 1), (0, D - 1), (1, D - 1)] {
        let moment: f64 = forces.iter().zip(&state.positions).map(|(f, x)| x[i] * f[j] - x[j] * f[i]).sum();
        assert!(moment.abs() < 1e-13 * total, "{gradient:?} {law:?} {moment} of {total}");
    }
}

#[test]
fn momentum_and_angular_momentum_are_kept_to_round_off() {
    for gradient in GRADIENTS {
        for law in [Law::AlmansiHooke, Law::StVenantKirchhoff, Law::NeoHookean] {
            keeps_momenta(gradient, law, jittered::<2>(0.15, law));
            keeps_momenta(gradient, law, jittered::<3>(0.15, law));
            keeps_momenta(gradient, law, celled(law));
            keeps_momenta(gradient, law, nearly_incompressible(jittered::<2>(0.15, law)));
            keeps_momenta(gradient, law, nearly_incompressible(jittered::<3>(0.15, law)));
            keeps_momenta(gradient, law, nearly_incompressible(celled(law)));
        }
        for law in [Law::MooneyRivlin, Law::Yeoh, Law::Ogden] {
            let mut body = jittered::<2>(0.15, law);
            body.material = rubber(law, Plane::Stress);
            keeps_momenta(gradient, law, body);
            let mut body = jittered::<3>(0.15, law);
            body.material = rubber(law, Plane::ThreeDimensional);
            keeps_momenta(gradient, law, body);
        }
    }
}

#[test]
fn a_rigid_rotation_gives_no_stress() {
    for gradient in GRADIENTS {
        for law in [Law::AlmansiHooke, Law::StVenantKirchhoff, Law::NeoHookean] {
            let mut structure = structure(jittered::<2>(0.15, law), gradient);
            let (s, c) = 2.0_f64.sin_cos();
            let rotation = Matrix::<2>::new(c, -s, s, c);
            let mut state = structure.state_at_rest(0.0);
            state.positions.iter_mut().for_each(|p| *p = rotation * *p);
            let mut derived = Derived::default();
            structure.derive(&state, &mut derived).unwrap();
            // Round-off of F times the stiffness, about 4.
            assert!(derived.von_mises.iter().all(|v| *v < 1e-12), "{gradient:?} {law:?}");
        }
    }
}

/// The control acts on nothing that is linear, resists a checkerboard, and keeps momentum.
#[test]
fn hourglass_control_acts_on_what_the_gradient_does_not_see() {
    let body = jittered::<2>(0.0, Law::StVenantKirchhoff);
    let make = |hourglass| {
        let mut setup = Setup::new(vec![body.clone()]);
        setup.options = Options::of(Gradient::FirstOrder);
        setup.options.hourglass = hourglass;
        TotalLagrangian::new(setup).unwrap()
    };
    let (mut plain, mut controlled) = (make(0.0), make(0.1));
    let mut state = plain.state_at_rest(0.0);
    let map = Matrix::<2>::new(1.2, 0.1, -0.2, 0.9);
    state.positions.iter_mut().for_each(|p| *p = map * *p);
    let difference =
        |a: &[Vector<2>], b: &[Vector<2>]| a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let before = plain.internal_accelerations(&state).unwrap();
    let after = controlled.internal_accelerations(&state).unwrap();
    // Round-off of E/(ρ Δx) = 15.
    assert!(difference(&before, &after) < 1e-12);
    let checkerboard = |i: usize| if (i % 9 + i / 9).is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut rough = plain.state_at_rest(0.0);
    for (i, p) in rough.positions.iter_mut().enumerate() {
        p.y += 1e-4 * checkerboard(i);
    }
    let before = plain.internal_accelerations(&rough).unwrap();
    let after = controlled.internal_accelerations(&rough).unwrap();
    let power: f64 = (0..after.len()).map(|i| (after[i].y - before[i].y) * checkerboard(i)).sum();
    // ½ ζ E V W/(ρ Δx²) · 4e-4 is 3e-4 m/s² a vertical pair.
    assert!(power < -3e-4 * after.len() as f64, "{power}");
    let sum = after.iter().fold(Vector::<2>::zeros(), |s, a| s + a);
    assert!(sum.norm() < 1e-12, "{sum}");
    assert!(controlled.stable_time_step() <= plain.stable_time_step());
}
