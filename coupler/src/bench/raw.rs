//! The same messages without the coupling: what the transport takes.

use super::{BenchError, Measured, Options, Series, warm_up};
use crate::launch::{self, Child};
use crate::placement::Placement;
use interfaces::protocol::Kind;
use interfaces::transport::{Connection, SharedMemory};
use interfaces::{Address, Result, Role, new_run, remove_stale};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Longest wait for a message.
const DEADLINE: Duration = Duration::from_secs(20);

/// The other end: answers every `Start` with `given` doubles, until it is told to terminate.
///
/// # Errors
/// Where the transport fails, or nothing comes.
pub fn echo(address: &Address, taken: usize, given: usize) -> Result<()> {
    let mut connection =
        Connection::<SharedMemory>::open(address, DEADLINE, Arc::default(), Box::new(|| None))?;
    let (mut inputs, outputs) = (vec![0.0; taken], vec![1.0; given]);
    connection.send_raw(Kind::Hello, &[], true)?;
    loop {
        match connection.receive_raw(DEADLINE, &mut inputs)? {
            Kind::Start => connection.send_raw(Kind::Solved, &outputs, true)?,
            Kind::Terminate => return connection.send_raw(Kind::Terminated, &[], true),
            _ => {}
        }
    }
}

/// One participant's end, seen from here.
struct Leg {
    connection: Connection<SharedMemory>,
    child: Child,
    given: Vec<f64>,
    answer: Vec<f64>,
}

impl Leg {
    fn open(
        role: Role,
        (taken, given): (usize, usize),
        run: &str,
        options: &Options,
    ) -> Result<Self, BenchError> {
        let mut address = Address::new(run, role);
        if let Some(domain) = &options.domain {
            address = address.in_domain(domain);
        }
        remove_stale(&address)?;
        let mut connection = Connection::create(&address, Arc::clone(&options.stop))?;
        let words =
            ["bench".to_owned(), "echo".to_owned(), role.to_string(), taken.to_string(), given.to_string()];
        let mut command = vec![options.executable.display().to_string()];
        command.extend(words);
        command.extend(["--run".to_owned(), address.connect()]);
        let log = std::env::temp_dir().join(format!("meniscus-bench-{run}-{role}.log"));
        let child = Child::spawn(role, &command, &[], &log).map_err(crate::run::RunError::from)?;
        // The process has its own handle by now.
        let _ = std::fs::remove_file(&log);
        connection.receive_raw(DEADLINE, &mut [])?;
        Ok(Self { connection, child, given: vec![1.0; taken], answer: vec![0.0; given] })
    }

    fn solve(&mut self) -> Result<()> {
        self.connection.send_raw(Kind::Start, &self.given, true)?;
        self.connection.receive_raw(DEADLINE, &mut self.answer)?;
        Ok(())
    }
}

/// Measures the messages of a series.
pub(super) fn measure(
    series: Series,
    points: usize,
    windows: u64,
    options: &Options,
) -> Result<Measured, BenchError> {
    let run = new_run();
    let mut structure =
        Leg::open(Role::Structure, (series.structure_takes(points), 4 * points), &run, options)?;
    let mut fluid = Leg::open(Role::Fluid, (4 * points, 2 * points), &run, options)?;
    let (of_structure, of_fluid) = series.solutions();
    let mut times = Vec::with_capacity(windows as usize);
    let mut cpu = 0.0;
    let processes = [structure.child.id(), fluid.child.id()];
    let mut placement = Placement::new(if options.share_core { &processes } else { &[] });
    for window in 0..windows {
        if window == warm_up(windows) {
            times.clear();
            cpu = cpu_seconds(&[&structure, &fluid]);
        }
        let started = Instant::now();
        for solution in 0..of_structure.max(of_fluid) {
            structure.solve()?;
            if solution < of_fluid {
                fluid.solve()?;
            }
        }
        for leg in [&mut fluid, &mut structure] {
            leg.connection.send_raw(Kind::Accept, &[], false)?;
        }
        times.push(started.elapsed().as_secs_f64());
        placement.window();
    }
    let cpu_seconds = (cpu_seconds(&[&structure, &fluid]) - cpu) / times.len() as f64;
    let mut peak_memory_bytes = launch::peak_memory_bytes(None);
    for leg in [&mut structure, &mut fluid] {
        peak_memory_bytes += leg.child.peak_memory_bytes();
        leg.connection.send_raw(Kind::Terminate, &[], true)?;
        leg.connection.receive_raw(DEADLINE, &mut [])?;
        leg.child.end(Instant::now() + Duration::from_secs(2));
    }
    times.sort_by(f64::total_cmp);
    Ok(Measured { times, cpu_seconds, peak_memory_bytes })
}

fn cpu_seconds(legs: &[&Leg]) -> f64 {
    launch::cpu_seconds(None) + legs.iter().map(|leg| leg.child.cpu_seconds()).sum::<f64>()
}
