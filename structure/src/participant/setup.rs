//! From the case to the structure's setup and initial velocities.

use super::error::failed;
use super::section;
use super::section::Elastic;
use crate::bodies::filling::{Filling, rectangle, without_disc};
use crate::{
    Body, Cell, ClampMotion, ContactSetup, DeadLoad, History, MaterialPoint, Setup, Side, Wall, WallShape,
};
use interfaces::Result;
use interfaces::case::fluid;
use interfaces::case::motion::Motion;
use interfaces::case::structure::{self, Clamp, ClampRegion};
use interfaces::case::velocity::{CantileverVelocity, InitialVelocity};
use interfaces::case::{AxisBox, Case};
use sph::lattice::Lattice;
use sph::{Matrix, Vector};
use words::geometry::Face;

/// A setup, and the velocities (m/s) of all its particles at the start.
pub struct Made<const D: usize> {
    pub setup: Setup<D>,
    pub velocities: Vec<Vector<D>>,
}

/// Tolerance of geometric comparisons, as a fraction of the spacing.
const TOUCHING: f64 = 1e-6;

/// The setup that the case describes.
pub fn from_case<const D: usize>(case: &Case) -> Result<Made<D>> {
    let structure = case.structure.as_ref().ok_or_else(|| failed("the case has no structure"))?;
    let (mut bodies, mut velocities, mut motions) = (Vec::new(), Vec::new(), Vec::new());
    for part in &structure.bodies {
        let (low, high) = corners::<D>(&part.bounds);
        let own = section::material_of(&structure.material, &part.material, case.general.dimension);
        let Elastic { material, density } = own.map_err(failed)?;
        let mut body = Body::block(low, high, structure.particle_spacing, material, density);
        let clamps: Vec<&Clamp> = structure.clamps.iter().filter(|c| c.body == part.name).collect();
        let mut arcs = Vec::new();
        if off_lattice(part, &clamps) {
            (body, arcs) = scattered(part, &clamps, structure.particle_spacing, &body)?;
        }
        let first = velocities.len();
        for clamp in clamps {
            let held = body.clamped.clone();
            body = clamped(body, clamp, part, structure.particle_spacing, &mut arcs);
            if let Some(motion) = clamp.moves().and_then(Motion::rigid) {
                // What an earlier clamp holds is that one's.
                let is_new = |n: &usize| body.clamped[*n] && !held.get(*n).is_some_and(|held| *held);
                let particles = (0..body.positions.len()).filter(is_new).map(|n| first + n).collect();
                motions.push(ClampMotion { particles, motion });
            }
        }
        for (position, clamped) in body.positions.iter().zip(&body.clamped) {
            velocities.push(if *clamped {
                Vector::zeros()
            } else {
                velocity(&part.velocity, &part.bounds, position)
            });
        }
        bodies.push(body);
    }
    let mut setup = Setup::new(bodies);
    setup.motions = motions;
    setup.contact = contact(case, structure)?;
    setup.gravity = Vector::from_column_slice(&case.general.gravity);
    setup.options = section::options(&structure.numerics).map_err(failed)?;
    let mut first = 0;
    for (part, body) in structure.bodies.iter().zip(&setup.bodies) {
        for load in structure.loads.iter().filter(|l| l.body == part.name) {
            setup.dead_loads.push(dead_load(load, part, body, first, structure.particle_spacing));
        }
        first += body.positions.len();
    }
    Ok(Made { setup, velocities })
}

/// What the bodies may meet: each other, themselves, and the case's walls.
fn contact<const D: usize>(case: &Case, structure: &structure::Structure) -> Result<ContactSetup<D>> {
    let point = |p: &Vec<f64>| Vector::from_column_slice(p);
    let wall = |wall: &fluid::Wall| {
        let shape = match (&wall.bounds, &wall.polyline) {
            (Some(bounds), _) => {
                let (low, high) = corners(bounds);
                WallShape::Box { low, high }
            }
            (None, Some(points)) => WallShape::Polyline(points.iter().map(point).collect()),
            (None, None) => return None,
        };
        let motion = wall.moves().and_then(Motion::rigid);
        Some(Wall { name: wall.name.clone(), shape, motion })
    };
    Ok(ContactSetup {
        options: section::contact(&structure.contact).map_err(failed)?,
        walls: case.fluid.iter().flat_map(|fluid| &fluid.walls).filter_map(wall).collect(),
        names: structure.bodies.iter().map(|body| body.name.clone()).collect(),
    })
}

/// The body held by one clamp more; `arcs` are the fixed nodes of its circles.
fn clamped<const D: usize>(
    mut body: Body<D>,
    clamp: &Clamp,
    part: &structure::Body,
    spacing: f64,
    arcs: &mut Vec<Vector<D>>,
) -> Body<D> {
    match clamp.region().expect("a clamp of a checked case holds something") {
        ClampRegion::Face { face, rows: 0 } if !body.centroid_offsets.is_empty() => {
            body.with_fixed_nodes(&face_points(face, &part.bounds, spacing))
        }
        ClampRegion::Face { face, rows: 0 } => body.with_fixed_face(face.axis(), side(face)),
        ClampRegion::Circle(_) => body.with_fixed_nodes(&std::mem::take(arcs)),
        ClampRegion::Face { face, rows } => body.with_fixed_rows(face.axis(), side(face), rows),
        ClampRegion::Box(bounds) => {
            let tolerance = TOUCHING * body.spacing();
            for (position, clamped) in body.positions.iter().zip(&mut body.clamped) {
                let inside = |i: usize| {
                    bounds.low[i] - tolerance <= position[i] && position[i] <= bounds.high[i] + tolerance
                };
                *clamped |= (0..D).all(inside);
            }
            body
        }
    }
}

fn corners<const D: usize>(bounds: &AxisBox) -> (Vector<D>, Vector<D>) {
    (Vector::from_column_slice(&bounds.low), Vector::from_column_slice(&bounds.high))
}

/// Points on a face of a box, about `spacing` (m) apart: centres of the cells that tile it.
fn face_points<const D: usize>(face: Face, of: &AxisBox, spacing: f64) -> Vec<Vector<D>> {
    let (mut low, mut high) = corners::<D>(of);
    let (axis, coordinate) = (face.axis(), of.coordinate(face));
    // One cell thick about the face: its cell centres lie on the face.
    (low[axis], high[axis]) = (coordinate - 0.5 * spacing, coordinate + 0.5 * spacing);
    Lattice::fill_box(low, high, spacing).positions
}

/// Whether the body's particles are no lattice along the axes.
fn off_lattice(part: &structure::Body, clamps: &[&Clamp]) -> bool {
    let is_cut = clamps.iter().any(|clamp| clamp.circle.is_some());
    part.lattice_angle != 0.0 || part.jitter != 0.0 || part.relaxation > 0 || is_cut
}

/// The body of particles that are no lattice, cut by its clamps' circles, and the fixed nodes on their arcs.
/// A checked case has two dimensions where it comes to this.
fn scattered<const D: usize>(
    part: &structure::Body,
    clamps: &[&Clamp],
    spacing: f64,
    like: &Body<D>,
) -> Result<(Body<D>, Vec<Vector<D>>)> {
    let (low, high) = corners::<2>(&part.bounds);
    let (mut outline, mut arcs) = (rectangle(low, high), Vec::new());
    for clamp in clamps {
        let Some(circle) = &clamp.circle else { continue };
        let centre = Vector::from_column_slice(&circle.centre);
        let (cut, nodes) = without_disc(&outline, &centre, circle.radius, spacing).ok_or_else(|| {
            failed(format!(
                "clamp `{}`: its circle does not cut the border of the body `{}` in two points; let it reach across one end of the body",
                clamp.name, part.name
            ))
        })?;
        outline = cut;
        arcs.extend(nodes.iter().map(|n| Vector::from_column_slice(n.as_slice())));
    }
    let filling = Filling {
        spacing,
        lattice_angle: part.lattice_angle,
        jitter: part.jitter,
        seed: u64::from(part.seed),
        sweeps: part.relaxation as usize,
    };
    let (positions, cells) = filling.fill(low, high, &outline);
    let positions = positions.iter().map(|p| Vector::from_column_slice(p.as_slice())).collect();
    let cells: Vec<Cell<D>> = cells
        .iter()
        .map(|cell| Cell {
            volume: cell.volume,
            offset: Vector::from_column_slice(cell.offset.as_slice()),
            moment: Matrix::from_fn(|i, j| cell.moment[(i, j)]),
        })
        .collect();
    Ok((Body::from_cells(positions, &cells, spacing, like.material, like.density), arcs))
}

fn side(face: Face) -> Side {
    if face.sign() < 0.0 { Side::Low } else { Side::High }
}

fn velocity<const D: usize>(from: &InitialVelocity, bounds: &AxisBox, position: &Vector<D>) -> Vector<D> {
    match from {
        InitialVelocity::Uniform(velocity) => Vector::from_column_slice(velocity),
        InitialVelocity::Mode(mode) => {
            let from_clamp =
                (position[mode.clamped_face.axis()] - bounds.coordinate(mode.clamped_face)).abs();
            let length = bounds.extent()[mode.clamped_face.axis()];
            cantilever(mode, from_clamp, length)
        }
    }
}

/// Eqs. (51)–(52): the first bending mode at the distance `s` (m) from the clamp of a beam of `length` (m).
fn cantilever<const D: usize>(mode: &CantileverVelocity, s: f64, length: f64) -> Vector<D> {
    const KL: f64 = 1.875;
    let f = |x: f64| {
        (KL.cos() + KL.cosh()) * (x.cosh() - x.cos()) + (KL.sin() - KL.sinh()) * (x.sinh() - x.sin())
    };
    Vector::from_column_slice(&mode.tip_velocity) * (f(KL * s / length) / f(KL))
}

/// The load's force shared over the body's particles, so that force and moment are those of the load on its
/// true face or point.
fn dead_load<const D: usize>(
    load: &structure::Load,
    part: &structure::Body,
    body: &Body<D>,
    first: usize,
    spacing: f64,
) -> DeadLoad<D> {
    let points: Option<Vec<Vector<D>>> = match (load.face, &load.at) {
        (Some(face), _) => Some(face_points(face, &part.bounds, spacing)),
        (None, Some(at)) => Some(vec![Vector::from_column_slice(at)]),
        (None, None) => None,
    };
    let mut shares = vec![0.0; body.positions.len()];
    match points {
        None => {
            let free: f64 =
                body.volumes.iter().zip(&body.clamped).filter(|(_, c)| !**c).map(|(v, _)| v).sum();
            for ((share, volume), clamped) in shares.iter_mut().zip(&body.volumes).zip(&body.clamped) {
                *share = if *clamped { 0.0 } else { volume / free };
            }
        }
        Some(points) => {
            for at in &points {
                let point = MaterialPoint::new(*at, &body.positions, body.spacing())
                    .expect("a body of a checked case has particles");
                for (particle, weight) in point.weights {
                    shares[particle] += weight / points.len() as f64;
                }
            }
        }
    }
    let particles =
        shares.iter().enumerate().filter(|(_, s)| **s != 0.0).map(|(i, s)| (first + i, *s)).collect();
    let history = History::through(load.ramp.iter().map(|[time, factor]| (*time, *factor)).collect());
    DeadLoad { particles, force: Vector::from_column_slice(&load.force), history }
}
