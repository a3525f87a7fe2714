//! What an instance of a unit can do, whatever the version of the standard.

#![expect(unsafe_code, reason = "functions of a library are found by name and called through pointers")]

use crate::Error;
use crate::description::{Type, Variable};
use interfaces::case::unit::ParameterValue;
use libloading::Library;
use std::ffi::{CStr, CString, c_char, c_void};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use words::text::{EXPLANATION, tame};

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

    /// Ends initialisation: steps can follow.
    fn exit_initialization(&mut self) -> Result<(), Error>;

    /// Sets real variables, the values of arrays one after another.
    fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error>;

    /// Reads real variables, the values of arrays one after another.
    fn get(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error>;

    /// Reads a scalar that is a number or a switch.
    fn number(&mut self, variable: &Variable) -> Result<f64, Error>;

    /// Steps from `start` over `size` (s).
    fn step(&mut self, start: f64, size: f64) -> Result<Stepped, Error>;

    /// Keeps the present state, in place of one kept before.
    fn keep(&mut self) -> Result<(), Error>;

    /// Goes back to the state kept.
    fn go_back(&mut self) -> Result<(), Error>;

    /// The state kept, as bytes.
    fn serialize(&mut self) -> Result<Vec<u8>, Error>;

    /// Keeps the state of these bytes.
    fn deserialize(&mut self, bytes: &[u8]) -> Result<(), Error>;

    /// Ends in order.
    fn terminate(&mut self) -> Result<(), Error>;
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
    pub fn check(&self, function: &'static str, status: i32) -> Result<(), Error> {
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
    pub fn error(&self, function: &'static str, status: &'static str) -> Error {
        let words = self.heard.lock().map(|mut words| std::mem::take(&mut *words)).unwrap_or_default();
        Error::Call { file: self.file.clone(), function, status, words }
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
