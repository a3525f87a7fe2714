//! What a constitutive law is, and the constants that it works with.

use crate::lanes::{Lanes, Tensor, matrix, trace};

/// Lamé's constants, as the laws use them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Elasticity {
    /// `λ` (Pa) of the material.
    pub lambda: f64,
    /// `μ` (Pa).
    pub mu: f64,
    /// `λ` (Pa) that in-plane stresses see: `2λμ/(λ + 2μ)` in plane stress.
    pub in_plane_lambda: f64,
    /// Whether the stress out of the plane is zero.
    pub plane_stress: bool,
}

impl Elasticity {
    /// Hooke's law `λ tr(ε) I + 2 μ ε`.
    #[inline(always)]
    pub fn hooke<const D: usize>(&self, strain: &Tensor<D>) -> Tensor<D> {
        let mean = trace(strain) * self.in_plane_lambda;
        let mut stress: Tensor<D> = matrix(|i, j| strain[i][j] * (2.0 * self.mu));
        for i in 0..D {
            stress[i][i] += mean;
        }
        stress
    }
}

/// What a law gives at one displacement gradient.
pub(crate) struct Response<const D: usize> {
    /// First Piola–Kirchhoff stress `P` (Pa), entry `(i, J)` spatial and material.
    pub first_piola: Tensor<D>,
    /// `J = det F`, of the in-plane deformation gradient in two dimensions.
    pub jacobian: Lanes,
}

/// One constitutive law: stress, energy and the stress out of the plane, all from the displacement gradient
/// `L = F − I` (which keeps small strains exact).
pub(crate) trait ConstitutiveLaw {
    /// Stress and Jacobian.
    fn respond<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>) -> Response<D>;
    /// Strain energy per reference volume (J/m³).
    fn energy<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>) -> Lanes;
    /// Cauchy stress out of the plane (Pa) in two dimensions.
    fn out_of_plane<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>) -> Lanes;
}
