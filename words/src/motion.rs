//! A number over time, by which a wall moves.

use serde::Serialize;

/// A number over time: a distance (m) or an angle (rad).
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Law {
    /// `amplitude · (sin(2πt/period + phase) − sin(phase))`: from zero.
    Sine {
        /// Amplitude (m or rad).
        amplitude: f64,
        /// Period (s).
        period: f64,
        /// Phase (rad).
        phase: f64,
    },
    /// A smooth curve: a cubic between two pairs, with the mean slope of both sides at each (Catmull and Rom
    /// 1974), so that the velocity is continuous; at rest before the first and after the last.
    Table {
        /// Pairs of time (s) and value, times growing.
        table: Vec<[f64; 2]>,
    },
}

impl Law {
    /// Its value at a time (s).
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Self::Sine { amplitude, period, phase } => {
                amplitude * ((std::f64::consts::TAU * time / period + phase).sin() - phase.sin())
            }
            Self::Table { table } => through(table, time),
        }
    }
}

fn through(rows: &[[f64; 2]], time: f64) -> f64 {
    let next = rows.partition_point(|row| row[0] <= time);
    if next == 0 || next == rows.len() {
        return rows[next.min(rows.len() - 1)][1];
    }
    let slope = |i: usize| {
        let (before, after) = (i.checked_sub(1), i + 1);
        match (before, after < rows.len()) {
            // At its ends the law rests.
            (None, _) | (_, false) => 0.0,
            (Some(before), true) => (rows[after][1] - rows[before][1]) / (rows[after][0] - rows[before][0]),
        }
    };
    let ([t0, v0], [t1, v1]) = (rows[next - 1], rows[next]);
    let length = t1 - t0;
    let s = (time - t0) / length;
    let (m0, m1) = (slope(next - 1) * length, slope(next) * length);
    let (s2, s3) = (s * s, s * s * s);
    (2.0 * s3 - 3.0 * s2 + 1.0) * v0 + (s3 - 2.0 * s2 + s) * m0 + (3.0 * s2 - 2.0 * s3) * v1 + (s3 - s2) * m1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_pass_through_their_values_and_start_at_rest() {
        let law = Law::Table { table: vec![[0.0, 0.0], [1.0, 2.0], [2.0, 3.0], [4.0, 3.0]] };
        for (t, value) in [(-1.0, 0.0), (0.0, 0.0), (1.0, 2.0), (2.0, 3.0), (4.0, 3.0), (9.0, 3.0)] {
            assert!((law.at(t) - value).abs() < 1e-15, "{t}");
        }
        // Slopes 0 at the first row and (3 − 0)/2 at the second: 2 (3/4 − 2/8) + 1.5 (1/8 − 1/4) + ... by
        // hand at the middle.
        assert!((law.at(0.5) - (2.0 * 0.5 - 1.5 * 0.125)).abs() < 1e-15);
        let slope = |t: f64| (law.at(t + 1e-6) - law.at(t - 1e-6)) / 2e-6;
        assert!((slope(1.0) - 1.5).abs() < 1e-5 && slope(0.0).abs() < 1e-5);
        let sine = Law::Sine { amplitude: 2.0, period: 4.0, phase: 0.0 };
        assert!((sine.at(1.0) - 2.0).abs() < 1e-15 && sine.at(0.0) == 0.0);
    }
}
