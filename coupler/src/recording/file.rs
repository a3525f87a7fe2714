//! The file: blocks with checksums, one after another.
//!
//! ```text
//! mnscrec1 │ header │ block │ block │ … │ end
//! each of them: kind (u8) │ bytes in the file (u32) │ bytes unpacked (u32) │ bytes │ CRC-32 of all that (u32)
//! ```
//!
//! Numbers are little endian, bytes packed by DEFLATE (RFC 1951). A block is handed to the operating system
//! whole: of a run that was killed the file ends with a whole block or within one, and all whole ones are
//! read. A reader holds a block's length against what the file has left before it reserves that, and unpacks
//! no more than the block says it holds.

use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use output::files;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, BufReader, Read, Write as _};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// First bytes of the file; the last is the version of its layout.
const MAGIC: &[u8; 8] = b"mnscrec1";
/// Kinds of blocks.
const HEADER: u8 = 0;
const ENTRIES: u8 = 1;
const END: u8 = 2;
/// Bytes of a block besides its own.
const FRAME: usize = 13;
/// Bytes of a block unpacked at most: a call with 33 million doubles.
pub const MOST_UNPACKED: usize = 256 << 20;
/// Room that is kept for the end of the file (bytes).
const ROOM_FOR_END: u64 = 4 << 10;
/// DEFLATE's level: of the coarse gate 1 wrote 5 % more, and 6 wrote 1 % less.
const LEVEL: u32 = 3;

/// A recording that cannot be written or read.
#[derive(Debug, Error)]
#[error("failed to {doing} the recording {}: {what}", .path.display())]
pub struct Error {
    /// `write` or `read`.
    pub doing: &'static str,
    /// The file.
    pub path: PathBuf,
    /// What is wrong, where, and what can be done.
    pub what: String,
}

/// What the file says of its run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Version of meniscus that recorded.
    pub version: String,
    /// Hash of the case.
    pub case_hash: String,
    /// The case as resolved, TOML.
    pub case: String,
}

/// Why there are no more entries.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct End {
    /// Why the recording ended before its run, where it did.
    pub early: Option<String>,
}

/// A recording being written.
#[derive(Debug)]
pub struct Writing {
    path: PathBuf,
    file: File,
    limit: u64,
    /// Bytes so far.
    pub bytes: u64,
    /// Blocks of entries so far.
    pub blocks: u64,
}

impl Writing {
    /// Makes the file, of at most `limit` bytes.
    ///
    /// # Errors
    /// One that is there already, a folder that is not, a full disk.
    pub fn create(path: &Path, header: &Header, limit: u64) -> Result<Self, Error> {
        let error = |what: String| Error { doing: "write", path: path.to_owned(), what };
        if std::fs::symlink_metadata(path).is_ok() {
            return Err(error("it is there already; remove it, or give another name".to_owned()));
        }
        let file = files::create(path).map_err(|source| error(source.to_string()))?;
        let mut writing = Self { path: path.to_owned(), file, limit, bytes: 0, blocks: 0 };
        let header = serde_json::to_vec(header).map_err(|source| error(source.to_string()))?;
        writing.put(MAGIC)?;
        let block = packed(HEADER, &header).map_err(error)?;
        writing.put(&block)?;
        Ok(writing)
    }

    /// Adds a block of entries; says whether there was room for it below the limit.
    ///
    /// # Errors
    /// A full disk; more than [`MOST_UNPACKED`] bytes.
    pub fn entries(&mut self, entries: &[u8]) -> Result<bool, Error> {
        let block = packed(ENTRIES, entries).map_err(|what| self.error(what))?;
        if self.bytes + block.len() as u64 + ROOM_FOR_END > self.limit {
            return Ok(false);
        }
        self.put(&block)?;
        self.blocks += 1;
        Ok(true)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// A full disk.
    pub fn end(mut self, end: &End) -> Result<u64, Error> {
        let end = serde_json::to_vec(end).map_err(|source| self.error(source.to_string()))?;
        let block = packed(END, &end).map_err(|what| self.error(what))?;
        self.put(&block)?;
        Ok(self.bytes)
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.file.write_all(bytes).map_err(|source| self.error(source.to_string()))?;
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    fn error(&self, what: String) -> Error {
        Error { doing: "write", path: self.path.clone(), what }
    }
}

/// A block as it stands in the file.
fn packed(kind: u8, bytes: &[u8]) -> Result<Vec<u8>, String> {
    if bytes.len() > MOST_UNPACKED {
        return Err(format!("a call has {} bytes, and {MOST_UNPACKED} are taken at most", bytes.len()));
    }
    let mut block = vec![kind, 0, 0, 0, 0];
    block.extend((bytes.len() as u32).to_le_bytes());
    let mut encoder = DeflateEncoder::new(block, Compression::new(LEVEL));
    let packed = encoder.write_all(bytes).and_then(|()| encoder.finish());
    let mut block = packed.map_err(|source| source.to_string())?;
    let length = (block.len() - (FRAME - 4)) as u32;
    block[1..5].copy_from_slice(&length.to_le_bytes());
    block.extend(crc32fast::hash(&block).to_le_bytes());
    Ok(block)
}

/// What comes next in a recording.
#[derive(Debug, PartialEq)]
pub enum Block {
    /// Entries.
    Entries(Vec<u8>),
    /// Its end in order.
    End(End),
    /// Its end within a block or before its end in order, at this byte: the run was killed.
    Cut(u64),
}

/// A recording being read, from its start to its end.
#[derive(Debug)]
pub struct Reading {
    path: PathBuf,
    input: BufReader<File>,
    at: u64,
    length: u64,
    /// What it says of its run.
    pub header: Header,
}

impl Reading {
    /// Opens the file.
    ///
    /// # Errors
    /// A file that cannot be read, is no recording, or one of another version; one that was cut off before
    /// its header's end.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let error = |what: String| Error { doing: "read", path: path.to_owned(), what };
        let file = files::open(path, u64::MAX).map_err(|source| error(source.to_string()))?;
        let length = file.metadata().map_err(|source| error(source.to_string()))?.len();
        let mut reading = Self {
            path: path.to_owned(),
            input: BufReader::new(file),
            at: 0,
            length,
            header: Header::default(),
        };
        let mut magic = [0; 8];
        let none =
            "it is no recording: it does not start as one; give a file that `meniscus run --record` wrote";
        if !reading.fill(&mut magic)? || magic[..7] != MAGIC[..7] {
            return Err(error(none.to_owned()));
        }
        if magic != *MAGIC {
            let (found, read) = (magic[7].escape_ascii(), char::from(MAGIC[7]));
            return Err(error(format!(
                "its layout is of version {found}, and {read} is read; record the run again with this version"
            )));
        }
        match reading.block()? {
            Some((HEADER, bytes)) => reading.header = reading.json(&bytes)?,
            Some(_) => return Err(reading.damaged("its header is not there")),
            None => return Err(error("it was cut off before anything was recorded".to_owned())),
        }
        Ok(reading)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The next block; after its end, the end again.
    ///
    /// # Errors
    /// A file that is damaged here, or cannot be read.
    pub fn next_block(&mut self) -> Result<Block, Error> {
        match self.block()? {
            Some((ENTRIES, bytes)) => Ok(Block::Entries(bytes)),
            Some((END, bytes)) if self.at == self.length => Ok(Block::End(self.json(&bytes)?)),
            Some((END, _)) => Err(self.damaged("it goes on after its end")),
            Some((kind, _)) => Err(self.damaged(&format!("a block of kind {kind} is none"))),
            None => Ok(Block::Cut(self.at)),
        }
    }

    /// Says that the file is damaged before the byte that comes next.
    pub fn damaged(&self, what: &str) -> Error {
        let (at, length) = (self.at, self.length);
        let what = format!("it is damaged before byte {at} of {length}: {what}; record the run again");
        Error { doing: "read", path: self.path.clone(), what }
    }

    /// The next block whole, and its kind; nothing where the file ends before it does.
    fn block(&mut self) -> Result<Option<(u8, Vec<u8>)>, Error> {
        let mut head = [0; FRAME - 4];
        let left = self.length.saturating_sub(self.at);
        if left < FRAME as u64 {
            return Ok(None);
        }
        let number = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as usize;
        let begun = self.at;
        if !self.fill(&mut head)? {
            return Ok(None);
        }
        let (packed, unpacked) = (number(&head[1..5]), number(&head[5..9]));
        if unpacked > MOST_UNPACKED {
            return Err(self.damaged(&format!("a block of {unpacked} bytes is none")));
        }
        if packed as u64 + FRAME as u64 > left {
            self.at = begun;
            return Ok(None);
        }
        let mut rest = vec![0; packed + 4];
        if !self.fill(&mut rest)? {
            self.at = begun;
            return Ok(None);
        }
        let (packed, sum) = rest.split_at(packed);
        let mut found = crc32fast::Hasher::new();
        found.update(&head);
        found.update(packed);
        if found.finalize() as usize != number(sum) {
            return Err(self.damaged("a block's checksum is not that of its bytes"));
        }
        let mut bytes = Vec::new();
        let most = unpacked as u64 + 1;
        match DeflateDecoder::new(packed).take(most).read_to_end(&mut bytes) {
            Ok(length) if length == unpacked => Ok(Some((head[0], bytes))),
            Ok(_) => Err(self.damaged("a block unpacks to another length than it says")),
            Err(source) => Err(self.damaged(&source.to_string())),
        }
    }

    /// Whether there were as many bytes.
    fn fill(&mut self, bytes: &mut [u8]) -> Result<bool, Error> {
        match self.input.read_exact(bytes) {
            Ok(()) => {
                self.at += bytes.len() as u64;
                Ok(true)
            }
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
            Err(source) => Err(Error { doing: "read", path: self.path.clone(), what: source.to_string() }),
        }
    }

    fn json<T: for<'a> Deserialize<'a>>(&self, bytes: &[u8]) -> Result<T, Error> {
        serde_json::from_slice(bytes).map_err(|source| self.damaged(&source.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn written(path: &Path) -> Vec<u8> {
        let header = Header { version: "0".to_owned(), ..Header::default() };
        let mut writing = Writing::create(path, &header, u64::MAX).unwrap();
        assert!(writing.entries(&[7; 300]).unwrap() && writing.entries(&[8; 20]).unwrap());
        let length = writing.end(&End::default()).unwrap();
        let bytes = fs::read(path).unwrap();
        assert_eq!(bytes.len() as u64, length);
        bytes
    }

    fn read(path: &Path) -> Result<(usize, Block), Error> {
        let mut reading = Reading::open(path)?;
        let mut whole = 0;
        loop {
            match reading.next_block()? {
                Block::Entries(_) => whole += 1,
                end => return Ok((whole, end)),
            }
        }
    }

    #[test]
    fn of_a_file_cut_anywhere_all_whole_blocks_are_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.record");
        let whole = written(&path);
        assert_eq!(read(&path).unwrap(), (2, Block::End(End::default())));
        let mut seen = Vec::new();
        for length in 0..whole.len() {
            fs::write(&path, &whole[..length]).unwrap();
            match read(&path) {
                Ok((blocks, Block::Cut(at))) => {
                    assert!(at <= length as u64);
                    seen.push(blocks);
                }
                Ok(other) => panic!("{length} bytes: {other:?}"),
                Err(error) => assert!(seen.is_empty() && error.to_string().contains("a.record"), "{error}"),
            }
        }
        assert!(seen.is_sorted() && seen.contains(&0) && seen.last() == Some(&2), "{seen:?}");
    }

    #[test]
    fn no_flipped_bit_is_taken_for_what_was_recorded() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.record");
        let whole = written(&path);
        for bit in 0..8 * whole.len() {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            fs::write(&path, &bytes).unwrap();
            // A length that became longer looks like a cut: what comes before it is whole.
            let read = read(&path);
            assert!(!matches!(read, Ok((_, Block::End(_)))), "bit {bit}: {read:?}");
        }
        fs::write(&path, [&whole[..], &[0; FRAME]].concat()).unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("after its end"));
    }

    #[test]
    fn what_is_no_recording_is_refused_by_name_and_nothing_is_overwritten() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.record");
        fs::write(&path, "[case]\n").unwrap();
        let refused = Reading::open(&path).unwrap_err().to_string();
        assert!(refused.contains("a.record: it is no recording"), "{refused}");
        fs::write(&path, b"mnscrec9 and so on").unwrap();
        let refused = Reading::open(&path).unwrap_err().to_string();
        assert!(refused.contains("version 9, and 1 is read"), "{refused}");
        let refused = Writing::create(&path, &Header::default(), u64::MAX).unwrap_err().to_string();
        assert!(refused.contains("it is there already"), "{refused}");
        assert!(fs::read(&path).unwrap().starts_with(b"mnscrec9"));
        // A block that promises more than there is: nothing of that size is reserved.
        let mut bytes = MAGIC.to_vec();
        bytes.extend([HEADER, 255, 255, 255, 255, 255, 255, 255, 255]);
        bytes.extend([0; 20]);
        fs::write(&path, bytes).unwrap();
        assert!(Reading::open(&path).is_err());
    }

    #[test]
    fn a_limit_is_kept() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.record");
        let mut writing = Writing::create(&path, &Header::default(), 6000).unwrap();
        let mut noise = 1_u64;
        let mut random = || {
            noise = noise.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (noise >> 40) as u8
        };
        let blocks = (0..).take_while(|_| {
            let block: Vec<u8> = (0..300).map(|_| random()).collect();
            writing.entries(&block).unwrap()
        });
        assert!((3..7).contains(&blocks.count()));
        let length = writing.end(&End { early: Some("its limit".to_owned()) }).unwrap();
        assert!(length <= 6000, "{length}");
    }
}
