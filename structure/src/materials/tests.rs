use super::*;
use crate::lanes::{LANES, Lanes, Tensor, green_lagrange, plus_identity};
use sph::{Matrix, tensor};

fn tensor_of(m: [[f64; 2]; 2]) -> Tensor<2> {
    m.map(|row| row.map(Lanes::splat))
}

/// E = 12, ν = 0.4 at small strain, whatever the law.
fn material(law: Law, plane: Plane) -> Material {
    let half_mu = 15.0 / 7.0;
    let mut material = Material::new(law, 12.0, 0.4, plane);
    match law {
        Law::MooneyRivlin => material.constants = Constants([half_mu - 0.6, 0.6, 0.0]),
        Law::Yeoh => material.constants = Constants([half_mu, 0.3, 0.05]),
        // ½ (3 · 2 + 2 · 0.5) = 3.5.
        Law::Ogden => {
            material.constants = Constants([2.0, -0.5, 0.0].map(|c| c * 2.0 * half_mu / 3.5));
            material.exponents = Constants([3.0, -2.0, 0.0]);
        }
        _ => {}
    }
    material
}

fn elasticity(law: Law, plane: Plane) -> Elasticity {
    material(law, plane).elasticity::<2>()
}

const LAWS: [Law; 6] =
    [Law::AlmansiHooke, Law::StVenantKirchhoff, Law::NeoHookean, Law::MooneyRivlin, Law::Yeoh, Law::Ogden];

fn stress(law: Law, e: &Elasticity, l: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let p = with_law!(law, L => L::respond(e, &tensor_of(l), Lanes::ZERO).first_piola);
    p.map(|row| row.map(|c| c.0[LANES - 1]))
}

fn energy(law: Law, e: &Elasticity, l: [[f64; 2]; 2]) -> f64 {
    with_law!(law, L => L::energy(e, &tensor_of(l)).0[0])
}

/// E = 12, ν = 0.4: λ = 12·0.4/(1.4·0.2) = 120/7, μ = 12/2.8 = 30/7.
#[test]
fn st_venant_kirchhoff_of_a_uniaxial_stretch_by_hand() {
    let p = stress(
        Law::StVenantKirchhoff,
        &elasticity(Law::StVenantKirchhoff, Plane::Strain),
        [[0.5, 0.0], [0.0, 0.0]],
    );
    // E_xx = 0.625; S_xx = (λ + 2μ) 0.625 = 112.5/7... P_xx = 1.5 S_xx, P_yy = λ 0.625.
    assert!((p[0][0] - 1.5 * 180.0 / 7.0 * 0.625).abs() < 1e-13);
    assert!((p[1][1] - 120.0 / 7.0 * 0.625).abs() < 1e-13);
    assert_eq!((p[0][1], p[1][0]), (0.0, 0.0));
}

#[test]
fn almansi_hooke_of_a_uniaxial_stretch_by_hand() {
    let p =
        stress(Law::AlmansiHooke, &elasticity(Law::AlmansiHooke, Plane::Strain), [[1.0, 0.0], [0.0, 0.0]]);
    // F = diag(2, 1): ε_xx = 1.5/4 = 0.375, J = 2: P_xx = 2 (λ + 2μ) 0.375 / 2, P_yy = 2 λ 0.375.
    assert!((p[0][0] - 180.0 / 7.0 * 0.375).abs() < 1e-13);
    assert!((p[1][1] - 2.0 * 120.0 / 7.0 * 0.375).abs() < 1e-13);
}

/// A stretch of 1e-6: laws differ by the strain squared times the stiffness, 25·1e-12.
#[test]
fn all_laws_agree_at_small_strain() {
    for plane in [Plane::Strain, Plane::Stress] {
        let l = [[1e-6, 3e-7], [-2e-7, -5e-7]];
        let law = Law::StVenantKirchhoff;
        let reference = stress(law, &elasticity(law, plane), l);
        for law in LAWS {
            let p = stress(law, &elasticity(law, plane), l);
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                assert!((p[i][j] - reference[i][j]).abs() < 2e-10, "{law:?} {plane:?} {p:?} {reference:?}");
            }
        }
    }
}

/// In plane stress a stretch ε in x with free sides gives σ = E ε: choose ε_yy = −ν ε.
#[test]
fn plane_stress_has_youngs_modulus() {
    let strain = 1e-7;
    for law in LAWS {
        let p = stress(law, &elasticity(law, Plane::Stress), [[strain, 0.0], [0.0, -0.4 * strain]]);
        assert!((p[0][0] / strain - 12.0).abs() < 1e-5, "{law:?}: {p:?}");
        assert!((p[1][1] / strain).abs() < 1e-5, "{law:?}: {p:?}");
    }
}

/// Rotations by any angle: stresses at round-off of the stiffness, 30·1e-16 times a few operations.
#[test]
fn a_rigid_rotation_gives_no_stress() {
    for law in LAWS {
        for plane in [Plane::Strain, Plane::Stress] {
            for angle in [0.3_f64, 1.7, 3.0, -2.2] {
                let (s, c) = angle.sin_cos();
                let p = stress(law, &elasticity(law, plane), [[c - 1.0, -s], [s, c - 1.0]]);
                assert!(p.as_flattened().iter().all(|v| v.abs() < 1e-13), "{law:?} {p:?}");
            }
        }
    }
}

/// Central differences of the energy at large strain: truncation about step² = 1e-10, rounding 1e-16/1e-5.
#[test]
fn stress_is_the_derivative_of_the_energy_where_the_law_has_one() {
    let step = 1e-5;
    let l = [[0.3, 0.2], [-0.4, -0.1]];
    for law in [Law::StVenantKirchhoff, Law::NeoHookean] {
        for plane in [Plane::Strain, Plane::Stress] {
            let e = elasticity(law, plane);
            let p = stress(law, &elasticity(law, plane), l);
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let (mut plus, mut minus) = (l, l);
                plus[i][j] += step;
                minus[i][j] -= step;
                let slope = (energy(law, &e, plus) - energy(law, &e, minus)) / (2.0 * step);
                assert!((slope - p[i][j]).abs() < 1e-7, "{law:?} {plane:?} ({i}, {j}): {slope} {p:?}");
            }
        }
    }
}

/// `∮ P : dF` around the rectangle `[0, s] × [−s, 0]` of the stretches in x and y, by the midpoint rule.
fn work_of_a_cycle(law: Law, e: &Elasticity, s: f64) -> f64 {
    let corners = [[0.0, -s], [s, -s], [s, 0.0], [0.0, 0.0], [0.0, -s]];
    let steps = 200;
    let mut work = 0.0;
    for edge in corners.windows(2) {
        let change = [0, 1].map(|i| (edge[1][i] - edge[0][i]) / f64::from(steps));
        for step in 0..steps {
            let at = [0, 1].map(|i| edge[0][i] + (f64::from(step) + 0.5) * change[i]);
            let p = stress(law, e, [[at[0], 0.0], [0.0, at[1]]]);
            work += p[0][0] * change[0] + p[1][1] * change[1];
        }
    }
    work
}

/// With a potential none; Almansi–Hooke: `∂P_xx/∂F_yy − ∂P_yy/∂F_xx = 2 (λ + μ) (x − y)` to first order in
/// the stretches x and y, whose integral over the rectangle is `2 (λ + μ) s³`: that much the law gives away
/// in this sense of rotation, and takes in the other. The next order is `s` of that; the midpoint rule errs
/// by 1e-9 at 200 steps an edge.
#[test]
fn a_closed_cycle_does_no_work_where_the_law_has_a_potential() {
    let (s, e) = (0.01, elasticity(Law::AlmansiHooke, Plane::Strain));
    let by_hand = 2.0 * (e.lambda + e.mu) * s * s * s;
    for law in LAWS.into_iter().filter(|law| *law != Law::AlmansiHooke) {
        let work = work_of_a_cycle(law, &elasticity(law, Plane::Strain), s);
        assert!(work.abs() < 1e-4 * by_hand, "{law:?}: {work}");
    }
    let work = work_of_a_cycle(Law::AlmansiHooke, &e, s);
    assert!((work / by_hand + 1.0).abs() < 0.1, "{work} {by_hand}");
}

#[test]
fn laws_in_three_dimensions_reduce_to_plane_strain() {
    for law in LAWS {
        let material = material(law, Plane::Strain);
        let (e2, e3) = (material.elasticity::<2>(), material.elasticity::<3>());
        let l2 = [[0.1, 0.2], [-0.05, -0.1]];
        let mut l3 = [[0.0; 3]; 3];
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            l3[i][j] = l2[i][j];
        }
        let l3 = l3.map(|row| row.map(Lanes::splat));
        let p2 = stress(law, &e2, l2);
        let (p3, out_of_plane, w3, jacobian) = with_law!(law, L => {
            let r = L::respond(&e3, &l3, Lanes::ZERO);
            (r.first_piola, L::out_of_plane(&e2, &tensor_of(l2), Lanes::ZERO), L::energy(&e3, &l3), r.jacobian)
        });
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            assert!((p3[i][j].0[0] - p2[i][j]).abs() < 1e-13);
        }
        // P_zz = J σ_zz with F_zz = 1.
        assert!((p3[2][2].0[0] - jacobian.0[0] * out_of_plane.0[0]).abs() < 1e-13);
        assert!((w3.0[0] - energy(law, &e2, l2)).abs() < 1e-13);
    }
}

#[test]
fn neo_hookean_plane_stress_holds_at_large_stretch() {
    let e = elasticity(Law::NeoHookean, Plane::Stress);
    for stretch in [0.55, 0.8, 1.5, 2.0] {
        // Uniaxial tension: find the side's stretch with no side stress; then P_xx is below E·strain for
        // rubber in tension.
        let (mut low, mut high) = (0.2, 3.0);
        for _ in 0..80 {
            let middle: f64 = 0.5 * (low + high);
            let side = stress(Law::NeoHookean, &e, [[stretch - 1.0, 0.0], [0.0, middle - 1.0]])[1][1];
            if side > 0.0 { high = middle } else { low = middle }
        }
        // Isotropy: the stretch out of the plane must equal that of the free side, so ψ of diag(a, b, b) in
        // 3-D has ∂ψ/∂b = 0.
        let material = Material::new(Law::NeoHookean, 12.0, 0.4, Plane::Strain);
        let diagonal = [stretch - 1.0, low - 1.0, low - 1.0];
        let l: Tensor<3> = std::array::from_fn(|i| {
            std::array::from_fn(|j| Lanes::splat(if i == j { diagonal[i] } else { 0.0 }))
        });
        let p = NeoHookean::respond(&material.elasticity::<3>(), &l, Lanes::ZERO).first_piola;
        assert!(p[2][2].0[0].abs() < 1e-12 && p[1][1].0[0].abs() < 1e-12, "{stretch}: {p:?}");
    }
}

/// σ = P Fᵀ / J is symmetric for every law at any deformation: angular momentum is kept.
#[test]
fn cauchy_stress_is_symmetric() {
    let l = [[0.3, 0.7], [-0.4, -0.2]];
    let f = Matrix::<2>::new(1.3, 0.7, -0.4, 0.8);
    for law in LAWS {
        let p = stress(law, &elasticity(law, Plane::Strain), l);
        let sigma = Matrix::<2>::from_fn(|i, j| p[i][j]) * f.transpose() / tensor::determinant(&f);
        assert!((sigma[(0, 1)] - sigma[(1, 0)]).abs() < 1e-13, "{law:?}");
    }
    assert_eq!(plus_identity(&tensor_of(l))[0][0].0[0], 1.3);
    assert!((green_lagrange(&tensor_of(l))[1][1].0[0] - (0.5 * (0.49 + 0.64) - 0.5)).abs() < 1e-15);
}

/// Uniaxial tension of an incompressible rubber, `P = 2 (λ − λ⁻²) (W₁ + W₂/λ)` and `Σ μ_p (λ^(α_p − 1) −
/// λ^(−α_p/2 − 1))` (Treloar 1975; Ogden 1972), of a sheet in plane stress at ν = 0.49999. κ/μ is 5e4 there:
/// the change of volume is 1e-5 of a few μ.
#[test]
fn rubber_in_uniaxial_tension_is_as_in_the_books() {
    let close = |law: Law, constants: [f64; 3], exponents: [f64; 3], stretch: f64, right: f64| {
        let mut material = Material::new(law, 1.0, 0.49999, Plane::Stress);
        (material.constants, material.exponents) = (Constants(constants), Constants(exponents));
        let e = material.elasticity::<2>();
        let side = 1.0 / stretch.sqrt();
        let p = stress(law, &e, [[stretch - 1.0, 0.0], [0.0, side - 1.0]]);
        assert!((p[0][0] / right - 1.0).abs() < 2e-4, "{law:?} at {stretch}: {p:?} {right}");
        assert!(p[1][1].abs() < 2e-4 * right.abs(), "{law:?} at {stretch}: {p:?}");
    };
    for stretch in [0.6_f64, 1.3, 2.0, 4.0] {
        let first = stretch * stretch + 2.0 / stretch;
        let pull = 2.0 * (stretch - stretch.powi(-2));
        close(Law::MooneyRivlin, [1.5, 0.5, 0.0], [0.0; 3], stretch, pull * (1.5 + 0.5 / stretch));
        let x = first - 3.0;
        let slope = 1.5 - 0.02 * x + 0.003 * x * x;
        close(Law::Yeoh, [1.5, -0.01, 0.001], [0.0; 3], stretch, pull * slope);
        // Treloar's rubber, in kg/cm² (Ogden 1972): μ = 6.3, 0.012, −0.1, α = 1.3, 5, −2.
        let terms = [(6.3, 1.3), (0.012, 5.0), (-0.1, -2.0)];
        let right = terms.iter().map(|&(mu, alpha): &(f64, f64)| {
            mu * (stretch.powf(alpha - 1.0) - stretch.powf(-0.5 * alpha - 1.0))
        });
        close(Law::Ogden, terms.map(|t| t.0), terms.map(|t| t.1), stretch, right.sum());
    }
}

/// A pressure from patches is as much of it as κ's own: `p` in place of the difference of two `λ`.
#[test]
fn the_stress_of_patches_stands_for_a_part_of_lambda() {
    let l = tensor_of([[0.05, 0.1], [-0.03, 0.04]]);
    for law in LAWS {
        let whole = elasticity(law, Plane::Strain);
        let part = Elasticity { lambda: 0.25 * whole.lambda, in_plane_lambda: 0.25 * whole.lambda, ..whole };
        let (own, shared, out, out_shared) = with_law!(law, L => {
            let rest = L::dilatation(&l) * (0.75 * whole.lambda);
            (
                L::respond(&whole, &l, Lanes::ZERO).first_piola,
                L::respond(&part, &l, rest).first_piola,
                L::out_of_plane(&whole, &l, Lanes::ZERO),
                L::out_of_plane(&part, &l, rest),
            )
        });
        for (a, b) in own.as_flattened().iter().zip(shared.as_flattened()) {
            assert!((a.0[0] - b.0[0]).abs() < 1e-13, "{law:?}");
        }
        assert!((out.0[0] - out_shared.0[0]).abs() < 1e-13, "{law:?}");
    }
}
