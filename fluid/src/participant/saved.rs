//! What a restored fluid gives at once, around its own state: limit and scalars depend on the last solution's
//! inputs, and the load on its sums.

use super::ledger::Ledger;
use crate::interface::InterfaceOutput;
use interfaces::Readiness;
use words::bytes::{Error, Reader, Writer};

/// First bytes of a saved state; the last is the version of its layout.
const MAGIC: &[u8; 8] = b"mnscflp5";

pub fn to_bytes<const D: usize>(
    ready: &Readiness,
    output: &InterfaceOutput<D>,
    (ledger, passed): (&Ledger, &[[f64; 2]]),
    shown: [&[f64]; 2],
    own: &[u8],
) -> Vec<u8> {
    let mut state = Writer::new(MAGIC);
    state.f64(ready.window_limit);
    state.f64s(&ready.scalars);
    for vectors in [&output.pressure_gradients, &output.pair_reactions, &output.normals] {
        state.vectors(vectors);
    }
    state.f64s(&output.pressures);
    ledger.save(&mut state);
    state.f64s(passed.as_flattened());
    shown.into_iter().for_each(|times| state.f64s(times));
    state.bytes(own);
    state.finish()
}

/// What is told of balances, and what has crossed areas.
type Told = (Ledger, Vec<[f64; 2]>);
/// Times (s) of the snapshots of fluid and walls.
type Shown = [Vec<f64>; 2];

/// For a fluid whose load is at present laid out as `output`, and that watches so many `areas`.
pub fn from_bytes<'a, const D: usize>(
    bytes: &'a [u8],
    output: &InterfaceOutput<D>,
    areas: usize,
) -> Result<(Readiness, InterfaceOutput<D>, Told, Shown, &'a [u8]), Error> {
    let points = Some(output.pressures.len());
    let mut state = Reader::new("fluid's state", MAGIC, bytes)?;
    let ready = Readiness { window_limit: state.f64("window limit")?, scalars: state.f64s("scalars", None)? };
    let output = InterfaceOutput {
        pressure_gradients: state.vectors("pressure gradients", points)?,
        pair_reactions: state.vectors("pair reactions", points)?,
        normals: state.vectors("normals", points)?,
        pressures: state.f64s("pressures", points)?,
    };
    let ledger = Ledger::restore(&mut state)?;
    let passed = state.f64s("volumes that crossed areas", Some(2 * areas))?;
    let (passed, _) = passed.as_chunks::<2>();
    let passed = passed.to_vec();
    let shown = [state.f64s("times of snapshots", None)?, state.f64s("times of walls' snapshots", None)?];
    let own = state.bytes("particles")?;
    state.finish().map(|()| (ready, output, (ledger, passed), shown, own))
}
