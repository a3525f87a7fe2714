//! Smoothing kernels.

use crate::Vector;
use std::f64::consts::PI;

/// The cubic B-spline kernel (Monaghan and Lattanzio 1985), the kernel of the paper (its Eq. (1)).
///
/// `W(r) = σ/hᴰ · { 1 − 3/2 q² + 3/4 q³ (q ≤ 1); ¼ (2 − q)³ (q ≤ 2); 0 }` with `q = r/h` and
/// `σ = 10/(7π)` in two dimensions, `1/π` in three, so that its integral over space is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubicSpline<const D: usize> {
    smoothing_length: f64,
    value_scale: f64,
    slope_scale: f64,
}

impl<const D: usize> CubicSpline<D> {
    /// The kernel with smoothing length `h` (m), which must be positive.
    pub fn new(smoothing_length: f64) -> Self {
        assert!(smoothing_length > 0.0, "a smoothing length is positive");
        let sigma = match D {
            2 => 10.0 / (7.0 * PI),
            3 => 1.0 / PI,
            _ => panic!("kernels are normalised for two and three dimensions"),
        };
        let value_scale = sigma / smoothing_length.powi(D as i32);
        Self { smoothing_length, value_scale, slope_scale: value_scale / smoothing_length }
    }

    /// `h` (m).
    pub fn smoothing_length(&self) -> f64 {
        self.smoothing_length
    }

    /// The distance (m) from which on the kernel is zero: `2h`.
    pub fn support(&self) -> f64 {
        2.0 * self.smoothing_length
    }

    /// `W(r)` in m⁻ᴰ.
    #[inline]
    pub fn value(&self, distance: f64) -> f64 {
        let q = distance / self.smoothing_length;
        if q <= 1.0 {
            self.value_scale * (1.0 - 1.5 * q * q * (1.0 - 0.5 * q))
        } else if q < 2.0 {
            self.value_scale * 0.25 * (2.0 - q).powi(3)
        } else {
            0.0
        }
    }

    /// `dW/dr` in m⁻ᴰ⁻¹; never positive.
    #[inline]
    pub fn slope(&self, distance: f64) -> f64 {
        let q = distance / self.smoothing_length;
        if q <= 1.0 {
            self.slope_scale * q * (2.25 * q - 3.0)
        } else if q < 2.0 {
            self.slope_scale * -0.75 * (2.0 - q) * (2.0 - q)
        } else {
            0.0
        }
    }

    /// [`value`](Self::value) and [`slope`](Self::slope) at once and without branches, from the form
    /// `W = σ/hᴰ · (¼ (2 − q)₊³ − (1 − q)₊³)` of the same polynomials.
    #[inline]
    pub fn value_and_slope(&self, distance: f64) -> (f64, f64) {
        let q = distance / self.smoothing_length;
        let (outer, inner) = ((2.0 - q).max(0.0), (1.0 - q).max(0.0));
        let (outer_squared, inner_squared) = (outer * outer, inner * inner);
        (
            self.value_scale * (0.25 * outer * outer_squared - inner * inner_squared),
            self.slope_scale * (3.0 * inner_squared - 0.75 * outer_squared),
        )
    }

    /// `∇W_ab = dW/dr · r_ab/|r_ab|` with respect to `r_a`, where `offset = r_ab = r_a − r_b`; zero for
    /// coincident points.
    #[inline]
    pub fn gradient(&self, offset: &Vector<D>) -> Vector<D> {
        let distance = offset.norm();
        if distance > 0.0 { offset * (self.slope(distance) / distance) } else { Vector::zeros() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerances: midpoint rule on 400 cells a support, error below 1e-6.
    #[test]
    fn integral_is_one_in_two_and_three_dimensions() {
        let (h, cells) = (0.7, 4000);
        let dr = 2.0 * h / f64::from(cells);
        let (k2, k3) = (CubicSpline::<2>::new(h), CubicSpline::<3>::new(h));
        let (mut area, mut volume) = (0.0, 0.0);
        for i in 0..cells {
            let r = (f64::from(i) + 0.5) * dr;
            area += 2.0 * PI * r * k2.value(r) * dr;
            volume += 4.0 * PI * r * r * k3.value(r) * dr;
        }
        assert!((area - 1.0).abs() < 1e-6 && (volume - 1.0).abs() < 1e-6, "{area} {volume}");
    }

    #[test]
    fn values_by_hand() {
        let k = CubicSpline::<2>::new(2.0);
        let scale = 10.0 / (7.0 * PI) / 4.0;
        assert_eq!(k.value(0.0), scale);
        assert!((k.value(2.0) - 0.25 * scale).abs() < 1e-15);
        assert!((k.value(3.0) - 0.25 * 0.125 * scale).abs() < 1e-15);
        assert_eq!((k.value(4.0), k.slope(4.0), k.slope(0.0)), (0.0, 0.0, 0.0));
        assert!((k.slope(2.0) - -0.75 * scale / 2.0).abs() < 1e-15);
    }

    /// Both forms are sums of a few terms of magnitude one or less: they differ by some roundings.
    #[test]
    fn value_and_slope_at_once_are_the_same() {
        let k = CubicSpline::<2>::new(1.3);
        let (value_scale, slope_scale) = (k.value(0.0), -k.slope(1.3));
        for i in 0..40 {
            let r = 0.07 * f64::from(i);
            let (value, slope) = k.value_and_slope(r);
            assert!((value - k.value(r)).abs() < 1e-14 * value_scale, "value at {r}");
            assert!((slope - k.slope(r)).abs() < 1e-14 * slope_scale, "slope at {r}");
        }
    }

    #[test]
    fn slope_is_the_derivative_of_value() {
        let (k, step) = (CubicSpline::<3>::new(1.3), 1e-6);
        for i in 1..30 {
            let r = 0.1 * f64::from(i);
            let difference = (k.value(r + step) - k.value(r - step)) / (2.0 * step);
            // Central differences: truncation about step², rounding about 1e-16/step.
            assert!((difference - k.slope(r)).abs() < 1e-8, "at {r}");
        }
    }
}
