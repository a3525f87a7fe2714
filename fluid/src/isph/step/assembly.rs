//! Neighbours, surface, and the operator of the pressure Poisson equation.

use crate::boundaries::sampling::BoundaryPoints;
use crate::boundaries::ties;
use crate::error::Error;
use crate::isph::options::{Options, Preconditioner, Scheme};
use crate::isph::pressure::adjoint_pair::{self, AdjointPair};
use crate::isph::pressure::hierarchy::{Hierarchy, Origin};
use crate::isph::pressure::pressure_operator::{PressureOperator, Yielding};
use crate::isph::solver::Isph;
use crate::isph::state::State;
use crate::isph::step::scratch::{ROWS, Scratch, Terms};
use crate::isph::surface::detection::{KNOWN, Surface};
use crate::particles::class::SurfaceClass;
use crate::particles::neighbourhood::{Bodies, Neighbourhood};
use crate::properties::FluidProperties;
use rayon::prelude::*;
use sph::Vector;
use std::sync::Arc;

/// The operator of both solves; where the structure is not `yielding` it is a wall.
pub(super) fn operator<'a, const D: usize>(
    (properties, options): (&FluidProperties<D>, &Options),
    yielding: Option<Yielding<'a>>,
    neighbourhood: &'a Neighbourhood<D>,
    surface: &'a Surface<D>,
    terms: &'a Terms<D>,
) -> PressureOperator<'a, D> {
    PressureOperator {
        pair: AdjointPair { neighbourhood, along: &terms.along, own: &terms.own },
        inverse_density: 1.0 / properties.density,
        yielding,
        pressure_stabilization: options.pressure_stabilization,
        wide_share: if options.scheme == Scheme::Paper { 0.0 } else { 1.0 },
        extra_diagonal: &terms.extra_diagonal,
        free: &surface.free,
    }
}

impl<const D: usize> Isph<D> {
    /// Of fluid particles at `positions` (m), `classes` being those that they had last.
    pub(super) fn find_neighbours(
        &mut self,
        positions: &[Vector<D>],
        classes: &[SurfaceClass],
        structure_positions: &[Vector<D>],
    ) {
        let bodies = Bodies {
            wall_positions: &self.walls.positions,
            wall_volumes: &self.walls.volumes,
            wall_grid: &self.walls.grid,
            structure_positions,
            structure_volumes: &self.sampling.volumes,
        };
        let Scratch {
            neighbourhood,
            corrections,
            surface,
            structure_surface,
            structure_normals,
            walls_of_structure,
            ties,
            ..
        } = &mut self.scratch;
        let (spacing, volume) = (self.properties.spacing, self.properties.particle_volume);
        neighbourhood.update(&self.kernel, spacing, volume, positions, &bodies);
        neighbourhood.corrections(0.25, corrections);
        let h = self.kernel.smoothing_length();
        surface.detect(neighbourhood, corrections, positions, classes, &self.options, h);
        structure_surface.normals(
            &self.kernel,
            structure_positions,
            &self.sampling.volumes,
            structure_normals,
        );
        let walls = &self.walls;
        let outwards = |w: usize| walls.surface_point(walls.part_of[w] as usize, &walls.positions[w], false);
        ties::find(
            self.kernel.support(),
            (&walls.positions, |w| walls.volumes[w].powf(1.0 / D as f64), |w| outwards(w).normal),
            (structure_positions, structure_normals, &self.sampling.spacings),
            walls_of_structure,
            ties,
        );
        neighbourhood.tie(ties, &self.kernel, volume, positions, &bodies);
    }

    /// Makes the diagonal of Eq. (16) divided by α, and the regularisation, of fluid particles at `positions`
    /// (m).
    pub(super) fn assemble(&mut self, positions: &[Vector<D>]) {
        let s = &mut self.scratch;
        // The paper's gradient, Eq. (18), has ways of its own with boundaries.
        let carries = self.options.scheme == Scheme::EnergyConsistent;
        let near = &s.neighbourhood;
        let walls = &self.walls;
        let moves = |w: &u32| walls.part_moves(walls.part_of[*w as usize] as usize);
        let beside = |a: usize| !near.structure.of(a).is_empty() || near.walls.of(a).iter().any(moves);
        // A wall's surface as the particle sees it, one wall after the other.
        let mut seen = (usize::MAX, usize::MAX, Vector::zeros());
        let wall_normal = |a: usize, w: usize| {
            let part = walls.part_of[w] as usize;
            if (a, part) != (seen.0, seen.1) {
                seen = (a, part, walls.surface_point(part, &positions[a], false).normal);
            }
            seen.2
        };
        s.terms.along.find(near, |a| carries && beside(a), &s.structure_normals, wall_normal);
        adjoint_pair::own_gradients(&s.neighbourhood, &s.terms.along, &mut s.terms.own);
        let unit = 1.0 / (self.properties.density * self.properties.spacing.powi(2));
        s.terms.extra_diagonal.clear();
        s.terms.extra_diagonal.resize(s.terms.own.len(), 0.0);
        operator((&self.properties, &self.options), None, &s.neighbourhood, &s.surface, &s.terms)
            .diagonal(&mut s.diagonal);
        s.terms.draw.resize(s.terms.own.len(), 0.0);
        let terms = s.terms.extra_diagonal.par_iter_mut().zip(&mut s.terms.draw);
        terms.zip(&mut s.diagonal).with_min_len(ROWS).enumerate().for_each(
            |(a, ((extra, draw), diagonal))| {
                // Without any surface the mean of the pressure is taken out instead.
                let pocket = s.surface.in_pocket[a] && !s.surface.is_closed();
                let pocket = if pocket { self.options.pocket_regularisation } else { 0.0 };
                let kappa = (self.options.regularisation + pocket) * unit;
                let alpha = s.surface.alpha[a].max(KNOWN);
                *draw = *diagonal * (1.0 / alpha - 1.0);
                *extra = kappa + *draw;
                *diagonal += *extra;
            },
        );
    }

    /// Makes the hierarchy that `accepted` says anew where the memory holds another, as after a restart: the
    /// same to the bit.
    pub(super) fn recover_hierarchy(&mut self, accepted: &State<D>) -> Result<(), Error> {
        let Some(Hierarchy { origin, .. }) = &accepted.memory.hierarchy else { return Ok(()) };
        if self.scratch.is_prepared_for(origin) {
            return Ok(());
        }
        let (found, expected) = (origin.structure_positions.len(), self.sampling.len());
        if found != expected {
            return Err(Error::InterfaceLength { field: "positions in the saved state", found, expected });
        }
        self.walls.move_to(origin.time, (origin.dt, 0.0));
        self.find_neighbours(&origin.positions, &origin.classes, &origin.structure_positions);
        self.assemble(&origin.positions);
        self.prepare(origin);
        Ok(())
    }

    /// The hierarchy that `accepted` says, or a new one of this step's matrix; with it `trial`'s next step
    /// starts.
    pub(super) fn choose_hierarchy(
        &mut self,
        accepted: &State<D>,
        (time, dt): (f64, f64),
        structure: &BoundaryPoints<D>,
        trial: &mut State<D>,
    ) {
        if accepted.memory.hierarchy.is_none() {
            let mut origin = self.scratch.prepared_for.take().unwrap_or_default();
            // The memory of the last one is used again, unless it belongs to a state that someone keeps.
            if Arc::get_mut(&mut origin).is_none() {
                origin = Arc::default();
            }
            let made_of = Arc::get_mut(&mut origin).expect("nobody else has it yet");
            (made_of.time, made_of.dt) = (time, dt);
            made_of.positions.clone_from(&accepted.positions);
            made_of.classes.clone_from(&accepted.classes);
            made_of.structure_positions.clear();
            made_of.structure_positions.extend_from_slice(&structure.positions);
            self.prepare(&origin);
            let kept = self.options.preconditioner == Preconditioner::Multigrid;
            trial.memory.hierarchy = kept.then(|| Hierarchy::new(origin));
        }
    }

    fn prepare(&mut self, origin: &Arc<Origin<D>>) {
        let s = &mut self.scratch;
        let a = operator(
            (&self.properties, &self.options),
            Yielding::of(&self.sampling, &self.compliance),
            &s.neighbourhood,
            &s.surface,
            &s.terms,
        );
        s.preconditioner.prepare(self.options.preconditioner, &a, &s.diagonal);
        s.prepared_for = Some(Arc::clone(origin));
    }
}
