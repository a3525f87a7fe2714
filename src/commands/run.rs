//! `meniscus run`.

use super::{FAILED, INTERRUPTED, failed};
use crate::arguments::Run;
use coupler::run::{Options, RunError, Solvers};
use interfaces::case::Case;
use output::summary::{Status, Summary};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs the case, prints a short summary and where to look.
pub fn run(arguments: &Run) -> ExitCode {
    let case = match super::load(&arguments.case) {
        Ok(case) => case,
        Err(code) => return code,
    };
    let out = arguments.out.clone().unwrap_or_else(|| default_folder(&arguments.case.case));
    let (executable, stop) = match (std::env::current_exe(), super::stop_flag()) {
        (Ok(executable), Ok(stop)) => (executable, stop),
        (Err(error), _) | (_, Err(error)) => return failed(error),
    };
    let options = Options {
        out: out.clone(),
        in_process: arguments.in_process,
        quiet: arguments.quiet,
        domain: arguments.domain.clone(),
        stop,
    };
    if arguments.in_process {
        super::set_threads(&case);
    }
    let build = |role| super::solver(&case, role, &out);
    let solvers = Solvers { in_process: &build, executable: &executable };
    let (summary, result) = coupler::run::run(&case, &options, &solvers);
    if let Err(error @ (RunError::Folder { .. } | RunError::NotInProcess { .. })) = result {
        return failed(error);
    }
    print_end(&case, &summary, &out);
    match (&result, summary.status) {
        (Err(error), Status::Interrupted) => eprintln!("interrupted: {error}"),
        (Err(error), _) => eprintln!("error: {error}"),
        (Ok(()), _) => {}
    }
    // Before the first window there is nothing to report on.
    if !arguments.no_report && summary.windows > 0 {
        match output::report::write_report(&out) {
            Ok(page) => println!("report      {}", page.display()),
            // A run that failed keeps its own exit code.
            Err(error) if summary.status == Status::Completed => return failed(error),
            Err(error) => eprintln!("warning: {error}"),
        }
    }
    match summary.status {
        Status::Completed => ExitCode::SUCCESS,
        Status::Interrupted => ExitCode::from(INTERRUPTED),
        Status::Failed => ExitCode::from(FAILED),
    }
}

/// `out/<name of the case>`: the folder of a case.toml names the case, any other file its own name.
fn default_folder(case: &Path) -> PathBuf {
    let named_by = if case.is_file() && case.file_name().is_some_and(|n| n == "case.toml") {
        case.parent().unwrap_or(case)
    } else {
        case
    };
    let named_by = named_by.canonicalize().unwrap_or_else(|_| named_by.to_owned());
    Path::new("out").join(named_by.file_stem().unwrap_or_else(|| "case".as_ref()))
}

fn print_end(case: &Case, summary: &Summary, out: &Path) {
    println!("{}", case.general.title);
    println!(
        "{:<12}{} windows to t = {:.6} s in {:.1} s",
        summary.status.word(),
        summary.windows,
        summary.simulated_seconds,
        summary.wall_seconds
    );
    for (role, used) in &summary.roles {
        println!("{role:<12}{:.1} s computing, {:.0} % of the run", used.compute_seconds, 100.0 * used.share);
    }
    for (probe, extremes) in &summary.probes {
        println!(
            "{probe:<12}from {:.6} (t = {:.4} s) to {:.6} (t = {:.4} s)",
            extremes.min, extremes.min_time, extremes.max, extremes.max_time
        );
    }
    if let Some(condition) = &summary.condition_46 {
        println!(
            "condition   (46): largest residual {:.1e} before enforcement, {:.1e} after",
            condition.before.max, condition.after.max
        );
    }
    println!("outputs     {}", out.display());
}
