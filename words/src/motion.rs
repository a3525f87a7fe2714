//! A number over time, by which a wall or a clamp moves.

/// A number over time: a distance (m) or an angle (rad).
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// `speed · t` from t = 0 on.
    Speed {
        /// Speed (m/s or rad/s).
        speed: f64,
    },
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
    /// A law that begins later, at rest until then, and smoothly: `step(t/ramp) · law(t)` with t from the
    /// start on and the quintic step `10 x³ − 15 x⁴ + 6 x⁵`, whose first and second derivative are zero at
    /// both ends. Of a constant speed it is the speed that the step multiplies.
    Late {
        /// When it begins (s): the law's own time counts from it.
        start: f64,
        /// How long (s) the smooth start takes; 0 is none.
        ramp: f64,
        /// The law.
        law: Box<Law>,
    },
}

impl Law {
    /// Its value at a time (s).
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Self::Speed { speed } => speed * time.max(0.0),
            Self::Sine { amplitude, period, phase } => {
                amplitude * ((std::f64::consts::TAU * time / period + phase).sin() - phase.sin())
            }
            Self::Table { table } => through(table, time),
            Self::Late { start, ramp, law } => {
                let own = (time - start).max(0.0);
                match (Step::over(*ramp, own), &**law) {
                    (None, law) => law.at(own),
                    (Some(step), Self::Speed { speed }) => speed * step.integral,
                    (Some(step), law) => step.value * law.at(own),
                }
            }
        }
    }

    /// Its derivative at a time (s): m/s or rad/s.
    pub fn rate(&self, time: f64) -> f64 {
        match self {
            Self::Speed { speed } => {
                if time < 0.0 {
                    0.0
                } else {
                    *speed
                }
            }
            Self::Sine { amplitude, period, phase } => {
                let frequency = std::f64::consts::TAU / period;
                amplitude * frequency * (std::f64::consts::TAU * time / period + phase).cos()
            }
            Self::Table { table } => slope_through(table, time),
            Self::Late { start, .. } if time < *start => 0.0,
            Self::Late { start, ramp, law } => {
                let own = time - start;
                match (Step::over(*ramp, own), &**law) {
                    (None, law) => law.rate(own),
                    (Some(step), Self::Speed { speed }) => speed * step.value,
                    (Some(step), law) => step.rate * law.at(own) + step.value * law.rate(own),
                }
            }
        }
    }
}

/// The smooth step at one time.
struct Step {
    value: f64,
    /// Its derivative (1/s).
    rate: f64,
    /// Its integral (s) since the start.
    integral: f64,
}

impl Step {
    /// At a time (s) since the start; none without a ramp.
    fn over(ramp: f64, time: f64) -> Option<Self> {
        if ramp <= 0.0 {
            return None;
        }
        if time >= ramp {
            return Some(Self { value: 1.0, rate: 0.0, integral: time - 0.5 * ramp });
        }
        let x = time / ramp;
        let (x2, x3) = (x * x, x * x * x);
        Some(Self {
            value: x3 * (10.0 - 15.0 * x + 6.0 * x2),
            rate: 30.0 * x2 * (1.0 - x) * (1.0 - x) / ramp,
            integral: ramp * x2 * x2 * (2.5 - 3.0 * x + x2),
        })
    }
}

/// A piece of a table's curve.
struct Piece {
    /// Values at its ends, and slopes times its length.
    values: [f64; 2],
    slopes: [f64; 2],
    /// Length (s), and how far along it, 0 to 1.
    length: f64,
    along: f64,
}

/// The piece in which a time (s) is; none before the first pair and after the last.
fn piece(rows: &[[f64; 2]], time: f64) -> Option<Piece> {
    let next = rows.partition_point(|row| row[0] <= time);
    if next == 0 || next == rows.len() {
        return None;
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
    Some(Piece {
        values: [v0, v1],
        slopes: [slope(next - 1) * length, slope(next) * length],
        length,
        along: (time - t0) / length,
    })
}

fn through(rows: &[[f64; 2]], time: f64) -> f64 {
    let Some(Piece { values: [v0, v1], slopes: [m0, m1], along: s, .. }) = piece(rows, time) else {
        let end = if rows.first().is_some_and(|row| row[0] > time) { rows.first() } else { rows.last() };
        return end.map_or(0.0, |row| row[1]);
    };
    let (s2, s3) = (s * s, s * s * s);
    (2.0 * s3 - 3.0 * s2 + 1.0) * v0 + (s3 - 2.0 * s2 + s) * m0 + (3.0 * s2 - 2.0 * s3) * v1 + (s3 - s2) * m1
}

fn slope_through(rows: &[[f64; 2]], time: f64) -> f64 {
    let Some(Piece { values: [v0, v1], slopes: [m0, m1], length, along: s }) = piece(rows, time) else {
        return 0.0;
    };
    let s2 = s * s;
    let slope = 6.0 * (s2 - s) * (v0 - v1) + (3.0 * s2 - 4.0 * s + 1.0) * m0 + (3.0 * s2 - 2.0 * s) * m1;
    slope / length
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine() -> Law {
        Law::Sine { amplitude: 2.0, period: 4.0, phase: 0.3 }
    }

    fn table() -> Law {
        Law::Table { table: vec![[0.0, 0.0], [1.0, 2.0], [2.0, 3.0], [4.0, 3.0]] }
    }

    fn late(law: Law, ramp: f64) -> Law {
        Law::Late { start: 0.5, ramp, law: Box::new(law) }
    }

    #[test]
    fn laws_pass_through_their_values_and_start_at_rest() {
        let law = table();
        for (t, value) in [(-1.0, 0.0), (0.0, 0.0), (1.0, 2.0), (2.0, 3.0), (4.0, 3.0), (9.0, 3.0)] {
            assert!((law.at(t) - value).abs() < 1e-15, "{t}");
        }
        // Slopes 0 at the first row and (3 − 0)/2 at the second: 2 (3/4 − 2/8) + 1.5 (1/8 − 1/4) + ... by
        // hand at the middle.
        assert!((law.at(0.5) - (2.0 * 0.5 - 1.5 * 0.125)).abs() < 1e-15);
        assert!((law.rate(1.0) - 1.5).abs() < 1e-15 && law.rate(0.0) == 0.0 && law.rate(9.0) == 0.0);
        let sine = Law::Sine { amplitude: 2.0, period: 4.0, phase: 0.0 };
        assert!((sine.at(1.0) - 2.0).abs() < 1e-15 && sine.at(0.0) == 0.0);
        let speed = Law::Speed { speed: 3.0 };
        assert_eq!([speed.at(-1.0), speed.at(2.0), speed.rate(-1.0), speed.rate(2.0)], [0.0, 6.0, 0.0, 3.0]);
    }

    /// Central differences: their error is `h²/6` times the third derivative, at most 1e-9 here.
    #[test]
    fn rates_are_the_derivatives_of_all_laws() {
        let laws = [
            sine(),
            table(),
            late(sine(), 0.0),
            late(Law::Speed { speed: 3.0 }, 0.7),
            late(sine(), 0.7),
            late(table(), 0.7),
        ];
        for law in laws {
            // None on a border between two pieces, where the second derivative jumps.
            for t in [0.1, 0.55, 0.9, 1.31, 1.9, 3.7, 4.9] {
                let h = 1e-5;
                let slope = (law.at(t + h) - law.at(t - h)) / (2.0 * h);
                assert!((law.rate(t) - slope).abs() < 1e-8, "{law:?} at {t}: {} {slope}", law.rate(t));
            }
        }
    }

    #[test]
    fn a_late_law_rests_until_its_start_and_begins_smoothly() {
        let plain = late(sine(), 0.0);
        for t in [0.5, 0.8, 3.0] {
            assert_eq!(plain.at(t), sine().at(t - 0.5));
            assert_eq!(plain.rate(t), sine().rate(t - 0.5));
        }
        for law in [late(sine(), 0.4), late(table(), 0.4), late(Law::Speed { speed: 3.0 }, 0.4)] {
            assert_eq!([law.at(0.2), law.rate(0.2), law.at(0.5), law.rate(0.5)], [0.0; 4]);
            // Zero acceleration at the start: the rate begins with the square of the time at least.
            assert!(law.rate(0.5 + 1e-4).abs() < 1e-5, "{law:?}");
        }
        // Half of the step at its middle: sin of the law's own time; by the integral a speed lags by half a
        // ramp.
        assert!((late(sine(), 0.4).at(0.7) - 0.5 * sine().at(0.2)).abs() < 1e-15);
        assert!((late(sine(), 0.4).at(2.5) - sine().at(2.0)).abs() < 1e-15);
        let speed = late(Law::Speed { speed: 3.0 }, 0.4);
        assert!((speed.at(2.5) - 3.0 * 1.8).abs() < 1e-14 && (speed.rate(0.7) - 1.5).abs() < 1e-14);
    }
}
