//! Neighbour lists in compressed rows, found with a uniform grid of cells.

use crate::Vector;
use rayon::prelude::*;

/// Lists of neighbours: those of query point `i` are `indices[offsets[i]..offsets[i + 1]]`, in a fixed order
/// that depends on the points alone (cell by cell, by index within a cell), so that sums over them do not
/// depend on the number of threads.
#[derive(Clone, Debug, Default)]
pub struct NeighbourList {
    offsets: Vec<u32>,
    indices: Vec<u32>,
    /// What each task has found for its [`ROWS`] query points, before it is known where in `indices` it goes.
    found: Vec<Vec<u32>>,
}

/// Query points that one task works through.
const ROWS: usize = 256;

/// Tasks that are worked through before what they have found is put into its place.
const TASKS: usize = 16;

impl NeighbourList {
    /// Neighbours of point `i`.
    #[inline]
    pub fn of(&self, i: usize) -> &[u32] {
        &self.indices[self.range(i)]
    }

    /// Where the pairs of point `i` stand in arrays that hold one entry a pair.
    #[inline]
    pub fn range(&self, i: usize) -> std::ops::Range<usize> {
        self.offsets[i] as usize..self.offsets[i + 1] as usize
    }

    /// Number of query points.
    pub fn len(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Whether there are no query points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of pairs over all points.
    pub fn pairs(&self) -> usize {
        self.indices.len()
    }

    /// Row starts, `len() + 1` of them.
    pub fn offsets(&self) -> &[u32] {
        &self.offsets
    }

    /// Neighbour indices, row after row.
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }

    /// Replaces every neighbour by `names[neighbour]`: ghost images become the points that they are images
    /// of.
    pub fn rename(&mut self, names: &[u32]) {
        self.indices.iter_mut().for_each(|j| *j = names[*j as usize]);
    }

    /// Appends pairs (row, neighbour), rows growing, behind those that each row has. Gives for each pair of
    /// the new list whether it is one of them.
    pub fn append(&mut self, pairs: impl Iterator<Item = (u32, u32)>) -> Vec<bool> {
        let (mut indices, mut is_new) = (Vec::with_capacity(self.indices.len()), Vec::new());
        let mut pairs = pairs.peekable();
        let mut offsets = vec![0];
        for row in 0..self.len() {
            indices.extend_from_slice(self.of(row));
            is_new.resize(indices.len(), false);
            while let Some((_, neighbour)) = pairs.next_if(|pair| pair.0 as usize == row) {
                indices.push(neighbour);
                is_new.push(true);
            }
            offsets.push(indices.len() as u32);
        }
        assert!(pairs.next().is_none(), "rows grow, and are rows of the list");
        (self.offsets, self.indices) = (offsets, indices);
        is_new
    }

    /// Finds, for every query point, the grid's points nearer than the grid's radius, coincident ones left
    /// out (so that a list over its own points does not hold the point itself). Memory of earlier calls is
    /// used again.
    pub fn rebuild<const D: usize>(
        &mut self,
        queries: &[Vector<D>],
        grid: &CellGrid<D>,
        points: &[Vector<D>],
    ) {
        // Candidates are read one after the other here, not one from here and one from there as `members` has
        // them.
        let binned: Vec<Vector<D>> =
            grid.members.par_iter().with_min_len(1024).map(|&j| points[j as usize]).collect();
        self.offsets.resize(queries.len() + 1, 0);
        self.offsets[0] = 0;
        self.found.resize_with(TASKS, Vec::new);
        let mut first = 0;
        for (ends, queries) in self.offsets[1..].chunks_mut(TASKS * ROWS).zip(queries.chunks(TASKS * ROWS)) {
            let tasks =
                self.found.par_iter_mut().zip(ends.par_chunks_mut(ROWS).zip(queries.par_chunks(ROWS)));
            tasks.for_each(|(found, (ends, queries))| grid.search(queries, &binned, found, ends));
            let found = &self.found[..queries.len().div_ceil(ROWS)];
            let end = first + found.iter().map(Vec::len).sum::<usize>();
            self.indices.resize(end.max(self.indices.len()), 0);
            let mut rest = &mut self.indices[first..end];
            let mut tasks = Vec::with_capacity(TASKS);
            for (found, ends) in found.iter().zip(ends.chunks_mut(ROWS)) {
                let (own, tail) = rest.split_at_mut(found.len());
                tasks.push((first as u32, found, ends, own));
                rest = tail;
                first += found.len();
            }
            tasks.into_par_iter().for_each(|(first, found, ends, own)| {
                ends.iter_mut().for_each(|end| *end += first);
                own.copy_from_slice(found);
            });
        }
        self.indices.truncate(first);
    }
}

/// Cells of a grid at most, besides some for each point: more are for few points far from each other, or a
/// radius far under their distance.
const CELLS: f64 = 1.6e7;

/// Points binned into cubic cells as wide as the search radius; wider where there would be too many.
#[derive(Clone, Debug)]
pub struct CellGrid<const D: usize> {
    radius: f64,
    width: f64,
    origin: Vector<D>,
    counts: [usize; D],
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl<const D: usize> CellGrid<D> {
    /// Bins `points` (m, finite) for searches within `radius` (m).
    pub fn new(points: &[Vector<D>], radius: f64) -> Self {
        assert!(radius > 0.0, "a search radius is positive");
        let mut low = Vector::<D>::repeat(f64::INFINITY);
        let mut high = Vector::<D>::repeat(f64::NEG_INFINITY);
        for p in points {
            low = low.inf(p);
            high = high.sup(p);
        }
        if points.is_empty() {
            (low, high) = (Vector::zeros(), Vector::zeros());
        }
        let counts = |width: f64| -> [usize; D] {
            std::array::from_fn(|i| (((high[i] - low[i]) / width) as usize).saturating_add(1))
        };
        let most = CELLS + 16.0 * points.len() as f64;
        let mut width = radius;
        while counts(width).iter().map(|count| *count as f64).product::<f64>() > most {
            width *= 2.0;
        }
        let counts = counts(width);
        let mut grid = Self { radius, width, origin: low, counts, starts: Vec::new(), members: Vec::new() };
        let cells: usize = counts.iter().product();
        let mut starts = vec![0u32; cells + 1];
        let bins: Vec<u32> = points.par_iter().with_min_len(1024).map(|p| grid.bin(p) as u32).collect();
        for &bin in &bins {
            starts[bin as usize + 1] += 1;
        }
        for c in 0..cells {
            starts[c + 1] += starts[c];
        }
        let mut next = starts.clone();
        let mut members = vec![0u32; points.len()];
        for (i, &bin) in bins.iter().enumerate() {
            members[next[bin as usize] as usize] = i as u32;
            next[bin as usize] += 1;
        }
        (grid.starts, grid.members) = (starts, members);
        grid
    }

    /// Search radius (m).
    pub fn radius(&self) -> f64 {
        self.radius
    }

    fn bin(&self, point: &Vector<D>) -> usize {
        let mut bin = 0;
        for i in (0..D).rev() {
            let k = ((point[i] - self.origin[i]) / self.width) as usize;
            bin = bin * self.counts[i] + k.min(self.counts[i] - 1);
        }
        bin
    }

    /// Writes the members near each of `queries` to `found`, and where the list of each ends there to `ends`;
    /// `binned` are the members' points in their order.
    fn search(&self, queries: &[Vector<D>], binned: &[Vector<D>], found: &mut Vec<u32>, ends: &mut [u32]) {
        let radius_squared = self.radius * self.radius;
        found.clear();
        for (end, query) in ends.iter_mut().zip(queries) {
            self.for_each_run(query, |run| {
                // Written always and kept when near: no branch that would be taken half the time.
                let start = found.len();
                found.resize(start + run.len(), 0);
                let (kept, mut count) = (&mut found[start..], 0);
                for (point, &j) in binned[run.clone()].iter().zip(&self.members[run]) {
                    let distance_squared = (query - point).norm_squared();
                    kept[count] = j;
                    count += usize::from((distance_squared < radius_squared) & (distance_squared > 0.0));
                }
                found.truncate(start + count);
            });
            *end = found.len() as u32;
        }
    }

    /// Calls `visit` with every binned point nearer to `query` than the radius and not coincident with it, in
    /// fixed order. `points` are the points the grid was made of.
    #[inline]
    pub fn for_each_near(&self, query: &Vector<D>, points: &[Vector<D>], mut visit: impl FnMut(u32)) {
        let radius_squared = self.radius * self.radius;
        self.for_each_run(query, |run| {
            for &j in &self.members[run] {
                let distance_squared = (query - points[j as usize]).norm_squared();
                if distance_squared < radius_squared && distance_squared > 0.0 {
                    visit(j);
                }
            }
        });
    }

    /// Calls `visit` with the runs of members in the cells around `query`. Cells of a run along the first
    /// axis are neighbours in memory.
    #[inline]
    fn for_each_run(&self, query: &Vector<D>, mut visit: impl FnMut(std::ops::Range<usize>)) {
        let mut low = [0usize; D];
        let mut high = [0usize; D];
        for i in 0..D {
            let k = ((query[i] - self.origin[i]) / self.width).floor() as i64;
            let last = self.counts[i] as i64 - 1;
            if k < -1 || k > last + 1 {
                return;
            }
            low[i] = (k - 1).max(0) as usize;
            high[i] = (k + 1).min(last) as usize;
        }
        let mut cell = low;
        loop {
            let mut first = 0;
            for i in (1..D).rev() {
                first = (first + cell[i]) * self.counts[i - 1];
            }
            visit(self.starts[first + low[0]] as usize..self.starts[first + high[0] + 1] as usize);
            let mut axis = 1;
            loop {
                if axis == D {
                    return;
                }
                if cell[axis] < high[axis] {
                    cell[axis] += 1;
                    break;
                }
                cell[axis] = low[axis];
                axis += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scattered<const D: usize>(count: usize) -> Vec<Vector<D>> {
        let mut seed = 12345u64;
        let mut next = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 33) as f64 / (1u64 << 31) as f64
        };
        (0..count).map(|_| Vector::from_fn(|_, _| next())).collect()
    }

    /// Cells are as many as fit in memory, whatever the radius and wherever a point flew.
    #[test]
    fn cells_are_bounded() {
        for (radius, far) in [(1e-9, 0.0), (1e-300, 0.0), (0.1, 1e9), (0.1, 1e300)] {
            let mut points = scattered::<2>(40);
            points.push(Vector::repeat(far));
            let grid = CellGrid::new(&points, radius);
            assert!(grid.starts.len() as f64 <= CELLS + 16.0 * 41.0 + 1.0, "{radius} {far}");
            let near = |i: usize| {
                let mut count = 0;
                grid.for_each_near(&points[i], &points, |_| count += 1);
                count
            };
            let pairs = |i: usize| {
                points.iter().filter(|q| (0.0..radius).contains(&(*q - points[i]).norm())).count() - 1
            };
            assert!((0..41).all(|i| near(i) == pairs(i)), "{radius} {far}");
        }
    }

    fn agrees_with_all_pairs<const D: usize>() {
        let (points, queries) = (scattered::<D>(300), scattered::<D>(170));
        let radius = 0.17;
        let mut list = NeighbourList::default();
        list.rebuild(&queries, &CellGrid::new(&points, radius), &points);
        for (i, q) in queries.iter().enumerate() {
            let mut found = list.of(i).to_vec();
            found.sort_unstable();
            let expected: Vec<u32> = (0..points.len() as u32)
                .filter(|&j| {
                    let d = (q - points[j as usize]).norm();
                    d < radius && d > 0.0
                })
                .collect();
            assert_eq!(found, expected, "query {i}");
        }
    }

    #[test]
    fn lists_agree_with_all_pairs_in_two_dimensions() {
        agrees_with_all_pairs::<2>();
    }

    #[test]
    fn lists_agree_with_all_pairs_in_three_dimensions() {
        agrees_with_all_pairs::<3>();
    }

    #[test]
    fn queries_far_outside_the_grid_find_nothing() {
        let points = scattered::<2>(10);
        let mut list = NeighbourList::default();
        list.rebuild(
            &[Vector::from([50.0, 0.5]), Vector::from([-9.0, -9.0])],
            &CellGrid::new(&points, 0.2),
            &points,
        );
        assert_eq!(list.pairs(), 0);
    }
}
