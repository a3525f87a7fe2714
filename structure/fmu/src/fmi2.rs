//! The C functions of FMI 2.0 for co-simulation, and those common to both kinds.
//!
//! Names, order and types of arguments are those of the standard's headers `fmi2Functions.h` and
//! `fmi2TypesPlatform.h` (version 2.0).

#![expect(unsafe_code, reason = "functions with the standard's names, called from C")]

use crate::boundary::{array, array_mut, call, common_functions, instantiate, text};
use crate::instance::{CallError, Instance, Logger, Status};
use crate::phase::Phase;
use crate::resources::{ResourceError, Resources};
use std::ffi::{CString, c_char, c_void};
use std::path::PathBuf;

type Handle = *mut c_void;
type Reference = u32;
type Boolean = i32;
type LogMessage = unsafe extern "C" fn(*mut c_void, *const c_char, i32, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`.
#[repr(C)]
struct Callbacks {
    logger: Option<LogMessage>,
    allocate: *const c_void,
    free: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

/// `fmi2CoSimulation`.
const CO_SIMULATION: i32 = 1;

/// The importer's logger; a `%` of the message is doubled, since it is a format. (As an argument of `%s` it
/// would be lost to importers that leave the places of a format unfilled.)
fn logger(name: &str, message: Option<LogMessage>, environment: *mut c_void) -> Logger {
    let name = CString::new(name.replace('\0', " ")).unwrap_or_default();
    Box::new(move |status, words| {
        let Some(message) = message else { return };
        let category = if status == Status::Ok { c"logEvents" } else { c"logStatusError" };
        let words = CString::new(words.replace('\0', " ").replace('%', "%%")).unwrap_or_default();
        // SAFETY: the importer's function, with the environment it came with; all texts end with a zero and
        // live during the call.
        unsafe {
            message(environment, name.as_ptr(), status as i32, category.as_ptr(), words.as_ptr());
        };
    })
}

/// The folder that a `file:` URI names; `%41` and the like are decoded. A plain path is taken as it is.
fn folder_of(uri: &str) -> Result<PathBuf, CallError> {
    let path = uri.strip_prefix("file://").or_else(|| uri.strip_prefix("file:")).unwrap_or(uri);
    // A host may stand before the path; only this machine's files can be read.
    let path = path.strip_prefix("localhost").unwrap_or(path);
    let mut bytes = Vec::with_capacity(path.len());
    let mut rest = path.as_bytes();
    while let [first, tail @ ..] = rest {
        let decoded = match (first, tail) {
            (b'%', [high, low, ..]) if uri.starts_with("file:") => {
                let digits = [*high, *low];
                std::str::from_utf8(&digits).ok().and_then(|d| u8::from_str_radix(d, 16).ok())
            }
            _ => None,
        };
        bytes.push(decoded.unwrap_or(*first));
        rest = if decoded.is_some() { &tail[2..] } else { tail };
    }
    String::from_utf8(bytes).map(PathBuf::from).map_err(|_| CallError::Text { what: "fmuResourceLocation" })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetDebugLogging(
    instance: Handle,
    on: Boolean,
    _count: usize,
    _categories: *const *const c_char,
) -> i32 {
    call(instance, "fmi2SetDebugLogging", &Phase::ALL, |instance| {
        instance.logging = on != 0;
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    kind: i32,
    token: *const c_char,
    resources: *const c_char,
    callbacks: *const Callbacks,
    _visible: Boolean,
    logging: Boolean,
) -> Handle {
    // SAFETY: text and struct of the importer, which live during this call.
    let (name, callbacks) = unsafe { (text(name, "instanceName").unwrap_or(""), callbacks.as_ref()) };
    let (message, environment) =
        callbacks.map_or((None, std::ptr::null_mut()), |c| (c.logger, c.environment));
    let make = || {
        if kind != CO_SIMULATION {
            return Err(CallError::Unsupported("model exchange"));
        }
        // SAFETY: texts of the importer, which live during this call.
        let (token, location) = unsafe { (text(token, "fmuGUID")?, text(resources, "fmuResourceLocation")?) };
        let folder = folder_of(location)?;
        if !folder.is_dir() {
            let what = format!("fmuResourceLocation {location} names no folder");
            return Err(ResourceError::Parse { path: folder, what }.into());
        }
        let resources = Resources::read(&folder)?;
        Instance::new(resources, token, false, logger(name, message, environment), logging != 0)
    };
    instantiate(make, logger(name, message, environment))
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetupExperiment(
    instance: Handle,
    _tolerance_defined: Boolean,
    _tolerance: f64,
    start: f64,
    _stop_defined: Boolean,
    _stop: f64,
) -> i32 {
    call(instance, "fmi2SetupExperiment", &[Phase::Instantiated], |instance| {
        instance.start = start;
        Ok(())
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2EnterInitializationMode(instance: Handle) -> i32 {
    call(instance, "fmi2EnterInitializationMode", &[Phase::Instantiated], |instance| {
        instance.initialize(instance.start)
    })
}

#[unsafe(no_mangle)]
extern "C" fn fmi2DoStep(instance: Handle, start: f64, size: f64, _no_state_before: Boolean) -> i32 {
    call(instance, "fmi2DoStep", &[Phase::Step], |instance| instance.step(start, size))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetReal(
    instance: Handle,
    references: *const Reference,
    count: usize,
    values: *mut f64,
) -> i32 {
    call(instance, "fmi2GetReal", &Phase::ALIVE, |instance| {
        // SAFETY: arrays of the importer, of the length it says.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, array_mut(values, count, "value")?) };
        instance.read(references, false, values)
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetReal(
    instance: Handle,
    references: *const Reference,
    count: usize,
    values: *const f64,
) -> i32 {
    call(instance, "fmi2SetReal", &Phase::ALIVE, |instance| {
        // SAFETY: arrays of the importer, of the length it says.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, array(values, count, "value")?) };
        instance.write(references, false, values)
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetInteger(
    instance: Handle,
    references: *const Reference,
    count: usize,
    values: *mut i32,
) -> i32 {
    call(instance, "fmi2GetInteger", &Phase::ALIVE, |instance| {
        // SAFETY: arrays of the importer, of the length it says.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, array_mut(values, count, "value")?) };
        let mut numbers = vec![0.0; values.len()];
        instance.read(references, true, &mut numbers)?;
        values.iter_mut().zip(numbers).for_each(|(value, number)| *value = number as i32);
        Ok(())
    })
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetInteger(
    instance: Handle,
    references: *const Reference,
    count: usize,
    values: *const i32,
) -> i32 {
    call(instance, "fmi2SetInteger", &Phase::ALIVE, |instance| {
        // SAFETY: arrays of the importer, of the length it says.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, array(values, count, "value")?) };
        let numbers: Vec<f64> = values.iter().map(|&value| f64::from(value)).collect();
        instance.write(references, true, &numbers)
    })
}

/// Getters and setters of types that no variable has: nothing to read is no error.
macro_rules! other_types {
    ($($get:ident $set:ident $type:ty;)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $get(instance: Handle, references: *const Reference, count: usize, _values: *mut $type) -> i32 {
            no_variable(instance, stringify!($get), references, count)
        }
        #[unsafe(no_mangle)]
        extern "C" fn $set(instance: Handle, references: *const Reference, count: usize, _values: *const $type) -> i32 {
            no_variable(instance, stringify!($set), references, count)
        }
    )*};
}

other_types! {
    fmi2GetBoolean fmi2SetBoolean Boolean;
    fmi2GetString fmi2SetString *const c_char;
}

fn no_variable(instance: Handle, function: &'static str, references: *const Reference, count: usize) -> i32 {
    call(instance, function, &Phase::SOUND, |_| {
        // SAFETY: an array of the importer, of the length it says.
        match unsafe { array(references, count, "vr")? } {
            [] => Ok(()),
            [reference, ..] => {
                Err(CallError::Reference { reference: *reference, wanted: "variable of this type" })
            }
        }
    })
}

common_functions! {
    fmi2FreeInstance fmi2ExitInitializationMode fmi2Terminate fmi2Reset
    fmi2GetFMUstate fmi2SetFMUstate fmi2FreeFMUstate
    fmi2SerializedFMUstateSize fmi2SerializeFMUstate fmi2DeSerializeFMUstate
}

/// Functions that belong to what the unit is not.
macro_rules! unsupported {
    ($($function:ident ($($argument:ident: $type:ty),*);)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $function(instance: Handle $(, $argument: $type)*) -> i32 {
            $(let _ = $argument;)*
            call(instance, stringify!($function), &Phase::SOUND, |_| Err(CallError::Unsupported(stringify!($function))))
        }
    )*};
}

unsupported! {
    fmi2GetDirectionalDerivative(unknowns: *const Reference, unknown_count: usize, knowns: *const Reference, known_count: usize, seed: *const f64, sensitivity: *mut f64);
    fmi2SetRealInputDerivatives(references: *const Reference, count: usize, orders: *const i32, values: *const f64);
    fmi2GetRealOutputDerivatives(references: *const Reference, count: usize, orders: *const i32, values: *mut f64);
    fmi2CancelStep();
    fmi2GetStatus(kind: i32, value: *mut i32);
    fmi2GetRealStatus(kind: i32, value: *mut f64);
    fmi2GetIntegerStatus(kind: i32, value: *mut i32);
    fmi2GetBooleanStatus(kind: i32, value: *mut Boolean);
    fmi2GetStringStatus(kind: i32, value: *mut *const c_char);
    fmi2EnterEventMode();
    fmi2NewDiscreteStates(events: *mut c_void);
    fmi2EnterContinuousTimeMode();
    fmi2CompletedIntegratorStep(no_state_before: Boolean, enter_event_mode: *mut Boolean, terminate: *mut Boolean);
    fmi2SetTime(time: f64);
    fmi2SetContinuousStates(states: *const f64, count: usize);
    fmi2GetDerivatives(derivatives: *mut f64, count: usize);
    fmi2GetEventIndicators(indicators: *mut f64, count: usize);
    fmi2GetContinuousStates(states: *mut f64, count: usize);
    fmi2GetNominalsOfContinuousStates(nominals: *mut f64, count: usize);
}

#[cfg(test)]
mod tests {
    use super::folder_of;
    use std::path::Path;

    #[test]
    fn resource_locations_are_uris_of_this_machine() {
        for (uri, path) in [
            ("file:///tmp/a%20b/resources", "/tmp/a b/resources"),
            ("file:/tmp/resources", "/tmp/resources"),
            ("file://localhost/tmp/r", "/tmp/r"),
            ("/tmp/100%41", "/tmp/100%41"),
            ("file:///tmp/100%", "/tmp/100%"),
        ] {
            assert_eq!(folder_of(uri).unwrap(), Path::new(path), "{uri}");
        }
    }
}
