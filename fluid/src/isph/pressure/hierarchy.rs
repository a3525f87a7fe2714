//! How long a hierarchy of the multigrid preconditioner serves.
//!
//! Making it takes as long as two iterations, and the particles of the next steps are nearly where they were:
//! in a column that collapses (9,000 particles) 6.8 iterations a step became 6.8 with a hierarchy made every
//! 8 steps, 6.9 with every 64. It is kept until iterations tell that it no longer fits.
//!
//! The iterations' rounding depends on the hierarchy, so a [`State`](crate::State) knows which one its next
//! step takes: not the matrices but [`Origin`], what they were made of. A step whose memory holds another
//! hierarchy (after a restart, say) makes it again from there, the same to the bit.

use crate::particles::class::SurfaceClass;
use sph::Vector;
use std::sync::Arc;

/// Iterations that making a hierarchy takes as long as: when the old one has lost so many, a new one is made.
/// In `cases/elastic_gate`, whose fluid splashes, being more patient (losses of more than one a step only,
/// three of them) cost more iterations than it saved.
const WORTH: usize = 2;

/// Everything that the preconditioner's matrix is made of and that changes in time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Origin<const D: usize> {
    /// Time (s) at which walls that move stood where they did.
    pub time: f64,
    /// Length (s) of the step that it was made for.
    pub dt: f64,
    /// Fluid particles (m).
    pub positions: Vec<Vector<D>>,
    /// Their classes as they had been.
    pub classes: Vec<SurfaceClass>,
    /// Interface particles (m).
    pub structure_positions: Vec<Vector<D>>,
}

/// A hierarchy in use.
#[derive(Clone, Debug, PartialEq)]
pub struct Hierarchy<const D: usize> {
    /// What it was made of.
    pub origin: Arc<Origin<D>>,
    /// Fewest iterations that both solves of a step took with it.
    pub fewest: usize,
    /// Iterations over those, lost since.
    pub lost: usize,
}

impl<const D: usize> Hierarchy<D> {
    /// A hierarchy that has not been used yet.
    pub fn new(origin: Arc<Origin<D>>) -> Self {
        Self { origin, fewest: usize::MAX, lost: 0 }
    }

    /// Counts a step whose solves took so many iterations; whether the next step is to use the hierarchy too.
    pub fn serves(&mut self, iterations: usize) -> bool {
        self.fewest = self.fewest.min(iterations);
        self.lost = self.lost + iterations - self.fewest;
        self.lost < WORTH
    }

    /// The hierarchy as bytes (little endian).
    pub fn to_bytes(&self) -> Vec<u8> {
        let Origin { time, dt, positions, classes, structure_positions } = &*self.origin;
        let mut bytes = Vec::new();
        for n in [self.fewest, self.lost, positions.len(), structure_positions.len()] {
            bytes.extend_from_slice(&(n as u64).to_le_bytes());
        }
        let points = positions.iter().chain(structure_positions).flat_map(|r| r.iter());
        for x in [time, dt].into_iter().chain(points) {
            bytes.extend_from_slice(&x.to_le_bytes());
        }
        bytes.extend(classes.iter().map(|class| *class as u8));
        bytes
    }

    /// The hierarchy that [`to_bytes`](Self::to_bytes) wrote; nothing where the bytes are not one.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (head, rest) = bytes.split_at_checked(32)?;
        let head: Vec<usize> = words(head).map(|w| u64::from_le_bytes(w) as usize).collect();
        let [fewest, lost, fluid, structure] = head[..] else { return None };
        let (rest, classes) = rest.split_at_checked(8 * (2 + D * fluid.checked_add(structure)?))?;
        if classes.len() != fluid {
            return None;
        }
        let classes = classes.iter().map(|&class| SurfaceClass::from_byte(class)).collect::<Option<_>>()?;
        let numbers: Vec<f64> = words(rest).map(f64::from_le_bytes).collect();
        let points = |range: std::ops::Range<usize>| {
            numbers[2 + D * range.start..2 + D * range.end]
                .chunks_exact(D)
                .map(Vector::from_column_slice)
                .collect()
        };
        let (positions, structure_positions) = (points(0..fluid), points(fluid..fluid + structure));
        let origin = Origin { time: numbers[0], dt: numbers[1], positions, classes, structure_positions };
        Some(Self { origin: Arc::new(origin), fewest, lost })
    }
}

fn words(bytes: &[u8]) -> impl Iterator<Item = [u8; 8]> + '_ {
    bytes.chunks_exact(8).map(|word| word.try_into().expect("eight bytes make a word"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hierarchy_serves_until_it_has_lost_what_a_new_one_costs() {
        let mut hierarchy = Hierarchy::<2>::new(Arc::default());
        for (iterations, fewest, lost) in [(8, 8, 0), (7, 7, 0), (8, 7, 1), (7, 7, 1)] {
            assert!(hierarchy.serves(iterations));
            assert_eq!((hierarchy.fewest, hierarchy.lost), (fewest, lost));
        }
        assert!(!hierarchy.serves(8));
    }

    #[test]
    fn bytes_give_the_same_hierarchy_back() {
        let v = |x: f64, y: f64| Vector::<2>::from([x, y]);
        let origin = Origin {
            time: 0.1,
            dt: 1e-3,
            positions: vec![v(0.1, 0.2), v(0.3, 0.4)],
            classes: vec![SurfaceClass::Splash, SurfaceClass::Surface],
            structure_positions: vec![v(0.5, 0.6)],
        };
        let hierarchy = Hierarchy { origin: Arc::new(origin), fewest: 7, lost: 2 };
        let bytes = hierarchy.to_bytes();
        assert_eq!(Hierarchy::from_bytes(&bytes), Some(hierarchy));
        assert_eq!(Hierarchy::<2>::from_bytes(&bytes[..bytes.len() - 8]), None);
    }
}
