//! `meniscus check`.

use super::{refuse, say};
use crate::arguments::Check;
use coupler::run::{Options, Solvers};
use interfaces::Role;
use interfaces::case::participant::Start;
use interfaces::case::{Case, Findings};
use output::report::short;
use std::io::Read;
use std::os::unix::fs::{DirBuilderExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How long a unit may take to be loaded and instantiated.
const PROBE: Duration = Duration::from_secs(20);
/// Bytes of what a unit says that are kept.
const WORDS: usize = 1 << 16;
/// Windows of a run at most: those of 30 years at 100 a second.
const MOST_WINDOWS: f64 = 1e11;
/// How long the start of a run is measured.
const MEASURED: Duration = Duration::from_secs(4);

/// Reports all mistakes of a case; without one, what would run. The verdict comes last.
pub fn check(arguments: &Check) -> ExitCode {
    let case = match super::load(&arguments.case) {
        Ok(case) => case,
        Err(code) => return code,
    };
    let mut mistakes = Findings::default();
    for (role, start) in sides(&case) {
        match preview(&case, role, start) {
            Ok(lines) => {
                for (what, value) in lines {
                    say(format_args!("{:<10} {what:<24} {value}", role.to_string()));
                }
            }
            Err(error) => add(&mut mistakes, &key(role, start), &error),
        }
        missing(role, start, &mut mistakes);
        if matches!(start, Start::Fmu(_))
            && mistakes.is_empty()
            && let Err(error) = probe(arguments, role)
        {
            add(&mut mistakes, &key(role, start), &error);
        }
    }
    let windows = if mistakes.is_empty() { expected_windows(&case) } else { None };
    if let Some(Windows { least, limit, .. }) = windows.filter(|windows| windows.least > MOST_WINDOWS) {
        let (key, what) = limit;
        let problem = format!("{what} asks for {least:.1e} windows, and {MOST_WINDOWS:.0e} never end");
        mistakes.add(key, problem, "let windows be longer, or the run shorter");
    } else if let Some(Windows { least, most, .. }) = windows {
        let range = if most > least {
            format!(
                "{least:.0} (as slow as at the start) to {most:.0} (at twice characteristic_speed throughout)"
            )
        } else {
            format!("{least:.0}")
        };
        say(format_args!("{:<10} {:<24} {range}", "run", "expected windows"));
    }
    if let Some(asked) = windows.and_then(|windows| more_sub_steps_than_stable(&case, windows)) {
        say(format_args!("{:<10} {:<24} {asked}", "run", "sub-steps"));
    }
    for advice in windows.iter().flat_map(|windows| fast_motions(&case, *windows)) {
        say(format_args!("{:<10} {:<24} {advice}", "run", "note"));
    }
    for advice in windows.iter().flat_map(|windows| short_intervals(&case, *windows)) {
        say(format_args!("{:<10} {:<24} {advice}", "run", "note"));
    }
    if let Some(advice) = very_light(&case) {
        say(format_args!("{:<10} {:<24} {advice}", "run", "note"));
    }
    if mistakes.is_empty() && arguments.time {
        match measure(&case, windows) {
            Ok(line) => say(format_args!("{:<10} {:<24} {line}", "run", "wall time")),
            Err(error) => add(&mut mistakes, "", &error),
        }
    }
    if mistakes.is_empty() {
        say(format_args!("{}: no mistakes found", case.general.title));
        return ExitCode::SUCCESS;
    }
    refuse(&arguments.case, mistakes)
}

/// What a run of the case would start that cannot be started.
pub fn preflight(case: &Case) -> Findings {
    let mut mistakes = Findings::default();
    for (role, start) in sides(case) {
        missing(role, start, &mut mistakes);
        if matches!(start, Start::Fmu(_))
            && let Err(error) = fmu_host::preview(case, role)
        {
            add(&mut mistakes, &key(role, start), &error.to_string());
        }
    }
    mistakes
}

/// The key that says who solves a side.
fn key(role: Role, start: Start<'_>) -> String {
    match start {
        Start::Fmu(_) => format!("{role}.participant.fmu"),
        _ => role.to_string(),
    }
}

/// A mistake that is told with its remedy last, as a solver does.
fn add(mistakes: &mut Findings, key: &str, told: &str) {
    let (problem, remedy) = told.rsplit_once("; ").unwrap_or((told, "mend what it names"));
    mistakes.add(key, problem, remedy);
}

fn sides(case: &Case) -> impl Iterator<Item = (Role, Start<'_>)> {
    [Role::Fluid, Role::Structure].into_iter().filter_map(|role| Some((role, case.start(role)?)))
}

/// What would solve a side: pairs of what and value.
fn preview(case: &Case, role: Role, start: Start<'_>) -> Result<Vec<(String, String)>, String> {
    let who = |what: &str, value: String| {
        let mut lines = vec![(what.to_owned(), value)];
        let of_side = case.probes.iter().filter(|probe| probe.is_on_structure() == (role == Role::Structure));
        lines.extend(of_side.map(|probe| {
            let names: Vec<String> =
                probe.scalars(case.general.dimension).map(|scalar| scalar.name).collect();
            let (name, columns) = (&probe.name, names.join(", "));
            let what = if probe.is_of_interface() && case.coupling.is_some() {
                format!("probe \"{name}\" is recorded from the interface points, unless it reports {columns}")
            } else {
                format!("probe \"{name}\" is recorded if it reports {columns}")
            };
            ("note".to_owned(), what)
        }));
        Ok(lines)
    };
    match (start, role) {
        (Start::Own, Role::Fluid) => fluid::participant::preview(case).map_err(|e| e.to_string()),
        (Start::Own, Role::Structure) => structure::participant::preview(case).map_err(|e| e.to_string()),
        (Start::Fmu(_), _) => fmu_host::preview(case, role).map_err(|e| e.to_string()),
        (Start::Command(words), _) => who("command", words.join(" ")),
        (Start::ByHand, _) => who("started", "by hand".to_owned()),
    }
}

/// A program of the case that is not there.
fn missing(role: Role, start: Start<'_>, mistakes: &mut Findings) {
    let Start::Command(words) = start else { return };
    let Some(program) = words.first() else { return };
    let runs = |path: &Path| {
        path.metadata().is_ok_and(|there| there.is_file() && there.permissions().mode() & 0o111 != 0)
    };
    let found = if program.contains('/') {
        runs(Path::new(program))
    } else {
        std::env::var_os("PATH")
            .is_some_and(|path| std::env::split_paths(&path).any(|at| runs(&at.join(program))))
    };
    if !found {
        let remedy = "write its path, or what PATH has of it";
        mistakes.add(
            format!("{role}.participant.command.0"),
            "there is no such program, or it may not be executed",
            remedy,
        );
    }
}

/// Loads and instantiates the unit of a side in a process of its own, where it can do no harm.
fn probe(arguments: &Check, role: Role) -> Result<(), String> {
    let executable = std::env::current_exe().map_err(|error| error.to_string())?;
    let file = std::path::absolute(&arguments.case.case).unwrap_or_else(|_| arguments.case.case.clone());
    let mut command = Command::new(executable);
    command.arg("probe-fmu").arg(role.to_string()).arg(file);
    for setting in &arguments.case.set {
        command.args(["--set", setting]);
    }
    let mut child = command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| error.to_string())?;
    // Read while it runs: a unit that says much would wait for that.
    let said = child.stderr.take().map(|errors| std::thread::spawn(move || tail(errors)));
    let deadline = Instant::now() + PROBE;
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if Instant::now() < deadline => std::thread::sleep(Duration::from_millis(5)),
            _ => {
                let _ = child.kill();
                let _ = child.wait();
                let seconds = PROBE.as_secs();
                return Err(format!("the unit was not instantiated within {seconds} s"));
            }
        }
    };
    if status.success() {
        return Ok(());
    }
    let said = said.and_then(|reader| reader.join().ok()).unwrap_or_default();
    let words = said.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("it said nothing");
    let words = words.trim_start_matches("error: ");
    Err(format!("the unit cannot be instantiated ({status}): {words}"))
}

/// The end of what is said, as far as it can be read.
fn tail(mut said: impl Read) -> String {
    let (mut end, mut more) = (Vec::new(), [0; 4096]);
    while let Ok(length @ 1..) = said.read(&mut more) {
        end.extend_from_slice(&more[..length]);
        end.drain(..end.len().saturating_sub(WORDS));
    }
    String::from_utf8_lossy(&end).into_owned()
}

/// The other side of [`probe`].
pub fn probe_fmu(case: &Case, role: Role) -> Result<(), String> {
    let folder = Scratch::new()?;
    fmu_host::open(case, role, &folder.0).map(drop).map_err(|error| error.to_string())
}

/// Windows of the run at least and at most, as far as our own solvers tell: a fluid that stays as fast as it
/// is at the start, and one that goes at twice its characteristic speed. Nothing where a solver of another
/// make may ask for shorter ones.
fn expected_windows(case: &Case) -> Option<Windows> {
    if sides(case).any(|(_, start)| start != Start::Own) {
        return None;
    }
    let general = &case.general;
    let mut limits = vec![(("case.output_interval", "it"), general.output_interval)];
    if let Some(coupling) = &case.coupling {
        limits.push((("coupling.max_window", "it"), coupling.max_window));
    }
    let mut sub_step = f64::INFINITY;
    if case.structure.is_some() {
        sub_step = structure::participant::stable_sub_step(case).ok()?;
        let most = structure::participant::most_sub_steps(case).map_or(f64::INFINITY, f64::from);
        let limit =
            ("structure", "its stable sub-step, by its material, spacing and numerics.step_fraction,");
        limits.push((limit, most * sub_step));
    }
    let mut fastest = f64::INFINITY;
    if case.fluid.is_some() {
        let [slow, fast] = fluid::participant::time_steps(case).ok()?;
        let limit = ("fluid", "its time step, by its speed, gravity, spacing and max_time_step,");
        limits.push((limit, slow));
        fastest = fast;
    }
    let (limit, longest) = limits.into_iter().min_by(|(_, a), (_, b)| a.total_cmp(b))?;
    // A window ends with every output: as many of one size as fit between two.
    let outputs = (general.end_time / general.output_interval).ceil();
    let count = |step: f64| outputs * (general.output_interval / step - 1e-9).ceil();
    Some(Windows { least: count(longest), most: count(longest.min(fastest)), longest, sub_step, limit })
}

/// Sub-steps in a period of a clamp's motion under which a shaken plate's account was seen to open: by 42 %
/// of the clamp's work at 8.5 of them, 14 % at 17, 6e-5 at 42, 8e-6 at 85.
const SUB_STEPS_IN_A_PERIOD: f64 = 50.0;

/// Clamps that swing faster than the structure's sub-steps follow, one line each.
fn fast_motions(case: &Case, windows: Windows) -> Vec<String> {
    let fixed = case.coupling.as_ref().and_then(|coupling| coupling.sub_steps.count());
    let step = fixed.map_or(windows.sub_step, |count| windows.longest / f64::from(count));
    let told = |(name, period): (&String, f64)| {
        let count = period / step;
        (count < SUB_STEPS_IN_A_PERIOD).then(|| {
            format!(
                "the clamp \"{name}\" swings once in {count:.1} sub-steps, which do not follow it; structure.numerics.step_fraction makes them shorter"
            )
        })
    };
    let clamps = case.structure.iter().flat_map(|structure| &structure.clamps);
    let periods = clamps.filter_map(|clamp| Some((&clamp.name, clamp.moves()?.period?)));
    periods.filter_map(told).collect()
}

/// Probes whose intervals or filters are shorter than the windows of which they are made, one line each.
fn short_intervals(case: &Case, windows: Windows) -> Vec<String> {
    let longest = windows.longest;
    let mut told = Vec::new();
    for probe in &case.probes {
        let name = &probe.name;
        if let Some(interval) = probe.interval.filter(|interval| *interval < longest) {
            told.push(format!(
                "probe \"{name}\" has intervals of {interval} s, and windows of up to {longest:.2e} s, whose one value fills several"
            ));
        }
        if let Some(cut_off) = probe.low_pass.filter(|cut_off| 2.0 * cut_off * longest > 1.0) {
            told.push(format!(
                "probe \"{name}\" has a low-pass of {cut_off} Hz, and windows of up to {longest:.2e} s tell of at most {:.3e} Hz",
                0.5 / longest
            ));
        }
    }
    told
}

/// Density of a structure over the fluid's under which a free body was thrown apart by an explicit scheme, as
/// far as was tried (a submerged block of 1/100 was, one of 1/50 was not), with some room.
const VERY_LIGHT: f64 = 0.05;

/// Advice for a structure that is so light that an explicit scheme may not be stable.
fn very_light(case: &Case) -> Option<String> {
    let explicit = case.coupling.as_ref().is_some_and(|coupling| !coupling.scheme.is_implicit());
    let ratio = case.structure.as_ref()?.least_density() / case.fluid.as_ref()?.density;
    (explicit && ratio < VERY_LIGHT).then(|| {
        format!(
            "the structure has {ratio:.2e} of the fluid's density: an explicit scheme may throw it apart where it is free; coupling.scheme = \"serial-implicit\" with coupling.compliance = false holds it"
        )
    })
}

/// What a fixed number of sub-steps costs, where stability would do with a third of it.
fn more_sub_steps_than_stable(case: &Case, windows: Windows) -> Option<String> {
    let fixed = case.coupling.as_ref()?.sub_steps.count()?;
    let stable = (windows.longest / windows.sub_step).ceil().max(1.0);
    let share = 100.0 * (1.0 - stable / f64::from(fixed));
    (f64::from(fixed) > 3.0 * stable).then(|| {
        format!(
            "{fixed} in each window, where stability asks for {stable}: coupling.sub_steps = \"stable\" saves {share:.0} % of the structure's work"
        )
    })
}

/// Windows of a run.
#[derive(Clone, Copy)]
struct Windows {
    least: f64,
    most: f64,
    /// Size of the longest (s).
    longest: f64,
    /// The structure's stable sub-step (s); infinite without a structure.
    sub_step: f64,
    /// The key, and what of it makes them so many.
    limit: (&'static str, &'static str),
}

/// Runs the case's beginning, and says what the whole would take: so many windows at that pace.
fn measure(case: &Case, windows: Option<Windows>) -> Result<String, String> {
    let folder = Scratch::new()?;
    let executable = std::env::current_exe().map_err(|error| error.to_string())?;
    let stop = Arc::new(AtomicBool::new(false));
    let options = Options {
        out: folder.0.join("run"),
        in_process: false,
        quiet: true,
        trace: false,
        domain: None,
        stop: Arc::clone(&stop),
        checkpoints: None,
        from: None,
        record: None,
    };
    let (send, ended) = std::sync::mpsc::channel::<()>();
    let clock = std::thread::spawn(move || {
        // The run ends by itself, or is told to.
        let _ = ended.recv_timeout(MEASURED);
        stop.store(true, Ordering::Relaxed);
    });
    let build = |role| super::solver(case, role, &folder.0);
    let solvers = Solvers { in_process: &build, executable: &executable };
    let (summary, result) = coupler::run::run(case, &options, &solvers);
    drop(send);
    let _ = clock.join();
    match result {
        Err(error) if !error.is_interruption() => return Err(error.to_string()),
        _ => {}
    }
    if summary.windows == 0 {
        let seconds = MEASURED.as_secs();
        return Ok(format!("no window was solved within {seconds} s"));
    }
    let (solved, time, wall) = (summary.windows, summary.simulated_seconds, summary.wall_seconds);
    if time >= case.general.end_time {
        return Ok(format!("{} s: it ran to its end, in {solved} windows", short(wall)));
    }
    let starting = coupler::run::phases(&summary)
        .into_iter()
        .find(|(phase, _)| *phase == "starting and ending")
        .map_or(0.0, |(_, seconds)| seconds);
    let each = (wall - starting) / solved as f64;
    let whole = match windows {
        Some(Windows { least, most, .. }) if most > least => {
            format!(
                "{} to {} s for as many windows",
                short(starting + each * least),
                short(starting + each * most)
            )
        }
        _ => format!("about {} s", short(starting + (wall - starting) * case.general.end_time / time)),
    };
    Ok(format!(
        "{whole}: {} s each, by the first {solved} (to t = {} s in {wall:.1} s)",
        short(each),
        short(time)
    ))
}

/// A folder for a moment.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Result<Self, String> {
        let path = std::env::temp_dir().join(format!("meniscus-check-{}", interfaces::new_run()));
        let made = std::fs::DirBuilder::new().mode(0o700).create(&path);
        made.map(|()| Self(path)).map_err(|error| error.to_string())
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What cannot be removed is in a folder for passing files.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
