//! The arithmetic of radial basis functions on one cluster, eight numbers at a time.
//!
//! Arrays over a cluster's points are filled up with zeros to a multiple of [`LANES`], which is their stride.

use super::semidefinite::solve;
use pulp::NullaryFnOnce;

/// Numbers worked on at once.
pub(super) const LANES: usize = 8;

/// Wendland's C² function, positive definite in up to three dimensions.
#[inline(always)]
pub(super) fn wendland_c2(q: f64) -> f64 {
    let rest = if q < 1.0 { 1.0 - q } else { 0.0 };
    (rest * rest) * (rest * rest) * (4.0 * q + 1.0)
}

/// Inverts the symmetric positive definite matrix of `count` rows of that stride in place; else the row whose pivot is lost in rounding.
pub(super) fn invert(a: &mut [f64], count: usize, stride: usize) -> Result<(), usize> {
    pulp::Arch::new().dispatch(Invert { a, count, stride })
}

struct Invert<'a> {
    a: &'a mut [f64],
    count: usize,
    stride: usize,
}

impl NullaryFnOnce for Invert<'_> {
    type Output = Result<(), usize>;

    /// Gauss and Jordan's elimination, without exchanges, which a positive definite matrix does not need. Its pivots are those of Cholesky's factors, squared.
    #[inline(always)]
    fn call(self) -> Result<(), usize> {
        /// Rounding errors of a pivot, of a matrix with ones on its diagonal.
        const LOST: f64 = 1e-13;
        let Self { a, count, stride } = self;
        for k in 0..count {
            let (above, rest) = a.split_at_mut(k * stride);
            let (pivot_row, below) = rest.split_at_mut(stride);
            if pivot_row[k] <= LOST {
                return Err(k);
            }
            let inverse = 1.0 / pivot_row[k];
            pivot_row[k] = 1.0;
            for x in pivot_row.iter_mut() {
                *x *= inverse;
            }
            for row in above.chunks_exact_mut(stride).chain(below.chunks_exact_mut(stride)) {
                let factor = std::mem::replace(&mut row[k], 0.0);
                for (x, y) in row.iter_mut().zip(&*pivot_row) {
                    *x -= factor * y;
                }
            }
        }
        Ok(())
    }
}

/// A cluster of source points as a target sees it.
#[derive(Clone, Copy)]
pub(super) struct Basis<'a, const D: usize> {
    /// Positions from the cluster's mean (m), `D` arrays.
    pub places: [&'a [f64]; D],
    /// One for each point, and zeros behind.
    pub points: &'a [f64],
    /// How many points there are.
    pub count: usize,
    /// `Φ⁻¹`, a row a point.
    pub inverse: &'a [f64],
    /// `Σ d dᵀ` of the positions from the mean.
    pub spread: [[f64; D]; D],
    /// Distance (m) at which a function is zero.
    pub support: f64,
}

/// What a cluster's weights leave to be wished for.
pub(super) struct Quality<const D: usize> {
    /// `1 − Σ w`.
    pub one: f64,
    /// `x − Σ w xᵢ` (m).
    pub linear: [f64; D],
    /// `Σ |w|`.
    pub amplification: f64,
}

impl<const D: usize> Basis<'_, D> {
    /// Fills in the weights for a target at `x` from the cluster's mean (m); `values` is scratch. Both have the stride of the cluster's arrays.
    pub fn weigh(&self, x: &[f64; D], values: &mut [f64], weights: &mut [f64]) -> Quality<D> {
        let arch = pulp::Arch::new();
        arch.dispatch(Values { basis: *self, x, values });
        arch.dispatch(Product { inverse: self.inverse, values: &values[..self.count], product: weights });
        // Once for the polynomial, once more for the rounding of the first.
        for _ in 0..2 {
            let Quality { one, linear, .. } = self.quality(x, weights);
            let gradient = solve(self.spread, linear);
            arch.dispatch(Correct { basis: *self, one: one / self.count as f64, gradient, weights });
        }
        self.quality(x, weights)
    }

    fn quality(&self, x: &[f64; D], weights: &[f64]) -> Quality<D> {
        let Sums { weight, moment, size } = pulp::Arch::new().dispatch(Gather { basis: *self, weights });
        let sum = |lanes: &[f64; LANES]| -> f64 {
            let [a, b, c, d, e, f, g, h] = *lanes;
            ((a + e) + (c + g)) + ((b + f) + (d + h))
        };
        let mut linear = *x;
        for (linear, moment) in linear.iter_mut().zip(&moment) {
            *linear -= sum(moment);
        }
        Quality { one: 1.0 - sum(&weight), linear, amplification: sum(&size) }
    }
}

/// `φ(|x − xᵢ|)`.
struct Values<'a, const D: usize> {
    basis: Basis<'a, D>,
    x: &'a [f64; D],
    values: &'a mut [f64],
}

impl<const D: usize> NullaryFnOnce for Values<'_, D> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { basis: Basis { places, points, support, .. }, x, values } = self;
        let places = places.map(|places| &places[..values.len()]);
        for (i, (value, point)) in values.iter_mut().zip(points).enumerate() {
            let mut squared = 0.0;
            for c in 0..D {
                squared += (places[c][i] - x[c]) * (places[c][i] - x[c]);
            }
            *value = point * wendland_c2(squared.sqrt() / support);
        }
    }
}

/// `Σⱼ valueⱼ rowⱼ`.
struct Product<'a> {
    inverse: &'a [f64],
    values: &'a [f64],
    product: &'a mut [f64],
}

impl NullaryFnOnce for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { inverse, values, product } = self;
        let stride = product.len();
        let mut column = 0;
        while column < stride {
            let left = (stride - column) / LANES;
            let place = &mut product[column..];
            let from = &inverse[column..];
            column += LANES
                * match left {
                    0..=2 => columns::<1>(from, stride, values, place),
                    3 => columns::<3>(from, stride, values, place),
                    4 => columns::<4>(from, stride, values, place),
                    5 => columns::<5>(from, stride, values, place),
                    _ => columns::<6>(from, stride, values, place),
                };
        }
    }
}

/// The first `B` times [`LANES`] columns of the product; gives `B`.
#[inline(always)]
fn columns<const B: usize>(inverse: &[f64], stride: usize, values: &[f64], product: &mut [f64]) -> usize {
    let mut sums = [[0.0; LANES]; B];
    for (j, value) in values.iter().enumerate() {
        let row = &inverse[j * stride..][..B * LANES].as_chunks::<LANES>().0[..B];
        for b in 0..B {
            for lane in 0..LANES {
                sums[b][lane] += value * row[b][lane];
            }
        }
    }
    product[..B * LANES].copy_from_slice(sums.as_flattened());
    B
}

/// Adds `one` and the linear function of that gradient.
struct Correct<'a, const D: usize> {
    basis: Basis<'a, D>,
    one: f64,
    gradient: [f64; D],
    weights: &'a mut [f64],
}

impl<const D: usize> NullaryFnOnce for Correct<'_, D> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { basis: Basis { places, points, .. }, one, gradient, weights } = self;
        let places = places.map(|places| &places[..weights.len()]);
        for (i, (weight, point)) in weights.iter_mut().zip(points).enumerate() {
            let mut more = one;
            for c in 0..D {
                more += places[c][i] * gradient[c];
            }
            *weight += point * more;
        }
    }
}

/// Sums over the points, some lanes each.
struct Sums<const D: usize> {
    weight: [f64; LANES],
    moment: [[f64; LANES]; D],
    size: [f64; LANES],
}

/// Sums of weights, of weights times positions, and of their sizes.
struct Gather<'a, const D: usize> {
    basis: Basis<'a, D>,
    weights: &'a [f64],
}

impl<const D: usize> NullaryFnOnce for Gather<'_, D> {
    type Output = Sums<D>;

    #[inline(always)]
    fn call(self) -> Sums<D> {
        let weights = self.weights.as_chunks::<LANES>().0;
        let places = self.basis.places.map(|places| &places.as_chunks::<LANES>().0[..weights.len()]);
        let zero = [0.0; LANES];
        let mut sums = Sums { weight: zero, moment: [zero; D], size: zero };
        for (i, weights) in weights.iter().enumerate() {
            for lane in 0..LANES {
                sums.weight[lane] += weights[lane];
                sums.size[lane] += weights[lane].abs();
                for c in 0..D {
                    sums.moment[c][lane] += weights[lane] * places[c][i][lane];
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::super::semidefinite::dot;
    use super::*;

    #[test]
    fn inverts_by_hand() {
        // [[4, 2], [2, 2]], whose inverse is [[0.5, -0.5], [-0.5, 1]].
        let mut a = [0.0; 2 * LANES];
        (a[0], a[1], a[LANES], a[LANES + 1]) = (4.0, 2.0, 2.0, 2.0);
        assert_eq!(invert(&mut a, 2, LANES), Ok(()));
        assert_eq!([a[0], a[1], a[LANES], a[LANES + 1]], [0.5, -0.5, -0.5, 1.0]);
        assert!(a[2..LANES].iter().chain(&a[LANES + 2..]).all(|zero| *zero == 0.0));
        let mut singular = [0.0; 2 * LANES];
        (singular[0], singular[1], singular[LANES], singular[LANES + 1]) = (1.0, 1.0, 1.0, 1.0);
        assert_eq!(invert(&mut singular, 2, LANES), Err(1));
    }

    #[test]
    fn wendlands_function_by_hand() {
        assert_eq!(wendland_c2(0.0), 1.0);
        assert_eq!(wendland_c2(0.5), 3.0 / 16.0);
        assert_eq!([wendland_c2(1.0), wendland_c2(7.0)], [0.0, 0.0]);
    }

    /// Products of any number of points, against sums one by one of numbers of few bits, which are exact in any order.
    #[test]
    fn products_are_those_of_any_stride() {
        for stride in (1..12).map(|k| k * LANES) {
            let count = stride - 3;
            let inverse: Vec<f64> = (0..count * stride).map(|i| ((i * 7) % 11) as f64 - 5.0).collect();
            let values: Vec<f64> = (0..count).map(|i| ((i * 5) % 13) as f64).collect();
            let mut product = vec![f64::NAN; stride];
            pulp::Arch::new().dispatch(Product { inverse: &inverse, values: &values, product: &mut product });
            for column in 0..stride {
                let sum: f64 = (0..count).map(|j| values[j] * inverse[j * stride + column]).sum();
                assert_eq!(product[column], sum);
            }
        }
    }

    /// Four points in a square reproduce a linear field wherever the target is.
    #[test]
    fn weights_are_consistent() {
        let places: [[f64; LANES]; 2] =
            [[-1.0, 1.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0], [-1.0, -1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]];
        let points = [1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0];
        let mut inverse = [0.0; 4 * LANES];
        for i in 0..4 {
            for j in 0..4 {
                let off = std::array::from_fn(|c| places[c][i] - places[c][j]);
                inverse[i * LANES + j] = wendland_c2(dot::<2>(&off, &off).sqrt() / 8.0);
            }
        }
        invert(&mut inverse, 4, LANES).unwrap();
        let basis = Basis {
            places: [&places[0][..], &places[1][..]],
            points: &points,
            count: 4,
            inverse: &inverse,
            spread: [[4.0, 0.0], [0.0, 4.0]],
            support: 8.0,
        };
        let (mut values, mut weights) = ([0.0; LANES], [0.0; LANES]);
        let quality = basis.weigh(&[0.3, -0.4], &mut values, &mut weights);
        // Rounding of a handful of sums.
        assert!(quality.one.abs() < 1e-15 && quality.linear.iter().all(|x| x.abs() < 1e-15));
        assert!((1.0..4.0).contains(&quality.amplification) && weights[4..] == [0.0; 4]);
        // At a point, its own value.
        basis.weigh(&[1.0, -1.0], &mut values, &mut weights);
        assert!((weights[1] - 1.0).abs() < 1e-13 && weights[0].abs() < 1e-13, "{weights:?}");
    }
}
