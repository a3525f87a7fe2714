//! The weights of a mapping, with where the points stood for which they were made.

use crate::mapping::{Mapping, MappingError, Settings};
use words::bytes::{Error, Reader, Writer};

/// First bytes of a saved state; the last is the version of its layout.
const MAGIC: &[u8; 8] = b"mnscmap1";

/// A mapping between points of the structure and those of the fluid, which both move.
pub struct Weights {
    mapping: Mapping,
    /// Positions for which the weights were made (m): of the sources, of the targets.
    made_at: [Vec<f64>; 2],
    /// Displacements of the sources since then (m).
    moved: Vec<f64>,
    /// Memory for the targets' positions (m).
    followed: Vec<f64>,
    dimension: usize,
}

impl Weights {
    /// Makes the weights for these positions (m), with so many threads when they are made again.
    pub fn build(settings: Settings, made_at: [Vec<f64>; 2], threads: usize) -> Result<Self, MappingError> {
        let dimension = settings.dimension;
        let mut mapping = Mapping::build(settings, &made_at[0], &made_at[1])?;
        mapping.use_threads(threads);
        Ok(Self { mapping, made_at, moved: Vec::new(), followed: Vec::new(), dimension })
    }

    /// The mapping, for what does not depend on where the points stood.
    pub fn mapping(&self) -> &Mapping {
        &self.mapping
    }

    /// Where the targets stood (m).
    pub fn targets_made_at(&self) -> &[f64] {
        &self.made_at[1]
    }

    /// How far (m) the targets have gone since, of sources that are `now` there (m).
    pub fn displacement(&mut self, now: &[f64], of_targets: &mut [f64]) {
        self.moved.clear();
        self.moved.extend(now.iter().zip(&self.made_at[0]).map(|(now, then)| now - then));
        self.mapping.consistent(self.dimension, &self.moved, of_targets);
    }

    /// Where (m) the targets are, of sources that are `now` there (m).
    pub fn position(&mut self, now: &[f64], of_targets: &mut [f64]) {
        self.displacement(now, of_targets);
        of_targets.iter_mut().zip(&self.made_at[1]).for_each(|(x, then)| *x += then);
    }

    /// Makes the weights anew, for sources that are `now` there (m) and targets that went along.
    pub fn follow(&mut self, now: &[f64]) -> Result<(), MappingError> {
        let mut followed = std::mem::take(&mut self.followed);
        followed.resize(self.made_at[1].len(), 0.0);
        self.position(now, &mut followed);
        self.followed = std::mem::replace(&mut self.made_at[1], followed);
        self.made_at[0].copy_from_slice(now);
        self.mapping.update(&self.made_at[0], &self.made_at[1])
    }

    /// Where the weights were made, and the participant's own state.
    pub fn save(&self, own: &[u8]) -> Vec<u8> {
        let mut state = Writer::new(MAGIC);
        self.made_at.iter().for_each(|positions| state.f64s(positions));
        state.bytes(own);
        state.finish()
    }

    /// Makes the weights for where those of a saved state were made. Gives the participant's own state.
    pub fn restore<'a>(&mut self, state: &'a [u8]) -> Result<&'a [u8], WeightsError> {
        let mut state = Reader::new("mapping's state", MAGIC, state)?;
        let positions = [("sources", self.made_at[0].len()), ("targets", self.made_at[1].len())];
        let [source, target] = positions.map(|(which, count)| state.f64s(which, Some(count)));
        let (made_at, own) = ([source?, target?], state.bytes("participant's state")?);
        state.finish()?;
        self.mapping.update(&made_at[0], &made_at[1])?;
        self.made_at = made_at;
        Ok(own)
    }
}

/// Why weights are not those of a saved state.
#[derive(Debug, thiserror::Error)]
pub enum WeightsError {
    /// It is no state of this mapping.
    #[error(transparent)]
    State(#[from] Error),
    /// The positions allow no mapping.
    #[error(transparent)]
    Mapping(#[from] MappingError),
}
