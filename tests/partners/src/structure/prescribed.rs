//! A structure that moves by an analytic law of time, whatever the load.

use super::points::{Points, components};
use crate::Model;
use crate::stand_in::write;
use interfaces::port::names;
use interfaces::{Description, Fields, Result, ScalarKind, TimeWindow};
use std::f64::consts::PI;

/// A motion. Times are those of the windows (s); at time 0 every law passes through the reference positions.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// All points by `amplitude · sin(2π frequency t)` (m, Hz).
    Heave {
        /// Amplitude by component (m).
        amplitude: Vec<f64>,
        /// Frequency (Hz).
        frequency: f64,
    },
    /// All points by `velocity · t`.
    ConstantVelocity {
        /// Velocity (m/s).
        velocity: Vec<f64>,
    },
    /// A gate that swings open: a rotation in the plane of the first two axes by
    /// `θ = angle · (1 − cos(π t/duration))/2`, at rest before 0 and after `duration`.
    Swing {
        /// The point that stays (m).
        pivot: Vec<f64>,
        /// Angle when open (rad), positive from the first axis to the second.
        angle: f64,
        /// Time it takes (s).
        duration: f64,
    },
}

impl Law {
    /// Position (m) and velocity (m/s) at time `t` (s) of the point at `x` (m).
    pub fn motion(&self, t: f64, x: &[f64]) -> (Vec<f64>, Vec<f64>) {
        match self {
            Self::Heave { amplitude, frequency } => {
                let omega = 2.0 * PI * frequency;
                let (sin, cos) = (omega * t).sin_cos();
                let position = x.iter().zip(amplitude).map(|(x, a)| x + a * sin).collect();
                (position, amplitude.iter().map(|a| a * omega * cos).collect())
            }
            Self::ConstantVelocity { velocity } => {
                (x.iter().zip(velocity).map(|(x, v)| x + v * t).collect(), velocity.clone())
            }
            Self::Swing { pivot, angle, duration } => {
                let phase = PI * (t / duration).clamp(0.0, 1.0);
                let (sin, cos) = (0.5 * angle * (1.0 - phase.cos())).sin_cos();
                let rate = 0.5 * angle * phase.sin() * PI / duration;
                let arm = [x[0] - pivot[0], x[1] - pivot[1]];
                let turned = [cos * arm[0] - sin * arm[1], sin * arm[0] + cos * arm[1]];
                let mut position = x.to_vec();
                (position[0], position[1]) = (pivot[0] + turned[0], pivot[1] + turned[1]);
                let mut velocity = vec![0.0; x.len()];
                (velocity[0], velocity[1]) = (-rate * turned[1], rate * turned[0]);
                (position, velocity)
            }
        }
    }
}

/// Points moved by a law. State: the time (s), then the force on the points (N).
#[derive(Clone, Debug)]
pub struct Prescribed {
    /// The points.
    pub points: Points,
    /// Their motion.
    pub law: Law,
}

impl Prescribed {
    fn state(&self, time: f64, inputs: &Fields) -> Vec<f64> {
        [vec![time], self.points.force(inputs, names::PRESSURE_GRADIENT)].concat()
    }
}

impl Model for Prescribed {
    fn description(&self) -> Description {
        let force = components("force", "N", ScalarKind::Balance, self.points.dimension);
        self.points.description("mock structure (prescribed motion)", false, force)
    }

    fn initial(&mut self, start: f64, inputs: &Fields) -> Result<Vec<f64>> {
        Ok(self.state(start, inputs))
    }

    fn constants(&self, outputs: &mut Fields) {
        self.points.constants(outputs);
    }

    fn advance(&self, _accepted: &[f64], window: &TimeWindow, inputs: &Fields) -> Result<(Vec<f64>, u32)> {
        Ok((self.state(window.end(), inputs), asked_sub_steps(window)))
    }

    fn outputs(&self, state: &[f64], outputs: &mut Fields) {
        let reference = self.points.positions.chunks_exact(self.points.dimension);
        let (positions, velocities): (Vec<_>, Vec<_>) =
            reference.map(|x| self.law.motion(state[0], x)).unzip();
        write(outputs, names::POSITION, &positions.concat());
        write(outputs, names::VELOCITY, &velocities.concat());
    }

    fn scalars(&self, state: &[f64]) -> Vec<f64> {
        state[1..].to_vec()
    }
}

/// Sub-steps that a structure without a stability limit reports.
pub(super) fn asked_sub_steps(window: &TimeWindow) -> u32 {
    window.sub_steps.count().map_or(1, |count| count.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn velocities_are_the_derivatives_of_positions() {
        let laws = [
            Law::Heave { amplitude: vec![0.0, 0.1], frequency: 2.0 },
            Law::ConstantVelocity { velocity: vec![0.5, -0.2] },
            Law::Swing { pivot: vec![0.0, 1.0], angle: 1.2, duration: 0.8 },
        ];
        let (x, t, h) = ([0.3, 0.2], 0.37, 1e-5);
        for law in laws {
            let (after, _) = law.motion(t + h, &x);
            let (before, _) = law.motion(t - h, &x);
            let (_, velocity) = law.motion(t, &x);
            for axis in 0..2 {
                let slope = (after[axis] - before[axis]) / (2.0 * h);
                // Central difference: h²/6 of the third derivative (at most 0.1 (4π)³ = 200) and round-off
                // 1e-16/h.
                assert!((slope - velocity[axis]).abs() < 1e-8, "{law:?}");
            }
        }
    }

    #[test]
    fn the_gate_is_open_in_the_end_and_keeps_its_length() {
        let law = Law::Swing { pivot: vec![0.0, 1.0], angle: PI / 2.0, duration: 0.5 };
        let (position, velocity) = law.motion(0.9, &[0.0, 0.0]);
        // The arm (0, −1) turned by 90° is (1, 0).
        assert!((position[0] - 1.0).abs() < 1e-15 && (position[1] - 1.0).abs() < 1e-15);
        assert!(velocity[0].abs() < 1e-15 && velocity[1].abs() < 1e-15);
        let (half, _) = law.motion(0.25, &[0.0, 0.0]);
        assert!((half[0].hypot(half[1] - 1.0) - 1.0).abs() < 1e-15);
    }
}
