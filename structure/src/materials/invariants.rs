//! Rubber by the invariants of the isochoric deformation: Mooney–Rivlin and Yeoh.

use crate::lanes::{
    LANES, Lanes, Tensor, cofactor, matrix, plus_identity, product, trace, transposed_product,
};
use crate::materials::law::{ConstitutiveLaw, Elasticity, Response};

/// `ψ = C₁₀ (Ī₁ − 3) + C₀₁ (Ī₂ − 3) + C₂₀ (Ī₁ − 3)² + C₃₀ (Ī₁ − 3)³ + κ/2 (ln J)²`, `Ī₁ = J^(−2/3) tr C`,
/// `Ī₂ = J^(−4/3) ½ ((tr C)² − tr C²)`: Mooney 1940 and Rivlin 1948 with the first two constants, Yeoh 1993
/// with all but the second; the volumetric part of Simo, Taylor and Pister 1985. With `W₁ = ∂ψ/∂Ī₁`,
/// `W₂ = ∂ψ/∂Ī₂` (Holzapfel 2000, Eqs. (6.90), (6.102))
///
/// `P = 2 W₁ J^(−2/3) (F − I₁/3 F⁻ᵀ) + 2 W₂ J^(−4/3) (I₁ F − F C − ⅔ I₂ F⁻ᵀ) + κ ln J F⁻ᵀ`.
///
/// In plane stress the stretch out of the plane follows from `∂ψ/∂ ln F₃₃ = 0`.
pub(crate) struct Invariants;

/// Newton iterations for the stretch out of the plane, from that of an incompressible sheet.
const NEWTON_ITERATIONS: usize = 12;

/// What the invariants are made of, in three dimensions whatever `D` is.
struct Kinematics<const D: usize> {
    f: Tensor<D>,
    cofactor: Tensor<D>,
    /// `J` of the plane in two dimensions.
    in_plane: Lanes,
    /// `F₃₃` in two dimensions, one in three.
    thickness: Lanes,
}

impl<const D: usize> Kinematics<D> {
    #[inline(always)]
    fn new(elasticity: &Elasticity, l: &Tensor<D>) -> Self {
        let f = plus_identity(l);
        let (cofactor, in_plane) = cofactor(&f);
        let mut thickness = Lanes::splat(1.0);
        if D == 2 && elasticity.plane_stress {
            let c = transposed_product(&f, &f);
            let (trace, square) = (trace(&c), in_plane * in_plane);
            for lane in 0..LANES {
                thickness.0[lane] = thickness_stretch(elasticity, trace.0[lane], square.0[lane]);
            }
        }
        Self { f, cofactor, in_plane, thickness }
    }

    /// `ln J`.
    #[inline(always)]
    fn log(&self) -> Lanes {
        (self.in_plane * self.thickness).map(f64::ln)
    }
}

/// `W₁`, at `x = Ī₁ − 3`, and its derivative.
#[inline(always)]
fn first_slope(e: &Elasticity, x: f64) -> (f64, f64) {
    let [c10, _, c20, c30] = e.constants;
    (c10 + x * (2.0 * c20 + x * 3.0 * c30), 2.0 * c20 + x * 6.0 * c30)
}

/// `κ` (Pa) of the particle's own dilatation.
#[inline(always)]
fn bulk(e: &Elasticity) -> f64 {
    e.lambda + 2.0 / 3.0 * e.mu
}

/// The stretch without stress out of the plane, where `C` has this trace and determinant in the plane; one
/// where the determinant is not positive.
fn thickness_stretch(e: &Elasticity, trace: f64, determinant: f64) -> f64 {
    if determinant.is_nan() || determinant <= 0.0 {
        return 1.0;
    }
    let mut y = -0.5 * determinant.ln();
    for _ in 0..NEWTON_ITERATIONS {
        let c33 = (2.0 * y).exp();
        let log = 0.5 * determinant.ln() + y;
        let a = (-2.0 / 3.0 * log).exp();
        let (first, second) = (trace + c33, determinant + c33 * trace);
        let (w1, w11) = first_slope(e, a * first - 3.0);
        let w2 = e.constants[1];
        // ∂Ī₁/∂y and ∂Ī₂/∂y are twice these.
        let p = a * (c33 - first / 3.0);
        let q = a * a * (c33 * trace - 2.0 / 3.0 * second);
        let residual = 2.0 * (w1 * p + w2 * q) + bulk(e) * log;
        let p_slope = a * 4.0 / 3.0 * c33 - 2.0 / 3.0 * p;
        let q_slope = a * a * 2.0 / 3.0 * c33 * trace - 4.0 / 3.0 * q;
        y -= residual / (2.0 * (w1 * p_slope + w2 * q_slope) + 4.0 * w11 * p * p + bulk(e));
    }
    y.exp()
}

/// `det(I + L) − 1` without the loss of small `L`.
#[inline(always)]
fn jacobian_excess<const D: usize>(l: &Tensor<D>) -> Lanes {
    if D == 2 {
        return trace(l) + (l[0][0] * l[1][1] - l[0][1] * l[1][0]);
    }
    let minor = |i: usize, j: usize| l[i][i] * l[j][j] - l[i][j] * l[j][i];
    trace(l) + minor(0, 1) + minor(0, D - 1) + minor(1, D - 1) + cofactor(l).1
}

impl ConstitutiveLaw for Invariants {
    #[inline(always)]
    fn respond<const D: usize>(e: &Elasticity, l: &Tensor<D>, volumetric: Lanes) -> Response<D> {
        let k = Kinematics::new(e, l);
        let c = transposed_product(&k.f, &k.f);
        let log = k.log();
        let a = log.map(|log| (-2.0 / 3.0 * log).exp());
        let c33 = if D == 2 { k.thickness * k.thickness } else { Lanes::ZERO };
        let in_plane = trace(&c);
        let first = in_plane + c33;
        let squares = trace(&transposed_product(&c, &c)) + c33 * c33;
        let second = (first * first - squares) * 0.5;
        let w1 = (a * first - Lanes::splat(3.0)).map(|x| first_slope(e, x).0);
        let (of_first, of_second) = (w1 * a * 2.0, a * a * (2.0 * e.constants[1]));
        let fc = product(&k.f, &c);
        let pressure =
            log * bulk(e) + volumetric - of_first * first * (1.0 / 3.0) - of_second * second * (2.0 / 3.0);
        let inverse = k.in_plane.recip();
        let first_piola = matrix(|i, j| {
            k.f[i][j] * (of_first + of_second * first) - fc[i][j] * of_second
                + k.cofactor[i][j] * (pressure * inverse)
        });
        Response { first_piola, jacobian: k.in_plane }
    }

    #[inline(always)]
    fn energy<const D: usize>(e: &Elasticity, l: &Tensor<D>) -> Lanes {
        let k = Kinematics::new(e, l);
        let stretch = k.thickness - Lanes::splat(1.0);
        let excess = jacobian_excess(l);
        // ln J, I₁ − 3 and I₂ − 3 from L, which keep small strains.
        let log = excess.map(f64::ln_1p) + stretch.map(f64::ln_1p);
        let c = matrix::<D, D>(|i, j| {
            let mut square = l[0][i] * l[0][j];
            for m in 1..D {
                square += l[m][i] * l[m][j];
            }
            l[i][j] + l[j][i] + square
        });
        let c33 = if D == 2 { stretch * 2.0 + stretch * stretch } else { Lanes::ZERO };
        let first = trace(&c) + c33;
        // With C = I + c: I₂ − 3 = 2 tr c + ½ ((tr c)² − tr c²).
        let squares = trace(&transposed_product(&c, &c)) + c33 * c33;
        let second = first * 2.0 + (first * first - squares) * 0.5;
        let a = log.map(|log| (-2.0 / 3.0 * log).exp());
        let x = a * (first - log.map(|log| 3.0 * (2.0 / 3.0 * log).exp_m1()));
        let y = a * a * (second - log.map(|log| 3.0 * (4.0 / 3.0 * log).exp_m1()));
        let [c10, c01, c20, c30] = e.constants;
        let powers = x.map(|x| x * (c10 + x * (c20 + x * c30)));
        powers + y * c01 + log * log * (0.5 * bulk(e))
    }

    #[inline(always)]
    fn out_of_plane<const D: usize>(e: &Elasticity, l: &Tensor<D>, volumetric: Lanes) -> Lanes {
        if e.plane_stress {
            return Lanes::ZERO;
        }
        let k = Kinematics::new(e, l);
        let c = transposed_product(&k.f, &k.f);
        let log = k.log();
        let a = log.map(|log| (-2.0 / 3.0 * log).exp());
        let (in_plane, one) = (trace(&c), Lanes::splat(1.0));
        let first = in_plane + one;
        let second = k.in_plane * k.in_plane + in_plane;
        let w1 = (a * first - Lanes::splat(3.0)).map(|x| first_slope(e, x).0);
        let deviatoric = w1 * a * 2.0 * (one - first * (1.0 / 3.0))
            + a * a * (2.0 * e.constants[1]) * (in_plane - second * (2.0 / 3.0));
        (deviatoric + log * bulk(e) + volumetric) * k.in_plane.recip()
    }

    /// `ln J`.
    #[inline(always)]
    fn dilatation<const D: usize>(l: &Tensor<D>) -> Lanes {
        cofactor(&plus_identity(l)).1.map(f64::ln)
    }
}
