//! Walls that move by a prescribed law: a gate that lifts, a tank that rolls.
//!
//! The law is a number over time: a distance (m) along a direction, or an angle (rad) about a pivot. A wall's
//! particles and its shape are where the law puts them at the start of a step, and meet the fluid with their
//! mean velocity over it.

use sph::{Matrix, Vector};

/// A number over time.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// `amplitude · sin(2π t/period + phase) − amplitude · sin(phase)`: from zero.
    Sine {
        /// Amplitude (m or rad).
        amplitude: f64,
        /// Period (s).
        period: f64,
        /// Phase (rad).
        phase: f64,
    },
    /// Pairs of time (s) and value, times growing: a cubic between two of them, with the mean slope of both
    /// sides at each (Catmull and Rom 1974), so that the velocity is continuous; constant before and after.
    Table(Vec<[f64; 2]>),
}

/// How a wall moves.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion<const D: usize> {
    /// Along a direction.
    Translation {
        /// Unit vector.
        direction: Vector<D>,
        /// Distance (m).
        law: Law,
    },
    /// About a point; in three dimensions about the line through it along the third axis.
    Rotation {
        /// The point (m).
        pivot: Vector<D>,
        /// Angle (rad), from the first axis to the second.
        law: Law,
    },
}

/// Where a motion has brought a wall: `r ↦ pivot + Q (r − pivot) + shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<const D: usize> {
    pivot: Vector<D>,
    turn: Matrix<D>,
    shift: Vector<D>,
}

impl Law {
    /// Its value at a time (s).
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Self::Sine { amplitude, period, phase } => {
                amplitude * ((std::f64::consts::TAU * time / period + phase).sin() - phase.sin())
            }
            Self::Table(rows) => table(rows, time),
        }
    }
}

fn table(rows: &[[f64; 2]], time: f64) -> f64 {
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

impl<const D: usize> Motion<D> {
    /// Where it has brought the wall at a time (s).
    pub fn pose(&self, time: f64) -> Pose<D> {
        match self {
            Self::Translation { direction, law } => {
                Pose { pivot: Vector::zeros(), turn: Matrix::identity(), shift: direction * law.at(time) }
            }
            Self::Rotation { pivot, law } => {
                let (sin, cos) = law.at(time).sin_cos();
                let mut turn = Matrix::identity();
                (turn[(0, 0)], turn[(0, 1)], turn[(1, 0)], turn[(1, 1)]) = (cos, -sin, sin, cos);
                Pose { pivot: *pivot, turn, shift: Vector::zeros() }
            }
        }
    }
}

impl<const D: usize> Pose<D> {
    /// Where a point of the wall at rest (m) is now.
    pub fn moved(&self, point: &Vector<D>) -> Vector<D> {
        self.pivot + self.turn * (point - self.pivot) + self.shift
    }

    /// Which point of the wall at rest (m) is here now.
    pub fn at_rest(&self, point: &Vector<D>) -> Vector<D> {
        self.pivot + self.turn.transpose() * (point - self.shift - self.pivot)
    }

    /// A direction of the wall at rest as it points now.
    pub fn turned(&self, direction: &Vector<D>) -> Vector<D> {
        self.turn * direction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_pass_through_their_values_and_start_at_rest() {
        let law = Law::Table(vec![[0.0, 0.0], [1.0, 2.0], [2.0, 3.0], [4.0, 3.0]]);
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

    #[test]
    fn a_quarter_turn_by_hand() {
        let law = Law::Table(vec![[0.0, 0.0], [1.0, std::f64::consts::FRAC_PI_2]]);
        let pose = Motion::Rotation { pivot: Vector::from([1.0, 0.0]), law }.pose(2.0);
        let at = pose.moved(&Vector::from([2.0, 0.0]));
        assert!((at - Vector::from([1.0, 1.0])).norm() < 1e-15);
        assert!((pose.at_rest(&at) - Vector::from([2.0, 0.0])).norm() < 1e-15);
        assert!((pose.turned(&Vector::from([1.0, 0.0])) - Vector::from([0.0, 1.0])).norm() < 1e-15);
    }
}
