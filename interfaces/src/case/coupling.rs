//! `[coupling]`: as written, where every key may be left out, and as resolved.

use super::resolved::General;
use crate::SubSteps;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Sub-steps of a window where the case does not say: the paper's choice.
const SUB_STEPS: u32 = 100;
/// Longest wait for a participant where the case does not say (s).
const DEADLINE: f64 = 60.0;
/// Relaxation of an implicit scheme where the case does not say: iterations against a moving wall contract by
/// `1 − r (1 + μ)`, up to an added-mass ratio `μ` of 19.
const IMPLICIT_RELAXATION: f64 = 0.1;

/// The coupling of fluid and structure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CouplingKeys {
    /// Order of the solutions of a window; serial-explicit if left out.
    pub scheme: Option<CouplingScheme>,
    /// Largest window (s); the output interval if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub max_window: Option<f64>,
    /// Sub-steps of the structure in a window; 100 if left out.
    pub sub_steps: Option<SubStepsKey>,
    /// Form of the load; transpose if left out.
    pub load: Option<LoadForm>,
    /// Whether a serial explicit window begins with a prediction of the structure; yes if left out.
    pub prediction: Option<bool>,
    /// Load that the structure's sub-steps see within a window; held if left out.
    pub load_in_window: Option<LoadInWindow>,
    /// Relaxation, over 0 and at most 1: of the load, 1 with the mean velocity and 0.5 with that at the end
    /// if left out; of an implicit scheme's first iterations, 0.1.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
    pub relaxation: Option<f64>,
    /// Velocity of the structure over a window that the fluid meets; mean if left out, end where the load is
    /// linear.
    pub structure_velocity: Option<StructureVelocity>,
    /// Whether the pressure equation carries the structure's compliance; yes if left out.
    pub compliance: Option<bool>,
    /// Whether condition (46), continuity of the normal stress, is enforced; yes if left out.
    pub enforce_condition_46: Option<bool>,
    /// Longest wait for an answer of a participant (s); 60 if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub deadline: Option<f64>,
    /// Whether the processes of a serial scheme may be put on one core where windows are so short that waking
    /// takes most of their time; yes if left out.
    pub share_core: Option<bool>,
    /// From iterate to iterate of an implicit scheme.
    pub acceleration: Option<AccelerationKeys>,
    /// When the iterations of an implicit scheme end.
    pub convergence: Option<ConvergenceKeys>,
    /// Order of the extrapolation from the last windows to the first iterate of an implicit scheme; 1 if left
    /// out.
    #[schemars(extend("enum" = [0, 1, 2]))]
    pub extrapolation: Option<u32>,
    /// For a structure whose points are not those of the fluid; none if left out.
    pub mapping: Option<MappingKeys>,
    /// For a fluid whose points are not the structure's particles; none if left out.
    pub fluid_mapping: Option<FluidMappingKeys>,
    /// Steady state at which the run ends; none if left out.
    pub steady_state: Option<SteadyStateKeys>,
}

/// Between a structure's own points and points that fill its bodies: motion goes to the fluid by the weights,
/// forces come back by their transpose.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MappingKeys {
    /// Method; nearest-projection if left out.
    pub method: Option<MappingMethod>,
    /// Spacing of the points that fill the bodies (m); that of the structure if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub spacing: Option<f64>,
    /// Farthest that a point may be from the structure's points (m); two spacings if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub reach: Option<f64>,
    /// Whether the weights are made anew every window, from where the points have gone; no if left out.
    pub rebuild: Option<bool>,
}

/// Between the structure's particles and a fluid's own points: motion goes to these by the weights, forces
/// come back by their transpose.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FluidMappingKeys {
    /// Method; radial-basis if left out.
    pub method: Option<FluidMappingMethod>,
    /// Farthest that a point may be from the structure's particles (m); two of their spacings if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub reach: Option<f64>,
    /// Whether the weights are made anew every window, from where the points have gone; no if left out.
    pub rebuild: Option<bool>,
}

/// When nothing changes any more. Changes are measured against the greatest departure from the start so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SteadyStateKeys {
    /// What has to be steady; position and load if left out.
    pub quantities: Option<Vec<SteadyQuantity>>,
    /// Largest relative change per time (1/s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate: f64,
    /// For how long it has to stay below (s).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub duration: f64,
}

/// How an implicit scheme goes from iterate to iterate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AccelerationKeys {
    /// Method; iqn-ils if left out.
    pub method: Option<AccelerationMethod>,
    /// Earlier windows from which the quasi-Newton methods learn; 8 if left out.
    pub reused_windows: Option<u32>,
    /// Least share of a difference that must be new to the quasi-Newton methods; 1e-3 if left out.
    #[schemars(extend("minimum" = 1e-6, "exclusiveMaximum" = 1))]
    pub filter: Option<f64>,
    /// Most differences that the quasi-Newton methods keep; 100 if left out.
    #[schemars(extend("minimum" = 1))]
    pub max_columns: Option<u32>,
}

/// When the iterations of an implicit scheme end. Norms of the residual of the load and, where it is an
/// unknown, of the velocity.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ConvergenceKeys {
    /// Limit on the residual of the load (Pa/m); none if left out.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub absolute: Option<f64>,
    /// Limit on the residual over the values; 1e-3 if no limit is given.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub relative: Option<f64>,
    /// Limit on the residual over that of the window's first iteration; none if left out.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub residual_relative: Option<f64>,
    /// Whether any of the limits is enough, or all must be kept; any if left out.
    pub combine: Option<Combine>,
    /// Most iterations of a window; 30 if left out.
    #[schemars(extend("minimum" = 1))]
    pub max_iterations: Option<u32>,
    /// What becomes of a window that does not converge; continue if left out.
    pub at_limit: Option<AtLimit>,
}

/// A number of sub-steps, or `"stable"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum SubStepsKey {
    /// Number of sub-steps in a window.
    Count(#[schemars(extend("minimum" = 1))] u32),
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

/// `[coupling]`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coupling {
    /// Order of the solutions of a window.
    pub scheme: CouplingScheme,
    /// Largest window (s).
    pub max_window: f64,
    /// Sub-steps of the structure in a window.
    #[serde(with = "sub_steps")]
    pub sub_steps: SubSteps,
    /// Form of the load.
    pub load: LoadForm,
    /// Whether a serial explicit window begins with a prediction of the structure; only with that scheme.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prediction: Option<bool>,
    /// Load that the structure's sub-steps see within a window.
    pub load_in_window: LoadInWindow,
    /// Relaxation r in `r·new + (1 − r)·old`, over 0 and at most 1: of the load with an explicit scheme, of
    /// iterations that have no better with an implicit one.
    pub relaxation: f64,
    /// Which velocity of the structure over a window the fluid meets.
    pub structure_velocity: StructureVelocity,
    /// Whether the pressure equation carries the structure's compliance (its 1/ρ).
    pub compliance: bool,
    /// Whether condition (46), continuity of the normal stress, is enforced; it is measured and recorded in
    /// any case.
    pub enforce_condition_46: bool,
    /// Longest wait for an answer of a participant (s).
    pub deadline: f64,
    /// Whether the processes may be put on one core where windows are short; never in parallel order.
    pub share_core: bool,
    /// Order of the extrapolation to the first iterate; only with an implicit scheme.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extrapolation: Option<u32>,
    /// From iterate to iterate; only with an implicit scheme.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration: Option<Acceleration>,
    /// When iterations end; only with an implicit scheme.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub convergence: Option<Convergence>,
    /// For a structure whose points are not those of the fluid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mapping: Option<Mapping>,
    /// For a fluid whose points are not the structure's particles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluid_mapping: Option<FluidMapping>,
    /// Steady state at which the run ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steady_state: Option<SteadyState>,
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

/// Between a structure's own points and points that fill its bodies.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mapping {
    /// Method.
    pub method: MappingMethod,
    /// Spacing of the points that fill the bodies (m).
    pub spacing: f64,
    /// Farthest that a point may be from the structure's points (m).
    pub reach: f64,
    /// Whether the weights are made anew every window.
    pub rebuild: bool,
}

/// Between the structure's particles and a fluid's own points.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FluidMapping {
    /// Method.
    pub method: FluidMappingMethod,
    /// Farthest that a point may be from the structure's particles (m).
    pub reach: f64,
    /// Whether the weights are made anew every window.
    pub rebuild: bool,
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

/// A steady state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SteadyState {
    /// What has to be steady.
    pub quantities: Vec<SteadyQuantity>,
    /// Largest relative change per time (1/s).
    pub rate: f64,
    /// For how long it has to stay below (s).
    pub duration: f64,
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

/// The iterations of an implicit scheme.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Acceleration {
    /// Method.
    pub method: AccelerationMethod,
    /// Earlier windows from which the quasi-Newton methods learn.
    pub reused_windows: u32,
    /// Least share of a difference that must be new to the quasi-Newton methods.
    pub filter: f64,
    /// Most differences that the quasi-Newton methods keep.
    pub max_columns: u32,
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

/// When the iterations of an implicit scheme end.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Convergence {
    /// Limit on the residual of the load (Pa/m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absolute: Option<f64>,
    /// Limit on the residual over the values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative: Option<f64>,
    /// Limit on the residual over that of the window's first iteration.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual_relative: Option<f64>,
    /// Whether any of the limits is enough, or all must be kept.
    pub combine: Combine,
    /// Most iterations of a window.
    pub max_iterations: u32,
    /// What becomes of a window that does not converge.
    pub at_limit: AtLimit,
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

/// Velocity of the structure over a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StructureVelocity {
    /// The displacement over the window's size. It answers a load of the window always in the load's
    /// direction, however stiff the structure.
    Mean,
    /// That at the window's end.
    End,
}

impl StructureVelocity {
    /// Relaxation of the load where none is written: none for the mean velocity, which is stable without.
    pub fn relaxation(self) -> f64 {
        match self {
            Self::Mean => 1.0,
            Self::End => 0.5,
        }
    }
}

/// Form of the load on the structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LoadForm {
    /// Transpose of the divergence through which the structure's velocity enters the pressure equation.
    Transpose,
    /// Pressure gradient at the structure's particles, Eq. (48).
    PressureGradient,
}

impl CouplingKeys {
    /// Fills in what was left out.
    pub(super) fn resolve(&self, general: &General, structure_spacing: f64) -> Coupling {
        let load_in_window = self.load_in_window.unwrap_or(LoadInWindow::Held);
        let structure_velocity = self.structure_velocity.unwrap_or(load_in_window.structure_velocity());
        let scheme = self.scheme.unwrap_or(CouplingScheme::SerialExplicit);
        let implicit = scheme.is_implicit();
        let relaxation = if implicit { IMPLICIT_RELAXATION } else { structure_velocity.relaxation() };
        Coupling {
            scheme,
            max_window: self.max_window.unwrap_or(general.output_interval),
            sub_steps: match self.sub_steps {
                Some(SubStepsKey::Count(count)) => SubSteps::Fixed(count),
                Some(SubStepsKey::Word(SubStepsWord::Stable)) => SubSteps::Stable,
                None => SubSteps::Fixed(SUB_STEPS),
            },
            load: self.load.unwrap_or(LoadForm::Transpose),
            prediction: (scheme == CouplingScheme::SerialExplicit).then(|| self.prediction.unwrap_or(true)),
            load_in_window,
            relaxation: self.relaxation.unwrap_or(relaxation),
            structure_velocity,
            compliance: self.compliance.unwrap_or(true),
            enforce_condition_46: self.enforce_condition_46.unwrap_or(true),
            deadline: self.deadline.unwrap_or(DEADLINE),
            share_core: self.share_core.unwrap_or(!scheme.is_parallel()),
            extrapolation: implicit.then(|| self.extrapolation.unwrap_or(1)),
            acceleration: implicit.then(|| self.acceleration.clone().unwrap_or_default().resolve()),
            convergence: implicit.then(|| self.convergence.clone().unwrap_or_default().resolve()),
            mapping: self.mapping.as_ref().map(|keys| keys.resolve(structure_spacing)),
            fluid_mapping: self.fluid_mapping.as_ref().map(|keys| FluidMapping {
                method: keys.method.unwrap_or(FluidMappingMethod::RadialBasis),
                reach: keys.reach.unwrap_or(2.0 * structure_spacing),
                rebuild: keys.rebuild.unwrap_or(false),
            }),
            steady_state: self.steady_state.as_ref().map(SteadyStateKeys::resolve),
        }
    }
}

impl MappingKeys {
    fn resolve(&self, structure_spacing: f64) -> Mapping {
        let spacing = self.spacing.unwrap_or(structure_spacing);
        Mapping {
            method: self.method.unwrap_or(MappingMethod::NearestProjection),
            spacing,
            reach: self.reach.unwrap_or(2.0 * spacing),
            rebuild: self.rebuild.unwrap_or(false),
        }
    }
}

impl SteadyStateKeys {
    fn resolve(&self) -> SteadyState {
        let quantities = || vec![SteadyQuantity::Position, SteadyQuantity::Load];
        SteadyState {
            quantities: self.quantities.clone().unwrap_or_else(quantities),
            rate: self.rate,
            duration: self.duration,
        }
    }
}

impl AccelerationKeys {
    fn resolve(&self) -> Acceleration {
        Acceleration {
            method: self.method.unwrap_or(AccelerationMethod::IqnIls),
            reused_windows: self.reused_windows.unwrap_or(8),
            filter: self.filter.unwrap_or(1e-3),
            max_columns: self.max_columns.unwrap_or(100),
        }
    }
}

impl ConvergenceKeys {
    fn resolve(&self) -> Convergence {
        let Self { absolute, relative, residual_relative, .. } = *self;
        let none = absolute.is_none() && residual_relative.is_none();
        Convergence {
            absolute,
            relative: relative.or(none.then_some(1e-3)),
            residual_relative,
            combine: self.combine.unwrap_or(Combine::Any),
            max_iterations: self.max_iterations.unwrap_or(30),
            at_limit: self.at_limit.unwrap_or(AtLimit::Continue),
        }
    }
}

/// Sub-steps as the case file writes them: a number, or `"stable"`.
mod sub_steps {
    use crate::SubSteps;
    use serde::Serializer;

    pub fn serialize<S: Serializer>(sub_steps: &SubSteps, serializer: S) -> Result<S::Ok, S::Error> {
        match sub_steps {
            SubSteps::Fixed(count) => serializer.serialize_u32(*count),
            SubSteps::Stable => serializer.serialize_str("stable"),
        }
    }
}
