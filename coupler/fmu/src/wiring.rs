//! Which variables are behind which port, and what is recorded.

mod values;

use crate::Error;
use crate::description::{Causality, Description, Type, Variable};
use interfaces::case::Case;
use interfaces::case::coupling::CouplingScheme;
use interfaces::case::participant::Unit;
use interfaces::case::probe::Probe;
use interfaces::case::unit::ParameterValue;
use interfaces::port::names;
use interfaces::{Direction, Exchange, Port, Quantity, Role, Scalar, ScalarKind};
use std::collections::BTreeMap;

/// A unit's part in a coupling.
#[derive(Clone, Debug, PartialEq)]
pub struct Wiring {
    /// The ports, and where their values are.
    pub wires: Vec<Wire>,
    /// What is recorded.
    pub records: Vec<Record>,
    /// Tells the largest next step, and what it has to be multiplied by to be in seconds.
    pub window_limit: Option<(Variable, f64)>,
    /// Tells how many sub-steps the last step had.
    pub sub_steps: Option<Variable>,
    /// What to set before initialisation.
    pub parameters: Vec<(Variable, ParameterValue)>,
    /// What looks odd and may be meant, one line each.
    pub notes: Vec<String>,
}

/// A scalar and what is behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// What is reported.
    pub scalar: Scalar,
    /// Where its value is.
    pub variable: Variable,
    /// What that has to be multiplied by to be in the scalar's unit.
    pub factor: f64,
}

/// A port and what is behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct Wire {
    /// The port, its number of points known.
    pub port: Port,
    /// Where its values are.
    pub values: Values,
    /// What its variables have to be multiplied by to be in the port's unit.
    pub factor: f64,
}

/// Values of a port, their number of points where it is known, and the factor to the port's unit.
struct Sourced {
    values: Values,
    points: Option<usize>,
    factor: f64,
}

/// Where the values of a port are.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// In variables, their values one after another.
    Variables(Vec<u32>),
    /// In one variable, for all points.
    Same(u32),
    /// In the case, for all points.
    Number(f64),
}

/// What a participant's report holds by default, where the unit has variables of these names.
const ENERGIES: [&str; 9] = [
    names::KINETIC_ENERGY,
    names::STRAIN_ENERGY,
    names::POTENTIAL_ENERGY,
    names::LOAD_WORK,
    names::CLAMP_WORK,
    names::WALL_WORK,
    names::CONTACT_ENERGY,
    names::DISSIPATED_ENERGY,
    names::FRICTION_LOSS,
];

/// Ports of a side: name, quantity, direction, exchange.
fn ports_of(role: Role) -> Vec<(&'static str, Quantity, Direction, Exchange)> {
    use Direction::{In, Out};
    use Exchange::{Constant, EveryWindow};
    let (motion, load) = match role {
        Role::Structure => (Out, In),
        Role::Fluid => (In, Out),
    };
    let mut ports = vec![
        (names::REFERENCE_VOLUME, Quantity::ReferenceVolume, motion, Constant),
        (names::DENSITY, Quantity::Density, motion, Constant),
        (names::POSITION, Quantity::Position, motion, EveryWindow),
        (names::VELOCITY, Quantity::Velocity, motion, EveryWindow),
        (names::PRESSURE_GRADIENT, Quantity::PressureGradient, load, EveryWindow),
        (names::PRESSURE, Quantity::Pressure, load, EveryWindow),
    ];
    ports.extend(match role {
        Role::Structure => vec![
            (names::FACETS, Quantity::Facet, Out, Constant),
            (names::START_PRESSURE_GRADIENT, Quantity::PressureGradient, In, EveryWindow),
            (names::FORCE, Quantity::Force, In, EveryWindow),
            (names::START_FORCE, Quantity::Force, In, EveryWindow),
        ],
        Role::Fluid => vec![
            (names::PAIR_REACTION, Quantity::PairReaction, Out, EveryWindow),
            (names::NORMAL, Quantity::Normal, Out, EveryWindow),
            (names::HELD_PRESSURE_GRADIENT, Quantity::PressureGradient, In, EveryWindow),
            (names::OWN_POSITION, Quantity::Position, Out, Constant),
            (names::DISPLACEMENT, Quantity::Displacement, In, EveryWindow),
            (names::FORCE, Quantity::Force, Out, EveryWindow),
        ],
    });
    ports
}

/// Wires the unit that solves the side `role` of `case`.
///
/// # Errors
/// All that does not fit.
pub fn wire(unit: Unit<'_>, description: &Description, case: &Case, role: Role) -> Result<Wiring, Error> {
    let mut plan = Plan { unit, description, role, mismatches: Vec::new(), notes: Vec::new() };
    let parameters = plan.parameters();
    let wires = plan.wires(case.general.dimension);
    let records = plan.records(&case.probes, case.general.dimension);
    let window_limit = plan.window_limit();
    let sub_steps = plan.number("sub_steps", unit.variables.sub_steps.as_deref(), "steps_taken");
    plan.check_state(case);
    plan.note_mapping(&wires, case);
    plan.note_clamps(case);
    let Plan { mismatches, notes, .. } = plan;
    if mismatches.is_empty() {
        Ok(Wiring { wires, records, window_limit, sub_steps, parameters, notes })
    } else {
        Err(Error::Wiring { file: unit.file.to_owned(), mismatches })
    }
}

struct Plan<'a> {
    unit: Unit<'a>,
    description: &'a Description,
    role: Role,
    mismatches: Vec<String>,
    notes: Vec<String>,
}

/// A port before the number of points is known.
struct Found {
    name: &'static str,
    quantity: Quantity,
    direction: Direction,
    exchange: Exchange,
    sourced: Sourced,
}

impl Plan<'_> {
    fn key(&self, rest: &str) -> String {
        format!("{}.participant.{rest}", self.role)
    }

    /// Windows are solved again by implicit schemes, and after a prediction, by a structure.
    fn check_state(&mut self, case: &Case) {
        let Some(coupling) = case.coupling.as_ref().filter(|_| !self.description.keeps_state) else { return };
        let predicts = self.role == Role::Structure
            && coupling.scheme == CouplingScheme::SerialExplicit
            && coupling.prediction == Some(true);
        if coupling.scheme.is_implicit() || predicts {
            let key = self.key("fmu");
            self.mismatches.push(format!(
                "{key}: it cannot solve a window again (canGetAndSetFMUState is false); take coupling.scheme = \"serial-explicit\" with coupling.prediction = false, or \"parallel-explicit\""
            ));
        }
    }

    /// A structure that takes forces alone meets the fluid through a mapping, which the case need not name.
    fn note_mapping(&mut self, wires: &[Wire], case: &Case) {
        let takes =
            |name: &str| wires.iter().any(|w| w.port.name == name && w.port.direction == Direction::In);
        let named = case.coupling.as_ref().is_none_or(|coupling| coupling.mapping.is_some());
        if self.role == Role::Structure && takes(names::FORCE) && !takes(names::PRESSURE_GRADIENT) && !named {
            self.notes.push(
                "it takes forces at points of its own: the fluid meets the case's bodies through a mapping by radial basis functions (choose another with coupling.mapping)".to_owned(),
            );
        }
    }

    /// A unit of ours holds the case that it was exported from, one of another make its own.
    fn note_clamps(&mut self, case: &Case) {
        let clamps = case.structure.iter().flat_map(|structure| &structure.clamps);
        for clamp in clamps.filter(|clamp| self.role == Role::Structure && clamp.moves().is_some()) {
            let name = &clamp.name;
            self.notes.push(format!(
                "the clamp \"{name}\" moves as the unit has it from its export, not as this case says"
            ));
        }
    }

    fn wires(&mut self, dimension: usize) -> Vec<Wire> {
        let said = self.unit.variables.ports();
        let known = ports_of(self.role);
        for (name, _) in said
            .iter()
            .filter(|(name, source)| source.is_some() && known.iter().all(|(port, ..)| port != name))
        {
            let key = self.key(&format!("variables.{name}"));
            self.mismatches.push(format!("{key}: a {} has no such port", self.role));
        }
        let mut found = Vec::new();
        for (name, quantity, direction, exchange) in known {
            let source = said.iter().find(|(port, _)| *port == name).and_then(|(_, source)| *source);
            let values = match source {
                Some(source) => self.said(name, source, quantity.components(dimension), direction, exchange),
                None => self.of_own_name(name, quantity.components(dimension), direction, exchange),
            };
            if let Some(sourced) = values {
                found.push(Found { name, quantity, direction, exchange, sourced });
            }
        }
        self.check_inputs(&found);
        self.check_needed(&found);
        let points = self.common_points(&found);
        found
            .into_iter()
            .map(|Found { name, quantity, direction, exchange, sourced }| {
                let Sourced { values, points: own, factor } = sourced;
                let port = Port::new(name, quantity, dimension, own.or(points), direction);
                let port = if exchange == Exchange::Constant { port.constant() } else { port };
                // A unit takes what is given; what nobody gives stays at its start value, and that is for the
                // partner to know.
                let needed =
                    name == names::PRESSURE_GRADIENT || name == names::FORCE || name == names::POSITION;
                let port = if direction == Direction::In && !needed { port.optional() } else { port };
                Wire { port, values, factor }
            })
            .collect()
    }

    fn check_needed(&mut self, found: &[Found]) {
        let has = |name: &str| found.iter().any(|port| port.name == name);
        let needed: &[&[&str]] = match self.role {
            Role::Structure => {
                &[&[names::POSITION], &[names::VELOCITY], &[names::PRESSURE_GRADIENT, names::FORCE]]
            }
            Role::Fluid => &[&[names::PRESSURE_GRADIENT], &[names::POSITION]],
        };
        let said = self.unit.variables.ports();
        let is_said = |name: &str| said.iter().any(|(port, source)| *port == name && source.is_some());
        let missing: Vec<_> = needed
            .iter()
            // One that was named and does not fit was reported already.
            .filter(|any| !any.iter().any(|name| has(name) || is_said(name)))
            .collect();
        for any in missing {
            let key = self.key(&format!("variables.{}", any[0]));
            let ports = any.join("` or `");
            self.mismatches.push(format!(
                "{key}: nothing is behind port `{ports}`, which a {} needs; name variables",
                self.role
            ));
        }
    }

    /// A variable that takes two values keeps the last alone.
    fn check_inputs(&mut self, found: &[Found]) {
        let mut taken = BTreeMap::new();
        for port in found.iter().filter(|port| port.direction == Direction::In) {
            let Values::Variables(references) = &port.sourced.values else { continue };
            for reference in references {
                if let Some(other) = taken.insert(*reference, port.name) {
                    let mut of = self.description.variables.iter().filter(|v| v.reference == *reference);
                    let name = of.next().map_or_else(String::new, |variable| variable.name.clone());
                    let key = self.key(&format!("variables.{}", port.name));
                    self.mismatches.push(format!(
                        "{key}: `{name}` (value reference {reference}) takes a value of `{other}` already, and keeps one alone"
                    ));
                }
            }
        }
    }

    /// The number of points of all ports but those with a number of their own.
    fn common_points(&mut self, found: &[Found]) -> Option<usize> {
        let counted: Vec<(&str, usize)> = found
            .iter()
            .filter(|port| port.quantity != Quantity::Facet)
            .filter_map(|port| Some((port.name, port.sourced.points?)))
            .collect();
        let (first, points) = *counted.first()?;
        for (name, other) in counted.iter().filter(|(_, other)| *other != points) {
            self.mismatches.push(format!("`{first}` has {points} points, `{name}` has {other}"));
        }
        Some(points)
    }

    fn records(&mut self, probes: &[Probe], dimension: usize) -> Vec<Record> {
        let mut records: Vec<Record> = Vec::new();
        let of_case = ENERGIES.map(|name| Scalar::new(name, "J", ScalarKind::Balance));
        let on_structure = self.role == Role::Structure;
        let is_mine = |probe: &&Probe| probe.is_on_structure() == on_structure;
        let of_probes = probes.iter().filter(is_mine).flat_map(|probe| {
            // What the coupler can tell from the interface is missed by nobody.
            probe.scalars(dimension).map(|scalar| (scalar, !probe.is_of_interface()))
        });
        for (scalar, is_missed) in of_case.map(|scalar| (scalar, false)).into_iter().chain(of_probes) {
            let variable = self.description.variable(&scalar.name).filter(|variable| is_number(variable));
            if variable.is_none() && is_missed {
                self.notes.push(format!("the case's probe `{}` is none of its variables", scalar.name));
            }
            records.extend(variable.cloned().map(|variable| self.record(scalar, variable)));
        }
        let key = self.key("record");
        for name in self.unit.record {
            let Some(variable) = self.variable(&key, name) else { continue };
            if !is_number(&variable) {
                self.mismatches.push(format!("{key}: `{name}` is no number"));
            } else if records.iter().all(|record| record.scalar.name != *name) {
                let unit = variable.unit.clone().unwrap_or_else(|| "1".to_owned());
                let scalar = Scalar::new(name, &unit, ScalarKind::Balance);
                records.push(Record { scalar, variable, factor: 1.0 });
            }
        }
        records
    }

    /// A variable that is recorded in the scalar's unit; in its own where it cannot be, which is noted.
    fn record(&mut self, scalar: Scalar, variable: Variable) -> Record {
        match self.factor_to(&scalar.unit, &variable) {
            Ok(factor) => Record { scalar, variable, factor },
            Err(what) => {
                self.notes.push(format!("{what}: it is recorded as it is"));
                let unit = variable.unit.clone().unwrap_or_default();
                Record { scalar: Scalar { unit, ..scalar }, variable, factor: 1.0 }
            }
        }
    }

    fn window_limit(&mut self) -> Option<(Variable, f64)> {
        let variable =
            self.number("window_limit", self.unit.variables.window_limit.as_deref(), "largest_step")?;
        match self.factor_to("s", &variable) {
            Ok(factor) => Some((variable, factor)),
            Err(what) => {
                let key = self.key("variables.window_limit");
                self.mismatches.push(format!("{key}: {what}"));
                None
            }
        }
    }

    /// A number that the unit tells.
    fn number(&mut self, what: &str, said: Option<&str>, usual: &str) -> Option<Variable> {
        let key = self.key(&format!("variables.{what}"));
        let Some(name) = said else {
            return self.description.variable(usual).filter(|variable| is_number(variable)).cloned();
        };
        let variable = self.variable(&key, name)?;
        if !is_number(&variable) {
            self.mismatches.push(format!("{key}: `{name}` is no number"));
            return None;
        }
        Some(variable)
    }

    fn parameters(&mut self) -> Vec<(Variable, ParameterValue)> {
        let mut parameters = Vec::new();
        for (name, value) in self.unit.parameters {
            let key = self.key(&format!("parameters.{name}"));
            let Some(variable) = self.variable(&key, name) else { continue };
            let settable = [Causality::Parameter, Causality::StructuralParameter, Causality::Input];
            if !settable.contains(&variable.causality) {
                self.mismatches.push(format!("{key}: it is no parameter"));
                continue;
            }
            if let Err(what) = fits(variable.kind, value) {
                self.mismatches.push(format!("{key}: {what}"));
                continue;
            }
            parameters.push((variable, value.clone()));
        }
        parameters
    }
}

fn is_number(variable: &Variable) -> bool {
    variable.dimensions.is_empty() && !matches!(variable.kind, Type::String | Type::Other)
}

/// Whether a value can be a variable's of that type.
fn fits(kind: Type, value: &ParameterValue) -> Result<(), String> {
    let whole = |number: f64, least: f64, most: f64| {
        if number.fract() == 0.0 && (least..=most).contains(&number) {
            Ok(())
        } else {
            Err(format!("{number} is no whole number of type {kind:?}"))
        }
    };
    let number = |number: f64| match kind {
        Type::Float64 | Type::Float32 => Ok(()),
        Type::Int32 => whole(number, f64::from(i32::MIN), f64::from(i32::MAX)),
        Type::UInt32 => whole(number, 0.0, f64::from(u32::MAX)),
        // Whole numbers up to here are exact.
        Type::Int64 => whole(number, -9e15, 9e15),
        Type::UInt64 => whole(number, 0.0, 9e15),
        _ => Err(format!("it is of type {kind:?}, not a number")),
    };
    match (kind, value) {
        (Type::Other, _) => Err("it is of a type that a case cannot set".to_owned()),
        (Type::Boolean, ParameterValue::Boolean(_)) | (Type::String, ParameterValue::Text(_)) => Ok(()),
        (_, ParameterValue::Number(value)) => number(*value),
        (_, ParameterValue::Numbers(values)) => values.iter().try_for_each(|value| number(*value)),
        (_, ParameterValue::Boolean(_) | ParameterValue::Text(_)) => Err(format!("it is of type {kind:?}")),
    }
}
