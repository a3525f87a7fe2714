//! Does a participant keep the contract? One suite for all: mocks, solvers, processes behind shared memory,
//! FMUs, a user's own.
//!
//! Every check starts from fresh participants, behind [`interfaces::Guarded`] as in a coupling. A check that
//! fails says what was promised and what came; [`check`] gathers them all.

mod life;
mod order;
mod solution;

use interfaces::{Description, Direction, Fields, Participant, Quantity, Role, SubSteps, port::names};
use std::collections::BTreeSet;
use thiserror::Error;

/// What the suite needs to know about the participant.
pub struct Options<'a> {
    /// Interface points where the participant takes as many as its partner has.
    pub points: usize,
    /// Time at the start (s).
    pub start: f64,
    /// Largest window to solve (s); the suite also takes smaller ones.
    pub size: f64,
    /// Sub-steps to ask for.
    pub sub_steps: SubSteps,
    /// Whether it can save and restore. Where it cannot, these calls must fail and are not made otherwise.
    pub can_save: bool,
    /// Fills the inputs for a time (s). Different variants must differ, where the participant takes anything
    /// every window.
    pub inputs: &'a dyn Fn(f64, u32, &mut Fields),
}

impl Default for Options<'_> {
    /// Five points, windows of 1 ms from 0.25 s with 3 sub-steps, and [`plausible`] inputs.
    fn default() -> Self {
        Self {
            points: 5,
            start: 0.25,
            size: 1e-3,
            sub_steps: SubSteps::Fixed(3),
            can_save: true,
            inputs: &plausible,
        }
    }
}

/// The promises that a participant broke.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("the participant broke {} promise(s):\n  {}", .0.len(), .0.join("\n  "))]
pub struct Nonconformity(
    /// One message each.
    pub Vec<String>,
);

/// The outcome of one check.
type Check = Result<(), String>;

struct Suite<'a> {
    make: &'a dyn Fn() -> Box<dyn Participant>,
    options: &'a Options<'a>,
}

/// Holds the participants that `make` gives to the contract. They must all be of the same case.
///
/// # Errors
/// All promises broken, one message each.
pub fn check(make: impl Fn() -> Box<dyn Participant>, options: &Options) -> Result<(), Nonconformity> {
    let suite = Suite { make: &make, options };
    let mut broken = Vec::new();
    broken.extend(description(suite.make().describe()));
    if !broken.is_empty() {
        return Err(Nonconformity(broken));
    }
    type Named = (&'static str, fn(&Suite) -> Check);
    let checks: [Named; 8] = [
        ("one description for a life", solution::one_description),
        ("initialisation", solution::initialization),
        ("windows one after the other", solution::windows),
        ("solving again", solution::solving_again),
        ("saving and restoring", solution::saving),
        ("order of calls", order::table),
        ("wrong windows", order::wrong_windows),
        ("inputs that are not finite", order::not_finite),
    ];
    for (name, check) in checks {
        if let Err(what) = check(&suite) {
            broken.push(format!("{name}: {what}"));
        }
    }
    if broken.is_empty() { Ok(()) } else { Err(Nonconformity(broken)) }
}

impl Suite<'_> {
    fn make(&self) -> Box<dyn Participant> {
        (self.make)()
    }
}

/// Deterministic inputs that no mock minds: points 1 cm apart along a diagonal, motions of millimetres, loads
/// of kilopascals a metre. A solver needs positions that fit its own geometry.
pub fn plausible(time: f64, variant: u32, inputs: &mut Fields) {
    let shift = f64::from(variant) + 10.0 * time;
    for (port, array) in inputs.iter_mut() {
        let components = port.components;
        for (at, value) in array.iter_mut().enumerate() {
            let point = (at / components) as f64;
            let wave = (1.0 + shift + at as f64).sin();
            *value = match port.quantity {
                Quantity::Position => 0.01 * point + 1e-3 * wave,
                Quantity::Velocity => 0.1 * wave,
                Quantity::Displacement => 1e-3 * wave,
                Quantity::PressureGradient | Quantity::PairReaction => 1e3 * (1.0 + wave),
                Quantity::Pressure => 100.0 * (1.0 + wave),
                Quantity::Normal => f64::from(u8::from(at % components == components - 1)),
                // Constants of the partner: the same for all variants and times.
                Quantity::ReferenceVolume => 1e-4,
                Quantity::Density => 1000.0 + point,
                Quantity::Force => 10.0 * (1.0 + wave),
                Quantity::Facet => point,
            };
        }
    }
}

/// What a description must be.
fn description(d: &Description) -> Vec<String> {
    let mut broken = Vec::new();
    let mut must = |holds: bool, what: String| {
        if !holds {
            broken.push(format!("description: {what}"));
        }
    };
    must(matches!(d.dimension, 2 | 3), format!("dimension {} is neither 2 nor 3", d.dimension));
    must(!d.solver.trim().is_empty(), "the solver has no name".to_owned());
    for direction in [Direction::In, Direction::Out] {
        let mut seen = BTreeSet::new();
        for port in d.ports.iter().filter(|p| p.direction == direction) {
            let (name, quantity) = (&port.name, port.quantity);
            must(!name.is_empty(), "a port has no name".to_owned());
            must(seen.insert(name), format!("two ports {direction:?} are called `{name}`"));
            must(
                port.unit == quantity.unit(),
                format!("port `{name}` is in {}, but {quantity} is in {}", port.unit, quantity.unit()),
            );
            let components = quantity.components(d.dimension);
            must(
                port.components == components,
                format!("port `{name}` has {} components, {quantity} has {components}", port.components),
            );
        }
    }
    let needed: &[(&str, Quantity)] = match d.role {
        Role::Structure => &[(names::POSITION, Quantity::Position), (names::VELOCITY, Quantity::Velocity)],
        Role::Fluid if d.ports.iter().any(|port| port.name == names::OWN_POSITION) => {
            &[(names::OWN_POSITION, Quantity::Position), (names::FORCE, Quantity::Force)]
        }
        Role::Fluid => &[(names::PRESSURE_GRADIENT, Quantity::PressureGradient)],
    };
    for (name, quantity) in needed {
        let given = d
            .ports
            .iter()
            .any(|p| p.direction == Direction::Out && p.name == *name && p.quantity == *quantity);
        must(given, format!("a {} gives `{name}`, and this one does not", d.role));
    }
    let mut seen = BTreeSet::new();
    for scalar in &d.scalars {
        must(!scalar.name.is_empty(), "a scalar has no name".to_owned());
        must(!scalar.unit.is_empty(), format!("scalar `{}` has no unit; `1` for none", scalar.name));
        must(seen.insert(&scalar.name), format!("two scalars are called `{}`", scalar.name));
    }
    broken
}
