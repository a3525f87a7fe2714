//! Loads: what the fluid gives, and dead loads with their history.

use crate::bodies::point::MaterialPoint;
use sph::Vector;

/// Pressure gradient `∇p_s` (Pa/m) at the interface particles over one window, in the order of
/// [`crate::Particles::interface`]; it accelerates by `−∇p_s/ρ_s`, Eq. (48).
#[derive(Clone, Copy, Debug, Default)]
pub enum Load<'a, const D: usize> {
    /// None.
    #[default]
    None,
    /// Held over the window.
    Held(&'a [Vector<D>]),
    /// Linear from the window's start to its end.
    Linear(&'a [Vector<D>], &'a [Vector<D>]),
}

/// A factor over time: piecewise linear through its points, constant before the first and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    points: Vec<(f64, f64)>,
}

impl History {
    /// One at all times.
    pub fn constant() -> Self {
        Self { points: vec![(0.0, 1.0)] }
    }

    /// From zero at t = 0 to one at `duration` (s), one after.
    pub fn ramp(duration: f64) -> Self {
        Self { points: vec![(0.0, 0.0), (duration, 1.0)] }
    }

    /// Through `(time in s, factor)`, times ascending, at least one.
    pub fn through(points: Vec<(f64, f64)>) -> Self {
        assert!(!points.is_empty(), "a history has at least one point");
        assert!(points.windows(2).all(|w| w[0].0 < w[1].0), "times of a history ascend");
        Self { points }
    }

    /// The factor at a time (s).
    pub fn at(&self, time: f64) -> f64 {
        let after = self.points.partition_point(|p| p.0 <= time);
        if after == 0 {
            return self.points[0].1;
        }
        let Some(&(t1, f1)) = self.points.get(after) else { return self.points[after - 1].1 };
        let (t0, f0) = self.points[after - 1];
        f0 + (f1 - f0) * (time - t0) / (t1 - t0)
    }

    /// Whether the factor is the same at all times between.
    pub fn is_constant(&self, from: f64, to: f64) -> bool {
        let f = self.at(from);
        self.at(to) == f && self.points.iter().all(|p| p.0 < from || p.0 > to || p.1 == f)
    }
}

/// A force fixed in direction and place in the material.
#[derive(Clone, Debug, PartialEq)]
pub struct DeadLoad<const D: usize> {
    /// Particles and the share of the force on each; for a force at a point or on a face see
    /// [`crate::MaterialPoint`].
    pub particles: Vec<(usize, f64)>,
    /// Force (N; in two dimensions for one metre of depth) at factor one.
    pub force: Vector<D>,
    /// Its factor over time.
    pub history: History,
}

impl<const D: usize> DeadLoad<D> {
    /// A force (N) at a point of the material, or spread evenly over a face.
    pub fn at(point: &MaterialPoint<D>, force: Vector<D>, history: History) -> Self {
        Self { particles: point.weights.clone(), force, history }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histories_by_hand() {
        let ramp = History::ramp(2.0);
        assert_eq!([ramp.at(-1.0), ramp.at(0.5), ramp.at(2.0), ramp.at(9.0)], [0.0, 0.25, 1.0, 1.0]);
        assert!(ramp.is_constant(2.0, 3.0) && !ramp.is_constant(1.0, 3.0));
        let pulse = History::through(vec![(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)]);
        assert!(!pulse.is_constant(0.0, 2.0) && pulse.is_constant(2.0, 5.0));
        assert!(History::constant().is_constant(-1.0, 1.0));
    }
}
