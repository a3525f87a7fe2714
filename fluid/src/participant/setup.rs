//! From the case to particles, walls and options.

use super::{failed, section};
use crate::{FluidProperties, Options, State, WallPart, WallShape, Walls};
use interfaces::Result;
use interfaces::case::fluid::{self, Slip};
use interfaces::case::motion::Motion;
use interfaces::case::region::{FluidVelocity, Region};
use interfaces::case::{AxisBox, Case};
use sph::Vector;
use sph::lattice::{Lattice, jittered};

/// A fluid as the case describes it.
pub struct Made<const D: usize> {
    pub properties: FluidProperties<D>,
    pub options: Options,
    pub walls: Walls<D>,
    pub state: State<D>,
    /// Largest time step that the case allows (s).
    pub max_time_step: f64,
}

/// The fluid that the case describes.
pub fn from_case<const D: usize>(case: &Case) -> Result<Made<D>> {
    let fluid = case.fluid.as_ref().ok_or_else(|| failed("the case has no fluid"))?;
    let spacing = fluid.particle_spacing;
    let (mut positions, mut velocities, mut volume) = (Vec::new(), Vec::new(), 0.0);
    for region in &fluid.regions {
        let bounds = corners::<D>(&region.shape().expect("a region of a checked case has a shape"));
        let lattice = Lattice::fill_box(bounds.0, bounds.1, spacing);
        let cell = lattice.cell_volume();
        let mut points = lattice.positions;
        if let Some(ball) = &region.ball {
            let centre = Vector::from_column_slice(&ball.centre);
            points.retain(|p| (p - centre).norm() < ball.radius);
        }
        volume += cell * points.len() as f64;
        let points = jittered(points, region.jitter * spacing, u64::from(region.seed));
        velocities.extend(points.iter().map(|p| velocity(region, &bounds, p)));
        positions.extend(points.iter().map(|p| p + wave(region, &bounds, p)));
    }
    let properties = FluidProperties {
        density: fluid.density,
        kinematic_viscosity: fluid.kinematic_viscosity,
        gravity: Vector::from_column_slice(&case.general.gravity),
        spacing,
        particle_volume: volume / positions.len() as f64,
        domain: corners(&fluid.domain),
        periodic: std::array::from_fn(|i| fluid.periodic.iter().any(|axis| axis.index() == i)),
    };
    let options = options(case, fluid)?;
    let parts = fluid.walls.iter().map(wall_part).collect();
    let support = 2.0 * options.smoothing_ratio * spacing;
    let walls = Walls::new(parts, spacing, support).map_err(failed)?;
    let state = State::new(positions, velocities);
    Ok(Made { properties, options, walls, state, max_time_step: fluid.max_time_step })
}

/// Velocity (m/s) at the start at a point of a region within the corners `bounds`.
fn velocity<const D: usize>(
    region: &Region,
    (low, high): &(Vector<D>, Vector<D>),
    point: &Vector<D>,
) -> Vector<D> {
    let mean: Vector<D> = match &region.velocity {
        FluidVelocity::Uniform(v) => Vector::from_column_slice(v),
        FluidVelocity::Mode(mode) => in_plane(mode.at(point[0] - low[0], point[1] - low[1])),
    };
    let arm = point - (low + high) * 0.5;
    mean + Vector::from_fn(|i, _| region.velocity_gradient[i].iter().zip(&arm).map(|(g, x)| g * x).sum())
}

/// Displacement (m) of a particle by the region's standing wave.
fn wave<const D: usize>(
    region: &Region,
    (low, high): &(Vector<D>, Vector<D>),
    point: &Vector<D>,
) -> Vector<D> {
    region.wave.as_ref().map_or(Vector::zeros(), |wave| {
        in_plane(wave.displacement(point[0] - low[0], point[1] - low[1], high[1] - low[1]))
    })
}

/// A vector in the plane of the first two axes.
fn in_plane<const D: usize>(vector: [f64; 2]) -> Vector<D> {
    Vector::from_fn(|i, _| vector.get(i).copied().unwrap_or(0.0))
}

pub(super) fn corners<const D: usize>(bounds: &AxisBox) -> (Vector<D>, Vector<D>) {
    (Vector::from_column_slice(&bounds.low), Vector::from_column_slice(&bounds.high))
}

fn wall_part<const D: usize>(wall: &fluid::Wall) -> WallPart<D> {
    let shape = match (&wall.bounds, &wall.polyline, wall.solid_side) {
        (Some(bounds), ..) => {
            let (low, high) = corners(bounds);
            WallShape::Box { low, high }
        }
        (None, Some(points), Some(solid)) => {
            let points = points.iter().map(|p| Vector::from_column_slice(p)).collect();
            WallShape::Polyline { points, solid }
        }
        _ => unreachable!("a wall of a checked case is a box, or a polyline with its solid side"),
    };
    let velocity = Vector::from_column_slice(&wall.velocity);
    let motion = wall.moves().and_then(Motion::rigid);
    WallPart { name: wall.name.clone(), shape, velocity, motion }
}

/// The options that the case describes: its numerics, and what the coupling asks of the fluid.
fn options(case: &Case, fluid: &fluid::Fluid) -> Result<Options> {
    let of_numerics = section::options(&fluid.numerics).map_err(failed)?;
    let no_slip_walls = fluid.walls.iter().any(|w| w.slip == Slip::NoSlip);
    let of_fluid =
        Options { no_slip_walls, reference_velocity: Some(fluid.characteristic_speed), ..of_numerics };
    let Some(coupling) = &case.coupling else { return Ok(of_fluid) };
    Ok(Options {
        compliance: coupling.compliance,
        structure_velocity: coupling.structure_velocity,
        load: coupling.load,
        ..of_fluid
    })
}
