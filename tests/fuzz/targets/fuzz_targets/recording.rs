//! A recording of a run, and the entries behind its checksums.
#![no_main]

use coupler::recording::entry::Decoder;
use coupler::recording::file::{Block, Reading};
use libfuzzer_sys::fuzz_target;
use meniscus_fuzz::file;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(mut reading) = Reading::open(&file("a.record", bytes)) {
        while let Ok(Block::Entries(_)) = reading.next_block() {}
    }
    // Entries one after another, each after its length (u32): what a block holds.
    let (mut decoder, mut rest) = (Decoder::default(), bytes);
    while let Some((length, after)) = rest.split_first_chunk::<4>() {
        let length = (u32::from_le_bytes(*length) as usize).min(after.len());
        let (entry, after) = after.split_at(length);
        if decoder.entry(entry).is_err() {
            break;
        }
        rest = after;
    }
});
