//! Small tensor algebra that nalgebra offers for fixed sizes only, for the generic dimension.

use crate::{Matrix, Vector};
use nalgebra::{Matrix2, Matrix3};

fn as_2<const D: usize>(m: &Matrix<D>) -> Matrix2<f64> {
    Matrix2::from_fn(|i, j| m[(i, j)])
}

fn as_3<const D: usize>(m: &Matrix<D>) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| m[(i, j)])
}

/// Determinant.
#[inline]
pub fn determinant<const D: usize>(m: &Matrix<D>) -> f64 {
    match D {
        2 => as_2(m).determinant(),
        3 => as_3(m).determinant(),
        _ => unreachable!("two or three dimensions"),
    }
}

/// Inverse, or nothing where the determinant is zero.
#[inline]
pub fn inverse<const D: usize>(m: &Matrix<D>) -> Option<Matrix<D>> {
    match D {
        2 => as_2(m).try_inverse().map(|n| Matrix::from_fn(|i, j| n[(i, j)])),
        3 => as_3(m).try_inverse().map(|n| Matrix::from_fn(|i, j| n[(i, j)])),
        _ => unreachable!("two or three dimensions"),
    }
}

/// The smallest eigenvalue of a symmetric matrix.
#[inline]
pub fn smallest_eigenvalue<const D: usize>(m: &Matrix<D>) -> f64 {
    match D {
        2 => {
            let (mean, half) = (0.5 * (m[(0, 0)] + m[(1, 1)]), 0.5 * (m[(0, 0)] - m[(1, 1)]));
            mean - half.hypot(0.5 * (m[(0, 1)] + m[(1, 0)]))
        }
        3 => as_3(m).symmetric_eigenvalues().min(),
        _ => unreachable!("two or three dimensions"),
    }
}

/// The dyadic product `a ⊗ b`, entry `(i, j)` being `a_i b_j`.
#[inline]
pub fn outer<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> Matrix<D> {
    a * b.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_dimensional_results_by_hand() {
        let m = Matrix::<3>::from_diagonal(&Vector::from([2.0, 4.0, 0.5]));
        assert_eq!(determinant(&m), 4.0);
        assert_eq!(inverse(&m).unwrap()[(2, 2)], 2.0);
        assert!((smallest_eigenvalue(&m) - 0.5).abs() < 1e-14);
        assert!(inverse(&Matrix::<3>::zeros()).is_none());
    }

    #[test]
    fn smallest_eigenvalue_of_a_symmetric_pair() {
        let m = Matrix::<2>::new(2.0, 1.0, 1.0, 2.0);
        assert!((smallest_eigenvalue(&m) - 1.0).abs() < 1e-15);
    }
}
