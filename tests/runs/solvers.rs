//! Our solvers against the contract: conformance, here and as processes, and going on from a saved state.

use crate::support::{Bench, COARSE, Running};
use coupler::schedule::Schedule;
use coupler::schemes::serial_explicit::SerialExplicit;
use coupler::schemes::{Coupled, Onward, Pair, Run};
use coupler::side::Side;
use interfaces::case::Case;
use interfaces::case::coupling::StructureVelocity;
use interfaces::port::names;
use interfaces::{
    Address, Call, Deadlines, Direction, Exchange, Expectations, Fields, Guarded, Participant,
    RemoteParticipant, Role, SubSteps, new_run,
};
use partners::conformance::{self, Options, plausible};
use partners::{Log, Recorded, Recording};
use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;

fn coarse_gate() -> Case {
    let overrides: Vec<String> =
        COARSE.iter().filter(|word| word.contains('=')).map(|&w| w.to_owned()).collect();
    Case::load(Path::new(COARSE[0]), &overrides, &crate::case::SECTIONS).expect("a sound case")
}

fn solver(case: &Case, role: Role, out: &Path) -> Box<dyn Participant> {
    let made = match role {
        Role::Fluid => fluid::participant::from_case(case, out),
        Role::Structure => structure::participant::from_case(case, out),
    };
    made.expect("a solver of a sound case")
}

/// What the gate gives at the start: where its particles are, and their constants.
fn gate_at_rest(case: &Case, out: &Path) -> Fields {
    let mut gate = solver(case, Role::Structure, out);
    let inputs = gate.describe().fields(Direction::In, 0);
    let mut outputs = gate.describe().fields(Direction::Out, 0);
    gate.initialize(0.25, &inputs, &mut outputs).expect("a gate");
    outputs
}

/// The suite for one of our solvers of the coarse gate, as `make` makes it.
fn conforms(bench: &Bench, role: Role, make: impl Fn(&Case) -> Box<dyn Participant>) {
    let case = coarse_gate();
    let gate = gate_at_rest(&case, &bench.path("gate"));
    let points = gate.get(names::DENSITY).expect("given").len();
    // A fluid needs a gate where its own geometry leaves room for one; it trembles by a hundredth of a
    // spacing.
    let inputs = |time: f64, variant: u32, inputs: &mut Fields| {
        plausible(time, variant, inputs);
        for (name, share) in [(names::POSITION, 1e-5), (names::REFERENCE_VOLUME, 0.0), (names::DENSITY, 0.0)]
        {
            if let (Some(values), Some(at_rest)) = (inputs.get_mut(name), gate.get(name)) {
                for (value, rest) in values.iter_mut().zip(at_rest) {
                    *value = rest + share * (1e3 * *value).sin();
                }
            }
        }
    };
    let options = Options { points, sub_steps: SubSteps::Fixed(100), inputs: &inputs, ..Options::default() };
    conformance::check(|| make(&case), &options).unwrap_or_else(|broken| panic!("{role}: {broken}"));
}

#[test]
fn our_solvers_keep_the_contract() {
    let bench = Bench::new();
    for role in [Role::Structure, Role::Fluid] {
        conforms(&bench, role, |case| solver(case, role, &bench.path("out")));
    }
}

#[test]
fn our_solvers_keep_the_contract_as_processes() {
    let bench = Bench::new();
    let file = bench.path("case.toml");
    std::fs::write(&file, coarse_gate().to_toml()).expect("a case");
    for role in [Role::Structure, Role::Fluid] {
        let processes = RefCell::new(Vec::new());
        conforms(&bench, role, |case| {
            let address = Address::new(new_run(), role).in_domain(&bench.domain);
            let expected = Expectations { case_hash: case.hash(), dimension: 2 };
            let listening =
                RemoteParticipant::listen(&address, expected, Deadlines::default(), &Arc::default())
                    .expect("heard");
            let words = [role.to_string(), file.display().to_string(), "--run".to_owned(), address.connect()];
            let command = bench.command(&words.each_ref().map(String::as_str));
            let number = processes.borrow().len();
            processes.borrow_mut().push(Running::spawn(command, &bench.path(&format!("{role}-{number}"))));
            Box::new(listening.wait_for_hello(Box::new(|| None)).expect("a handshake"))
        });
        for process in processes.into_inner() {
            // In order, or told that nothing more is wanted: 0 or 1, and no other end.
            let ended = process.wait();
            assert!(matches!(ended.status.code(), Some(0 | 1)), "{:?}: {}", ended.status, ended.errors);
        }
    }
}

/// A participant that was initialised with what the recorded one was.
fn replica(case: &Case, out: &Path, calls: &[Recorded]) -> Guarded<Box<dyn Participant>> {
    let first = calls.first().expect("an initialisation");
    let mut participant = Guarded::new(solver(case, first.role, out));
    let mut outputs = first.outputs.clone().expect("it succeeded");
    let inputs = first.inputs.as_ref().expect("it took inputs");
    participant.initialize(first.start.expect("a time"), inputs, &mut outputs).expect("it starts again");
    participant
}

/// What a participant gives that goes to a saved state, over fields like these.
fn restored(participant: &mut dyn Participant, state: &[u8], like: &Fields) -> Fields {
    let mut found = like.clone();
    found.iter_mut().filter(|(port, _)| port.exchange == Exchange::EveryWindow).for_each(|(_, values)| {
        values.fill(f64::NAN);
    });
    participant.restore(state, &mut found).expect("a state of the same case");
    found
}

/// Makes the recorded calls again, and compares what comes out to the bit.
fn replay(participant: &mut dyn Participant, calls: &[Recorded]) {
    for call in calls {
        match call.call {
            Call::Start => {
                let window = call.window.expect("a start has a window");
                participant
                    .start(&window, call.inputs.as_ref().expect("and inputs"))
                    .expect("it solved before");
            }
            Call::Finish => {
                let expected = call.outputs.as_ref().expect("a solution");
                let mut found = expected.clone();
                found.iter_mut().for_each(|(port, values)| {
                    if port.exchange == Exchange::EveryWindow {
                        values.fill(f64::NAN);
                    }
                });
                participant.finish(&mut found).expect("it solved before");
                for ((port, expected), (_, found)) in expected.iter().zip(found.iter()) {
                    let differs = (0..expected.len()).find(|&i| expected[i].to_bits() != found[i].to_bits());
                    assert_eq!(differs, None, "{} of the {} differs", port.name, call.role);
                }
            }
            Call::Accept => participant.accept(None).expect("it accepted before"),
            other => unreachable!("{other} is no call of a window"),
        }
    }
}

#[test]
fn a_saved_run_goes_on_to_the_bit() {
    let bench = Bench::new();
    let (case, out) = (coarse_gate(), bench.path("out"));
    let logs = [Role::Fluid, Role::Structure].map(|role| (role, Log::default()));
    let [fluid, structure] = logs
        .clone()
        .map(|(role, log)| Side::new(Box::new(Guarded::new(Recording::new(solver(&case, role, &out), log)))));
    let pair = Pair::initialize(fluid, structure, 0.0, StructureVelocity::Mean).expect("they fit");
    let scheme = SerialExplicit { relaxation: 0.5, enforce: true, predict: true };
    let mut driven = Run {
        solver: Coupled::new(pair, scheme),
        schedule: Schedule::new(0.0, 0.02, 0.02, 1e-3, SubSteps::Fixed(100)),
    };
    driven.drive(|_, _| Ok(Onward::Continue)).expect("the coarse gate runs");
    for (_, log) in logs {
        let calls = log.calls();
        let half =
            calls.iter().enumerate().filter(|(_, c)| c.call == Call::Accept).nth(9).expect("windows").0 + 1;
        let mut first = replica(&case, &out, &calls);
        replay(&mut first, &calls[1..half]);
        let saved = first.save().expect("a state");
        let mut second = replica(&case, &out, &calls);
        let last = calls[..half].iter().rev().find_map(|call| call.outputs.as_ref()).expect("a solution");
        assert_eq!(&restored(&mut second, &saved, last), last, "what it gave when it was saved");
        assert_eq!(second.save().expect("a state"), saved);
        replay(&mut second, &calls[half..]);
        // What was saved is the state, not where the first has gone since.
        replay(&mut first, &calls[half..]);
        assert_ne!(first.save().expect("a state"), saved);
        assert_eq!(&restored(&mut first, &saved, last), last, "what it gave when it was saved");
        replay(&mut first, &calls[half..]);
    }
}
