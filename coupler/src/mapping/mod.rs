//! Mapping between point sets that do not match: motion one way, forces the other way.
//!
//! A [`Mapping`] is one sparse matrix `W`, a row for each *target* point and a column for each *source*
//! point, made from positions of both in a common configuration. The source is the side whose motion is known
//! (the structure, or the vertices of its boundary mesh), the target the side that follows (the fluid's
//! interface particles).
//!
//! | | formula | kept |
//! |---|---|---|
//! | [`Mapping::consistent`]: positions, velocities | `u_t = Σ_s W_ts u_s` | constant fields, as `Σ_s W_ts = 1` |
//! | [`Mapping::conservative`]: forces | `F_s = Σ_t W_ts F_t` | `Σ F`, by the same sum |
//! | both | `Σ_s F_s · u_s = Σ_t F_t · u_t` | power, exactly, as one is the other's transpose |
//!
//! All methods but the first also give `Σ_s W_ts x_s = x_t`. Then linear fields are exact, and so is a rigid
//! motion by any finite rotation: `Σ W (R x_s + c) = R x_t + c`. Moments are kept for the same reason,
//! `Σ_s x_s × F_s = Σ_t (Σ_s W_ts x_s) × F_t = Σ_t x_t × F_t`, and not only in the configuration of the
//! mapping: wherever the source has gone, moments are kept about target positions that were mapped
//! themselves. This is why no offset from a surface is carried along apart: it is in the weights.
//!
//! | [`Method`] | linear fields | order | weights in a row | for |
//! |---|---|---|---|---|
//! | [nearest neighbour](Method::NearestNeighbour) | no | 1 | 1 | points that nearly match |
//! | [nearest neighbour with gradient](Method::NearestNeighbourGradient) | yes | 2 | 7 | clouds, moving ones too |
//! | [nearest projection](Method::NearestProjection) | yes | 2 | up to 4 (6 in space) | a boundary mesh |
//! | [radial basis functions](Method::RadialBasis) | yes | 2 | 63 | clouds, accuracy |
//!
//! A row's weights were counted between lattices in the plane. On points scattered about a lattice of spacing
//! 1/80 a wave of length one was mapped with root mean square errors of 1.5e-2, 4.0e-4 and, by radial basis
//! functions, 4.0e-5.
//!
//! Weights are applied by one thread; those of all methods but the first are worked out by as many as
//! [`Mapping::use_threads`] allows, each for a part of the targets: results do not depend on their number.
//! Nothing is allocated in applying a mapping; in rebuilding it, the storage of the last but one is used
//! again.
//!
//! Start at [`Mapping`]; then a file for each method. Nothing here knows a participant or a field's meaning,
//! but for [`Mapping::conservative_per_volume`].

mod boundary;
mod cell_grid;
mod cells;
mod error;
mod facet;
mod factors;
mod lanes;
mod nearest_neighbour;
mod nearest_neighbour_gradient;
mod nearest_projection;
mod parts;
mod radial_basis;
mod rows;
mod semidefinite;
mod weigh;

pub use error::{MappingError, PointSet};

use nearest_neighbour::NearestNeighbour;
use nearest_neighbour_gradient::NearestNeighbourGradient;
use nearest_projection::NearestProjection;
use radial_basis::RadialBasis;
use rows::Rows;
use sprs::CsMatViewI;

/// Points in a cluster of radial basis functions where nothing else is asked for: some rings of neighbours
/// around a target in the plane.
pub const POINTS_PER_CLUSTER: usize = 32;

/// How targets are to follow.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// Each target takes the value of the nearest source point.
    NearestNeighbour,
    /// The value of the nearest source point, continued with the gradient that its neighbours give.
    NearestNeighbourGradient,
    /// Barycentric weights on a boundary mesh whose vertices are the source points; a target off it lies on a
    /// line between two of its facets.
    NearestProjection {
        /// Facets, flat: `dimension` source points each. Segments that go round the body anticlockwise, or
        /// triangles that do as seen from outside. The boundary may be open where no target needs it.
        facets: Vec<usize>,
    },
    /// Wendland's C² functions in overlapping clusters of source points, blended.
    RadialBasis {
        /// Source points in a cluster, about; [`POINTS_PER_CLUSTER`].
        points_per_cluster: usize,
    },
}

/// What a mapping is made with.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Coordinates of a point: 2 or 3.
    pub dimension: usize,
    /// How far (m) a target may be from the nearest source point; by nearest projection, how far outside the
    /// boundary. May be infinite.
    pub reach: f64,
    /// The method.
    pub method: Method,
}

/// A mapping from source to target points, and of forces back.
#[derive(Clone, Debug)]
pub struct Mapping {
    dimension: usize,
    reach: f64,
    threads: usize,
    method: Scratch,
    sources: usize,
    weights: Rows,
    /// The rows of the next update, which then become the weights.
    rows: Rows,
}

/// A method with its scratch memory.
#[derive(Clone, Debug)]
enum Scratch {
    NearestNeighbour(NearestNeighbour),
    NearestNeighbourGradient(NearestNeighbourGradient),
    NearestProjection(Box<NearestProjection>),
    RadialBasis(Box<RadialBasis>),
}

impl Mapping {
    /// Builds the mapping for `source` and `target` positions (m), flat, in one configuration.
    ///
    /// # Errors
    ///
    /// Where positions are not finite, or a target has no sources that determine its motion: see
    /// [`MappingError`].
    pub fn build(settings: Settings, source: &[f64], target: &[f64]) -> Result<Self, MappingError> {
        let Settings { dimension, reach, method } = settings;
        if !(2..=3).contains(&dimension) {
            return Err(MappingError::Dimension { dimension });
        }
        let method = match method {
            Method::NearestNeighbour => Scratch::NearestNeighbour(NearestNeighbour::default()),
            Method::NearestNeighbourGradient => {
                Scratch::NearestNeighbourGradient(NearestNeighbourGradient::default())
            }
            Method::NearestProjection { facets } => {
                Scratch::NearestProjection(Box::new(NearestProjection::new(facets, dimension)?))
            }
            Method::RadialBasis { points_per_cluster } => {
                Scratch::RadialBasis(Box::new(RadialBasis::new(points_per_cluster)))
            }
        };
        let (weights, rows) = (Rows::default(), Rows::default());
        let mut mapping = Self { dimension, reach, threads: 1, method, sources: 0, weights, rows };
        mapping.update(source, target)?;
        Ok(mapping)
    }

    /// Lets [`Mapping::update`] work with so many threads; with one, where nothing is said.
    pub fn use_threads(&mut self, threads: usize) {
        self.threads = threads;
    }

    /// Builds the mapping anew for points that moved, in the memory that it has. The result is that of
    /// [`Mapping::build`], to the bit.
    ///
    /// # Errors
    ///
    /// As [`Mapping::build`]; the mapping then stays what it was.
    pub fn update(&mut self, source: &[f64], target: &[f64]) -> Result<(), MappingError> {
        match self.dimension {
            2 => self.update_in::<2>(source, target),
            _ => self.update_in::<3>(source, target),
        }
    }

    fn update_in<const D: usize>(&mut self, source: &[f64], target: &[f64]) -> Result<(), MappingError> {
        let source = points::<D>(source, PointSet::Source)?;
        let target = points::<D>(target, PointSet::Target)?;
        self.rows.clear();
        if source.is_empty() && !target.is_empty() {
            return Err(MappingError::NoSource { targets: target.len() });
        }
        if !target.is_empty() {
            let (reach, threads, rows) = (self.reach, self.threads, &mut self.rows);
            match &mut self.method {
                Scratch::NearestNeighbour(method) => method.fill(source, target, reach, rows),
                Scratch::NearestNeighbourGradient(method) => {
                    method.fill(source, target, reach, threads, rows)
                }
                Scratch::NearestProjection(method) => method.fill(source, target, reach, threads, rows),
                Scratch::RadialBasis(method) => method.fill(source, target, reach, threads, rows),
            }?;
        }
        std::mem::swap(&mut self.rows, &mut self.weights);
        self.sources = source.len();
        Ok(())
    }

    /// The matrix `W`: targets × sources.
    pub fn weights(&self) -> CsMatViewI<'_, f64, u32, usize> {
        self.weights.matrix(self.sources)
    }

    /// Number of source points.
    pub fn sources(&self) -> usize {
        self.sources
    }

    /// Number of target points.
    pub fn targets(&self) -> usize {
        self.weights.count()
    }

    /// `u_t = Σ_s W_ts u_s`: what moves with the points, as positions and velocities. Fields are flat,
    /// `components` doubles a point.
    pub fn consistent(&self, components: usize, source: &[f64], target: &mut [f64]) {
        self.assert_fit(components, source, target);
        match components {
            1 => gather::<1>(&self.weights, source, target),
            2 => gather::<2>(&self.weights, source, target),
            3 => gather::<3>(&self.weights, source, target),
            _ => gather_many(&self.weights, components, source, target),
        }
    }

    /// `F_s = Σ_t W_ts F_t`: forces on the targets to forces on the sources. Fields are flat, `components`
    /// doubles a point.
    pub fn conservative(&self, components: usize, target: &[f64], source: &mut [f64]) {
        self.assert_fit(components, source, target);
        source.fill(0.0);
        match components {
            1 => scatter::<1>(&self.weights, |_| 1.0, target, source),
            2 => scatter::<2>(&self.weights, |_| 1.0, target, source),
            3 => scatter::<3>(&self.weights, |_| 1.0, target, source),
            _ => scatter_many(&self.weights, |_| 1.0, components, target, source),
        }
    }

    /// A load per volume, `g_s = (1/V_s) Σ_t W_ts V_t g_t`: the pressure gradients (Pa/m) that a fluid sends
    /// for points of volumes `V_t` (m³) act with the forces `−V_t g_t`, and it is these that are kept. The
    /// sources take forces `−V_s g_s`. A source without volume, such as the vertex of a boundary mesh, takes
    /// the force itself: multiply by `−V_t` and use [`Mapping::conservative`].
    ///
    /// # Errors
    ///
    /// Where a source's volume is not positive and finite; `source_load` is then untouched.
    pub fn conservative_per_volume(
        &self,
        components: usize,
        target_volume: &[f64],
        target_load: &[f64],
        source_volume: &[f64],
        source_load: &mut [f64],
    ) -> Result<(), MappingError> {
        self.assert_fit(components, source_load, target_load);
        self.assert_fit(1, source_volume, target_volume);
        if let Some(point) = source_volume.iter().position(|v| !(*v > 0.0 && v.is_finite())) {
            return Err(MappingError::Volume { point, volume: source_volume[point] });
        }
        source_load.fill(0.0);
        let volume = |target: usize| target_volume[target];
        match components {
            1 => scatter::<1>(&self.weights, volume, target_load, source_load),
            2 => scatter::<2>(&self.weights, volume, target_load, source_load),
            3 => scatter::<3>(&self.weights, volume, target_load, source_load),
            _ => scatter_many(&self.weights, volume, components, target_load, source_load),
        }
        for (load, volume) in source_load.chunks_exact_mut(components).zip(source_volume) {
            load.iter_mut().for_each(|g| *g /= volume);
        }
        Ok(())
    }

    fn assert_fit(&self, components: usize, source: &[f64], target: &[f64]) {
        let fits = components > 0
            && (source.len(), target.len()) == (components * self.sources(), components * self.targets());
        assert!(
            fits,
            "fields of {components} components are laid out for the {} sources and {} targets of the mapping, and these have {} and {}",
            self.sources(),
            self.targets(),
            source.len(),
            target.len()
        );
    }
}

/// Flat coordinates as points, all finite.
fn points<const D: usize>(flat: &[f64], set: PointSet) -> Result<&[[f64; D]], MappingError> {
    let (points, rest) = flat.as_chunks::<D>();
    if !rest.is_empty() {
        return Err(MappingError::Length { set, length: flat.len(), dimension: D });
    }
    match points.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        Some(point) => Err(MappingError::NotFinite { set, point, position: points[point].to_vec() }),
        None => Ok(points),
    }
}

fn gather<const C: usize>(weights: &Rows, source: &[f64], target: &mut [f64]) {
    let (source, _) = source.as_chunks::<C>();
    let (target, _) = target.as_chunks_mut::<C>();
    for (t, value) in target.iter_mut().enumerate() {
        let mut sum = [0.0; C];
        let (columns, weights) = weights.row(t);
        for (&column, weight) in columns.iter().zip(weights) {
            for c in 0..C {
                sum[c] += weight * source[column as usize][c];
            }
        }
        *value = sum;
    }
}

fn gather_many(weights: &Rows, components: usize, source: &[f64], target: &mut [f64]) {
    target.fill(0.0);
    for (t, value) in target.chunks_exact_mut(components).enumerate() {
        let (columns, weights) = weights.row(t);
        for (&column, weight) in columns.iter().zip(weights) {
            let from = components * column as usize;
            for (sum, u) in value.iter_mut().zip(&source[from..from + components]) {
                *sum += weight * u;
            }
        }
    }
}

fn scatter<const C: usize>(weights: &Rows, scale: impl Fn(usize) -> f64, target: &[f64], source: &mut [f64]) {
    let (target, _) = target.as_chunks::<C>();
    let (source, _) = source.as_chunks_mut::<C>();
    for (t, value) in target.iter().enumerate() {
        let force = value.map(|f| scale(t) * f);
        let (columns, weights) = weights.row(t);
        for (&column, weight) in columns.iter().zip(weights) {
            for c in 0..C {
                source[column as usize][c] += weight * force[c];
            }
        }
    }
}

fn scatter_many(
    weights: &Rows,
    scale: impl Fn(usize) -> f64,
    components: usize,
    target: &[f64],
    source: &mut [f64],
) {
    for (t, value) in target.chunks_exact(components).enumerate() {
        let scale = scale(t);
        let (columns, weights) = weights.row(t);
        for (&column, weight) in columns.iter().zip(weights) {
            let to = components * column as usize;
            for (sum, f) in source[to..to + components].iter_mut().zip(value) {
                *sum += weight * (scale * f);
            }
        }
    }
}
