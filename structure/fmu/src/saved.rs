//! A state of an instance as bytes, little endian: magic, token of the unit, life-cycle phase, and the
//! model's numbers.

use crate::instance::Phase;
use crate::model::Saved;
use crate::variables::Parameter;
use interfaces::SubSteps;

/// First bytes of a serialised state; the last is the version of this layout.
const MAGIC: &[u8; 8] = b"mnscfmu1";

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
    let mut bytes = MAGIC.to_vec();
    let model = &state.model;
    put_bytes(&mut bytes, token.as_bytes());
    bytes.push(state.phase as u8);
    put_number(&mut bytes, model.time.to_bits());
    put_number(&mut bytes, model.windows);
    put_number(&mut bytes, u64::from(model.sub_steps.count().unwrap_or(0)));
    put_number(&mut bytes, model.declared_points as u64);
    for parameter in Parameter::ALL {
        let value = model.parameters.get(&parameter);
        bytes.push(u8::from(value.is_some()));
        put_number(&mut bytes, value.copied().unwrap_or(0.0).to_bits());
    }
    put_bytes(&mut bytes, &model.structure);
    for arrays in [&model.inputs, &model.outputs] {
        put_number(&mut bytes, arrays.len() as u64);
        arrays.iter().for_each(|array| put_doubles(&mut bytes, array));
    }
    put_doubles(&mut bytes, &model.forces);
    put_doubles(&mut bytes, &model.scalars);
    bytes
}

/// The state that [`to_bytes`] wrote for a unit with this token; nothing where they are others, or cut.
pub fn from_bytes(bytes: &[u8], token: &str) -> Option<InstanceState> {
    let mut rest = bytes.strip_prefix(MAGIC)?;
    let rest = &mut rest;
    if take_bytes(rest)? != token.as_bytes() {
        return None;
    }
    let phase = Phase::from_byte(take(rest, 1)?[0])?;
    let time = f64::from_bits(take_number(rest)?);
    let windows = take_number(rest)?;
    let sub_steps = match u32::try_from(take_number(rest)?).ok()? {
        0 => SubSteps::Stable,
        count => SubSteps::Fixed(count),
    };
    let declared_points = usize::try_from(take_number(rest)?).ok()?;
    let mut parameters = std::collections::BTreeMap::new();
    for parameter in Parameter::ALL {
        let is_set = take(rest, 1)?[0] != 0;
        let value = f64::from_bits(take_number(rest)?);
        if is_set {
            parameters.insert(parameter, value);
        }
    }
    let structure = take_bytes(rest)?.to_vec();
    let [inputs, outputs] = [take_arrays(rest)?, take_arrays(rest)?];
    let (forces, scalars) = (take_doubles(rest)?, take_doubles(rest)?);
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
    rest.is_empty().then_some(InstanceState { phase, model })
}

fn put_number(bytes: &mut Vec<u8>, number: u64) {
    bytes.extend(number.to_le_bytes());
}

fn put_bytes(bytes: &mut Vec<u8>, more: &[u8]) {
    put_number(bytes, more.len() as u64);
    bytes.extend(more);
}

fn put_doubles(bytes: &mut Vec<u8>, doubles: &[f64]) {
    put_number(bytes, doubles.len() as u64);
    bytes.extend(doubles.iter().flat_map(|d| d.to_le_bytes()));
}

fn take<'a>(rest: &mut &'a [u8], length: usize) -> Option<&'a [u8]> {
    let (head, tail) = rest.split_at_checked(length)?;
    *rest = tail;
    Some(head)
}

fn take_number(rest: &mut &[u8]) -> Option<u64> {
    take(rest, 8).map(|word| u64::from_le_bytes(word.try_into().expect("eight bytes were taken")))
}

fn take_length(rest: &mut &[u8], size: usize) -> Option<usize> {
    let count = usize::try_from(take_number(rest)?).ok()?;
    // A length that the bytes cannot hold is refused before anything is reserved for it.
    (count.checked_mul(size)? <= rest.len()).then_some(count)
}

fn take_bytes<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let length = take_length(rest, 1)?;
    take(rest, length)
}

fn take_doubles(rest: &mut &[u8]) -> Option<Vec<f64>> {
    let count = take_length(rest, 8)?;
    (0..count).map(|_| take_number(rest).map(f64::from_bits)).collect()
}

fn take_arrays(rest: &mut &[u8]) -> Option<Vec<Vec<f64>>> {
    let count = take_length(rest, 8)?;
    (0..count).map(|_| take_doubles(rest)).collect()
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
        assert_eq!(from_bytes(&bytes, "{token}"), Some(state));
        assert_eq!(from_bytes(&bytes, "{other}"), None);
        for length in 0..bytes.len() {
            assert_eq!(from_bytes(&bytes[..length], "{token}"), None, "{length}");
        }
    }
}
