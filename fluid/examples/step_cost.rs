//! What a step costs, stage by stage, on one and two threads, beside the machine's memory bandwidth:
//! `cargo run --release -p fluid --example step_cost -- CELLS TOLERANCE [STEPS] [REPETITIONS] [STATE]`.
//!
//! A column of water 1 × 2 in a tank 4 wide, `CELLS` particles across, has flowed for `STEPS` steps; the next step is then repeated and the least time
//! of each stage taken, which other load on the machine disturbs least. With a file name the
//! state is read from there if the file exists, and written there after the steps. Memory is the process's, before and after.

#[path = "../benches/column/mod.rs"]
mod column;

use column::column;
use fluid::{InterfaceInput, Stage, State};
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

/// Bandwidth (GB/s) of copying an array much larger than the caches, bytes read and written counted; best of ten.
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

fn main() {
    let arguments: Vec<f64> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let argument = |i: usize, default: f64| arguments.get(i).copied().unwrap_or(default);
    let (cells, tolerance) = (argument(0, 50.0) as usize, argument(1, 1e-3));
    let (steps, repetitions) = (argument(2, 20.0) as usize, argument(3, 10.0) as usize);
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");

    let (empty, _) = memory();
    let (mut fluid, mut state) = column(cells, tolerance);
    let mut trial = State::default();
    let file = std::env::args().nth(5);
    if let Some(bytes) = file.as_ref().and_then(|path| std::fs::read(path).ok()) {
        state = State::from_bytes(&bytes).expect("the file holds a state");
    }
    let n = state.len() as f64;
    let (mut pressure_iterations, mut position_iterations, mut time) = (0, 0, 0.0);
    pool(2).install(|| {
        for _ in 0..steps {
            let dt = fluid.stable_step(&state, time, &[]);
            let report = fluid.step(&state, time, dt, &InterfaceInput::NONE, &mut trial).expect("it flows");
            time += dt;
            pressure_iterations += report.pressure_solve.iterations;
            position_iterations += report.position_solve.iterations;
            std::mem::swap(&mut state, &mut trial);
        }
    });
    if let (Some(path), true) = (file, steps > 0) {
        std::fs::write(path, state.to_bytes()).expect("the state can be written");
    }
    let per_step = |sum: usize| sum as f64 / steps.max(1) as f64;
    println!("{n} particles, tolerance {tolerance:.0e}, {steps} steps to t = {time:.4} s");
    println!(
        "iterations a step: pressure {:.1}, positions {:.1}",
        per_step(pressure_iterations),
        per_step(position_iterations)
    );
    let dt = fluid.stable_step(&state, time, &[]);
    let mut table: Vec<(Stage, Vec<f64>)> = Vec::new();
    let mut totals = Vec::new();
    for (column, threads) in [1, 2].into_iter().enumerate() {
        let pool = pool(threads);
        let mut total = f64::INFINITY;
        for _ in 0..repetitions {
            pool.install(|| {
                let first = Instant::now();
                let mut last = first;
                let watch = |stage: Stage| {
                    let seconds = last.elapsed().as_secs_f64();
                    last = Instant::now();
                    let row = match table.iter().position(|(s, _)| *s == stage) {
                        Some(row) => row,
                        None => {
                            table.push((stage, vec![f64::INFINITY; 2]));
                            table.len() - 1
                        }
                    };
                    let least = &mut table[row].1[column];
                    *least = least.min(seconds);
                };
                fluid
                    .step_watched(&state, time, dt, &InterfaceInput::NONE, &mut trial, watch)
                    .expect("it flows");
                total = f64::min(total, first.elapsed().as_secs_f64());
            });
        }
        totals.push(total);
    }
    println!("{:<20} {:>12} {:>8} {:>12} {:>8}", "stage", "us/particle", "share", "2 threads", "speed-up");
    let micro = 1e6 / n;
    let sum: f64 = table.iter().map(|(_, t)| t[0]).sum();
    for (stage, t) in &table {
        let stage = format!("{stage:?}");
        println!(
            "{stage:<20} {:>12.3} {:>8.3} {:>12.3} {:>8.2}",
            t[0] * micro,
            t[0] / sum,
            t[1] * micro,
            t[0] / t[1]
        );
    }
    println!(
        "{:<20} {:>12.3} {:>8} {:>12.3} {:>8.2}",
        "whole step",
        totals[0] * micro,
        "",
        totals[1] * micro,
        totals[0] / totals[1]
    );
    let (_, peak) = memory();
    println!("memory: {:.0} bytes a particle at the peak", (peak - empty) / n);
    println!("copy: {:.1} GB/s on one thread, {:.1} on two", copy_bandwidth(1), copy_bandwidth(2));
}
