//! Rigid motions by a law: along a direction, or about a point. Points are of any type that is an array of
//! `D` numbers.

use crate::motion::Law;

/// A rigid motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion<const D: usize> {
    /// Along a direction.
    Translation {
        /// Unit vector.
        direction: [f64; D],
        /// Distance (m).
        law: Law,
    },
    /// About a point; in three dimensions about the line through it along the third axis.
    Rotation {
        /// The point (m).
        pivot: [f64; D],
        /// Angle (rad), from the first axis to the second.
        law: Law,
    },
}

/// Where a motion has brought what it moves: `r ↦ pivot + Q (r − pivot) + shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<const D: usize> {
    pivot: [f64; D],
    turn: [[f64; D]; D],
    shift: [f64; D],
}

/// How fast: `r ↦ shift + spin × (r − pivot)`, the velocity (m/s) of what is at `r` now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twist<const D: usize> {
    pivot: [f64; D],
    /// About the third axis (rad/s).
    spin: f64,
    /// Velocity (m/s).
    shift: [f64; D],
}

impl<const D: usize> Motion<D> {
    /// Along a direction of any length that is not zero.
    pub fn along(direction: [f64; D], law: Law) -> Self {
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        Self::Translation { direction: direction.map(|x| x / length), law }
    }

    /// Where it has brought things at a time (s).
    pub fn pose(&self, time: f64) -> Pose<D> {
        let mut turn = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
        match self {
            Self::Translation { direction, law } => {
                let distance = law.at(time);
                Pose { pivot: [0.0; D], turn, shift: direction.map(|x| x * distance) }
            }
            Self::Rotation { pivot, law } => {
                let (sin, cos) = law.at(time).sin_cos();
                (turn[0][0], turn[0][1], turn[1][0], turn[1][1]) = (cos, -sin, sin, cos);
                Pose { pivot: *pivot, turn, shift: [0.0; D] }
            }
        }
    }

    /// How fast it moves things at a time (s): the derivative of its pose.
    pub fn twist(&self, time: f64) -> Twist<D> {
        match self {
            Self::Translation { direction, law } => {
                let speed = law.rate(time);
                Twist { pivot: [0.0; D], spin: 0.0, shift: direction.map(|x| x * speed) }
            }
            Self::Rotation { pivot, law } => Twist { pivot: *pivot, spin: law.rate(time), shift: [0.0; D] },
        }
    }
}

impl<const D: usize> Pose<D> {
    /// Where a point at rest (m) is now.
    pub fn moved<V: Copy + Into<[f64; D]> + From<[f64; D]>>(&self, point: &V) -> V {
        let arm: [f64; D] = minus((*point).into(), self.pivot);
        let turned = times(&self.turn, &arm);
        V::from(std::array::from_fn(|i| self.pivot[i] + turned[i] + self.shift[i]))
    }

    /// Which point at rest (m) is here now.
    pub fn at_rest<V: Copy + Into<[f64; D]> + From<[f64; D]>>(&self, point: &V) -> V {
        let arm = minus(minus((*point).into(), self.shift), self.pivot);
        let back = times(&self.back(), &arm);
        V::from(std::array::from_fn(|i| self.pivot[i] + back[i]))
    }

    /// A direction at rest as it points now.
    pub fn turned<V: Copy + Into<[f64; D]> + From<[f64; D]>>(&self, direction: &V) -> V {
        V::from(times(&self.turn, &(*direction).into()))
    }

    /// A direction of now as it pointed at rest: its components along the axes that have turned.
    pub fn turned_back<V: Copy + Into<[f64; D]> + From<[f64; D]>>(&self, direction: &V) -> V {
        V::from(times(&self.back(), &(*direction).into()))
    }

    fn back(&self) -> [[f64; D]; D] {
        std::array::from_fn(|i| std::array::from_fn(|j| self.turn[j][i]))
    }
}

impl<const D: usize> Twist<D> {
    /// Velocity (m/s) of what is at a point (m) now.
    pub fn at<V: Copy + Into<[f64; D]> + From<[f64; D]>>(&self, point: &V) -> V {
        let arm = minus((*point).into(), self.pivot);
        let mut velocity = self.shift;
        velocity[0] -= self.spin * arm[1];
        velocity[1] += self.spin * arm[0];
        V::from(velocity)
    }
}

fn minus<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|i| a[i] - b[i])
}

/// Column after column.
fn times<const D: usize>(matrix: &[[f64; D]; D], vector: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|i| (1..D).fold(matrix[i][0] * vector[0], |sum, j| sum + matrix[i][j] * vector[j]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near<const D: usize>(a: [f64; D], b: [f64; D], tolerance: f64) -> bool {
        a.iter().zip(&b).all(|(a, b)| (a - b).abs() < tolerance)
    }

    #[test]
    fn a_quarter_turn_by_hand() {
        let law = Law::Table { table: vec![[0.0, 0.0], [1.0, std::f64::consts::FRAC_PI_2]] };
        let pose = Motion::Rotation { pivot: [1.0, 0.0], law }.pose(2.0);
        let at = pose.moved(&[2.0, 0.0]);
        assert!(near(at, [1.0, 1.0], 1e-15));
        assert!(near(pose.at_rest(&at), [2.0, 0.0], 1e-15));
        assert!(near(pose.turned(&[1.0, 0.0]), [0.0, 1.0], 1e-15));
        assert!(near(pose.turned_back(&[0.0, 1.0]), [1.0, 0.0], 1e-15));
    }

    /// Central differences of the pose, in three dimensions; the third axis is that of the rotation.
    #[test]
    fn twists_are_the_derivatives_of_poses() {
        let law = Law::Sine { amplitude: 0.8, period: 2.0, phase: 0.1 };
        let along = Motion::along([1.0, -2.0, 2.0], law.clone());
        let Motion::Translation { direction, .. } = &along else { panic!("it is one") };
        assert!(near(*direction, [1.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0], 1e-15));
        for motion in [along, Motion::Rotation { pivot: [0.3, -0.2, 5.0], law }] {
            for time in [0.0, 0.4, 1.3] {
                let (point, h) = ([1.0, 0.5, -2.0], 1e-5);
                let (after, before) =
                    (motion.pose(time + h).moved(&point), motion.pose(time - h).moved(&point));
                let slope = minus(after, before).map(|x| x / (2.0 * h));
                let velocity = motion.twist(time).at(&motion.pose(time).moved(&point));
                assert!(near(velocity, slope, 1e-8), "{motion:?} at {time}: {velocity:?} {slope:?}");
            }
        }
    }
}
