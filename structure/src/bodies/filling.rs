//! Particles of two-dimensional bodies that no lattice along the axes fits: scattered ones, lattices at an
//! angle, bodies that a circle cuts.

use crate::bodies::cells::{Cell, relax_to_centroids};
use sph::Vector;
use sph::lattice::{Lattice, jittered};

/// Chords of an arc in a spacing: the arc's area is then missed by `(Δx/8)³/(12 R)` a chord.
const CHORDS: f64 = 8.0;

/// How particles are laid in the outline of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filling {
    /// Particle spacing (m).
    pub spacing: f64,
    /// Angle of the lattice to the axes (rad), counter-clockwise. At zero the lattice tiles the body's box.
    pub lattice_angle: f64,
    /// Random displacement from the lattice, at most this times the spacing along each axis.
    pub jitter: f64,
    /// Seed of the random displacement.
    pub seed: u64,
    /// Times that the particles move to the centroids of their cells ([`relax_to_centroids`]).
    pub sweeps: usize,
}

impl Filling {
    /// Particles in the part of the box from `low` to `high` (m) within `outline` (corners
    /// counter-clockwise), with their cells.
    pub fn fill(
        &self,
        low: Vector<2>,
        high: Vector<2>,
        outline: &[Vector<2>],
    ) -> (Vec<Vector<2>>, Vec<Cell<2>>) {
        let points = jittered(self.lattice(low, high), self.jitter * self.spacing, self.seed);
        let positions = points.into_iter().filter(|p| contains(outline, p)).collect();
        relax_to_centroids(positions, outline, self.spacing, self.sweeps)
    }

    /// The lattice; at an angle, over a disc about the box, which is centred on a corner of its cells.
    fn lattice(&self, low: Vector<2>, high: Vector<2>) -> Vec<Vector<2>> {
        if self.lattice_angle == 0.0 {
            return Lattice::fill_box(low, high, self.spacing).positions;
        }
        let (sine, cosine) = self.lattice_angle.sin_cos();
        let centre = (low + high) * 0.5;
        let rows = (0.5 * (high - low).norm() / self.spacing).ceil() as i32 + 1;
        let at = |n: i32| (f64::from(n) + 0.5) * self.spacing;
        (-rows..rows)
            .flat_map(|j| (-rows..rows).map(move |i| (at(i), at(j))))
            .map(|(x, y)| centre + Vector::from([cosine * x - sine * y, sine * x + cosine * y]))
            .collect()
    }
}

/// The corners of a box (m), counter-clockwise.
pub fn rectangle(low: Vector<2>, high: Vector<2>) -> Vec<Vector<2>> {
    [[low.x, low.y], [high.x, low.y], [high.x, high.y], [low.x, high.y]].map(Vector::from).to_vec()
}

/// An outline without the part in a disc, and fixed nodes about `spacing` (m) apart on the arc that bounds it
/// then. `None` unless the circle cuts the outline in two points.
pub fn without_disc(
    outline: &[Vector<2>],
    centre: &Vector<2>,
    radius: f64,
    spacing: f64,
) -> Option<(Vec<Vector<2>>, Vec<Vector<2>>)> {
    // The corners outside of the disc from the point where the border leaves it, and the two points.
    let mut crossings = Vec::new();
    for (i, p) in outline.iter().enumerate() {
        let edge = outline[(i + 1) % outline.len()] - p;
        let from = p - centre;
        // |from + s edge| = radius
        let (a, b, c) = (edge.norm_squared(), from.dot(&edge), from.norm_squared() - radius * radius);
        let square = b * b - a * c;
        if square > 0.0 {
            let inner = [(-b - square.sqrt()) / a, (-b + square.sqrt()) / a];
            // Entering at the smaller root, leaving at the larger one.
            for (s, leaves) in inner.into_iter().zip([false, true]) {
                if (0.0..1.0).contains(&s) {
                    crossings.push((i, p + edge * s, leaves));
                }
            }
        }
    }
    let (&(leaving_edge, start, _), &(entering_edge, end, _)) = match &crossings[..] {
        [one, other] if one.2 && !other.2 => (one, other),
        [one, other] if !one.2 && other.2 => (other, one),
        _ => return None,
    };
    let count = outline.len();
    let mut kept = vec![start];
    let mut corner = (leaving_edge + 1) % count;
    while corner != (entering_edge + 1) % count {
        kept.push(outline[corner]);
        corner = (corner + 1) % count;
    }
    // Back along the circle, the material to the left: clockwise about the centre.
    let angle = |p: &Vector<2>| (p.y - centre.y).atan2(p.x - centre.x);
    let turn = (angle(&end) - angle(&start)).rem_euclid(std::f64::consts::TAU);
    let on_circle = |fraction: f64| {
        let (sine, cosine) = (angle(&end) - fraction * turn).sin_cos();
        centre + Vector::from([cosine, sine]) * radius
    };
    let nodes = (turn * radius / spacing).round().max(1.0);
    let chords = nodes * CHORDS;
    kept.extend((0..chords as usize).map(|k| on_circle(k as f64 / chords)));
    Some((kept, (0..nodes as usize).map(|k| on_circle((k as f64 + 0.5) / nodes)).collect()))
}

/// Whether a point is in a simple polygon: a ray from it crosses the border an odd number of times.
fn contains(polygon: &[Vector<2>], point: &Vector<2>) -> bool {
    let mut inside = false;
    for (i, p) in polygon.iter().enumerate() {
        let q = &polygon[(i + 1) % polygon.len()];
        if (p.y > point.y) != (q.y > point.y) && point.x < p.x + (q.x - p.x) * (point.y - p.y) / (q.y - p.y) {
            inside = !inside;
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// A square of edge 2 about the origin without a quarter of a disc of radius 1 about its corner: area 4 −
    /// π/4, up to the chords.
    #[test]
    fn a_disc_cuts_a_corner_off() {
        let square = rectangle(Vector::from([-1.0, -1.0]), Vector::from([1.0, 1.0]));
        for corner in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(Vector::from) {
            let (outline, nodes) = without_disc(&square, &corner, 1.0, 0.1).unwrap();
            let area: f64 = (0..outline.len())
                .map(|i| {
                    let (p, q) = (outline[i], outline[(i + 1) % outline.len()]);
                    0.5 * (p.x * q.y - p.y * q.x)
                })
                .sum();
            // 128 chords miss (π/256)³ · 128 · 2/12 of radius 1.
            assert!((area - (4.0 - PI / 4.0)).abs() < 5e-5, "{corner} {area}");
            assert_eq!(nodes.len(), 16);
            assert!(nodes.iter().all(|n| ((n - corner).norm() - 1.0).abs() < 1e-14));
            assert!(nodes.iter().all(|n| n.x.abs() < 1.0 && n.y.abs() < 1.0));
        }
        assert_eq!(without_disc(&square, &Vector::zeros(), 0.5, 0.1), None);
        assert_eq!(without_disc(&square, &Vector::zeros(), 1.2, 0.1), None);
    }

    /// Cells tile the outline: its volume and first moments, to round-off, whatever the particles.
    #[test]
    fn cells_of_any_filling_tile_the_outline() {
        let (low, high) = (Vector::from([0.24, 0.19]), Vector::from([0.6, 0.21]));
        let cut = without_disc(&rectangle(low, high), &Vector::from([0.2, 0.2]), 0.05, 0.004).unwrap().0;
        let plain = Filling { spacing: 0.004, lattice_angle: 0.0, jitter: 0.0, seed: 1, sweeps: 0 };
        for filling in [
            plain,
            Filling { jitter: 0.1, ..plain },
            Filling { lattice_angle: 0.3, ..plain },
            Filling { lattice_angle: 0.3, jitter: 0.2, sweeps: 3, ..plain },
        ] {
            let (positions, cells) = filling.fill(low, high, &cut);
            let (mut area, mut first) = (0.0, Vector::<2>::zeros());
            for (i, p) in cut.iter().enumerate() {
                let q = cut[(i + 1) % cut.len()];
                let triangle = 0.5 * (p.x * q.y - p.y * q.x);
                area += triangle;
                first += (p + q) * (triangle / 3.0);
            }
            let volume: f64 = cells.iter().map(|c| c.volume).sum();
            let moment = cells
                .iter()
                .zip(&positions)
                .fold(Vector::<2>::zeros(), |sum, (c, p)| sum + (p + c.offset) * c.volume);
            assert!((volume / area - 1.0).abs() < 1e-12, "{filling:?} {volume}");
            assert!((moment - first).norm() < 1e-12 * first.norm(), "{filling:?}");
        }
    }
}
