//! Rigid walls as contact sees them: their faces, where their law has brought them.

use sph::Vector;
use words::rigid::{Motion, Pose};

/// A rigid wall.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall<const D: usize> {
    /// Name, for messages.
    pub name: String,
    /// Shape at rest.
    pub shape: WallShape<D>,
    /// How it moves; none for one that stays where it is.
    pub motion: Option<Motion<D>>,
}

/// Shape of a wall.
#[derive(Clone, Debug, PartialEq)]
pub enum WallShape<const D: usize> {
    /// A solid box between two corners (m).
    Box {
        /// Lowest coordinates.
        low: Vector<D>,
        /// Highest coordinates.
        high: Vector<D>,
    },
    /// A face in pieces from point to point (m); two dimensions only.
    Polyline(Vec<Vector<D>>),
}

/// A convex part of a wall at rest.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part<const D: usize> {
    Box(Vector<D>, Vector<D>),
    Segment(Vector<D>, Vector<D>),
    Point(Vector<D>),
}

/// A wall's parts, and how often each counts: a point that pieces share as often as takes away what it is in
/// more than one of them.
pub(crate) fn parts<const D: usize>(shape: &WallShape<D>) -> Vec<(Part<D>, f64)> {
    match shape {
        WallShape::Box { low, high } => vec![(Part::Box(*low, *high), 1.0)],
        WallShape::Polyline(points) => {
            let mut parts: Vec<_> = points.windows(2).map(|p| (Part::Segment(p[0], p[1]), 1.0)).collect();
            let inner = points.iter().skip(1).take(points.len().saturating_sub(2));
            parts.extend(inner.map(|p| (Part::Point(*p), -1.0)));
            if points.len() > 2 && points.first() == points.last() {
                parts.push((Part::Point(points[0]), -1.0));
            }
            parts
        }
    }
}

impl<const D: usize> Part<D> {
    /// Its nearest point (m) to `x` (m), both at rest.
    pub fn nearest(&self, x: &Vector<D>) -> Vector<D> {
        match self {
            Self::Box(low, high) => Vector::from_fn(|i, _| x[i].clamp(low[i], high[i])),
            Self::Segment(a, b) => {
                let w = crate::contact::distance::nearest(x, &[*a, *b]);
                a * w[0] + b * w[1]
            }
            Self::Point(a) => *a,
        }
    }
}

impl<const D: usize> Wall<D> {
    /// Where it is at a time (s), if it moves.
    pub fn pose(&self, time: f64) -> Option<Pose<D>> {
        self.motion.as_ref().map(|motion| motion.pose(time))
    }

    /// Corners of the box (m) that holds its shape at rest.
    pub(crate) fn corners(&self) -> (Vector<D>, Vector<D>) {
        match &self.shape {
            WallShape::Box { low, high } => (*low, *high),
            WallShape::Polyline(points) => points.iter().fold(
                (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY)),
                |(low, high), p| (low.inf(p), high.sup(p)),
            ),
        }
    }
}
