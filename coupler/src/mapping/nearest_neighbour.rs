//! Nearest neighbour: each target takes the value of the nearest source point.
//!
//! Constant fields are exact, and so total forces are kept; rotations and moments are not, but for targets
//! that coincide with sources. The error falls with the first power of the distance between source points.

use super::cell_grid::CellGrid;
use super::error::MappingError;
use super::rows::Rows;

/// Points a cell of the search: of 0.75, 1, 1.5, 2 and 3 the fastest, or as fast, on lattices in the plane.
pub(super) const POINTS_PER_CELL: f64 = 1.0;

/// The scratch of the method.
#[derive(Clone, Debug, Default)]
pub(super) struct NearestNeighbour {
    grid: CellGrid,
}

impl NearestNeighbour {
    /// Gathers a row for each target. There is a source point, and all points are finite.
    pub fn fill<const D: usize>(
        &mut self,
        source: &[[f64; D]],
        target: &[[f64; D]],
        reach: f64,
        rows: &mut Rows,
    ) -> Result<(), MappingError> {
        self.grid.rebuild(source, POINTS_PER_CELL);
        for (point, x) in target.iter().enumerate() {
            let (nearest, _) =
                self.grid.nearest(x, reach).ok_or_else(|| out_of_reach(&self.grid, point, x, reach))?;
            rows.add(nearest, 1.0);
            rows.end_row();
        }
        Ok(())
    }
}

/// The error for a target with no source point in reach.
pub(super) fn out_of_reach<const D: usize>(
    grid: &CellGrid,
    point: usize,
    x: &[f64; D],
    reach: f64,
) -> MappingError {
    let distance = grid.nearest(x, f64::INFINITY).map_or(f64::INFINITY, |(_, squared)| squared.sqrt());
    MappingError::OutOfReach { point, position: x.to_vec(), distance, reach }
}
