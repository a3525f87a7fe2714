//! Snapshots of the fluid: velocity, pressure, class by surroundings.

use super::failed;
use crate::{State, Walls};
use interfaces::ParticipantError;
use output::{ParticleFrame, PointArray, Series, Values};
use sph::Vector;
use std::path::{Path, PathBuf};

/// The series `fluid`.
pub struct Snapshots {
    series: Series,
    out: PathBuf,
    /// Begun with the first walls that are written.
    walls: Option<Series>,
}

impl Snapshots {
    /// Starts the series in the folder `out`.
    pub fn create(out: &Path) -> Result<Self, ParticipantError> {
        let series = Series::create(out, "fluid").map_err(failed)?;
        Ok(Self { series, out: out.to_owned(), walls: None })
    }

    /// Writes the walls' particles at `time` (s), at which they are.
    pub fn write_walls<const D: usize>(
        &mut self,
        time: f64,
        walls: &Walls<D>,
    ) -> Result<(), ParticipantError> {
        if walls.positions.is_empty() {
            return Ok(());
        }
        let positions = flat(&walls.positions);
        let parts: Vec<i32> = walls.part_of.iter().map(|&part| part as i32).collect();
        let arrays = [PointArray { name: "part", components: 1, values: Values::I32(&parts) }];
        let frame = ParticleFrame { time, dimension: D, positions: &positions, arrays: &arrays };
        let series = match &mut self.walls {
            Some(series) => series,
            begun => begun.insert(Series::create(&self.out, "walls").map_err(failed)?),
        };
        series.write(&frame).map_err(failed)?;
        Ok(())
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

    /// Writes what a failed solve stood on as the series `failed_solve` and gives the file: positions, velocities and pressures
    /// of `accepted`, the unknowns where the solve `stopped`, and its residual. Arrays are shortened or filled with zeros where a length disagrees.
    pub fn write_failed_solve<const D: usize>(
        &self,
        time: f64,
        accepted: &State<D>,
        stopped: &State<D>,
        residual: &[f64],
    ) -> Result<PathBuf, ParticipantError> {
        let as_long = |values: &[f64]| {
            let mut values = values.to_vec();
            values.resize(accepted.len(), 0.0);
            values
        };
        let (positions, velocities) = (flat(&accepted.positions), flat(&accepted.velocities));
        let classes: Vec<u8> = accepted.classes.iter().map(|c| *c as u8).collect();
        let ids: Vec<i32> = accepted.ids.iter().map(|&i| i as i32).collect();
        let (pressures, potentials) = (as_long(&stopped.pressures), as_long(&stopped.position_potentials));
        let residual = as_long(residual);
        let arrays = [
            PointArray::vector("velocity", D, &velocities),
            PointArray::scalar("pressure", &accepted.pressures),
            PointArray::scalar("pressure_where_stopped", &pressures),
            PointArray::scalar("position_potential_where_stopped", &potentials),
            PointArray::scalar("residual", &residual),
            PointArray::class("surface_class", &classes),
            PointArray { name: "id", components: 1, values: Values::I32(&ids) },
        ];
        let frame = ParticleFrame { time, dimension: D, positions: &positions, arrays: &arrays };
        Series::create(&self.out, "failed_solve").and_then(|mut series| series.write(&frame)).map_err(failed)
    }
}

fn flat<const D: usize>(vectors: &[Vector<D>]) -> Vec<f64> {
    vectors.iter().flat_map(|v| v.iter().copied()).collect()
}
