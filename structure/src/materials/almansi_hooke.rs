//! The paper's law: Hooke's law between Cauchy stress and Almansi strain.

use crate::lanes::{
    Lanes, Tensor, cofactor, green_lagrange, matrix, plus_identity, product, trace, transposed_product,
};
use crate::materials::law::{ConstitutiveLaw, Elasticity, Response};

/// `σ = λ tr(ε) I + 2 μ ε` with the Almansi strain `ε = F⁻ᵀ E F⁻¹`, Eqs. (37)–(41), and `P = J σ F⁻ᵀ`, Eq.
/// (34) (the paper prints `F⁻¹` there, and `F⁻ᵀ E Eᵀ` in Eq. (39), which do not transform as these tensors
/// must).
///
/// The law has no potential at finite strain; the energy reported is `½ J σ : ε`, its value at small strain.
/// A cycle of stretches between 0 and `s` in x and between `−s` and 0 in y gives or takes the work
/// `2 (λ + μ) s³` (tested), so short waves in a strained body may gain energy from nothing where the
/// integrator takes none (`docs/decisions/0006-potential.md`). The other laws have potentials and keep theirs
/// to 1e-5.
pub(crate) struct AlmansiHooke;

/// Cofactor of `F`, `J` and the Almansi strain.
#[inline(always)]
fn kinematics<const D: usize>(l: &Tensor<D>) -> (Tensor<D>, Lanes, Tensor<D>) {
    let (cofactor, jacobian) = cofactor(&plus_identity(l));
    let scale = jacobian.recip();
    let inverse_transposed = matrix(|i, j| cofactor[i][j] * scale);
    let half = product(&inverse_transposed, &green_lagrange(l));
    // F⁻ᵀ E F⁻¹ = (F⁻ᵀ E) (F⁻ᵀ)ᵀ
    let strain = matrix(|i, j| {
        let mut sum = half[i][0] * inverse_transposed[j][0];
        for k in 1..D {
            sum += half[i][k] * inverse_transposed[j][k];
        }
        sum
    });
    (cofactor, jacobian, strain)
}

impl ConstitutiveLaw for AlmansiHooke {
    #[inline(always)]
    fn respond<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>, volumetric: Lanes) -> Response<D> {
        let (cofactor, jacobian, strain) = kinematics(l);
        Response { first_piola: product(&elasticity.hooke(&strain, volumetric), &cofactor), jacobian }
    }

    #[inline(always)]
    fn energy<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>) -> Lanes {
        let (_, jacobian, strain) = kinematics(l);
        let work = transposed_product(&elasticity.hooke(&strain, Lanes::ZERO), &strain);
        trace(&work) * jacobian * 0.5
    }

    #[inline(always)]
    fn out_of_plane<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>, volumetric: Lanes) -> Lanes {
        let lambda = if elasticity.plane_stress { 0.0 } else { elasticity.lambda };
        trace(&kinematics(l).2) * lambda + volumetric
    }

    /// `tr ε`.
    #[inline(always)]
    fn dilatation<const D: usize>(l: &Tensor<D>) -> Lanes {
        trace(&kinematics(l).2)
    }
}
