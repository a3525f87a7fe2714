//! Snapshots of the structure: displacement, velocity, stress, strain energy.

use super::error::failed;
use crate::particles::Particles;
use crate::solid::Solid;
use crate::state::{Derived, State};
use interfaces::Result;
use output::{ParticleFrame, PointArray, Series};
use sph::Vector;
use std::path::Path;

/// The series `structure`, and memory for its arrays.
pub struct Snapshots<const D: usize> {
    series: Series,
    derived: Derived<D>,
    clamped: Vec<u8>,
}

impl<const D: usize> Snapshots<D> {
    /// Starts the series in the folder `out`.
    pub fn create(out: &Path, particles: &Particles<D>) -> Result<Self> {
        let series = Series::create(out, "structure").map_err(failed)?;
        let clamped = particles.clamped.iter().map(|&c| u8::from(c)).collect();
        Ok(Self { series, derived: Derived::default(), clamped })
    }

    /// Times (s) of the snapshots so far.
    pub fn times(&self) -> &[f64] {
        self.series.times()
    }

    /// Goes on behind snapshots of these times (s).
    pub fn go_on(&mut self, times: Vec<f64>) -> Result<()> {
        self.series.go_on(times).map_err(failed)
    }

    /// Writes the next snapshot.
    pub fn write(&mut self, solid: &mut impl Solid<D>, state: &State<D>) -> Result<()> {
        solid.derive(state, &mut self.derived).map_err(failed)?;
        let particles = solid.particles();
        let stress = |i: usize, j: usize| -> Vec<f64> {
            self.derived.cauchy_stress.iter().map(|sigma| sigma[(i, j)]).collect()
        };
        let stresses =
            [("stress_xx", stress(0, 0)), ("stress_yy", stress(1, 1)), ("stress_xy", stress(0, 1))];
        let (positions, velocities) = (flat(&state.positions), flat(&state.velocities));
        let displacements = flat(&particles.displacements(&state.positions));
        let mut arrays = vec![
            PointArray::vector("displacement", D, &displacements),
            PointArray::vector("velocity", D, &velocities),
            PointArray::scalar("von_mises_stress", &self.derived.von_mises),
            PointArray::scalar("strain_energy_density", &self.derived.strain_energy_density),
            PointArray::scalar("reference_volume", &particles.volumes),
            PointArray::class("clamped", &self.clamped),
        ];
        arrays.extend(stresses.iter().map(|(name, values)| PointArray::scalar(name, values)));
        let frame = ParticleFrame { time: state.time, dimension: D, positions: &positions, arrays: &arrays };
        self.series.write(&frame).map_err(failed)?;
        Ok(())
    }
}

fn flat<const D: usize>(vectors: &[Vector<D>]) -> Vec<f64> {
    vectors.iter().flat_map(|v| v.iter().copied()).collect()
}
