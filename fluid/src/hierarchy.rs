//! How long a hierarchy of the multigrid preconditioner serves.
//!
//! Making it takes as long as two iterations, and the particles of the next steps are nearly where they were:
//! in a column that collapses (9,000 particles) 6.8 iterations a step became 6.8 with a hierarchy made every
//! 8 steps, 6.9 with every 64. It is kept until iterations tell that it no longer fits.
//!
//! The iterations' rounding depends on the hierarchy, so a [`State`](crate::State) knows which one its next
//! step takes: not the matrices but [`Origin`], what they were made of. A step whose memory holds another
//! hierarchy (after a restart, say) makes it again from there, the same to the bit.

use crate::state::SurfaceClass;
use sph::Vector;
use std::sync::Arc;
use words::bytes::{Error, Reader, Writer};

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

    /// Adds the hierarchy to a state in the making.
    pub fn write(&self, state: &mut Writer) {
        let Origin { time, dt, positions, classes, structure_positions } = &*self.origin;
        state.usize(self.fewest);
        state.usize(self.lost);
        state.f64(*time);
        state.f64(*dt);
        state.vectors(positions);
        state.list(classes, |state, class| state.u8(*class as u8));
        state.vectors(structure_positions);
    }

    /// The hierarchy, of so many fluid particles, that [`write`](Self::write) added.
    ///
    /// # Errors
    /// Bytes that are not one.
    pub fn read(state: &mut Reader, particles: usize) -> Result<Self, Error> {
        let (fewest, lost) = (state.usize("fewest iterations")?, state.usize("lost iterations")?);
        let origin = Origin {
            time: state.f64("time of the preconditioner")?,
            dt: state.f64("step of the preconditioner")?,
            positions: state.vectors("positions of the preconditioner", Some(particles))?,
            classes: SurfaceClass::read(state, "classes of the preconditioner", particles)?,
            structure_positions: state.vectors("interface positions of the preconditioner", None)?,
        };
        Ok(Self { origin: Arc::new(origin), fewest, lost })
    }
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
        let mut state = Writer::new(b"mnsctst1");
        hierarchy.write(&mut state);
        let bytes = state.finish();
        let read = |bytes: &[u8], particles| {
            let mut state = Reader::new("test's state", b"mnsctst1", bytes)?;
            Hierarchy::read(&mut state, particles)
        };
        assert_eq!(read(&bytes, 2), Ok(hierarchy));
        assert!(read(&bytes, 3).is_err());
        assert!(read(&bytes[..bytes.len() - 8], 2).is_err());
    }
}
