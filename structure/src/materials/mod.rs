//! Elastic materials: constants, the kinematic assumption in two dimensions, and the constitutive laws, one
//! file each.
//!
//! A law is a type that implements `ConstitutiveLaw`; a new one is a new file here, a variant of [`Law`] and
//! a line in `with_law`.

mod almansi_hooke;
mod neo_hookean;
mod st_venant_kirchhoff;

pub(crate) use almansi_hooke::AlmansiHooke;
pub(crate) use neo_hookean::NeoHookean;
pub(crate) use st_venant_kirchhoff::StVenantKirchhoff;

use crate::lanes::{Lanes, Tensor};

/// The constitutive law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Law {
    /// The paper's: Cauchy stress from Almansi strain by Hooke's law, Eqs. (37)–(41).
    #[default]
    AlmansiHooke,
    /// St. Venant–Kirchhoff: second Piola–Kirchhoff stress from Green–Lagrange strain by Hooke's law.
    StVenantKirchhoff,
    /// Compressible neo-Hookean, `ψ = μ/2 (tr C − 3 − 2 ln J) + λ/2 (ln J)²`.
    NeoHookean,
}

/// What two dimensions mean; without effect in three.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Plane {
    /// No strain out of the plane, Eq. (37).
    #[default]
    Strain,
    /// No stress out of the plane, Eq. (38).
    Stress,
}

/// An isotropic elastic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Constitutive law.
    pub law: Law,
    /// Plane strain or plane stress.
    pub plane: Plane,
    /// Young's modulus `E` (Pa).
    pub youngs_modulus: f64,
    /// Poisson's ratio `ν`.
    pub poissons_ratio: f64,
}

impl Material {
    /// Lamé's constants and the plane assumption, for `D` dimensions.
    pub(crate) fn elasticity<const D: usize>(&self) -> Elasticity {
        let (e, nu) = (self.youngs_modulus, self.poissons_ratio);
        let (lambda, mu) = (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
        let plane_stress = D == 2 && self.plane == Plane::Stress;
        let in_plane_lambda = if plane_stress { 2.0 * lambda * mu / (lambda + 2.0 * mu) } else { lambda };
        Elasticity { lambda, mu, in_plane_lambda, plane_stress }
    }

    /// Speed of compression waves `c_p` (m/s) in `D` dimensions at the density given (kg/m³).
    pub fn compression_wave_speed<const D: usize>(&self, density: f64) -> f64 {
        let e = self.elasticity::<D>();
        ((e.in_plane_lambda + 2.0 * e.mu) / density).sqrt()
    }
}

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
        let mean = crate::lanes::trace(strain) * self.in_plane_lambda;
        let mut stress: Tensor<D> = crate::lanes::matrix(|i, j| strain[i][j] * (2.0 * self.mu));
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
    /// Strain energy a reference volume (J/m³).
    fn energy<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>) -> Lanes;
    /// Cauchy stress out of the plane (Pa) in two dimensions.
    fn out_of_plane<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>) -> Lanes;
}

/// Evaluates the expression with the type alias `$law` standing for the law of the value `$choice`.
macro_rules! with_law {
    ($choice:expr, $law:ident => $body:expr) => {
        match $choice {
            $crate::materials::Law::AlmansiHooke => {
                type $law = $crate::materials::AlmansiHooke;
                $body
            }
            $crate::materials::Law::StVenantKirchhoff => {
                type $law = $crate::materials::StVenantKirchhoff;
                $body
            }
            $crate::materials::Law::NeoHookean => {
                type $law = $crate::materials::NeoHookean;
                $body
            }
        }
    };
}
pub(crate) use with_law;

#[cfg(test)]
mod tests;
