//! Instructions of one Runge–Kutta step per particle, counted by Valgrind: the same on an idle and on a
//! loaded machine, to about one in 10⁴.
//!
//! `cargo bench -p structure --bench instructions` prints one line for each gradient and path; without
//! Valgrind it says so and counts nothing. The benchmark runs itself under Valgrind with two numbers of
//! steps; the difference is the steps' alone. Valgrind knows AVX2 and no AVX-512, so the counts are those of
//! vectors of four numbers, one thread.

mod beam;

use beam::{Path, beam, name};
use std::process::{Command, ExitCode};
use structure::{Gradient, Load, Solid};

/// Layers and columns: 3,000 particles.
const SIZE: [usize; 2] = [20, 150];

/// Steps of the two runs.
const STEPS: [usize; 2] = [2, 12];

/// The child's work is passed in this variable: arguments are Cargo's.
const CHILD: &str = "MENISCUS_COUNTED_STEPS";

fn main() -> ExitCode {
    if let Ok(work) = std::env::var(CHILD) {
        child(&work);
        return ExitCode::SUCCESS;
    }
    match Command::new("valgrind").arg("--version").output() {
        Ok(answer) if answer.status.success() => print!("{}", String::from_utf8_lossy(&answer.stdout)),
        _ => {
            println!(
                "instructions: skipped, there is no `valgrind` to count them (Debian: apt-get install valgrind)"
            );
            return ExitCode::SUCCESS;
        }
    }
    for gradient in GRADIENTS {
        for path in Path::ALL {
            let counts: Result<Vec<u64>, String> = STEPS
                .iter()
                .map(|&steps| count(&format!("{} {} {steps}", name(gradient), path.name())))
                .collect();
            match counts {
                Ok(counts) => {
                    let steps = (SIZE[0] * SIZE[1] * (STEPS[1] - STEPS[0])) as f64;
                    let each = (counts[1] - counts[0]) as f64 / steps;
                    println!(
                        "{:12} {:8} {each:8.1} instructions per particle and step",
                        name(gradient),
                        path.name()
                    );
                }
                Err(said) => {
                    eprintln!("failed to count {} {}: {said}", name(gradient), path.name());
                    return ExitCode::FAILURE;
                }
            }
        }
    }
    ExitCode::SUCCESS
}

const GRADIENTS: [Gradient; 2] = [Gradient::FirstOrder, Gradient::Quadratic];

/// Steps a beam as `work` says: gradient, path, number of steps.
fn child(work: &str) {
    let words: Vec<&str> = work.split(' ').collect();
    let [gradient, path, steps] = words[..] else { panic!("three words: {work}") };
    let gradient = GRADIENTS.into_iter().find(|&g| name(g) == gradient).expect("a gradient's name");
    let path = Path::ALL.into_iter().find(|p| p.name() == path).expect("a path's name");
    let steps: usize = steps.parse().expect("a number of steps");
    let mut structure = beam(gradient, path, SIZE);
    let from = structure.state_at_rest(0.0);
    let mut to = from.clone();
    let dt = 0.5 * steps as f64 * structure.stable_time_step();
    structure.advance(&from, &mut to, dt, steps, &Load::None).expect("it is stable");
}

/// Instructions of this executable doing `work`.
fn count(work: &str) -> Result<u64, String> {
    let executable = std::env::current_exe().map_err(|e| e.to_string())?;
    let ran = Command::new("valgrind")
        .args(["--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"])
        .arg(executable)
        .env(CHILD, work)
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .map_err(|e| e.to_string())?;
    let said = String::from_utf8_lossy(&ran.stderr);
    // "==1234== I   refs:      12,345,678", the spaces between differ from version to version.
    let line = said.lines().find(|l| l.contains("refs:") && l.contains(" I "));
    let digits = line.and_then(|l| l.rsplit(':').next()).map(|n| n.replace([',', ' '], ""));
    match digits.and_then(|n| n.parse().ok()) {
        Some(instructions) if ran.status.success() => Ok(instructions),
        _ => Err(format!("valgrind ended with {} and said\n{said}", ran.status)),
    }
}
