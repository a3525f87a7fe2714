//! From the case to particles, walls and options.

use super::failed;
use crate::{
    FluidProperties, Load, Options, Scheme, Side, State, StructureVelocity, ViscousOperator, WallPart,
    WallShape, Walls,
};
use interfaces::ParticipantError;
use interfaces::case::numerics::{FluidScheme, ViscosityOperator};
use interfaces::case::resolved::{self, LoadForm, Region, Slip, StructureVelocity as Velocity};
use interfaces::case::{AxisBox, Case, geometry};
use sph::Vector;
use sph::lattice::Lattice;

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
pub fn from_case<const D: usize>(case: &Case) -> Result<Made<D>, ParticipantError> {
    let fluid = case.fluid.as_ref().ok_or_else(|| failed("the case has no fluid"))?;
    let spacing = fluid.particle_spacing;
    let (mut positions, mut velocities, mut volume) = (Vec::new(), Vec::new(), 0.0);
    for region in &fluid.regions {
        let (low, high) = corners::<D>(&region.bounds);
        let lattice = Lattice::fill_box(low, high, spacing);
        volume += lattice.cell_volume() * lattice.positions.len() as f64;
        velocities
            .resize(velocities.len() + lattice.positions.len(), Vector::from_column_slice(&region.velocity));
        positions.extend(jittered(lattice.positions, region, spacing));
    }
    let properties = FluidProperties {
        density: fluid.density,
        kinematic_viscosity: fluid.kinematic_viscosity,
        gravity: Vector::from_column_slice(&case.general.gravity),
        spacing,
        particle_volume: volume / positions.len() as f64,
        domain: corners(&fluid.domain),
    };
    let options = options(case, fluid);
    let parts = fluid.walls.iter().map(wall_part).collect();
    let support = 2.0 * options.smoothing_ratio * spacing;
    let walls = Walls::new(parts, spacing, support).map_err(failed)?;
    let state = State::new(positions, velocities);
    Ok(Made { properties, options, walls, state, max_time_step: fluid.max_time_step })
}

fn corners<const D: usize>(bounds: &AxisBox) -> (Vector<D>, Vector<D>) {
    (Vector::from_column_slice(&bounds.low), Vector::from_column_slice(&bounds.high))
}

fn wall_part<const D: usize>(wall: &resolved::Wall) -> WallPart<D> {
    let shape = match &wall.shape {
        resolved::WallShape::Box { bounds } => {
            let (low, high) = corners(bounds);
            WallShape::Box { low, high }
        }
        resolved::WallShape::Polyline { points, solid_side } => WallShape::Polyline {
            points: points.iter().map(|p| Vector::from_column_slice(p)).collect(),
            solid: match solid_side {
                geometry::Side::Left => Side::Left,
                geometry::Side::Right => Side::Right,
            },
        },
    };
    WallPart { name: wall.name.clone(), shape, velocity: Vector::from_column_slice(&wall.velocity) }
}

fn options(case: &Case, fluid: &resolved::Fluid) -> Options {
    let numerics = &fluid.numerics;
    let base = match numerics.scheme {
        FluidScheme::EnergyConsistent => Options::default(),
        FluidScheme::Paper => Options::paper(),
    };
    let coupling = case.coupling.as_ref();
    let (compliance, load) = coupling.map_or((true, LoadForm::Transpose), |c| (c.compliance, c.load));
    Options {
        scheme: match numerics.scheme {
            FluidScheme::EnergyConsistent => Scheme::EnergyConsistent,
            FluidScheme::Paper => Scheme::Paper,
        },
        smoothing_ratio: numerics.smoothing_ratio,
        pressure_tolerance: numerics.pressure_tolerance,
        viscous_operator: match numerics.viscosity_operator {
            ViscosityOperator::Morris => ViscousOperator::Morris,
            ViscosityOperator::Corrected => ViscousOperator::FatehiManzari,
        },
        no_slip_walls: fluid.walls.iter().any(|w| w.slip == Slip::NoSlip),
        reference_velocity: Some(fluid.characteristic_speed),
        compliance,
        structure_velocity: match coupling.map(|c| c.structure_velocity) {
            Some(Velocity::End) => StructureVelocity::End,
            Some(Velocity::Mean) | None => StructureVelocity::Mean,
        },
        load: match load {
            LoadForm::Transpose => Load::Transpose,
            LoadForm::PressureGradient => Load::PressureGradient,
        },
        ..base
    }
}

/// The lattice's points, each displaced along each axis by at most the region's jitter times the spacing. The numbers are those of
/// SplitMix64 (Steele, Lea and Flood 2014) from the region's seed, so that a start is the same everywhere.
fn jittered<const D: usize>(points: Vec<Vector<D>>, region: &Region, spacing: f64) -> Vec<Vector<D>> {
    let mut state = u64::from(region.seed);
    let mut next = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64
    };
    let amplitude = region.jitter * spacing;
    points.into_iter().map(|p| p + Vector::from_fn(|_, _| amplitude * (2.0 * next() - 1.0))).collect()
}
