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
    /// The point (m), on the structure in the reference configuration; none for a force.
    #[schemars(with = "Option<PerAxis<f64>>")]
    pub at: Option<Vec<f64>>,
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
    /// The structure: displacement, position and velocity at a point; force of the fluid on a body.
    Structure,
    /// The fluid: pressure and velocity at a point; extent, centroid and spread of the fluid in a box.
    Fluid,
    /// A wall: pressure at a point; force of the fluid on the wall.
    Wall,
}

/// Where a probe looks. Which quantities it may record stands beside each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProbeTarget<'a> {
    /// A point of a body's reference configuration (m): displacement, position, velocity.
    StructurePoint {
        /// The body.
        body: &'a str,
        /// The point (m).
        at: &'a [f64],
    },
    /// A whole body: the force of the fluid on it.
    Body(&'a str),
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
}

impl Probe {
    /// Where it looks: a name or point that is missing, which no checked case lacks, is empty.
    pub fn target(&self) -> ProbeTarget<'_> {
        let at = self.at.as_deref().unwrap_or_default();
        let (body, wall) =
            (self.body.as_deref().unwrap_or_default(), self.wall.as_deref().unwrap_or_default());
        match (self.on, self.quantity) {
            (ProbeSide::Structure, ProbeQuantity::Force) => ProbeTarget::Body(body),
            (ProbeSide::Structure, _) => ProbeTarget::StructurePoint { body, at },
            (ProbeSide::Fluid, quantity) if quantity.is_of_a_box() => {
                ProbeTarget::FluidBox(self.bounds.as_ref())
            }
            (ProbeSide::Fluid, _) => ProbeTarget::FluidPoint(at),
            (ProbeSide::Wall, ProbeQuantity::Force) => ProbeTarget::Wall(wall),
            (ProbeSide::Wall, _) => ProbeTarget::WallPoint { wall, at },
        }
    }

    /// Its columns in `probes.csv`: `<name>.<component>`.
    pub fn columns(&self, dimension: usize) -> Vec<String> {
        self.quantity
            .components(dimension)
            .iter()
            .map(|component| format!("{}.{component}", self.name))
            .collect()
    }

    /// The scalars that the participant which records it describes, one a column.
    pub fn scalars(&self, dimension: usize) -> impl Iterator<Item = Scalar> {
        let (unit, meaning) = (self.quantity.unit(), self.meaning());
        let scalar = move |name| Scalar::new(name, unit, ScalarKind::Probe).meaning(meaning.clone());
        self.columns(dimension).into_iter().map(scalar)
    }

    /// What it records, in words.
    fn meaning(&self) -> String {
        let quantity = self.quantity;
        let meaning = match self.target() {
            ProbeTarget::StructurePoint { body, at } => format!("{quantity} of {body} at {at:?} m"),
            ProbeTarget::Body(body) => format!("{quantity} of the fluid on {body}"),
            ProbeTarget::FluidPoint(at) => format!("{quantity} of the fluid at {at:?} m"),
            ProbeTarget::FluidBox(None) => format!("{quantity} of the fluid"),
            ProbeTarget::FluidBox(Some(within)) => {
                format!("{quantity} of the fluid between {:?} and {:?} m", within.low, within.high)
            }
            ProbeTarget::WallPoint { wall, at } => format!("{quantity} on {wall} at {at:?} m"),
            ProbeTarget::Wall(wall) => format!("{quantity} of the fluid on {wall}"),
        };
        match &self.relative_to {
            Some(frame) => format!("{meaning}, seen from {frame}"),
            None => meaning,
        }
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
