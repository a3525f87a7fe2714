//! `[[probe]]`, `[[reference]]`: what is recorded at every window, and values from elsewhere beside it.

use super::geometry::{AxisBox, PerAxis};
use crate::participant::{Scalar, ScalarKind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use words::probe::ProbeQuantity;

/// A quantity recorded at every window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Name; the columns of `probes.csv` are `<name>.<component>`.
    pub name: String,
    /// What it looks at.
    pub on: ProbeSide,
    /// What it records.
    pub quantity: ProbeQuantity,
    /// The point (m), on the structure in the reference configuration; none for a force. Of a moment it is
    /// the point that the moment is about, of a line where it begins, of an area the middle.
    #[schemars(with = "Option<PerAxis<f64>>")]
    pub at: Option<Vec<f64>>,
    /// Where a line goes, of any length: of a surface height, against gravity if left out. Of a flux it is
    /// the side to which what crosses counts as positive. It is the normal of a disc.
    #[schemars(with = "Option<PerAxis<f64>>")]
    pub direction: Option<Vec<f64>>,
    /// Edges of an area (m), `at` in its middle: in two dimensions one, of a segment, in three two, of a
    /// rectangle. A pressure is then that of a sensor: the mean over the area, 0 where it is dry.
    #[schemars(with = "Option<Vec<PerAxis<f64>>>")]
    pub span: Option<Vec<Vec<f64>>>,
    /// Radius of a disc (m) about `at`, in three dimensions, in place of `span`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: Option<f64>,
    /// Length (s) of the intervals over which means and extremes are taken, in `probes_intervals.csv`; none
    /// if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
    /// Cut-off frequency (Hz) of a Butterworth low-pass of second order, whose values have columns of their
    /// own, `<name>.<component>_butterworth`; none if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub low_pass: Option<f64>,
    /// Box in which the fluid's extent, centroid or spread is taken; all of the fluid if left out.
    #[serde(rename = "box")]
    pub bounds: Option<AxisBox>,
    /// The body, where the structure has more than one.
    pub body: Option<String>,
    /// The wall, where the fluid has more than one.
    pub wall: Option<String>,
    /// Wall, clamp or motion with which the probe goes: it records in the frame that moves so, along axes
    /// that turn with it, and a point of the fluid or of a wall, or a box, goes along. The frame at rest if
    /// left out.
    pub relative_to: Option<String>,
}

/// What a probe looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ProbeSide {
    /// The structure: displacement, position, velocity, stress and strain at a point; force and moment of the
    /// fluid on a body.
    Structure,
    /// The fluid: pressure and velocity at a point; extent, centroid and spread of the fluid in a box; height
    /// of its surface along a line; flux through an area.
    Fluid,
    /// A wall: pressure at a point or over a sensor's area; force and moment of the fluid on the wall.
    Wall,
}

/// Where a probe looks. Which quantities it may record stands beside each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProbeTarget<'a> {
    /// A point of a body's reference configuration (m): displacement, position, velocity, stress, strain.
    StructurePoint {
        /// The body.
        body: &'a str,
        /// The point (m).
        at: &'a [f64],
    },
    /// A whole body: the force of the fluid on it.
    Body(&'a str),
    /// A whole body: the moment of the fluid's force on it about a point (m).
    BodyAbout {
        /// The body.
        body: &'a str,
        /// The point (m).
        at: &'a [f64],
    },
    /// A point of space in the fluid (m): pressure, velocity.
    FluidPoint(&'a [f64]),
    /// The fluid in a box, or all of it: extent, centroid, spread.
    FluidBox(Option<&'a AxisBox>),
    /// A point on a wall (m): pressure.
    WallPoint {
        /// The wall.
        wall: &'a str,
        /// The point (m).
        at: &'a [f64],
    },
    /// A whole wall: the force of the fluid on it.
    Wall(&'a str),
    /// A whole wall: the moment of the fluid's force on it about a point (m).
    WallAbout {
        /// The wall.
        wall: &'a str,
        /// The point (m).
        at: &'a [f64],
    },
    /// A line through the fluid: where its surface is.
    Line {
        /// Where it begins (m).
        at: &'a [f64],
        /// Where it goes, of any length; against gravity where there is none.
        direction: Option<&'a [f64]>,
    },
    /// An area in the fluid or on a wall: flux, pressure.
    Area(Area<'a>),
}

/// A flat area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area<'a> {
    /// Its middle (m).
    pub at: &'a [f64],
    /// Its edges (m): one of a segment, two of a rectangle, none of a disc.
    pub span: &'a [Vec<f64>],
    /// Radius of a disc (m).
    pub radius: Option<f64>,
    /// The side to which it looks.
    pub direction: Option<&'a [f64]>,
}

/// What stands behind a probe's column where it is low-passed.
pub const LOW_PASSED: &str = "_butterworth";
/// What stands behind a probe's column in the table of intervals: mean, least and largest value.
pub const OVER_INTERVAL: [&str; 3] = ["_mean", "_min", "_max"];

impl Probe {
    /// Where it looks: a name or point that is missing, which no checked case lacks, is empty.
    pub fn target(&self) -> ProbeTarget<'_> {
        let at = self.at.as_deref().unwrap_or_default();
        let (body, wall) =
            (self.body.as_deref().unwrap_or_default(), self.wall.as_deref().unwrap_or_default());
        match (self.on, self.quantity) {
            (ProbeSide::Structure, ProbeQuantity::Force) => ProbeTarget::Body(body),
            (ProbeSide::Structure, ProbeQuantity::Moment) => ProbeTarget::BodyAbout { body, at },
            (ProbeSide::Structure, _) => ProbeTarget::StructurePoint { body, at },
            (ProbeSide::Fluid, quantity) if quantity.is_of_a_box() => {
                ProbeTarget::FluidBox(self.bounds.as_ref())
            }
            (ProbeSide::Fluid, ProbeQuantity::SurfaceHeight) => {
                ProbeTarget::Line { at, direction: self.direction.as_deref() }
            }
            (ProbeSide::Fluid | ProbeSide::Wall, ProbeQuantity::Flux | ProbeQuantity::Pressure)
                if self.span.is_some() || self.radius.is_some() =>
            {
                ProbeTarget::Area(Area {
                    at,
                    span: self.span.as_deref().unwrap_or_default(),
                    radius: self.radius,
                    direction: self.direction.as_deref(),
                })
            }
            (ProbeSide::Fluid, _) => ProbeTarget::FluidPoint(at),
            (ProbeSide::Wall, ProbeQuantity::Force) => ProbeTarget::Wall(wall),
            (ProbeSide::Wall, ProbeQuantity::Moment) => ProbeTarget::WallAbout { wall, at },
            (ProbeSide::Wall, _) => ProbeTarget::WallPoint { wall, at },
        }
    }

    /// Its columns in `probes.csv`, those that are low-passed left out: `<name>.<component>`.
    pub fn columns(&self, dimension: usize) -> Vec<String> {
        self.quantity
            .components(dimension)
            .iter()
            .map(|component| format!("{}.{component}", self.name))
            .collect()
    }

    /// All its columns, by table: those of `probes.csv`, and those of `probes_intervals.csv`.
    pub fn all_columns(&self, dimension: usize) -> [Vec<String>; 2] {
        let own = self.columns(dimension);
        let with = |ends: &[&str]| -> Vec<String> {
            own.iter().flat_map(|column| ends.iter().map(move |end| format!("{column}{end}"))).collect()
        };
        let low_passed = if self.low_pass.is_some() { with(&[LOW_PASSED]) } else { Vec::new() };
        let over_interval = if self.interval.is_some() { with(&OVER_INTERVAL) } else { Vec::new() };
        [[own.clone(), low_passed].concat(), over_interval]
    }

    /// The scalars that the participant which records it describes, one a column.
    pub fn scalars(&self, dimension: usize) -> impl Iterator<Item = Scalar> {
        let (quantity, meaning) = (self.quantity, self.meaning());
        let components = quantity.components(dimension).iter().zip(self.columns(dimension));
        components.map(move |(component, name)| {
            let unit = quantity.unit(component);
            Scalar::new(name, unit, ScalarKind::Probe).meaning(meaning.clone())
        })
    }

    /// What it records, in words.
    fn meaning(&self) -> String {
        let quantity = self.quantity;
        let meaning = match self.target() {
            ProbeTarget::StructurePoint { body, at } => format!("{quantity} of {body} at {at:?} m"),
            ProbeTarget::Body(body) => format!("{quantity} of the fluid on {body}"),
            ProbeTarget::BodyAbout { body: on, at } | ProbeTarget::WallAbout { wall: on, at } => {
                format!("{quantity} of the fluid on {on} about {at:?} m")
            }
            ProbeTarget::FluidPoint(at) => format!("{quantity} of the fluid at {at:?} m"),
            ProbeTarget::FluidBox(None) => format!("{quantity} of the fluid"),
            ProbeTarget::FluidBox(Some(within)) => {
                format!("{quantity} of the fluid between {:?} and {:?} m", within.low, within.high)
            }
            ProbeTarget::WallPoint { wall, at } => format!("{quantity} on {wall} at {at:?} m"),
            ProbeTarget::Wall(wall) => format!("{quantity} of the fluid on {wall}"),
            ProbeTarget::Line { at, .. } => format!("{quantity} of the fluid along the line from {at:?} m"),
            ProbeTarget::Area(area) => {
                format!("{quantity} of the fluid over the area around {:?} m", area.at)
            }
        };
        match &self.relative_to {
            Some(frame) => format!("{meaning}, seen from {frame}"),
            None => meaning,
        }
    }

    /// Whether positions, velocities and loads of a structure's interface points tell of it: then the coupler
    /// records it of a structure that does not.
    pub fn is_of_interface(&self) -> bool {
        use ProbeQuantity::{Displacement, Force, Moment, Position, Velocity};
        self.is_on_structure() && matches!(self.quantity, Displacement | Position | Velocity | Force | Moment)
    }

    /// Whether the structure records it (otherwise the fluid does).
    pub fn is_on_structure(&self) -> bool {
        self.on == ProbeSide::Structure
    }
}

/// Values from elsewhere for one column of a probe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// The column: `<probe>.<component>`.
    pub probe: String,
    /// What the report's legend says.
    pub label: String,
    /// Where it is from.
    pub source: String,
    /// Times (s), growing.
    pub time: Vec<f64>,
    /// Values at the times, in the probe's SI unit.
    pub value: Vec<f64>,
    /// Lower border of the values; the values themselves if left out.
    #[schemars(with = "Option<Vec<f64>>")]
    pub low: Vec<f64>,
    /// Upper border of the values; the values themselves if left out.
    #[schemars(with = "Option<Vec<f64>>")]
    pub high: Vec<f64>,
}
