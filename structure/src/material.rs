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
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Stress–strain law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// The paper's: Cauchy stress from Almansi strain by Hooke's law, Eqs. (37)–(41). It has no potential and
    /// may gain energy in long runs without damping.
    AlmansiHooke,
    /// St. Venant–Kirchhoff: second Piola–Kirchhoff stress from Green–Lagrange strain by Hooke's law.
    #[serde(rename = "saint-venant-kirchhoff")]
    StVenantKirchhoff,
    /// Compressible neo-Hookean, `ψ = μ/2 (tr C − 3 − 2 ln J) + λ/2 (ln J)²`.
    NeoHookean,
}

/// How two dimensions stand for three.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Plane {
    /// No strain out of the plane, Eq. (37).
    #[serde(rename = "plane-strain")]
    Strain,
    /// No stress out of the plane, Eq. (38).
    #[serde(rename = "plane-stress")]
    Stress,
    /// Three dimensions: no assumption.
    #[serde(rename = "three-dimensional")]
    ThreeDimensional,
}

/// An isotropic elastic material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Material {
    /// Stress–strain law.
    pub law: Law,
    /// Young's modulus E (Pa).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub youngs_modulus: f64,
    /// Poisson's ratio ν; over −1 and under 0.5, in plane stress at most 0.5.
    #[serde(rename = "poisson_ratio")]
    pub poissons_ratio: f64,
    /// How two dimensions stand for three; in three dimensions `"three-dimensional"` if left out.
    #[serde(rename = "assumption")]
    pub plane: Plane,
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
            $crate::material::Law::AlmansiHooke => {
                type $law = $crate::material::AlmansiHooke;
                $body
            }
            $crate::material::Law::StVenantKirchhoff => {
                type $law = $crate::material::StVenantKirchhoff;
                $body
            }
            $crate::material::Law::NeoHookean => {
                type $law = $crate::material::NeoHookean;
                $body
            }
        }
    };
}
pub(crate) use with_law;

#[cfg(test)]
mod tests;
