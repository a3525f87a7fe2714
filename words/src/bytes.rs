//! States as bytes: what a participant or the coupler saves, and reads again without trusting it.
//!
//! A state is a magic of eight bytes, the last of which is the version of its layout, then its fields one
//! after another, little endian, lists with their count before them. [`Writer`] and [`Reader`] name the same
//! fields in the same order:
//!
//! ```
//! use words::bytes::{Error, Reader, Writer};
//!
//! const MAGIC: &[u8; 8] = b"mnscexa1";
//!
//! fn to_bytes(time: f64, pressures: &[f64]) -> Vec<u8> {
//!     let mut state = Writer::new(MAGIC);
//!     state.f64(time);
//!     state.f64s(pressures);
//!     state.finish()
//! }
//!
//! fn from_bytes(bytes: &[u8], particles: usize) -> Result<(f64, Vec<f64>), Error> {
//!     let mut state = Reader::new("example's state", MAGIC, bytes)?;
//!     let time = state.f64("time")?;
//!     let pressures = state.f64s("pressures", Some(particles))?;
//!     state.finish()?;
//!     Ok((time, pressures))
//! }
//!
//! assert_eq!(from_bytes(&to_bytes(0.5, &[1.0, -0.0]), 2), Ok((0.5, vec![1.0, -0.0])));
//! let refused = from_bytes(&to_bytes(0.5, &[1.0]), 2).unwrap_err();
//! assert_eq!(refused.to_string(), "the example's state holds 1 pressures at byte 16, where 2 belong");
//! ```
//!
//! A reader holds each count against the bytes that are left, and against the count that the caller expects,
//! before anything is reserved for it; numbers come back to the bit.

/// Why bytes are refused as a state.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the {state} {problem}")]
pub struct Error {
    /// Which state was read, e.g. `fluid's state`.
    pub state: &'static str,
    /// What is wrong with its bytes, and where.
    pub problem: Problem,
}

/// What is wrong with the bytes of a state, and where: `at` is the byte at which the field starts, a list's
/// field with its count.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Problem {
    /// They are not such a state.
    #[error("does not start with {expected:?}")]
    Magic { expected: String },
    /// They are such a state of another version of the program.
    #[error("is of version {found}, where {expected} is read")]
    Version { found: char, expected: char },
    /// They end too early.
    #[error("is cut off: its {field} at byte {at} needs {needed} bytes, and {left} are left")]
    Cut { field: &'static str, at: usize, needed: usize, left: usize },
    /// There are not as many entries as the rest of the case has.
    #[error("holds {found} {field} at byte {at}, where {expected} belong")]
    Count { field: &'static str, at: usize, found: u64, expected: usize },
    /// An entry is none that there could be.
    #[error("holds {found} at byte {at}, which its {field} cannot be")]
    Value { field: &'static str, at: usize, found: String },
    /// They go on after the state's end.
    #[error("goes on for {left} bytes after its end at byte {at}")]
    Trailing { at: usize, left: usize },
}

/// Bytes of a state in the making. What each function writes, the function of [`Reader`] with the same name
/// reads.
#[derive(Clone, Debug)]
pub struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    /// A state that starts with this magic, whose last byte is the version of its layout.
    pub fn new(magic: &[u8; 8]) -> Self {
        Self { bytes: magic.to_vec() }
    }

    /// A byte.
    pub fn u8(&mut self, value: u8) {
        self.bytes.push(value);
    }

    /// A flag.
    pub fn bool(&mut self, value: bool) {
        self.u8(u8::from(value));
    }

    /// A number of 32 bits.
    pub fn u32(&mut self, value: u32) {
        self.bytes.extend(value.to_le_bytes());
    }

    /// A number of 64 bits.
    pub fn u64(&mut self, value: u64) {
        self.bytes.extend(value.to_le_bytes());
    }

    /// A number of this machine's width, as one of 64 bits.
    pub fn usize(&mut self, value: usize) {
        self.u64(value as u64);
    }

    /// A double, to the bit.
    pub fn f64(&mut self, value: f64) {
        self.u64(value.to_bits());
    }

    /// Bytes, a nested state for instance.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.usize(bytes.len());
        self.bytes.extend(bytes);
    }

    /// A text.
    pub fn text(&mut self, text: &str) {
        self.bytes(text.as_bytes());
    }

    /// Numbers of 32 bits.
    pub fn u32s(&mut self, values: &[u32]) {
        self.list(values, |state, value| state.u32(*value));
    }

    /// Doubles.
    pub fn f64s(&mut self, values: &[f64]) {
        self.list(values, |state, value| state.f64(*value));
    }

    /// Vectors of `D` components.
    pub fn vectors<const D: usize, V: Copy + Into<[f64; D]>>(&mut self, vectors: &[V]) {
        self.list(vectors, |state, vector| (*vector).into().iter().for_each(|x| state.f64(*x)));
    }

    /// A list, each of whose entries takes at least one byte.
    pub fn list<T>(&mut self, list: &[T], mut entry: impl FnMut(&mut Self, &T)) {
        self.usize(list.len());
        self.bytes.reserve(size_of_val(list));
        list.iter().for_each(|value| entry(self, value));
    }

    /// What there may be or not.
    pub fn option<T>(&mut self, value: Option<&T>, some: impl FnOnce(&mut Self, &T)) {
        self.bool(value.is_some());
        if let Some(value) = value {
            some(self, value);
        }
    }

    /// The state's bytes.
    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }
}

/// Bytes that should be a state. Each function takes the name of the field that it reads, for the message
/// when it is not there.
///
/// # Errors
/// Each function returns [`Error`] where the bytes end before the field does, or where the field is none
/// that it could be; nothing has been reserved for it then.
#[derive(Clone, Debug)]
pub struct Reader<'a> {
    state: &'static str,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    /// Reads the bytes of `state` (`fluid's state`, say), which starts with this magic.
    ///
    /// # Errors
    /// [`Error`] where they start otherwise.
    pub fn new(state: &'static str, magic: &[u8; 8], bytes: &'a [u8]) -> Result<Self, Error> {
        let mut reader = Self { state, bytes, at: 0 };
        let (kind, version) = (&magic[..7], char::from(magic[7]));
        match bytes.split_first_chunk::<8>() {
            Some((found, _)) if found == magic => {
                reader.at = magic.len();
                Ok(reader)
            }
            Some((found, _)) if found.starts_with(kind) => {
                Err(reader.error(Problem::Version { found: char::from(found[7]), expected: version }))
            }
            _ => Err(reader.error(Problem::Magic { expected: String::from_utf8_lossy(magic).into_owned() })),
        }
    }

    /// A byte.
    pub fn u8(&mut self, field: &'static str) -> Result<u8, Error> {
        self.array::<1>(field).map(|[byte]| byte)
    }

    /// A flag.
    pub fn bool(&mut self, field: &'static str) -> Result<bool, Error> {
        self.tag(field, |byte| [false, true].get(usize::from(byte)).copied())
    }

    /// What a byte stands for, by `meaning`: an enum's variant.
    pub fn tag<T>(&mut self, field: &'static str, meaning: impl FnOnce(u8) -> Option<T>) -> Result<T, Error> {
        let byte = self.u8(field)?;
        meaning(byte).ok_or_else(|| self.refused(field, self.at - 1, byte.to_string()))
    }

    /// A number of 32 bits.
    pub fn u32(&mut self, field: &'static str) -> Result<u32, Error> {
        self.array(field).map(u32::from_le_bytes)
    }

    /// A number of 64 bits.
    pub fn u64(&mut self, field: &'static str) -> Result<u64, Error> {
        self.array(field).map(u64::from_le_bytes)
    }

    /// A number of this machine's width. It bounds nothing: for counts of what follows there are the lists.
    pub fn usize(&mut self, field: &'static str) -> Result<usize, Error> {
        let number = self.u64(field)?;
        usize::try_from(number).map_err(|_| self.refused(field, self.at - 8, number.to_string()))
    }

    /// A double.
    pub fn f64(&mut self, field: &'static str) -> Result<f64, Error> {
        self.u64(field).map(f64::from_bits)
    }

    /// Bytes, a nested state for instance.
    pub fn bytes(&mut self, field: &'static str) -> Result<&'a [u8], Error> {
        let count = self.count(field, 1, None)?;
        self.take(field, count)
    }

    /// A text.
    pub fn text(&mut self, field: &'static str) -> Result<&'a str, Error> {
        let at = self.at;
        let bytes = self.bytes(field)?;
        std::str::from_utf8(bytes).map_err(|_| self.refused(field, at, "no UTF-8"))
    }

    /// Numbers of 32 bits, `expected` of them where that is known.
    pub fn u32s(&mut self, field: &'static str, expected: Option<usize>) -> Result<Vec<u32>, Error> {
        self.words(field, expected, u32::from_le_bytes)
    }

    /// Doubles, `expected` of them where that is known.
    pub fn f64s(&mut self, field: &'static str, expected: Option<usize>) -> Result<Vec<f64>, Error> {
        self.words(field, expected, f64::from_le_bytes)
    }

    /// Vectors of `D` components, `expected` of them where that is known.
    pub fn vectors<const D: usize, V: From<[f64; D]>>(
        &mut self,
        field: &'static str,
        expected: Option<usize>,
    ) -> Result<Vec<V>, Error> {
        let count = self.count(field, 8 * D, expected)?;
        let components = self.take(field, 8 * D * count)?.as_chunks::<8>().0;
        let vector = |words: &[[u8; 8]]| V::from(std::array::from_fn(|i| f64::from_le_bytes(words[i])));
        Ok(components.chunks_exact(D).map(vector).collect())
    }

    /// A list, `expected` entries of it where that is known, each of which takes at least one byte.
    pub fn list<T>(
        &mut self,
        field: &'static str,
        expected: Option<usize>,
        mut entry: impl FnMut(&mut Self) -> Result<T, Error>,
    ) -> Result<Vec<T>, Error> {
        let count = self.count(field, 1, expected)?;
        (0..count).map(|_| entry(self)).collect()
    }

    /// What there may be or not.
    pub fn option<T>(
        &mut self,
        field: &'static str,
        some: impl FnOnce(&mut Self) -> Result<T, Error>,
    ) -> Result<Option<T>, Error> {
        if self.bool(field)? { some(self).map(Some) } else { Ok(None) }
    }

    /// The state is read.
    ///
    /// # Errors
    /// [`Error`] where bytes are left.
    pub fn finish(self) -> Result<(), Error> {
        match self.left() {
            0 => Ok(()),
            left => Err(self.error(Problem::Trailing { at: self.at, left })),
        }
    }

    /// The error for a field that has been read whole and holds what this state cannot have; it names the
    /// byte up to which was read.
    pub fn refuse(&self, field: &'static str, found: impl Into<String>) -> Error {
        self.refused(field, self.at, found)
    }

    fn refused(&self, field: &'static str, at: usize, found: impl Into<String>) -> Error {
        self.error(Problem::Value { field, at, found: found.into() })
    }

    fn error(&self, problem: Problem) -> Error {
        Error { state: self.state, problem }
    }

    fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// A count of entries of so many bytes each, which the bytes left hold.
    fn count(&mut self, field: &'static str, size: usize, expected: Option<usize>) -> Result<usize, Error> {
        let at = self.at;
        let found = self.u64(field)?;
        let count = usize::try_from(found).unwrap_or(usize::MAX);
        if let Some(expected) = expected.filter(|expected| *expected != count) {
            return Err(self.error(Problem::Count { field, at, found, expected }));
        }
        let needed = count.saturating_mul(size);
        let left = self.left();
        if needed > left {
            return Err(self.error(Problem::Cut { field, at, needed, left }));
        }
        Ok(count)
    }

    fn words<const N: usize, T>(
        &mut self,
        field: &'static str,
        expected: Option<usize>,
        word: impl Fn([u8; N]) -> T,
    ) -> Result<Vec<T>, Error> {
        let count = self.count(field, N, expected)?;
        Ok(self.take(field, N * count)?.as_chunks::<N>().0.iter().map(|bytes| word(*bytes)).collect())
    }

    fn array<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], Error> {
        let bytes = self.take(field, N)?;
        Ok(bytes.try_into().expect("as many bytes were taken"))
    }

    fn take(&mut self, field: &'static str, needed: usize) -> Result<&'a [u8], Error> {
        let (at, left) = (self.at, self.left());
        if needed > left {
            return Err(self.error(Problem::Cut { field, at, needed, left }));
        }
        self.at += needed;
        Ok(&self.bytes[at..self.at])
    }
}

#[cfg(test)]
mod tests;
