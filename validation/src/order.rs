//! Observed order of convergence.

/// How a number converges with its own refinement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convergence {
    /// Observed order.
    pub order: f64,
    /// The value that it converges to.
    pub limit: f64,
}

/// Order and limit of `f(h) = limit + C hᵖ` through the three finest of `(h, f)`, sorted from coarse to fine.
/// Nothing if there are fewer than three, or no order between 0.1 and 8 does it: the values swing, or their
/// steps do not shrink as a power of h.
pub fn convergence(values: &[(f64, f64)]) -> Option<Convergence> {
    let [(h1, f1), (h2, f2), (h3, f3)] = *values.last_chunk::<3>()?;
    let ratio = (f1 - f2) / (f2 - f3);
    // Grows with p: a decrease in h from coarse to fine counts the more the higher the order.
    let excess = |p: f64| (h1.powf(p) - h2.powf(p)) / (h2.powf(p) - h3.powf(p)) - ratio;
    let (mut low, mut high) = (0.1, 8.0);
    // Written so that a ratio that is no number gives nothing.
    if !(excess(low) < 0.0 && excess(high) > 0.0) {
        return None;
    }
    // Halves to the last bit.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if excess(middle) < 0.0 { low = middle } else { high = middle }
    }
    let factor = (f2 - f3) / (h2.powf(low) - h3.powf(low));
    Some(Convergence { order: low, limit: f3 - factor * h3.powf(low) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_found() {
        let at = |h: f64| (h, 5.0 - 3.0 * h.powf(1.7));
        let found = convergence(&[at(0.5), at(0.25), at(1.0 / 6.0), at(0.1)]).unwrap();
        assert!((found.order - 1.7).abs() < 1e-9 && (found.limit - 5.0).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn values_that_swing_or_are_few_have_none() {
        assert_eq!(convergence(&[(0.2, 1.0), (0.1, 2.0)]), None);
        assert_eq!(convergence(&[(0.4, 1.0), (0.2, 2.0), (0.1, 1.5)]), None);
        assert_eq!(convergence(&[(0.4, 1.0), (0.2, 1.0), (0.1, 1.0)]), None);
    }
}
