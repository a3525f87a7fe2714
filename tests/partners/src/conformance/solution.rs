//! What a participant gives: whole, finite, the same again, and from where it was left.

use super::life::{Given, Life, UNTOUCHED};
use super::{Check, Suite};
use crate::stand_in::bits;
use interfaces::{Exchange, Fields, Participant, Readiness, Scalar, ScalarKind};

/// The description is the same for every participant of the case, and does not change.
pub(super) fn one_description(suite: &Suite) -> Check {
    let before = suite.make().describe().clone();
    let mut life = Life::initialized(suite)?;
    life.advance(0)?;
    if *life.participant.describe() != before {
        return Err("after a window it describes itself in another way than a new one".to_owned());
    }
    Ok(())
}

/// Initialising gives whole outputs, a limit and the scalars described, the same every time.
pub(super) fn initialization(suite: &Suite) -> Check {
    let mut given = Vec::new();
    for before in [UNTOUCHED, -3.5] {
        let mut life = Life::new(suite, Vec::new());
        life.fill(before);
        let shapes = shapes(&life.outputs);
        let ready = life.initialize().map_err(|error| format!("it failed: {error}"))?;
        report(&life, &ready.scalars, ready.window_limit)?;
        whole(&life, &shapes)?;
        given.push((life.outputs.clone(), ready));
    }
    let (first, second) = (&given[0], &given[1]);
    let ready = |ready: &Readiness| Given::new(Vec::new(), ready.window_limit, &ready.scalars);
    if ready(&first.1).same_as(&ready(&second.1), "initialised").is_err() {
        return Err("two participants of the case are ready with different scalars or limits".to_owned());
    }
    for ((port, one), (_, other)) in first.0.iter().zip(second.0.iter()) {
        if let Some(at) = (0..one.len()).find(|&i| one[i].to_bits() != other[i].to_bits()) {
            return Err(format!(
                "value {at} of `{}` is not written, or differs between two participants of the case",
                port.name
            ));
        }
    }
    Ok(())
}

/// Windows follow each other; every solution is whole and leaves the constant fields as they are.
pub(super) fn windows(suite: &Suite) -> Check {
    let mut life = Life::initialized(suite)?;
    let shapes = shapes(&life.outputs);
    for _ in 0..4 {
        let place = format!("window {}", life.index);
        life.start(0).map_err(|error| format!("`start` failed in {place}: {error}"))?;
        life.fill(UNTOUCHED);
        let finished = life.participant.finish(&mut life.outputs);
        let finished = finished.map_err(|error| format!("`finish` failed in {place}: {error}"))?;
        whole(&life, &shapes).map_err(|what| format!("{place}: {what}"))?;
        report(&life, &finished.scalars, finished.window_limit).map_err(|what| format!("{place}: {what}"))?;
        if !(finished.compute_seconds >= 0.0 && finished.compute_seconds.is_finite()) {
            return Err(format!("{place}: it computed for {} s", finished.compute_seconds));
        }
        if finished.sub_steps == 0 {
            return Err(format!("{place}: it took no sub-step"));
        }
        let constants = life.outputs.iter().filter(|(port, _)| port.exchange == Exchange::Constant);
        for (port, array) in constants {
            if array.iter().any(|v| v.to_bits() != UNTOUCHED.to_bits()) {
                return Err(format!("{place}: `finish` wrote the constant field `{}`", port.name));
            }
        }
        life.accept().map_err(|error| format!("`accept` failed in {place}: {error}"))?;
    }
    Ok(())
}

/// Every solution starts from the last accepted state, repeats to the bit, writes all it gives, and leaves no
/// trace when it is not accepted.
pub(super) fn solving_again(suite: &Suite) -> Check {
    let mut life = Life::initialized(suite)?;
    life.advance(0)?;
    let first = life.solve(0)?;
    life.solve(1)?;
    let again = life.solve(0)?;
    first.same_as(&again, "the same input twice, another between")?;
    life.start(0).map_err(|error| format!("`start` failed: {error}"))?;
    life.fill(-3.5);
    let finished = life.participant.finish(&mut life.outputs);
    let finished = finished.map_err(|error| format!("`finish` failed: {error}"))?;
    first.same_as(&life.answer(&finished), "over outputs that held something else")?;
    life.accept().map_err(|error| format!("`accept` failed: {error}"))?;
    let after = life.advance(0)?;

    let mut straight = Life::initialized(suite)?;
    straight.advance(0)?;
    straight.advance(0)?;
    straight.advance(0)?.same_as(&after, "without and with solutions that were not accepted")
}

/// A saved state gives what stood there when it was saved, and goes on to the bit: in the participant that
/// saved it, from a solution that was not accepted, and in a new participant; that of the very start too.
pub(super) fn saving(suite: &Suite) -> Check {
    if !suite.options.can_save {
        return match Life::initialized(suite)?.participant.save() {
            Ok(_) => Err("it cannot save, and `save` succeeds".to_owned()),
            Err(_) => Ok(()),
        };
    }
    let mut life = Life::new(suite, Vec::new());
    let ready = life.initialize().map_err(|error| format!("`initialize` failed: {error}"))?;
    let at_start = Given::new(bits(&life.outputs), ready.window_limit, &ready.scalars);
    let start = life.save()?;
    let first = life.advance(0)?;
    let second = life.advance(1)?;
    let state = life.save()?;
    let (third, fourth) = (life.advance(0)?, life.advance(1)?);

    second.given.same_as(&life.restore(&state, 2)?, "when it was saved and when it was restored")?;
    if life.save()? != state {
        return Err("a state that was restored and saved again differs".to_owned());
    }
    third.same_as(&life.advance(0)?, "before and after restoring, first window")?;
    fourth.same_as(&life.advance(1)?, "before and after restoring, second window")?;

    life.solve(1)?;
    let restored = life.restore(&state, 2)?;
    second.given.same_as(&restored, "when it was saved and when it was restored over a solution")?;
    third.same_as(&life.advance(0)?, "restored over a solution that was not accepted")?;

    let mut fresh = Life::initialized(suite)?;
    let restored = fresh.restore(&state, 2)?;
    second.given.same_as(&restored, "when it was saved and when it was restored in a new participant")?;
    third.same_as(&fresh.advance(0)?, "restored in a new participant, first window")?;
    fourth.same_as(&fresh.advance(1)?, "restored in a new participant, second window")?;

    at_start.same_as(&fresh.restore(&start, 0)?, "initialised and restored to the start")?;
    first.same_as(&fresh.advance(0)?, "initialised and restored to the start, first window")?;

    let mut torn = Life::initialized(suite)?;
    if torn.restore(&state[..state.len() - 1], 2).is_ok() {
        return Err("it restores a state whose last byte is missing".to_owned());
    }
    Ok(())
}

fn shapes(fields: &Fields) -> Vec<(String, usize)> {
    fields.iter().map(|(port, array)| (port.name.clone(), array.len())).collect()
}

fn whole(life: &Life, shapes_before: &[(String, usize)]) -> Check {
    if shapes(&life.outputs) != shapes_before {
        return Err("it changed the shape of its outputs".to_owned());
    }
    life.outputs.check_finite().map_err(|error| error.to_string())
}

fn report(life: &Life, scalars: &[f64], window_limit: f64) -> Check {
    let described = &life.participant.describe().scalars;
    if scalars.len() != described.len() {
        let (found, expected) = (scalars.len(), described.len());
        return Err(format!("it reports {found} scalars where it described {expected}"));
    }
    let wrong = |(scalar, value): &(&Scalar, &f64)| {
        let nothing_to_read = scalar.kind == ScalarKind::Probe && value.is_nan();
        !value.is_finite() && !nothing_to_read
    };
    if let Some((scalar, value)) = described.iter().zip(scalars).find(wrong) {
        return Err(format!("scalar `{}` is {value}", scalar.name));
    }
    if window_limit.is_nan() || window_limit <= 0.0 {
        return Err(format!("its window limit is {window_limit} s"));
    }
    Ok(())
}
