//! The coupling loop on partners that are known: order of calls, fields that pass, and the added-mass
//! instability.

use coupler::schedule::Schedule;
use coupler::schemes::serial_explicit::SerialExplicit;
use coupler::schemes::{Accepted, Coupled, Onward, Pair, Run, SchemeError};
use coupler::side::Side;
use interfaces::case::coupling::StructureVelocity::{self, End, Mean};
use interfaces::port::names;
use interfaces::{Guarded, Participant, SubSteps, pairing};
use partners::{Log, Recording, build};

const EXPLICIT: SerialExplicit = SerialExplicit { relaxation: 1.0, enforce: true, predict: true };

fn mock(words: &str) -> Box<dyn Participant> {
    build(words).expect("a mock")
}

fn side(participant: impl Participant + 'static) -> Side {
    Side::new(Box::new(Guarded::new(participant)))
}

fn pair(fluid: &str, structure: &str) -> Pair {
    Pair::initialize(side(mock(fluid)), side(mock(structure)), 0.0, Mean).expect("mocks that fit")
}

#[test]
fn a_window_is_predicted_solved_and_accepted_in_this_order() {
    let log = Log::default();
    let recorded = |words| side(Recording::new(mock(words), log.clone()));
    // The fluid asks for windows of 4 ms; outputs are due every 10 ms: three windows each.
    let fluid = recorded("constant gradient=1e3 window_limit=0.004");
    let structure = recorded("spring-mass points=3 window_limit=0.005");
    let pair = Pair::initialize(fluid, structure, 0.0, Mean).expect("mocks that fit");
    let mut accepted: Vec<Accepted> = Vec::new();
    let mut driven = Run {
        solver: Coupled::new(pair, EXPLICIT),
        schedule: Schedule::new(0.0, 0.02, 0.01, 1.0, SubSteps::Fixed(100)),
    };
    let result = driven.drive(|window, _| {
        accepted.push(*window);
        Ok(Onward::Continue)
    });
    let Run { schedule, .. } = driven;
    result.expect("mocks do not fail");
    let mut expected = vec!["structure initialize".to_owned(), "fluid initialize".to_owned()];
    for window in 0..6 {
        let snapshot = ["", "", " #1", "", "", " #2"][window];
        expected.extend([
            format!("structure start {window}.0"),
            "structure finish".to_owned(),
            format!("fluid start {window}.0"),
            "fluid finish".to_owned(),
            format!("structure start {window}.1"),
            "structure finish".to_owned(),
            format!("fluid accept{snapshot}"),
            format!("structure accept{snapshot}"),
        ]);
    }
    assert_eq!(log.brief(), expected);
    assert_eq!(schedule.windows(), 6);
    let times: Vec<_> = accepted.iter().map(|a| (a.window.index, a.output)).collect();
    assert_eq!(times, [(0, None), (1, None), (2, Some(1)), (3, None), (4, None), (5, Some(2))]);
    assert_eq!((accepted[2].time, accepted[5].time), (0.01, 0.02));
    for (before, after) in accepted.iter().zip(&accepted[1..]) {
        assert_eq!(before.time, after.window.start, "windows follow each other without a gap");
    }
    for call in log.calls().iter().filter_map(|call| call.window) {
        assert_eq!(call.sub_steps, SubSteps::Fixed(100));
        // An output interval in three equal parts, up to the rounding of sums.
        assert!((call.size - 0.01 / 3.0).abs() < 1e-15);
    }
}

#[test]
fn each_side_gets_what_the_scheme_says() {
    let log = Log::default();
    let recorded = |words| side(Recording::new(mock(words), log.clone()));
    let fluid = recorded("added-mass-column mass=20 wall=compliant");
    let pair =
        Pair::initialize(fluid, recorded("spring-mass points=4 velocity=0,1"), 0.0, Mean).expect("they fit");
    let relaxed = SerialExplicit { relaxation: 0.25, ..EXPLICIT };
    let mut driven = Run {
        solver: Coupled::new(pair, relaxed),
        schedule: Schedule::new(0.0, 0.002, 1.0, 0.001, SubSteps::Stable),
    };
    driven.drive(|_, _| Ok(Onward::Continue)).expect("mocks do not fail");
    let calls = log.calls();
    let field = |call: usize, name: &str| {
        let calls = &calls[call];
        let fields = calls.inputs.as_ref().or(calls.outputs.as_ref()).expect("a call with fields");
        fields.get(name).expect("a field of it").to_vec()
    };
    // Calls of the second window: structure start 10, finish 11, fluid start 12, finish 13, structure start
    // 14, finish 15.
    let (accepted, predicted) = (field(7, names::POSITION), field(11, names::POSITION));
    assert_eq!(field(10, names::PRESSURE_GRADIENT), field(6, names::PRESSURE_GRADIENT), "the load held");
    assert_eq!(field(12, names::HELD_PRESSURE_GRADIENT), field(10, names::PRESSURE_GRADIENT));
    assert_eq!(field(12, names::POSITION), accepted, "where the structure was at the start");
    let size = calls[12].window.expect("a start").size;
    let mean: Vec<f64> = predicted.iter().zip(&accepted).map(|(end, start)| (end - start) / size).collect();
    assert_eq!(field(12, names::VELOCITY), mean, "its mean velocity as predicted");
    let (new, held) = (field(13, names::PRESSURE_GRADIENT), field(10, names::PRESSURE_GRADIENT));
    let load: Vec<f64> = new.iter().zip(&held).map(|(new, held)| 0.25 * new + 0.75 * held).collect();
    assert_eq!(field(14, names::PRESSURE_GRADIENT), load, "the load relaxed");
}

#[test]
fn a_scripted_structure_sees_what_it_must() {
    let solution = |iteration: u32| {
        serde_json::json!({
            "window": {
                "index": 0, "iteration": iteration, "start": 0.0, "size": 0.25,
                "sub_steps": serde_json::to_value(SubSteps::Fixed(7)).expect("JSON"),
            },
            "expected": { "pressure_gradient": [0.0, 3.0] },
            "given": { "position": [0.0, 1.5] },
            "report": { "sub_steps": 7, "window_limit": 1e9, "compute_seconds": 0.0, "scalars": [] },
            "accepted": iteration == 1,
        })
    };
    let script = serde_json::json!({
        "description": {
            "role": "structure", "solver": "script", "dimension": 2, "scalars": [],
            "ports": mock("spring-mass points=1").describe().ports,
        },
        "given": { "reference_volume": [0.5], "density": [1000.0], "position": [0.0, 1.0] },
        "readiness": { "window_limit": 1e9, "scalars": [] },
        "solutions": [solution(0), solution(1)],
    });
    let bench = crate::support::Bench::new();
    let file = bench.path("script.json");
    std::fs::write(&file, script.to_string()).expect("a script");
    let pair = pair("constant gradient=0,3", &format!("scripted file={}", file.display()));
    let mut driven = Run {
        solver: Coupled::new(pair, EXPLICIT),
        schedule: Schedule::new(0.0, 0.25, 0.25, 1.0, SubSteps::Fixed(7)),
    };
    driven.drive(|_, _| Ok(Onward::Continue)).expect("the script is kept");
    driven.solver.pair.structure.terminate().expect("nothing of the script is left over");
}

#[test]
fn one_side_alone_and_a_stop() {
    let log = Log::default();
    let mut alone_side = side(Recording::new(mock("spring-mass displacement=0,0.01"), log.clone()));
    alone_side.initialize(0.0, 10, None).expect("a mock");
    let mut driven =
        Run { solver: alone_side, schedule: Schedule::new(0.0, 1.0, 0.5, 0.1, SubSteps::Stable) };
    let result = driven
        .drive(|accepted, _| Ok(if accepted.window.index == 1 { Onward::Stop } else { Onward::Continue }));
    result.expect("a mock does not fail");
    let window =
        |n: u32| [format!("structure start {n}.0"), "structure finish".into(), "structure accept".into()];
    assert_eq!(
        log.brief(),
        [vec!["structure initialize".to_owned()], [window(0), window(1)].concat()].concat()
    );
    assert_eq!((driven.schedule.windows(), driven.schedule.finished()), (2, false));
}

#[test]
fn ports_that_do_not_fit_are_named() {
    let mismatches = |fluid: &str, structure: &str| {
        pairing::compare(mock(structure).describe(), mock(fluid).describe()).join("\n")
    };
    assert_eq!(mismatches("constant", "rigid"), "");
    let found = mismatches("constant dimension=3", "rigid");
    assert!(found.contains("dimension: the structure has 2, the fluid has 3"), "{found}");
    assert!(
        found.contains("components of port `position`: the fluid takes 3, the structure gives 2"),
        "{found}"
    );
}

/// A fluid whose load is all it gives.
struct Taciturn(Box<dyn Participant>, interfaces::Description);

impl Taciturn {
    fn new(words: &str) -> Self {
        let inner = mock(words);
        let mut description = inner.describe().clone();
        description
            .ports
            .retain(|p| ![names::PAIR_REACTION, names::NORMAL, names::PRESSURE].contains(&p.name.as_str()));
        Self(inner, description)
    }

    fn all(&self, outputs: &interfaces::Fields) -> interfaces::Fields {
        let points = outputs.ports()[0].points.unwrap_or(0);
        self.0.describe().fields(interfaces::Direction::Out, points)
    }
}

impl Participant for Taciturn {
    fn describe(&self) -> &interfaces::Description {
        &self.1
    }
    fn initialize(
        &mut self,
        start: f64,
        inputs: &interfaces::Fields,
        outputs: &mut interfaces::Fields,
    ) -> Result<interfaces::Readiness, interfaces::ParticipantError> {
        let mut all = self.all(outputs);
        let ready = self.0.initialize(start, inputs, &mut all)?;
        outputs.copy_from(&all, |_| true)?;
        Ok(ready)
    }
    fn start(
        &mut self,
        window: &interfaces::TimeWindow,
        inputs: &interfaces::Fields,
    ) -> Result<(), interfaces::ParticipantError> {
        self.0.start(window, inputs)
    }
    fn finish(
        &mut self,
        outputs: &mut interfaces::Fields,
    ) -> Result<interfaces::WindowReport, interfaces::ParticipantError> {
        let mut all = self.all(outputs);
        let report = self.0.finish(&mut all)?;
        outputs.copy_from(&all, |_| true)?;
        Ok(report)
    }
    fn accept(&mut self, snapshot: Option<u64>) -> Result<(), interfaces::ParticipantError> {
        self.0.accept(snapshot)
    }
    fn save(&mut self) -> Result<Vec<u8>, interfaces::ParticipantError> {
        self.0.save()
    }
    fn restore(
        &mut self,
        state: &[u8],
        outputs: &mut interfaces::Fields,
    ) -> Result<interfaces::Readiness, interfaces::ParticipantError> {
        let mut all = self.all(outputs);
        let ready = self.0.restore(state, &mut all)?;
        outputs.copy_from(&all, |port| port.exchange == interfaces::Exchange::EveryWindow)?;
        Ok(ready)
    }
    fn terminate(&mut self) -> Result<(), interfaces::ParticipantError> {
        self.0.terminate()
    }
}

#[test]
fn a_fluid_that_gives_a_load_alone_is_taken_at_its_word() {
    let words = "constant gradient=0,1e4";
    let positions: Vec<f64> = [side(mock(words)), side(Taciturn::new(words))]
        .into_iter()
        .map(|fluid| {
            let pair = Pair::initialize(fluid, side(mock("spring-mass")), 0.0, Mean).expect("they fit");
            let mut driven = Run {
                solver: Coupled::new(pair, EXPLICIT),
                schedule: Schedule::new(0.0, 0.05, 0.01, 0.001, SubSteps::Stable),
            };
            let run = driven.drive(|accepted, _| {
                let condition = accepted.condition46.expect("a coupled window");
                assert_eq!((condition.residual_before, condition.residual_after), (0.0, 0.0));
                Ok(Onward::Continue)
            });
            let Run { solver: Coupled { pair, .. }, .. } = driven;
            run.expect("mocks do not fail");
            pair.structure.outputs.get(names::POSITION).expect("given")[1]
        })
        .collect();
    assert_eq!(positions[0], positions[1]);
    assert!(positions[0] < 0.0, "a gradient upwards pushes downwards: {positions:?}");
}

#[test]
fn a_participant_that_leaves_an_error_in_condition_46_is_corrected() {
    // It says that it received 0.9 of what it gives: a tenth of the load is missing along the normals.
    let pair = pair("constant gradient=0,1e4 reaction_factor=0.9", "spring-mass");
    let mut driven = Run {
        solver: Coupled::new(pair, EXPLICIT),
        schedule: Schedule::new(0.0, 0.01, 0.01, 0.001, SubSteps::Stable),
    };
    let run = driven.drive(|accepted, _| {
        let condition = accepted.condition46.expect("a coupled window");
        assert!(condition.residual_before > 0.05, "{condition:?}");
        // Sums over ten points.
        assert!(condition.residual_after < 1e-14, "{condition:?}");
        Ok(Onward::Continue)
    });
    run.expect("mocks do not fail");
}

/// Largest displacement of a mass on a spring under a column of `mass_ratio` times its mass, over the first
/// and over the last quarter of `windows` windows, each of `phase = ω_s Δt` of the structure alone.
fn amplitudes(
    (mass_ratio, phase): (f64, f64),
    windows: usize,
    scheme: SerialExplicit,
    velocity: StructureVelocity,
    wall: &str,
) -> (f64, f64) {
    // Ten points of 0.01 m² at 1000 kg/m³: 1 kg. Spring 4 kN/m.
    let (mass, stiffness) = (1.0, 4e3_f64);
    let size = phase / (stiffness / mass).sqrt();
    let fluid = format!("added-mass-column {wall} mass={}", mass_ratio * mass);
    let structure = format!("spring-mass stiffness={stiffness} displacement=0,0.01");
    let pair = Pair::initialize(side(mock(&fluid)), side(mock(&structure)), 0.0, velocity).expect("they fit");
    let end = size * windows as f64;
    let mut heights = Vec::with_capacity(windows);
    let mut driven = Run {
        solver: Coupled::new(pair, scheme),
        schedule: Schedule::new(0.0, end, end, size, SubSteps::Stable),
    };
    let run = driven.drive(|_, Coupled { pair, .. }| {
        heights.push(pair.structure.scalars[1].abs());
        Ok(Onward::Continue)
    });
    // What diverges ends as not a number at last, which is refused at the boundary.
    assert!(run.is_ok() || heights.iter().any(|h| *h > 1e100), "{run:?}");
    let largest = |part: &[f64]| part.iter().fold(0.0_f64, |m, h| m.max(*h));
    let quarter = heights.len() / 4;
    assert!(quarter > 1 && heights[0] > 0.0, "{} windows", heights.len());
    (largest(&heights[..quarter]), largest(&heights[heights.len() - quarter..]))
}

/// `ω_s Δt` of the structure from a hundredth to three of its periods.
const PHASES: [f64; 12] = [0.01, 0.1, 0.5, 1.0, 2.0, 3.0, 3.3, 4.5, 6.0, 9.6, 15.0, 20.0];

#[test]
fn a_compliant_fluid_that_meets_the_mean_velocity_is_stable_for_any_mass_and_stiffness() {
    for mass_ratio in [0.5, 9.0, 100.0] {
        for phase in PHASES {
            for relaxation in [0.3, 1.0] {
                let scheme = SerialExplicit { relaxation, ..EXPLICIT };
                let (first, last) = amplitudes((mass_ratio, phase), 2000, scheme, Mean, "wall=compliant");
                // The eigenvalues stand within the unit circle; 2000 windows may add their round-off.
                assert!(last <= first * (1.0 + 1e-9), "{mass_ratio} {phase} {relaxation}: {first} {last}");
                // The first window has the load from before it: none. It then swings as a dry one, and no
                // further.
                assert!(first < 0.03, "{mass_ratio} {phase} {relaxation}: {first}");
            }
        }
    }
}

#[test]
fn the_end_velocity_grows_where_the_structure_answers_with_the_wrong_sign() {
    let half = SerialExplicit { relaxation: 0.5, ..EXPLICIT };
    for mass_ratio in [0.5, 9.0] {
        // sin ω_s Δt < 0: growth of 1.038 and 1.083 a window at 3.2, by the eigenvalues of the linear
        // recursion.
        let (first, last) = amplitudes((mass_ratio, 3.2), 400, half, End, "wall=compliant velocity=end");
        assert!(last > 100.0 * first, "{mass_ratio}: {first} {last}");
        for phase in [0.01, 0.5, 2.0, 3.0] {
            let (first, last) =
                amplitudes((mass_ratio, phase), 400, half, End, "wall=compliant velocity=end");
            assert!(last <= first * (1.0 + 1e-9), "{mass_ratio} {phase}: {first} {last}");
        }
    }
}

/// The structure's velocity against the column's, `d`, and the load's share in it over a window,
/// `f = Δt F/m_s`, follow, for windows that are short against the period, `d' = −μ d − (1 + μ) f`,
/// `f' = −μ d − μ f`: roots `−μ ± √(μ² + μ)`, outside the unit circle for `μ > 1/3`.
#[test]
fn a_moving_wall_diverges_from_a_third_of_the_structures_mass_whatever_the_window() {
    for phase in [0.001, 0.1] {
        for (mass_ratio, grows) in [(0.1, false), (0.3, false), (0.4, true), (1.0, true), (9.0, true)] {
            let (first, last) = amplitudes((mass_ratio, phase), 400, EXPLICIT, End, "wall=moving");
            // The slowest growth is 1.15 a window, at 0.4; what does not grow swings as a heavier mass does,
            // by no more than it began with.
            let factor = last / first.max(0.01);
            assert_eq!(factor > 10.0, grows, "{mass_ratio} {phase}: {first} {last}");
        }
    }
}

#[test]
fn a_failure_is_told_with_side_window_and_reason() {
    let pair = pair("constant gradient=1e3 --fault error@3", "spring-mass");
    let mut driven = Run {
        solver: Coupled::new(pair, EXPLICIT),
        schedule: Schedule::new(0.0, 1.0, 0.1, 0.1, SubSteps::Stable),
    };
    let error = driven.drive(|_, _| Ok(Onward::Continue)).expect_err("a fault");
    let Run { schedule, .. } = driven;
    let SchemeError::Side(side) = &error else { panic!("{error:?}") };
    assert_eq!(side.role, interfaces::Role::Fluid);
    let text = error.to_string();
    assert!(text.starts_with("the fluid failed while solving window 3 (iteration 0) from t = 0.3"), "{text}");
    assert!(text.ends_with("fault as told: an error in `finish`, window 3, iteration 0"), "{text}");
    assert_eq!(schedule.windows(), 3);
}
