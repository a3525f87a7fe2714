//! Flat areas: segments in two dimensions, rectangles and discs in three.

use sph::{Matrix, Vector, tensor};
use words::rigid::Pose;

/// A flat area around a point, which looks to one of its sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Area<const D: usize> {
    /// Its middle (m).
    pub middle: Vector<D>,
    /// Unit normal, towards the side to which it looks.
    pub normal: Vector<D>,
    shape: Shape<D>,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape<const D: usize> {
    /// Edges and normal as columns, and the inverse of that: an offset in shares of the edges.
    Edges { edges: Matrix<D>, shares: Matrix<D> },
    /// Radius (m), and two perpendicular unit vectors in the plane.
    Disc { radius: f64, across: [Vector<D>; 2] },
}

impl<const D: usize> Area<D> {
    /// The segment or rectangle (any parallelogram) with `D − 1` edges (m), which looks where `towards` (of
    /// any length) does; nothing where the edges have no area.
    pub fn of_edges(middle: Vector<D>, edges: &[Vector<D>], towards: Option<&Vector<D>>) -> Option<Self> {
        let mut columns = Matrix::<D>::zeros();
        edges.iter().take(D - 1).enumerate().for_each(|(i, edge)| columns.set_column(i, edge));
        // Cofactors of a last column: perpendicular to all others, as long as they are an area.
        let cofactor = |i: usize| {
            let mut with = columns;
            with[(i, D - 1)] = 1.0;
            tensor::determinant(&with)
        };
        let upright = Vector::<D>::from_fn(|i, _| cofactor(i));
        let mut normal = upright.try_normalize(0.0)?;
        if towards.is_some_and(|towards| towards.dot(&normal) < 0.0) {
            normal = -normal;
        }
        columns.set_column(D - 1, &normal);
        let shares = tensor::inverse(&columns)?;
        Some(Self { middle, normal, shape: Shape::Edges { edges: columns, shares } })
    }

    /// The disc of a radius (m) with that normal, of any length, in three dimensions; nothing where the
    /// normal is zero.
    pub fn disc(middle: Vector<D>, radius: f64, normal: &Vector<D>) -> Option<Self> {
        let normal = normal.try_normalize(0.0)?;
        // The axis that is least along the normal.
        let axis = normal.iamin();
        let unit = Vector::<D>::from_fn(|i, _| if i == axis { 1.0 } else { 0.0 });
        let first = (unit - normal * normal[axis]).try_normalize(0.0)?;
        let turned = |i: usize| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            normal[j] * first[k] - normal[k] * first[j]
        };
        let second = Vector::<D>::from_fn(|i, _| if D == 3 { turned(i) } else { 0.0 });
        Some(Self { middle, normal, shape: Shape::Disc { radius, across: [first, second] } })
    }

    /// The area where a motion has brought it.
    pub fn moved(&self, pose: &Pose<D>) -> Self {
        let turned = |vector: &Vector<D>| pose.turned(vector);
        let shape = match &self.shape {
            Shape::Edges { edges, .. } => {
                let columns: [Vector<D>; D] = std::array::from_fn(|j| turned(&edges.column(j).into_owned()));
                let edges = Matrix::<D>::from_fn(|i, j| columns[j][i]);
                let shares = tensor::inverse(&edges).expect("edges that were turned have the same area");
                Shape::Edges { edges, shares }
            }
            Shape::Disc { radius, across } => {
                Shape::Disc { radius: *radius, across: [turned(&across[0]), turned(&across[1])] }
            }
        };
        Self { middle: pose.moved(&self.middle), normal: turned(&self.normal), shape }
    }

    /// The sign with which the way from one point (m) to another crosses it: 1 towards the side to which it
    /// looks, −1 against it, 0 where it does not. A point on the plane is beyond it, so that a way cut in two
    /// crosses as often as the whole; of two areas that share an edge a way crosses one.
    pub fn crossing(&self, from: &Vector<D>, to: &Vector<D>) -> f64 {
        let (from, to) = (from - self.middle, to - self.middle);
        let (before, after) = (from.dot(&self.normal), to.dot(&self.normal));
        if (before < 0.0) == (after < 0.0) {
            return 0.0;
        }
        let at = from + (to - from) * (before / (before - after));
        let is_inside = match &self.shape {
            Shape::Edges { shares, .. } => {
                let share = shares * at;
                (0..D - 1).all(|i| (-0.5..0.5).contains(&share[i]))
            }
            Shape::Disc { radius, .. } => at.norm_squared() < radius * radius,
        };
        if !is_inside {
            0.0
        } else if before < 0.0 {
            1.0
        } else {
            -1.0
        }
    }

    /// Points (m) spread evenly over it, about `step` (m) apart, and the share of the area that each stands
    /// for. A linear field has its mean.
    pub fn points(&self, step: f64) -> Vec<(Vector<D>, f64)> {
        // Finer than that, nothing is seen any more.
        let count = |length: f64| ((length / step).ceil() as usize).clamp(4, 64);
        match &self.shape {
            Shape::Edges { edges, .. } => {
                let mut points = vec![(self.middle, 1.0)];
                for i in 0..D - 1 {
                    let edge = edges.column(i).into_owned();
                    let n = count(edge.norm());
                    let along = |k: usize| (k as f64 + 0.5) / n as f64 - 0.5;
                    let spread = points.iter().flat_map(|(at, share)| {
                        (0..n).map(move |k| (at + edge * along(k), share / n as f64))
                    });
                    points = spread.collect();
                }
                points
            }
            Shape::Disc { radius, across: [first, second] } => {
                let rings = count(*radius);
                let ring = |k: usize| {
                    let (reach, number) = (radius * (k as f64 + 0.5) / rings as f64, 6 * k + 4);
                    let share = (2 * k + 1) as f64 / (rings * rings * number) as f64;
                    (0..number).map(move |m| {
                        let angle = std::f64::consts::TAU * (m as f64 + 0.5) / number as f64;
                        let (sin, cos) = angle.sin_cos();
                        (self.middle + (first * cos + second * sin) * reach, share)
                    })
                };
                (0..rings).flat_map(ring).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type V = Vector<2>;
    type W = Vector<3>;

    #[test]
    fn a_way_crosses_a_segment_where_it_meets_it() {
        let up = V::from([0.0, 1.0]);
        let area = Area::of_edges(V::from([1.0, 1.0]), &[V::from([2.0, 0.0])], Some(&up)).unwrap();
        let ways = [
            ([0.5, 0.5], [0.5, 1.5], 1.0),
            ([0.5, 1.5], [0.5, 0.5], -1.0),
            // Its end is outside of the segment, where it crosses is not; and the other way round.
            ([1.0, 0.9], [4.0, 3.0], 1.0),
            ([1.0, 0.0], [2.5, 1.1], 0.0),
            ([0.5, 0.5], [0.5, 0.9], 0.0),
            // On the plane is beyond it.
            ([0.5, 0.5], [0.5, 1.0], 1.0),
            ([0.5, 1.0], [0.5, 1.5], 0.0),
            // The segment's low end is its own, its high end is not.
            ([0.0, 0.5], [0.0, 1.5], 1.0),
            ([2.0, 0.5], [2.0, 1.5], 0.0),
        ];
        for (from, to, expected) in ways {
            assert_eq!(area.crossing(&V::from(from), &V::from(to)), expected, "{from:?} to {to:?}");
        }
        let down = Area::of_edges(V::from([1.0, 1.0]), &[V::from([2.0, 0.0])], Some(&-up)).unwrap();
        assert_eq!(down.crossing(&V::from([0.5, 0.5]), &V::from([0.5, 1.5])), -1.0);
    }

    #[test]
    fn rectangles_and_discs_have_their_own_borders() {
        let edges = [W::from([2.0, 0.0, 0.0]), W::from([0.0, 1.0, 1.0])];
        let area = Area::of_edges(W::zeros(), &edges, Some(&W::from([0.0, -1.0, 1.0]))).unwrap();
        let normal = W::from([0.0, -1.0, 1.0]).normalize();
        assert!((area.normal - normal).norm() < 1e-15);
        let disc = Area::disc(W::zeros(), 0.6, &normal).unwrap();
        for (at, rectangle, round) in [
            ([0.0, 0.0, 0.0], 1.0, 1.0),
            ([0.9, 0.4, 0.4], 1.0, 0.0),
            ([0.0, 0.6, 0.6], 0.0, 0.0),
            ([0.5, 0.2, 0.2], 1.0, 1.0),
        ] {
            let at = W::from(at);
            let way = (at - normal * 0.1, at + normal * 0.2);
            assert_eq!(area.crossing(&way.0, &way.1), rectangle, "{at}");
            assert_eq!(disc.crossing(&way.0, &way.1), round, "{at}");
        }
    }

    /// Round-off of some thousand points; of the square of the distance on a disc `r²/2` is the mean, and
    /// rings take it at their middle: `1/n²` smaller at most.
    #[test]
    fn points_have_the_mean_of_linear_fields() {
        let middle = W::from([0.3, -0.2, 0.7]);
        let rectangle =
            Area::of_edges(middle, &[W::from([0.2, 0.0, 0.1]), W::from([0.0, 0.3, 0.0])], None).unwrap();
        let disc = Area::disc(middle, 0.4, &W::from([1.0, 2.0, -0.5])).unwrap();
        let field = |at: &W| 3.0 + at.x - 2.0 * at.y + 0.5 * at.z;
        for area in [&rectangle, &disc] {
            let points = area.points(0.02);
            assert!((points.iter().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-12);
            let mean: f64 = points.iter().map(|(at, share)| share * field(at)).sum();
            assert!((mean - field(&middle)).abs() < 1e-12, "{mean}");
        }
        let square: f64 =
            disc.points(0.02).iter().map(|(at, share)| share * (at - middle).norm_squared()).sum();
        assert!((square / 0.08 - 1.0).abs() < 1.0 / 400.0, "{square}");
    }
}
