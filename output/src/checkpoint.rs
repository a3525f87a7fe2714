//! A checkpoint: the state of a run in one file, in named parts with checksums.
//!
//! ```text
//! mnscckp1 │ part │ part │ … │ end
//! part: length of its name (u32), name, length of its bytes (u64), bytes, CRC-32 of all that (u32)
//! end:  a part named `end`, whose bytes are the number of bytes before it (u64)
//! ```
//!
//! All numbers are little endian. The file is written beside as `.NAME.partial`, forced to the disk, renamed,
//! and the folder forced to the disk: under its name it is whole, whenever the process is killed or the power
//! fails. It is checked from end to end before anything of it is used, through a buffer of fixed size; of a
//! part as many bytes are reserved as the file was found to have.

use crate::error::{Result, parse_error, read_error, write_error};
use crate::{atomic, files};
use crc32fast::Hasher;
use std::fs::{self, File};
use std::io::{self, BufReader, Read, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// First bytes of the file; the last is the version of its layout.
const MAGIC: &[u8; 8] = b"mnscckp1";
/// Name of the last part.
const END: &str = "end";
/// Longest name of a part (bytes).
const LONGEST_NAME: usize = 64;
/// Bytes that are looked at in one go.
const PIECE: usize = 1 << 18;

/// A checkpoint being written. Dropped before [`finish`](Self::finish), it leaves nothing.
#[derive(Debug)]
pub struct Writing {
    path: PathBuf,
    partial: PathBuf,
    /// Nothing once it is finished.
    file: Option<File>,
    written: u64,
}

impl Writing {
    /// Begins the file that will be `path`, in a folder that is there.
    ///
    /// # Errors
    /// [`crate::Error::Write`] if it cannot be made.
    pub fn begin(path: &Path) -> Result<Self> {
        let partial = atomic::partial_path(path);
        let file = files::create(&partial).map_err(write_error(path))?;
        let mut writing = Self { path: path.to_owned(), partial, file: Some(file), written: 0 };
        writing.put(MAGIC)?;
        Ok(writing)
    }

    /// Adds a part.
    ///
    /// # Errors
    /// [`crate::Error::Write`] if the disk is full.
    pub fn part(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        let mut head = Vec::with_capacity(12 + name.len());
        head.extend((name.len() as u32).to_le_bytes());
        head.extend(name.as_bytes());
        head.extend((bytes.len() as u64).to_le_bytes());
        let mut sum = Hasher::new();
        sum.update(&head);
        sum.update(bytes);
        self.put(&head)?;
        self.put(bytes)?;
        self.put(&sum.finalize().to_le_bytes())
    }

    /// Ends the file, forces it to the disk and gives it its name. Gives its length (bytes).
    ///
    /// # Errors
    /// [`crate::Error::Write`] if the disk is full or failed; nothing bears its name then.
    pub fn finish(mut self) -> Result<u64> {
        self.part(END, &self.written.to_le_bytes())?;
        let file = self.file.take().expect("it is taken here alone");
        let folder = self.path.parent().unwrap_or(Path::new("."));
        let named = file.sync_all().and_then(|()| fs::rename(&self.partial, &self.path));
        let named = named.and_then(|()| File::open(folder)?.sync_all());
        named.map_err(|source| {
            // The error that counts is the first.
            let _ = fs::remove_file(&self.partial);
            write_error(&self.path)(source)
        })?;
        Ok(self.written)
    }

    fn put(&mut self, bytes: &[u8]) -> Result<()> {
        let file = self.file.as_mut().expect("parts come before the end");
        file.write_all(bytes).map_err(write_error(&self.path))?;
        self.written += bytes.len() as u64;
        Ok(())
    }
}

impl Drop for Writing {
    fn drop(&mut self) {
        if self.file.take().is_some() {
            // What cannot be removed now, the next checkpoint removes.
            let _ = fs::remove_file(&self.partial);
        }
    }
}

/// A checkpoint that was found whole.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    file: File,
    parts: Vec<Part>,
}

#[derive(Debug)]
struct Part {
    name: String,
    /// Byte of the file at which its bytes begin.
    at: u64,
    length: u64,
    /// Checksum of its bytes alone.
    sum: u32,
}

impl Checkpoint {
    /// Opens the file and checks it from end to end.
    ///
    /// # Errors
    /// [`crate::Error::Read`] if it cannot be read, [`crate::Error::Parse`] with the place if it is no whole
    /// checkpoint of this version.
    pub fn open(path: &Path) -> Result<Self> {
        let file = files::open(path, u64::MAX).map_err(read_error(path))?;
        let length = file.metadata().map_err(read_error(path))?.len();
        let mut scan = Scan { path, input: BufReader::with_capacity(PIECE, &file), at: 0, length };
        let parts = scan.parts()?;
        Ok(Self { path: path.to_owned(), file, parts })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The bytes of a part.
    ///
    /// # Errors
    /// [`crate::Error::Parse`] if there is no such part, or it has changed since the file was opened;
    /// [`crate::Error::Read`].
    pub fn part(&mut self, name: &str) -> Result<Vec<u8>> {
        let Some(part) = self.parts.iter().find(|part| part.name == name) else {
            return Err(parse_error(&self.path, format!("it has no part `{name}`")));
        };
        let mut bytes = Vec::new();
        let length = usize::try_from(part.length).unwrap_or(usize::MAX);
        if bytes.try_reserve_exact(length).is_err() {
            let what = format!("its part `{name}` has {length} bytes, more than there is memory for");
            return Err(parse_error(&self.path, what));
        }
        let read = self.file.seek(SeekFrom::Start(part.at));
        let read = read.and_then(|_| Read::by_ref(&mut self.file).take(part.length).read_to_end(&mut bytes));
        read.map_err(read_error(&self.path))?;
        if bytes.len() != length || crc32fast::hash(&bytes) != part.sum {
            return Err(parse_error(&self.path, format!("its part `{name}` has just changed")));
        }
        Ok(bytes)
    }
}

/// A file on the way from its start to its end.
struct Scan<'a> {
    path: &'a Path,
    input: BufReader<&'a File>,
    at: u64,
    length: u64,
}

impl Scan<'_> {
    fn parts(&mut self) -> Result<Vec<Part>> {
        let magic: [u8; 8] = self.array()?;
        if magic[..7] != MAGIC[..7] {
            return Err(self.refuse("it is no checkpoint: it starts otherwise"));
        }
        if magic != *MAGIC {
            let (found, read) = (magic[7].escape_ascii(), char::from(MAGIC[7]));
            return Err(self.refuse(format!("its layout is of version {found}, and {read} is read")));
        }
        let mut parts = Vec::new();
        loop {
            let before = self.at;
            let (part, first) = self.part()?;
            if part.name != END {
                parts.push(part);
                continue;
            }
            return match (u64::from_le_bytes(first) == before && part.length == 8, self.length - self.at) {
                (true, 0) => Ok(parts),
                (true, more) => Err(self.refuse(format!("it goes on for {more} bytes after its end"))),
                (false, _) => Err(self.refuse("parts of it are missing")),
            };
        }
    }

    /// The next part, and its first bytes.
    fn part(&mut self) -> Result<(Part, [u8; 8])> {
        let mut sum = Hasher::new();
        let name_length = u32::from_le_bytes(self.array()?);
        let length_of_name = name_length as usize;
        if length_of_name > LONGEST_NAME {
            return Err(self.refuse(format!("a part's name has {length_of_name} bytes")));
        }
        let mut name = [0; LONGEST_NAME];
        self.fill(&mut name[..length_of_name])?;
        let name = &name[..length_of_name];
        let length = u64::from_le_bytes(self.array()?);
        sum.update(&name_length.to_le_bytes());
        sum.update(name);
        sum.update(&length.to_le_bytes());
        let name = String::from_utf8_lossy(name).into_owned();
        if length > self.length - self.at {
            let left = self.length - self.at;
            return Err(self.refuse(format!("its part `{name}` has {length} bytes, and {left} are left")));
        }
        let (at, mut own, mut left) = (self.at, Hasher::new(), length);
        let mut piece = vec![0; PIECE.min(usize::try_from(length).unwrap_or(PIECE))];
        let mut first = [0; 8];
        while left > 0 {
            let next = piece.len().min(usize::try_from(left).unwrap_or(PIECE));
            self.fill(&mut piece[..next])?;
            own.update(&piece[..next]);
            if left == length {
                let known = next.min(first.len());
                first[..known].copy_from_slice(&piece[..known]);
            }
            left -= next as u64;
        }
        sum.combine(&own);
        if u32::from_le_bytes(self.array()?) != sum.finalize() {
            return Err(self.refuse(format!("the checksum of its part `{name}` is not that of its bytes")));
        }
        Ok((Part { name, at, length, sum: own.finalize() }, first))
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<()> {
        match self.input.read_exact(bytes) {
            Ok(()) => {
                self.at += bytes.len() as u64;
                Ok(())
            }
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Err(self.refuse("it is cut off")),
            Err(error) => Err(read_error(self.path)(error)),
        }
    }

    fn refuse(&self, what: impl Into<String>) -> crate::Error {
        parse_error(self.path, format!("{} (at byte {} of {})", what.into(), self.at, self.length))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(path: &Path) -> Vec<u8> {
        let mut writing = Writing::begin(path).unwrap();
        writing.part("header", b"{}").unwrap();
        writing.part("fluid", &[7; 1000]).unwrap();
        writing.part("empty", &[]).unwrap();
        let length = writing.finish().unwrap();
        let bytes = fs::read(path).unwrap();
        assert_eq!(bytes.len() as u64, length);
        bytes
    }

    #[test]
    fn parts_come_back_and_nothing_else_stays() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.checkpoint");
        write(&path);
        let mut read = Checkpoint::open(&path).unwrap();
        assert_eq!(read.part("fluid").unwrap(), [7; 1000]);
        assert_eq!(
            (read.part("header").unwrap().as_slice(), read.part("empty").unwrap().len()),
            (&b"{}"[..], 0)
        );
        assert!(read.part("structure").unwrap_err().to_string().contains("no part `structure`"));
        drop(Writing::begin(&dir.path().join("b.checkpoint")).unwrap());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1, "one given up leaves nothing");
    }

    #[test]
    fn every_cut_and_every_flipped_bit_is_found() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.checkpoint");
        let whole = write(&path);
        for length in 0..whole.len() {
            fs::write(&path, &whole[..length]).unwrap();
            assert!(Checkpoint::open(&path).is_err(), "{length} bytes");
        }
        for bit in 0..8 * whole.len() {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            fs::write(&path, &bytes).unwrap();
            assert!(Checkpoint::open(&path).is_err(), "bit {bit}");
        }
        fs::write(&path, [&whole[..], &[0]].concat()).unwrap();
        assert!(Checkpoint::open(&path).unwrap_err().to_string().contains("after its end"));
        let mut other = whole;
        other[7] = b'2';
        fs::write(&path, &other).unwrap();
        let error = Checkpoint::open(&path).unwrap_err().to_string();
        assert!(error.contains("a.checkpoint") && error.contains("version 2, and 1 is read"), "{error}");
    }
}
