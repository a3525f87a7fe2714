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
    /// `λ` (Pa) in the strain-gradient energy of the quadratic gradient.
    pub strain_gradient_lambda: f64,
    /// `λ_p` (Pa) that acts on the dilatation's mean over patches, in addition to the others.
    pub patch_lambda: f64,
    /// Constants (Pa) of rubber: `C₁₀`, `C₀₁`, `C₂₀`, `C₃₀`, or Ogden's `μ_p`.
    pub constants: [f64; 4],
    /// Ogden's `α_p`.
    pub exponents: [f64; 3],
}

/// `λ/μ` up to which every particle's own dilatation bears it: `ν = 0.4`.
const OWN_LIMIT: f64 = 4.0;

/// `λ/μ` from which own dilatations bear [`OWN_SHARE`] and strain gradients nothing: `ν = 0.4286`.
const PATCH_LIMIT: f64 = 6.0;

/// `λ/μ` that stays with every particle's own dilatation where patches bear the rest: that of `ν = 1/3`.
/// Less gives softer patches and no better bending (measured: 0, 1, 2).
const OWN_SHARE: f64 = 2.0;

impl Elasticity {
    /// Leaves to patches what locks: `λ` above four `μ`. From there on less of it acts on own dilatations
    /// and strain gradients, so that the answer does not jump between two Poisson's ratios.
    #[must_use]
    pub fn with_patches(self) -> Self {
        let ratio = self.in_plane_lambda / self.mu;
        let blend = ((ratio - OWN_LIMIT) / (PATCH_LIMIT - OWN_LIMIT)).clamp(0.0, 1.0);
        if blend < 1e-9 {
            return self;
        }
        let own = (OWN_LIMIT + blend * (OWN_SHARE - OWN_LIMIT)) * self.mu;
        Self {
            lambda: own,
            in_plane_lambda: own,
            strain_gradient_lambda: (1.0 - blend) * OWN_LIMIT * self.mu,
            patch_lambda: self.in_plane_lambda - own,
            ..self
        }
    }

    /// Hooke's law `(λ tr(ε) + p) I + 2 μ ε`, `p` the volumetric stress that patches add.
    #[inline(always)]
    pub fn hooke<const D: usize>(&self, strain: &Tensor<D>, volumetric: Lanes) -> Tensor<D> {
        let mean = trace(strain) * self.in_plane_lambda + volumetric;
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
/// `L = F − I` (which keeps small strains exact) and the volumetric stress `p` (Pa) that patches add to that
/// of the particle's own dilatation `f`.
pub(crate) trait ConstitutiveLaw {
    /// Stress, `p ∂f/∂F` in it, and Jacobian.
    fn respond<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>, volumetric: Lanes) -> Response<D>;
    /// Strain energy per reference volume (J/m³), that of patches left out.
    fn energy<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>) -> Lanes;
    /// Cauchy stress out of the plane (Pa) in two dimensions.
    fn out_of_plane<const D: usize>(elasticity: &Elasticity, l: &Tensor<D>, volumetric: Lanes) -> Lanes;
    /// The dilatation `f`: the measure of the change of volume whose square times `λ/2` is in the energy.
    fn dilatation<const D: usize>(l: &Tensor<D>) -> Lanes;
}
