//! Cells of particles that are no lattice: Voronoi cells within a polygon, with volume, centroid and second
//! moments.

use sph::neighbours::CellGrid;
use sph::{Matrix, Vector, tensor};

/// Bisectors with the particles within this many spacings bound a cell; of a set without gaps as wide as
/// that, no others cut it.
const REACH: f64 = 4.0;

/// The part of a body that one particle stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell<const D: usize> {
    /// Volume (m³).
    pub volume: f64,
    /// Centroid less the particle's position (m).
    pub offset: Vector<D>,
    /// Second moments about the centroid over the volume (m²).
    pub moment: Matrix<D>,
}

impl<const D: usize> Cell<D> {
    /// The cell of a lattice with the edges given (m): `Δx_k²/12` on the diagonal.
    pub fn of_lattice(edges: &Vector<D>) -> Self {
        let moment = Matrix::from_fn(|i, j| if i == j { edges[i].powi(2) / 12.0 } else { 0.0 });
        Self { volume: edges.iter().product(), offset: Vector::zeros(), moment }
    }
}

/// Voronoi cells of the positions (m), about `spacing` (m) apart, within a simple polygon (corners
/// counter-clockwise). A particle without any part of the polygon has volume zero.
pub fn voronoi_cells(positions: &[Vector<2>], polygon: &[Vector<2>], spacing: f64) -> Vec<Cell<2>> {
    let radius = REACH * spacing;
    let grid = CellGrid::new(positions, radius);
    let mut near = Vec::new();
    positions
        .iter()
        .map(|a| {
            near.clear();
            grid.for_each_near(a, positions, |b| near.push(positions[b as usize] - a));
            // Nearest first: the polygon is small after a few cuts.
            near.sort_by(|p, q| p.norm_squared().total_cmp(&q.norm_squared()));
            let mut corners: Vec<Vector<2>> = polygon.iter().map(|p| p - a).collect();
            for n in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
                corners = cut(&corners, &Vector::from(n), 0.5 * radius);
            }
            for d in near.iter().filter(|d| d.norm_squared() > 0.0 && d.norm() < radius) {
                corners = cut(&corners, d, 0.5 * d.norm_squared());
            }
            measure(&corners)
        })
        .collect()
}

/// Moves particles to the centroids of their Voronoi cells, `sweeps` times (Lloyd 1982), and gives them with
/// their cells. Scattered particles want one sweep; a lattice at an angle to the body's faces wants three:
/// its rows at the faces then follow them.
pub fn relax_to_centroids(
    mut positions: Vec<Vector<2>>,
    polygon: &[Vector<2>],
    spacing: f64,
    sweeps: usize,
) -> (Vec<Vector<2>>, Vec<Cell<2>>) {
    let mut cells = voronoi_cells(&positions, polygon, spacing);
    for _ in 0..sweeps {
        for (p, cell) in positions.iter_mut().zip(&cells) {
            *p += cell.offset;
        }
        cells = voronoi_cells(&positions, polygon, spacing);
    }
    (positions, cells)
}

/// The part of a polygon with `n · x ≤ limit` (Sutherland and Hodgman 1974). Pieces of a polygon that is not
/// convex stay joined by edges there and back, which add nothing to its integrals.
fn cut(corners: &[Vector<2>], n: &Vector<2>, limit: f64) -> Vec<Vector<2>> {
    let mut kept = Vec::with_capacity(corners.len() + 2);
    for (i, p) in corners.iter().enumerate() {
        let q = &corners[(i + 1) % corners.len()];
        let (at_p, at_q) = (n.dot(p) - limit, n.dot(q) - limit);
        if at_p <= 0.0 {
            kept.push(*p);
        }
        if (at_p < 0.0 && at_q > 0.0) || (at_p > 0.0 && at_q < 0.0) {
            kept.push(p + (q - p) * (at_p / (at_p - at_q)));
        }
    }
    kept
}

/// Area, centroid and second moments of a polygon, as sums over the triangles that its edges make with the
/// origin.
fn measure(corners: &[Vector<2>]) -> Cell<2> {
    let (mut area, mut first, mut second) = (0.0, Vector::<2>::zeros(), Matrix::<2>::zeros());
    for (i, p) in corners.iter().enumerate() {
        let q = &corners[(i + 1) % corners.len()];
        let triangle = 0.5 * (p.x * q.y - p.y * q.x);
        let sum = p + q;
        area += triangle;
        first += sum * (triangle / 3.0);
        second += (tensor::outer(p, p) + tensor::outer(q, q) + tensor::outer(&sum, &sum)) * (triangle / 12.0);
    }
    if area <= 0.0 {
        return Cell { volume: 0.0, offset: Vector::zeros(), moment: Matrix::zeros() };
    }
    let offset = first / area;
    Cell { volume: area, offset, moment: second / area - tensor::outer(&offset, &offset) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_a_lattice_are_its_cells_and_cells_of_any_set_tile_the_polygon() {
        let rectangle = [[0.0, 0.0], [0.4, 0.0], [0.4, 0.2], [0.0, 0.2]].map(Vector::from);
        let mut points: Vec<Vector<2>> = (0..8)
            .map(|n| Vector::from([0.05 + 0.1 * f64::from(n % 4), 0.05 + 0.1 * f64::from(n / 4)]))
            .collect();
        let lattice = Cell::of_lattice(&Vector::from([0.1, 0.1]));
        for cell in voronoi_cells(&points, &rectangle, 0.1) {
            // Round-off of coordinates in the cuts.
            assert!((cell.volume - lattice.volume).abs() < 1e-15);
            assert!(cell.offset.norm() < 1e-15 && (cell.moment - lattice.moment).norm() < 1e-16);
        }
        for (n, p) in points.iter_mut().enumerate() {
            *p += Vector::from([0.02 * (n as f64 * 1.7).sin(), 0.02 * (n as f64 * 2.3).cos()]);
        }
        let cells = voronoi_cells(&points, &rectangle, 0.1);
        let volume: f64 = cells.iter().map(|c| c.volume).sum();
        let first =
            cells.iter().zip(&points).fold(Vector::<2>::zeros(), |s, (c, p)| s + (p + c.offset) * c.volume);
        let second: f64 = cells
            .iter()
            .zip(&points)
            .map(|(c, p)| c.volume * (c.moment.trace() + (p + c.offset).norm_squared()))
            .sum();
        // Integrals of 1, x and x² + y² over the rectangle, to round-off.
        assert!((volume - 0.08).abs() < 1e-15);
        assert!((first - Vector::from([0.016, 0.008])).norm() < 1e-16);
        assert!((second - (0.2 * 0.4_f64.powi(3) + 0.4 * 0.2_f64.powi(3)) / 3.0).abs() < 1e-16);
    }

    /// An L, one particle in it: area 3, centroid (5/6, 5/6).
    #[test]
    fn a_polygon_may_have_a_corner_inwards() {
        let polygon =
            [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]].map(Vector::from);
        let at = Vector::from([0.5, 0.5]);
        let cell = voronoi_cells(&[at], &polygon, 1.0)[0];
        assert!((cell.volume - 3.0).abs() < 1e-14);
        assert!((cell.offset + at - Vector::repeat(5.0 / 6.0)).norm() < 1e-14);
    }
}
