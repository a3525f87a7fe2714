//! Periodic sides: space that repeats.
//!
//! Positions are kept inside the domain; pairs meet through the nearest image, which is the only one within
//! reach while the domain is at least two supports long. Neighbours are found among the particles and ghost
//! images of those near a periodic side, and the lists then name the originals. Walls are not repeated: let
//! them reach a support beyond the periodic sides. Structures have to keep a support away from them.

use sph::Vector;

/// The lengths after which space repeats; nothing repeats by default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Period<const D: usize> {
    low: Vector<D>,
    /// Zero along axes on which nothing repeats.
    length: Vector<D>,
    /// One over the length, or zero.
    inverse: Vector<D>,
}

impl<const D: usize> Default for Period<D> {
    fn default() -> Self {
        Self { low: Vector::zeros(), length: Vector::zeros(), inverse: Vector::zeros() }
    }
}

impl<const D: usize> Period<D> {
    /// Space that repeats with the domain from `low` to `high` (m) along the axes marked.
    pub fn new(periodic: &[bool; D], (low, high): &(Vector<D>, Vector<D>)) -> Self {
        let length: Vector<D> = Vector::from_fn(|i, _| if periodic[i] { high[i] - low[i] } else { 0.0 });
        let inverse = length.map(|l| if l > 0.0 { 1.0 / l } else { 0.0 });
        Self { low: *low, length, inverse }
    }

    /// Whether nothing repeats.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.length == Vector::<D>::zeros()
    }

    /// Period (m) along an axis, zero where nothing repeats.
    pub fn length(&self, axis: usize) -> f64 {
        self.length[axis]
    }

    /// The shortest of the offsets (m) that are the same but for whole periods.
    #[inline]
    pub fn nearest(&self, offset: Vector<D>) -> Vector<D> {
        if self.is_none() {
            return offset;
        }
        offset - self.length.component_mul(&offset.component_mul(&self.inverse).map(f64::round))
    }

    /// The same point inside the domain (m).
    pub fn wrap(&self, point: Vector<D>) -> Vector<D> {
        let cells = (point - self.low).component_mul(&self.inverse).map(f64::floor);
        point - self.length.component_mul(&cells)
    }

    /// Appends to `points` (m), all inside the domain, their images within `reach` (m) of it; `owners` gets
    /// the point that each entry is.
    pub fn add_images(&self, points: &mut Vec<Vector<D>>, reach: f64, owners: &mut Vec<u32>) {
        owners.clear();
        owners.extend(0..points.len() as u32);
        for axis in (0..D).filter(|&i| self.length[i] > 0.0) {
            // Images of images make the corners.
            for i in 0..points.len() {
                let from_low = points[i][axis] - self.low[axis];
                for (near, sign) in [(from_low < reach, 1.0), (self.length[axis] - from_low < reach, -1.0)] {
                    if near {
                        let mut image = points[i];
                        image[axis] += sign * self.length[axis];
                        points.push(image);
                        owners.push(owners[i]);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn v(x: f64, y: f64) -> Vector<2> {
        Vector::from([x, y])
    }

    #[test]
    fn offsets_points_and_images_by_hand() {
        let period = Period::new(&[true, false], &(v(1.0, 0.0), v(3.0, 1.0)));
        assert_eq!(period.nearest(v(1.5, 0.9)), v(-0.5, 0.9));
        assert_eq!(period.wrap(v(3.25, 7.0)), v(1.25, 7.0));
        assert_eq!(period.wrap(v(0.5, -7.0)), v(2.5, -7.0));
        let (mut points, mut owners) = (vec![v(1.1, 0.0), v(2.0, 0.0), v(2.9, 0.0)], Vec::new());
        period.add_images(&mut points, 0.25, &mut owners);
        assert_eq!(owners, [0, 1, 2, 0, 2]);
        assert!((points[3] - v(3.1, 0.0)).norm() < 1e-15 && (points[4] - v(0.9, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn corners_have_images_too() {
        let period = Period::new(&[true, true], &(v(0.0, 0.0), v(1.0, 1.0)));
        let (mut points, mut owners) = (vec![v(0.05, 0.05)], Vec::new());
        period.add_images(&mut points, 0.1, &mut owners);
        assert_eq!(points.len(), 4);
        assert!((points[3] - v(1.05, 1.05)).norm() < 1e-15);
    }
}
