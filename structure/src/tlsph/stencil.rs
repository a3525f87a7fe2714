//! Neighbours and their weights, slice by slice of [`LANES`] particles.
//!
//! Where the particles of a slice have their neighbours at the same distances in the internal order
//! (lattices, also jittered), an entry is one offset, and the neighbours of the slice are one run in memory;
//! a lane without that neighbour has weight zero there. Elsewhere an entry is one index per lane. Slices that
//! look alike (all inside a lattice) share one set of weights.

use crate::lanes::LANES;
use std::collections::HashMap;
use std::ops::Range;

/// Offsets that a slice may need beyond its longest list before indices per lane are the better choice: half
/// as many again.
const RUN_EXCESS: f64 = 1.5;

/// Reference differences equal to this fraction of the spacing count as the same pattern: far over round-off
/// of coordinates, far under any real difference.
const PATTERN_RESOLUTION: f64 = 1e-9;

/// Neighbours of one slice.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slice {
    /// First entry and one past the last, in `offsets` or in `indices`.
    pub entries: (u32, u32),
    /// Where the weights start, `K LANES` of them per entry.
    pub weights: usize,
    /// Where the constants of the slice's particles start, `LANES` of them each.
    pub constants: usize,
    /// Whether entries are runs.
    pub runs: bool,
}

/// Neighbours of all slices.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stencil {
    pub slices: Vec<Slice>,
    /// Runs: internal index of the neighbour less that of the particle.
    pub offsets: Vec<i32>,
    /// Elsewhere: internal index of the neighbour of each lane.
    pub indices: Vec<[u32; LANES]>,
    pub weights: Vec<f64>,
    pub constants: Vec<f64>,
    /// Runs reach at most so far past either end.
    pub margin: usize,
}

/// What one gradient operator puts on each pair and each particle.
pub(crate) trait PairOperator {
    /// Weights per pair.
    const WEIGHTS: usize;
    /// Writes the weights of the pair `(a, b)`, internal indices, to `out`.
    fn weights(&self, a: usize, b: usize, out: &mut [f64]);
    /// Number of constants per particle.
    fn constants(&self) -> usize;
    /// Writes the constants of particle `a` with the neighbours given, or returns `false` where these do not
    /// suffice.
    fn write_constants(&self, a: usize, neighbours: &[u32], out: &mut [f64]) -> bool;
    /// What the weights of the pair and the constants depend on, in units of the spacing.
    fn features(&self, a: usize, b: usize, out: &mut Vec<f64>);
}

impl Stencil {
    /// Adds the slices of one body, of which `rows[a − first]` are the neighbours of the internal particle
    /// `a` (empty for fillers). Gives the internal index of a particle whose neighbours do not suffice as
    /// error.
    pub fn push<O: PairOperator>(
        &mut self,
        slices: Range<usize>,
        rows: &[Vec<u32>],
        operator: &O,
    ) -> Result<(), usize> {
        let mut known: HashMap<Vec<i64>, Slice> = HashMap::new();
        for s in slices.clone() {
            let lanes: [&[u32]; LANES] =
                std::array::from_fn(|l| rows[(s - slices.start) * LANES + l].as_slice());
            let slice = match common_offsets(s, &lanes) {
                Some(offsets) => {
                    let key = pattern(s, &lanes, &offsets, operator);
                    match known.get(&key) {
                        Some(&slice) => slice,
                        None => {
                            let slice = self.push_runs(s, &lanes, &offsets, operator)?;
                            known.insert(key, slice);
                            slice
                        }
                    }
                }
                None => self.push_indices(s, &lanes, operator)?,
            };
            self.slices.push(slice);
        }
        Ok(())
    }

    fn push_runs<O: PairOperator>(
        &mut self,
        s: usize,
        lanes: &[&[u32]; LANES],
        offsets: &[i32],
        operator: &O,
    ) -> Result<Slice, usize> {
        let first = self.offsets.len() as u32;
        let weights = self.weights.len();
        for &offset in offsets {
            self.offsets.push(offset);
            self.margin = self.margin.max(offset.unsigned_abs() as usize);
            let at = self.weights.len();
            self.weights.resize(at + O::WEIGHTS * LANES, 0.0);
            for l in 0..LANES {
                let a = s * LANES + l;
                let b = a as i64 + i64::from(offset);
                if lanes[l].iter().any(|&n| i64::from(n) == b) {
                    self.write_weights(at, l, a, b as usize, operator);
                }
            }
        }
        let constants = self.push_constants(s, lanes, operator)?;
        Ok(Slice { entries: (first, self.offsets.len() as u32), weights, constants, runs: true })
    }

    fn push_indices<O: PairOperator>(
        &mut self,
        s: usize,
        lanes: &[&[u32]; LANES],
        operator: &O,
    ) -> Result<Slice, usize> {
        let first = self.indices.len() as u32;
        let weights = self.weights.len();
        let longest = lanes.iter().map(|n| n.len()).max().unwrap_or(0);
        for e in 0..longest {
            let at = self.weights.len();
            self.weights.resize(at + O::WEIGHTS * LANES, 0.0);
            let mut neighbours = [0; LANES];
            for l in 0..LANES {
                let a = s * LANES + l;
                neighbours[l] = a as u32;
                if let Some(&b) = lanes[l].get(e) {
                    neighbours[l] = b;
                    self.write_weights(at, l, a, b as usize, operator);
                }
            }
            self.indices.push(neighbours);
        }
        let constants = self.push_constants(s, lanes, operator)?;
        Ok(Slice { entries: (first, self.indices.len() as u32), weights, constants, runs: false })
    }

    fn write_weights<O: PairOperator>(&mut self, at: usize, lane: usize, a: usize, b: usize, operator: &O) {
        let mut pair = vec![0.0; O::WEIGHTS];
        operator.weights(a, b, &mut pair);
        for (k, w) in pair.into_iter().enumerate() {
            self.weights[at + k * LANES + lane] = w;
        }
    }

    fn push_constants<O: PairOperator>(
        &mut self,
        s: usize,
        lanes: &[&[u32]; LANES],
        operator: &O,
    ) -> Result<usize, usize> {
        let (start, count) = (self.constants.len(), operator.constants());
        self.constants.resize(start + count * LANES, 0.0);
        let mut own = vec![0.0; count];
        for l in 0..LANES {
            own.fill(0.0);
            if !operator.write_constants(s * LANES + l, lanes[l], &mut own) {
                return Err(s * LANES + l);
            }
            for (k, &c) in own.iter().enumerate() {
                self.constants[start + k * LANES + l] = c;
            }
        }
        Ok(start)
    }
}

/// The offsets that serve all lanes, ascending, if these are few enough.
fn common_offsets(s: usize, lanes: &[&[u32]; LANES]) -> Option<Vec<i32>> {
    let mut offsets: Vec<i32> = Vec::new();
    let mut longest = 0;
    for (l, neighbours) in lanes.iter().enumerate() {
        longest = longest.max(neighbours.len());
        let a = (s * LANES + l) as i64;
        offsets.extend(neighbours.iter().map(|&b| (i64::from(b) - a) as i32));
    }
    offsets.sort_unstable();
    offsets.dedup();
    (offsets.len() as f64 <= RUN_EXCESS * longest as f64 + 2.0).then_some(offsets)
}

/// The rounded features of a slice: slices with equal ones share their weights.
fn pattern<O: PairOperator>(s: usize, lanes: &[&[u32]; LANES], offsets: &[i32], operator: &O) -> Vec<i64> {
    let mut key: Vec<i64> = offsets.iter().map(|&o| i64::from(o)).collect();
    let mut features = Vec::new();
    for l in 0..LANES {
        let a = s * LANES + l;
        features.clear();
        operator.features(a, a, &mut features);
        key.push(i64::MIN + lanes[l].len() as i64);
        for &b in lanes[l] {
            key.push(i64::from(b) - a as i64);
            operator.features(a, b as usize, &mut features);
        }
        key.extend(features.iter().map(|f| (f / PATTERN_RESOLUTION).round() as i64));
    }
    key
}
