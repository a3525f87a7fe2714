//! A functional mock-up unit (FMU) in a participant's place: as written.

use crate::port::names;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Variables behind the ports of an FMU, and numbers that it tells. A port that is left out has the variable
/// of its own name, if there is one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Variables {
    /// Position of the interface points (m): the structure gives it.
    pub position: Option<Source>,
    /// Velocity of the interface points (m/s): the structure gives it.
    pub velocity: Option<Source>,
    /// Reference volume of the interface points (m³), once: the structure gives it.
    pub reference_volume: Option<Source>,
    /// Density at the interface points (kg/m³), once: the structure gives it.
    pub density: Option<Source>,
    /// Facets of the boundary, once: a structure with points of its own gives them.
    pub facets: Option<Source>,
    /// Pressure gradient at the interface points (Pa/m): the fluid gives it.
    pub pressure_gradient: Option<Source>,
    /// Pressure at the interface points (Pa): the fluid gives it.
    pub pressure: Option<Source>,
    /// What the fluid received from the interface points (Pa/m): the fluid gives it, for condition (46).
    pub pair_reaction: Option<Source>,
    /// Normals of the interface points: the fluid gives them, for condition (46).
    pub normal: Option<Source>,
    /// Pressure gradient of the last window (Pa/m): a fluid takes it.
    pub held_pressure_gradient: Option<Source>,
    /// Pressure gradient at the window's start (Pa/m): a structure takes it, where the load is linear within
    /// a window.
    pub start_pressure_gradient: Option<Source>,
    /// Positions of its own points at the start (m): a fluid with such points gives them.
    pub own_position: Option<Source>,
    /// Displacement of its own points since the start (m): a fluid with such points takes it.
    pub displacement: Option<Source>,
    /// Force on its own points (N): a structure with such points takes it, a fluid gives it.
    pub force: Option<Source>,
    /// Force at the window's start (N): a structure with points of its own takes it, where the load is linear
    /// within a window.
    pub start_force: Option<Source>,
    /// Largest next step that the FMU takes (s); `largest_step` if left out and there, otherwise any.
    pub window_limit: Option<String>,
    /// Its own sub-steps in the last step; `steps_taken` if left out and there, otherwise 1.
    pub sub_steps: Option<String>,
}

/// Where a port's values are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Source {
    /// The same number at all points; only for what does not change.
    Number(f64),
    /// An array of points × components, one variable for all points of what does not change, or a pattern of
    /// scalars: `point[{point}].force.{axis}`.
    Name(String),
    /// Scalars, point by point.
    Names(Vec<String>),
}

/// Value of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ParameterValue {
    /// A switch.
    Boolean(bool),
    /// A number; a whole one for variables that count.
    Number(f64),
    /// A text.
    Text(String),
    /// An array.
    Numbers(Vec<f64>),
}

/// Values of parameters, by name.
pub type Parameters = BTreeMap<String, ParameterValue>;

impl Variables {
    /// The ports and where their values are, as far as the case says.
    pub fn ports(&self) -> [(&'static str, Option<&Source>); 15] {
        [
            (names::REFERENCE_VOLUME, self.reference_volume.as_ref()),
            (names::DENSITY, self.density.as_ref()),
            (names::FACETS, self.facets.as_ref()),
            (names::POSITION, self.position.as_ref()),
            (names::VELOCITY, self.velocity.as_ref()),
            (names::PRESSURE_GRADIENT, self.pressure_gradient.as_ref()),
            (names::PRESSURE, self.pressure.as_ref()),
            (names::PAIR_REACTION, self.pair_reaction.as_ref()),
            (names::NORMAL, self.normal.as_ref()),
            (names::HELD_PRESSURE_GRADIENT, self.held_pressure_gradient.as_ref()),
            (names::START_PRESSURE_GRADIENT, self.start_pressure_gradient.as_ref()),
            (names::OWN_POSITION, self.own_position.as_ref()),
            (names::DISPLACEMENT, self.displacement.as_ref()),
            (names::FORCE, self.force.as_ref()),
            (names::START_FORCE, self.start_force.as_ref()),
        ]
    }

    /// Whether nothing is said.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
