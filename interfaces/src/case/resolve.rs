//! From the case as written to the case as resolved: defaults filled in, alternatives decided. It runs after
//! [`super::check`] found nothing, and so has nothing to report; where it relies on a check, it says so.

use super::coupling;
use super::geometry::AxisBox;
use super::region::{FluidVelocity, Region, RegionShape, greatest_speed};
use super::resolved::{
    Body, Case, Clamp, ClampRegion, Fluid, General, Load, LoadTarget, MotionPath, Probe, ProbeTarget,
    Reference, Start, Structure, Unit, Wall, WallMotion, WallShape,
};
use super::typed::{self, Slip};
use super::velocity::InitialVelocity;
use words::geometry::Face;
use words::motion::Law;
use words::probe::ProbeQuantity;

/// Times that particles off the lattice move to the centroids of their cells where the case does not say:
/// with that many, rows at faces at an angle to the lattice follow the faces.
const RELAXATION: u32 = 10;

/// Resolves a checked case.
pub(super) fn resolve(file: typed::CaseFile) -> Case {
    let probes = file.probe.iter().map(|probe| resolve_probe(probe, &file)).collect();
    let general = resolve_general(file.case);
    let fluid = file.fluid.map(|fluid| resolve_fluid(fluid, &general));
    let structure = file.structure.map(|structure| resolve_structure(structure, &general));
    let coupling = structure.as_ref().filter(|_| fluid.is_some()).map(|structure| {
        let written = file.coupling.unwrap_or_default();
        coupling::resolve(&written, general.output_interval, structure.particle_spacing)
    });
    let references = file.reference.into_iter().map(resolve_reference).collect();
    Case { general, fluid, structure, coupling, probes, references }
}

fn resolve_general(case: typed::General) -> General {
    let dimension = case.dimension as usize;
    General {
        title: case.title,
        dimension,
        end_time: case.end_time,
        // A run that is shorter has one output, at its end.
        output_interval: case.output_interval.min(case.end_time),
        record_interval: case.record_interval,
        gravity: case.gravity.unwrap_or_else(|| vec![0.0; dimension]),
        threads: case.threads as usize,
        particle_spacing: case.particle_spacing,
    }
}

fn resolve_fluid(fluid: typed::Fluid, general: &General) -> Fluid {
    let zero = || vec![0.0; general.dimension];
    let characteristic_speed =
        fluid.characteristic_speed.unwrap_or_else(|| default_characteristic_speed(&fluid, &general.gravity));
    Fluid {
        density: fluid.density,
        kinematic_viscosity: fluid.kinematic_viscosity,
        particle_spacing: fluid.particle_spacing.unwrap_or(general.particle_spacing),
        max_time_step: fluid.max_time_step.unwrap_or(general.output_interval),
        characteristic_speed,
        domain: fluid.domain,
        periodic: fluid.periodic,
        regions: fluid
            .region
            .into_iter()
            .map(|region| Region {
                shape: region_shape(&region).expect("the check wants a box or a ball"),
                name: region.name,
                velocity: region.velocity.unwrap_or_else(|| FluidVelocity::Uniform(zero())),
                velocity_gradient: region
                    .velocity_gradient
                    .unwrap_or_else(|| vec![zero(); general.dimension]),
                wave: region.wave,
                jitter: region.jitter,
                seed: region.seed,
            })
            .collect(),
        walls: fluid
            .wall
            .into_iter()
            .map(|wall| Wall {
                name: wall.name,
                shape: match (wall.bounds, wall.polyline, wall.solid_side) {
                    (Some(bounds), ..) => WallShape::Box { bounds },
                    (None, Some(points), Some(solid_side)) => WallShape::Polyline { points, solid_side },
                    _ => unreachable!("the check wants a box, or a polyline with its solid side"),
                },
                slip: wall.slip.unwrap_or(Slip::FreeSlip),
                velocity: wall.velocity.unwrap_or_else(zero),
                motion: wall.motion.map(resolve_motion),
            })
            .collect(),
        numerics: fluid.numerics,
        participant: resolve_participant(fluid.participant),
    }
}

/// The shape of a region that has one.
pub(super) fn region_shape(region: &typed::Region) -> Option<RegionShape> {
    match (&region.bounds, &region.ball) {
        (Some(bounds), _) => Some(RegionShape::Box { bounds: bounds.clone() }),
        (None, Some(ball)) => Some(RegionShape::Ball { ball: ball.clone() }),
        (None, None) => None,
    }
}

/// √(g H), H the extent of all regions along gravity; without gravity the greatest speed at the start, 0
/// where all is at rest or there are no regions, as of a fluid that is not ours.
pub(super) fn default_characteristic_speed(fluid: &typed::Fluid, gravity: &[f64]) -> f64 {
    let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let g = norm(gravity);
    // A NaN, for a gravity that the check found wrong, goes this way too and comes out as NaN.
    if g != 0.0 && !fluid.region.is_empty() {
        // The corners of a box reach furthest along g where each coordinate does.
        let reach = |bounds: &AxisBox, far: bool| -> f64 {
            gravity
                .iter()
                .zip(bounds.low.iter().zip(&bounds.high))
                .map(|(gi, (low, high))| if (*gi > 0.0) == far { gi * high } else { gi * low })
                .sum::<f64>()
                / g
        };
        let shapes: Vec<AxisBox> =
            fluid.region.iter().filter_map(region_shape).map(|shape| shape.bounds()).collect();
        let low = shapes.iter().map(|bounds| reach(bounds, false)).fold(f64::INFINITY, f64::min);
        let high = shapes.iter().map(|bounds| reach(bounds, true)).fold(f64::NEG_INFINITY, f64::max);
        (g * (high - low)).sqrt()
    } else {
        let of = |region: &typed::Region| {
            let shape = region_shape(region);
            greatest_speed(region.velocity.as_ref(), region.velocity_gradient.as_deref(), shape.as_ref())
        };
        fluid.region.iter().map(of).fold(0.0, f64::max)
    }
}

fn resolve_motion(motion: typed::WallMotion) -> WallMotion {
    WallMotion {
        path: match (motion.direction, motion.pivot) {
            (Some(direction), _) => MotionPath::Along { direction },
            (None, Some(pivot)) => MotionPath::About { pivot },
            (None, None) => unreachable!("the check wants a direction or a pivot"),
        },
        law: match (motion.table, motion.amplitude, motion.period) {
            (Some(table), ..) => Law::Table { table },
            (None, Some(amplitude), Some(period)) => {
                Law::Sine { amplitude, period, phase: motion.phase.unwrap_or(0.0) }
            }
            _ => unreachable!("the check wants a table, or amplitude and period"),
        },
    }
}

fn resolve_participant(participant: typed::Participant) -> Start {
    let typed::Participant { start, command, fmu, variables, parameters, record } = participant;
    match (fmu, command, start) {
        (Some(file), ..) => Start::Fmu(Box::new(Unit { file, variables, parameters, record })),
        (None, Some(command), _) => Start::Command(command),
        (None, None, Some(typed::StartWord::ByHand)) => Start::ByHand,
        (None, None, Some(typed::StartWord::Own) | None) => Start::Own,
    }
}

fn resolve_structure(structure: typed::Structure, general: &General) -> Structure {
    Structure {
        particle_spacing: structure.particle_spacing.unwrap_or(general.particle_spacing),
        material: structure.material,
        bodies: structure
            .body
            .into_iter()
            .map(|body| Body {
                lattice_angle: body.lattice_angle,
                jitter: body.jitter,
                seed: body.seed,
                relaxation: body.relaxation.unwrap_or(if body.is_off_lattice(&structure.clamp) {
                    RELAXATION
                } else {
                    0
                }),
                name: body.name,
                bounds: body.bounds,
                velocity: body
                    .velocity
                    .unwrap_or_else(|| InitialVelocity::Uniform(vec![0.0; general.dimension])),
            })
            .collect(),
        clamps: structure.clamp.into_iter().map(resolve_clamp).collect(),
        loads: structure.load.into_iter().map(resolve_load).collect(),
        numerics: structure.numerics,
        participant: resolve_participant(structure.participant),
    }
}

fn resolve_clamp(clamp: typed::Clamp) -> Clamp {
    // What the case leaves out, the structure's solver has filled in by its own gradient.
    let rows = clamp.rows.unwrap_or(0) as usize;
    let region = match (clamp.face, clamp.bounds, clamp.circle) {
        (Some(face), ..) => ClampRegion::Face { face, rows },
        (None, Some(bounds), _) => ClampRegion::Box { bounds },
        (None, None, Some(circle)) => ClampRegion::Circle { circle },
        (None, None, None) => unreachable!("the check wants a face, a box or a circle"),
    };
    Clamp { name: clamp.name, body: clamp.body, region }
}

fn resolve_load(load: typed::Load) -> Load {
    let target = match (load.face, load.at) {
        (Some(face), _) => LoadTarget::Face { face },
        (None, Some(at)) => LoadTarget::Point { at },
        (None, None) => LoadTarget::Body {},
    };
    let ramp = load.ramp.unwrap_or_else(|| vec![[0.0, 1.0]]);
    Load { name: load.name, body: load.body, target, force: load.force, ramp }
}

fn resolve_probe(probe: &typed::Probe, file: &typed::CaseFile) -> Probe {
    let point = || probe.at.clone().expect("the check wants a point for all but a force");
    let body = || {
        let only =
            file.structure.as_ref().and_then(|structure| structure.body.first()).map(|body| &body.name);
        probe.body.as_ref().or(only).expect("the check wants a body that exists").clone()
    };
    let wall = || {
        let only = file.fluid.as_ref().and_then(|fluid| fluid.wall.first()).map(|wall| &wall.name);
        probe.wall.as_ref().or(only).expect("the check wants a wall that exists").clone()
    };
    let target = match (probe.on, probe.quantity) {
        (typed::ProbeSide::Structure, ProbeQuantity::Force) => ProbeTarget::Body(body()),
        (typed::ProbeSide::Structure, _) => ProbeTarget::StructurePoint { body: body(), at: point() },
        (typed::ProbeSide::Fluid, quantity) if quantity.is_of_a_box() => {
            ProbeTarget::FluidBox(probe.bounds.clone())
        }
        (typed::ProbeSide::Fluid, _) => ProbeTarget::FluidPoint(point()),
        (typed::ProbeSide::Wall, ProbeQuantity::Force) => ProbeTarget::Wall(wall()),
        (typed::ProbeSide::Wall, _) => ProbeTarget::WallPoint { wall: wall(), at: point() },
    };
    Probe { name: probe.name.clone(), target, quantity: probe.quantity }
}

fn resolve_reference(reference: typed::Reference) -> Reference {
    Reference {
        low: reference.low.unwrap_or_else(|| reference.value.clone()),
        high: reference.high.unwrap_or_else(|| reference.value.clone()),
        probe: reference.probe,
        label: reference.label,
        source: reference.source,
        time: reference.time,
        value: reference.value,
    }
}

impl Clamp {
    /// The box beyond the body's face that the fixed rows fill, for a clamp on a face; `cell` is the body's
    /// lattice distance across it (m).
    pub fn rows_box(&self, body: &AxisBox, cell: f64) -> Option<AxisBox> {
        match &self.region {
            ClampRegion::Face { face, rows } => Some(beyond(body, *face, *rows as f64 * cell)),
            ClampRegion::Box { .. } | ClampRegion::Circle { .. } => None,
        }
    }
}

/// The box that lies on `face` of `body`, `depth` (m) thick.
pub(super) fn beyond(body: &AxisBox, face: Face, depth: f64) -> AxisBox {
    let mut beyond = body.clone();
    let at = body.coordinate(face);
    beyond.low[face.axis()] = at.min(at + face.sign() * depth);
    beyond.high[face.axis()] = at.max(at + face.sign() * depth);
    beyond
}
