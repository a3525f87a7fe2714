//! Snapshots of the fluid: velocity, pressure, class by surroundings.

use super::failed;
use crate::boundaries::walls::Walls;
use crate::particles::state::State;
use interfaces::Result;
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
    pub fn create(out: &Path) -> Result<Self> {
        let series = Series::create(out, "fluid").map_err(failed)?;
        Ok(Self { series, out: out.to_owned(), walls: None })
    }

    /// Times (s) of the snapshots so far, of the fluid and of its walls.
    pub fn times(&self) -> [&[f64]; 2] {
        [self.series.times(), self.walls.as_ref().map_or(&[], Series::times)]
    }

    /// Goes on behind snapshots of these times (s).
    pub fn go_on(&mut self, [fluid, walls]: [Vec<f64>; 2]) -> Result<()> {
        self.series.go_on(fluid).map_err(failed)?;
        match &mut self.walls {
            Some(series) => series.go_on(walls).map_err(failed),
            None => Ok(()),
        }
    }

    /// Writes the walls' particles at `time` (s), at which they are.
    pub fn write_walls<const D: usize>(&mut self, time: f64, walls: &Walls<D>) -> Result<()> {
        if walls.positions.is_empty() {
            return Ok(());
        }
        let positions: Vec<f64> = walls.positions.iter().flat_map(|r| r.iter().copied()).collect();
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

    /// Writes the next snapshot, at `time` (s): particles in the order of their numbers, whatever that of the
    /// state is.
    pub fn write<const D: usize, M>(&mut self, time: f64, state: &State<D, M>) -> Result<()> {
        let order = state.by_id();
        let (positions, velocities) = (flat(&order, &state.positions), flat(&order, &state.velocities));
        let pressures = arranged(&order, |a| state.pressures[a]);
        let classes = arranged(&order, |a| state.classes[a] as u8);
        let ids = arranged(&order, |a| state.ids[a] as i32);
        let arrays = [
            PointArray::vector("velocity", D, &velocities),
            PointArray::scalar("pressure", &pressures),
            PointArray::class("surface_class", &classes),
            PointArray { name: "id", components: 1, values: Values::I32(&ids) },
        ];
        let frame = ParticleFrame { time, dimension: D, positions: &positions, arrays: &arrays };
        self.series.write(&frame).map_err(failed)?;
        Ok(())
    }

    /// Writes what a failed solve stood on as the series `failed_solve` and gives the file: positions,
    /// velocities and pressures of `accepted`, and the method's `fields`, which are in the order of
    /// `accepted`. Fields that are too short are filled with zeros.
    pub fn write_failed_solve<const D: usize, M>(
        &self,
        time: f64,
        accepted: &State<D, M>,
        fields: &[(&'static str, &[f64])],
    ) -> Result<PathBuf> {
        let order = accepted.by_id();
        let or_zero = |values: &[f64]| arranged(&order, |a| values.get(a).copied().unwrap_or(0.0));
        let (positions, velocities) = (flat(&order, &accepted.positions), flat(&order, &accepted.velocities));
        let classes = arranged(&order, |a| accepted.classes[a] as u8);
        let ids = arranged(&order, |a| accepted.ids[a] as i32);
        let pressures = or_zero(&accepted.pressures);
        let fields: Vec<_> = fields.iter().map(|(name, values)| (*name, or_zero(values))).collect();
        let mut arrays =
            vec![PointArray::vector("velocity", D, &velocities), PointArray::scalar("pressure", &pressures)];
        arrays.extend(fields.iter().map(|(name, values)| PointArray::scalar(name, values)));
        arrays.push(PointArray::class("surface_class", &classes));
        arrays.push(PointArray { name: "id", components: 1, values: Values::I32(&ids) });
        let frame = ParticleFrame { time, dimension: D, positions: &positions, arrays: &arrays };
        Series::create(&self.out, "failed_solve").and_then(|mut series| series.write(&frame)).map_err(failed)
    }
}

/// One value a particle, in this `order`.
fn arranged<T>(order: &[u32], value: impl Fn(usize) -> T) -> Vec<T> {
    order.iter().map(|&a| value(a as usize)).collect()
}

fn flat<const D: usize>(order: &[u32], vectors: &[Vector<D>]) -> Vec<f64> {
    order.iter().flat_map(|&a| vectors[a as usize].iter().copied()).collect()
}
