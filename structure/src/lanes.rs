//! Eight particles at once: arithmetic on small arrays, which the compiler turns into the vector instructions
//! of the machine it runs on (chosen at run time by `pulp`, see `tlsph::kernels`). No fused multiply-add is
//! used, so results are the same to the bit whatever the width of the vectors.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// Particles worked on together.
pub(crate) const LANES: usize = 8;

/// One number for each of [`LANES`] particles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub(crate) struct Lanes(pub [f64; LANES]);

/// One second-order tensor for each of [`LANES`] particles.
pub(crate) type Tensor<const D: usize> = [[Lanes; D]; D];

impl Lanes {
    pub const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    pub fn load(from: &[f64], start: usize) -> Self {
        let run: &[f64; LANES] =
            from[start..start + LANES].try_into().expect("the range has the lanes' length");
        Self(*run)
    }

    #[inline(always)]
    pub fn gather(from: &[f64], indices: &[u32; LANES]) -> Self {
        let mut out = Self::ZERO;
        for l in 0..LANES {
            out.0[l] = from[indices[l] as usize];
        }
        out
    }

    #[inline(always)]
    pub fn store(self, to: &mut [f64], start: usize) {
        to[start..start + LANES].copy_from_slice(&self.0);
    }

    #[inline(always)]
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut out = self;
        for l in 0..LANES {
            out.0[l] = f(out.0[l]);
        }
        out
    }

    #[inline(always)]
    pub fn recip(self) -> Self {
        let mut out = self;
        for l in 0..LANES {
            out.0[l] = 1.0 / out.0[l];
        }
        out
    }

    /// Whether all are positive; not-a-number is not.
    #[inline(always)]
    pub fn all_positive(self) -> bool {
        let mut all = true;
        for l in 0..LANES {
            all &= self.0[l] > 0.0;
        }
        all
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let mut out = self;
        for l in 0..LANES {
            out.0[l] += other.0[l];
        }
        out
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let mut out = self;
        for l in 0..LANES {
            out.0[l] -= other.0[l];
        }
        out
    }
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let mut out = self;
        for l in 0..LANES {
            out.0[l] = -out.0[l];
        }
        out
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let mut out = self;
        for l in 0..LANES {
            out.0[l] *= other.0[l];
        }
        out
    }
}

impl Mul<f64> for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        let mut out = self;
        for l in 0..LANES {
            out.0[l] *= factor;
        }
        out
    }
}

/// A vector of lanes by its components. (Library functions over arrays are not inlined into code for other
/// instruction sets.)
#[inline(always)]
pub(crate) fn row<const N: usize>(entry: impl Fn(usize) -> Lanes) -> [Lanes; N] {
    let mut out = [Lanes::ZERO; N];
    for i in 0..N {
        out[i] = entry(i);
    }
    out
}

/// A matrix of lanes by its entries.
#[inline(always)]
pub(crate) fn matrix<const N: usize, const M: usize>(
    entry: impl Fn(usize, usize) -> Lanes,
) -> [[Lanes; M]; N] {
    let mut out = [[Lanes::ZERO; M]; N];
    for i in 0..N {
        for j in 0..M {
            out[i][j] = entry(i, j);
        }
    }
    out
}

/// `a b`.
#[inline(always)]
pub(crate) fn product<const D: usize>(a: &Tensor<D>, b: &Tensor<D>) -> Tensor<D> {
    matrix(|i, j| {
        let mut sum = a[i][0] * b[0][j];
        for k in 1..D {
            sum += a[i][k] * b[k][j];
        }
        sum
    })
}

/// `aᵀ b`.
#[inline(always)]
pub(crate) fn transposed_product<const D: usize>(a: &Tensor<D>, b: &Tensor<D>) -> Tensor<D> {
    matrix(|i, j| {
        let mut sum = a[0][i] * b[0][j];
        for k in 1..D {
            sum += a[k][i] * b[k][j];
        }
        sum
    })
}

/// `I + l`.
#[inline(always)]
pub(crate) fn plus_identity<const D: usize>(l: &Tensor<D>) -> Tensor<D> {
    matrix(|i, j| if i == j { l[i][j] + Lanes::splat(1.0) } else { l[i][j] })
}

/// Sum of the diagonal.
#[inline(always)]
pub(crate) fn trace<const D: usize>(a: &Tensor<D>) -> Lanes {
    let mut sum = a[0][0];
    for i in 1..D {
        sum += a[i][i];
    }
    sum
}

/// The cofactor matrix `(det a) a⁻ᵀ`, and the determinant.
#[inline(always)]
pub(crate) fn cofactor<const D: usize>(a: &Tensor<D>) -> (Tensor<D>, Lanes) {
    let cofactor: Tensor<D> = if D == 2 {
        matrix(|i, j| {
            let value = a[1 - i][1 - j];
            if i == j { value } else { -value }
        })
    } else {
        matrix(|i, j| {
            let (i1, i2, j1, j2) = ((i + 1) % D, (i + 2) % D, (j + 1) % D, (j + 2) % D);
            a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1]
        })
    };
    let mut determinant = a[0][0] * cofactor[0][0];
    for j in 1..D {
        determinant += a[0][j] * cofactor[0][j];
    }
    (cofactor, determinant)
}

/// Green–Lagrange strain `E = ½ (L + Lᵀ + Lᵀ L)`, the paper's Eq. (40), of the displacement gradient `L`.
#[inline(always)]
pub(crate) fn green_lagrange<const D: usize>(l: &Tensor<D>) -> Tensor<D> {
    let square = transposed_product(l, l);
    matrix(|i, j| (l[i][j] + l[j][i] + square[i][j]) * 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cofactor_by_hand() {
        let s = Lanes::splat;
        let (c, j) = cofactor(&[[s(2.0), s(1.0)], [s(0.5), s(3.0)]]);
        assert_eq!(j, s(5.5));
        assert_eq!(c, [[s(3.0), s(-0.5)], [s(-1.0), s(2.0)]]);
        let (c, j) =
            cofactor(&[[s(2.0), s(0.0), s(0.0)], [s(0.0), s(3.0), s(1.0)], [s(0.0), s(0.0), s(4.0)]]);
        assert_eq!(j, s(24.0));
        assert_eq!((c[0][0], c[1][1], c[2][1], c[2][2]), (s(12.0), s(8.0), s(-2.0), s(6.0)));
    }

    #[test]
    fn green_lagrange_of_a_stretch_by_hand() {
        let s = Lanes::splat;
        let e = green_lagrange(&[[s(0.5), s(0.0)], [s(0.2), s(0.0)]]);
        assert_eq!(e[0][0], s(0.5 + 0.5 * (0.25 + 0.2 * 0.2)));
        assert_eq!(e[0][1], s(0.1));
    }
}
