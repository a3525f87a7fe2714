//! Axes: round tick values, and SI prefixes that keep tick labels short.

/// Ticks of an axis, and the ends that it gets by rounding its range outwards.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ticks {
    pub low: f64,
    pub high: f64,
    /// Value and label of each tick, from `low` to `high`.
    pub labels: Vec<(f64, String)>,
}

/// About `count` ticks at multiples of 1, 2 or 5 times a power of ten, covering `min` to `max`.
///
/// A range without width is widened by 1 % of its value (by 1 about zero).
pub(crate) fn linear(min: f64, max: f64, count: usize) -> Ticks {
    // Below 1e-9 of the value, tick labels would need more than nine digits to differ.
    let (min, max) = if max - min > 1e-9 * max.abs().max(min.abs()) {
        (min, max)
    } else {
        let half = if max == 0.0 { 1.0 } else { 0.01 * max.abs() };
        (min - half, max + half)
    };
    let raw = (max - min) / count as f64;
    let power = 10f64.powi(raw.log10().floor() as i32);
    // The remainder raw / power is in [1, 10); 1e-9 keeps a range that is round already from a longer step.
    let step = power * [1.0, 2.0, 5.0].into_iter().find(|s| raw / power <= s + 1e-9).unwrap_or(10.0);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    // A millionth of a step: bounds on a tick up to round-off do not get another interval.
    let first = (min / step + 1e-6).floor() as i64;
    let last = (max / step - 1e-6).ceil() as i64;
    let labels = (first..=last)
        .map(|index| {
            let value = index as f64 * step;
            let label = format!("{value:.decimals$}");
            (value, if index == 0 { "0".to_owned() } else { label.replace('-', "−") })
        })
        .collect();
    Ticks { low: first as f64 * step, high: last as f64 * step, labels }
}

/// `10` with its raised power.
pub(crate) fn power_of_ten(power: i32) -> String {
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = power.unsigned_abs().to_string();
    let raised: String = digits.bytes().map(|digit| RAISED[usize::from(digit - b'0')]).collect();
    format!("10{}{raised}", if power < 0 { "⁻" } else { "" })
}

/// The factor and the prefixed unit that bring a quantity of this largest magnitude between 1 and 1000.
///
/// Only units that take a prefix get one; `unit` is returned as it is otherwise.
pub(crate) fn prefixed(unit: &str, magnitude: f64) -> (f64, String) {
    const PREFIXED: [&str; 8] = ["m", "m/s", "m/s²", "s", "Pa", "N", "J", "W"];
    if !PREFIXED.contains(&unit) || magnitude == 0.0 || !magnitude.is_finite() {
        return (1.0, unit.to_owned());
    }
    let thousands = (magnitude.log10() / 3.0).floor().clamp(-4.0, 3.0) as i32;
    // Kilometres and kiloseconds are no units of this field.
    let thousands = if matches!(unit, "m" | "m/s" | "m/s²" | "s") { thousands.min(0) } else { thousands };
    let prefix = ["p", "n", "µ", "m", "", "k", "M", "G"][(thousands + 4) as usize];
    (1000f64.powi(-thousands), format!("{prefix}{unit}"))
}

/// `value` with four significant digits, for people.
pub fn short(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if !value.is_finite() {
        "not a number".to_owned()
    } else if (1e-4..1e5).contains(&magnitude) {
        let decimals = (3 - magnitude.log10().floor() as i32).max(0) as usize;
        let text = format!("{value:.decimals$}");
        let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        text.replace('-', "−")
    } else {
        format!("{value:.2e}").replace('-', "−")
    }
}

/// `value` with its unit, prefixed by its own size.
pub(crate) fn quantity(value: f64, unit: &str) -> String {
    let (factor, unit) = prefixed(unit, value.abs());
    let separator = if unit.is_empty() { "" } else { " " };
    format!("{}{separator}{unit}", short(value * factor))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &Ticks) -> Vec<&str> {
        ticks.labels.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn ticks_are_round_and_cover_the_range() {
        assert_eq!(labels(&linear(0.0, 0.4, 5)), ["0", "0.1", "0.2", "0.3", "0.4"]);
        assert_eq!(labels(&linear(-3.0, 44.0, 5)), ["−10", "0", "10", "20", "30", "40", "50"]);
        assert_eq!(labels(&linear(7.0, 7.0, 3)), ["6.90", "6.95", "7.00", "7.05", "7.10"]);
        for (min, max) in [(1e-9, 3e-9), (-1.0, 1e6), (0.99999, 1.00001), (5.0, 5.0), (0.0, 0.0)] {
            let ticks = linear(min, max, 5);
            assert!(
                ticks.low <= min + 1e-6 * ticks.high.abs() && ticks.high >= max - 1e-6 * ticks.high.abs()
            );
            assert!((2..=9).contains(&ticks.labels.len()), "{ticks:?}");
        }
    }

    #[test]
    fn prefixes_follow_the_size() {
        assert_eq!(prefixed("m", 0.044), (1e3, "mm".to_owned()));
        assert_eq!(prefixed("Pa", 1.4e6).1, "MPa");
        assert_eq!(prefixed("m", 4e3).1, "m");
        assert_eq!(prefixed("", 1e-8), (1.0, String::new()));
        assert_eq!(quantity(0.0443912, "m"), "44.39 mm");
        assert_eq!(short(-1.0), "−1");
        assert_eq!(short(123456.0), "1.23e5");
    }
}
