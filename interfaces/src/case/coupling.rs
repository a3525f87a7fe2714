//! `[coupling]`: its keys, and what they are where the case leaves them out.

use super::section::{laid_over, schema_of, to_table, with_defaults};
use crate::window::SubSteps;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value as Json;
use toml::Table;
pub use words::coupling::{LoadForm, StructureVelocity};

/// The coupling of fluid and structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// Order of the solutions of a window.
    pub scheme: CouplingScheme,
    /// Largest time window (s); `case.output_interval` if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub max_window: f64,
    /// Sub-steps of the structure in a window, or `"stable"`: as many as its stability asks, which is found
    /// anew as it is strained.
    #[serde(with = "sub_steps")]
    #[schemars(with = "SubStepsKey")]
    pub sub_steps: SubSteps,
    /// Form of the load.
    pub load: LoadForm,
    /// Whether a serial explicit window begins with a prediction of the structure. Without one each side
    /// solves once, under the last window's load: a third less to do, for light fluids only. Yes if left out,
    /// only with that scheme.
    pub prediction: Option<bool>,
    /// Load that the structure's sub-steps see within a window; with an implicit scheme its end is the
    /// iterate (waveform). For structures that take `start_pressure_gradient` or `start_force`; ours does.
    pub load_in_window: LoadInWindow,
    /// Relaxation, over 0 and at most 1: of the load, 1 with the mean velocity and 0.5 with that at the end
    /// if left out; of an implicit scheme's first iterations, 0.1.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
    pub relaxation: f64,
    /// Velocity of the structure over a window that the fluid meets (`docs/decisions/0003-mean-velocity.md`,
    /// `0009-load-in-window.md`); mean if left out, end where the load is linear.
    pub structure_velocity: StructureVelocity,
    /// Whether the pressure equation carries the structure's compliance (its 1/ρ).
    pub compliance: bool,
    /// Whether condition (46), continuity of the normal stress, is enforced; it is measured and recorded in
    /// any case.
    pub enforce_condition_46: bool,
    /// Longest wait for an answer of a participant (s).
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1e6))]
    pub deadline: f64,
    /// Whether the coupler may put the processes of a serial scheme on one core where windows take less than
    /// two milliseconds, much of which is waking: it tries, and keeps what is faster (`docs/exchange.md`). No
    /// in parallel order. Say `false` where you place processes yourself.
    pub share_core: bool,
    /// Order of the extrapolation from the last windows to the first iterate of an implicit scheme; 1 if left
    /// out.
    #[schemars(extend("enum" = [0, 1, 2]))]
    pub extrapolation: Option<u32>,
    /// From iterate to iterate of an implicit scheme.
    pub acceleration: Option<Acceleration>,
    /// When the iterations of an implicit scheme end.
    pub convergence: Option<Convergence>,
    /// For a structure whose points are not those of the fluid; if left out, a unit that takes forces at
    /// points of its own has one by radial basis functions.
    pub mapping: Option<Mapping>,
    /// For a fluid whose points are not the structure's particles; none if left out.
    pub fluid_mapping: Option<FluidMapping>,
    /// Steady state at which the run ends; none if left out.
    pub steady_state: Option<SteadyState>,
}

/// Between a structure's own points and points that fill its bodies: motion goes to the fluid by the weights,
/// forces come back by their transpose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mapping {
    /// Method.
    pub method: MappingMethod,
    /// Spacing of the points that fill the bodies (m); that of the structure if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub spacing: f64,
    /// Farthest that a point may be from the structure's points, by nearest projection outside its boundary
    /// (m); two spacings if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub reach: f64,
    /// Whether the weights are made anew after every window, from where the points have gone; a structure
    /// whose points stay with its material needs none of it.
    pub rebuild: bool,
}

/// Between the structure's particles and a fluid's own points: motion goes to these by the weights, forces
/// come back by their transpose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FluidMapping {
    /// Method.
    pub method: FluidMappingMethod,
    /// Farthest that a point may be from the structure's particles (m); two of their spacings if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub reach: f64,
    /// Whether the weights are made anew for every window, from where the points are at its start; points
    /// that stay with the structure's surface need none of it.
    pub rebuild: bool,
}

/// When nothing changes any more. Changes are measured against the greatest departure from the start so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SteadyState {
    /// What has to be steady, all of it.
    #[serde(default = "steady_quantities")]
    pub quantities: Vec<SteadyQuantity>,
    /// Largest relative change per time (1/s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate: f64,
    /// For how long it has to stay below (s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub duration: f64,
}

fn steady_quantities() -> Vec<SteadyQuantity> {
    vec![SteadyQuantity::Position, SteadyQuantity::Load]
}

/// How an implicit scheme goes from iterate to iterate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Acceleration {
    /// Method.
    pub method: AccelerationMethod,
    /// Earlier windows from which the quasi-Newton methods learn.
    pub reused_windows: u32,
    /// Least share of a difference that must be new to the quasi-Newton methods.
    #[schemars(extend("minimum" = 1e-6, "exclusiveMaximum" = 1))]
    pub filter: f64,
    /// Most differences that the quasi-Newton methods keep.
    #[schemars(extend("minimum" = 1))]
    pub max_columns: u32,
}

impl Default for Acceleration {
    fn default() -> Self {
        Self { method: AccelerationMethod::IqnIls, reused_windows: 8, filter: 1e-3, max_columns: 100 }
    }
}

/// When the iterations of an implicit scheme end. Norms of the residual of the load and, where it is an
/// unknown, of the velocity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Convergence {
    /// Limit on the residual of the load (Pa/m); none if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub absolute: Option<f64>,
    /// Limit on the residual over the values; 1e-3 if no limit is given.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub relative: Option<f64>,
    /// Limit on the residual over that of the window's first iteration; none if left out.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub residual_relative: Option<f64>,
    /// How several limits go together.
    pub combine: Combine,
    /// Most iterations of a window.
    #[schemars(extend("minimum" = 1))]
    pub max_iterations: u32,
    /// What becomes of a window that does not converge.
    pub at_limit: AtLimit,
}

impl Default for Convergence {
    fn default() -> Self {
        Self {
            absolute: None,
            relative: None,
            residual_relative: None,
            combine: Combine::Any,
            max_iterations: 30,
            at_limit: AtLimit::Continue,
        }
    }
}

/// The section with what it leaves out filled in; it was held against [`schema`].
pub(super) fn resolve(written: &Table, output_interval: f64, structure_spacing: f64) -> Coupling {
    fn at<'de, T: Deserialize<'de>>(table: &Table, key: &str) -> Option<T> {
        table.get(key).and_then(|value| T::deserialize(value.clone()).ok())
    }
    let load_in_window = at(written, "load_in_window").unwrap_or(LoadInWindow::Held);
    let structure_velocity = at(written, "structure_velocity");
    let scheme = at(written, "scheme").unwrap_or(CouplingScheme::SerialExplicit);
    let mapping = written
        .get("mapping")
        .and_then(toml::Value::as_table)
        .map(|mapping| Mapping::within(at(mapping, "spacing").unwrap_or(structure_spacing)));
    let fluid_mapping =
        written.contains_key("fluid_mapping").then(|| FluidMapping::within(structure_spacing));
    let mut defaults = defaults(scheme, load_in_window, structure_velocity);
    (defaults.max_window, defaults.mapping, defaults.fluid_mapping) =
        (output_interval, mapping, fluid_mapping);
    let mut coupling: Coupling = laid_over(&to_table(&defaults), written)
        .expect("a checked case has only keys and values of the schema");
    if let Some(Convergence { absolute: None, relative: relative @ None, residual_relative: None, .. }) =
        &mut coupling.convergence
    {
        *relative = Some(1e-3);
    }
    coupling
}

/// What the keys are that need no more of the case; the others are NaN or none.
fn defaults(
    scheme: CouplingScheme,
    load_in_window: LoadInWindow,
    structure_velocity: Option<StructureVelocity>,
) -> Coupling {
    let structure_velocity = structure_velocity.unwrap_or(load_in_window.structure_velocity());
    let implicit = scheme.is_implicit();
    Coupling {
        scheme,
        max_window: f64::NAN,
        // The paper's choice.
        sub_steps: SubSteps::Fixed(100),
        load: LoadForm::Transpose,
        prediction: (scheme == CouplingScheme::SerialExplicit).then_some(true),
        load_in_window,
        relaxation: match structure_velocity {
            // Iterations against a moving wall contract by `1 − r (1 + μ)`, up to an added-mass ratio `μ` of
            // 19.
            _ if implicit => 0.1,
            // Stable without relaxation.
            StructureVelocity::Mean => 1.0,
            StructureVelocity::End => 0.5,
        },
        structure_velocity,
        compliance: true,
        enforce_condition_46: true,
        deadline: 60.0,
        share_core: !scheme.is_parallel(),
        extrapolation: implicit.then_some(1),
        acceleration: implicit.then(Acceleration::default),
        convergence: implicit.then(Convergence::default),
        mapping: None,
        fluid_mapping: None,
        steady_state: None,
    }
}

impl Mapping {
    fn within(spacing: f64) -> Self {
        Self { method: MappingMethod::NearestProjection, spacing, reach: 2.0 * spacing, rebuild: false }
    }
}

impl FluidMapping {
    fn within(spacing: f64) -> Self {
        Self { method: FluidMappingMethod::RadialBasis, reach: 2.0 * spacing, rebuild: false }
    }
}

/// The JSON schema of the section.
pub(super) fn schema() -> Json {
    let mut plain = to_table(&defaults(CouplingScheme::SerialExplicit, LoadInWindow::Held, None));
    // Their documentation says what they are; it takes more than one value.
    for key in ["relaxation", "structure_velocity"] {
        plain.insert(key.to_owned(), f64::NAN.into());
    }
    let mut schema = schema_of::<Coupling>(&plain);
    with_defaults(&mut schema["$defs"]["Mapping"], &to_table(&Mapping::within(f64::NAN)));
    with_defaults(&mut schema["$defs"]["FluidMapping"], &to_table(&FluidMapping::within(f64::NAN)));
    schema
}

/// A number of sub-steps, or `"stable"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum SubStepsKey {
    /// Number of sub-steps in a window.
    Count(#[schemars(extend("minimum" = 1, "maximum" = 1_000_000))] u32),
    /// A word.
    Word(SubStepsWord),
}

/// Sub-steps in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SubStepsWord {
    /// As many as the structure's stability asks.
    Stable,
}

/// Load that the structure's sub-steps see within a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LoadInWindow {
    /// The window's load all the time.
    Held,
    /// From the last accepted window's load at the start to the window's at the end, linearly.
    Linear,
}

impl LoadInWindow {
    /// The velocity that goes with it: the one that a load of that course never changes against its own
    /// direction, however stiff the structure.
    pub fn structure_velocity(self) -> StructureVelocity {
        match self {
            Self::Held => StructureVelocity::Mean,
            Self::Linear => StructureVelocity::End,
        }
    }
}

/// How a fluid's points follow the structure's particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FluidMappingMethod {
    /// As the nearest particle.
    NearestNeighbour,
    /// As the nearest particle, continued with the gradient that its neighbours give.
    NearestNeighbourGradient,
    /// By radial basis functions with local support.
    RadialBasis,
}

/// How points follow others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MappingMethod {
    /// As the nearest point.
    NearestNeighbour,
    /// As the nearest point, continued with the gradient that its neighbours give.
    NearestNeighbourGradient,
    /// As points on the boundary between which they lie; the structure has to give its facets.
    NearestProjection,
    /// By radial basis functions with local support.
    RadialBasis,
}

/// What can be steady at the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SteadyQuantity {
    /// Position of its points.
    Position,
    /// Their velocity.
    Velocity,
    /// Load on them.
    Load,
}

/// Order of the solutions of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CouplingScheme {
    /// One participant after the other, each once a window.
    SerialExplicit,
    /// Both at once, each once a window.
    ParallelExplicit,
    /// One after the other, until the window converges.
    SerialImplicit,
    /// Both at once, until the window converges.
    ParallelImplicit,
}

impl CouplingScheme {
    /// Whether a window is solved again until it converges.
    pub fn is_implicit(self) -> bool {
        matches!(self, Self::SerialImplicit | Self::ParallelImplicit)
    }

    /// Whether both participants solve at the same time.
    pub fn is_parallel(self) -> bool {
        matches!(self, Self::ParallelExplicit | Self::ParallelImplicit)
    }
}

/// From iterate to iterate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AccelerationMethod {
    /// Relaxation by the same factor.
    Constant,
    /// Aitken's dynamic relaxation.
    Aitken,
    /// Interface quasi-Newton, inverse least squares.
    IqnIls,
    /// Interface quasi-Newton, inverse multi-vector Jacobian.
    IqnImvj,
}

/// How several limits go together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Combine {
    /// One of them is enough.
    Any,
    /// All must be kept.
    All,
}

/// What becomes of a window that does not converge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AtLimit {
    /// It is accepted as it is, and counted.
    Continue,
    /// It is solved again at half its size, down to a thousandth; then the run ends.
    Shrink,
    /// The run ends.
    Stop,
}

/// Sub-steps as the case file writes them: a number, or `"stable"`.
mod sub_steps {
    use super::{SubStepsKey, SubStepsWord};
    use crate::window::SubSteps;
    use serde::{Deserialize as _, Deserializer, Serialize as _, Serializer};

    pub fn serialize<S: Serializer>(sub_steps: &SubSteps, serializer: S) -> Result<S::Ok, S::Error> {
        let stable = SubStepsKey::Word(SubStepsWord::Stable);
        sub_steps.count().map_or(stable, SubStepsKey::Count).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<SubSteps, D::Error> {
        Ok(match SubStepsKey::deserialize(deserializer)? {
            SubStepsKey::Count(count) => SubSteps::Fixed(count),
            SubStepsKey::Word(SubStepsWord::Stable) => SubSteps::Stable,
        })
    }
}
