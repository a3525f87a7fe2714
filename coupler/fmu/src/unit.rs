//! What an instance of a unit can do, whatever the version of the standard.

#![expect(unsafe_code, reason = "functions of a library are found by name and called through pointers")]

use crate::Error;
use crate::description::{Description, Type, Variable, Version};
use interfaces::case::unit::ParameterValue;
use libloading::Library;
use std::ffi::{CStr, CString, c_char, c_void};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use words::text::{EXPLANATION, tame};

/// Bytes of a unit's state at most.
const MOST_BYTES: usize = 4 << 30;

/// An instance. Calls follow the standards' order; an instance that answered with an error is only dropped.
pub trait Instance {
    /// Sets parameters, structural ones first, and goes to initialisation at `start` (s).
    ///
    /// # Errors
    /// As every call here: what the unit answers, and its last words.
    fn enter_initialization(
        &mut self,
        parameters: &[(Variable, ParameterValue)],
        start: f64,
    ) -> Result<(), Error>;

    /// What it has in common with instances of the other version.
    fn common(&mut self) -> &mut Common;

    /// Ends initialisation: steps can follow.
    fn exit_initialization(&mut self) -> Result<(), Error> {
        let common = self.common();
        common.call("ExitInitializationMode")
    }

    /// Sets real variables, the values of arrays one after another.
    fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error>;

    /// Reads real variables, the values of arrays one after another.
    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error>;

    /// Reads a scalar that is a number or a switch.
    fn number(&mut self, variable: &Variable) -> Result<f64, Error>;

    /// Steps from `start` over `size` (s).
    fn step(&mut self, start: f64, size: f64) -> Result<Stepped, Error>;

    /// Keeps the present state, in place of one kept before.
    fn keep(&mut self) -> Result<(), Error> {
        let common = self.common();
        let get: unsafe extern "C" fn(Handle, *mut State) -> i32 = common.function("GetFMUState")?;
        // SAFETY: the state is null or one of this instance's, which the function may use again.
        let status = unsafe { get(common.handle, &raw mut common.state) };
        common.check("GetFMUState", status)
    }

    /// Goes back to the state kept.
    fn go_back(&mut self) -> Result<(), Error> {
        let common = self.common();
        let set: unsafe extern "C" fn(Handle, State) -> i32 = common.function("SetFMUState")?;
        // SAFETY: a state of this instance's.
        common.check("SetFMUState", unsafe { set(common.handle, common.state) })
    }

    /// The state kept, as bytes.
    fn serialize(&mut self) -> Result<Vec<u8>, Error> {
        type Size = unsafe extern "C" fn(Handle, State, *mut usize) -> i32;
        type Serialize = unsafe extern "C" fn(Handle, State, *mut u8, usize) -> i32;
        let common = self.common();
        let Common { handle, state, .. } = *common;
        let size_of: Size = common.function("SerializedFMUStateSize")?;
        let serialize: Serialize = common.function("SerializeFMUState")?;
        let mut size = 0;
        // SAFETY: a state of this instance's, then memory of the size that was asked for.
        common.check("SerializedFMUStateSize", unsafe { size_of(handle, state, &raw mut size) })?;
        if size > MOST_BYTES {
            let what = format!("its state has {size} bytes, and {MOST_BYTES} are kept at most");
            return Err(common.teller.incapable(&what));
        }
        let mut bytes = vec![0; size];
        // SAFETY: as above.
        common.check("SerializeFMUState", unsafe { serialize(handle, state, bytes.as_mut_ptr(), size) })?;
        Ok(bytes)
    }

    /// Keeps the state of these bytes.
    fn deserialize(&mut self, bytes: &[u8]) -> Result<(), Error> {
        type Deserialize = unsafe extern "C" fn(Handle, *const u8, usize, *mut State) -> i32;
        let common = self.common();
        let deserialize: Deserialize = common.function("DeserializeFMUState")?;
        // SAFETY: pointer and length of the same slice; the state as in `keep`.
        let status =
            unsafe { deserialize(common.handle, bytes.as_ptr(), bytes.len(), &raw mut common.state) };
        common.check("DeserializeFMUState", status)
    }

    /// Ends in order.
    fn terminate(&mut self) -> Result<(), Error> {
        let common = self.common();
        common.call("Terminate")
    }
}

/// The unit's own pointer to an instance.
pub(crate) type Handle = *mut c_void;
/// The unit's own pointer to a state.
pub(crate) type State = *mut c_void;
/// A function that takes an instance and nothing else.
type Plain = unsafe extern "C" fn(Handle) -> i32;

/// What instances of both versions have: the instance itself, the state kept (or null), and where functions
/// are found. It gives the unit both back when it is dropped.
pub struct Common {
    pub(crate) handle: Handle,
    pub(crate) state: State,
    pub(crate) version: Version,
    pub(crate) library: &'static Library,
    pub(crate) teller: Teller,
}

impl Common {
    /// A function's name, from that which is its own in FMI 3.0.
    fn name(&self, own: &str) -> String {
        match self.version {
            Version::Fmi3 => format!("fmi3{own}"),
            Version::Fmi2 => {
                let own = own.replace("FMUState", "FMUstate").replace("Deserialize", "DeSerialize");
                format!("fmi2{own}")
            }
        }
    }

    /// The function of that name. Its callers take the type from the standard's header.
    pub(crate) fn function<F: Copy>(&self, own: &str) -> Result<F, Error> {
        // SAFETY: as said.
        unsafe { self.teller.function(self.library, &self.name(own)) }
    }

    /// An error unless the function went well.
    pub(crate) fn check(&self, own: &str, status: i32) -> Result<(), Error> {
        if status == 0 { Ok(()) } else { self.teller.check(&self.name(own), status) }
    }

    /// Calls a function that takes nothing but the instance.
    pub(crate) fn call(&self, own: &str) -> Result<(), Error> {
        let function: Plain = self.function(own)?;
        // SAFETY: a function of the standard with an instance that lives.
        self.check(own, unsafe { function(self.handle) })
    }

    /// Refuses a unit that lacks a function that it needs, or one for what it says that it can.
    pub(crate) fn require(&self, description: &Description) -> Result<(), Error> {
        let groups: [(bool, &[&str]); 3] = [
            (true, &["FreeInstance", "ExitInitializationMode", "Terminate"]),
            (description.keeps_state, &["GetFMUState", "SetFMUState", "FreeFMUState"]),
            (
                description.serializes_state,
                &["SerializedFMUStateSize", "SerializeFMUState", "DeserializeFMUState"],
            ),
        ];
        let needed = groups.into_iter().filter(|(can, _)| *can).flat_map(|(_, functions)| functions);
        needed.into_iter().try_for_each(|own| self.function::<Plain>(own).map(|_| ()))
    }
}

impl Drop for Common {
    fn drop(&mut self) {
        let free_state: Result<unsafe extern "C" fn(Handle, *mut State) -> i32, _> =
            self.function("FreeFMUState");
        let free: Result<unsafe extern "C" fn(Handle), _> = self.function("FreeInstance");
        // SAFETY: the state and the instance are given back once, and not used again.
        unsafe {
            if let (false, Ok(free_state)) = (self.state.is_null(), free_state) {
                free_state(self.handle, &raw mut self.state);
            }
            if let Ok(free) = free {
                free(self.handle);
            }
        }
    }
}

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stepped {
    /// The unit goes on.
    On,
    /// The unit asks for the end of the run.
    EndRequested,
}

/// Hears what a unit says, and makes errors of its answers.
pub(crate) struct Teller {
    file: PathBuf,
    /// Given to the library as the logger's environment: it stays where it is.
    heard: Box<Heard>,
}

/// The last message of the logger.
pub(crate) type Heard = Mutex<String>;

impl Teller {
    pub fn new(file: &Path) -> Self {
        Self { file: file.to_owned(), heard: Box::new(Mutex::new(String::new())) }
    }

    /// The environment for the unit's logger.
    pub fn environment(&self) -> *mut c_void {
        std::ptr::from_ref::<Heard>(&self.heard).cast_mut().cast()
    }

    /// An error unless the status is OK or a warning, which the standards number alike.
    pub fn check(&self, function: &str, status: i32) -> Result<(), Error> {
        let status = match status {
            0 | 1 => return Ok(()),
            2 => "Discard",
            3 => "Error",
            4 => "Fatal",
            5 => "Pending: it works on its own, and steps that end later are not supported",
            _ => "a status that the standard does not know",
        };
        Err(self.error(function, status))
    }

    /// The error of a function that answered so.
    pub fn error(&self, function: &str, status: &'static str) -> Error {
        let words = self.heard.lock().map(|mut words| std::mem::take(&mut *words)).unwrap_or_default();
        Error::Call { file: self.file.clone(), function: function.to_owned(), status, words }
    }

    /// What the unit cannot do.
    pub fn incapable(&self, what: &str) -> Error {
        Error::Incapable { file: self.file.clone(), what: what.to_owned() }
    }

    /// The function of that name and type.
    ///
    /// # Safety
    /// `F` is a function pointer of the type that the standard gives the function.
    pub unsafe fn function<F: Copy>(&self, library: &'static Library, name: &str) -> Result<F, Error> {
        // SAFETY: the caller's promise.
        let symbol = unsafe { library.get::<F>(name.as_bytes()) };
        symbol
            .map(|symbol| *symbol)
            .map_err(|error| Error::Library { file: self.file.clone(), what: reason(&error) })
    }
}

/// What went wrong with a library, and what the system said of it.
pub(crate) fn reason(error: &libloading::Error) -> String {
    match std::error::Error::source(error) {
        Some(source) if !error.to_string().contains(&source.to_string()) => format!("{error}: {source}"),
        _ => error.to_string(),
    }
}

/// Prints what the unit says, which ends in the participant's log, and remembers it.
///
/// # Safety
/// `environment` is a [`Teller::environment`] whose teller lives, or null; `message` ends with a zero, or is
/// null.
pub(crate) unsafe fn hear(environment: *mut c_void, status: i32, message: *const c_char) {
    if message.is_null() {
        return;
    }
    // SAFETY: the caller's promise.
    let words = tame(&unsafe { CStr::from_ptr(message) }.to_string_lossy(), EXPLANATION);
    eprintln!("unit: {words}");
    if environment.is_null() {
        return;
    }
    // SAFETY: the caller's promise.
    let heard = unsafe { &*environment.cast::<Heard>() };
    if let (true, Ok(mut last)) = (status > 0, heard.lock()) {
        *last = words;
    }
}

/// Text for C. One with a zero inside is cut there.
pub(crate) fn c_text(text: &str) -> CString {
    let whole = text.split('\0').next().unwrap_or_default();
    CString::new(whole).expect("it was cut at its first zero")
}

/// The numbers of a parameter's value; none of a text.
pub(crate) fn numbers(value: &ParameterValue) -> Vec<f64> {
    match value {
        ParameterValue::Boolean(switch) => vec![f64::from(u8::from(*switch))],
        ParameterValue::Number(number) => vec![*number],
        ParameterValue::Numbers(numbers) => numbers.clone(),
        ParameterValue::Text(_) => Vec::new(),
    }
}

/// Said of a type where the wiring should have refused it.
pub(crate) fn not_wired(teller: &Teller, kind: Type) -> Error {
    teller.incapable(&format!("has a variable of type {kind:?} where there should be none"))
}
