//! A structure without physics, that misbehaves on request, and a domain of shared memory that must be empty
//! in the end.

use interfaces::{
    Deadlines, Description, Direction, Expectations, Fields, Participant, ParticipantError, Port, Quantity,
    Readiness, Result, Role, Scalar, ScalarKind, SubSteps, TimeWindow, WindowReport,
};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use words::bytes::{Reader, Writer};

const MAGIC: &[u8; 8] = b"mnscech1";

pub const HASH: &str = "5d41402abc4b2a76";

/// Gives back what it takes: position = load + number of the window, velocity = 2 × load.
pub struct Echo {
    pub description: Description,
    misdeed: String,
    at: u64,
    load: Vec<f64>,
    window: u64,
    accepted: u64,
}

impl Echo {
    /// `misdeed` is `none`, or `<what>@<window>`.
    pub fn new(points: usize, misdeed: &str) -> Self {
        let port = |name, quantity, direction| Port::new(name, quantity, 2, Some(points), direction);
        let ports = vec![
            port("position", Quantity::Position, Direction::Out),
            port("density", Quantity::Density, Direction::Out).constant(),
            Port { points: None, ..port("pressure_gradient", Quantity::PressureGradient, Direction::In) },
            port("velocity", Quantity::Velocity, Direction::Out),
        ];
        let energy = Scalar::new("energy", "J", ScalarKind::Balance);
        let description = Description {
            role: Role::Structure,
            solver: "echo".to_owned(),
            dimension: 2,
            ports,
            scalars: vec![energy],
            saves: true,
            notes: vec![],
        };
        let (misdeed, at) = misdeed.split_once('@').unwrap_or((misdeed, "0"));
        Self {
            description,
            misdeed: misdeed.to_owned(),
            at: at.parse().expect("a window's number"),
            load: vec![],
            window: 0,
            accepted: 0,
        }
    }

    fn give(&self, outputs: &mut Fields) {
        for (place, load) in outputs.get_mut("position").unwrap().iter_mut().zip(&self.load) {
            *place = load + self.window as f64;
        }
        for (place, load) in outputs.get_mut("velocity").unwrap().iter_mut().zip(&self.load) {
            *place = 2.0 * load;
        }
    }
}

impl Participant for Echo {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        self.load = inputs.get("pressure_gradient").unwrap().to_vec();
        self.give(outputs);
        outputs.get_mut("density").unwrap().fill(1100.0);
        Ok(Readiness { window_limit: 0.5 + start, scalars: vec![0.25] })
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        assert_eq!(window.sub_steps, SubSteps::Fixed(100));
        self.load.copy_from_slice(inputs.get("pressure_gradient").unwrap());
        self.window = window.index;
        if window.index != self.at {
            return Ok(());
        }
        match self.misdeed.as_str() {
            "hang" => loop {
                std::thread::sleep(Duration::from_secs(1));
            },
            "fail" => Err(ParticipantError::failed("particle 3 is inverted at t = 0.5 s")),
            "panic" => panic!("index {} out of bounds", 7),
            "exit" => std::process::exit(3),
            _ => Ok(()),
        }
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        self.give(outputs);
        if self.misdeed == "nan" && self.window == self.at {
            outputs.get_mut("velocity").unwrap()[5] = f64::NAN;
        }
        Ok(WindowReport {
            sub_steps: 100,
            window_limit: f64::INFINITY,
            compute_seconds: 0.125,
            scalars: vec![self.window as f64],
        })
    }

    fn accept(&mut self, snapshot: Option<u64>) -> Result<()> {
        if self.misdeed == "accept" && self.window == self.at {
            return Err(ParticipantError::failed(format!("cannot write snapshot {snapshot:?}")));
        }
        self.accepted += 1;
        Ok(())
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        let mut state = Writer::new(MAGIC);
        state.u64(self.accepted);
        state.u64(self.window);
        state.f64s(&self.load);
        Ok(state.finish())
    }

    fn restore(&mut self, state: &[u8], outputs: &mut Fields) -> Result<Readiness> {
        let mut state = Reader::new("echo's state", MAGIC, state).unwrap();
        self.accepted = state.u64("accepted windows").unwrap();
        self.window = state.u64("window").unwrap();
        self.load = state.f64s("load", Some(self.load.len())).unwrap();
        self.give(outputs);
        Ok(Readiness { window_limit: f64::INFINITY, scalars: vec![self.window as f64] })
    }

    fn terminate(&mut self) -> Result<()> {
        Ok(())
    }
}

pub fn expectations() -> Expectations {
    Expectations { case_hash: HASH.to_owned(), dimension: 2 }
}

/// Deadlines that no test should need: what ends earlier ends for another reason.
pub fn long() -> Deadlines {
    Deadlines { hello: Duration::from_secs(60), answer: Duration::from_secs(60) }
}

pub fn window(index: u64) -> TimeWindow {
    TimeWindow { index, iteration: 0, start: 0.1 * index as f64, size: 0.1, sub_steps: SubSteps::Fixed(100) }
}

/// A load of every bit pattern that numbers in use have: other in every window, point and component.
pub fn load(fields: &mut Fields, window: u64) {
    for (i, value) in fields.get_mut("pressure_gradient").unwrap().iter_mut().enumerate() {
        *value = (1.0 + i as f64 + 0.1 * window as f64).sqrt() * if i % 3 == 0 { -1e-7 } else { 1e5 };
    }
}

/// Initialises the structure, solves and accepts that many windows, and compares all that comes back bit for
/// bit.
pub fn exchange(structure: &mut dyn Participant, points: usize, windows: u64) -> Result<()> {
    let mut inputs = structure.describe().fields(Direction::In, points);
    let mut outputs = structure.describe().fields(Direction::Out, points);
    load(&mut inputs, 0);
    let readiness = structure.initialize(2.0, &inputs, &mut outputs)?;
    assert_eq!(readiness, Readiness { window_limit: 2.5, scalars: vec![0.25] });
    assert_eq!(outputs.get("density").unwrap(), vec![1100.0; points]);
    for index in 0..windows {
        load(&mut inputs, index);
        structure.start(&window(index), &inputs)?;
        let report = structure.finish(&mut outputs)?;
        assert_eq!((report.sub_steps, report.window_limit), (100, f64::INFINITY));
        assert_eq!((report.compute_seconds, report.scalars), (0.125, vec![index as f64]));
        let sent = inputs.get("pressure_gradient").unwrap();
        let came = outputs.get("position").unwrap().iter().zip(outputs.get("velocity").unwrap());
        for (load, (position, velocity)) in sent.iter().zip(came) {
            assert_eq!(position.to_bits(), (load + index as f64).to_bits());
            assert_eq!(velocity.to_bits(), (2.0 * load).to_bits());
        }
        structure.accept((index % 2 == 1).then_some(index))?;
    }
    assert_eq!(outputs.get("density").unwrap(), vec![1100.0; points], "constants are left as they are");
    Ok(())
}

/// A domain of shared memory of its own, that must be empty when it is dropped.
pub struct Domain(pub String);

impl Domain {
    pub fn new() -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        Self(format!("mt-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)))
    }

    /// What it has in shared memory and under its folder, but for empty folders.
    pub fn left(&self) -> Vec<String> {
        let address = interfaces::Address::new("any", Role::Fluid).in_domain(&self.0);
        let mut left = files(Path::new(&address.root()));
        left.extend(files(Path::new("/dev/shm")).into_iter().filter(|path| path.contains(&address.prefix())));
        left
    }
}

impl Drop for Domain {
    fn drop(&mut self) {
        let left = self.left();
        let root = interfaces::Address::new("any", Role::Fluid).in_domain(&self.0).root();
        let _ = std::fs::remove_dir_all(root);
        if !std::thread::panicking() {
            assert!(left.is_empty(), "left behind: {left:#?}");
        }
    }
}

fn files(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return vec![] };
    let mut found = vec![];
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.push(path.display().to_string());
        }
    }
    found
}
