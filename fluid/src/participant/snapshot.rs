//! Snapshots of the fluid: velocity, pressure, class by surroundings.

use super::failed;
use crate::State;
use interfaces::ParticipantError;
use output::{ParticleFrame, PointArray, Series, Values};
use sph::Vector;
use std::path::Path;

/// The series `fluid`.
pub struct Snapshots {
    series: Series,
}

impl Snapshots {
    /// Starts the series in the folder `out`.
    pub fn create(out: &Path) -> Result<Self, ParticipantError> {
        Ok(Self { series: Series::create(out, "fluid").map_err(failed)? })
    }

    /// Writes the next snapshot, at `time` (s).
    pub fn write<const D: usize>(&mut self, time: f64, state: &State<D>) -> Result<(), ParticipantError> {
        let (positions, velocities) = (flat(&state.positions), flat(&state.velocities));
        let classes: Vec<u8> = state.classes.iter().map(|c| *c as u8).collect();
        let ids: Vec<i32> = state.ids.iter().map(|&i| i as i32).collect();
        let arrays = [
            PointArray::vector("velocity", D, &velocities),
            PointArray::scalar("pressure", &state.pressures),
            PointArray::class("surface_class", &classes),
            PointArray { name: "id", components: 1, values: Values::I32(&ids) },
        ];
        let frame = ParticleFrame { time, dimension: D, positions: &positions, arrays: &arrays };
        self.series.write(&frame).map_err(failed)?;
        Ok(())
    }
}

fn flat<const D: usize>(vectors: &[Vector<D>]) -> Vec<f64> {
    vectors.iter().flat_map(|v| v.iter().copied()).collect()
}
