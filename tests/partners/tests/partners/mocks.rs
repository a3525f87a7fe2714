//! Mocks from words, their loads, records, scripts and faults.

use interfaces::port::names;
use interfaces::{Direction, Fields, Guarded, Participant, ParticipantError, SubSteps, TimeWindow};
use partners::scripted::{Arrays, Solution};
use partners::{Fault, Faulty, Log, MockSpec, Recording, Script, Scripted, build, help};
use std::os::unix::process::ExitStatusExt;

const WINDOW: TimeWindow =
    TimeWindow { index: 0, iteration: 0, start: 0.0, size: 0.1, sub_steps: SubSteps::Fixed(2) };

fn fields(mock: &dyn Participant, points: usize) -> (Fields, Fields) {
    let description = mock.describe();
    (description.fields(Direction::In, points), description.fields(Direction::Out, points))
}

#[test]
fn a_spring_under_a_held_load_moves_by_the_exact_solution() {
    // m = 4 points · 0.01 m³ · 1000 kg/m³ = 40 kg, k = 4000 N/m: ω = 10/s. F = −4 · 0.01 · (−1000) = 40 N:
    // rest at 1 cm.
    for (integration, tolerance) in [("exact", 1e-14), ("rk4", 1e-8_f64)] {
        let words = format!("spring-mass points=4 spacing=0.1 stiffness=4000 integration={integration}");
        let mut mock = build(&words).expect("a mock");
        let (mut load, mut motion) = fields(&*mock, 0);
        mock.initialize(0.0, &load, &mut motion).expect("a start");
        let gradient = load.get_mut(names::PRESSURE_GRADIENT).expect("taken");
        gradient.chunks_exact_mut(2).for_each(|g| g[1] = -1000.0);
        for index in 0..20 {
            let start = 0.1 * index as f64;
            // Runge–Kutta with ω Δt = 0.01: error ω t (ω Δt)⁴/120 of 1 cm after 2 s is 2e-11.
            let window = TimeWindow { index, start, sub_steps: SubSteps::Fixed(100), ..WINDOW };
            mock.start(&window, &load).expect("a solution");
            let report = mock.finish(&mut motion).expect("a solution");
            mock.accept(None).expect("a solution");
            let (u, v) = (0.01 * (1.0 - (10.0 * window.end()).cos()), 0.1 * (10.0 * window.end()).sin());
            let at = |name, i: usize| motion.get(name).expect("given")[i];
            assert!((at(names::POSITION, 1) - u).abs() < tolerance, "{integration} {index}");
            assert!((at(names::VELOCITY, 7) - v).abs() < 10.0 * tolerance);
            assert!((at(names::POSITION, 6) - 0.3).abs() < 1e-15);
            assert_eq!(report.sub_steps, 100);
            // Kinetic and elastic energy are the work of the load, 0.8 J at most, up to the integration's
            // error.
            let [kinetic, elastic, work] = report.scalars[2..] else { panic!("three energies") };
            assert!((kinetic + elastic - work).abs() < 1e-7 * 0.8, "{kinetic} {elastic} {work}");
        }
    }
}

#[test]
fn water_buoys_a_body_and_weighs_on_a_plate() {
    for (words, gradient) in
        [("hydrostatic level=1", -9810.0), ("hydrostatic level=1 plate_thickness=0.5", 9810.0)]
    {
        let mut mock = build(words).expect("a mock");
        let (mut motion, mut load) = fields(&*mock, 2);
        motion.get_mut(names::POSITION).expect("taken").copy_from_slice(&[0.0, 0.5, 0.0, 1.5]);
        motion.get_mut(names::REFERENCE_VOLUME).expect("taken").fill(0.01);
        let ready = mock.initialize(0.0, &motion, &mut load).expect("a start");
        // Half a metre under the surface: 4905 Pa; the second point is in the air.
        assert_eq!(load.get(names::PRESSURE).expect("given"), [4905.0, 0.0]);
        assert_eq!(load.get(names::PRESSURE_GRADIENT).expect("given"), [0.0, gradient, 0.0, 0.0]);
        assert_eq!(load.get(names::PAIR_REACTION).expect("given"), [0.0, gradient, 0.0, 0.0]);
        assert_eq!(load.get(names::NORMAL).expect("given"), [0.0, f64::signum(gradient), 0.0, 0.0]);
        assert_eq!(ready.scalars[1], -0.01 * gradient);
    }
}

#[test]
fn words_are_read_and_mistakes_told_together() {
    let one: MockSpec = "spring-mass --points 3 --dimension=3 stiffness=5".parse().expect("words");
    let other = MockSpec::from_words(&["spring-mass", "points=3", "--dimension", "3", "--stiffness", "5"]);
    assert_eq!(one, other.expect("words"));
    assert_eq!(one.build().expect("a mock").describe().ports[0].points, Some(3));

    let mistakes = |words: &str| build(words).err().expect(words).0;
    assert!(mistakes("")[0].starts_with("no kind is named: one of rigid, prescribed"));
    assert!(mistakes("jelly")[0].starts_with("there is no mock `jelly`: one of rigid"));
    let unknown = mistakes("rigid points=3 points=4 mass=3 oops --fault no@where --spacing");
    assert_eq!(unknown.len(), 5, "{unknown:?}");
    assert!(unknown[1].starts_with("`rigid` has no option `mass`: it has points, grid"));
    assert_eq!(
        mistakes("spring-mass points=0 stiffness=-1 displacement=1,2,3 window_limit=0"),
        [
            "option `window_limit` is `0`, which is not a positive number",
            "option `stiffness` is `-1`, which is not a number of at least 0",
            "option `displacement` is `1,2,3`, which is not one number or 2 numbers with commas",
            "option `points` is `0`, which is not a positive whole number",
        ]
    );
    assert_eq!(mistakes("hydrostatic"), ["option `level` must be given: height H of the surface (m)"]);
    assert!(mistakes("rigid grid=3x0")[0].contains("2 positive whole numbers"));
    assert!(mistakes("added-mass-column mass=1 axis=z")[0].contains("three dimensions"));
    assert!(mistakes("scripted file=nowhere.json")[0].starts_with("failed to read the script nowhere.json"));
    for kind in
        ["rigid", "prescribed", "spring-mass", "hydrostatic", "constant", "added-mass-column", "scripted"]
    {
        assert!(help().contains(&format!("{kind}: ")), "{kind}");
    }
}

#[test]
fn the_log_holds_the_order_of_calls_of_both_sides() {
    let log = Log::default();
    let mut structure = Recording::new(build("rigid points=2").expect("a mock"), log.clone());
    let mut fluid = Recording::new(build("constant gradient=3").expect("a mock"), log.clone());
    let (load, mut motion) = fields(&structure, 0);
    let (taken, mut answer) = fields(&fluid, 2);
    structure.initialize(0.5, &load, &mut motion).expect("a start");
    fluid.initialize(0.5, &taken, &mut answer).expect("a start");
    fluid.start(&WINDOW, &taken).expect("a solution");
    fluid.finish(&mut answer).expect("a solution");
    fluid.accept(Some(7)).expect("a solution");
    structure.restore(&[1, 2, 3], &mut motion).expect_err("no state");
    structure.terminate().expect("an end");
    assert_eq!(
        log.brief(),
        [
            "structure initialize",
            "fluid initialize",
            "fluid start 0.0",
            "fluid finish",
            "fluid accept #7",
            "structure restore",
            "structure terminate"
        ]
    );
    let calls = log.calls();
    assert_eq!((calls[0].start, calls[2].window), (Some(0.5), Some(WINDOW)));
    assert_eq!(calls[3].outputs.as_ref().and_then(|f| f.get(names::PRESSURE_GRADIENT)), Some(&[3.0; 4][..]));
    assert!(
        calls[5].error.as_ref().is_some_and(|e| e.contains("does not start with"))
            && calls[5].bytes == Some(3)
    );
}

fn script() -> Script {
    let mut mock = build("rigid points=1").expect("a mock");
    let (load, mut motion) = fields(&*mock, 0);
    let readiness = mock.initialize(0.0, &load, &mut motion).expect("a start");
    let one = |name: &str, values: [f64; 2]| Arrays::from([(name.to_owned(), values.to_vec())]);
    mock.start(&WINDOW, &load).expect("a solution");
    let report = mock.finish(&mut motion).expect("a solution");
    let limit = 1e9;
    let solution = |iteration, load, accepted| Solution {
        window: TimeWindow { iteration, ..WINDOW },
        expected: one(names::PRESSURE_GRADIENT, [0.0, load]),
        given: one(names::POSITION, [0.0, 0.5 * load]),
        report: interfaces::WindowReport { window_limit: limit, ..report.clone() },
        accepted,
    };
    Script {
        description: mock.describe().clone(),
        expected: one(names::PRESSURE_GRADIENT, [0.0, 0.0]),
        given: one(names::POSITION, [1.0, 2.0]),
        readiness: interfaces::Readiness { window_limit: limit, ..readiness },
        solutions: vec![solution(0, 1.0, false), solution(1, 2.0, true)],
        tolerance: 1e-12,
    }
}

#[test]
fn a_script_is_played_and_left_with_a_complaint() {
    // Through a file, as the command line would.
    let file = tempfile::NamedTempFile::new().expect("a temporary file");
    serde_json::to_writer(&file, &script()).expect("a script that can be written");
    let path = file.path().to_str().expect("a path in UTF-8");
    let mut mock =
        MockSpec::from_words(&["scripted", "--file", path]).and_then(|s| s.build()).expect("a mock");
    let (mut load, mut motion) = fields(&*mock, 0);
    mock.initialize(0.0, &load, &mut motion).expect("a start");
    assert_eq!(motion.get(names::POSITION), Some(&[1.0, 2.0][..]));
    for (iteration, value) in [(0, 1.0), (1, 2.0)] {
        load.get_mut(names::PRESSURE_GRADIENT).expect("taken")[1] = value;
        mock.start(&TimeWindow { iteration, ..WINDOW }, &load).expect("what the script expects");
        mock.finish(&mut motion).expect("what the script expects");
        assert_eq!(motion.get(names::POSITION), Some(&[0.0, 0.5 * value][..]));
    }
    mock.accept(None).expect("what the script expects");
    mock.terminate().expect("the end of the script");

    let mut mock = Scripted::new(script());
    let (mut load, mut motion) = fields(&mock, 0);
    mock.initialize(0.0, &load, &mut motion).expect("a start");
    let early = mock.terminate().expect_err("solutions are left").to_string();
    assert!(early.contains("2 solution(s) left over"), "{early}");
    let wrong = mock.start(&WINDOW, &load).expect_err("another load").to_string();
    assert_eq!(
        wrong,
        "the coupler left the script at solution 0: `pressure_gradient`[1] is 0 where the script has 1"
    );
    let other =
        mock.start(&TimeWindow { index: 1, ..WINDOW }, &load).expect_err("another window").to_string();
    assert!(other.contains("window 1, iteration 0, where the script has window 0, iteration 0"), "{other}");
    load.get_mut(names::PRESSURE_GRADIENT).expect("taken")[1] = 1.0;
    mock.start(&WINDOW, &load).expect("what the script expects");
    mock.finish(&mut motion).expect("what the script expects");
    mock.accept(None).expect_err("the first solution is not accepted");
    assert_eq!(mock.played(), 1);
}

#[test]
fn a_fault_strikes_at_its_place_only() {
    let faults = ["nan:1@0.1", "error@1/start", "slow:0.001@*"].map(|f| f.parse().expect("a fault"));
    let mut mock = Faulty::new(build("rigid points=2").expect("a mock"), faults.to_vec());
    let (load, mut motion) = fields(&mock, 0);
    mock.initialize(0.0, &load, &mut motion).expect("a start");
    for iteration in 0..3 {
        mock.start(&TimeWindow { iteration, ..WINDOW }, &load).expect("no fault here");
        mock.finish(&mut motion).expect("no error here");
        let position = motion.get(names::POSITION).expect("given");
        assert_eq!(position.iter().position(|x| x.is_nan()), (iteration == 1).then_some(2));
    }
    mock.accept(None).expect("no fault here");
    let message = mock.start(&TimeWindow { index: 1, ..WINDOW }, &load).expect_err("a fault").to_string();
    assert_eq!(message, "fault as told: an error in `start`, window 1, iteration 0");
    let panics = std::panic::catch_unwind(|| {
        let fault: Fault = "panic@terminate".parse().expect("a fault");
        Faulty::new(build("rigid").expect("a mock"), vec![fault]).terminate()
    });
    assert!(panics.is_err());
}

#[test]
fn a_guarded_participant_that_panics_has_failed_for_good() {
    let fault: Fault = "panic@0/start".parse().expect("a fault");
    let mut mock = Guarded::new(Faulty::new(build("rigid").expect("a mock"), vec![fault]));
    let (load, mut motion) = fields(&mock, 0);
    mock.initialize(0.0, &load, &mut motion).expect("a start");
    let message = mock.start(&WINDOW, &load).expect_err("a fault").to_string();
    assert!(message.starts_with("it panicked: fault as told"), "{message}");
    assert!(matches!(mock.save(), Err(ParticipantError::IllegalCall(_))));
    mock.terminate().expect("the only call that a broken participant takes");
}

/// Not a test of its own: the process that `deadly_faults_end_the_process` starts.
#[test]
fn victim() {
    if let Ok(fault) = std::env::var("PARTNERS_TEST_FAULT") {
        let mut mock = build(&format!("rigid --fault {fault}")).expect("a mock");
        let (load, mut motion) = fields(&*mock, 0);
        mock.initialize(0.0, &load, &mut motion).expect("a start");
        mock.start(&WINDOW, &load).expect("no fault here");
        mock.finish(&mut motion).expect("only death here");
        panic!("it outlived its fault");
    }
}

#[test]
fn deadly_faults_end_the_process() {
    // SIGKILL is 9 and SIGABRT is 6 on every Linux.
    for (fault, signal) in [("kill@0", 9), ("abort@0", 6)] {
        let program = std::env::current_exe().expect("the test program");
        let ended = std::process::Command::new(program)
            .args(["--exact", "mocks::victim"])
            .env("PARTNERS_TEST_FAULT", fault)
            .output()
            .expect("a process that starts");
        assert_eq!(ended.status.signal(), Some(signal), "{fault}: {ended:?}");
    }
}
