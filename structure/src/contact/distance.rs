//! The nearest point of a point, segment or triangle, as weights of its corners.

use sph::Vector;

/// Weights, which sum to one, of the corners (one, two or three) at their hull's nearest point to `x` (m).
pub(crate) fn nearest<const D: usize>(x: &Vector<D>, corners: &[Vector<D>]) -> [f64; 3] {
    match corners {
        [_] => [1.0, 0.0, 0.0],
        [a, b] => {
            let t = along(x, a, b);
            [1.0 - t, t, 0.0]
        }
        [a, b, c] => in_triangle(x, a, b, c),
        _ => unreachable!("parts of a surface have one to three corners"),
    }
}

/// Where from `a` (0) to `b` (1) the nearest point is.
fn along<const D: usize>(x: &Vector<D>, a: &Vector<D>, b: &Vector<D>) -> f64 {
    let ab = b - a;
    let square = ab.norm_squared();
    if square > 0.0 { ((x - a).dot(&ab) / square).clamp(0.0, 1.0) } else { 0.0 }
}

/// By the regions of a triangle's corners, edges and face (Ericson 2005, "Real-time collision detection",
/// §5.1.5).
fn in_triangle<const D: usize>(x: &Vector<D>, a: &Vector<D>, b: &Vector<D>, c: &Vector<D>) -> [f64; 3] {
    let (ab, ac, ax) = (b - a, c - a, x - a);
    let (d1, d2) = (ab.dot(&ax), ac.dot(&ax));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bx = x - b;
    let (d3, d4) = (ab.dot(&bx), ac.dot(&bx));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cx = x - c;
    let (d5, d6) = (ab.dot(&cx), ac.dot(&cx));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

/// Gradients (1/m) of the weights in the plane of a segment or triangle, one for each corner: they sum to
/// zero, and with the corners to the identity in that plane.
pub(crate) fn gradients<const D: usize>(corners: &[Vector<D>]) -> [Vector<D>; 3] {
    let zero = Vector::zeros();
    match corners {
        [a, b] => {
            let ab = b - a;
            let g = ab / ab.norm_squared().max(f64::MIN_POSITIVE);
            [-g, g, zero]
        }
        [a, b, c] => {
            let (u, v) = (b - a, c - a);
            let (uu, uv, vv) = (u.norm_squared(), u.dot(&v), v.norm_squared());
            let area = (uu * vv - uv * uv).max(f64::MIN_POSITIVE);
            let (gb, gc) = ((u * vv - v * uv) / area, (v * uu - u * uv) / area);
            [-(gb + gc), gb, gc]
        }
        _ => [zero; 3],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the least of a fine grid of weights; the grid's own error is of second order.
    #[test]
    fn nearest_points_of_a_triangle_are_the_nearest() {
        let [a, b, c] = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.3, 0.9, 0.4]].map(Vector::<3>::from);
        let at = |w: [f64; 3]| a * w[0] + b * w[1] + c * w[2];
        for n in 0..200 {
            let rough = |k: i32| f64::from((n * 37 + k * 101) % 97) / 97.0 * 3.0 - 1.0;
            let x = Vector::from([rough(1), rough(2), rough(3)]);
            let found = (x - at(nearest(&x, &[a, b, c]))).norm();
            let mut least = f64::INFINITY;
            for i in 0..=200 {
                for j in 0..=200 - i {
                    let (s, t) = (f64::from(i) / 200.0, f64::from(j) / 200.0);
                    least = least.min((x - at([1.0 - s - t, s, t])).norm());
                }
            }
            assert!(found <= least + 1e-12 && found > least - 1e-3, "{x}: {found} {least}");
        }
    }

    #[test]
    fn gradients_of_weights_reproduce_the_plane() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.3, 0.9, 0.4]].map(Vector::<3>::from);
        let g = gradients(&corners);
        let along = (corners[1] - corners[0]) * 0.3 + (corners[2] - corners[0]) * 0.2;
        let again = (0..3).fold(Vector::<3>::zeros(), |sum, j| sum + corners[j] * g[j].dot(&along));
        assert!((again - along).norm() < 1e-14 && (g[0] + g[1] + g[2]).norm() < 1e-14);
    }
}
