//! Elastic materials: constants, the kinematic assumption in two dimensions, and the constitutive laws, one
//! file each.
//!
//! A law is a type that implements `law::ConstitutiveLaw`; a new one is a new file here, a variant of [`Law`]
//! and a line in `with_law`.

mod almansi_hooke;
mod invariants;
mod law;
mod neo_hookean;
mod ogden;
mod rubber;
mod st_venant_kirchhoff;

pub(crate) use almansi_hooke::AlmansiHooke;
pub(crate) use invariants::Invariants;
pub(crate) use law::{ConstitutiveLaw, Elasticity};
pub(crate) use neo_hookean::NeoHookean;
pub(crate) use ogden::Ogden;
pub use rubber::Constants;
pub(crate) use st_venant_kirchhoff::StVenantKirchhoff;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sph::Matrix;

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
    /// Rubber: `ψ = C₁₀ (Ī₁ − 3) + C₀₁ (Ī₂ − 3) + κ/2 (ln J)²`; `constants` are `C₁₀`, `C₀₁`.
    MooneyRivlin,
    /// Rubber: `ψ = Σ C_i0 (Ī₁ − 3)^i + κ/2 (ln J)²`; `constants` are `C₁₀`, `C₂₀`, `C₃₀`.
    Yeoh,
    /// Rubber: `ψ = Σ μ_p/α_p (λ̄₁^α_p + λ̄₂^α_p + λ̄₃^α_p − 3) + κ/2 (ln J)²`; `constants` are the `μ_p`,
    /// `exponents` the `α_p`.
    Ogden,
}

/// `λ` counts in the strain-gradient energy up to this many `μ` (`ν = 0.4`).
const STRAIN_GRADIENT_LIMIT: f64 = 4.0;

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
    /// Young's modulus E (Pa). Laws with constants have one from them, at small strain, and it is left out:
    /// `2 (1 + ν) μ`, where `μ` is `2 (C₁₀ + C₀₁)`, `2 C₁₀` or `½ Σ μ_p α_p`.
    #[schemars(with = "Option<f64>", extend("exclusiveMinimum" = 0))]
    pub youngs_modulus: f64,
    /// Poisson's ratio ν; over −1 and under 0.5.
    pub poisson_ratio: f64,
    /// How two dimensions stand for three; in three dimensions `"three-dimensional"` if left out.
    pub assumption: Plane,
    /// Constants of the laws for rubber (Pa), up to three.
    #[serde(default, skip_serializing_if = "Constants::are_none")]
    pub constants: Constants,
    /// Exponents of Ogden's law, one for each constant.
    #[serde(default, skip_serializing_if = "Constants::are_none")]
    pub exponents: Constants,
}

impl Material {
    /// A material of a law that is given by Young's modulus (Pa) and Poisson's ratio.
    pub const fn new(law: Law, youngs_modulus: f64, poisson_ratio: f64, assumption: Plane) -> Self {
        let none = Constants([0.0; 3]);
        Self { law, youngs_modulus, poisson_ratio, assumption, constants: none, exponents: none }
    }

    /// Lamé's constants and the plane assumption, for `D` dimensions.
    pub(crate) fn elasticity<const D: usize>(&self) -> Elasticity {
        let nu = self.poisson_ratio;
        let e = self.modulus_of_constants().unwrap_or(self.youngs_modulus);
        let (lambda, mu) = (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
        let plane_stress = D == 2 && self.assumption == Plane::Stress;
        let in_plane_lambda = if plane_stress { 2.0 * lambda * mu / (lambda + 2.0 * mu) } else { lambda };
        let strain_gradient_lambda = in_plane_lambda.min(STRAIN_GRADIENT_LIMIT * mu);
        Elasticity {
            lambda,
            mu,
            in_plane_lambda,
            plane_stress,
            strain_gradient_lambda,
            patch_lambda: 0.0,
            constants: self.polynomial(),
            exponents: self.exponents.0,
        }
    }

    /// Speed of compression waves `c_p` (m/s) in `D` dimensions at the density given (kg/m³).
    pub fn compression_wave_speed<const D: usize>(&self, density: f64) -> f64 {
        let e = self.elasticity::<D>();
        ((e.in_plane_lambda + 2.0 * e.mu) / density).sqrt()
    }
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
            $crate::materials::Law::MooneyRivlin | $crate::materials::Law::Yeoh => {
                type $law = $crate::materials::Invariants;
                $body
            }
            $crate::materials::Law::Ogden => {
                type $law = $crate::materials::Ogden;
                $body
            }
        }
    };
}
pub(crate) use with_law;

/// Von Mises stress `√(3/2 s : s)` of the deviator, with the stress out of the plane in two dimensions.
pub(crate) fn von_mises<const D: usize>(sigma: &Matrix<D>, out_of_plane: f64) -> f64 {
    let third = if D == 2 { out_of_plane } else { 0.0 };
    let mean = (sigma.trace() + third) / 3.0;
    let mut square = if D == 2 { (third - mean).powi(2) } else { 0.0 };
    for i in 0..D {
        for j in 0..D {
            square += (sigma[(i, j)] - if i == j { mean } else { 0.0 }).powi(2);
        }
    }
    (1.5 * square).sqrt()
}

#[cfg(test)]
mod tests;
