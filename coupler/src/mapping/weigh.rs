//! Weights of the targets in one cell: `W` groups of eight targets at once, a lane each.
//!
//! Lengths are in radii, from a corner of the cell. The functions are evaluated once for the union of the
//! source points of the cell's clusters.

use super::factors::{BLOCK, offset, wendland_c2};
use super::lanes::{LANES, Lanes};
use pulp::NullaryFnOnce;

/// Support of the basis functions over the radius of a cluster. On points scattered about a lattice the error
/// at 4 was half of that at 2, and at 8 a third less again, as a matrix that is harder to invert. No target
/// is further than that from a point of a cluster that it is near.
pub(super) const SUPPORT: f64 = 4.0;
/// Largest `Σ |w|` of a cluster. Two source points much nearer to each other than to the rest share large
/// weights of opposite sign, which do no harm to smooth fields: up to 60 were met in clouds of random points.
const AMPLIFICATION: f64 = 256.0;
/// Largest `|x − Σ w xᵢ|` and `|1 − Σ w|`: rounding of sums of a hundred terms stays below, a target off a
/// plane of sources far above.
const INCONSISTENCY: f64 = 1e-11;
/// Above this they are corrected once more: some times the rounding of sums of some dozen terms of order one.
const ROUNDING: f64 = 2e-15;

/// What a cluster's weights are worked out from.
#[derive(Clone, Copy)]
pub(super) struct Cluster<'a, const D: usize> {
    /// How many points it has.
    pub count: usize,
    /// `L` and `D⁻¹`, see [`super::factors`].
    pub factors: &'a [f64],
    pub inverse_pivots: &'a [f64],
    /// Positions from the mean, and the mean from the corner of the cell.
    pub places: &'a [[f64; D]],
    pub mean: [f64; D],
    /// A generalised inverse of `Σ d dᵀ` of the positions from the mean.
    pub inverse_spread: [[f64; D]; D],
    /// Its points in the union: a whole number of blocks, filled up with the one behind the last.
    pub slots: &'a [u32],
    /// The middle of its ball.
    pub middle: [f64; D],
    /// One for targets in its ball.
    pub inside: [u8; 16],
}

/// `W` groups of targets, to be weighed by one cluster after the other.
pub(super) struct Weigh<'a, const D: usize, const W: usize> {
    pub cluster: Cluster<'a, D>,
    /// The targets.
    pub targets: &'a [[Lanes; W]; D],
    /// `φ` at the points of the union.
    pub values: &'a [[Lanes; W]],
    /// Scratch: unknowns of the cluster.
    pub unknowns: &'a mut [[Lanes; W]],
    /// Takes `φ(|x − c_k|) w` at the points of the union.
    pub sums: &'a mut [[Lanes; W]],
    /// Takes `φ(|x − c_k|)`.
    pub total: &'a mut [Lanes; W],
}

/// `φ` of targets at the points of a union.
pub(super) struct Values<'a, const D: usize, const W: usize> {
    pub targets: &'a [[Lanes; W]; D],
    pub places: &'a [[f64; D]],
    pub values: &'a mut [[Lanes; W]],
}

impl<const D: usize, const W: usize> NullaryFnOnce for Values<'_, D, W> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (value, place) in self.values.iter_mut().zip(self.places) {
            for w in 0..W {
                let mut squared = Lanes::ZERO;
                for c in 0..D {
                    let off = self.targets[c][w] - Lanes::splat(place[c]);
                    squared += off * off;
                }
                value[w] = squared.map(|s| wendland_c2(s.sqrt() * (1.0 / SUPPORT)));
            }
        }
    }
}

/// `1 − Σ w`, `x − Σ w xᵢ` and `Σ |w|`.
struct Quality<const D: usize, const W: usize> {
    one: [Lanes; W],
    linear: [[Lanes; W]; D],
    amplification: [Lanes; W],
}

impl<const D: usize, const W: usize> Weigh<'_, D, W> {
    /// The target's positions from the cluster's mean.
    #[inline(always)]
    fn nothing_yet(&self) -> Quality<D, W> {
        let mut linear = *self.targets;
        for c in 0..D {
            for w in 0..W {
                linear[c][w] -= Lanes::splat(self.cluster.mean[c]);
            }
        }
        Quality { one: [Lanes::splat(1.0); W], linear, amplification: [Lanes::ZERO; W] }
    }

    /// `L y = φ(x)`.
    #[inline(always)]
    fn forwards(&mut self) {
        for block in 0..self.cluster.slots.len() / BLOCK {
            let columns = self.cluster.factors[offset(block)..offset(block + 1)].as_chunks::<BLOCK>().0;
            let (known, unknown) = self.unknowns.split_at_mut(BLOCK * block);
            let mut sums = [[Lanes::ZERO; W]; BLOCK];
            for r in 0..BLOCK {
                sums[r] = self.values[self.cluster.slots[BLOCK * block + r] as usize];
            }
            for (y, l) in known.iter().zip(columns) {
                for r in 0..BLOCK {
                    for w in 0..W {
                        sums[r][w] -= y[w] * l[r];
                    }
                }
            }
            let triangle = &columns[BLOCK * block..][..BLOCK];
            eliminate::<W, 1, 0>(&mut sums, triangle[0][1]);
            eliminate::<W, 2, 0>(&mut sums, triangle[0][2]);
            eliminate::<W, 3, 0>(&mut sums, triangle[0][3]);
            eliminate::<W, 2, 1>(&mut sums, triangle[1][2]);
            eliminate::<W, 3, 1>(&mut sums, triangle[1][3]);
            eliminate::<W, 3, 2>(&mut sums, triangle[2][3]);
            unknown[..BLOCK].copy_from_slice(&sums);
        }
    }

    /// `Lᵀ w = D⁻¹ y`.
    #[inline(always)]
    fn backwards(&mut self) {
        let blocks = self.cluster.slots.len() / BLOCK;
        for block in (0..blocks).rev() {
            let (unknown, known) = self.unknowns.split_at_mut(BLOCK * (block + 1));
            let unknown = &mut unknown[BLOCK * block..];
            let mut sums = [[Lanes::ZERO; W]; BLOCK];
            for r in 0..BLOCK {
                for w in 0..W {
                    sums[r][w] = unknown[r][w] * self.cluster.inverse_pivots[BLOCK * block + r];
                }
            }
            let below = self.cluster.factors[offset(block + 1)..].as_chunks::<BLOCK>().0;
            let mut at = 0;
            for (k, known) in known.as_chunks::<BLOCK>().0.iter().enumerate() {
                let columns = &below[at + BLOCK * block..][..BLOCK];
                for (j, known) in known.iter().enumerate() {
                    for r in 0..BLOCK {
                        for w in 0..W {
                            sums[r][w] -= known[w] * columns[r][j];
                        }
                    }
                }
                at += BLOCK * (block + 2 + k);
            }
            let triangle =
                &self.cluster.factors[offset(block)..].as_chunks::<BLOCK>().0[BLOCK * block..][..BLOCK];
            eliminate::<W, 2, 3>(&mut sums, triangle[2][3]);
            eliminate::<W, 1, 3>(&mut sums, triangle[1][3]);
            eliminate::<W, 0, 3>(&mut sums, triangle[0][3]);
            eliminate::<W, 1, 2>(&mut sums, triangle[1][2]);
            eliminate::<W, 0, 2>(&mut sums, triangle[0][2]);
            eliminate::<W, 0, 1>(&mut sums, triangle[0][1]);
            unknown[..BLOCK].copy_from_slice(&sums);
        }
    }

    #[inline(always)]
    fn quality(&self) -> Quality<D, W> {
        let mut quality = self.nothing_yet();
        for (weight, place) in self.unknowns.iter().zip(self.cluster.places) {
            quality.take(weight, place);
        }
        quality
    }

    /// Adds to the weights what leaves nothing of that to be wished for; and what then is.
    #[inline(always)]
    fn correct(&mut self, wanted: &Quality<D, W>) -> Quality<D, W> {
        let inverse_spread = &self.cluster.inverse_spread;
        let mut gradient = [[Lanes::ZERO; W]; D];
        for c in 0..D {
            for e in 0..D {
                for w in 0..W {
                    gradient[c][w] += wanted.linear[e][w] * inverse_spread[c][e];
                }
            }
        }
        let mut one = wanted.one;
        for w in 0..W {
            one[w] = one[w] * (1.0 / self.cluster.count as f64);
        }
        let mut quality = self.nothing_yet();
        for (weight, place) in self.unknowns.iter_mut().zip(self.cluster.places) {
            for w in 0..W {
                let mut more = one[w];
                for c in 0..D {
                    more += gradient[c][w] * place[c];
                }
                weight[w] += more;
            }
            quality.take(weight, place);
        }
        quality
    }
}

/// Takes the part of unknown `FROM` out of row `ROW` of a block. (By hand, as loops over a triangle are not
/// unrolled, and sums then not kept in registers.)
#[inline(always)]
fn eliminate<const W: usize, const ROW: usize, const FROM: usize>(sums: &mut [[Lanes; W]; BLOCK], l: f64) {
    for w in 0..W {
        let less = sums[FROM][w] * l;
        sums[ROW][w] -= less;
    }
}

impl<const D: usize, const W: usize> Quality<D, W> {
    #[inline(always)]
    fn take(&mut self, weight: &[Lanes; W], place: &[f64; D]) {
        for w in 0..W {
            self.one[w] -= weight[w];
            self.amplification[w] += weight[w].map(f64::abs);
            for c in 0..D {
                self.linear[c][w] -= weight[w] * place[c];
            }
        }
    }

    /// The larger of `|1 − Σ w|` and the root of the sum of squares of `x − Σ w xᵢ`, squared.
    #[inline(always)]
    fn inconsistency_squared(&self, w: usize) -> Lanes {
        let mut squared = Lanes::ZERO;
        for c in 0..D {
            squared += self.linear[c][w] * self.linear[c][w];
        }
        for lane in 0..LANES {
            let one = self.one[w].0[lane] * self.one[w].0[lane];
            squared.0[lane] = if one > squared.0[lane] { one } else { squared.0[lane] };
        }
        squared
    }

    /// Sets to zero what is but rounding; whether there is more.
    #[inline(always)]
    fn keep_errors(&mut self) -> bool {
        let mut any = false;
        for w in 0..W {
            let squared = self.inconsistency_squared(w);
            for lane in 0..LANES {
                let wrong = squared.0[lane] > ROUNDING * ROUNDING;
                any |= wrong;
                let keep = if wrong { 1.0 } else { 0.0 };
                self.one[w].0[lane] *= keep;
                for c in 0..D {
                    self.linear[c][w].0[lane] *= keep;
                }
            }
        }
        any
    }
}

impl<const D: usize, const W: usize> NullaryFnOnce for Weigh<'_, D, W> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        self.forwards();
        self.backwards();
        let wanted = self.quality();
        let mut quality = self.correct(&wanted);
        // The polynomial is exact to the rounding of the correction, which is large where the functions left
        // much.
        if quality.keep_errors() {
            quality = self.correct(&quality);
        }
        let mut share = [Lanes::ZERO; W];
        for w in 0..W {
            let mut squared = Lanes::ZERO;
            for c in 0..D {
                let off = self.targets[c][w] - Lanes::splat(self.cluster.middle[c]);
                squared += off * off;
            }
            let inconsistency = quality.inconsistency_squared(w);
            for lane in 0..LANES {
                let q = squared.0[lane].sqrt();
                let inside = f64::from(self.cluster.inside[LANES * w + lane]);
                let good = inconsistency.0[lane] <= INCONSISTENCY * INCONSISTENCY
                    && quality.amplification[w].0[lane] <= AMPLIFICATION;
                let phi = if q < 1.0 { wendland_c2(q) } else { 0.0 };
                share[w].0[lane] = if good { inside * phi } else { 0.0 };
            }
            self.total[w] += share[w];
        }
        for (weight, &slot) in self.unknowns[..self.cluster.count].iter().zip(self.cluster.slots) {
            let sum = &mut self.sums[slot as usize];
            for w in 0..W {
                sum[w] += share[w] * weight[w];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::factors::Factorise;
    use super::*;

    /// Four points in a square, the union of one cluster, and targets about them.
    #[test]
    fn weights_are_consistent() {
        const PLACES: [[f64; 2]; 4] = [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]];
        let lanes = PLACES.map(|place| place.map(|c| Lanes::splat(c / SUPPORT)));
        let mut factors = [Lanes::ZERO; 16];
        let mut inverse_pivots = [Lanes::ZERO; 4];
        let lost = Factorise {
            places: &lanes,
            present: &[Lanes::splat(1.0); 4],
            factors: &mut factors,
            inverse_pivots: &mut inverse_pivots,
        }
        .run();
        assert_eq!(lost, [None; LANES]);
        // The last is outside the ball, and the one before it inside but not asked for.
        let x = Lanes([0.3, -0.5, 0.0, 0.1, 0.5, 0.4, 0.2, 2.0]);
        let y = Lanes([-0.4, -0.5, 0.0, 0.7, 0.5, -0.1, 0.2, 0.0]);
        let targets = [[x], [y]];
        let mut values = [[Lanes::ZERO]; 5];
        let arch = pulp::Arch::new();
        arch.dispatch(Values { targets: &targets, places: &PLACES, values: &mut values[..4] });
        let (mut unknowns, mut sums, mut total) = ([[Lanes::ZERO]; 4], [[Lanes::ZERO]; 4], [Lanes::ZERO]);
        let cluster = Cluster {
            count: 4,
            factors: &factors.map(|lanes| lanes.0[0]),
            inverse_pivots: &inverse_pivots.map(|lanes| lanes.0[0]),
            places: &PLACES,
            mean: [0.0; 2],
            inverse_spread: [[1.0, 0.0], [0.0, 1.0]],
            slots: &[0, 1, 2, 3],
            middle: [0.0; 2],
            inside: [1, 1, 1, 1, 1, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0],
        };
        let (unknowns, total) = (&mut unknowns, &mut total);
        arch.dispatch(Weigh {
            cluster,
            targets: &targets,
            values: &values,
            unknowns,
            sums: &mut sums,
            total,
        });
        for lane in 0..LANES {
            let distance = (x.0[lane].powi(2) + y.0[lane].powi(2)).sqrt();
            let phi = if lane < 6 { wendland_c2(distance) } else { 0.0 };
            let weights = sums.map(|[sum]| sum.0[lane]);
            let sum = |f: &dyn Fn(usize) -> f64| (0..4).map(|k| weights[k] * f(k)).sum::<f64>();
            // Rounding of a handful of sums.
            assert!((total[0].0[lane] - phi).abs() < 1e-15);
            assert!((sum(&|_| 1.0) - phi).abs() < 2e-15);
            assert!((sum(&|k| PLACES[k][0]) - phi * x.0[lane]).abs() < 2e-15);
            assert!((sum(&|k| PLACES[k][1]) - phi * y.0[lane]).abs() < 2e-15);
        }
        // At a point, its own value.
        let at_first = sums.map(|[sum]| sum.0[1] / total[0].0[1]);
        assert!((at_first[0] - 1.0).abs() < 1e-13 && at_first[3].abs() < 1e-13, "{at_first:?}");
    }
}
