//! What is read off a state: values at points, the fluid in a box, its departure from rest; the height of its
//! surface ([`gauge`]), what crosses an [`area`] ([`flux`]).

pub mod area;
pub mod flux;
pub mod gauge;

use crate::particles::class::SurfaceClass;
use crate::particles::state::State;
use crate::properties::FluidProperties;
use area::Area;
use sph::kernel::CubicSpline;
use sph::neighbours::CellGrid;
use sph::{Matrix, Vector, tensor};
use words::rigid::Pose;

/// Points of a sensor in a spacing along each edge.
const SAMPLES: f64 = 4.0;

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

    /// Mean pressure (Pa) over an area, as a sensor there has it: that of [`at`](Self::at) where fluid
    /// touches it, which is where a particle is within one `spacing` (m), and none where it is dry.
    pub fn mean_over(&self, area: &Area<D>, spacing: f64) -> f64 {
        let pressure = |(point, share): (Vector<D>, f64)| {
            let mut is_touched = false;
            self.grid.for_each_near(&point, self.positions, |b| {
                is_touched |= (self.positions[b as usize] - point).norm_squared() <= spacing * spacing;
            });
            if is_touched { share * self.at(&point).pressure } else { 0.0 }
        };
        area.points(spacing / SAMPLES).into_iter().map(pressure).sum()
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

#[cfg(test)]
mod tests {
    use super::*;

    type V = Vector<2>;

    /// Water 0.5 m deep beside a wall at x = 0, under gravity of 10 m/s²: a sensor from 0.1 to 0.3 m has the
    /// pressure at its middle, one from 0.4 to 0.6 m that of the half which is wet, 10⁴·0.1²/2 over 0.2 m,
    /// but for the third of a spacing beyond the waterline that still counts as touched (1.2 %); one above
    /// is dry.
    #[test]
    fn a_sensor_has_the_mean_over_its_area() {
        let spacing = 0.02;
        let lattice = (0..500)
            .map(|i| V::from([spacing * (f64::from(i % 20) + 0.5), spacing * (f64::from(i / 20) + 0.5)]));
        let positions: Vec<V> = lattice.collect();
        let mut state = State::at_start(positions.clone(), vec![V::zeros(); 500], ());
        state.pressures = positions.iter().map(|r| 1e4 * (0.5 - r.y)).collect();
        let probe = Probe::new(&state, 1.3 * spacing);
        let sensor = |y: f64| Area::of_edges(V::from([0.0, y]), &[V::from([0.0, 0.2])], None).unwrap();
        let mean = |y: f64| probe.mean_over(&sensor(y), spacing);
        assert!((mean(0.2) - 3000.0).abs() < 1e-6, "{}", mean(0.2));
        assert!((mean(0.5) - 250.0).abs() < 0.02 * 250.0, "{}", mean(0.5));
        assert_eq!(mean(0.7), 0.0);
    }
}
