//! Probes of the case, and where in the fluid each looks.

use super::{failed, setup};
use crate::boundaries::wall_motion::Motion;
use crate::probes::area::Area;
use interfaces::Result;
use interfaces::case::probe::{Probe, ProbeTarget};
use interfaces::case::{Case, motion};
use sph::Vector;
use words::probe::ProbeQuantity;

/// A probe, the place at which it looks and the frame that it goes with.
pub struct Watched<const D: usize> {
    pub probe: Probe,
    pub place: Place<D>,
    pub frame: Option<Motion<D>>,
}

/// Where a probe looks.
pub enum Place<const D: usize> {
    /// At a point of the fluid or of a wall (m).
    Point(Vector<D>),
    /// At all of the fluid below a point (m).
    Level(Vector<D>),
    /// At the fluid between two corners (m), or at all of it.
    Box(Option<(Vector<D>, Vector<D>)>),
    /// At a wall.
    Wall(String),
    /// At a wall, about a point (m).
    WallAbout(String, Vector<D>),
    /// Along a line, from a point (m) in the direction of a unit vector.
    Line { at: Vector<D>, direction: Vector<D> },
    /// At the pressure on an area.
    Sensor(Area<D>),
    /// At what crosses an area.
    Crossed(Area<D>),
}

impl<const D: usize> Place<D> {
    /// Whether fields are interpolated there.
    pub fn is_interpolated(&self) -> bool {
        matches!(self, Self::Point(_) | Self::Sensor(_))
    }
}

impl<const D: usize> Watched<D> {
    /// # Errors
    /// A probe of what is not in a fluid; no checked case has one.
    pub fn new(probe: &Probe, case: &Case) -> Result<Self> {
        let place = place(probe, &case.general.gravity)
            .ok_or_else(|| failed(format!("probe `{}` does not look at the fluid", probe.name)))?;
        let frame = case.frame_of(probe).and_then(motion::Motion::rigid);
        Ok(Self { probe: probe.clone(), place, frame })
    }

    /// Whether it counts what crosses an area.
    pub fn is_flux(&self) -> bool {
        matches!(self.place, Place::Crossed(_))
    }
}

fn place<const D: usize>(probe: &Probe, gravity: &[f64]) -> Option<Place<D>> {
    let vector = |list: &[f64]| Vector::<D>::from_column_slice(list);
    Some(match probe.target() {
        ProbeTarget::FluidPoint(level) if probe.quantity == ProbeQuantity::HydrostaticError => {
            Place::Level(vector(level))
        }
        ProbeTarget::FluidPoint(at) | ProbeTarget::WallPoint { at, .. } => Place::Point(vector(at)),
        ProbeTarget::FluidBox(bounds) => Place::Box(bounds.map(setup::corners)),
        ProbeTarget::Wall(name) => Place::Wall(name.to_owned()),
        ProbeTarget::WallAbout { wall, at } => Place::WallAbout(wall.to_owned(), vector(at)),
        ProbeTarget::Line { at, direction } => {
            let direction = direction.map_or_else(|| -vector(gravity), vector);
            Place::Line { at: vector(at), direction: direction.try_normalize(0.0)? }
        }
        ProbeTarget::Area(area) => {
            let (at, towards) = (vector(area.at), area.direction.map(vector));
            let edges: Vec<Vector<D>> = area.span.iter().map(|edge| vector(edge)).collect();
            let made = match area.radius {
                Some(radius) => Area::disc(at, radius, &towards?)?,
                None => Area::of_edges(at, &edges, towards.as_ref())?,
            };
            if probe.quantity == ProbeQuantity::Flux { Place::Crossed(made) } else { Place::Sensor(made) }
        }
        ProbeTarget::StructurePoint { .. } | ProbeTarget::Body(_) | ProbeTarget::BodyAbout { .. } => {
            return None;
        }
    })
}
