//! One series as a run has it: participants as processes, contract, scheme, records.

use super::{BenchError, Measured, Options, Series, warm_up};
use crate::launch;
use crate::run::participants::Participants;
use crate::run::{self, RunError, Solvers};
use crate::schemes::{Onward, Solver as _};
use crate::timing::Timing;
use interfaces::case::Case;
use interfaces::{ParticipantError, Role, new_run};
use std::os::unix::fs::DirBuilderExt;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// A case of both sides, of which nothing is solved.
const CASE: &str = r#"
[case]
title = "Exchange"
dimension = 2
end_time = 1.0
output_interval = 1.0
particle_spacing = 0.1
[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
characteristic_speed = 1.0
domain = { low = [0.0, 0.0], high = [1.0, 1.0] }
[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 1e6
poisson_ratio = 0.3
density = 1000.0
"#;

/// The case of a series.
fn case(series: Series, points: usize, windows: u64, options: &Options) -> Case {
    let executable = &options.executable;
    let mock = |words: &[&str]| {
        let mut command = vec![executable.display().to_string(), "mock".to_owned(), "idle".to_owned()];
        command.extend(words.iter().map(|word| (*word).to_owned()));
        command.push(format!("points={points}"));
        format!("{command:?}")
    };
    let yes_or_no = |yes: bool| if yes { "yes" } else { "no" };
    let varies = format!("varies={}", yes_or_no(matches!(series, Series::Iterated(_))));
    let interpolates = format!("interpolates={}", yes_or_no(series == Series::Interpolated));
    let mut settings = vec![
        format!("case.end_time={windows}.0"),
        format!("case.output_interval={windows}.0"),
        "coupling.max_window=1.0".to_owned(),
        format!("coupling.share_core={}", options.share_core),
        format!("fluid.participant.command={}", mock(&["role=fluid", &varies])),
        format!("structure.participant.command={}", mock(&["role=structure", &interpolates])),
    ];
    match series {
        Series::Explicit => settings.push("coupling.prediction=false".to_owned()),
        Series::Interpolated => {
            settings.push("coupling.prediction=false".to_owned());
            settings.push("coupling.load_in_window=linear".to_owned());
        }
        Series::Predicted => {}
        Series::Iterated(count) => {
            settings.push("coupling.scheme=serial-implicit".to_owned());
            settings.push(format!("coupling.convergence.max_iterations={count}"));
            settings.push("coupling.convergence.relative=1e-300".to_owned());
        }
    }
    Case::parse(CASE, Path::new("exchange.toml"), &settings, &options.sections)
        .expect("the case of the bench is sound")
}

/// Measures a series.
pub(super) fn measure(
    series: Series,
    points: usize,
    windows: u64,
    options: &Options,
) -> Result<Measured, BenchError> {
    let out = std::env::temp_dir().join(format!("meniscus-bench-{}", new_run()));
    let made = std::fs::DirBuilder::new().mode(0o700).create(&out);
    made.map_err(|source| BenchError::System { during: "make the bench's folder", source })?;
    let measured = measure_in(series, points, windows, options, &out);
    let removed = std::fs::remove_dir_all(&out);
    let measured = measured?;
    removed.map_err(|source| BenchError::System { during: "remove the bench's folder", source })?;
    Ok(measured)
}

fn measure_in(
    series: Series,
    points: usize,
    windows: u64,
    options: &Options,
    out: &Path,
) -> Result<Measured, BenchError> {
    let case = case(series, points, windows, options);
    let run_options = run::Options {
        out: out.to_owned(),
        in_process: false,
        quiet: true,
        trace: false,
        domain: options.domain.clone(),
        stop: options.stop.clone(),
        checkpoints: None,
        from: None,
        record: None,
    };
    let none = |_: Role| Err(ParticipantError::failed("the bench has no participant in its own process"));
    let solvers = Solvers { in_process: &none, executable: &options.executable };
    launch::forget_peak_memory();
    let folder = run::folder::prepare(out, &case)?;
    let mut participants = Participants::new(Timing::new(None), &options.stop, None);
    let mut times = Vec::with_capacity(windows as usize);
    let started = participants.start(&case, &run_options, &solvers);
    let result = started.and_then(|()| timed(&case, &run_options, &mut participants, windows, &mut times));
    let memory = participants.end(result.is_ok());
    drop(folder);
    let cpu_seconds = result? / times.len() as f64;
    times.sort_by(f64::total_cmp);
    Ok(Measured { times, cpu_seconds, peak_memory_bytes: memory.0.values().sum() })
}

/// Solves all windows, fills in the time of each that counts (s), and gives the processor time of those (s).
fn timed(
    case: &Case,
    options: &run::Options,
    participants: &mut Participants,
    windows: u64,
    times: &mut Vec<f64>,
) -> Result<f64, RunError> {
    let mut coupled = run::coupled(case, options, participants)?;
    let cpu = |participants: &Participants| launch::cpu_seconds(None) + participants.cpu_seconds();
    let (mut before, mut after) = (0.0, 0.0);
    let mut placement = participants.placement(case);
    let mut last = Instant::now();
    let result = coupled.drive(|accepted, _| {
        times.push(last.elapsed().as_secs_f64());
        placement.window();
        let done = accepted.window.index + 1;
        if done == warm_up(windows) {
            times.clear();
            before = cpu(participants);
        }
        if done == windows {
            after = cpu(participants);
            participants.look_at_memory();
        }
        last = Instant::now();
        if options.stop.load(Ordering::Relaxed) { Onward::Stop } else { Onward::Continue }
    });
    result?;
    for side in coupled.run.solver.sides_mut() {
        side.terminate()?;
    }
    Ok(after - before)
}
