//! An instance of FMI 2.0. Names and types are those of the standard's `fmi2Functions.h` and
//! `fmi2TypesPlatform.h`.

#![expect(unsafe_code, reason = "C functions, called through pointers")]

mod logger;

use crate::Error;
use crate::archive::Unpacked;
use crate::description::{Description, Type, Variable, Version};
use crate::unit::{Common, Handle, Instance, Stepped, Teller, c_text, not_wired, numbers};
use interfaces::case::unit::ParameterValue;
use libloading::Library;
use std::ffi::{c_char, c_void};
use std::path::Path;
use std::ptr::null;

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
    setup: unsafe extern "C" fn(Handle, i32, f64, f64, i32, f64) -> i32,
    step: unsafe extern "C" fn(Handle, f64, f64, i32) -> i32,
    get: Get<f64>,
    set: Set<f64>,
}

/// An instance.
pub struct Unit {
    common: Common,
    functions: Functions,
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
                setup: teller.function(library, "fmi2SetupExperiment")?,
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
        let common = Common { handle, state: std::ptr::null_mut(), version: Version::Fmi2, library, teller };
        common.require(description)?;
        Ok(Self { common, functions, _callbacks: callbacks })
    }

    fn set_typed<T: Copy>(&mut self, function: &str, reference: u32, value: T) -> Result<(), Error> {
        let set: Set<T> = self.common.function(function)?;
        // SAFETY: one reference, one value.
        let status = unsafe { set(self.common.handle, &raw const reference, 1, &raw const value) };
        self.common.check(function, status)
    }

    fn get_typed<T: Default + Copy>(&mut self, function: &str, reference: u32) -> Result<T, Error> {
        let get: Get<T> = self.common.function(function)?;
        let mut value = T::default();
        // SAFETY: as above.
        let status = unsafe { get(self.common.handle, &raw const reference, 1, &raw mut value) };
        self.common.check(function, status)?;
        Ok(value)
    }

    fn set_parameter(&mut self, variable: &Variable, value: &ParameterValue) -> Result<(), Error> {
        let (reference, number) = (variable.reference, numbers(value).first().copied());
        match (variable.kind, number, value) {
            (Type::Float64, Some(number), _) => self.set_typed("SetReal", reference, number),
            (Type::Int32, Some(number), _) => self.set_typed("SetInteger", reference, number as i32),
            (Type::Boolean, Some(number), _) => {
                self.set_typed("SetBoolean", reference, i32::from(number != 0.0))
            }
            (Type::String, None, ParameterValue::Text(text)) => {
                let text = c_text(text);
                self.set_typed("SetString", reference, text.as_ptr())
            }
            (other, ..) => Err(not_wired(&self.common.teller, other)),
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
        let status = unsafe { (self.functions.setup)(self.common.handle, FALSE, 0.0, start, FALSE, 0.0) };
        self.common.check("SetupExperiment", status)?;
        self.common.call("EnterInitializationMode")
    }

    fn common(&mut self) -> &mut Common {
        &mut self.common
    }

    fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        assert_eq!(references.len(), values.len(), "variables of FMI 2.0 are scalars");
        // SAFETY: pointers and the length of slices of the same length.
        let status = unsafe {
            (self.functions.set)(self.common.handle, references.as_ptr(), references.len(), values.as_ptr())
        };
        self.common.check("SetReal", status)
    }

    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        assert_eq!(references.len(), values.len(), "variables of FMI 2.0 are scalars");
        let count = references.len();
        // SAFETY: as above.
        let status = unsafe {
            (self.functions.get)(self.common.handle, references.as_ptr(), count, values.as_mut_ptr())
        };
        self.common.check("GetReal", status)
    }

    fn number(&mut self, variable: &Variable) -> Result<f64, Error> {
        let reference = variable.reference;
        Ok(match variable.kind {
            Type::Float64 => self.get_typed::<f64>("GetReal", reference)?,
            Type::Int32 => f64::from(self.get_typed::<i32>("GetInteger", reference)?),
            Type::Boolean => f64::from(u8::from(self.get_typed::<i32>("GetBoolean", reference)? != 0)),
            other => return Err(not_wired(&self.common.teller, other)),
        })
    }

    fn step(&mut self, start: f64, size: f64) -> Result<Stepped, Error> {
        // SAFETY: as in `call`. The unit is never told that a state before this one will not come back.
        let status = unsafe { (self.functions.step)(self.common.handle, start, size, FALSE) };
        self.common.check("DoStep", status)?;
        Ok(Stepped::On)
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
