//! Shapes of walls, and where their surface is nearest to a point.

use crate::boundaries::wall_motion::Motion;
use sph::Vector;
pub use words::geometry::Side;

/// Shape of a wall.
#[derive(Clone, Debug, PartialEq)]
pub enum WallShape<const D: usize> {
    /// A solid box between two corners (m), its edges along the axes.
    Box {
        /// Lowest coordinates.
        low: Vector<D>,
        /// Highest coordinates.
        high: Vector<D>,
    },
    /// Straight pieces from point to point (m), solid on one side (two dimensions only); closed when the last
    /// point is the first.
    Polyline {
        /// The points.
        points: Vec<Vector<D>>,
        /// Where the solid is.
        solid: Side,
    },
}

/// A named wall.
#[derive(Clone, Debug, PartialEq)]
pub struct WallPart<const D: usize> {
    /// Name, for forces and messages.
    pub name: String,
    /// Shape.
    pub shape: WallShape<D>,
    /// Velocity of the surface (m/s) along itself: the wall slides, its shape stays where it is.
    pub velocity: Vector<D>,
    /// How the wall moves; none for one that stays where it is.
    pub motion: Option<Motion<D>>,
}

/// A point on a surface: signed distance to it (m, negative inside the solid) and the direction away from the
/// solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint<const D: usize> {
    /// Distance (m).
    pub distance: f64,
    /// Unit normal, out of the solid.
    pub normal: Vector<D>,
}

impl<const D: usize> WallShape<D> {
    /// The nearest point of the shape's surface to `point` (m).
    pub fn surface_point(&self, point: &Vector<D>) -> SurfacePoint<D> {
        match self {
            Self::Box { low, high } => {
                let nearest = Vector::from_fn(|i, _| point[i].clamp(low[i], high[i]));
                let offset = point - nearest;
                let distance = offset.norm();
                if distance > 0.0 {
                    return SurfacePoint { distance, normal: offset / distance };
                }
                let mut best = SurfacePoint { distance: f64::NEG_INFINITY, normal: Vector::zeros() };
                for axis in 0..D {
                    for (depth, sign) in [(point[axis] - low[axis], -1.0), (high[axis] - point[axis], 1.0)] {
                        if -depth > best.distance {
                            best.distance = -depth;
                            best.normal = Vector::from_fn(|i, _| if i == axis { sign } else { 0.0 });
                        }
                    }
                }
                best
            }
            Self::Polyline { points, solid } => {
                let (nearest, beyond) = nearest_on(points, *solid, point);
                if beyond {
                    SurfacePoint { distance: nearest.distance.abs(), normal: nearest.away }
                } else {
                    nearest.into()
                }
            }
        }
    }

    /// The same, but that a polyline's solid goes on beyond its ends.
    pub fn continued_distance(&self, point: &Vector<D>) -> f64 {
        match self {
            Self::Box { .. } => self.surface_point(point).distance,
            Self::Polyline { points, solid } => nearest_on(points, *solid, point).0.distance,
        }
    }
}

/// The nearest point of a polyline.
struct Nearest<const D: usize> {
    /// Distance (m), negative on the solid's side.
    distance: f64,
    /// Unit vector from it to the point.
    away: Vector<D>,
}

impl<const D: usize> From<Nearest<D>> for SurfacePoint<D> {
    fn from(nearest: Nearest<D>) -> Self {
        let Nearest { distance, away } = nearest;
        Self { distance, normal: if distance < 0.0 { -away } else { away } }
    }
}

/// The nearest point of a polyline, and whether `point` (m) is beyond one of its ends: there is no solid
/// there.
fn nearest_on<const D: usize>(points: &[Vector<D>], solid: Side, point: &Vector<D>) -> (Nearest<D>, bool) {
    let (last, closed) = (points.len().saturating_sub(2), points.first() == points.last());
    // At a corner two pieces are equally near; the one that the point stands more squarely before has the
    // right sign.
    let mut best = (f64::INFINITY, 0.0, Vector::zeros(), false);
    for (k, piece) in points.windows(2).enumerate() {
        let along = piece[1] - piece[0];
        let s = (point - piece[0]).dot(&along) / along.norm_squared();
        let offset = point - (piece[0] + along * s.clamp(0.0, 1.0));
        let out = fluid_side(&along, solid);
        let (distance, square) = (offset.norm(), offset.dot(&out));
        let tie = (distance - best.0).abs() <= 1e-9 * along.norm();
        if (tie && square.abs() > f64::abs(best.1)) || (!tie && distance < best.0) {
            let beyond = !closed && (k == 0 && s < 0.0 || k == last && s > 1.0);
            best = (distance, square, if distance > 0.0 { offset / distance } else { out }, beyond);
        }
    }
    let (distance, square, away, beyond) = best;
    (Nearest { distance: if square < 0.0 { -distance } else { distance }, away }, beyond)
}

/// Unit normal of a piece, out of the solid.
pub fn fluid_side<const D: usize>(along: &Vector<D>, solid: Side) -> Vector<D> {
    let right = Vector::from_fn(|i, _| if i == 0 { along[1] } else { -along[0] }) / along.norm();
    match solid {
        Side::Left => right,
        Side::Right => -right,
    }
}
