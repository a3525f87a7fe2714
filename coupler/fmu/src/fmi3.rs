//! An instance of FMI 3.0. Names and types are those of the standard's `fmi3Functions.h` and
//! `fmi3PlatformTypes.h`.

#![expect(unsafe_code, reason = "C functions, called through pointers")]

use crate::Error;
use crate::archive::Unpacked;
use crate::description::{Causality, Description, Type, Variable, Version};
use crate::unit::{Common, Handle, Instance, Stepped, Teller, c_text, hear, not_wired, numbers};
use interfaces::case::unit::ParameterValue;
use libloading::Library;
use std::ffi::{c_char, c_void};
use std::ptr::null;

type Log = unsafe extern "C" fn(*mut c_void, i32, *const c_char, *const c_char);
type Instantiate = unsafe extern "C" fn(
    *const c_char,
    *const c_char,
    *const c_char,
    bool,
    bool,
    bool,
    bool,
    *const u32,
    usize,
    *mut c_void,
    Log,
    *const c_void,
) -> Handle;
type EnterInitialization = unsafe extern "C" fn(Handle, bool, f64, f64, bool, f64) -> i32;
type Step = unsafe extern "C" fn(Handle, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> i32;
type Set<T> = unsafe extern "C" fn(Handle, *const u32, usize, *const T, usize) -> i32;
type Get<T> = unsafe extern "C" fn(Handle, *const u32, usize, *mut T, usize) -> i32;

struct Functions {
    enter_initialization: EnterInitialization,
    step: Step,
    get: Get<f64>,
    set: Set<f64>,
}

/// An instance.
pub struct Unit {
    common: Common,
    functions: Functions,
}

unsafe extern "C" fn log(
    environment: *mut c_void,
    status: i32,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the unit hands back the environment it was given, and a text.
    unsafe { hear(environment, status, message) };
}

impl Unit {
    /// Instantiates it.
    pub fn new(
        library: &'static Library,
        description: &Description,
        unpacked: &Unpacked,
        teller: Teller,
    ) -> Result<Self, Error> {
        // SAFETY: the types are those of the standard's header.
        let (functions, instantiate) = unsafe {
            let functions = Functions {
                enter_initialization: teller.function(library, "fmi3EnterInitializationMode")?,
                step: teller.function(library, "fmi3DoStep")?,
                get: teller.function(library, "fmi3GetFloat64")?,
                set: teller.function(library, "fmi3SetFloat64")?,
            };
            (functions, teller.function::<Instantiate>(library, "fmi3InstantiateCoSimulation")?)
        };
        let (name, token) = (c_text(&description.model), c_text(&description.token));
        // The standard wants the separator at the end.
        let resources = c_text(&format!("{}/", unpacked.resources.display()));
        // A unit without resources is told of none.
        let resources = if unpacked.resources.is_dir() { resources.as_ptr() } else { null() };
        let environment = teller.environment();
        // SAFETY: all texts live during the call; the logger's environment lives as long as the teller, which
        // the instance has.
        let handle = unsafe {
            instantiate(
                name.as_ptr(),
                token.as_ptr(),
                resources,
                false,
                false,
                false,
                false,
                null(),
                0,
                environment,
                log,
                null(),
            )
        };
        if handle.is_null() {
            return Err(teller.error("fmi3InstantiateCoSimulation", "with no instance"));
        }
        let common = Common { handle, state: std::ptr::null_mut(), version: Version::Fmi3, library, teller };
        common.require(description)?;
        Ok(Self { common, functions })
    }

    /// Sets one variable through the function of its type.
    fn set_typed<T>(&mut self, function: &str, reference: u32, values: &[T]) -> Result<(), Error> {
        // SAFETY: the type is that of the standard's header for this function, which all callers take from
        // one table.
        let status = unsafe {
            let set: Set<T> = self.common.function(function)?;
            set(self.common.handle, &raw const reference, 1, values.as_ptr(), values.len())
        };
        self.common.check(function, status)
    }

    fn get_typed<T: Default>(&mut self, function: &str, reference: u32) -> Result<T, Error> {
        let mut value = T::default();
        // SAFETY: as above.
        let status = unsafe {
            let get: Get<T> = self.common.function(function)?;
            get(self.common.handle, &raw const reference, 1, &raw mut value, 1)
        };
        self.common.check(function, status)?;
        Ok(value)
    }

    fn set_parameter(&mut self, variable: &Variable, value: &ParameterValue) -> Result<(), Error> {
        let (reference, numbers) = (variable.reference, numbers(value));
        macro_rules! as_type {
            ($function:literal, $kind:ty) => {{
                let values: Vec<$kind> = numbers.iter().map(|number| *number as $kind).collect();
                self.set_typed($function, reference, &values)
            }};
        }
        match variable.kind {
            Type::Float64 => as_type!("SetFloat64", f64),
            Type::Float32 => as_type!("SetFloat32", f32),
            Type::Int32 => as_type!("SetInt32", i32),
            Type::Int64 => as_type!("SetInt64", i64),
            Type::UInt32 => as_type!("SetUInt32", u32),
            Type::UInt64 => as_type!("SetUInt64", u64),
            Type::Boolean => {
                let values: Vec<bool> = numbers.iter().map(|number| *number != 0.0).collect();
                self.set_typed("SetBoolean", reference, &values)
            }
            Type::String => {
                let ParameterValue::Text(text) = value else {
                    return Err(not_wired(&self.common.teller, Type::String));
                };
                let text = c_text(text);
                self.set_typed("SetString", reference, &[text.as_ptr()])
            }
            Type::Other => Err(not_wired(&self.common.teller, Type::Other)),
        }
    }
}

impl Instance for Unit {
    fn enter_initialization(
        &mut self,
        parameters: &[(Variable, ParameterValue)],
        start: f64,
    ) -> Result<(), Error> {
        let is_structural = |variable: &Variable| variable.causality == Causality::StructuralParameter;
        if parameters.iter().any(|(variable, _)| is_structural(variable)) {
            self.common.call("EnterConfigurationMode")?;
            for (variable, value) in parameters.iter().filter(|(variable, _)| is_structural(variable)) {
                self.set_parameter(variable, value)?;
            }
            self.common.call("ExitConfigurationMode")?;
        }
        for (variable, value) in parameters.iter().filter(|(variable, _)| !is_structural(variable)) {
            self.set_parameter(variable, value)?;
        }
        // SAFETY: as in `call`.
        let status = unsafe {
            (self.functions.enter_initialization)(self.common.handle, false, 0.0, start, false, 0.0)
        };
        self.common.check("EnterInitializationMode", status)
    }

    fn common(&mut self) -> &mut Common {
        &mut self.common
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        // SAFETY: pointers and lengths of the same slices.
        let status = unsafe {
            (self.functions.set)(
                self.common.handle,
                references.as_ptr(),
                references.len(),
                values.as_ptr(),
                values.len(),
            )
        };
        self.common.check("SetFloat64", status)
    }

    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        let (count, length) = (references.len(), values.len());
        // SAFETY: as above.
        let status = unsafe {
            (self.functions.get)(self.common.handle, references.as_ptr(), count, values.as_mut_ptr(), length)
        };
        self.common.check("GetFloat64", status)
    }

    fn number(&mut self, variable: &Variable) -> Result<f64, Error> {
        let reference = variable.reference;
        Ok(match variable.kind {
            Type::Float64 => self.get_typed::<f64>("GetFloat64", reference)?,
            Type::Float32 => f64::from(self.get_typed::<f32>("GetFloat32", reference)?),
            Type::Int32 => f64::from(self.get_typed::<i32>("GetInt32", reference)?),
            Type::Int64 => self.get_typed::<i64>("GetInt64", reference)? as f64,
            Type::UInt32 => f64::from(self.get_typed::<u32>("GetUInt32", reference)?),
            Type::UInt64 => self.get_typed::<u64>("GetUInt64", reference)? as f64,
            // Read as the byte that it is: a foreign one need be neither 0 nor 1.
            Type::Boolean => f64::from(u8::from(self.get_typed::<u8>("GetBoolean", reference)? != 0)),
            other => return Err(not_wired(&self.common.teller, other)),
        })
    }

    fn step(&mut self, start: f64, size: f64) -> Result<Stepped, Error> {
        let (mut event, mut end, mut early, mut last) = (false, false, false, start);
        // SAFETY: the four results live during the call.
        let status = unsafe {
            let step = self.functions.step;
            step(
                self.common.handle,
                start,
                size,
                false,
                &raw mut event,
                &raw mut end,
                &raw mut early,
                &raw mut last,
            )
        };
        self.common.check("DoStep", status)?;
        if early {
            let what = format!("returned early from a step, at {last} s, which it was told not to do");
            return Err(self.common.teller.incapable(&what));
        }
        Ok(if end { Stepped::EndRequested } else { Stepped::On })
    }
}
