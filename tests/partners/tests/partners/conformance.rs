//! The suite over every mock, and the suite itself over participants that break the contract.

use interfaces::{Description, Exchange, Fields, Participant, Readiness, Result};
use interfaces::{SubSteps, TimeWindow, WindowReport};
use partners::conformance::{Options, check, plausible};
use partners::{Log, Recording, build};

const MOCKS: [&str; 19] = [
    "rigid points=4",
    "rigid dimension=3 grid=2x3x2",
    "prescribed",
    "prescribed dimension=3 law=constant-velocity velocity=1,0,-2",
    "prescribed law=swing pivot=0,1 duration=0.3",
    "spring-mass points=40 stiffness=1e4 damping=3 displacement=0.01",
    "spring-mass dimension=3 grid=4x1x1 integration=rk4 velocity=0,0,1 window_limit=1e-3",
    "hydrostatic level=0.03",
    "surface-pressure outline=4x2 level=0.03",
    "hydrostatic dimension=3 level=0.03 plate_thickness=0.02 reaction_factor=0.9",
    "constant gradient=100,-20 pressure=5",
    "constant dimension=3 gradient=100",
    "spring-mass load=linear",
    "spring-mass outline=4x2 load=linear",
    "prescribed outline=3x1 law=swing pivot=0,1 duration=0.3",
    "harmonic gradient=3 frequency=2",
    "added-mass-column mass=2 gravity=9.81",
    "added-mass-column mass=2 wall=compliant axis=x",
    "added-mass-column dimension=3 mass=2 wall=compliant area=0.1",
];

#[test]
fn every_mock_conforms() {
    for words in MOCKS {
        let make = || build(words).unwrap_or_else(|error| panic!("{words}: {error}"));
        for (sub_steps, points) in [(SubSteps::Fixed(3), 5), (SubSteps::Stable, 5), (SubSteps::Fixed(100), 1)]
        {
            let options = Options { sub_steps, points, ..Options::default() };
            check(make, &options).unwrap_or_else(|broken| panic!("{words}: {broken}"));
        }
        let recorded = || Box::new(Recording::new(make(), Log::default())) as Box<dyn Participant>;
        check(recorded, &Options::default()).unwrap_or_else(|broken| panic!("{words}, recorded: {broken}"));
    }
}

#[test]
fn faults_are_found() {
    for (fault, finding) in [
        ("nan:2@1", "field `position` is not finite: component 0 at point 2"),
        ("no-points@1", "shape"),
        ("scalars@1", "it reports 6 scalars where it described 5"),
        ("limit:0@1", "window limit is 0 s"),
        ("limit:nan@initialize", "window limit is NaN s"),
        ("scalars@initialize", "it reports 6 scalars"),
        ("error@accept", "`accept` failed"),
        ("error@save", "saving and restoring: `save` failed"),
        ("error@terminate", "`terminate` failed"),
        ("error@*.1", "solving again: `finish` failed in window 1, iteration 1"),
    ] {
        let make = || build(&format!("spring-mass --fault {fault}")).expect("a mock with a fault");
        let broken = check(make, &Options::default()).expect_err(fault).to_string();
        assert!(broken.contains(finding), "{fault}: {broken}");
    }
}

/// A participant that keeps its own state wrongly around one that is right.
struct Careless {
    inner: Box<dyn Participant>,
    flaw: Flaw,
    solutions: u32,
}

#[derive(Clone, Copy)]
enum Flaw {
    /// What it gives depends on how often it solved.
    Counts,
    /// It never writes velocities.
    LeavesOut,
    /// It writes constants every window.
    Rewrites,
    /// It restores nothing.
    Forgets,
    /// It restores, and does not say what stands there.
    Withholds,
}

impl Participant for Careless {
    fn describe(&self) -> &Description {
        self.inner.describe()
    }
    fn initialize(&mut self, t: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        self.inner.initialize(t, inputs, outputs)
    }
    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        self.inner.start(window, inputs)
    }
    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        self.solutions += 1;
        let before = outputs.get("velocity").expect("a structure's field").to_vec();
        let report = self.inner.finish(outputs)?;
        match self.flaw {
            Flaw::Counts => {
                outputs.get_mut("position").expect("a field")[0] += f64::from(self.solutions) * 1e-9;
            }
            Flaw::LeavesOut => outputs.get_mut("velocity").expect("a field").copy_from_slice(&before),
            Flaw::Rewrites => {
                let constants = outputs.iter_mut().filter(|(port, _)| port.exchange == Exchange::Constant);
                constants.for_each(|(_, array)| array.fill(1000.0));
            }
            Flaw::Forgets | Flaw::Withholds => {}
        }
        Ok(report)
    }
    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        self.inner.accept(snapshot)
    }
    fn save(&mut self) -> Result<Vec<u8>> {
        self.inner.save()
    }
    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        match self.flaw {
            Flaw::Forgets => {
                let now = self.inner.save()?;
                self.inner.restore(&now, outputs)
            }
            Flaw::Withholds => {
                let before = outputs.clone();
                let ready = self.inner.restore(state, outputs)?;
                outputs.copy_from(&before, |_| true)?;
                Ok(ready)
            }
            _ => self.inner.restore(state, outputs),
        }
    }
    fn terminate(&mut self) -> Result<()> {
        self.inner.terminate()
    }
}

#[test]
fn careless_participants_are_found() {
    for (flaw, finding) in [
        (Flaw::Counts, "solving again: the same input twice, another between: output 0"),
        (Flaw::LeavesOut, "solving again: over outputs that held something else"),
        (Flaw::Rewrites, "`finish` wrote the constant field `reference_volume`"),
        (Flaw::Forgets, "saving and restoring: when it was saved and when it was restored: output"),
        (Flaw::Withholds, "saving and restoring: when it was saved and when it was restored: output"),
    ] {
        let make = || {
            let inner = build("spring-mass velocity=1").expect("a mock");
            Box::new(Careless { inner, flaw, solutions: 0 }) as Box<dyn Participant>
        };
        let broken = check(make, &Options::default()).expect_err(finding).to_string();
        assert!(broken.contains(finding), "{broken}");
    }
}

#[test]
fn a_wrong_description_ends_the_suite() {
    struct Renamed(Description);
    impl Participant for Renamed {
        fn describe(&self) -> &Description {
            &self.0
        }
        fn initialize(&mut self, _: f64, _: &Fields, _: &mut Fields) -> Result<Readiness> {
            unreachable!("the suite ends before")
        }
        fn start(&mut self, _: &TimeWindow, _: &Fields) -> Result<()> {
            unreachable!("the suite ends before")
        }
        fn finish(&mut self, _: &mut Fields) -> Result<WindowReport> {
            unreachable!("the suite ends before")
        }
        fn accept(&mut self, _: Option<u64>) -> Result<()> {
            unreachable!("the suite ends before")
        }
        fn save(&mut self) -> Result<Vec<u8>> {
            unreachable!("the suite ends before")
        }
        fn restore(&mut self, _: &[u8], _: &mut Fields) -> Result<Readiness> {
            unreachable!("the suite ends before")
        }
        fn terminate(&mut self) -> Result<()> {
            unreachable!("the suite ends before")
        }
    }
    let make = || {
        let mut description = build("rigid").expect("a mock").describe().clone();
        description.ports[0].unit = "mm".to_owned();
        description.ports[1].name = "position".to_owned();
        description.scalars[0].unit.clear();
        Box::new(Renamed(description)) as Box<dyn Participant>
    };
    let broken = check(make, &Options::default()).expect_err("a wrong description").0;
    assert_eq!(
        broken,
        [
            "description: port `position` is in mm, but position is in m",
            "description: two ports Out are called `position`",
            "description: a structure gives `velocity`, and this one does not",
            "description: scalar `force_x` has no unit; `1` for none",
        ]
    );
}

#[test]
fn plausible_inputs_differ_between_variants() {
    let description = build("hydrostatic level=1").expect("a mock").describe().clone();
    let mut fields = [0, 1].map(|_| description.fields(interfaces::Direction::In, 3));
    for (variant, inputs) in (0..).zip(&mut fields) {
        plausible(0.5, variant, inputs);
    }
    for ((port, one), (_, other)) in fields[0].iter().zip(fields[1].iter()) {
        assert_eq!(one == other, port.exchange == Exchange::Constant, "{}", port.name);
    }
}
