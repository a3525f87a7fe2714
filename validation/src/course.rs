//! Numbers of a course over time: `times` grow, `values` are as many.

use std::f64::consts::TAU;

/// Largest (`sign` 1) or least (`sign` −1) value; of the parabola through the three rows about it where it is
/// not at an end.
pub fn extreme(times: &[f64], values: &[f64], sign: f64) -> f64 {
    vertex(times, values, sign).1
}

/// Time and value of the same.
pub fn vertex(times: &[f64], values: &[f64], sign: f64) -> (f64, f64) {
    let at = (0..values.len()).max_by(|&a, &b| (sign * values[a]).total_cmp(&(sign * values[b])));
    let at = at.expect("the caller has seen three rows");
    if at == 0 || at + 1 == values.len() {
        return (times[at], values[at]);
    }
    // f(s) = f₁ + b s + a s², s counted from the middle row.
    let (left, right) = (times[at - 1] - times[at], times[at + 1] - times[at]);
    let (down, up) = ((values[at - 1] - values[at]) / left, (values[at + 1] - values[at]) / right);
    let a = (up - down) / (right - left);
    let b = down - a * left;
    if a == 0.0 {
        return (times[at], values[at]);
    }
    (times[at] - b / (2.0 * a), values[at] - b * b / (4.0 * a))
}

/// Time at which a course first is over a level.
pub fn first_over(times: &[f64], values: &[f64], level: f64) -> Option<f64> {
    let i = values.iter().position(|&v| v > level)?;
    if i == 0 {
        return Some(times[0]);
    }
    let part = (level - values[i - 1]) / (values[i] - values[i - 1]);
    Some(times[i - 1] + part * (times[i] - times[i - 1]))
}

/// Value at a time, of the parabola through the rows about it.
pub fn value_at(times: &[f64], values: &[f64], time: f64) -> Option<f64> {
    let (&first, &last) = (times.first()?, times.last()?);
    // A run's last row is at its end up to rounding.
    if times.len() < 3 || time < first || time > last * (1.0 + 1e-9) {
        return None;
    }
    let middle = times.partition_point(|&t| t < time).clamp(1, times.len() - 2);
    let (t, v) = (&times[middle - 1..=middle + 1], &values[middle - 1..=middle + 1]);
    let weight =
        |i: usize, j: usize, k: usize| (time - t[j]) * (time - t[k]) / ((t[i] - t[j]) * (t[i] - t[k]));
    Some(v[0] * weight(0, 1, 2) + v[1] * weight(1, 0, 2) + v[2] * weight(2, 0, 1))
}

/// Mean over time, the values linear between rows.
pub fn mean(times: &[f64], values: &[f64]) -> f64 {
    let area: f64 =
        (1..times.len()).map(|i| 0.5 * (values[i] + values[i - 1]) * (times[i] - times[i - 1])).sum();
    area / (times[times.len() - 1] - times[0])
}

/// Mean time between passages through the middle of the range; that of those downwards and of those upwards,
/// each if there are two.
pub fn period(times: &[f64], values: &[f64]) -> Option<f64> {
    let middle = 0.5 * (extreme(times, values, 1.0) + extreme(times, values, -1.0));
    let passages = |sign: f64| -> Vec<f64> {
        let passes = |i: &usize| sign * (values[i - 1] - middle) < 0.0 && sign * (values[*i] - middle) >= 0.0;
        let at = |i: usize| {
            let part = (middle - values[i - 1]) / (values[i] - values[i - 1]);
            times[i - 1] + part * (times[i] - times[i - 1])
        };
        (1..times.len()).filter(passes).map(at).collect()
    };
    let both = [passages(1.0), passages(-1.0)];
    let (periods, length) = both
        .iter()
        .filter(|p| p.len() > 1)
        .fold((0, 0.0), |(count, length), p| (count + p.len() - 1, length + p[p.len() - 1] - p[0]));
    (periods > 0).then(|| length / periods as f64)
}

/// Mean and frequency (Hz) of the sinusoid about a mean that fits a course best, in frequency within a tenth
/// of one over its period.
pub fn ringing(times: &[f64], values: &[f64]) -> Option<[f64; 2]> {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let first = 1.0 / period(times, values)?;
    let (mut low, mut high) = (0.9 * first, 1.1 * first);
    // Forty cuts leave 4e-9 of the span.
    for _ in 0..40 {
        let (left, right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        if sinusoid(times, values, left)[1] < sinusoid(times, values, right)[1] {
            high = right;
        } else {
            low = left;
        }
    }
    let frequency = 0.5 * (low + high);
    Some([sinusoid(times, values, frequency)[0], frequency])
}

/// The mean `m` of `m + a cos ωt + b sin ωt` that fits best, and what is left of the squares.
fn sinusoid(times: &[f64], values: &[f64], frequency: f64) -> [f64; 2] {
    let count = times.len() as f64;
    let centred = |of: Vec<f64>| {
        let mean = of.iter().sum::<f64>() / count;
        (mean, of.into_iter().map(|v| v - mean).collect::<Vec<f64>>())
    };
    let (cos_mean, cos) = centred(times.iter().map(|t| (TAU * frequency * t).cos()).collect());
    let (sin_mean, sin) = centred(times.iter().map(|t| (TAU * frequency * t).sin()).collect());
    let (mean, v) = centred(values.to_vec());
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (cc, cs, ss, cv, sv) =
        (dot(&cos, &cos), dot(&cos, &sin), dot(&sin, &sin), dot(&cos, &v), dot(&sin, &v));
    let determinant = cc * ss - cs * cs;
    let (a, b) = ((cv * ss - sv * cs) / determinant, (sv * cc - cv * cs) / determinant);
    [mean - a * cos_mean - b * sin_mean, dot(&v, &v) - a * cv - b * sv]
}

/// Swings of a course about the middle of its range: the time halfway between two extremes and the logarithm
/// of their difference. What comes after its last passage may be no extreme yet, and is left out.
pub fn swings(times: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
    let middle = 0.5 * (extreme(times, values, 1.0) + extreme(times, values, -1.0));
    let sides: Vec<(usize, usize)> = values
        .chunk_by(|a, b| (*a < middle) == (*b < middle))
        .scan(0, |end, side| {
            let first = *end;
            *end += side.len();
            Some((first, *end))
        })
        .collect();
    let peaks: Vec<(f64, f64)> = sides[..sides.len() - 1]
        .iter()
        .map(|&(first, end)| {
            let (times, values) = (&times[first..end], &values[first..end]);
            let sign = if values[0] < middle { -1.0 } else { 1.0 };
            let at = (0..values.len()).max_by(|&a, &b| (sign * values[a]).total_cmp(&(sign * values[b])));
            (times[at.unwrap_or(0)], extreme(times, values, sign))
        })
        .collect();
    peaks.windows(2).map(|p| (0.5 * (p[0].0 + p[1].0), (p[1].1 - p[0].1).abs().ln())).collect()
}

/// The line through points by least squares: mean x, mean y, slope. Nothing through fewer than three, or
/// where they are no numbers.
pub fn line(points: &[(f64, f64)]) -> Option<[f64; 3]> {
    let count = points.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let slope = mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2));
    (points.len() >= 3 && slope.is_finite()).then_some([x, y, slope])
}
