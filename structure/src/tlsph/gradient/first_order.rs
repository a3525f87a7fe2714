//! The paper's kernel gradient with first-order correction, Eqs. (35), (36), (42).
//!
//! Weights of a pair: `V_b ∇₀W_ab` with `∇₀W_ab = W′(r)/r (X_a − X_b)`. Constants of a particle: `K_a⁻¹`
//! (upper triangle, row by row), and `Σ_b V_b ∇₀W_ab`.

use crate::bodies::Body;
use crate::lanes::{LANES, Lanes, Tensor, matrix, product};
use crate::materials::{ConstitutiveLaw, Elasticity};
use crate::tlsph::stencil::PairOperator;
use sph::kernel::CubicSpline;
use sph::{Matrix, Vector, tensor};

/// A moment matrix whose smallest eigenvalue is under this fraction of its trace over `D` does not span all
/// directions: on a regular lattice it is one, at a corner about one.
const SINGULAR: f64 = 1e-6;

/// The operator of one body; particle indices are internal ones.
pub(crate) struct FirstOrder<'a, const D: usize> {
    body: &'a Body<D>,
    kernel: CubicSpline<D>,
    /// First internal index of the body, and the index within the body of each internal one after it.
    first: usize,
    members: &'a [Option<usize>],
    mean_volume: f64,
}

impl<'a, const D: usize> FirstOrder<'a, D> {
    pub fn new(body: &'a Body<D>, smoothing_ratio: f64, first: usize, members: &'a [Option<usize>]) -> Self {
        let kernel = CubicSpline::new(smoothing_ratio * body.spacing());
        let mean_volume = body.cell.iter().product();
        Self { body, kernel, first, members, mean_volume }
    }

    fn member(&self, internal: usize) -> usize {
        self.members[internal - self.first].expect("only members of the body are neighbours")
    }

    fn weight(&self, a: usize, b: usize) -> Vector<D> {
        let (a, b) = (self.member(a), self.member(b));
        self.kernel.gradient(&(self.body.positions[a] - self.body.positions[b])) * self.body.volumes[b]
    }

    /// `K_a = Σ_b V_b (X_b − X_a) ⊗ ∇₀W_ab`, Eq. (35).
    fn moment_matrix(&self, a: usize, neighbours: &[u32]) -> Matrix<D> {
        let x_a = self.body.positions[self.member(a)];
        neighbours.iter().fold(Matrix::zeros(), |sum, &b| {
            let x_b = self.body.positions[self.member(b as usize)];
            sum + tensor::outer(&(x_b - x_a), &self.weight(a, b as usize))
        })
    }
}

impl<const D: usize> PairOperator for FirstOrder<'_, D> {
    const WEIGHTS: usize = D;

    fn weights(&self, a: usize, b: usize, out: &mut [f64]) {
        out.copy_from_slice(self.weight(a, b).as_slice());
    }

    fn constants(&self) -> usize {
        D * (D + 1) / 2 + D
    }

    fn write_constants(&self, a: usize, neighbours: &[u32], out: &mut [f64]) -> bool {
        let Some(member) = self.members[a - self.first] else { return true };
        let k = self.moment_matrix(a, neighbours);
        let regular = tensor::smallest_eigenvalue(&k) > SINGULAR * k.trace() / D as f64;
        let (true, Some(inverse)) = (regular, tensor::inverse(&k)) else {
            return self.body.volumes[member] == 0.0;
        };
        let mut next = 0;
        for i in 0..D {
            for j in i..D {
                out[next] = inverse[(i, j)];
                next += 1;
            }
        }
        for &b in neighbours {
            for (sum, w) in out[next..].iter_mut().zip(self.weight(a, b as usize).iter()) {
                *sum += w;
            }
        }
        true
    }

    fn features(&self, a: usize, b: usize, out: &mut Vec<f64>) {
        let Some(a) = self.members[a - self.first] else { return };
        let b = self.member(b);
        let spacing = self.body.spacing();
        out.push(self.body.volumes[b] / self.mean_volume);
        out.extend(((self.body.positions[b] - self.body.positions[a]) / spacing).iter());
    }
}

/// Conjugates `Q = P K⁻¹` of the moments, so that the pair sum of Eq. (42) needs no matrix, and `J`.
#[inline(always)]
pub(crate) fn respond<const D: usize, const K: usize, L: ConstitutiveLaw>(
    elasticity: &Elasticity,
    moments: &[[Lanes; K]; D],
    constants: &[f64],
) -> ([[Lanes; K]; D], Lanes) {
    let response =
        L::respond::<D>(elasticity, &displacement_gradient::<D, K>(moments, constants), Lanes::ZERO);
    let q = product(&response.first_piola, &inverse_moment::<D>(constants));
    // K equals D here; the compiler knows it only after instantiation.
    (matrix(|i, k| q[i][k]), response.jacobian)
}

/// The displacement gradient `L = A K⁻¹`, Eq. (41), from the moments `A = Σ_b (U_b − U_a) ⊗ V_b ∇₀W_ab`.
#[inline(always)]
pub(crate) fn displacement_gradient<const D: usize, const K: usize>(
    moments: &[[Lanes; K]; D],
    constants: &[f64],
) -> Tensor<D> {
    product(&matrix(|i, j| moments[i][j]), &inverse_moment::<D>(constants))
}

/// `K⁻¹` from the upper triangle that the constants begin with.
#[inline(always)]
fn inverse_moment<const D: usize>(constants: &[f64]) -> Tensor<D> {
    matrix(|i, j| {
        let (r, c) = (i.min(j), i.max(j));
        Lanes::load(constants, (r * D - r * (r + 1) / 2 + c) * LANES)
    })
}
