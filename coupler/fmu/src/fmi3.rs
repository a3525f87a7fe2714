//! An instance of FMI 3.0. Names and types are those of the standard's `fmi3Functions.h` and
//! `fmi3PlatformTypes.h`.

#![expect(unsafe_code, reason = "C functions, called through pointers")]

use crate::Error;
use crate::archive::Unpacked;
use crate::description::{Causality, Description, Type, Variable};
use crate::unit::{Instance, Stepped, Teller, c_text, hear, not_wired, numbers};
use interfaces::case::unit::ParameterValue;
use libloading::Library;
use std::ffi::{c_char, c_void};
use std::ptr::null;

type Handle = *mut c_void;
type State = *mut c_void;
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
type Plain = unsafe extern "C" fn(Handle) -> i32;
type EnterInitialization = unsafe extern "C" fn(Handle, bool, f64, f64, bool, f64) -> i32;
type Step = unsafe extern "C" fn(Handle, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> i32;
type Set<T> = unsafe extern "C" fn(Handle, *const u32, usize, *const T, usize) -> i32;
type Get<T> = unsafe extern "C" fn(Handle, *const u32, usize, *mut T, usize) -> i32;

struct Functions {
    free: unsafe extern "C" fn(Handle),
    enter_configuration: Plain,
    exit_configuration: Plain,
    enter_initialization: EnterInitialization,
    exit_initialization: Plain,
    terminate: Plain,
    step: Step,
    get: Get<f64>,
    set: Set<f64>,
    get_state: unsafe extern "C" fn(Handle, *mut State) -> i32,
    set_state: unsafe extern "C" fn(Handle, State) -> i32,
    free_state: unsafe extern "C" fn(Handle, *mut State) -> i32,
    serialized_size: unsafe extern "C" fn(Handle, State, *mut usize) -> i32,
    serialize: unsafe extern "C" fn(Handle, State, *mut u8, usize) -> i32,
    deserialize: unsafe extern "C" fn(Handle, *const u8, usize, *mut State) -> i32,
}

/// An instance.
pub struct Unit {
    handle: Handle,
    state: State,
    functions: Functions,
    library: &'static Library,
    teller: Teller,
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
                free: teller.function(library, "fmi3FreeInstance")?,
                enter_configuration: teller.function(library, "fmi3EnterConfigurationMode")?,
                exit_configuration: teller.function(library, "fmi3ExitConfigurationMode")?,
                enter_initialization: teller.function(library, "fmi3EnterInitializationMode")?,
                exit_initialization: teller.function(library, "fmi3ExitInitializationMode")?,
                terminate: teller.function(library, "fmi3Terminate")?,
                step: teller.function(library, "fmi3DoStep")?,
                get: teller.function(library, "fmi3GetFloat64")?,
                set: teller.function(library, "fmi3SetFloat64")?,
                get_state: teller.function(library, "fmi3GetFMUState")?,
                set_state: teller.function(library, "fmi3SetFMUState")?,
                free_state: teller.function(library, "fmi3FreeFMUState")?,
                serialized_size: teller.function(library, "fmi3SerializedFMUStateSize")?,
                serialize: teller.function(library, "fmi3SerializeFMUState")?,
                deserialize: teller.function(library, "fmi3DeserializeFMUState")?,
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
        Ok(Self { handle, state: std::ptr::null_mut(), functions, library, teller })
    }

    /// Sets one variable through the function of its type.
    fn set_typed<T>(&mut self, function: &'static str, reference: u32, values: &[T]) -> Result<(), Error> {
        // SAFETY: the type is that of the standard's header for this function, which all callers take from
        // one table.
        let status = unsafe {
            let set: Set<T> = self.teller.function(self.library, function)?;
            set(self.handle, &raw const reference, 1, values.as_ptr(), values.len())
        };
        self.teller.check(function, status)
    }

    fn get_typed<T: Default>(&mut self, function: &'static str, reference: u32) -> Result<T, Error> {
        let mut value = T::default();
        // SAFETY: as above.
        let status = unsafe {
            let get: Get<T> = self.teller.function(self.library, function)?;
            get(self.handle, &raw const reference, 1, &raw mut value, 1)
        };
        self.teller.check(function, status)?;
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
            Type::Float64 => as_type!("fmi3SetFloat64", f64),
            Type::Float32 => as_type!("fmi3SetFloat32", f32),
            Type::Int32 => as_type!("fmi3SetInt32", i32),
            Type::Int64 => as_type!("fmi3SetInt64", i64),
            Type::UInt32 => as_type!("fmi3SetUInt32", u32),
            Type::UInt64 => as_type!("fmi3SetUInt64", u64),
            Type::Boolean => {
                let values: Vec<bool> = numbers.iter().map(|number| *number != 0.0).collect();
                self.set_typed("fmi3SetBoolean", reference, &values)
            }
            Type::String => {
                let ParameterValue::Text(text) = value else {
                    return Err(not_wired(&self.teller, Type::String));
                };
                let text = c_text(text);
                self.set_typed("fmi3SetString", reference, &[text.as_ptr()])
            }
            Type::Other => Err(not_wired(&self.teller, Type::Other)),
        }
    }

    fn call(&self, name: &'static str, function: Plain) -> Result<(), Error> {
        // SAFETY: a function of the standard with an instance that lives.
        let status = unsafe { function(self.handle) };
        self.teller.check(name, status)
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
            self.call("fmi3EnterConfigurationMode", self.functions.enter_configuration)?;
            for (variable, value) in parameters.iter().filter(|(variable, _)| is_structural(variable)) {
                self.set_parameter(variable, value)?;
            }
            self.call("fmi3ExitConfigurationMode", self.functions.exit_configuration)?;
        }
        for (variable, value) in parameters.iter().filter(|(variable, _)| !is_structural(variable)) {
            self.set_parameter(variable, value)?;
        }
        // SAFETY: as in `call`.
        let status =
            unsafe { (self.functions.enter_initialization)(self.handle, false, 0.0, start, false, 0.0) };
        self.teller.check("fmi3EnterInitializationMode", status)
    }

    fn exit_initialization(&mut self) -> Result<(), Error> {
        self.call("fmi3ExitInitializationMode", self.functions.exit_initialization)
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        // SAFETY: pointers and lengths of the same slices.
        let status = unsafe {
            (self.functions.set)(
                self.handle,
                references.as_ptr(),
                references.len(),
                values.as_ptr(),
                values.len(),
            )
        };
        self.teller.check("fmi3SetFloat64", status)
    }

    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        let (count, length) = (references.len(), values.len());
        // SAFETY: as above.
        let status = unsafe {
            (self.functions.get)(self.handle, references.as_ptr(), count, values.as_mut_ptr(), length)
        };
        self.teller.check("fmi3GetFloat64", status)
    }

    fn number(&mut self, variable: &Variable) -> Result<f64, Error> {
        let reference = variable.reference;
        Ok(match variable.kind {
            Type::Float64 => self.get_typed::<f64>("fmi3GetFloat64", reference)?,
            Type::Float32 => f64::from(self.get_typed::<f32>("fmi3GetFloat32", reference)?),
            Type::Int32 => f64::from(self.get_typed::<i32>("fmi3GetInt32", reference)?),
            Type::Int64 => self.get_typed::<i64>("fmi3GetInt64", reference)? as f64,
            Type::UInt32 => f64::from(self.get_typed::<u32>("fmi3GetUInt32", reference)?),
            Type::UInt64 => self.get_typed::<u64>("fmi3GetUInt64", reference)? as f64,
            // Read as the byte that it is: a foreign one need be neither 0 nor 1.
            Type::Boolean => f64::from(u8::from(self.get_typed::<u8>("fmi3GetBoolean", reference)? != 0)),
            other => return Err(not_wired(&self.teller, other)),
        })
    }

    fn step(&mut self, start: f64, size: f64) -> Result<Stepped, Error> {
        let (mut event, mut end, mut early, mut last) = (false, false, false, start);
        // SAFETY: the four results live during the call.
        let status = unsafe {
            let step = self.functions.step;
            step(self.handle, start, size, false, &raw mut event, &raw mut end, &raw mut early, &raw mut last)
        };
        self.teller.check("fmi3DoStep", status)?;
        if early {
            let what = format!("returned early from a step, at {last} s, which it was told not to do");
            return Err(self.teller.incapable(&what));
        }
        Ok(if end { Stepped::EndRequested } else { Stepped::On })
    }

    fn keep(&mut self) -> Result<(), Error> {
        // SAFETY: the state is null or one of this instance's, which the function may use again.
        let status = unsafe { (self.functions.get_state)(self.handle, &raw mut self.state) };
        self.teller.check("fmi3GetFMUState", status)
    }

    fn go_back(&mut self) -> Result<(), Error> {
        // SAFETY: a state of this instance's.
        let status = unsafe { (self.functions.set_state)(self.handle, self.state) };
        self.teller.check("fmi3SetFMUState", status)
    }

    fn serialize(&mut self) -> Result<Vec<u8>, Error> {
        let mut size = 0;
        // SAFETY: a state of this instance's, then memory of the size that was asked for.
        let status = unsafe { (self.functions.serialized_size)(self.handle, self.state, &raw mut size) };
        self.teller.check("fmi3SerializedFMUStateSize", status)?;
        let mut bytes = vec![0; size];
        // SAFETY: as above.
        let status =
            unsafe { (self.functions.serialize)(self.handle, self.state, bytes.as_mut_ptr(), bytes.len()) };
        self.teller.check("fmi3SerializeFMUState", status)?;
        Ok(bytes)
    }

    fn deserialize(&mut self, bytes: &[u8]) -> Result<(), Error> {
        // SAFETY: pointer and length of the same slice; the state as in `keep`.
        let status = unsafe {
            (self.functions.deserialize)(self.handle, bytes.as_ptr(), bytes.len(), &raw mut self.state)
        };
        self.teller.check("fmi3DeserializeFMUState", status)
    }

    fn terminate(&mut self) -> Result<(), Error> {
        self.call("fmi3Terminate", self.functions.terminate)
    }
}

impl Drop for Unit {
    fn drop(&mut self) {
        // SAFETY: the state and the instance are given back once, and not used again.
        unsafe {
            if !self.state.is_null() {
                (self.functions.free_state)(self.handle, &raw mut self.state);
            }
            (self.functions.free)(self.handle);
        }
    }
}
