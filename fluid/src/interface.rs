//! The structure's particles as the fluid sees them, and what it gives back.

use crate::error::Error;
use rayon::prelude::*;
use sph::Vector;
use sph::kernel::CubicSpline;
use sph::neighbours::{CellGrid, NeighbourList};

/// What never changes of the interface particles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InterfaceParticles<const D: usize> {
    /// Positions at the start (m).
    pub positions: Vec<Vector<D>>,
    /// Reference volumes (m³).
    pub volumes: Vec<f64>,
    /// Densities (kg/m³); zero for particles that are held and do not yield to their load.
    pub densities: Vec<f64>,
}

/// What the structure sends for one window.
#[derive(Clone, Copy, Debug)]
pub struct InterfaceInput<'a, const D: usize> {
    /// Positions at the window's start (m).
    pub positions: &'a [Vector<D>],
    /// Velocities (m/s) predicted under the load held from the last window: the mean over the window, or
    /// that at its end ([`StructureVelocity`](crate::StructureVelocity)).
    pub velocities: &'a [Vector<D>],
    /// That load as a pressure gradient (Pa/m): it accelerated the structure by `−g/ρ_s`.
    pub held_pressure_gradients: &'a [Vector<D>],
}

impl<const D: usize> InterfaceInput<'_, D> {
    /// No structure.
    pub const NONE: Self = Self { positions: &[], velocities: &[], held_pressure_gradients: &[] };

    /// Checks lengths and finite values.
    pub fn check(&self, expected: usize, time: f64) -> Result<(), Error> {
        for (field, values) in [
            ("positions", self.positions),
            ("velocities", self.velocities),
            ("held pressure gradients", self.held_pressure_gradients),
        ] {
            if values.len() != expected {
                return Err(Error::InterfaceLength { field, found: values.len(), expected });
            }
            if let Some(particle) = values.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
                let remedy = "the structure has diverged: shorten its sub-steps or the window";
                return Err(Error::NotFinite { field, particle, time, remedy });
            }
        }
        Ok(())
    }
}

/// What the fluid gives back, one entry an interface particle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InterfaceOutput<const D: usize> {
    /// Load on the structure as a pressure gradient `g_s` (Pa/m): the force on particle s is `−V_s g_s`.
    pub pressure_gradients: Vec<Vector<D>>,
    /// `R_s` (Pa/m): the fluid received the force `+V_s R_s` from particle s in this step, contact and
    /// friction included.
    pub pair_reactions: Vec<Vector<D>>,
    /// Unit normals out of the structure; zero deep inside.
    pub normals: Vec<Vector<D>>,
    /// Pressures (Pa) of the fluid beside each particle, zero where it is dry.
    pub pressures: Vec<f64>,
}

/// Normals of the structure's surface.
#[derive(Clone, Debug, Default)]
pub struct StructureSurface {
    list: NeighbourList,
}

/// `|Σ_s V_s ∇W| h` below which a particle counts as deep inside: one layer below a flat surface it is 0.03,
/// in the surface layer 0.56 (lattice, h = 1.2 Δx).
const EXPOSED: f64 = 0.25;

impl StructureSurface {
    /// `−Σ V ∇W/|…|` over the structure's own particles.
    pub fn normals<const D: usize>(
        &mut self,
        kernel: &CubicSpline<D>,
        positions: &[Vector<D>],
        volumes: &[f64],
        out: &mut Vec<Vector<D>>,
    ) {
        let grid = CellGrid::new(positions, kernel.support());
        self.list.rebuild(positions, &grid, positions);
        out.resize(positions.len(), Vector::zeros());
        out.par_iter_mut().with_min_len(128).enumerate().for_each(|(s, normal)| {
            let mut inward = Vector::zeros();
            for &t in self.list.of(s) {
                inward += kernel.gradient(&(positions[s] - positions[t as usize])) * volumes[t as usize];
            }
            let length = inward.norm();
            let exposed = length * kernel.smoothing_length() > EXPOSED;
            *normal = if exposed { inward / -length } else { Vector::zeros() };
        });
    }
}
