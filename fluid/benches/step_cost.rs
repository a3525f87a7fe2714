//! What a step costs, stage by stage, on one and two threads, beside the machine's memory bandwidth:
//! `cargo bench -p fluid --bench step_cost -- CELLS TOLERANCE [STEPS] [MEASURED] [STATE]`.
//!
//! A column of water 1 × 2 in a tank 4 wide, `CELLS` particles across, has flowed for `STEPS` steps; each of
//! the next `MEASURED` steps is then taken three times on one thread and on two, and the least time of each
//! stage counts, which other load on the machine disturbs least. With a file name the state is read from
//! there if the file exists, and written there after the steps. Memory is the process's, before and after.
//! Bandwidth is [`traffic`] by time.

mod column;

use column::column;
use fluid::{Fluid, InterfaceInput, Isph, Stage, State};
use sph::kernel::CubicSpline;
use sph::neighbours::{CellGrid, NeighbourList};
use std::time::Instant;

/// Resident memory of this process (bytes): now and at its peak; zeros where the system does not tell.
fn memory() -> (f64, f64) {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let figure = |key: &str| {
        let line = status.lines().find(|l| l.starts_with(key));
        line.and_then(|l| l.split_whitespace().nth(1))
            .and_then(|n| n.parse::<f64>().ok())
            .map_or(0.0, |k| k * 1024.0)
    };
    (figure("VmRSS:"), figure("VmHWM:"))
}

/// Bandwidth (GB/s) of copying an array much larger than the caches, bytes read and written counted; best of
/// ten.
fn copy_bandwidth(threads: usize) -> f64 {
    let n = 16 << 20;
    let (from, mut to) = (vec![1.0f64; n], vec![0.0f64; n]);
    let part = n / threads;
    let best = (0..10)
        .map(|_| {
            let started = Instant::now();
            std::thread::scope(|scope| {
                for (to, from) in to.chunks_mut(part).zip(from.chunks(part)) {
                    scope.spawn(|| to.copy_from_slice(from));
                }
            });
            started.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min);
    16.0 * n as f64 / best / 1e9
}

/// Bytes a particle that a stage reads and writes at least, in two dimensions: every array of a pass once,
/// values that neighbours are asked for included, coarse levels of the hierarchy left out. `pairs` a
/// particle; iterations and hierarchies made a step.
fn traffic(stage: Stage, pairs: f64, pressure: f64, positions: f64, made: f64) -> f64 {
    // An index takes 4 bytes, a pair 12, an entry of the hierarchy 8 and a row of it 32.
    let application = 2.0 * 16.0 * pairs + 105.0;
    let preconditioner = 2.0 * (8.0 * pairs + 32.0) + 64.0;
    let solve = |iterations: f64| (iterations + 1.0) * application + iterations * (preconditioner + 120.0);
    match stage {
        Stage::Neighbours => (3.0 * 4.0 + 16.0 + 4.0) * pairs + 760.0,
        Stage::Assembly => 12.0 * pairs + 200.0 + made * ((16.0 + 8.0 + 8.0 + 8.0) * pairs + 150.0),
        Stage::PositionProjection => solve(positions) + 16.0 * pairs + 110.0,
        Stage::Prediction => 2.0 * 16.0 * pairs + 200.0,
        Stage::PressureSolve => solve(pressure) + application + 16.0 * pairs + 160.0,
        Stage::Velocity => 2.0 * 16.0 * pairs + 350.0,
        Stage::MotionAndAccounts => 500.0,
    }
}

const STAGES: [Stage; 7] = [
    Stage::Neighbours,
    Stage::Assembly,
    Stage::Prediction,
    Stage::PositionProjection,
    Stage::PressureSolve,
    Stage::Velocity,
    Stage::MotionAndAccounts,
];

/// Seconds of each stage and of the whole, the least of three times the same step.
fn time_step(fluid: &mut Isph<2>, state: &State<2>, time: f64, dt: f64, trial: &mut State<2>) -> [f64; 8] {
    let mut least = [f64::INFINITY; 8];
    for _ in 0..3 {
        let first = Instant::now();
        let mut last = first;
        let watch = |stage: Stage| {
            let row = STAGES.iter().position(|s| *s == stage).expect("every stage is listed");
            least[row] = least[row].min(last.elapsed().as_secs_f64());
            last = Instant::now();
        };
        fluid.step_watched(state, time, dt, &InterfaceInput::NONE, trial, watch).expect("it flows");
        least[7] = least[7].min(first.elapsed().as_secs_f64());
    }
    least
}

fn main() {
    let arguments: Vec<f64> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let argument = |i: usize, default: f64| arguments.get(i).copied().unwrap_or(default);
    let (cells, tolerance) = (argument(0, 50.0) as usize, argument(1, 1e-3));
    let (steps, measured) = (argument(2, 20.0) as usize, argument(3, 10.0) as usize);
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
    let (one, two) = (pool(1), pool(2));

    let (empty, _) = memory();
    let (mut fluid, mut state) = column(cells, tolerance);
    let mut trial = State::default();
    let file = std::env::args().skip(1).filter(|a| a != "--bench").nth(4);
    if let Some(bytes) = file.as_ref().and_then(|path| std::fs::read(path).ok()) {
        state = State::from_bytes(&bytes).expect("the file holds a state");
    }
    let mut time = 0.0;
    two.install(|| {
        for _ in 0..steps {
            let dt = fluid.stable_step(&state, time, &[]);
            fluid.step(&state, time, dt, &InterfaceInput::NONE, &mut trial).expect("it flows");
            time += dt;
            std::mem::swap(&mut state, &mut trial);
        }
    });
    if let (Some(path), true) = (file, steps > 0) {
        std::fs::write(path, state.to_bytes()).expect("the state can be written");
    }
    let n = state.len() as f64;
    println!("{n} particles, tolerance {tolerance:.0e}, after {steps} steps, t = {time:.4} s");

    let (mut seconds, mut iterations, mut made) = ([[0.0; 8]; 2], [0.0; 2], 0.0);
    for _ in 0..measured {
        made += f64::from(u8::from(state.memory.hierarchy.is_none())) / measured as f64;
        let dt = fluid.stable_step(&state, time, &[]);
        for (sums, pool) in seconds.iter_mut().zip([&one, &two]) {
            let least = pool.install(|| time_step(&mut fluid, &state, time, dt, &mut trial));
            sums.iter_mut().zip(least).for_each(|(sum, least)| *sum += least / measured as f64);
        }
        let report = fluid.step(&state, time, dt, &InterfaceInput::NONE, &mut trial).expect("it flows");
        iterations[0] += report.pressure_solve.iterations as f64 / measured as f64;
        iterations[1] += report.position_solve.iterations as f64 / measured as f64;
        time += dt;
        std::mem::swap(&mut state, &mut trial);
    }
    println!(
        "iterations a step: pressure {:.1}, positions {:.1}; hierarchies made a step: {made:.2}",
        iterations[0], iterations[1]
    );
    let (_, peak) = memory();
    let kernel = CubicSpline::<2>::new(fluid.smoothing_length());
    let mut list = NeighbourList::default();
    list.rebuild(&state.positions, &CellGrid::new(&state.positions, kernel.support()), &state.positions);
    let pairs = list.pairs() as f64 / n;
    println!(
        "{:<20} {:>12} {:>8} {:>8} {:>12} {:>8} {:>8}",
        "stage", "us/particle", "share", "GB/s", "2 threads", "GB/s", "speed-up"
    );
    let [one, two] = seconds;
    let row = |name: &str, i: usize, bytes: f64| {
        println!(
            "{name:<20} {:>12.3} {:>8.3} {:>8.1} {:>12.3} {:>8.1} {:>8.2}",
            one[i] * 1e6 / n,
            one[i] / one[7],
            bytes * n / one[i] / 1e9,
            two[i] * 1e6 / n,
            bytes * n / two[i] / 1e9,
            one[i] / two[i]
        );
    };
    let bytes = |stage: Stage| traffic(stage, pairs, iterations[0], iterations[1], made);
    for (i, stage) in STAGES.into_iter().enumerate() {
        row(&format!("{stage:?}"), i, bytes(stage));
    }
    row("whole step", 7, STAGES.into_iter().map(bytes).sum());
    println!("memory: {:.0} bytes a particle at the peak", (peak - empty) / n);
    println!("copy: {:.1} GB/s on one thread, {:.1} on two", copy_bandwidth(1), copy_bandwidth(2));
}
