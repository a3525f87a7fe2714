//! St. Venant–Kirchhoff: Hooke's law between second Piola–Kirchhoff stress and Green–Lagrange strain.

use crate::lanes::{
    Lanes, Tensor, cofactor, green_lagrange, plus_identity, product, trace, transposed_product,
};
use crate::materials::law::{ConstitutiveLaw, Elasticity, Response};

/// `S = λ tr(E) I + 2 μ E`, `P = F S`, with the potential `ψ = ½ E : S`.
pub(crate) struct StVenantKirchhoff;

impl ConstitutiveLaw for StVenantKirchhoff {
    #[inline(always)]
    fn respond<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>, volumetric: Lanes) -> Response<D> {
        let f = plus_identity(l);
        let first_piola = product(&f, &elasticity.hooke(&green_lagrange(l), volumetric));
        Response { first_piola, jacobian: cofactor(&f).1 }
    }

    #[inline(always)]
    fn energy<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>) -> Lanes {
        let strain = green_lagrange(l);
        trace(&transposed_product(&elasticity.hooke(&strain, Lanes::ZERO), &strain)) * 0.5
    }

    #[inline(always)]
    fn out_of_plane<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>, volumetric: Lanes) -> Lanes {
        let lambda = if elasticity.plane_stress { 0.0 } else { elasticity.lambda };
        let jacobian = cofactor(&plus_identity(l)).1;
        trace(&green_lagrange(l)) * jacobian.recip() * lambda + volumetric * jacobian.recip()
    }

    /// `tr E`.
    #[inline(always)]
    fn dilatation<const D: usize>(l: &Tensor<D>) -> Lanes {
        trace(&green_lagrange(l))
    }
}
