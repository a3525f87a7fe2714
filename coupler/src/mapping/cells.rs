//! Targets in the cells of a lattice of clusters, and which source points a row has before any weight is
//! known.
//!
//! The lattice's spacing is the radius of the clusters' balls, which stand around its nodes: a target is in
//! balls around corners of its own cell, and nowhere else. Rows of a cell's targets are parts of the union of
//! the clusters around its corners.

use super::cell_grid::{CellGrid, distance_squared};
use std::collections::HashMap;
use std::ops::Range;

/// Corners of a cell in space.
pub(super) const CORNERS: usize = 8;
/// No cluster stands around a corner.
pub(super) const NONE: u32 = u32::MAX;

/// Where clusters take their points from.
#[derive(Clone, Copy)]
pub(super) struct Sources<'a, const D: usize> {
    pub grid: &'a CellGrid,
    pub positions: &'a [[f64; D]],
    /// Of a cluster's ball, and spacing of the lattice (m).
    pub radius: f64,
}

/// A cell with targets in it.
#[derive(Clone, Debug, Default)]
pub(super) struct Cell {
    /// Its lowest corner.
    pub node: [i64; 3],
    /// Slots of its targets.
    pub targets: Range<usize>,
    /// Clusters around its corners that have a target of it, or [`NONE`]. The first axis is the last bit of a
    /// corner's number.
    pub clusters: [u32; CORNERS],
    /// Slots of the union of their points.
    pub union: Range<usize>,
    /// First of the slots in the union that each corner's points have.
    pub slots: [u32; CORNERS],
}

/// Cells and clusters of a part of the targets.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    cell_of: HashMap<[i64; 3], u32>,
    cluster_of: HashMap<[i64; 3], u32>,
    pub cells: Vec<Cell>,
    /// The cell of each target, in the order of targets.
    cell: Vec<u32>,
    /// Targets from cell to cell, ascending in each, and the corners in whose balls they are, a bit each.
    pub order: Vec<u32>,
    pub inside: Vec<u8>,
    /// Points of the clusters, ascending in each: cluster `k` has those of `starts[k]..starts[k + 1]`.
    pub points: Vec<u32>,
    pub starts: Vec<usize>,
    /// Points of the unions, ascending in each, and the corners in whose clusters they are.
    pub union: Vec<u32>,
    pub union_corners: Vec<u8>,
    /// For each cluster of a cell where its points are in the union.
    pub slots: Vec<u32>,
    /// Length of each target's row.
    pub lengths: Vec<u32>,
}

/// The middle of the ball around a node (m).
pub(super) fn middle<const D: usize>(node: [i64; 3], corner: usize, radius: f64) -> [f64; D] {
    std::array::from_fn(|c| node[c].saturating_add((corner >> c & 1) as i64) as f64 * radius)
}

impl Cells {
    /// Sorts the targets of a part into cells and finds the points of their clusters.
    pub fn lay<const D: usize>(&mut self, sources: Sources<D>, target: &[[f64; D]], pad: usize) {
        self.sort(sources.radius, target);
        self.cluster_of.clear();
        self.points.clear();
        self.starts.clear();
        self.starts.push(0);
        self.union.clear();
        self.union_corners.clear();
        self.slots.clear();
        self.lengths.clear();
        self.lengths.resize(target.len(), 0);
        self.inside.clear();
        for at in 0..self.cells.len() {
            self.find_clusters(sources, target, at);
            self.unite(at, pad);
            self.count(at);
        }
    }

    fn sort<const D: usize>(&mut self, radius: f64, target: &[[f64; D]]) {
        let Self { cell_of, cells, cell, order, .. } = self;
        cell_of.clear();
        cells.clear();
        cell.clear();
        // The next target is often in the cell of the last.
        let (mut last, mut number) = ([i64::MIN; 3], 0);
        let per_radius = 1.0 / radius;
        for x in target {
            let mut node = [0; 3];
            for c in 0..D {
                node[c] = (x[c] * per_radius).floor() as i64;
            }
            if node != last || cells.is_empty() {
                last = node;
                number = *cell_of.entry(node).or_insert_with(|| {
                    cells.push(Cell { node, ..Cell::default() });
                    cells.len() as u32 - 1
                });
            }
            cell.push(number);
            cells[number as usize].targets.end += 1;
        }
        let mut end = 0;
        for cell in &mut *cells {
            end += cell.targets.end;
            cell.targets = end..end;
        }
        order.resize(target.len(), 0);
        for (point, &cell) in cell.iter().enumerate().rev() {
            let first = &mut cells[cell as usize].targets.start;
            *first -= 1;
            order[*first] = point as u32;
        }
    }

    /// The clusters around a cell's corners in whose balls it has targets.
    fn find_clusters<const D: usize>(&mut self, sources: Sources<D>, target: &[[f64; D]], at: usize) {
        let Sources { grid, positions, radius } = sources;
        let node = self.cells[at].node;
        let middles: [[f64; D]; CORNERS] = std::array::from_fn(|corner| middle(node, corner, radius));
        let mut any = 0;
        for &point in &self.order[self.cells[at].targets.clone()] {
            let mut inside = 0;
            for (corner, middle) in middles[..1 << D].iter().enumerate() {
                let near = distance_squared(&target[point as usize], middle) < radius * radius;
                inside |= u8::from(near) << corner;
            }
            self.inside.push(inside);
            any |= inside;
        }
        self.cells[at].clusters = [NONE; CORNERS];
        for corner in (0..1 << D).filter(|corner| any >> corner & 1 == 1) {
            let mut corner_node = node;
            for c in 0..D {
                corner_node[c] = corner_node[c].saturating_add((corner >> c & 1) as i64);
            }
            let Self { points, starts, .. } = self;
            self.cells[at].clusters[corner] = *self.cluster_of.entry(corner_node).or_insert_with(|| {
                let middle = &middles[corner];
                let first = points.len();
                grid.visit_around(middle, radius, |point, x| {
                    if distance_squared(x, middle) < radius * radius {
                        points.push(point as u32);
                    }
                });
                points[first..].sort_unstable();
                starts.push(points.len());
                starts.len() as u32 - 2
            });
        }
        debug_assert!(positions.len() < NONE as usize);
    }

    /// Merges the points of the clusters around a cell.
    fn unite(&mut self, at: usize, pad: usize) {
        let Self { cells, points, starts, union, union_corners, slots, .. } = self;
        let cell = &mut cells[at];
        let first = union.len();
        let mut lists: [&[u32]; CORNERS] = [&[]; CORNERS];
        let mut next = [0; CORNERS];
        let mut corners = 0;
        for corner in 0..CORNERS {
            cell.slots[corner] = slots.len() as u32;
            if cell.clusters[corner] != NONE {
                let cluster = cell.clusters[corner] as usize;
                lists[corner] = &points[starts[cluster]..starts[cluster + 1]];
                next[corner] = slots.len();
                slots.resize(slots.len() + lists[corner].len().next_multiple_of(pad), 0);
                corners = corner + 1;
            }
        }
        let ends: [usize; CORNERS] = std::array::from_fn(|corner| next[corner] + lists[corner].len());
        let mut heads: [u32; CORNERS] = std::array::from_fn(|corner| *lists[corner].first().unwrap_or(&NONE));
        loop {
            let least = heads[..corners].iter().fold(NONE, |least, head| least.min(*head));
            if least == NONE {
                break;
            }
            let slot = (union.len() - first) as u32;
            let mut members = 0;
            for corner in 0..corners {
                if heads[corner] == least {
                    slots[next[corner]] = slot;
                    next[corner] += 1;
                    let (_, rest) = lists[corner].split_first().expect("its head is the least");
                    lists[corner] = rest;
                    heads[corner] = *rest.first().unwrap_or(&NONE);
                    members |= 1 << corner;
                }
            }
            union.push(least);
            union_corners.push(members);
        }
        cell.union = first..union.len();
        // Behind a cluster's last point the slot behind the union's last.
        for corner in 0..CORNERS {
            if cell.clusters[corner] != NONE {
                let end = ends[corner].wrapping_sub(cell.slots[corner] as usize).next_multiple_of(pad);
                slots[ends[corner]..cell.slots[corner] as usize + end].fill((union.len() - first) as u32);
            }
        }
    }

    /// Lengths of the rows of a cell's targets.
    fn count(&mut self, at: usize) {
        let cell = &self.cells[at];
        let corners = &self.union_corners[cell.union.clone()];
        for slot in cell.targets.clone() {
            let inside = self.inside[slot];
            let length = corners.iter().fold(0, |sum, corners| sum + u32::from(corners & inside != 0));
            self.lengths[self.order[slot] as usize] = length;
        }
    }
}
