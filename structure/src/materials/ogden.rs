//! Rubber by principal stretches: Ogden's law.

use crate::lanes::{LANES, Lanes, Tensor, cofactor, plus_identity};
use crate::materials::law::{ConstitutiveLaw, Elasticity, Response};
use nalgebra::{Matrix2, Matrix3, SymmetricEigen};

/// `ψ = Σ_p μ_p/α_p (λ̄₁^α_p + λ̄₂^α_p + λ̄₃^α_p − 3) + κ/2 (ln J)²` of the isochoric principal stretches
/// `λ̄ = J^(−1/3) λ` (Ogden 1972; Simo and Taylor 1991). The principal Kirchhoff stresses are
/// `τ_a = Σ_p μ_p (λ̄_a^α_p − ⅓ Σ_b λ̄_b^α_p) + κ ln J`, and `P = F Σ_a τ_a/λ_a² N_a ⊗ N_a`.
///
/// In plane stress the stretch out of the plane follows from `τ₃ = 0`.
pub(crate) struct Ogden;

/// Newton iterations for the stretch out of the plane, from that of an incompressible sheet.
const NEWTON_ITERATIONS: usize = 12;

/// Principal stretches, as logarithms, and their directions in the reference configuration: of one particle,
/// in three dimensions whatever `D` is.
struct Principal {
    logs: [f64; 3],
    /// Columns.
    directions: Matrix3<f64>,
}

/// `½ ln(1 + 2 E)` of the eigenvalues of the Green–Lagrange strain: small strains stay exact.
fn principal<const D: usize>(e: &Elasticity, l: &Tensor<D>, lane: usize) -> Principal {
    let strain = |i: usize, j: usize| {
        let square: f64 = (0..D).map(|m| l[m][i].0[lane] * l[m][j].0[lane]).sum();
        0.5 * (l[i][j].0[lane] + l[j][i].0[lane] + square)
    };
    let log = |strain: f64| 0.5 * (2.0 * strain).ln_1p();
    let is_number = (0..D).all(|i| (0..D).all(|j| strain(i, j).is_finite()));
    if !is_number {
        return Principal { logs: [f64::NAN; 3], directions: Matrix3::identity() };
    }
    if D == 3 {
        let eigen = SymmetricEigen::new(Matrix3::from_fn(strain));
        let logs = [0, 1, 2].map(|a| log(eigen.eigenvalues[a]));
        return Principal { logs, directions: eigen.eigenvectors };
    }
    let eigen = SymmetricEigen::new(Matrix2::from_fn(strain));
    let mut directions = Matrix3::identity();
    directions.fixed_view_mut::<2, 2>(0, 0).copy_from(&eigen.eigenvectors);
    let [first, second] = [0, 1].map(|a| log(eigen.eigenvalues[a]));
    let third = if e.plane_stress { log_thickness(e, first, second) } else { 0.0 };
    Principal { logs: [first, second, third], directions }
}

fn terms(e: &Elasticity) -> impl Iterator<Item = (f64, f64)> + '_ {
    e.constants.iter().copied().zip(e.exponents).filter(|(mu, _)| *mu != 0.0)
}

/// `κ` (Pa) of the particle's own dilatation.
fn bulk(e: &Elasticity) -> f64 {
    e.lambda + 2.0 / 3.0 * e.mu
}

/// `ln λ₃` without stress out of the plane.
fn log_thickness(e: &Elasticity, first: f64, second: f64) -> f64 {
    let mut third = -(first + second);
    for _ in 0..NEWTON_ITERATIONS {
        let log = first + second + third;
        let (mut residual, mut slope) = (bulk(e) * log, bulk(e));
        for (mu, alpha) in terms(e) {
            let power = |x: f64| (alpha * (x - log / 3.0)).exp();
            let in_plane = power(first) + power(second);
            residual += mu * (2.0 * power(third) - in_plane) / 3.0;
            slope += mu * alpha * (4.0 * power(third) + in_plane) / 9.0;
        }
        third -= residual / slope;
    }
    third
}

/// Principal Kirchhoff stresses (Pa).
fn kirchhoff(e: &Elasticity, logs: &[f64; 3], volumetric: f64) -> [f64; 3] {
    let log: f64 = logs.iter().sum();
    let mut stress = [bulk(e) * log + volumetric; 3];
    for (mu, alpha) in terms(e) {
        // Powers less one: what is left of them at small strain is exact.
        let powers = logs.map(|x| (alpha * (x - log / 3.0)).exp_m1());
        let mean = powers.iter().sum::<f64>() / 3.0;
        for a in 0..3 {
            stress[a] += mu * (powers[a] - mean);
        }
    }
    stress
}

impl ConstitutiveLaw for Ogden {
    #[inline(always)]
    fn respond<const D: usize>(e: &Elasticity, l: &Tensor<D>, volumetric: Lanes) -> Response<D> {
        let f = plus_identity(l);
        let jacobian = cofactor(&f).1;
        let mut first_piola = [[Lanes::ZERO; D]; D];
        for lane in 0..LANES {
            let principal = principal(e, l, lane);
            let stress = kirchhoff(e, &principal.logs, volumetric.0[lane]);
            let n = &principal.directions;
            let second_piola = |j: usize, m: usize| -> f64 {
                let of = |a: usize| stress[a] * (-2.0 * principal.logs[a]).exp() * n[(j, a)] * n[(m, a)];
                (0..D).map(of).sum()
            };
            for i in 0..D {
                for j in 0..D {
                    first_piola[i][j].0[lane] = (0..D).map(|m| f[i][m].0[lane] * second_piola(m, j)).sum();
                }
            }
        }
        Response { first_piola, jacobian }
    }

    #[inline(always)]
    fn energy<const D: usize>(e: &Elasticity, l: &Tensor<D>) -> Lanes {
        let mut energy = Lanes::ZERO;
        for lane in 0..LANES {
            let logs = principal(e, l, lane).logs;
            let log: f64 = logs.iter().sum();
            energy.0[lane] = 0.5 * bulk(e) * log * log;
            for (mu, alpha) in terms(e) {
                // e^x − 1 − x, as the isochoric logarithms have no sum.
                let excess = |x: f64| beyond_linear(alpha * (x - log / 3.0));
                energy.0[lane] += mu / alpha * logs.iter().map(|x| excess(*x)).sum::<f64>();
            }
        }
        energy
    }

    #[inline(always)]
    fn out_of_plane<const D: usize>(e: &Elasticity, l: &Tensor<D>, volumetric: Lanes) -> Lanes {
        let mut stress = Lanes::ZERO;
        if e.plane_stress || D == 3 {
            return stress;
        }
        let jacobian = cofactor(&plus_identity(l)).1;
        for lane in 0..LANES {
            let logs = principal(e, l, lane).logs;
            stress.0[lane] = kirchhoff(e, &logs, volumetric.0[lane])[2] / jacobian.0[lane];
        }
        stress
    }

    /// `ln J`.
    #[inline(always)]
    fn dilatation<const D: usize>(l: &Tensor<D>) -> Lanes {
        cofactor(&plus_identity(l)).1.map(f64::ln)
    }
}

/// `e^x − 1 − x`; by its series where that would cancel.
fn beyond_linear(x: f64) -> f64 {
    if x.abs() < 1e-2 {
        x * x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x * (1.0 / 120.0 + x / 720.0))))
    } else {
        x.exp_m1() - x
    }
}
