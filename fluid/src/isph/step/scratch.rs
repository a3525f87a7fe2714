//! Memory of a step.

use crate::boundaries::sampling::BoundaryPoints;
use crate::boundaries::ties::Tie;
use crate::interface::StructureSurface;
use crate::isph::interface_load::WallForces;
use crate::isph::pressure::along::Along;
use crate::isph::pressure::conjugate_gradients;
use crate::isph::pressure::hierarchy::Origin;
use crate::isph::pressure::preconditioner::PressurePreconditioner;
use crate::isph::pressure::pressure_operator::OperatorScratch;
use crate::isph::surface::detection::Surface;
use crate::isph::surface::surface_offset::Outside;
use crate::isph::viscosity::{Friction, ImplicitViscosity};
use crate::particles::neighbourhood::Neighbourhood;
use crate::particles::order::ParticleOrder;
use sph::neighbours::NeighbourList;
use sph::{Matrix, Vector};
use std::sync::Arc;

/// What the operator is made of besides neighbours and surface, one entry a particle.
#[derive(Default)]
pub struct Terms<const D: usize> {
    /// What boundaries carry of the pressure's gradient.
    pub along: Along<D>,
    /// What a particle's own pressure is multiplied by in its gradient (1/m).
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
    /// The structure's boundary points, their surface and normals out of it (zero inside).
    pub points: BoundaryPoints<D>,
    pub structure_surface: StructureSurface,
    pub structure_normals: Vec<Vector<D>>,
    pub terms: Terms<D>,
    pub diagonal: Vec<f64>,
    pub right: Vec<f64>,
    pub outside: Outside,
    /// Velocity of the wall across its surface (m/s), one entry per pair of fluid and wall; empty where no
    /// wall moves.
    pub wall_velocities: Vec<Vector<D>>,
    /// Wall particles around structure, and those that stand for it.
    pub walls_of_structure: NeighbourList,
    pub ties: Vec<Tie<D>>,
    pub preconditioner: PressurePreconditioner<D>,
    pub prepared_for: Option<Arc<Origin<D>>>,
    pub solver: conjugate_gradients::Scratch,
    pub operator: OperatorScratch<D>,
    /// [`factors`](crate::isph::viscosity::factors) of the viscous pairs.
    pub viscous_factors: Vec<f64>,
    /// Pairs of fluid and no-slip boundaries.
    pub frictions: Vec<Friction<D>>,
    pub implicit_viscosity: ImplicitViscosity<D>,
    /// Viscous accelerations (m/s²).
    pub viscous: Vec<Vector<D>>,
    /// `D u*` (1/s), where tearing asks for it.
    pub parting: Vec<f64>,
    /// What the known pressures give of the pressure equation's left side (1/s²).
    pub of_known: Vec<f64>,
    pub predicted: Vec<Vector<D>>,
    pub confidence: Vec<f64>,
    pub position_shifts: Vec<Vector<D>>,
    /// Change of velocity (m/s) that Eq. (18) makes to that by the symmetric gradient.
    pub differences: Vec<Vector<D>>,
    /// `G_a` (Pa/m) of the last pressure along boundaries, one entry per row of [`Along`].
    pub gradients_along: Vec<Vector<D>>,
    /// `ρ (g − a_w)` (Pa/m) at each of these rows.
    pub weights_along: Vec<Vector<D>>,
    /// `g_s` (Pa/m): what the projection lays on the structure's boundary points.
    pub structure_gradients: Vec<Vector<D>>,
    /// What the fluid gets from each boundary point, as `R_s` (Pa/m), and the pressures (Pa) beside them.
    pub reactions: Vec<Vector<D>>,
    pub structure_pressures: Vec<f64>,
    /// Volume (m³) of the boundary points that count at each interface particle.
    pub carried: Vec<f64>,
    /// A load on the interface particles (Pa/m).
    pub particle_loads: Vec<Vector<D>>,
    /// Shifts (m) of Eqs. (21)–(30).
    pub shifts: Vec<Vector<D>>,
    /// What each boundary point of the structure gave by friction and contact (kg m/s).
    pub contact_impulses: Vec<Vector<D>>,
    /// Changes of velocity (m/s) by contact, each with the part of the walls that made it.
    pub wall_contacts: Vec<(usize, Vector<D>, Vector<D>)>,
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
