//! The structure of a case, stepped: values in and out by [`Source`].

use crate::reduction::Reduction;
use crate::resources::Resources;
use crate::variables::{Parameter, Source};
use interfaces::case::Case;
use interfaces::port::names;
use interfaces::{Description, Direction, Fields, ParticipantError, SubSteps, TimeWindow};
use std::collections::BTreeMap;
use std::path::Path;
use structure::participant::Stressed;

/// Why the model could not do what it was asked for.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// The case with the parameters set has mistakes.
    #[error("{0}")]
    Case(interfaces::case::CaseErrors),
    /// The structure refused or failed.
    #[error(transparent)]
    Structure(#[from] ParticipantError),
    /// Arrays declared for another number of particles.
    #[error(
        "interface_points is {declared}, but with this particle spacing there are {found} interface particles: set interface_points to {found} in configuration mode"
    )]
    Points {
        /// As set.
        declared: usize,
        /// What the case makes.
        found: usize,
    },
    /// A value that must not be set.
    #[error("{what} cannot be {value}")]
    Value {
        /// The variable.
        what: &'static str,
        /// The value.
        value: f64,
    },
    /// A load that is not finite.
    #[error("the load is not finite: value {index} is {value}")]
    Load {
        /// Place in the array.
        index: usize,
        /// The value.
        value: f64,
    },
    /// Bytes that are no saved state of this unit.
    #[error(transparent)]
    Bytes(#[from] words::bytes::Error),
    /// A saved state whose arrays are not those of this unit.
    #[error("the saved state is not one of this unit")]
    Saved,
}

/// A structure and what its importer set.
pub struct Model {
    resources: Resources,
    case: Case,
    parameters: BTreeMap<Parameter, f64>,
    sub_steps: SubSteps,
    structure: Box<dyn Stressed + Send>,
    /// Number of interface particles that arrays are declared for.
    declared_points: usize,
    reduction: Option<Reduction>,
    /// Forces (N) at the points of a reduced interface.
    forces: Vec<f64>,
    inputs: Fields,
    outputs: Fields,
    /// Those of the structure, then the sub-steps of the last step.
    scalars: Vec<f64>,
    time: f64,
    windows: u64,
    pool: Option<rayon::ThreadPool>,
}

/// Below so many particles a step is shared by no threads, and none are started.
const POOLED_PARTICLES: usize = 1024;

impl Model {
    /// Of the resources of a unit, with the parameters of its case, at rest at time 0.
    ///
    /// # Errors
    /// A case that does not hold.
    pub fn new(resources: Resources) -> Result<Self, ModelError> {
        let case = read(&resources, &BTreeMap::new())?;
        let sub_steps = case.coupling.as_ref().map_or(SubSteps::Stable, |coupling| coupling.sub_steps);
        let structure = structure::participant::without_snapshots(&case)?;
        let (inputs, outputs) = fields(structure.describe());
        let mut model = Self {
            declared_points: points(&outputs),
            resources,
            case,
            parameters: BTreeMap::new(),
            sub_steps,
            structure,
            reduction: None,
            forces: Vec::new(),
            inputs,
            outputs,
            scalars: Vec::new(),
            time: 0.0,
            windows: 0,
            pool: None,
        };
        model.prepare(0.0)?;
        model.forces = vec![0.0; model.reduction.as_ref().map_or(0, Reduction::len) * model.dimension()];
        Ok(model)
    }

    /// The structure as a participant describes itself.
    pub fn describe(&self) -> &Description {
        self.structure.describe()
    }

    /// The case, with the parameters that are set.
    pub fn case(&self) -> &Case {
        &self.case
    }

    /// Points of a reduced interface, as they lie in the reference configuration (m).
    pub fn reduced_points(&self) -> Option<&[Vec<f64>]> {
        self.resources.points.as_ref().map(|points| points.points.as_slice())
    }

    /// Space dimension.
    pub fn dimension(&self) -> usize {
        self.structure.describe().dimension
    }

    /// Goes to the start: parameters that were set take effect.
    ///
    /// # Errors
    /// Parameters that the case does not hold with; arrays declared for another number of particles.
    pub fn initialize(&mut self, start: f64) -> Result<(), ModelError> {
        if !self.parameters.is_empty() {
            self.case = read(&self.resources, &self.parameters)?;
            self.structure = structure::participant::without_snapshots(&self.case)?;
            let loads = std::mem::take(&mut self.inputs);
            (self.inputs, self.outputs) = fields(self.structure.describe());
            let found = points(&self.outputs);
            if found != self.declared_points && self.reduction.is_none() {
                return Err(ModelError::Points { declared: self.declared_points, found });
            }
            // A load that was set already, unless the particles are others now.
            let _ = self.inputs.copy_from(&loads, |_| true);
        }
        self.prepare(start)
    }

    fn prepare(&mut self, start: f64) -> Result<(), ModelError> {
        let readiness = self.structure.initialize(start, &self.inputs, &mut self.outputs)?;
        self.scalars = readiness.scalars;
        self.scalars.push(0.0);
        (self.time, self.windows) = (start, 0);
        if let Some(reduced) = &self.resources.points {
            let spacing = self.case.structure.as_ref().map_or(1.0, |s| s.particle_spacing);
            let positions = self.outputs.get(names::POSITION).unwrap_or_default();
            self.reduction = Some(Reduction::new(
                self.structure.describe().dimension,
                &reduced.points,
                positions,
                spacing,
            ));
        }
        if self.pool.is_none() && points(&self.outputs) >= POOLED_PARTICLES {
            self.pool = rayon::ThreadPoolBuilder::new().num_threads(self.case.general.threads).build().ok();
        }
        Ok(())
    }

    /// Solves from `start` over `size` (s) under the load that is set, and takes the result.
    ///
    /// # Errors
    /// Whatever the structure refuses: it then stands at `start`.
    pub fn step(&mut self, start: f64, size: f64) -> Result<(), ModelError> {
        if let Some(reduction) = &self.reduction {
            let volumes = self.outputs.get(names::REFERENCE_VOLUME).unwrap_or_default();
            if let Some(out) = self.inputs.get_mut(names::PRESSURE_GRADIENT) {
                reduction.spread(&self.forces, volumes, out);
            }
        }
        let window = TimeWindow { index: self.windows, iteration: 0, start, size, sub_steps: self.sub_steps };
        let Self { structure, inputs, outputs, pool, .. } = self;
        let mut solve = || {
            structure.start(&window, inputs)?;
            let report = structure.finish(outputs)?;
            structure.accept(None)?;
            Ok::<_, ParticipantError>(report)
        };
        let report = match pool {
            Some(pool) => pool.install(solve),
            None => solve(),
        }?;
        self.scalars = report.scalars;
        self.scalars.push(f64::from(report.sub_steps));
        self.windows += 1;
        self.time = window.end();
        Ok(())
    }

    /// How many numbers a source has.
    pub fn length(&self, source: Source) -> usize {
        match source {
            Source::PressureGradient | Source::Position | Source::Velocity => {
                self.declared_points * self.dimension()
            }
            Source::ReferenceVolume | Source::InterfaceDensity => self.declared_points,
            _ => 1,
        }
    }

    /// Reads a source into `out`, of its length.
    ///
    /// # Errors
    /// A stress of a state that is not finite; arrays that do not fit the structure yet.
    pub fn read(&mut self, source: Source, out: &mut [f64]) -> Result<(), ModelError> {
        let found = points(&self.outputs);
        let array = |fields: &Fields, name: &str, out: &mut [f64]| match fields.get(name) {
            Some(values) if values.len() == out.len() => {
                out.copy_from_slice(values);
                Ok(())
            }
            _ => Err(ModelError::Points { declared: self.declared_points, found }),
        };
        let d = self.dimension();
        out[0] = match source {
            Source::PressureGradient => return array(&self.inputs, names::PRESSURE_GRADIENT, out),
            Source::Position => return array(&self.outputs, names::POSITION, out),
            Source::Velocity => return array(&self.outputs, names::VELOCITY, out),
            Source::ReferenceVolume => return array(&self.outputs, names::REFERENCE_VOLUME, out),
            Source::InterfaceDensity => return array(&self.outputs, names::DENSITY, out),
            Source::Time => self.time,
            Source::InterfacePoints => self.declared_points as f64,
            Source::Parameter(parameter) => self.parameter(parameter),
            Source::SubSteps => f64::from(self.sub_steps.count().unwrap_or(0)),
            Source::PointForce(point, component) => self.forces[point * d + component],
            Source::PointPosition(point, component) => self.at_point(names::POSITION, point, component),
            Source::PointVelocity(point, component) => self.at_point(names::VELOCITY, point, component),
            Source::Scalar(n) => self.scalars[n],
            Source::LargestStep => match self.sub_steps.count() {
                Some(count) => self.structure.stable_time_step() * f64::from(count),
                // Any: no importer expects infinity.
                None => f64::MAX,
            },
            Source::LargestStress => self.structure.largest_von_mises_stress()?,
        };
        Ok(())
    }

    /// Sets a source that can be set. Which when, the life cycle says.
    ///
    /// # Errors
    /// Values out of their range.
    pub fn write(&mut self, source: Source, values: &[f64]) -> Result<(), ModelError> {
        if let Some((index, &value)) = values.iter().enumerate().find(|(_, v)| !v.is_finite()) {
            return Err(ModelError::Load { index, value });
        }
        let d = self.dimension();
        match source {
            Source::PressureGradient => {
                let found = points(&self.outputs);
                match self.inputs.get_mut(names::PRESSURE_GRADIENT) {
                    Some(array) if array.len() == values.len() => array.copy_from_slice(values),
                    _ => return Err(ModelError::Points { declared: self.declared_points, found }),
                }
            }
            Source::PointForce(point, component) => self.forces[point * d + component] = values[0],
            Source::Parameter(parameter) => {
                self.parameters.insert(parameter, values[0]);
            }
            Source::SubSteps => {
                let value = values[0];
                self.sub_steps = match value as u32 {
                    _ if value < 0.0 || value > f64::from(u32::MAX) => {
                        return Err(ModelError::Value { what: "sub_steps", value });
                    }
                    0 => SubSteps::Stable,
                    count => SubSteps::Fixed(count),
                };
            }
            Source::InterfacePoints => {
                if values[0] < 1.0 {
                    return Err(ModelError::Value { what: "interface_points", value: values[0] });
                }
                self.declared_points = values[0] as usize;
            }
            _ => return Err(ModelError::Value { what: "what the unit computes", value: values[0] }),
        }
        Ok(())
    }

    fn parameter(&self, parameter: Parameter) -> f64 {
        let structure = self.case.structure.as_ref();
        let of_case = structure.and_then(|s| match parameter {
            Parameter::ParticleSpacing => Some(s.particle_spacing),
            Parameter::Damping => s.numerics.get(parameter.name())?.as_float(),
            _ => s.material.get(parameter.name())?.as_float(),
        });
        self.parameters.get(&parameter).copied().or(of_case).unwrap_or(f64::NAN)
    }

    fn at_point(&self, name: &str, point: usize, component: usize) -> f64 {
        let field = self.outputs.get(name).unwrap_or_default();
        self.reduction.as_ref().map_or(f64::NAN, |reduction| reduction.value(field, point, component))
    }

    /// All that a later step depends on, and all that can be read.
    ///
    /// # Errors
    /// A structure that cannot say its state.
    pub fn save(&mut self) -> Result<Saved, ModelError> {
        let arrays = |fields: &Fields| fields.iter().map(|(_, array)| array.to_vec()).collect();
        Ok(Saved {
            time: self.time,
            windows: self.windows,
            sub_steps: self.sub_steps,
            declared_points: self.declared_points,
            parameters: self.parameters.clone(),
            structure: self.structure.save()?,
            inputs: arrays(&self.inputs),
            outputs: arrays(&self.outputs),
            forces: self.forces.clone(),
            scalars: self.scalars.clone(),
        })
    }

    /// Goes to a saved state.
    ///
    /// # Errors
    /// One that is not of this unit.
    pub fn restore(&mut self, saved: &Saved) -> Result<(), ModelError> {
        if saved.parameters != self.parameters {
            self.parameters.clone_from(&saved.parameters);
            self.declared_points = saved.declared_points;
            self.initialize(saved.time)?;
        }
        let fits = |fields: &Fields, arrays: &[Vec<f64>]| {
            fields.iter().map(|(_, a)| a.len()).eq(arrays.iter().map(Vec::len))
        };
        let whole = fits(&self.inputs, &saved.inputs)
            && fits(&self.outputs, &saved.outputs)
            && saved.forces.len() == self.forces.len()
            && saved.scalars.len() == self.scalars.len();
        if !whole {
            return Err(ModelError::Saved);
        }
        self.structure.restore(&saved.structure, &mut self.outputs)?;
        for (fields, arrays) in [(&mut self.inputs, &saved.inputs), (&mut self.outputs, &saved.outputs)] {
            for ((_, array), values) in fields.iter_mut().zip(arrays) {
                array.copy_from_slice(values);
            }
        }
        self.forces.clone_from(&saved.forces);
        self.scalars.clone_from(&saved.scalars);
        (self.time, self.windows, self.sub_steps) = (saved.time, saved.windows, saved.sub_steps);
        self.declared_points = saved.declared_points;
        Ok(())
    }

    /// Back to the case's own parameters, at rest at time 0.
    ///
    /// # Errors
    /// As [`Model::new`].
    pub fn reset(&mut self) -> Result<(), ModelError> {
        *self = Self::new(self.resources.clone())?;
        Ok(())
    }

    /// The token of the unit.
    pub fn token(&self) -> String {
        self.resources.token()
    }
}

/// A state of a [`Model`].
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "fields of the model")]
pub struct Saved {
    pub time: f64,
    pub windows: u64,
    pub sub_steps: SubSteps,
    pub declared_points: usize,
    pub parameters: BTreeMap<Parameter, f64>,
    pub structure: Vec<u8>,
    pub inputs: Vec<Vec<f64>>,
    pub outputs: Vec<Vec<f64>>,
    pub forces: Vec<f64>,
    pub scalars: Vec<f64>,
}

fn read(resources: &Resources, parameters: &BTreeMap<Parameter, f64>) -> Result<Case, ModelError> {
    let overrides: Vec<String> =
        parameters.iter().map(|(parameter, value)| format!("{}={value:?}", parameter.key())).collect();
    let file = Path::new(crate::resources::CASE);
    Case::parse(&resources.case, file, &overrides, &[structure::participant::SECTIONS])
        .map_err(ModelError::Case)
}

fn fields(description: &Description) -> (Fields, Fields) {
    (description.fields(Direction::In, 0), description.fields(Direction::Out, 0))
}

fn points(outputs: &Fields) -> usize {
    outputs.get(names::REFERENCE_VOLUME).map_or(0, <[f64]>::len)
}
