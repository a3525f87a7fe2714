//! A few points that stand for all interface particles, for tools that know scalar variables only.
//!
//! The motion of a point is the moving-least-squares value at it, exact for linear fields
//! ([`structure::MaterialPoint`]); a force at a point is shared over the particles with the same weights. So
//! forces and moments are kept, and the work of the forces on the points is that on the particles, to
//! round-off.

use sph::Vector;
use structure::MaterialPoint;

/// The points and their weights on the interface particles.
#[derive(Clone, Debug)]
pub struct Reduction {
    /// For each point, interface particles and weights.
    weights: Vec<Vec<(usize, f64)>>,
    dimension: usize,
}

impl Reduction {
    /// Of `points` among interface particles at `positions`, both `dimension` coordinates each (m), spaced by
    /// `spacing` (m).
    pub fn new(dimension: usize, points: &[Vec<f64>], positions: &[f64], spacing: f64) -> Self {
        let weights = match dimension {
            2 => weights::<2>(points, positions, spacing),
            _ => weights::<3>(points, positions, spacing),
        };
        Self { weights, dimension }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// One component of a vector field at the particles, seen at a point.
    pub fn value(&self, field: &[f64], point: usize, component: usize) -> f64 {
        let weights = self.weights[point].iter();
        weights.map(|&(particle, weight)| weight * field[particle * self.dimension + component]).sum()
    }

    /// Pressure gradients (Pa/m) at the particles, of volumes `volumes` (m³), whose forces `−V ∇p` are
    /// `forces` (N) at the points.
    pub fn spread(&self, forces: &[f64], volumes: &[f64], out: &mut [f64]) {
        let d = self.dimension;
        out.fill(0.0);
        for (force, weights) in forces.chunks_exact(d).zip(&self.weights) {
            for &(particle, weight) in weights {
                for i in 0..d {
                    out[particle * d + i] -= weight * force[i] / volumes[particle];
                }
            }
        }
    }
}

fn weights<const D: usize>(points: &[Vec<f64>], positions: &[f64], spacing: f64) -> Vec<Vec<(usize, f64)>> {
    let positions: Vec<Vector<D>> = positions.chunks_exact(D).map(Vector::from_column_slice).collect();
    let of = |point: &Vec<f64>| {
        let made = MaterialPoint::new(Vector::from_column_slice(point), &positions, spacing);
        made.expect("a structure has interface particles").weights
    };
    points.iter().map(of).collect()
}

/// `count` of the points at `positions`, as far from each other as can be: first the one farthest from their
/// mean, then always the one farthest from all chosen. The order is that of choice.
pub fn spread_out(dimension: usize, positions: &[f64], count: usize) -> Vec<Vec<f64>> {
    let points: Vec<&[f64]> = positions.chunks_exact(dimension).collect();
    let mean: Vec<f64> = (0..dimension)
        .map(|i| points.iter().map(|p| p[i]).sum::<f64>() / points.len().max(1) as f64)
        .collect();
    let square = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    let mut distances: Vec<f64> = points.iter().map(|p| square(p, &mean)).collect();
    let mut chosen: Vec<Vec<f64>> = Vec::new();
    while chosen.len() < count.min(points.len()) {
        // The first of equals: the same points at every export.
        let mut farthest = 0;
        for (n, distance) in distances.iter().enumerate() {
            if *distance > distances[farthest] {
                farthest = n;
            }
        }
        let from_mean = chosen.is_empty();
        chosen.push(points[farthest].to_vec());
        for (n, point) in points.iter().enumerate() {
            let to_last = square(point, points[farthest]);
            distances[n] = if from_mean { to_last } else { distances[n].min(to_last) };
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice() -> Vec<f64> {
        (0..40).flat_map(|n| [0.1 * f64::from(n % 10) + 0.05, 0.1 * f64::from(n / 10) + 0.05]).collect()
    }

    #[test]
    fn linear_motion_is_seen_exactly_and_force_moment_and_work_are_kept() {
        let positions = lattice();
        let points = spread_out(2, &positions, 5);
        let reduction = Reduction::new(2, &points, &positions, 0.1);
        let linear = |x: f64, y: f64| [0.3 + 2.0 * x - y, 0.1 - x + 0.5 * y];
        let field: Vec<f64> = positions.chunks_exact(2).flat_map(|p| linear(p[0], p[1])).collect();
        let seen: Vec<f64> = (0..10).map(|n| reduction.value(&field, n / 2, n % 2)).collect();
        for (point, seen) in points.iter().zip(seen.chunks_exact(2)) {
            let expected = linear(point[0], point[1]);
            assert!((seen[0] - expected[0]).abs() < 1e-12 && (seen[1] - expected[1]).abs() < 1e-12);
        }
        let forces: Vec<f64> = (0..10).map(|n| f64::from(n) - 4.0).collect();
        let volumes = vec![0.01; 40];
        let mut gradients = vec![0.0; 80];
        reduction.spread(&forces, &volumes, &mut gradients);
        let on_particles: Vec<f64> = gradients.iter().map(|g| -g * 0.01).collect();
        let work = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((work(&on_particles, &field) - work(&forces, &seen)).abs() < 1e-12);
        for i in 0..2 {
            let total = |f: &[f64]| f.iter().skip(i).step_by(2).sum::<f64>();
            assert!((total(&on_particles) - total(&forces)).abs() < 1e-12);
        }
        let moment = |x: &[f64], f: &[f64]| {
            x.chunks_exact(2).zip(f.chunks_exact(2)).map(|(x, f)| x[0] * f[1] - x[1] * f[0]).sum::<f64>()
        };
        let flat: Vec<f64> = points.concat();
        assert!((moment(&positions, &on_particles) - moment(&flat, &forces)).abs() < 1e-12);
    }

    #[test]
    fn points_lie_apart() {
        let points = spread_out(2, &lattice(), 4);
        // Opposite corners first, then between them on alternate sides of the strip of 0.9 by 0.3.
        let expected = [[0.95, 0.35], [0.05, 0.05], [0.55, 0.05], [0.25, 0.35]];
        for (point, expected) in points.iter().zip(expected) {
            assert!((point[0] - expected[0]).abs() + (point[1] - expected[1]).abs() < 1e-9, "{points:?}");
        }
        assert_eq!(spread_out(2, &lattice(), 100).len(), 40);
    }
}
