//! Compressible neo-Hookean material.

use crate::lanes::{Lanes, Tensor, cofactor, matrix, plus_identity, trace, transposed_product};
use crate::materials::law::{ConstitutiveLaw, Elasticity, Response};

/// `ψ = μ/2 (tr C − 3 − 2 ln J) + λ/2 (ln J)²`, `P = μ (F − F⁻ᵀ) + λ ln J F⁻ᵀ` (Bonet and Wood 2008, Eq.
/// (6.28)).
///
/// In plane stress the stretch out of the plane follows from `S₃₃ = 0`, that is
/// `μ (F₃₃² − 1) + λ ln(J₂ F₃₃) = 0`.
pub(crate) struct NeoHookean;

/// Newton iterations for the stretch out of the plane. It converges quadratically from `J₂^(−λ/(λ+2μ))`, the
/// small-strain value; six give round-off for `J₂` between 0.3 and 4 (tested).
const NEWTON_ITERATIONS: usize = 8;

/// Stretch out of the plane: one in plane strain, in three dimensions, and where `J` is not positive.
#[inline(always)]
fn thickness_stretch(elasticity: &Elasticity, jacobian: Lanes) -> Lanes {
    if !elasticity.plane_stress {
        return Lanes::splat(1.0);
    }
    let (lambda, mu) = (elasticity.lambda, elasticity.mu);
    jacobian.map(|j| {
        if j.is_nan() || j <= 0.0 {
            return 1.0;
        }
        // In y = ln F₃₃ the equation is convex and smooth: μ (e^{2y} − 1) + λ (ln J₂ + y) = 0.
        let log_j = j.ln();
        let mut y = -lambda / (lambda + 2.0 * mu) * log_j;
        for _ in 0..NEWTON_ITERATIONS {
            let square = (2.0 * y).exp();
            y -= (mu * (square - 1.0) + lambda * (log_j + y)) / (2.0 * mu * square + lambda);
        }
        y.exp()
    })
}

impl ConstitutiveLaw for NeoHookean {
    #[inline(always)]
    fn respond<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>, volumetric: Lanes) -> Response<D> {
        let f = plus_identity(l);
        let (cofactor, jacobian) = cofactor(&f);
        let log = (jacobian * thickness_stretch(elasticity, jacobian)).map(f64::ln);
        let coefficient =
            (log * elasticity.lambda + volumetric - Lanes::splat(elasticity.mu)) * jacobian.recip();
        let first_piola = matrix(|i, j| f[i][j] * elasticity.mu + cofactor[i][j] * coefficient);
        Response { first_piola, jacobian }
    }

    #[inline(always)]
    fn energy<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>) -> Lanes {
        let f = plus_identity(l);
        let jacobian = cofactor(&f).1;
        let stretch = thickness_stretch(elasticity, jacobian);
        let log = (jacobian * stretch).map(f64::ln);
        // tr C − D directly would lose small strains; the same is tr(Lᵀ L) + 2 tr L.
        let excess =
            trace(&transposed_product(l, l)) + trace(l) * 2.0 + (stretch * stretch - Lanes::splat(1.0));
        (excess - log * 2.0) * (0.5 * elasticity.mu) + log * log * (0.5 * elasticity.lambda)
    }

    #[inline(always)]
    fn out_of_plane<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>, volumetric: Lanes) -> Lanes {
        if elasticity.plane_stress {
            return Lanes::ZERO;
        }
        let jacobian = cofactor(&plus_identity(l)).1;
        jacobian.map(f64::ln) * jacobian.recip() * elasticity.lambda + volumetric * jacobian.recip()
    }

    /// `ln J`.
    #[inline(always)]
    fn dilatation<const D: usize>(l: &Tensor<D>) -> Lanes {
        cofactor(&plus_identity(l)).1.map(f64::ln)
    }
}
