//! What a structure is made of: bodies, loads and options, and the checks on them.

use crate::cells::Cell;
use crate::load::DeadLoad;
use crate::material::Material;
use crate::options::{Gradient, Options, SAFETY};
use crate::{ErrorKind, SetupError};
use sph::lattice::Lattice;
use sph::{Matrix, Vector};

/// One of the two sides of a box along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The side of the smaller coordinate.
    Low,
    /// The side of the larger coordinate.
    High,
}

/// One elastic body: particles with their volumes, all of one material. Particles see those of their own body
/// only.
#[derive(Clone, Debug, PartialEq)]
pub struct Body<const D: usize> {
    /// Reference positions `X` (m).
    pub positions: Vec<Vector<D>>,
    /// Reference volumes `V` (m³), none negative; only clamped particles may have none.
    pub volumes: Vec<f64>,
    /// Cell edge along each axis (m): the particle spacing.
    pub cell: Vector<D>,
    /// Centroid of each particle's cell less its position (m), and second moments about the centroid over the
    /// volume (m²), for the quadratic gradient. Particles beyond the end of these lists (all, where they are
    /// empty) have the lattice's.
    pub centroid_offsets: Vec<Vector<D>>,
    /// See `centroid_offsets`.
    pub second_moments: Vec<Matrix<D>>,
    /// Whether the particle is fixed. Fixed particles take part fully in `K`, `F` and `P`.
    pub clamped: Vec<bool>,
    /// Material.
    pub material: Material,
    /// Reference density `ρ_s` (kg/m³).
    pub density: f64,
}

impl<const D: usize> Body<D> {
    /// A free box from `low` to `high` (m) on a lattice of cells near `spacing` (m) that tile it.
    pub fn block(low: Vector<D>, high: Vector<D>, spacing: f64, material: Material, density: f64) -> Self {
        let lattice = Lattice::fill_box(low, high, spacing);
        let count = lattice.positions.len();
        Self {
            volumes: vec![lattice.cell_volume(); count],
            cell: lattice.cell,
            positions: lattice.positions,
            centroid_offsets: Vec::new(),
            second_moments: Vec::new(),
            clamped: vec![false; count],
            material,
            density,
        }
    }

    /// A free body of particles that are no lattice, about `spacing` (m) apart, each with its cell
    /// ([`crate::voronoi_cells`] in two dimensions). The two lists are of one length.
    pub fn from_cells(
        positions: Vec<Vector<D>>,
        cells: &[Cell<D>],
        spacing: f64,
        material: Material,
        density: f64,
    ) -> Self {
        Self {
            volumes: cells.iter().map(|c| c.volume).collect(),
            cell: Vector::repeat(spacing),
            clamped: vec![false; positions.len()],
            positions,
            centroid_offsets: cells.iter().map(|c| c.offset).collect(),
            second_moments: cells.iter().map(|c| c.moment).collect(),
            material,
            density,
        }
    }

    /// Centroid offset (m) and second moments (m²) of a particle's cell.
    pub(crate) fn shape(&self, particle: usize) -> (Vector<D>, Matrix<D>) {
        match (self.centroid_offsets.get(particle), self.second_moments.get(particle)) {
            (Some(&offset), Some(&moment)) => (offset, moment),
            _ => (Vector::zeros(), Cell::of_lattice(&self.cell).moment),
        }
    }

    /// Adds fixed nodes without volume or mass, about a spacing apart on the clamp's true plane: the clamp of
    /// a body whose particles do not follow it, for the quadratic gradient.
    #[must_use]
    pub fn with_fixed_nodes(mut self, nodes: &[Vector<D>]) -> Self {
        self.positions.extend_from_slice(nodes);
        self.volumes.resize(self.positions.len(), 0.0);
        self.clamped.resize(self.positions.len(), true);
        self
    }

    /// Clamps the face of a box: adds `rows` rows of fixed particles beyond it, each a copy of the row at the
    /// face moved out. The first-order gradient wants as many rows as its support is wide, see
    /// [`Body::rows_for_clamp`].
    #[must_use]
    pub fn with_fixed_rows(mut self, axis: usize, side: Side, rows: usize) -> Self {
        let outward = if side == Side::Low { -self.cell[axis] } else { self.cell[axis] };
        let at_face = self.particles_at_face(axis, side);
        for row in 1..=rows {
            for &i in &at_face {
                let mut position = self.positions[i];
                position[axis] += row as f64 * outward;
                self.positions.push(position);
                self.volumes.push(self.volumes[i]);
                self.clamped.push(true);
            }
        }
        self
    }

    /// Clamps the face of a box: adds fixed nodes without volume or mass on the face itself, one before each
    /// particle of the row at the face. For the quadratic gradient, which sees them as neighbours only; the
    /// clamp is then where the face is.
    #[must_use]
    pub fn with_fixed_face(mut self, axis: usize, side: Side) -> Self {
        let outward = if side == Side::Low { -0.5 } else { 0.5 } * self.cell[axis];
        for i in self.particles_at_face(axis, side) {
            let mut position = self.positions[i];
            position[axis] += outward;
            self.positions.push(position);
            self.volumes.push(0.0);
            self.clamped.push(true);
        }
        self
    }

    /// Clamps the face of a box as the gradient wants it: on the face for the quadratic one, by fixed rows
    /// beyond it for the first-order one.
    #[must_use]
    pub fn clamp(self, axis: usize, side: Side, gradient: Gradient, smoothing_ratio: f64) -> Self {
        match gradient {
            Gradient::FirstOrder => {
                let rows = Self::rows_for_clamp(smoothing_ratio);
                self.with_fixed_rows(axis, side, rows)
            }
            Gradient::Quadratic => self.with_fixed_face(axis, side),
        }
    }

    /// The outermost particles of a box on one side, clamped ones left out.
    pub fn particles_at_face(&self, axis: usize, side: Side) -> Vec<usize> {
        let free = || (0..self.positions.len()).filter(|&i| !self.clamped[i]);
        let coordinates = free().map(|i| self.positions[i][axis]);
        let face = match side {
            Side::Low => coordinates.fold(f64::INFINITY, f64::min),
            Side::High => coordinates.fold(f64::NEG_INFINITY, f64::max),
        };
        free().filter(|&i| (self.positions[i][axis] - face).abs() < 0.25 * self.cell[axis]).collect()
    }

    /// Rows of fixed particles as deep as the support of a kernel with this ratio of smoothing length to
    /// spacing.
    pub fn rows_for_clamp(smoothing_ratio: f64) -> usize {
        (2.0 * smoothing_ratio).ceil() as usize
    }

    /// Mean of the cell's edges (m): the spacing that smoothing lengths refer to.
    pub fn spacing(&self) -> f64 {
        self.cell.mean()
    }
}

/// Everything a structure is made of.
#[derive(Clone, Debug)]
pub struct Setup<const D: usize> {
    /// The bodies. Particles are counted through them in this order.
    pub bodies: Vec<Body<D>>,
    /// Gravity (m/s²).
    pub gravity: Vector<D>,
    /// Dead loads.
    pub dead_loads: Vec<DeadLoad<D>>,
    /// Choices of the method.
    pub options: Options,
}

impl<const D: usize> Setup<D> {
    /// Bodies without loads, with the default options: the quadratic gradient. Clamp them for the same gradient
    /// ([`Body::clamp`]).
    pub fn new(bodies: Vec<Body<D>>) -> Self {
        Self { bodies, gravity: Vector::zeros(), dead_loads: Vec::new(), options: Options::default() }
    }

    /// Finds all mistakes.
    pub(crate) fn check(&self) -> Result<(), SetupError> {
        let mut mistakes = Vec::new();
        if self.bodies.iter().all(|b| b.clamped.iter().all(|&c| c)) {
            mistakes.push(ErrorKind::NothingToMove);
        }
        let mut first = 0;
        for (index, body) in self.bodies.iter().enumerate() {
            check_body(index, first, body, &mut mistakes);
            first += body.positions.len();
        }
        if self.options.gradient == Gradient::Quadratic && mistakes.is_empty() {
            for (index, body) in self.bodies.iter().enumerate() {
                mistakes.extend(too_thin(index, body));
            }
        }
        let mut positive = |name: &'static str, value: f64, zero_allowed: bool| {
            if !value.is_finite() || value < 0.0 || (value == 0.0 && !zero_allowed) {
                mistakes.push(ErrorKind::Option { name, value });
            }
        };
        positive("smoothing_ratio", self.options.smoothing_ratio, false);
        positive("damping", self.options.damping, true);
        positive("hourglass", self.options.hourglass, true);
        if !(self.options.step_fraction > 0.0 && self.options.step_fraction <= SAFETY) {
            mistakes.push(ErrorKind::Option { name: "step_fraction", value: self.options.step_fraction });
        }
        if !self.gravity.iter().all(|g| g.is_finite()) {
            mistakes.push(ErrorKind::Option { name: "gravity", value: f64::NAN });
        }
        for (load, dead) in self.dead_loads.iter().enumerate() {
            if let Some(&(particle, _)) = dead.particles.iter().find(|(p, _)| *p >= first) {
                mistakes.push(ErrorKind::LoadedParticle { load, particle, count: first });
            }
        }
        if mistakes.is_empty() { Ok(()) } else { Err(SetupError { mistakes }) }
    }
}

/// An axis along which the free particles are fewer than three layers, judged by their extent.
fn too_thin<const D: usize>(index: usize, body: &Body<D>) -> Option<ErrorKind> {
    let mut free = body.positions.iter().zip(&body.clamped).filter(|(_, clamped)| !**clamped);
    let first = free.next()?.0;
    let (low, high) = free.fold((*first, *first), |(l, h), (p, _)| (l.inf(p), h.sup(p)));
    (0..D).find_map(|axis| {
        let layers = ((high[axis] - low[axis]) / body.cell[axis]).round() as usize + 1;
        (layers < 3).then_some(ErrorKind::Layers { body: index, axis, layers })
    })
}

fn check_body<const D: usize>(index: usize, first: usize, body: &Body<D>, mistakes: &mut Vec<ErrorKind>) {
    let count = body.positions.len();
    if body.volumes.len() != count || body.clamped.len() != count {
        mistakes.push(ErrorKind::Lengths {
            body: index,
            positions: count,
            volumes: body.volumes.len(),
            clamped: body.clamped.len(),
        });
        return;
    }
    let mut number = |name: &'static str, value: f64, good: bool| {
        if !good {
            mistakes.push(ErrorKind::Number { body: index, name, value });
        }
    };
    let m = &body.material;
    number("density", body.density, body.density > 0.0 && body.density.is_finite());
    number("youngs_modulus", m.youngs_modulus, m.youngs_modulus > 0.0 && m.youngs_modulus.is_finite());
    number("poissons_ratio", m.poissons_ratio, m.poissons_ratio > -1.0 && m.poissons_ratio < 0.5);
    for &edge in &body.cell {
        number("cell", edge, edge > 0.0 && edge.is_finite());
    }
    for i in 0..count {
        let volume = body.volumes[i];
        let enough = volume > 0.0 || (volume == 0.0 && body.clamped[i]);
        if !(enough && volume.is_finite() && body.positions[i].iter().all(|x| x.is_finite())) {
            mistakes.push(ErrorKind::Particle { body: index, particle: first + i, volume });
            return;
        }
    }
}
