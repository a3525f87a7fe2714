//! How long the exchange of a window takes between three processes whose participants do nothing.
//!
//! `cargo run --release -p interfaces --example exchange [POINTS…]` starts itself twice more, as a structure
//! that gives position and velocity (4N doubles in two dimensions) and as a fluid that gives the pressure
//! gradient (2N), and prints the median, the 10th and the 99th percentile of the time per window, in µs,
//! beside a copy of the same bytes within one process. Fields are checked for values that are not finite on
//! both sides of each leg, as in a run. With `VERBOSE` in the environment it prints what the connections
//! count.

use interfaces::{
    Address, Deadlines, Description, Direction, Expectations, Fields, Guarded, Participant, Port, Quantity,
    Readiness, RemoteParticipant, Result, Role, SubSteps, TimeWindow, WindowReport, new_run, serve,
};
use std::error::Error;
use std::hint::black_box;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::Instant;

struct Idle(Description);

impl Idle {
    fn new(role: Role, points: usize) -> Self {
        let port = |name: &str, quantity, direction| Port::new(name, quantity, 2, Some(points), direction);
        let (motion, load) = match role {
            Role::Structure => (Direction::Out, Direction::In),
            Role::Fluid => (Direction::In, Direction::Out),
        };
        let ports = vec![
            port("position", Quantity::Position, motion),
            port("velocity", Quantity::Velocity, motion),
            port("pressure_gradient", Quantity::PressureGradient, load),
        ];
        Self(Description {
            role,
            solver: "idle".to_owned(),
            dimension: 2,
            ports,
            scalars: vec![],
            saves: false,
            notes: vec![],
        })
    }
}

impl Participant for Idle {
    fn describe(&self) -> &Description {
        &self.0
    }
    fn initialize(&mut self, _: f64, _: &Fields, _: &mut Fields) -> Result<Readiness> {
        Ok(Readiness { window_limit: f64::INFINITY, scalars: vec![] })
    }
    fn start(&mut self, _: &TimeWindow, _: &Fields) -> Result<()> {
        Ok(())
    }
    fn finish(&mut self, _: &mut Fields) -> Result<WindowReport> {
        Ok(WindowReport { sub_steps: 1, window_limit: f64::INFINITY, compute_seconds: 0.0, scalars: vec![] })
    }
    fn accept(&mut self, _: Option<u64>) -> Result<()> {
        Ok(())
    }
    fn save(&mut self) -> Result<Vec<u8>> {
        Ok(vec![])
    }
    fn restore(&mut self, _: &[u8], _: &mut Fields) -> Result<Readiness> {
        Ok(Readiness { window_limit: f64::INFINITY, scalars: vec![] })
    }
    fn terminate(&mut self) -> Result<()> {
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [role, points, connect] = arguments.as_slice()
        && let Some(role) = [Role::Structure, Role::Fluid].into_iter().find(|r| r.to_string() == *role)
    {
        let mut idle = Idle::new(role, points.parse()?);
        let address = Address::parse(connect, role);
        return Ok(serve(
            &mut idle,
            &address,
            "idle",
            Deadlines::default(),
            &Arc::default(),
            Box::new(|| None),
        )?);
    }
    let points: Vec<usize> = arguments.iter().map(|a| a.parse()).collect::<Result<_, _>>()?;
    println!("   points   median      p10      p99   memcpy  (µs per window)");
    for points in if points.is_empty() { vec![100, 1_000, 10_000, 100_000] } else { points } {
        measure(points)?;
    }
    Ok(())
}

fn measure(points: usize) -> Result<(), Box<dyn Error>> {
    let run = new_run();
    let connect = |role| -> Result<_, Box<dyn Error>> {
        let address = Address::new(&run, role);
        let expectations = Expectations { case_hash: "idle".to_owned(), dimension: 2 };
        let listening =
            RemoteParticipant::listen(&address, expectations, Deadlines::default(), &Arc::default())?;
        let child = Command::new(std::env::current_exe()?)
            .args([role.to_string(), points.to_string(), address.connect()])
            .spawn()?;
        let child = Arc::new(Mutex::new(child));
        let watched = Arc::clone(&child);
        let alive = move || watched.lock().ok()?.try_wait().ok()?.map(|status| status.to_string());
        let remote = listening.wait_for_hello(Box::new(alive))?;
        let meter = remote.meter();
        Ok((Guarded::new(remote), meter, child))
    };
    let (mut structure, structure_meter, structure_process) = connect(Role::Structure)?;
    let (mut fluid, fluid_meter, fluid_process) = connect(Role::Fluid)?;

    let mut load = structure.describe().fields(Direction::In, 0);
    let mut motion = structure.describe().fields(Direction::Out, 0);
    structure.initialize(0.0, &load, &mut motion)?;
    fluid.initialize(0.0, &motion, &mut load)?;
    let windows = (2_000_000 / points).clamp(200, 5_000) as u64;
    let mut seconds = Vec::new();
    for index in 0..windows {
        let window = TimeWindow {
            index,
            iteration: 0,
            start: index as f64,
            size: 1.0,
            sub_steps: SubSteps::Fixed(100),
        };
        let started = Instant::now();
        structure.start(&window, &load)?;
        structure.finish(&mut motion)?;
        fluid.start(&window, &motion)?;
        fluid.finish(&mut load)?;
        structure.accept(None)?;
        fluid.accept(None)?;
        seconds.push(started.elapsed().as_secs_f64());
    }
    structure.terminate()?;
    fluid.terminate()?;
    let copies = vec![1.0; 6 * points];
    let mut into = vec![0.0; 6 * points];
    let started = Instant::now();
    for _ in 0..100 {
        into.copy_from_slice(black_box(&copies));
        black_box(&mut into);
    }
    let memcpy = started.elapsed().as_secs_f64() / 100.0;
    let mut seconds = seconds.split_off(seconds.len() / 10);
    seconds.sort_by(f64::total_cmp);
    let at = |fraction: f64| 1e6 * seconds[(fraction * (seconds.len() - 1) as f64) as usize];
    println!("{points:9} {:8.1} {:8.1} {:8.1} {:8.1}", at(0.5), at(0.1), at(0.99), 1e6 * memcpy);
    if std::env::var_os("VERBOSE").is_some() {
        println!("structure {:?}\nfluid {:?}", structure_meter.get(), fluid_meter.get());
    }
    drop((structure, fluid));
    for process in [structure_process, fluid_process] {
        process.lock().expect("no thread panicked with it").wait()?;
    }
    Ok(())
}
