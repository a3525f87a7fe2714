//! Walls that move by a prescribed law: a gate that lifts, a tank that rolls.
//!
//! The law is a number over time: a distance (m) along a direction, or an angle (rad) about a pivot. A wall's
//! particles and its shape are where the law puts them at the start of a step, and meet the fluid with their
//! mean velocity over it.

use sph::{Matrix, Vector};
pub use words::motion::Law;

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
    fn a_quarter_turn_by_hand() {
        let law = Law::Table { table: vec![[0.0, 0.0], [1.0, std::f64::consts::FRAC_PI_2]] };
        let pose = Motion::Rotation { pivot: Vector::from([1.0, 0.0]), law }.pose(2.0);
        let at = pose.moved(&Vector::from([2.0, 0.0]));
        assert!((at - Vector::from([1.0, 1.0])).norm() < 1e-15);
        assert!((pose.at_rest(&at) - Vector::from([2.0, 0.0])).norm() < 1e-15);
        assert!((pose.turned(&Vector::from([1.0, 0.0])) - Vector::from([0.0, 1.0])).norm() < 1e-15);
    }
}
