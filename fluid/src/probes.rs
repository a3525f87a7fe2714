//! What is read off a state: values at points, the fluid in a box, its departure from rest.

use crate::particles::class::SurfaceClass;
use crate::particles::state::State;
use crate::properties::FluidProperties;
use sph::kernel::CubicSpline;
use sph::neighbours::CellGrid;
use sph::{Matrix, Vector, tensor};
use words::rigid::Pose;

/// Interpolation of a state's fields at any points.
pub struct Probe<'a, const D: usize> {
    positions: &'a [Vector<D>],
    velocities: &'a [Vector<D>],
    pressures: &'a [f64],
    kernel: CubicSpline<D>,
    grid: CellGrid<D>,
}

/// Values at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeValue<const D: usize> {
    /// Pressure (Pa).
    pub pressure: f64,
    /// Velocity (m/s).
    pub velocity: Vector<D>,
    /// Whether any fluid is within reach: without, the values are not numbers.
    pub wet: bool,
}

/// The fluid in a box, taken as a whole; not numbers without fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body<const D: usize> {
    /// Where it begins along each axis (m), half a spacing before its first particle.
    pub low: Vector<D>,
    /// Where it ends (m).
    pub high: Vector<D>,
    /// Mean position (m).
    pub centroid: Vector<D>,
    /// Standard deviation of position along each axis (m), half the semi-axis of an ellipse along the axes.
    pub spread: Vector<D>,
}

impl<const D: usize, M> State<D, M> {
    /// The fluid between two corners (m), particles `spacing` (m) apart, those that fly alone left out; where
    /// a pose is given, as seen by whoever has come to it.
    pub fn body_in(
        &self,
        spacing: f64,
        (low, high): (Vector<D>, Vector<D>),
        pose: Option<&Pose<D>>,
    ) -> Body<D> {
        let half = 0.5 * spacing;
        let mut body = Body { low: high, high: low, centroid: Vector::zeros(), spread: Vector::zeros() };
        let inside = |r: &Vector<D>| (0..D).all(|i| r[i] >= low[i] && r[i] <= high[i]);
        let members = || {
            let together = self.classes.iter().map(|class| *class != SurfaceClass::Splash);
            let seen = self.positions.iter().map(|r| pose.map_or(*r, |pose| pose.at_rest(r)));
            let members = seen.zip(together).filter(move |(r, together)| *together && inside(r));
            members.map(|(r, _)| r)
        };
        let mut count = 0.0;
        for r in members() {
            body.low = body.low.inf(&r.add_scalar(-half));
            body.high = body.high.sup(&r.add_scalar(half));
            body.centroid += r;
            count += 1.0;
        }
        if count > 0.0 {
            body.centroid /= count;
            let square = members().fold(Vector::zeros(), |sum: Vector<D>, r| {
                let offset = r - body.centroid;
                sum + offset.component_mul(&offset)
            });
            body.spread = (square / count).map(f64::sqrt);
            return body;
        }
        let nowhere = Vector::repeat(f64::NAN);
        Body { low: nowhere, high: nowhere, centroid: nowhere, spread: nowhere }
    }

    /// Departure of the pressure from `ρ g·(r − level)`, over the greatest of it: its largest magnitude and
    /// its root mean square, of all particles deeper than one spacing below the point `level` (m); not
    /// numbers without any.
    pub fn hydrostatic_error(&self, properties: &FluidProperties<D>, level: &Vector<D>) -> [f64; 2] {
        let weight = properties.gravity * properties.density;
        let first_layer = weight.norm() * properties.spacing;
        let (mut largest, mut square, mut count, mut deepest) = (0.0f64, 0.0, 0.0, 0.0f64);
        for (r, p) in self.positions.iter().zip(&self.pressures) {
            let hydrostatic = weight.dot(&(r - level));
            if hydrostatic > first_layer {
                largest = largest.max((p - hydrostatic).abs());
                square += (p - hydrostatic).powi(2);
                count += 1.0;
                deepest = deepest.max(hydrostatic);
            }
        }
        if count == 0.0 { [f64::NAN; 2] } else { [largest / deepest, f64::sqrt(square / count) / deepest] }
    }
}

impl<'a, const D: usize> Probe<'a, D> {
    /// Bins a state's particles for probing with the kernel of a smoothing length (m).
    pub fn new<M>(state: &'a State<D, M>, smoothing_length: f64) -> Self {
        let kernel = CubicSpline::new(smoothing_length);
        let grid = CellGrid::new(&state.positions, kernel.support());
        let State { positions, velocities, pressures, .. } = state;
        Self { positions, velocities, pressures, kernel, grid }
    }

    /// Weighted least squares of a linear field, `Σ W (f_b − f(r))² → min`; the mean where neighbours do not
    /// span the space.
    pub fn at(&self, point: &Vector<D>) -> ProbeValue<D> {
        let positions = self.positions;
        let (mut weight, mut lean) = (0.0, Vector::<D>::zeros());
        let mut spread = Matrix::<D>::zeros();
        self.grid.for_each_near(point, positions, |b| {
            let r = positions[b as usize] - point;
            let w = self.kernel.value(r.norm());
            weight += w;
            lean += r * w;
            spread += tensor::outer(&r, &r) * w;
        });
        if weight == 0.0 {
            return ProbeValue { pressure: f64::NAN, velocity: Vector::repeat(f64::NAN), wet: false };
        }
        // The value at r of the fitted field is Σ W (1 − l·(r_b − r)) f_b / Σ W (1 − l·(r_b − r)) with
        // spread·l = lean.
        let h = self.kernel.smoothing_length();
        let spanned = tensor::smallest_eigenvalue(&spread) > 0.02 * weight * h * h;
        let slope = if spanned {
            tensor::inverse(&spread).map_or(Vector::zeros(), |m| m * lean)
        } else {
            Vector::zeros()
        };
        let scale = weight - slope.dot(&lean);
        let (slope, scale) = if scale > 0.1 * weight { (slope, scale) } else { (Vector::zeros(), weight) };
        let (mut pressure, mut velocity) = (0.0, Vector::zeros());
        self.grid.for_each_near(point, positions, |b| {
            let b = b as usize;
            let r = positions[b] - point;
            let w = self.kernel.value(r.norm()) * (1.0 - slope.dot(&r)) / scale;
            pressure += self.pressures[b] * w;
            velocity += self.velocities[b] * w;
        });
        ProbeValue { pressure, velocity, wet: true }
    }
}
