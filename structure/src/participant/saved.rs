//! The state as bytes, for a restart that is identical to the bit.

use crate::{Energy, Stability, State};
use sph::Vector;

/// Doubles before the arrays: time, energies and stability.
const HEAD: usize = 7;

/// The state, little endian: time, energies, stability, positions, velocities.
pub fn to_bytes<const D: usize>(state: &State<D>) -> Vec<u8> {
    let Energy { kinetic, strain, load_work, dissipated } = state.energy;
    let Stability { strain: found_at, step } = state.stability;
    let head = [state.time, kinetic, strain, load_work, dissipated, found_at, step];
    let arrays = state.positions.iter().chain(&state.velocities).flat_map(|v| v.iter().copied());
    head.into_iter().chain(arrays).flat_map(f64::to_le_bytes).collect()
}

/// The state of `particles` particles that [`to_bytes`] wrote; nothing where the length is another.
pub fn from_bytes<const D: usize>(bytes: &[u8], particles: usize) -> Option<State<D>> {
    if bytes.len() != 8 * (HEAD + 2 * D * particles) {
        return None;
    }
    let doubles: Vec<f64> = bytes
        .chunks_exact(8)
        .map(|word| f64::from_le_bytes(word.try_into().expect("chunks of eight bytes")))
        .collect();
    let (head, arrays) = doubles.split_at(HEAD);
    let mut vectors = arrays.chunks_exact(D).map(Vector::from_column_slice);
    Some(State {
        time: head[0],
        energy: Energy { kinetic: head[1], strain: head[2], load_work: head[3], dissipated: head[4] },
        stability: Stability { strain: head[5], step: head[6] },
        positions: vectors.by_ref().take(particles).collect(),
        velocities: vectors.collect(),
    })
}
