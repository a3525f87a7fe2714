//! Source points sorted into equal cells: the nearest one, and all within a radius.

use std::ops::Range;

/// Points in cell order. Dimensions that are missing, or thinner than a cell, have one cell.
#[derive(Clone, Debug, Default)]
pub(super) struct CellGrid {
    lower: [f64; 3],
    size: f64,
    cells_per_metre: f64,
    counts: [usize; 3],
    /// First slot of each cell, and the end.
    starts: Vec<u32>,
    /// Point in each slot; ascending in a cell.
    points: Vec<u32>,
    /// Coordinates in slot order, flat.
    positions: Vec<f64>,
    cell_of: Vec<u32>,
}

impl CellGrid {
    /// Sorts `points` anew, about `points_per_cell` into each cell. There must be a point, and all must be
    /// finite.
    pub fn rebuild<const D: usize>(&mut self, points: &[[f64; D]], points_per_cell: f64) {
        let (lower, upper) = bounds(points);
        self.lay_cells(&lower, &upper, points.len() as f64 / points_per_cell);
        let cells: usize = self.counts.iter().product();
        self.starts.clear();
        self.starts.resize(cells + 1, 0);
        self.cell_of.clear();
        for point in points {
            let [x, y, z] = self.cell(point);
            let cell = x + self.counts[0] * (y + self.counts[1] * z);
            self.cell_of.push(cell as u32);
            self.starts[cell] += 1;
        }
        let mut end = 0;
        for start in &mut self.starts {
            end += *start;
            *start = end;
        }
        self.points.resize(points.len(), 0);
        self.positions.resize(D * points.len(), 0.0);
        let (positions, _) = self.positions.as_chunks_mut::<D>();
        // Backwards, so that points ascend in a cell, and each start ends where its cell begins.
        for (point, &cell) in self.cell_of.iter().enumerate().rev() {
            let slot = &mut self.starts[cell as usize];
            *slot -= 1;
            self.points[*slot as usize] = point as u32;
            positions[*slot as usize] = points[point];
        }
    }

    /// Side of a cell (m).
    pub fn cell_size(&self) -> f64 {
        self.size
    }

    /// The nearest point and the square of its distance (m²), of equally near ones the first; none if there
    /// is none within `reach` (m).
    pub fn nearest<const D: usize>(&self, x: &[f64; D], reach: f64) -> Option<(usize, f64)> {
        let (positions, _) = self.positions.as_chunks::<D>();
        let cell = self.cell(x);
        let mut best = (f64::INFINITY, u32::MAX);
        // The last ring has all cells inside whatever the cell it is drawn around.
        for ring in 0..=self.counts.into_iter().max().unwrap_or(0) {
            self.visit_ring(cell, ring, |slots| {
                for slot in slots {
                    let found = (distance_squared(&positions[slot], x), self.points[slot]);
                    if found < best {
                        best = found;
                    }
                }
            });
            let clearance = self.clearance(x, cell, ring);
            if best.0 < clearance * clearance || clearance > reach {
                break;
            }
        }
        (best.0 <= reach * reach).then_some((best.1 as usize, best.0))
    }

    /// Calls `visit(point, position)` for all points of the cells that a ball meets: those within `radius`
    /// (m) of `x`, and some more.
    pub fn visit_around<const D: usize>(
        &self,
        x: &[f64; D],
        radius: f64,
        mut visit: impl FnMut(usize, &[f64; D]),
    ) {
        let (positions, _) = self.positions.as_chunks::<D>();
        let low = self.cell(&x.map(|c| c - radius));
        let high = self.cell(&x.map(|c| c + radius));
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                for slot in self.slots(low[0], high[0], y, z) {
                    visit(self.points[slot] as usize, &positions[slot]);
                }
            }
        }
    }

    /// About `count` cubes over the box; dimensions thinner than a cube count one.
    fn lay_cells<const D: usize>(&mut self, lower: &[f64; D], upper: &[f64; D], count: f64) {
        let mut extents: [f64; D] = std::array::from_fn(|i| upper[i] - lower[i]);
        extents.sort_by(f64::total_cmp);
        let mut size = 0.0;
        for thin in 0..D {
            let wide = &extents[thin..];
            size = (wide.iter().product::<f64>() / count.max(1.0)).powf(1.0 / wide.len() as f64);
            if wide[0] >= size {
                break;
            }
        }
        self.size = if size > 0.0 { size } else { 1.0 };
        self.cells_per_metre = 1.0 / self.size;
        self.lower = [0.0; 3];
        self.counts = [1; 3];
        for i in 0..D {
            self.lower[i] = lower[i];
            self.counts[i] = ((upper[i] - lower[i]) * self.cells_per_metre) as usize + 1;
        }
    }

    /// The cell of `x`, or the nearest to it.
    fn cell<const D: usize>(&self, x: &[f64; D]) -> [usize; 3] {
        let mut cell = [0; 3];
        for i in 0..D {
            // A cast to an integer saturates: what is below is in the first cell.
            cell[i] = (((x[i] - self.lower[i]) * self.cells_per_metre) as usize).min(self.counts[i] - 1);
        }
        cell
    }

    fn slots(&self, low_x: usize, high_x: usize, y: usize, z: usize) -> Range<usize> {
        let row = self.counts[0] * (y + self.counts[1] * z);
        self.starts[row + low_x] as usize..self.starts[row + high_x + 1] as usize
    }

    /// Calls `visit` with the slots of all cells that are `ring` cells from `cell`, in the largest component.
    fn visit_ring(&self, cell: [usize; 3], ring: usize, mut visit: impl FnMut(Range<usize>)) {
        let range = |i: usize| (cell[i].saturating_sub(ring), (cell[i] + ring).min(self.counts[i] - 1));
        let ((low_x, high_x), (low_y, high_y), (low_z, high_z)) = (range(0), range(1), range(2));
        for z in low_z..=high_z {
            for y in low_y..=high_y {
                if z.abs_diff(cell[2]) == ring || y.abs_diff(cell[1]) == ring {
                    visit(self.slots(low_x, high_x, y, z));
                } else {
                    if cell[0] >= ring {
                        visit(self.slots(low_x, low_x, y, z));
                    }
                    if cell[0] + ring < self.counts[0] {
                        visit(self.slots(high_x, high_x, y, z));
                    }
                }
            }
        }
    }

    /// Distance (m) from `x` to the nearest cell outside the block of `ring` cells around `cell`; infinite
    /// where there is none.
    fn clearance<const D: usize>(&self, x: &[f64; D], cell: [usize; 3], ring: usize) -> f64 {
        let mut clearance = f64::INFINITY;
        for i in 0..D {
            if cell[i] > ring {
                clearance = clearance.min(x[i] - self.lower[i] - (cell[i] - ring) as f64 * self.size);
            }
            if cell[i] + ring + 1 < self.counts[i] {
                clearance = clearance.min(self.lower[i] + (cell[i] + ring + 1) as f64 * self.size - x[i]);
            }
        }
        // A point on a face may have been rounded into the cell beyond.
        (clearance - 1e-9 * self.size).max(0.0)
    }
}

/// Square of the distance (m²).
pub(super) fn distance_squared<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    let mut sum = 0.0;
    for i in 0..D {
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    }
    sum
}

/// Lowest and highest coordinates.
pub(super) fn bounds<const D: usize>(points: &[[f64; D]]) -> ([f64; D], [f64; D]) {
    let (mut lower, mut upper) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    for point in points {
        for i in 0..D {
            lower[i] = lower[i].min(point[i]);
            upper[i] = upper[i].max(point[i]);
        }
    }
    (lower, upper)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in [0, 1) from a linear congruence (Knuth's MMIX).
    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*state >> 11) as f64 / (1u64 << 53) as f64
    }

    fn agrees_with_all_pairs<const D: usize>(extents: [f64; D], count: usize) {
        let state = &mut 7;
        let points: Vec<[f64; D]> = (0..count).map(|_| extents.map(|e| e * random(state))).collect();
        let mut grid = CellGrid::default();
        grid.rebuild(&points, 2.0);
        for _ in 0..200 {
            // Inside, outside and far outside.
            let x = extents.map(|e| (e + 0.1) * (3.0 * random(state) - 1.0));
            let all = points.iter().enumerate().map(|(i, p)| (distance_squared(p, &x), i));
            let (distance, nearest) = all.min_by(|a, b| a.partial_cmp(b).unwrap()).unwrap();
            assert_eq!(grid.nearest(&x, f64::INFINITY), Some((nearest, distance)));
            assert_eq!(grid.nearest(&x, 0.999 * distance.sqrt()), None);
            let radius = 0.3 * random(state);
            let mut around = vec![false; count];
            grid.visit_around(&x, radius, |i, p| around[i] = *p == points[i]);
            for (i, p) in points.iter().enumerate() {
                assert!(around[i] || distance_squared(p, &x) > radius * radius);
            }
        }
    }

    #[test]
    fn finds_what_a_search_over_all_pairs_finds() {
        agrees_with_all_pairs([1.0, 1.0], 300);
        agrees_with_all_pairs([1.0, 0.01], 300);
        agrees_with_all_pairs([0.0, 1.0], 50);
        agrees_with_all_pairs([1.0, 0.3, 2.0], 500);
        agrees_with_all_pairs([1.0, 0.0, 1.0], 200);
        agrees_with_all_pairs([0.0, 0.0, 0.0], 3);
    }

    #[test]
    fn of_equally_near_points_the_first_is_taken() {
        let mut grid = CellGrid::default();
        grid.rebuild(&[[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]], 1.0);
        assert_eq!(grid.nearest(&[0.0, 0.0], 2.0), Some((0, 1.0)));
    }
}
