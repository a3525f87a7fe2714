//! A state of an instance as bytes: token of the unit, life-cycle phase, and the model's numbers.

use crate::model::Saved;
use crate::phase::Phase;
use crate::variables::Parameter;
use interfaces::SubSteps;
use words::bytes::{self, Reader, Writer};

/// Starts every serialised state; the last byte is the version of this layout.
const MAGIC: &[u8; 8] = b"mnscfmu2";

/// A state of an instance: `fmi3FMUState` and `fmi2FMUstate` point at one.
#[derive(Clone, Debug, PartialEq)]
pub struct InstanceState {
    /// Where in its life the instance was.
    pub phase: Phase,
    /// Its model.
    pub model: Saved,
}

/// The state of a unit with this token as bytes.
pub fn to_bytes(state: &InstanceState, token: &str) -> Vec<u8> {
    let InstanceState { phase, model } = state;
    let mut state = Writer::new(MAGIC);
    state.text(token);
    state.u8(*phase as u8);
    state.f64(model.time);
    state.u64(model.windows);
    state.u32(model.sub_steps.count().unwrap_or(0));
    state.usize(model.declared_points);
    for parameter in Parameter::ALL {
        state.option(model.parameters.get(&parameter), |state, value| state.f64(*value));
    }
    state.bytes(&model.structure);
    for arrays in [&model.inputs, &model.outputs] {
        state.list(arrays, |state, array| state.f64s(array));
    }
    state.f64s(&model.forces);
    state.f64s(&model.scalars);
    state.finish()
}

/// The state that [`to_bytes`] wrote for a unit with this token.
///
/// # Errors
/// Bytes that are no such state, or one of another unit.
pub fn from_bytes(bytes: &[u8], token: &str) -> Result<InstanceState, bytes::Error> {
    let mut state = Reader::new("unit's state", MAGIC, bytes)?;
    let of = state.text("token")?;
    if of != token {
        return Err(state.refuse("token", of));
    }
    let phase = state.tag("phase", Phase::from_byte)?;
    let time = state.f64("time")?;
    let windows = state.u64("windows")?;
    let sub_steps = match state.u32("sub-steps")? {
        0 => SubSteps::Stable,
        count => SubSteps::Fixed(count),
    };
    let declared_points = state.usize("interface points")?;
    let mut parameters = std::collections::BTreeMap::new();
    for parameter in Parameter::ALL {
        if let Some(value) = state.option("parameters", |state| state.f64("parameters"))? {
            parameters.insert(parameter, value);
        }
    }
    let structure = state.bytes("structure")?.to_vec();
    let mut arrays = |field: &'static str| state.list(field, None, |state| state.f64s(field, None));
    let (inputs, outputs) = (arrays("inputs")?, arrays("outputs")?);
    let (forces, scalars) = (state.f64s("forces", None)?, state.f64s("scalars", None)?);
    state.finish()?;
    let model = Saved {
        time,
        windows,
        sub_steps,
        declared_points,
        parameters,
        structure,
        inputs,
        outputs,
        forces,
        scalars,
    };
    Ok(InstanceState { phase, model })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_comes_back_whole_and_no_cut_or_foreign_one_does() {
        let model = Saved {
            time: 0.1,
            windows: 7,
            sub_steps: SubSteps::Fixed(100),
            declared_points: 3,
            parameters: [(Parameter::Density, 1100.0)].into(),
            structure: vec![1, 2, 3],
            inputs: vec![vec![1.0, -0.0]],
            outputs: vec![vec![], vec![f64::MIN_POSITIVE]],
            forces: vec![],
            scalars: vec![2.5],
        };
        let state = InstanceState { phase: Phase::Step, model };
        let bytes = to_bytes(&state, "{token}");
        assert_eq!(from_bytes(&bytes, "{token}"), Ok(state));
        let said = from_bytes(&bytes, "{other}").unwrap_err().to_string();
        assert_eq!(said, "the unit's state holds {token} at byte 23, which its token cannot be");
        for length in 0..bytes.len() {
            assert!(from_bytes(&bytes[..length], "{token}").is_err(), "{length}");
        }
    }
}
