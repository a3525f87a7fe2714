//! Points of the material between and beyond particles: true faces, edges and corners, to read or to load.

use sph::{Matrix, Vector, tensor};

/// A point of the material as a weighted sum over particles, fixed in the reference configuration. The
/// weights reproduce linear fields exactly (moving least squares), and quadratic ones where the particles
/// about the point resolve them, so a point on a face or corner, half a spacing from the next particle, is
/// read to that order. Used as a load they are the exact transpose: the force and its moment about any point
/// are those of the force at the point.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialPoint<const D: usize> {
    /// Reference position (m).
    pub reference: Vector<D>,
    /// Particles and their weights, which sum to one.
    pub weights: Vec<(usize, f64)>,
}

/// Particles within this many spacings of the nearest one to the point make the sum.
const REACH: f64 = 2.6;

/// Smallest accepted ratio of the moment matrix's eigenvalues (scaled to a unit diagonal) for a polynomial
/// basis.
const CONDITION: f64 = 1e-6;

impl<const D: usize> MaterialPoint<D> {
    /// The point at the reference coordinates `at` (m) among particles at `positions` (m) spaced by `spacing`
    /// (m). `None` without particles.
    pub fn new(at: Vector<D>, positions: &[Vector<D>], spacing: f64) -> Option<Self> {
        let nearest = positions.iter().map(|p| (p - at).norm()).min_by(f64::total_cmp)?;
        let radius = nearest + REACH * spacing;
        let near: Vec<usize> =
            (0..positions.len()).filter(|&i| (positions[i] - at).norm() < radius).collect();
        let offsets: Vec<Vector<D>> = near.iter().map(|&i| (positions[i] - at) / spacing).collect();
        let kernel: Vec<f64> = offsets.iter().map(|o| (1.0 - o.norm() * spacing / radius).powi(2)).collect();
        let shape = [2, 1, 0].iter().find_map(|&degree| shape(&offsets, &kernel, degree))?;
        let weights = near.into_iter().zip(shape).filter(|(_, w)| *w != 0.0).collect();
        Some(Self { reference: at, weights })
    }

    /// The box face between two opposite corners (m), which share one coordinate: the mean over `samples`
    /// points along each of its axes. As a load it is a uniform traction.
    pub fn over_face(
        low: Vector<D>,
        high: Vector<D>,
        samples: usize,
        positions: &[Vector<D>],
        spacing: f64,
    ) -> Option<Self> {
        let axes: Vec<usize> = (0..D).filter(|&i| high[i] > low[i]).collect();
        let count = samples.pow(axes.len() as u32);
        let mut weights = std::collections::BTreeMap::new();
        for mut n in 0..count {
            let mut at = low;
            for &axis in &axes {
                let fraction = ((n % samples) as f64 + 0.5) / samples as f64;
                at[axis] += fraction * (high[axis] - low[axis]);
                n /= samples;
            }
            for (i, w) in Self::new(at, positions, spacing)?.weights {
                *weights.entry(i).or_insert(0.0) += w / count as f64;
            }
        }
        Some(Self { reference: (low + high) * 0.5, weights: weights.into_iter().collect() })
    }

    /// The value at the point of a field given at the particles.
    pub fn value(&self, field: &[Vector<D>]) -> Vector<D> {
        self.weights.iter().fold(Vector::zeros(), |sum, &(i, w)| sum + field[i] * w)
    }

    /// The value at the point of a tensor given at the particles.
    pub fn tensor(&self, field: &[Matrix<D>]) -> Matrix<D> {
        self.weights.iter().fold(Matrix::<D>::zeros(), |sum, &(i, w)| sum + field[i] * w)
    }

    /// The scalar value at the point.
    pub fn scalar(&self, field: &[f64]) -> f64 {
        self.weights.iter().map(|&(i, w)| field[i] * w).sum()
    }
}

/// Moving-least-squares weights `p(0)ᵀ M⁻¹ p(o_i) k_i` of the polynomial degree given, if the points resolve
/// it.
fn shape<const D: usize>(offsets: &[Vector<D>], kernel: &[f64], degree: usize) -> Option<Vec<f64>> {
    let basis: Vec<nalgebra::DVector<f64>> = offsets.iter().map(|o| monomials(o, degree)).collect();
    let size = basis.first()?.len();
    let mut moment = nalgebra::DMatrix::zeros(size, size);
    for (p, &k) in basis.iter().zip(kernel) {
        moment += p * p.transpose() * k;
    }
    let scale = moment.diagonal().map(|d: f64| 1.0 / d.max(f64::MIN_POSITIVE).sqrt());
    let scaled = nalgebra::DMatrix::from_fn(size, size, |i, j| moment[(i, j)] * scale[i] * scale[j]);
    if scaled.symmetric_eigenvalues().min() < CONDITION {
        return None;
    }
    let mut unit = nalgebra::DVector::zeros(size);
    unit[0] = scale[0];
    let solved = scaled.cholesky()?.solve(&unit).component_mul(&scale);
    Some(basis.iter().zip(kernel).map(|(p, k)| p.dot(&solved) * k).collect())
}

fn monomials<const D: usize>(o: &Vector<D>, degree: usize) -> nalgebra::DVector<f64> {
    let mut terms = vec![1.0];
    if degree >= 1 {
        terms.extend(o.iter());
    }
    if degree >= 2 {
        let square = tensor::outer(o, o);
        for i in 0..D {
            for j in i..D {
                terms.push(square[(i, j)]);
            }
        }
    }
    nalgebra::DVector::from_vec(terms)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sph::lattice::Lattice;

    /// Round-off of sums of some twenty terms.
    #[test]
    fn a_corner_reads_quadratic_fields_exactly() {
        let beam = Lattice::<2>::fill_box(Vector::from([0.0, 0.0]), Vector::from([2.0, 0.4]), 0.1);
        let field = |p: &Vector<2>| {
            Vector::from([1.0 + 2.0 * p.x - p.y + p.x * p.y, p.x * p.x - 3.0 * p.y * p.y + 0.5])
        };
        let values: Vec<Vector<2>> = beam.positions.iter().map(field).collect();
        for at in [[2.0, 0.4], [2.0, 0.2], [0.03, 0.0], [1.0, 0.21]].map(Vector::from) {
            let point = MaterialPoint::new(at, &beam.positions, 0.1).unwrap();
            assert!((point.value(&values) - field(&at)).norm() < 1e-12, "{at}");
        }
    }

    #[test]
    fn few_particles_fall_back_to_lower_degree() {
        let row: Vec<Vector<2>> = (0..2).map(|i| Vector::from([f64::from(i), 0.0])).collect();
        let point = MaterialPoint::new(Vector::from([0.5, 0.0]), &row, 1.0).unwrap();
        assert!((point.weights.iter().map(|w| w.1).sum::<f64>() - 1.0).abs() < 1e-14);
        assert!(MaterialPoint::<2>::new(Vector::zeros(), &[], 1.0).is_none());
    }
}
