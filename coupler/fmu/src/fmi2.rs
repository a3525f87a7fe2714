//! An instance of FMI 2.0. Names and types are those of the standard's `fmi2Functions.h` and
//! `fmi2TypesPlatform.h`.

#![expect(unsafe_code, reason = "C functions, called through pointers")]

mod logger;

use crate::Error;
use crate::archive::Unpacked;
use crate::description::{Description, Type, Variable};
use crate::unit::{Instance, Stepped, Teller, c_text, not_wired, numbers};
use interfaces::case::unit::ParameterValue;
use libloading::Library;
use std::ffi::{c_char, c_void};
use std::path::Path;
use std::ptr::null;

type Handle = *mut c_void;
type State = *mut c_void;
/// The standard's logger.
type Log = *const c_void;
type Instantiate = unsafe extern "C" fn(
    *const c_char,
    i32,
    *const c_char,
    *const c_char,
    *const Callbacks,
    i32,
    i32,
) -> Handle;
type Plain = unsafe extern "C" fn(Handle) -> i32;
type Set<T> = unsafe extern "C" fn(Handle, *const u32, usize, *const T) -> i32;
type Get<T> = unsafe extern "C" fn(Handle, *const u32, usize, *mut T) -> i32;
/// `fmi2CoSimulation`.
const CO_SIMULATION: i32 = 1;
/// `fmi2False`.
const FALSE: i32 = 0;

/// `fmi2CallbackFunctions`.
#[repr(C)]
struct Callbacks {
    logger: Log,
    allocate: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void),
    step_finished: *const c_void,
    environment: *mut c_void,
}

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
}

struct Functions {
    free: unsafe extern "C" fn(Handle),
    setup: unsafe extern "C" fn(Handle, i32, f64, f64, i32, f64) -> i32,
    enter_initialization: Plain,
    exit_initialization: Plain,
    terminate: Plain,
    step: unsafe extern "C" fn(Handle, f64, f64, i32) -> i32,
    get: Get<f64>,
    set: Set<f64>,
}

/// An instance.
pub struct Unit {
    handle: Handle,
    state: State,
    functions: Functions,
    library: &'static Library,
    teller: Teller,
    /// The unit keeps a pointer to them.
    _callbacks: Box<Callbacks>,
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
                free: teller.function(library, "fmi2FreeInstance")?,
                setup: teller.function(library, "fmi2SetupExperiment")?,
                enter_initialization: teller.function(library, "fmi2EnterInitializationMode")?,
                exit_initialization: teller.function(library, "fmi2ExitInitializationMode")?,
                terminate: teller.function(library, "fmi2Terminate")?,
                step: teller.function(library, "fmi2DoStep")?,
                get: teller.function(library, "fmi2GetReal")?,
                set: teller.function(library, "fmi2SetReal")?,
            };
            (functions, teller.function::<Instantiate>(library, "fmi2Instantiate")?)
        };
        let callbacks = Box::new(Callbacks {
            logger: logger::pointer(),
            allocate: calloc,
            free,
            step_finished: null(),
            environment: teller.environment(),
        });
        let (name, token) = (c_text(&description.model), c_text(&description.token));
        let resources = c_text(&file_uri(&unpacked.resources));
        // SAFETY: all texts live during the call, the callbacks as long as the instance.
        let handle = unsafe {
            let callbacks: *const Callbacks = &raw const *callbacks;
            instantiate(
                name.as_ptr(),
                CO_SIMULATION,
                token.as_ptr(),
                resources.as_ptr(),
                callbacks,
                FALSE,
                FALSE,
            )
        };
        if handle.is_null() {
            return Err(teller.error("fmi2Instantiate", "with no instance"));
        }
        Ok(Self { handle, state: std::ptr::null_mut(), functions, library, teller, _callbacks: callbacks })
    }

    /// Calls a function that only some units have, with the rest of its arguments.
    fn state_function<F: Copy>(&self, name: &'static str) -> Result<F, Error> {
        // SAFETY: the callers take the types from the standard's header.
        unsafe { self.teller.function(self.library, name) }
    }

    fn call(&self, name: &'static str, function: Plain) -> Result<(), Error> {
        // SAFETY: a function of the standard with an instance that lives.
        let status = unsafe { function(self.handle) };
        self.teller.check(name, status)
    }

    fn set_typed<T: Copy>(&mut self, function: &'static str, reference: u32, value: T) -> Result<(), Error> {
        let set: Set<T> = self.state_function(function)?;
        // SAFETY: one reference, one value.
        let status = unsafe { set(self.handle, &raw const reference, 1, &raw const value) };
        self.teller.check(function, status)
    }

    fn get_typed<T: Default + Copy>(&mut self, function: &'static str, reference: u32) -> Result<T, Error> {
        let get: Get<T> = self.state_function(function)?;
        let mut value = T::default();
        // SAFETY: as above.
        let status = unsafe { get(self.handle, &raw const reference, 1, &raw mut value) };
        self.teller.check(function, status)?;
        Ok(value)
    }

    fn set_parameter(&mut self, variable: &Variable, value: &ParameterValue) -> Result<(), Error> {
        let (reference, number) = (variable.reference, numbers(value).first().copied());
        match (variable.kind, number, value) {
            (Type::Float64, Some(number), _) => self.set_typed("fmi2SetReal", reference, number),
            (Type::Int32, Some(number), _) => self.set_typed("fmi2SetInteger", reference, number as i32),
            (Type::Boolean, Some(number), _) => {
                self.set_typed("fmi2SetBoolean", reference, i32::from(number != 0.0))
            }
            (Type::String, None, ParameterValue::Text(text)) => {
                let text = c_text(text);
                self.set_typed("fmi2SetString", reference, text.as_ptr())
            }
            (other, ..) => Err(not_wired(&self.teller, other)),
        }
    }
}

impl Instance for Unit {
    fn enter_initialization(
        &mut self,
        parameters: &[(Variable, ParameterValue)],
        start: f64,
    ) -> Result<(), Error> {
        for (variable, value) in parameters {
            self.set_parameter(variable, value)?;
        }
        // SAFETY: as in `call`.
        let status = unsafe { (self.functions.setup)(self.handle, FALSE, 0.0, start, FALSE, 0.0) };
        self.teller.check("fmi2SetupExperiment", status)?;
        self.call("fmi2EnterInitializationMode", self.functions.enter_initialization)
    }

    fn exit_initialization(&mut self) -> Result<(), Error> {
        self.call("fmi2ExitInitializationMode", self.functions.exit_initialization)
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        assert_eq!(references.len(), values.len(), "variables of FMI 2.0 are scalars");
        // SAFETY: pointers and the length of slices of the same length.
        let status = unsafe {
            (self.functions.set)(self.handle, references.as_ptr(), references.len(), values.as_ptr())
        };
        self.teller.check("fmi2SetReal", status)
    }

    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        assert_eq!(references.len(), values.len(), "variables of FMI 2.0 are scalars");
        let count = references.len();
        // SAFETY: as above.
        let status =
            unsafe { (self.functions.get)(self.handle, references.as_ptr(), count, values.as_mut_ptr()) };
        self.teller.check("fmi2GetReal", status)
    }

    fn number(&mut self, variable: &Variable) -> Result<f64, Error> {
        let reference = variable.reference;
        Ok(match variable.kind {
            Type::Float64 => self.get_typed::<f64>("fmi2GetReal", reference)?,
            Type::Int32 => f64::from(self.get_typed::<i32>("fmi2GetInteger", reference)?),
            Type::Boolean => f64::from(u8::from(self.get_typed::<i32>("fmi2GetBoolean", reference)? != 0)),
            other => return Err(not_wired(&self.teller, other)),
        })
    }

    fn step(&mut self, start: f64, size: f64) -> Result<Stepped, Error> {
        // SAFETY: as in `call`. The unit is never told that a state before this one will not come back.
        let status = unsafe { (self.functions.step)(self.handle, start, size, FALSE) };
        self.teller.check("fmi2DoStep", status)?;
        Ok(Stepped::On)
    }

    fn keep(&mut self) -> Result<(), Error> {
        let get: unsafe extern "C" fn(Handle, *mut State) -> i32 = self.state_function("fmi2GetFMUstate")?;
        // SAFETY: the state is null or one of this instance's, which the function may use again.
        let status = unsafe { get(self.handle, &raw mut self.state) };
        self.teller.check("fmi2GetFMUstate", status)
    }

    fn go_back(&mut self) -> Result<(), Error> {
        let set: unsafe extern "C" fn(Handle, State) -> i32 = self.state_function("fmi2SetFMUstate")?;
        // SAFETY: a state of this instance's.
        let status = unsafe { set(self.handle, self.state) };
        self.teller.check("fmi2SetFMUstate", status)
    }

    fn serialize(&mut self) -> Result<Vec<u8>, Error> {
        type Size = unsafe extern "C" fn(Handle, State, *mut usize) -> i32;
        type Serialize = unsafe extern "C" fn(Handle, State, *mut u8, usize) -> i32;
        let size_of: Size = self.state_function("fmi2SerializedFMUstateSize")?;
        let serialize: Serialize = self.state_function("fmi2SerializeFMUstate")?;
        let mut size = 0;
        // SAFETY: a state of this instance's, then memory of the size that was asked for.
        let status = unsafe { size_of(self.handle, self.state, &raw mut size) };
        self.teller.check("fmi2SerializedFMUstateSize", status)?;
        let mut bytes = vec![0; size];
        // SAFETY: as above.
        let status = unsafe { serialize(self.handle, self.state, bytes.as_mut_ptr(), bytes.len()) };
        self.teller.check("fmi2SerializeFMUstate", status)?;
        Ok(bytes)
    }

    fn deserialize(&mut self, bytes: &[u8]) -> Result<(), Error> {
        type Deserialize = unsafe extern "C" fn(Handle, *const u8, usize, *mut State) -> i32;
        let deserialize: Deserialize = self.state_function("fmi2DeSerializeFMUstate")?;
        // SAFETY: pointer and length of the same slice; the state as in `keep`.
        let status = unsafe { deserialize(self.handle, bytes.as_ptr(), bytes.len(), &raw mut self.state) };
        self.teller.check("fmi2DeSerializeFMUstate", status)
    }

    fn terminate(&mut self) -> Result<(), Error> {
        self.call("fmi2Terminate", self.functions.terminate)
    }
}

impl Drop for Unit {
    fn drop(&mut self) {
        type FreeState = unsafe extern "C" fn(Handle, *mut State) -> i32;
        let free_state = self.state_function::<FreeState>("fmi2FreeFMUstate");
        // SAFETY: the state and the instance are given back once, and not used again.
        unsafe {
            if let (false, Ok(free_state)) = (self.state.is_null(), free_state) {
                free_state(self.handle, &raw mut self.state);
            }
            (self.functions.free)(self.handle);
        }
    }
}

/// The folder as a URI: bytes other than unreserved ones are escaped.
fn file_uri(folder: &Path) -> String {
    use std::fmt::Write as _;
    let mut uri = String::from("file://");
    for byte in folder.to_string_lossy().bytes() {
        match byte {
            b'/' | b'-' | b'_' | b'.' | b'~' => uri.push(byte.into()),
            _ if byte.is_ascii_alphanumeric() => uri.push(byte.into()),
            _ => {
                let _ = write!(uri, "%{byte:02X}");
            }
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_uri_escapes_what_paths_may_have_and_uris_not() {
        assert_eq!(file_uri(Path::new("/a b/ü-1.0/resources")), "file:///a%20b/%C3%BC-1.0/resources");
    }
}
