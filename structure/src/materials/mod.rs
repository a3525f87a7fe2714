//! Elastic materials: constants, the kinematic assumption in two dimensions, and the constitutive laws, one
//! file each.
//!
//! A law is a type that implements `law::ConstitutiveLaw`; a new one is a new file here, a variant of [`Law`]
//! and a line in `with_law`.

mod almansi_hooke;
mod law;
mod neo_hookean;
mod st_venant_kirchhoff;

pub(crate) use almansi_hooke::AlmansiHooke;
pub(crate) use law::{ConstitutiveLaw, Elasticity};
pub(crate) use neo_hookean::NeoHookean;
pub(crate) use st_venant_kirchhoff::StVenantKirchhoff;

use sph::Matrix;

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
