//! `meniscus sweep`.

use super::{FAILED, INTERRUPTED, WRONG, failed, say, tell};
use crate::arguments::Sweep;
use output::summary::Status;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use validation::sweep::{self, Member, Options, Overs, page, table};

/// Runs the members, tabulates them, and says where to look. Fails if one of them does.
pub fn sweep(arguments: &Sweep) -> ExitCode {
    let overs = match Overs::new(arguments.over.clone()) {
        Ok(overs) => overs,
        Err(problem) => {
            tell(format_args!("error: {problem}"));
            return ExitCode::from(WRONG);
        }
    };
    let (executable, stop) = match (std::env::current_exe(), super::stop_flag()) {
        (Ok(executable), Ok(stop)) => (executable, stop),
        (Err(error), _) | (_, Err(error)) => return failed(error),
    };
    let out = arguments.out.clone().unwrap_or_else(|| default_folder(arguments));
    let options = Options {
        executable,
        case: arguments.case.case.clone(),
        set: super::overrides(&arguments.case),
        overs,
        jobs: arguments.jobs.get(),
        reports: !arguments.no_report,
        out,
        sections: super::SECTIONS.to_vec(),
        stop,
    };
    let members = match sweep::members(&options) {
        Ok(members) => members,
        Err(mistakes) => {
            for (label, errors) in mistakes {
                tell(format_args!("{label}:\n{errors}"));
            }
            return ExitCode::from(WRONG);
        }
    };
    run(&members, &options)
}

fn run(members: &[Member], options: &Options) -> ExitCode {
    if let Err(error) = std::fs::create_dir_all(&options.out) {
        return failed(format_args!("failed to make {}: {error}", options.out.display()));
    }
    let results = sweep::run(members, options, &|count, result| {
        let label = options.overs.label(&result.member.values);
        let (status, seconds) = (result.summary.status.word(), result.summary.wall_seconds);
        let how = match (&result.summary.message, result.was_there) {
            (_, true) => "was there".to_owned(),
            (Some(message), _) => format!("{status} in {seconds:.1} s: {message}"),
            (None, _) => format!("{status} in {seconds:.1} s"),
        };
        say(format_args!("[{count}/{}] {label}: {how}", members.len()));
    });
    let results: Vec<_> = results.into_iter().flatten().collect();
    let name = results.iter().map(|result| result.summary.title.as_str()).find(|title| !title.is_empty());
    let written = table::write(&results, &options.overs, &options.out).and_then(|table| {
        let title = name.unwrap_or("no member ran");
        Ok((table, page::write(&results, &options.overs, title, &options.out)?))
    });
    match written {
        Ok((table, page)) => {
            say(format_args!("table       {}\npage        {}", table.display(), page.display()));
        }
        Err(error) => return failed(error),
    }
    if options.stop.load(Ordering::Relaxed) {
        tell("interrupted; the same command goes on with what is left");
        return ExitCode::from(INTERRUPTED);
    }
    let failed = results.iter().filter(|result| result.summary.status != Status::Completed).count();
    if failed > 0 {
        tell(format_args!("error: {failed} of {} members did not complete", members.len()));
        return ExitCode::from(FAILED);
    }
    ExitCode::SUCCESS
}

/// Beside the folder that `meniscus run` would take.
fn default_folder(arguments: &Sweep) -> PathBuf {
    let mut folder = super::run::default_folder(&arguments.case.case).into_os_string();
    folder.push("-sweep");
    folder.into()
}
