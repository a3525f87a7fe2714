//! Memory of a step.

use crate::interface::StructureSurface;
use crate::isph::interface_load::WallForces;
use crate::isph::pressure::conjugate_gradients;
use crate::isph::pressure::hierarchy::Origin;
use crate::isph::pressure::preconditioner::PressurePreconditioner;
use crate::isph::pressure::pressure_operator::OperatorScratch;
use crate::isph::surface::detection::Surface;
use crate::isph::surface::surface_offset::Outside;
use crate::particles::neighbourhood::Neighbourhood;
use crate::particles::order::ParticleOrder;
use sph::{Matrix, Vector};
use std::sync::Arc;

/// What the operator is made of besides neighbours and surface, one entry a particle.
#[derive(Default)]
pub struct Terms<const D: usize> {
    /// `Σ V ∇W` with the weight 2 on walls and structure (1/m).
    pub own: Vec<Vector<D>>,
    /// What regularisation and Eq. (16) add to the operator's diagonal (m³/kg/m²).
    pub extra_diagonal: Vec<f64>,
    /// The part of it that Eq. (16) adds: how strongly a pressure is drawn towards that of the surface.
    pub draw: Vec<f64>,
}

/// Particles that one task works through at least where little is done for each.
pub const ROWS: usize = 1024;

/// Memory of a step, used again by the next.
#[derive(Default)]
pub struct Scratch<const D: usize> {
    pub neighbourhood: Neighbourhood<D>,
    pub corrections: Vec<(Matrix<D>, f64)>,
    pub surface: Surface<D>,
    pub structure_surface: StructureSurface,
    pub terms: Terms<D>,
    pub diagonal: Vec<f64>,
    pub right: Vec<f64>,
    pub outside: Outside,
    pub wall_rate: Vec<f64>,
    pub preconditioner: PressurePreconditioner<D>,
    pub prepared_for: Option<Arc<Origin<D>>>,
    pub solver: conjugate_gradients::Scratch,
    pub operator: OperatorScratch<D>,
    /// What one stage makes and uses up itself: viscosities, then what known pressures give.
    pub passing_numbers: Vec<f64>,
    pub predicted: Vec<Vector<D>>,
    pub predicted_structure: Vec<Vector<D>>,
    pub confidence: Vec<f64>,
    pub position_shifts: Vec<Vector<D>>,
    /// What one stage makes and uses up itself: viscous accelerations, then the difference that Eq. (18)
    /// makes, then shifts.
    pub passing: Vec<Vector<D>>,
    pub contact_impulses: Vec<Vector<D>>,
    pub wall_forces: WallForces<D>,
    pub keep: Vec<bool>,
    pub torn: Vec<u32>,
    pub order: ParticleOrder,
}

impl<const D: usize> Scratch<D> {
    /// Whether the preconditioner was made of `origin`.
    pub fn is_prepared_for(&self, origin: &Arc<Origin<D>>) -> bool {
        self.prepared_for.as_ref().is_some_and(|made| Arc::ptr_eq(made, origin) || made == origin)
    }
}
