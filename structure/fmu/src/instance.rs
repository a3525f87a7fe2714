//! One instance of a unit: where it is in its life, what it may do there, and whom it tells what went wrong.

use crate::model::{Model, ModelError};
use crate::phase::Phase;
use crate::resources::Resources;
use crate::saved::{self, InstanceState};
use crate::variables::{Causality, Source, Variable, table};

/// Why a call failed; what the importer's logger is told.
#[derive(Debug, thiserror::Error)]
pub enum CallError {
    /// A call that is not allowed now.
    #[error("{function} is not allowed now: the instance is {phase:?}, and the call needs {needed:?}")]
    OutOfOrder {
        /// The function.
        function: &'static str,
        /// Where the instance is.
        phase: Phase,
        /// Where it would be allowed.
        needed: Vec<Phase>,
    },
    /// A value reference that is none, or of another type.
    #[error("value reference {reference} is no {wanted}")]
    Reference {
        /// As given.
        reference: u32,
        /// What the function reads or sets.
        wanted: &'static str,
    },
    /// A variable that cannot be set, or not now.
    #[error("{name} cannot be set while the instance is {phase:?}: {rule}")]
    NotSettable {
        /// The variable.
        name: String,
        /// Where the instance is.
        phase: Phase,
        /// When it could be.
        rule: &'static str,
    },
    /// An array of the wrong length.
    #[error("{found} values are given for variables that have {expected}")]
    Length {
        /// As given.
        found: usize,
        /// As it should be.
        expected: usize,
    },
    /// A null pointer where an array or a string belongs.
    #[error("{what} is a null pointer")]
    Null {
        /// The argument.
        what: &'static str,
    },
    /// Text that is no UTF-8.
    #[error("{what} is no UTF-8 text")]
    Text {
        /// The argument.
        what: &'static str,
    },
    /// A step that does not begin where the last ended.
    #[error("the step begins at {given} s, but the last ended at {time} s; the structure has no other past")]
    Time {
        /// The step's start.
        given: f64,
        /// The model's time.
        time: f64,
    },
    /// A step that is not positive.
    #[error("a step of {0} s; it must be positive and finite")]
    Step(f64),
    /// What a unit of this kind does not do.
    #[error("{0} is not part of this unit: it is for co-simulation, without events, clocks or derivatives")]
    Unsupported(&'static str),
    /// The structure's own words.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Resources that cannot be used.
    #[error(transparent)]
    Resource(#[from] crate::resources::ResourceError),
}

/// How bad it is, as both standards number it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
#[expect(missing_docs, reason = "terms of the standards")]
pub enum Status {
    Ok = 0,
    Warning = 1,
    Discard = 2,
    Error = 3,
    Fatal = 4,
}

/// Takes what an instance has to say.
pub type Logger = Box<dyn Fn(Status, &str)>;

/// Time (s) by which a step may begin beside the end of the last, as a fraction of the step: rounding of an
/// importer's own sum.
const TIME_TOLERANCE: f64 = 1e-6;

/// An instance.
pub struct Instance {
    model: Model,
    variables: Vec<Variable>,
    phase: Phase,
    logger: Logger,
    /// Time (s) at which it will be initialised, where that is said beforehand.
    pub start: f64,
    /// Whether a parameter was set in initialization mode and has not taken effect yet.
    stale: bool,
    /// Whether the importer wants to hear of more than errors.
    pub logging: bool,
}

impl Instance {
    /// Of the resources of a unit that has this token; `arrays` says whether the standard knows any.
    ///
    /// # Errors
    /// A token of another unit, resources of the other standard, a case that does not hold.
    pub fn new(
        resources: Resources,
        token: &str,
        arrays: bool,
        logger: Logger,
        logging: bool,
    ) -> Result<Self, CallError> {
        resources.check_token(token)?;
        if resources.points.is_none() && !arrays {
            return Err(CallError::Unsupported("an interface of arrays in FMI 2.0"));
        }
        let model = Model::new(resources)?;
        let variables = table(model.describe(), model.reduced_points());
        Ok(Self { model, variables, phase: Phase::Instantiated, logger, start: 0.0, stale: false, logging })
    }

    /// Tells the importer.
    pub fn say(&self, status: Status, message: &str) {
        if self.logging || status as i32 >= Status::Error as i32 {
            (self.logger)(status, message);
        }
    }

    /// Where it is in its life.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// The variables, by value reference.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// After a panic: nothing but reset and the end is left.
    pub fn break_down(&mut self) {
        self.phase = Phase::Broken;
    }

    /// Refuses a call outside of the phases in which it is allowed.
    ///
    /// # Errors
    /// [`CallError::OutOfOrder`].
    pub fn expect(&self, function: &'static str, needed: &[Phase]) -> Result<(), CallError> {
        if needed.contains(&self.phase) {
            return Ok(());
        }
        Err(CallError::OutOfOrder { function, phase: self.phase, needed: needed.to_vec() })
    }

    /// Goes on to another phase.
    pub fn enter(&mut self, phase: Phase) {
        self.phase = phase;
    }

    /// Initialises at `start` (s).
    ///
    /// # Errors
    /// What the model refuses.
    pub fn initialize(&mut self, start: f64) -> Result<(), CallError> {
        self.start = start;
        self.model.initialize(start)?;
        self.stale = false;
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// Ends initialization mode.
    ///
    /// # Errors
    /// What the model refuses of parameters that were set in it.
    pub fn begin_steps(&mut self) -> Result<(), CallError> {
        self.settle()?;
        self.phase = Phase::Step;
        Ok(())
    }

    /// Parameters that were set in initialization mode take effect.
    fn settle(&mut self) -> Result<(), CallError> {
        if std::mem::take(&mut self.stale) {
            self.model.initialize(self.start)?;
        }
        Ok(())
    }

    /// One step.
    ///
    /// # Errors
    /// A step that does not follow the last, or fails: the instance is broken then.
    pub fn step(&mut self, start: f64, size: f64) -> Result<(), CallError> {
        if !(size > 0.0 && size.is_finite()) {
            return Err(CallError::Step(size));
        }
        let mut time = [0.0];
        self.model.read(Source::Time, &mut time)?;
        // A start that is not a number is within no tolerance.
        let follows = (start - time[0]).abs() <= TIME_TOLERANCE * size;
        if !follows {
            return Err(CallError::Time { given: start, time: time[0] });
        }
        self.model.step(start, size).inspect_err(|_| self.phase = Phase::Broken)?;
        Ok(())
    }

    /// Back to where it began.
    ///
    /// # Errors
    /// Resources that no longer hold.
    pub fn reset(&mut self) -> Result<(), CallError> {
        self.model.reset()?;
        (self.start, self.stale) = (0.0, false);
        self.phase = Phase::Instantiated;
        Ok(())
    }

    /// The variable of a reference that is a real number, or a count.
    fn variable(&self, reference: u32, is_count: bool) -> Result<&Variable, CallError> {
        let wanted = if is_count { "count" } else { "real variable" };
        let variable = self.variables.get(reference as usize);
        variable
            .filter(|variable| variable.quantity.is_none() == is_count)
            .ok_or(CallError::Reference { reference, wanted })
    }

    /// Reads variables, arrays whole, one after another, into `out`.
    ///
    /// # Errors
    /// References that are none, a length that does not fit.
    pub fn read(&mut self, references: &[u32], is_count: bool, out: &mut [f64]) -> Result<(), CallError> {
        self.settle()?;
        let sources = self.sources(references, is_count, out.len())?;
        let mut rest = out;
        for (source, length) in sources {
            let (head, tail) = rest.split_at_mut(length);
            self.model.read(source, head)?;
            rest = tail;
        }
        Ok(())
    }

    /// Sets variables, arrays whole, one after another.
    ///
    /// # Errors
    /// References that are none or cannot be set now, a length that does not fit, values that are not finite.
    pub fn write(&mut self, references: &[u32], is_count: bool, values: &[f64]) -> Result<(), CallError> {
        let sources = self.sources(references, is_count, values.len())?;
        for &reference in references {
            self.check_settable(self.variable(reference, is_count)?)?;
        }
        let mut rest = values;
        for (source, length) in sources {
            let (head, tail) = rest.split_at(length);
            self.model.write(source, head)?;
            self.stale |= self.phase == Phase::Initialization && matches!(source, Source::Parameter(_));
            rest = tail;
        }
        Ok(())
    }

    fn sources(
        &self,
        references: &[u32],
        is_count: bool,
        given: usize,
    ) -> Result<Vec<(Source, usize)>, CallError> {
        let mut sources = Vec::with_capacity(references.len());
        for &reference in references {
            let source = self.variable(reference, is_count)?.source;
            sources.push((source, self.model.length(source)));
        }
        let expected = sources.iter().map(|(_, length)| length).sum();
        if given == expected { Ok(sources) } else { Err(CallError::Length { found: given, expected }) }
    }

    fn check_settable(&self, variable: &Variable) -> Result<(), CallError> {
        let (phases, rule): (&[Phase], _) = match variable.causality {
            Causality::Input => {
                (&[Phase::Instantiated, Phase::Initialization, Phase::Step], "inputs are set before a step")
            }
            Causality::Parameter => {
                (&[Phase::Instantiated, Phase::Initialization], "parameters are fixed once steps begin")
            }
            Causality::StructuralParameter => (&[Phase::Configuration], "it is set in configuration mode"),
            _ => (&[], "the unit computes it"),
        };
        if phases.contains(&self.phase) {
            return Ok(());
        }
        Err(CallError::NotSettable { name: variable.name.clone(), phase: self.phase, rule })
    }

    /// The state, whole.
    ///
    /// # Errors
    /// A structure that cannot say its state.
    pub fn save(&mut self) -> Result<InstanceState, CallError> {
        self.settle()?;
        Ok(InstanceState { phase: self.phase, model: self.model.save()? })
    }

    /// Goes to a state.
    ///
    /// # Errors
    /// A state that is not of this unit.
    pub fn restore(&mut self, state: &InstanceState) -> Result<(), CallError> {
        self.model.restore(&state.model)?;
        self.stale = false;
        self.phase = state.phase;
        Ok(())
    }

    /// A state as bytes.
    pub fn serialize(&self, state: &InstanceState) -> Vec<u8> {
        saved::to_bytes(state, &self.model.token())
    }

    /// A state from bytes.
    ///
    /// # Errors
    /// Bytes that are no state of this unit.
    pub fn deserialize(&self, bytes: &[u8]) -> Result<InstanceState, CallError> {
        Ok(saved::from_bytes(bytes, &self.model.token()).map_err(ModelError::Bytes)?)
    }
}
