//! `meniscus run`.

use super::{FAILED, INTERRUPTED, failed, resume, say};
use crate::arguments::Run;
use coupler::run::{Options, Record, RunError, Solvers};
use interfaces::case::Case;
use output::report::Shown;
use output::summary::{Extremes, Status, Summary};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs the case, prints a short summary and where to look.
pub fn run(arguments: &Run) -> ExitCode {
    let of_case = match resume::case_of(arguments) {
        Ok(of_case) => of_case,
        Err(code) => return code,
    };
    let case = match super::load(&of_case) {
        Ok(case) => case,
        Err(code) => return code,
    };
    // What does not fit is said before anything is started or emptied.
    let mistakes = super::check::preflight(&case);
    if !mistakes.is_empty() {
        return super::refuse(&of_case, mistakes);
    }
    let from = match resume::from(arguments, &case) {
        Ok(from) => from,
        Err(code) => return code,
    };
    let scenario = match resume::scenario_of(arguments) {
        Ok(scenario) => scenario,
        Err(code) => return code,
    };
    let out = arguments.resume.clone().or_else(|| arguments.out.clone());
    let out = out.unwrap_or_else(|| default_folder(&of_case.case));
    let flags = super::stop_flag().and_then(|stop| Ok((stop, super::checkpoint_flag()?)));
    let (executable, (stop, checkpoints)) = match (std::env::current_exe(), flags) {
        (Ok(executable), Ok(flags)) => (executable, flags),
        (Err(error), _) | (_, Err(error)) => return failed(error),
    };
    let options = Options {
        out: out.clone(),
        in_process: arguments.in_process,
        quiet: arguments.quiet,
        trace: arguments.trace,
        domain: arguments.domain.clone(),
        stop,
        checkpoints: Some(checkpoints),
        from,
        scenario,
        record: arguments.record.clone().map(|path| Record { path, limit: arguments.record_limit }),
    };
    if arguments.in_process {
        super::set_threads(&case);
    }
    let build = |role| super::solver(&case, role, &out);
    let solvers = Solvers { in_process: &build, executable: &executable };
    let (summary, result) = coupler::run::run(&case, &options, &solvers);
    if let Err(
        error @ (RunError::Folder { .. }
        | RunError::NotInProcess { .. }
        | RunError::Recording(_)
        | RunError::Scenario(_)),
    ) = result
    {
        return failed(error);
    }
    print_end(&case, &summary, &out);
    match (&result, summary.status) {
        (Err(error), Status::Interrupted) => super::tell(format_args!("interrupted: {error}")),
        (Err(error), _) => super::tell(format_args!("error: {error}")),
        (Ok(()), _) => {}
    }
    // Before the first window there is nothing to report on.
    if !arguments.no_report && summary.windows > 0 {
        match output::report::write_report(&out, &Shown::default()) {
            Ok(report) => {
                say(format_args!("report      {}", report.page.display()));
                report.notes.iter().for_each(|note| super::tell(format_args!("warning: {note}")));
            }
            // A run that failed keeps its own exit code.
            Err(error) if summary.status == Status::Completed => return failed(error),
            Err(error) => super::tell(format_args!("warning: {error}")),
        }
    }
    match summary.status {
        Status::Completed => ExitCode::SUCCESS,
        Status::Interrupted => ExitCode::from(INTERRUPTED),
        Status::Failed => ExitCode::from(FAILED),
    }
}

/// `out/<name of the case>`: the folder of a case.toml names the case, any other file its own name.
pub fn default_folder(case: &Path) -> PathBuf {
    let named_by = if case.is_file() && case.file_name().is_some_and(|n| n == "case.toml") {
        case.parent().unwrap_or(case)
    } else {
        case
    };
    let named_by = named_by.canonicalize().unwrap_or_else(|_| named_by.to_owned());
    Path::new("out").join(named_by.file_stem().unwrap_or_else(|| "case".as_ref()))
}

fn print_end(case: &Case, summary: &Summary, out: &Path) {
    say(&case.general.title);
    let Summary { windows, simulated_seconds, wall_seconds, .. } = summary;
    let (status, time) = (summary.status.word(), short(*simulated_seconds));
    say(format_args!("{status:<12}{windows} windows to t = {time} s in {wall_seconds:.1} s"));
    if let (Status::Completed, Some(message)) = (summary.status, &summary.message) {
        say(format_args!("ended       early: {message}"));
    }
    if let Some(iterations) = summary.iterations.as_ref().filter(|found| found.not_converged > 0) {
        say(format_args!(
            "warning     {} of {windows} windows did not converge: their results are those of the last iteration; raise \
             coupling.convergence.max_iterations, or see iterations.csv",
            iterations.not_converged
        ));
    }
    for seam in &summary.seams {
        say(format_args!("seam        {}", seam.words()));
    }
    for note in &summary.notes {
        say(format_args!("note        {note}"));
    }
    print_times(summary);
    print_probes(summary, out);
    if let Some(condition) = &summary.condition_46 {
        let (before, after) = (condition.before.max, condition.after.max);
        say(format_args!(
            "condition   (46): largest residual {before:.1e} before enforcement, {after:.1e} after"
        ));
    }
    if let Some(recording) = summary.roles.get("coupler").and_then(|coupler| coupler.extra.get("recording")) {
        let megabytes = recording["bytes"].as_f64().unwrap_or(0.0) / 1e6;
        let file = recording["file"].as_str().unwrap_or_default();
        say(format_args!("recording   {file} ({megabytes:.3} MB)"));
    }
    say(format_args!("outputs     {}", out.display()));
}

/// The extremes of each probe, with four digits and units, in columns.
fn print_probes(summary: &Summary, out: &Path) {
    // Without the file there are no units, and the numbers still say something.
    let units = output::columns::read(out).unwrap_or_default().remove("probes.csv").unwrap_or_default();
    let widest = summary.probes.keys().map(|probe| probe.chars().count()).max().unwrap_or(0).max(10) + 2;
    for (probe, Extremes { min, min_time, max, max_time }) in &summary.probes {
        let unit = match units.get(probe).map_or("1", |content| content.unit.as_str()) {
            "1" => String::new(),
            unit => format!(" {unit}"),
        };
        let (min, max) = (short(*min), short(*max));
        let (first, last) = (short(*min_time), short(*max_time));
        say(format_args!("{probe:<widest$}from {min}{unit} (t = {first} s) to {max}{unit} (t = {last} s)"));
    }
}

/// Who computed and waited, and what the coupler did.
fn print_times(summary: &Summary) {
    let row = |name: &str, seconds: f64, what: &str| {
        let share = 100.0 * seconds / summary.wall_seconds;
        say(format_args!("{name:<12}{seconds:>10.3} s  {share:>5.1} %  {what}"));
    };
    for (role, used) in summary.roles.iter().filter(|(_, used)| used.compute_seconds > 0.0) {
        row(role, used.compute_seconds, "computing");
        row("", used.wait_seconds, "waiting");
    }
    for (index, (phase, seconds)) in coupler::run::phases(summary).into_iter().enumerate() {
        row(if index == 0 { "coupler" } else { "" }, seconds, phase);
    }
}

/// Four significant digits, in the signs of a terminal.
fn short(value: f64) -> String {
    output::report::short(value).replace('−', "-")
}
