//! Sums over flat vectors, at the width that the machine has.
//!
//! Partial sums are as many whatever the machine, and added in an order that depends on the length alone:
//! results are the same to the bit everywhere.
//!
//! Work of more than a line is a structure with a `call`, not a closure: a closure is called through a shim
//! that the compiler does not always merge with the code for the machine at hand, and then runs at the width
//! that all machines have. And what adds up partial sums in the end stands outside of it: seen together, the
//! compiler works two numbers at a time throughout.

use pulp::NullaryFnOnce;

/// Partial sums of a product.
const LANES: usize = 16;

/// `a · b`.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let [sum] = dots(a, [b]);
    sum
}

/// `a · bᵢ` for each `bᵢ`, all of one length, in one pass over `a`.
pub fn dots<const K: usize>(a: &[f64], b: [&[f64]; K]) -> [f64; K] {
    let b = b.map(|b| &b[..a.len()]);
    let partial = pulp::Arch::new().dispatch(PartialDots { a, b });
    let summed = a.len() / LANES * LANES;
    std::array::from_fn(|k| {
        let rest: f64 = a[summed..].iter().zip(&b[k][summed..]).map(|(a, b)| a * b).sum();
        folded(&partial[k]) + rest
    })
}

struct PartialDots<'a, const K: usize> {
    a: &'a [f64],
    b: [&'a [f64]; K],
}

impl<const K: usize> NullaryFnOnce for PartialDots<'_, K> {
    type Output = [[f64; LANES]; K];

    #[inline(always)]
    fn call(self) -> [[f64; LANES]; K] {
        let chunks = self.b.map(|b| b.as_chunks::<LANES>().0);
        let mut sums = [[0.0; LANES]; K];
        for (at, head) in self.a.as_chunks::<LANES>().0.iter().enumerate() {
            for k in 0..K {
                let other = &chunks[k][at];
                for lane in 0..LANES {
                    sums[k][lane] += head[lane] * other[lane];
                }
            }
        }
        sums
    }
}

/// The sum of partial sums, halves upon halves.
pub fn folded(sums: &[f64; LANES]) -> f64 {
    let mut sums = *sums;
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            sums[lane] += sums[lane + half];
        }
        half /= 2;
    }
    sums[0]
}

/// `x ← y − Σ cᵢ wᵢ`, in pieces that stay in the fastest memory while all `wᵢ` pass.
pub fn subtract_all(x: &mut [f64], y: &[f64], terms: &[(f64, &[f64])]) {
    pulp::Arch::new().dispatch(SubtractAll { x, y, terms });
}

struct SubtractAll<'a> {
    x: &'a mut [f64],
    y: &'a [f64],
    terms: &'a [(f64, &'a [f64])],
}

impl NullaryFnOnce for SubtractAll<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        const PIECE: usize = 1024;
        let Self { x, y, terms } = self;
        for (at, x) in x.chunks_mut(PIECE).enumerate() {
            let piece = at * PIECE..at * PIECE + x.len();
            x.copy_from_slice(&y[piece.clone()]);
            for (c, w) in terms {
                for (x, w) in x.iter_mut().zip(&w[piece.clone()]) {
                    *x -= c * w;
                }
            }
        }
    }
}

/// `to ← a − b`.
pub fn difference(to: &mut Vec<f64>, a: &[f64], b: &[f64]) {
    to.clear();
    to.extend(a.iter().zip(b).map(|(a, b)| a - b));
}

/// `mean ← (end − start) / size`: over a window of that size, the mean of what goes from `start` to `end` as
/// its derivative.
pub fn mean_rate(mean: &mut [f64], start: &[f64], end: &[f64], size: f64) {
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            for ((mean, start), end) in mean.iter_mut().zip(start).zip(end) {
                *mean = (end - start) / size;
            }
        },
    );
}

/// `held ← r new + (1 − r) held`.
pub fn relax(held: &mut [f64], new: &[f64], r: f64) {
    if r == 1.0 {
        held.copy_from_slice(new);
        return;
    }
    for (held, new) in held.iter_mut().zip(new) {
        *held = r * new + (1.0 - r) * *held;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_small_whole_numbers_are_exact() {
        for length in [0, 1, 15, 16, 17, 100] {
            let a: Vec<f64> = (0..length).map(f64::from).collect();
            let ones = vec![1.0; length as usize];
            let n = f64::from(length);
            let (sum, squares) = (n * (n - 1.0) / 2.0, (n - 1.0) * n * (2.0 * n - 1.0) / 6.0);
            assert_eq!(dots(&a, [&ones, &a]), [sum, squares]);
            assert_eq!(dot(&ones, &a), sum);
        }
    }

    #[test]
    fn terms_are_subtracted_piece_by_piece() {
        let y: Vec<f64> = (0..3000).map(f64::from).collect();
        let (ones, mut x) = (vec![1.0; 3000], vec![7.0; 3000]);
        subtract_all(&mut x, &y, &[(2.0, &y), (-3.0, &ones)]);
        assert!(x.iter().zip(&y).all(|(x, y)| *x == 3.0 - y));
    }

    #[test]
    fn all_of_the_new_is_the_new() {
        let mut held = vec![1.0, 2.0];
        relax(&mut held, &[3.0, 6.0], 0.5);
        assert_eq!(held, [2.0, 4.0]);
        relax(&mut held, &[3.0, 6.0], 1.0);
        assert_eq!(held, [3.0, 6.0]);
    }
}
