//! A recorded side is played back to the bit, and what departs from it is named.

use crate::states::{WINDOWS, schedule, schemes, windows};
use coupler::phase::Announce;
use coupler::recording::{Header, OnDeparture, Recording, Replay};
use coupler::schemes::serial_explicit::SerialExplicit;
use coupler::schemes::{Coupled, Onward, Pair, Run, Scheme, SchemeError};
use coupler::side::Side;
use interfaces::case::coupling::StructureVelocity;
use interfaces::{Guarded, Participant, Role};
use partners::build;
use std::cell::RefCell;
use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use tempfile::TempDir;

const FLUID: &str = "added-mass-column wall=moving mass=0.5";
const STRUCTURE: &str = "spring-mass stiffness=4e3 displacement=0,0.01 load=linear";
const EXPLICIT: SerialExplicit = SerialExplicit { relaxation: 1.0, enforce: false, predict: true };

fn mock(words: &str) -> Box<dyn Participant> {
    build(words).expect("a mock")
}

fn run(fluid: Box<dyn Participant>, structure: Box<dyn Participant>, scheme: Scheme) -> Run<Coupled> {
    let [fluid, structure] = [fluid, structure].map(|side| Side::new(Box::new(Guarded::new(side))));
    let pair = Pair::initialize(fluid, structure, 0.0, StructureVelocity::Mean).expect("they fit");
    Run { solver: Coupled::new(pair, scheme), schedule: schedule() }
}

/// A folder with the recording of a run of mocks, and what was seen of the run.
fn recorded(scheme: Scheme) -> (TempDir, PathBuf, Vec<Vec<u64>>) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.record");
    let recording = Recording::create(&path, &Header::default(), u64::MAX).expect("a recording");
    let keep = |words| Box::new(recording.recorder(mock(words), Announce::nobody()));
    let mut run = run(keep(FLUID), keep(STRUCTURE), scheme);
    let seen = windows(&mut run, WINDOWS);
    end(&mut run);
    let kept = recording.end();
    assert_eq!((kept.bytes, kept.note), (fs::metadata(&path).expect("a file").len(), None));
    (folder, path, seen)
}

fn end(run: &mut Run<Coupled>) {
    let Pair { fluid, structure, .. } = &mut run.solver.pair;
    for side in [fluid, structure] {
        side.terminate().expect("mocks end in order");
    }
}

/// A replay, and what it tells.
fn replay(path: &Path, role: Role, on_departure: OnDeparture) -> (Box<Replay>, Rc<RefCell<Vec<String>>>) {
    let told = Rc::new(RefCell::new(Vec::new()));
    let heard = Rc::clone(&told);
    let tell = move |line: &str| heard.borrow_mut().push(line.to_owned());
    (Box::new(Replay::open(path, role, on_departure, tell).expect("a recording")), told)
}

/// The run with one side played back, the other from these words.
fn replayed(path: &Path, role: Role, other: &str, how: OnDeparture, scheme: Scheme) -> Replayed {
    let (side, told) = replay(path, role, how);
    let run = match role {
        Role::Fluid => run(side, mock(other), scheme),
        Role::Structure => run(mock(other), side, scheme),
    };
    Replayed { run, told }
}

struct Replayed {
    run: Run<Coupled>,
    told: Rc<RefCell<Vec<String>>>,
}

impl Replayed {
    fn drive(&mut self) -> Result<(), SchemeError> {
        self.run.drive(|_, _| Ok(Onward::Continue))
    }
}

#[test]
fn either_side_is_played_back_to_the_bit_under_every_scheme_and_acceleration() {
    for (name, scheme) in schemes() {
        let (_folder, path, seen) = recorded(scheme());
        for (role, other) in [(Role::Fluid, STRUCTURE), (Role::Structure, FLUID)] {
            let mut replayed = replayed(&path, role, other, OnDeparture::End, scheme());
            assert!(windows(&mut replayed.run, WINDOWS) == seen, "{name}, {role}");
            end(&mut replayed.run);
            let told = replayed.told.borrow();
            assert!(told.len() == 1 && told[0].ends_with("as recorded, to the bit"), "{name}: {told:?}");
        }
    }
}

#[test]
fn one_bit_of_one_field_in_one_window_is_found_and_named() {
    let (_folder, path, _) = recorded(EXPLICIT.into());
    for (role, other, said) in [
        (Role::Fluid, format!("{STRUCTURE} --fault bit:3@7.0"), "in window 7 (iteration 0) from t = 0.0007"),
        (Role::Structure, format!("{FLUID} --fault bit:3@7"), "in window 7 (iteration 1) from t = 0.0007"),
    ] {
        let mut ended = replayed(&path, role, &other, OnDeparture::End, EXPLICIT.into());
        let error = ended.drive().expect_err("it departs").to_string();
        let field = if role == Role::Fluid { "velocity" } else { "pressure_gradient" };
        let place = format!("field `{field}`, point 3, component 0: recorded ");
        assert!(error.contains(said) && error.contains(&place), "{error}");
        let mut went_on = replayed(&path, role, &other, OnDeparture::Continue, EXPLICIT.into());
        went_on.drive().expect("a replay that goes on does not fail");
        end(&mut went_on.run);
        let told = went_on.told.borrow();
        assert!(told[0].contains(said) && told[0].contains(&place), "{told:?}");
        assert!(
            told.iter().any(|line| line.contains("largest departure") && line.contains(field)),
            "{told:?}"
        );
    }
}

#[test]
fn another_number_of_solutions_is_a_departure() {
    let schemes = schemes();
    let named = |name: &str| &schemes.iter().find(|(found, _)| found == name).expect("it is there").1;
    let (few, many) =
        (named("IQN-ILS, parallel: false, order 2"), named("constant, parallel: false, order 2"));
    for (first, second) in [(few, many), (many, few)] {
        let (_folder, path, _) = recorded(first());
        let mut ended = replayed(&path, Role::Fluid, STRUCTURE, OnDeparture::End, second());
        assert!(ended.drive().is_err());
        let mut went_on = replayed(&path, Role::Fluid, STRUCTURE, OnDeparture::Continue, second());
        // It may not converge to what was recorded; it is answered to the end of the recording.
        went_on.drive().expect("a replay that goes on does not fail");
    }
}

#[test]
fn of_a_killed_run_all_whole_blocks_are_played_back_and_the_end_is_told() {
    let (folder, path, _) = recorded(EXPLICIT.into());
    let whole = fs::read(&path).expect("a file");
    let cut = folder.path().join("cut.record");
    // Without the last block, the end.
    fs::write(&cut, &whole[..whole.len() - 20]).expect("a file");
    replayed(&cut, Role::Fluid, STRUCTURE, OnDeparture::End, EXPLICIT.into()).drive().expect("all is there");
    let refused = Replay::open(&folder.path().join("none"), Role::Fluid, OnDeparture::End, |_| ());
    assert!(refused.err().expect("no file").to_string().contains("failed to read the recording"));
    for length in (0..whole.len()).step_by(97) {
        fs::write(&cut, &whole[..length]).expect("a file");
        if let Ok(side) = Replay::open(&cut, Role::Fluid, OnDeparture::End, |_| ()) {
            let mut run = run(Box::new(side), mock(STRUCTURE), EXPLICIT.into());
            if let Err(error) = run.drive(|_, _| Ok(Onward::Continue)) {
                assert!(error.to_string().contains("was cut off there"), "{error}");
            }
        }
    }
}

#[test]
fn a_recorded_failure_is_played_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.record");
    let recording = Recording::create(&path, &Header::default(), u64::MAX).expect("a recording");
    let keep = |words: &str| Box::new(recording.recorder(mock(words), Announce::nobody()));
    let mut first = run(keep(&format!("{FLUID} --fault error@5")), keep(STRUCTURE), EXPLICIT.into());
    assert!(first.drive(|_, _| Ok(Onward::Continue)).is_err());
    recording.end();
    let mut replayed = replayed(&path, Role::Fluid, STRUCTURE, OnDeparture::End, EXPLICIT.into());
    let error = replayed.drive().expect_err("it failed").to_string();
    assert!(error.contains("window 5") && error.contains("it failed so when it was recorded"), "{error}");
}

#[test]
fn a_recording_ends_at_its_limit_and_the_run_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.record");
    let recording = Recording::create(&path, &Header::default(), 4500).expect("a recording");
    let keep = |words| Box::new(recording.recorder(mock(words), Announce::nobody()));
    let mut first = run(keep(FLUID), keep(STRUCTURE), EXPLICIT.into());
    assert_eq!(windows(&mut first, WINDOWS).len() as u64, WINDOWS);
    let kept = recording.end();
    let note = kept.note.expect("a note");
    assert!(note.contains("limit of 4500 bytes") && kept.bytes <= 4500, "{note}");
    // Its only block did not fit: nobody was recorded in it.
    let refused = Replay::open(&path, Role::Fluid, OnDeparture::End, |_| ()).err().expect("nothing is there");
    assert!(refused.to_string().contains("no fluid was recorded"), "{refused}");
}
