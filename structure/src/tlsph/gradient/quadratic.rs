//! A quadratic gradient with a strain-gradient energy: right in bending at a few particles through the
//! thickness, and free of zero-energy modes without any control.
//!
//! In the reference configuration a moving-least-squares fit in difference form gives at each particle `a`
//! the gradient *and the second gradient* (Hessian) of the displacement, from the basis `p = (ΔX, ½ΔX², …)`,
//! `ΔX = X_b − X_a`, and the weights `w = −W′(r)/r` of the cubic spline with `h = Δx`. It is exact for linear
//! fields always, for quadratic ones where the neighbours resolve them; the Hessian directions that they do
//! not resolve (scaled eigenvalue under [`RESOLVED`], at surfaces mostly) are dropped from the fit.
//!
//! The energy of a particle is that of its cell, to second order over the cell:
//! `Π_a = V_a [ψ(F_a) + ½ sᵀ D̃ s]`, where `s` stacks the Voigt components of `∂E/∂X_k = sym(Fᵀ ∂F/∂X_k)` and
//! `D = S ⊗ C` holds the cell's second moments `S` (`diag(Δx_k²/12)` on a lattice; naturally stabilised nodal
//! integration, Hillman and Chen 2016). `D̃` is `D` with the dropped directions condensed out. `C` is that of
//! small strains, for every law, with `λ` limited: two more volumetric constraints per particle lock nearly
//! incompressible materials (and so does one: [`patches`](crate::tlsph::patches)).
//!
//! `F` is that at the cell's centroid: the gradient at the particle and the Hessian times the centroid's
//! offset.
//!
//! The internal force is the exact negative gradient of `Σ Π_a`: momentum, angular momentum and energy are
//! kept.
//!
//! Weights of a pair: `w p`. Constants of a particle: the symmetric matrix `M` that takes
//! `Σ_b (U_b − U_a) w p` to gradient and Hessian, the symmetric `D̃`, `V`, and the centroid's offset; upper
//! triangles row by row.

use crate::bodies::Body;
use crate::lanes::{LANES, Lanes, Tensor, matrix, plus_identity};
use crate::materials::{ConstitutiveLaw, Elasticity};
use crate::tlsph::stencil::PairOperator;
use nalgebra::{DMatrix, DVector};
use sph::Matrix;
use sph::kernel::CubicSpline;

/// Eigenvalues of the scaled Hessian moments under this are not resolved. Two in ten separates rows at a
/// surface (none resolved across it) from all others on a lattice, and keeps the stable step of scattered
/// particles from collapsing.
const RESOLVED: f64 = 0.2;

/// Where the entry `(i, j)` of a symmetric matrix of `size` rows stands in its upper triangle, row by row.
#[inline(always)]
const fn triangle(i: usize, j: usize, size: usize) -> usize {
    let (r, c) = if i < j { (i, j) } else { (j, i) };
    r * size - r * (r + 1) / 2 + c
}

/// The operator of one body; particle indices are internal ones.
pub(crate) struct Quadratic<'a, const D: usize> {
    body: &'a Body<D>,
    kernel: CubicSpline<D>,
    elasticity: Elasticity,
    first: usize,
    members: &'a [Option<usize>],
}

impl<'a, const D: usize> Quadratic<'a, D> {
    pub fn new(
        body: &'a Body<D>,
        elasticity: Elasticity,
        smoothing_ratio: f64,
        first: usize,
        members: &'a [Option<usize>],
    ) -> Self {
        let kernel = CubicSpline::new(smoothing_ratio * body.spacing());
        Self { body, kernel, elasticity, first, members }
    }

    const HESSIAN: usize = D * (D + 1) / 2;

    fn member(&self, internal: usize) -> usize {
        self.members[internal - self.first].expect("only members of the body are neighbours")
    }

    /// The basis `p` at neighbour `b` of `a`, lengths in spacings, and the weight `w`.
    fn basis(&self, a: usize, b: usize) -> (DVector<f64>, f64) {
        let spacing = self.body.spacing();
        let offset = self.body.positions[self.member(b)] - self.body.positions[self.member(a)];
        let r = offset.norm();
        // The scale of the weights is free; this one makes them numbers near one.
        let weight = -self.kernel.slope(r) / r * spacing.powi(D as i32 + 2);
        let xi = offset / spacing;
        let mut p = DVector::zeros(D + Self::HESSIAN);
        for i in 0..D {
            p[i] = xi[i];
            for j in i..D {
                p[D + triangle(i, j, D)] = xi[i] * xi[j] * if i == j { 0.5 } else { 1.0 };
            }
        }
        (p, weight)
    }

    /// The matrix `M` in units of the spacing, and the dropped Hessian directions (columns).
    fn fit(&self, a: usize, neighbours: &[u32]) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let (all, second) = (D + Self::HESSIAN, Self::HESSIAN);
        let mut moments = DMatrix::zeros(all, all);
        for &b in neighbours {
            let (p, w) = self.basis(a, b as usize);
            moments += &p * p.transpose() * w;
        }
        let a11 = moments.view((0, 0), (D, D)).into_owned();
        if a11.symmetric_eigenvalues().min() <= 1e-6 * a11.trace() {
            return None;
        }
        let inverse = a11.try_inverse()?;
        let a12 = moments.view((0, D), (D, second)).into_owned();
        let a22 = moments.view((D, D), (second, second)).into_owned();
        let schur = &a22 - a12.transpose() * &inverse * &a12;
        let scale = DVector::from_fn(second, |i, _| {
            let d: f64 = a22[(i, i)];
            if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 }
        });
        let scaled = DMatrix::from_fn(second, second, |i, j| schur[(i, j)] * scale[i] * scale[j]);
        let eigen = ((&scaled + scaled.transpose()) * 0.5).symmetric_eigen();
        let direction = |n: usize| eigen.eigenvectors.column(n).component_mul(&scale);
        let mut pseudo_inverse = DMatrix::zeros(second, second);
        let mut dropped = Vec::new();
        for n in 0..second {
            let (d, value) = (direction(n), eigen.eigenvalues[n]);
            if value > RESOLVED {
                pseudo_inverse += &d * d.transpose() / value;
            } else {
                dropped.push(if d.norm() > 0.0 { d } else { eigen.eigenvectors.column(n).into_owned() });
            }
        }
        let cross = -(&inverse * &a12 * &pseudo_inverse);
        let mut m = DMatrix::zeros(all, all);
        m.view_mut((0, 0), (D, D)).copy_from(&(&inverse - &cross * a12.transpose() * &inverse));
        m.view_mut((0, D), (D, second)).copy_from(&cross);
        m.view_mut((D, 0), (second, D)).copy_from(&cross.transpose());
        m.view_mut((D, D), (second, second)).copy_from(&pseudo_inverse);
        let dropped =
            if dropped.is_empty() { DMatrix::zeros(second, 0) } else { DMatrix::from_columns(&dropped) };
        Some((m, dropped))
    }

    /// Strain-gradient stiffness `D̃` (J/m): rows and columns `(k, v)`, direction of the derivative and Voigt
    /// component.
    fn strain_gradient_stiffness(&self, second_moment: &Matrix<D>, dropped: &DMatrix<f64>) -> DMatrix<f64> {
        let h = Self::HESSIAN;
        let mut stiffness = DMatrix::zeros(D * h, D * h);
        let lambda = self.elasticity.strain_gradient_lambda;
        for (k, m) in (0..D).flat_map(|k| (0..D).map(move |m| (k, m))) {
            let moment = second_moment[(k, m)];
            for i in 0..D {
                for j in i..D {
                    let (v, w) = (k * h + triangle(i, j, D), m * h + triangle(i, j, D));
                    if i != j {
                        stiffness[(v, w)] = moment * self.elasticity.mu;
                        continue;
                    }
                    stiffness[(v, w)] += 2.0 * moment * self.elasticity.mu;
                    for l in 0..D {
                        stiffness[(v, m * h + triangle(l, l, D))] += moment * lambda;
                    }
                }
            }
        }
        // B N: strain gradients at F = I of each dropped direction in each component of the displacement.
        let count = dropped.ncols();
        let mut modes = DMatrix::zeros(D * h, D * count);
        for i in 0..D {
            for n in 0..count {
                for k in 0..D {
                    for j in 0..D {
                        modes[(k * h + triangle(i, j, D), i * count + n)] += dropped[(triangle(k, j, D), n)];
                    }
                }
            }
        }
        let forces = &stiffness * &modes;
        let reduced = modes.transpose() * &forces;
        let inverse = pseudo_inverse(&reduced);
        let condensed = &stiffness - &forces * inverse * forces.transpose();
        (&condensed + condensed.transpose()) * 0.5
    }
}

/// Moore–Penrose inverse of a symmetric matrix that is not negative; directions without energy are left out.
fn pseudo_inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let size = matrix.nrows();
    if size == 0 {
        return DMatrix::zeros(0, 0);
    }
    let eigen = matrix.clone().symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let mut inverse = DMatrix::zeros(size, size);
    for n in 0..size {
        if eigen.eigenvalues[n] > 1e-9 * largest {
            let d = eigen.eigenvectors.column(n);
            inverse += d * d.transpose() / eigen.eigenvalues[n];
        }
    }
    inverse
}

impl<const D: usize> PairOperator for Quadratic<'_, D> {
    const WEIGHTS: usize = D + D * (D + 1) / 2;

    fn weights(&self, a: usize, b: usize, out: &mut [f64]) {
        let (p, w) = self.basis(a, b);
        let spacing = self.body.spacing();
        for k in 0..Self::WEIGHTS {
            out[k] = w * p[k] * if k < D { spacing } else { spacing * spacing };
        }
    }

    fn constants(&self) -> usize {
        let (m, s) = (Self::WEIGHTS, D * Self::HESSIAN);
        m * (m + 1) / 2 + s * (s + 1) / 2 + 1 + D
    }

    fn write_constants(&self, a: usize, neighbours: &[u32], out: &mut [f64]) -> bool {
        let Some(member) = self.members[a - self.first] else { return true };
        let volume = self.body.volumes[member];
        if volume == 0.0 {
            return true;
        }
        let Some((m, dropped)) = self.fit(a, neighbours) else { return false };
        let spacing = self.body.spacing();
        let unit = |k: usize| if k < D { spacing } else { spacing * spacing };
        let mut next = 0;
        for i in 0..Self::WEIGHTS {
            for j in i..Self::WEIGHTS {
                out[next] = m[(i, j)] / (unit(i) * unit(j));
                next += 1;
            }
        }
        let (offset, second_moment) = self.body.shape(member);
        let stiffness = self.strain_gradient_stiffness(&second_moment, &dropped);
        for i in 0..stiffness.nrows() {
            for j in i..stiffness.nrows() {
                out[next] = stiffness[(i, j)];
                next += 1;
            }
        }
        out[next] = volume;
        out[next + 1..].copy_from_slice(offset.as_slice());
        true
    }

    fn features(&self, a: usize, b: usize, out: &mut Vec<f64>) {
        let Some(a) = self.members[a - self.first] else { return };
        if a == self.member(b) && !self.body.second_moments.is_empty() {
            let (offset, second_moment) = self.body.shape(a);
            out.extend(offset.iter().map(|o| o / self.body.spacing()));
            out.extend(second_moment.iter().map(|m| m / self.body.spacing().powi(2)));
        }
        let b = self.member(b);
        out.push(self.body.volumes[b] / self.body.cell.iter().product::<f64>());
        out.extend(((self.body.positions[b] - self.body.positions[a]) / self.body.spacing()).iter());
    }
}

/// Gradient and Hessian at a slice's particles, `G = m M`, from the moments `m`.
#[inline(always)]
fn derivatives<const D: usize, const K: usize>(
    moments: &[[Lanes; K]; D],
    constants: &[f64],
) -> [[Lanes; K]; D] {
    let mut g = [[Lanes::ZERO; K]; D];
    for l in 0..K {
        for k in 0..K {
            let m = Lanes::load(constants, triangle(l, k, K) * LANES);
            for i in 0..D {
                g[i][k] += moments[i][l] * m;
            }
        }
    }
    g
}

/// Where volume and centroid offset begin among the constants.
const fn cell_constants(dimensions: usize, basis: usize) -> usize {
    let s = dimensions * (basis - dimensions);
    (basis * (basis + 1) / 2 + s * (s + 1) / 2) * LANES
}

/// The centroid's offset from the particle (m).
#[inline(always)]
fn centroid_offset<const D: usize, const K: usize>(constants: &[f64]) -> [Lanes; D] {
    std::array::from_fn(|k| Lanes::load(constants, cell_constants(D, K) + (1 + k) * LANES))
}

/// Moves the gradient from the particle to the centroid of its cell.
#[inline(always)]
fn to_centroid<const D: usize, const K: usize>(g: &mut [[Lanes; K]; D], offset: &[Lanes; D]) {
    for row in g {
        for j in 0..D {
            for k in 0..D {
                row[j] += row[D + triangle(k, j, D)] * offset[k];
            }
        }
    }
}

/// The transpose of [`to_centroid`], for conjugates.
#[inline(always)]
fn from_centroid<const D: usize, const K: usize>(c: &mut [[Lanes; K]; D], offset: &[Lanes; D]) {
    for row in c {
        for j in 0..D {
            for k in 0..D {
                row[D + triangle(k, j, D)] += row[j] * offset[k];
            }
        }
    }
}

/// The displacement gradient alone.
#[inline(always)]
fn first<const D: usize, const K: usize>(g: &[[Lanes; K]; D]) -> Tensor<D> {
    matrix(|i, j| g[i][j])
}

/// Voigt components of `∂E/∂X_k`, shears doubled, the first `K − D` of each row used.
#[inline(always)]
fn strain_gradients<const D: usize, const K: usize>(f: &Tensor<D>, g: &[[Lanes; K]; D]) -> [[Lanes; K]; D] {
    let mut s = [[Lanes::ZERO; K]; D];
    for k in 0..D {
        for i in 0..D {
            for j in 0..D {
                // F_mi ∂F_mj/∂X_k lands in (i, i) once, in (i, j) from both orders: the doubled shear.
                let mut sum = f[0][i] * g[0][D + triangle(k, j, D)];
                for m in 1..D {
                    sum += f[m][i] * g[m][D + triangle(k, j, D)];
                }
                s[k][triangle(i, j, D)] += sum;
            }
        }
    }
    s
}

/// `T = D̃ s`.
#[inline(always)]
fn strain_gradient_stress<const D: usize, const K: usize>(
    s: &[[Lanes; K]; D],
    constants: &[f64],
) -> [[Lanes; K]; D] {
    let h = K - D;
    let stiffness = &constants[K * (K + 1) / 2 * LANES..];
    let mut t = [[Lanes::ZERO; K]; D];
    for k in 0..D {
        for v in 0..h {
            for l in 0..D {
                for w in 0..h {
                    let d = Lanes::load(stiffness, triangle(k * h + v, l * h + w, D * h) * LANES);
                    t[k][v] += d * s[l][w];
                }
            }
        }
    }
    t
}

/// Conjugates `V c M` of the moments, and `J`; `volumetric` is the stress (Pa) that patches add.
#[inline(always)]
pub(crate) fn respond<const D: usize, const K: usize, L: ConstitutiveLaw>(
    elasticity: &Elasticity,
    moments: &[[Lanes; K]; D],
    constants: &[f64],
    volumetric: Lanes,
) -> ([[Lanes; K]; D], Lanes) {
    let mut g = derivatives::<D, K>(moments, constants);
    let offset = centroid_offset::<D, K>(constants);
    to_centroid(&mut g, &offset);
    let l = first::<D, K>(&g);
    let f = plus_identity(&l);
    let response = L::respond::<D>(elasticity, &l, volumetric);
    let t = strain_gradient_stress::<D, K>(&strain_gradients::<D, K>(&f, &g), constants);
    let mut c = [[Lanes::ZERO; K]; D];
    for i in 0..D {
        for j in 0..D {
            // P + Σ_k (∂F/∂X_k) T_k
            let mut sum = response.first_piola[i][j];
            for k in 0..D {
                for m in 0..D {
                    sum += g[i][D + triangle(k, m, D)] * t[k][triangle(m, j, D)];
                }
            }
            c[i][j] = sum;
            // F T_k, both orders of a mixed derivative together
            for k in 0..D {
                let mut sum = f[i][0] * t[k][triangle(0, j, D)];
                for m in 1..D {
                    sum += f[i][m] * t[k][triangle(m, j, D)];
                }
                c[i][D + triangle(k, j, D)] += sum;
            }
        }
    }
    from_centroid(&mut c, &offset);
    let volume = Lanes::load(constants, cell_constants(D, K));
    let q = derivatives::<D, K>(&c, constants);
    (matrix(|i, k| q[i][k] * volume), response.jacobian)
}

/// The displacement gradient at the centroids.
#[inline(always)]
pub(crate) fn displacement_gradient<const D: usize, const K: usize>(
    moments: &[[Lanes; K]; D],
    constants: &[f64],
) -> Tensor<D> {
    let mut g = derivatives::<D, K>(moments, constants);
    to_centroid(&mut g, &centroid_offset::<D, K>(constants));
    first::<D, K>(&g)
}

/// The displacement gradient, and the strain-gradient energy per volume (J/m³).
#[inline(always)]
pub(crate) fn observe<const D: usize, const K: usize>(
    moments: &[[Lanes; K]; D],
    constants: &[f64],
) -> (Tensor<D>, Lanes) {
    let mut g = derivatives::<D, K>(moments, constants);
    to_centroid(&mut g, &centroid_offset::<D, K>(constants));
    let l = first::<D, K>(&g);
    let s = strain_gradients::<D, K>(&plus_identity(&l), &g);
    let t = strain_gradient_stress::<D, K>(&s, constants);
    let mut energy = Lanes::ZERO;
    for k in 0..D {
        for v in 0..K - D {
            energy += s[k][v] * t[k][v] * 0.5;
        }
    }
    (l, energy)
}
