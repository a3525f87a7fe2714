//! Small symmetric positive semidefinite systems.

/// Pivots below this fraction of the largest diagonal entry count as zero: a hundred times the rounding error
/// of a sum of squares.
const ZERO_PIVOT: f64 = 1e-14;

/// A solution of `M g = b` for symmetric positive semidefinite `M` (`D×D`) and `b` in its range; for other
/// `b` of the part that pivots reach, and the caller sees it in the residual. Elimination with pivots from
/// the diagonal.
#[inline]
pub(super) fn solve<const D: usize>(mut m: [[f64; D]; D], mut b: [f64; D]) -> [f64; D] {
    let zero = ZERO_PIVOT * (0..D).map(|i| m[i][i]).fold(0.0, f64::max);
    let mut order: [usize; D] = std::array::from_fn(|i| i);
    let mut rank = D;
    for k in 0..D {
        let pivot = (k..D).fold(k, |best, i| if m[i][i] > m[best][best] { i } else { best });
        m.swap(k, pivot);
        m.iter_mut().for_each(|row| row.swap(k, pivot));
        b.swap(k, pivot);
        order.swap(k, pivot);
        if m[k][k] <= zero {
            rank = k;
            break;
        }
        let inverse = 1.0 / m[k][k];
        for i in k + 1..D {
            let factor = m[i][k] * inverse;
            for j in k + 1..D {
                m[i][j] -= factor * m[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    let mut g = [0.0; D];
    for k in (0..rank).rev() {
        let mut sum = b[k];
        for j in k + 1..rank {
            sum -= m[k][j] * g[order[j]];
        }
        g[order[k]] = sum / m[k][k];
    }
    g
}

/// `a · b`.
pub(super) fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    let mut sum = 0.0;
    for i in 0..D {
        sum += a[i] * b[i];
    }
    sum
}

/// `a − b`.
pub(super) fn minus<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|i| a[i] - b[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `M g`.
    fn product<const D: usize>(m: &[[f64; D]; D], g: &[f64; D]) -> [f64; D] {
        std::array::from_fn(|i| dot(&m[i], g))
    }

    #[test]
    fn solves_by_hand() {
        // Pivot 4 first: 2 − 2·2/4 = 1.
        assert_eq!(solve([[2.0, 2.0], [2.0, 4.0]], [8.0, 14.0]), [1.0, 3.0]);
        // Rank one: any g with g₀ + 2 g₁ = 5.
        let m = [[1.0, 2.0], [2.0, 4.0]];
        assert_eq!(product(&m, &solve(m, [5.0, 10.0])), [5.0, 10.0]);
        assert_eq!(solve([[0.0; 3]; 3], [1.0, 2.0, 3.0]), [0.0; 3]);
        let m = [[4.0, 1.0, 0.5], [1.0, 3.0, -1.0], [0.5, -1.0, 5.0]];
        let b = product(&m, &[1.0, -2.0, 3.0]);
        for (g, expected) in solve(m, b).iter().zip([1.0, -2.0, 3.0]) {
            assert!((g - expected).abs() < 1e-14, "rounding of a 3×3 elimination: {g}");
        }
    }
}
