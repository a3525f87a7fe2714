//! One facet of a boundary: a segment in the plane, a triangle in space.

use super::semidefinite::{dot, minus};

/// A point of a facet: `Σ bᵢ vᵢ` with `Σ bᵢ = 1`.
pub(super) type Barycentric<const D: usize> = [f64; D];

/// The point of the facet that is nearest to `x`.
pub(super) fn nearest<const D: usize>(vertices: &[[f64; D]; D], x: &[f64; D]) -> Barycentric<D> {
    let mut b = [0.0; D];
    if D == 2 {
        let t = along(&vertices[0], &vertices[1], x);
        (b[0], b[1]) = (1.0 - t, t);
        return b;
    }
    // Inside, if all barycentric coordinates of the projection are positive; else on one of the edges.
    let (e, f, r) =
        (minus(&vertices[1], &vertices[0]), minus(&vertices[2], &vertices[0]), minus(x, &vertices[0]));
    let (ee, ef, ff, er, fr) = (dot(&e, &e), dot(&e, &f), dot(&f, &f), dot(&e, &r), dot(&f, &r));
    let determinant = ee * ff - ef * ef;
    let (s, t) = ((ff * er - ef * fr) / determinant, (ee * fr - ef * er) / determinant);
    if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
        (b[0], b[1], b[2]) = (1.0 - s - t, s, t);
        return b;
    }
    let mut best = f64::INFINITY;
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let t = along(&vertices[i], &vertices[j], x);
        let mut edge = [0.0; D];
        (edge[i], edge[j]) = (1.0 - t, t);
        let off = minus(x, &point(vertices, &edge));
        if dot(&off, &off) < best {
            (best, b) = (dot(&off, &off), edge);
        }
    }
    b
}

/// Whether `x` is certainly off the end of a segment: the line from the nearest point to it is not
/// perpendicular to the segment by an angle of more than 1e-5. Costs no division. Of a triangle it is never
/// certain.
pub(super) fn is_beside<const D: usize>(vertices: &[[f64; D]; D], x: &[f64; D]) -> bool {
    if D != 2 {
        return false;
    }
    let e = minus(&vertices[1], &vertices[0]);
    let (before, beyond) = (minus(x, &vertices[0]), minus(x, &vertices[1]));
    let along = if dot(&e, &before) < 0.0 {
        dot(&before, &e).powi(2) - 1e-10 * dot(&before, &before) * dot(&e, &e)
    } else {
        dot(&beyond, &e).max(0.0).powi(2) - 1e-10 * dot(&beyond, &beyond) * dot(&e, &e)
    };
    along > 0.0
}

/// Whether a line in the plane certainly passes a segment by, with both ends on one side of it, the nearer by
/// 1e-8 of what they are apart. Costs no division. Of a triangle it is never certain.
#[inline]
pub(super) fn is_missed<const D: usize>(
    vertices: &[[f64; D]; D],
    origin: &[f64; D],
    direction: &[f64; D],
) -> bool {
    if D != 2 {
        return false;
    }
    let side = |v: &[f64; D]| (v[0] - origin[0]) * direction[1] - (v[1] - origin[1]) * direction[0];
    let (a, b) = (side(&vertices[0]), side(&vertices[1]));
    a * b > 0.0 && a.abs().min(b.abs()) > 1e-8 * (a - b).abs()
}

/// Where the line `origin + t direction` meets the facet's plane inside the facet: `t` and the point. None if
/// it is parallel or outside.
pub(super) fn meet<const D: usize>(
    vertices: &[[f64; D]; D],
    origin: &[f64; D],
    direction: &[f64; D],
) -> Option<(f64, Barycentric<D>)> {
    /// How far outside a facet still counts as inside, so that no line slips through between two facets.
    const CRACK: f64 = 1e-9;
    let normal = normal(vertices);
    let slope = dot(&normal, direction);
    if slope == 0.0 {
        return None;
    }
    let t = dot(&normal, &minus(&vertices[0], origin)) / slope;
    let hit: [f64; D] = std::array::from_fn(|i| origin[i] + t * direction[i]);
    let mut b = [0.0; D];
    let e = minus(&vertices[1], &vertices[0]);
    let r = minus(&hit, &vertices[0]);
    if D == 2 {
        b[1] = dot(&e, &r) / dot(&e, &e);
        b[0] = 1.0 - b[1];
    } else {
        let f = minus(&vertices[2], &vertices[0]);
        let (ee, ef, ff, er, fr) = (dot(&e, &e), dot(&e, &f), dot(&f, &f), dot(&e, &r), dot(&f, &r));
        let determinant = ee * ff - ef * ef;
        b[1] = (ff * er - ef * fr) / determinant;
        b[2] = (ee * fr - ef * er) / determinant;
        b[0] = 1.0 - b[1] - b[2];
    }
    b.iter().all(|&b| b >= -CRACK).then_some((t, b))
}

/// The point `Σ bᵢ vᵢ`.
pub(super) fn point<const D: usize>(vertices: &[[f64; D]; D], b: &Barycentric<D>) -> [f64; D] {
    // As v₀ and differences from it, so that a point of a facet far from the origin keeps its digits.
    let mut x = vertices[0];
    for k in 1..D {
        for i in 0..D {
            x[i] += b[k] * (vertices[k][i] - vertices[0][i]);
        }
    }
    x
}

/// Normal, of the length or twice the area; outwards for facets that go round anticlockwise as seen from
/// outside (the plane: body to the left).
pub(super) fn normal<const D: usize>(vertices: &[[f64; D]; D]) -> [f64; D] {
    let e = minus(&vertices[1], &vertices[0]);
    let mut normal = [0.0; D];
    if D == 2 {
        (normal[0], normal[1]) = (e[1], -e[0]);
    } else {
        let f = minus(&vertices[2], &vertices[0]);
        for i in 0..D {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            normal[i] = e[j] * f[k] - e[k] * f[j];
        }
    }
    normal
}

/// Fraction of the way from `a` to `b` at which `x` is nearest.
fn along<const D: usize>(a: &[f64; D], b: &[f64; D], x: &[f64; D]) -> f64 {
    let e = minus(b, a);
    (dot(&e, &minus(x, a)) / dot(&e, &e)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEGMENT: [[f64; 2]; 2] = [[1.0, 1.0], [3.0, 1.0]];
    const TRIANGLE: [[f64; 3]; 3] = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 2.0, 1.0]];

    #[test]
    fn nearest_points_by_hand() {
        assert_eq!(nearest(&SEGMENT, &[1.5, 7.0]), [0.75, 0.25]);
        assert_eq!(nearest(&SEGMENT, &[5.0, 0.0]), [0.0, 1.0]);
        assert_eq!(nearest(&TRIANGLE, &[0.5, 0.5, 3.0]), [0.5, 0.25, 0.25]);
        assert_eq!(nearest(&TRIANGLE, &[2.0, 2.0, 0.0]), [0.0, 0.5, 0.5]);
        assert_eq!(nearest(&TRIANGLE, &[-1.0, -1.0, 0.0]), [1.0, 0.0, 0.0]);
        assert_eq!(nearest(&TRIANGLE, &[1.0, -1.0, 0.0]), [0.5, 0.5, 0.0]);
    }

    #[test]
    fn what_is_off_the_end_of_a_segment_is_beside_it() {
        for (x, beside) in [
            ([0.5, 4.0], true),
            ([3.5, 1.0], true),
            ([1.0, 4.0], false),
            ([2.0, 1.0], false),
            ([3.0, -1.0], false),
        ] {
            assert_eq!(is_beside(&SEGMENT, &x), beside, "{x:?}");
        }
        assert!(!is_beside(&TRIANGLE, &[-1.0, -1.0, 1.0]));
    }

    #[test]
    fn a_line_with_both_ends_on_one_side_misses() {
        for (origin, direction, missed) in [
            ([0.0, 0.0], [0.0, 1.0], true),
            ([4.0, 0.0], [0.0, 1.0], true),
            ([2.0, 0.0], [0.0, 1.0], false),
            ([1.0, 0.0], [0.0, 1.0], false),
            // By less than what keeps lines from slipping through.
            ([1.0 - 1e-9, 0.0], [0.0, 1.0], false),
            ([0.0, 1.0], [1.0, 0.0], false),
            ([0.0, 2.0], [1.0, 0.0], true),
        ] {
            assert_eq!(is_missed(&SEGMENT, &origin, &direction), missed, "{origin:?}");
        }
        assert!(!is_missed(&TRIANGLE, &[9.0; 3], &[0.0, 0.0, 1.0]));
    }

    #[test]
    fn meetings_by_hand() {
        assert_eq!(meet(&SEGMENT, &[1.5, 0.0], &[0.0, 1.0]), Some((1.0, [0.75, 0.25])));
        assert_eq!(meet(&SEGMENT, &[0.5, 0.0], &[0.0, 1.0]), None);
        assert_eq!(meet(&SEGMENT, &[0.5, 0.0], &[1.0, 0.0]), None);
        assert_eq!(meet(&TRIANGLE, &[0.5, 0.5, 3.0], &[0.0, 0.0, 2.0]), Some((-1.0, [0.5, 0.25, 0.25])));
        assert_eq!(meet(&TRIANGLE, &[1.5, 1.5, 3.0], &[0.0, 0.0, 2.0]), None);
    }

    #[test]
    fn normals_point_to_the_right_and_along_the_thumb() {
        assert_eq!(normal(&SEGMENT), [0.0, -2.0]);
        assert_eq!(normal(&TRIANGLE), [0.0, 0.0, 4.0]);
    }
}
