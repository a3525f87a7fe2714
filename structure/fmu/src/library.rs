//! The shared library as it goes into a unit: without what only debuggers read. And what it needs of the
//! system that it runs on.
//!
//! Both read the file's own tables (System V ABI, "Object Files"), of 64 bits and little-endian; any other
//! file is left as it is. What the loader reads lies in the segments, and after their end are sections for
//! debuggers alone: seven eighths of the file.

use std::ops::Range;

/// Kinds of segments and entries that are looked at.
const LOAD: usize = 1;
const DYNAMIC: usize = 2;
const STRING_TABLE: usize = 5;
const STRING_TABLE_SIZE: usize = 10;
/// A section that is in memory while the library runs.
const ALLOCATED: usize = 2;
/// Sizes (bytes) of an entry of the tables of segments and sections.
const SEGMENT: usize = 56;
const SECTION: usize = 64;
/// Where the header has the place of the table of sections, how many there are, and which has their names.
const SECTIONS_AT: usize = 0x28;
const SECTION_COUNT: usize = 0x3c;
const SECTION_OF_NAMES: usize = 0x3e;

/// The library without what only debuggers read.
pub fn stripped(library: Vec<u8>) -> Vec<u8> {
    strip(&library).unwrap_or(library)
}

/// The oldest version of the GNU C library that has all functions which the library calls; nothing where it
/// does not need that one.
pub fn needed_glibc(library: &[u8]) -> Option<(u32, u32)> {
    let elf = Elf::of(library)?;
    let dynamic = elf.segments().find(|segment| segment.kind == DYNAMIC)?;
    let entries = library.get(dynamic.in_file)?.chunks_exact(16);
    let entry =
        |kind| entries.clone().find(|entry| word(entry, 0, 8) == Some(kind)).and_then(|e| word(e, 8, 8));
    let (address, length) = (entry(STRING_TABLE)?, entry(STRING_TABLE_SIZE)?);
    let holds = |segment: &Segment| {
        segment.kind == LOAD
            && address.checked_sub(segment.address).is_some_and(|at| at < segment.in_file.len())
    };
    let segment = elf.segments().find(holds)?;
    let start = segment.in_file.start + (address - segment.address);
    let names = library.get(start..start.checked_add(length)?)?.split(|byte| *byte == 0);
    let version = |name: &[u8]| {
        let mut numbers = std::str::from_utf8(name).ok()?.strip_prefix("GLIBC_")?.split('.');
        Some((numbers.next()?.parse().ok()?, numbers.next()?.parse().ok()?))
    };
    names.filter_map(version).max()
}

/// The segments, then the table of the sections that lie in them.
fn strip(library: &[u8]) -> Option<Vec<u8>> {
    let elf = Elf::of(library)?;
    let end = elf.segments().map(|segment| segment.in_file.end).max()?;
    let header = |index: usize| {
        let at = word(library, SECTIONS_AT, 8)?.checked_add(index * SECTION)?;
        library.get(at..at.checked_add(SECTION)?)
    };
    let count = word(library, SECTION_COUNT, 2)?;
    let is_kept = |index: usize| Some(index == 0 || word(header(index)?, 8, 8)? & ALLOCATED != 0);
    // Sections name each other by their places in the table: those that stay come first in it.
    let kept = (0..count).take_while(|index| is_kept(*index) == Some(true)).count();
    if (kept..count).any(|index| is_kept(index) != Some(false)) {
        return None;
    }
    let mut of_names = header(word(library, SECTION_OF_NAMES, 2)?)?.to_vec();
    let (at, length) = (word(&of_names, 24, 8)?, word(&of_names, 32, 8)?);
    let mut short = library.get(..end)?.to_vec();
    of_names[24..32].copy_from_slice(&(short.len() as u64).to_le_bytes());
    short.extend_from_slice(library.get(at..at.checked_add(length)?)?);
    short.resize(short.len().next_multiple_of(8), 0);
    let sections_at = short.len() as u64;
    for index in 0..kept {
        short.extend_from_slice(header(index)?);
    }
    short.extend_from_slice(&of_names);
    short[SECTIONS_AT..SECTIONS_AT + 8].copy_from_slice(&sections_at.to_le_bytes());
    short[SECTION_COUNT..SECTION_COUNT + 2].copy_from_slice(&(kept as u16 + 1).to_le_bytes());
    short[SECTION_OF_NAMES..SECTION_OF_NAMES + 2].copy_from_slice(&(kept as u16).to_le_bytes());
    Some(short)
}

struct Elf<'a>(&'a [u8]);

struct Segment {
    kind: usize,
    in_file: Range<usize>,
    address: usize,
}

impl<'a> Elf<'a> {
    /// Of 64 bits and little-endian.
    fn of(file: &'a [u8]) -> Option<Self> {
        file.starts_with(b"\x7fELF\x02\x01").then_some(Self(file))
    }

    fn segments(&self) -> impl Iterator<Item = Segment> {
        let (at, count) = (word(self.0, 0x20, 8).unwrap_or(0), word(self.0, 0x38, 2).unwrap_or(0));
        (0..count).filter_map(move |index| {
            let entry = self.0.get(at.checked_add(index * SEGMENT)?..)?;
            let start = word(entry, 8, 8)?;
            let in_file = start..start.checked_add(word(entry, 32, 8)?)?;
            Some(Segment { kind: word(entry, 0, 4)?, in_file, address: word(entry, 16, 8)? })
        })
    }
}

/// The number of so many bytes at a place.
fn word(bytes: &[u8], at: usize, length: usize) -> Option<usize> {
    let bytes = bytes.get(at..at.checked_add(length)?)?;
    Some(bytes.iter().rev().fold(0, |number, byte| (number << 8) | usize::from(*byte)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_library_stays_as_it_is() {
        for file in
            [b"MZ".as_slice(), b"\x7fELF\x02\x01", &[0x7f, b'E', b'L', b'F', 2, 1, 255, 255, 255, 255]]
        {
            assert_eq!(stripped(file.to_vec()), file);
            assert_eq!(needed_glibc(file), None);
        }
    }
}
