//! The checkpoint that `meniscus run --resume` and `--branch` go on from, and whether the case fits it.

use super::{WRONG, failed, say, tell};
use crate::arguments::{CaseArguments, Run};
use coupler::run::{Found, checkpoint};
use coupler::scenario::{self, Scenario};
use interfaces::case::{Case, Change};
use output::summary::{Seam, Status, Summary};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The case and its overrides: of a run that goes on, the case in its folder where none is named.
///
/// # Errors
/// The exit code, where there is no run in that folder.
pub fn case_of(arguments: &Run) -> Result<CaseArguments, ExitCode> {
    let case = match (&arguments.case, folder(arguments)) {
        (Some(case), _) => case.clone(),
        (None, Some(folder)) if folder.join(coupler::run::CASE).is_file() => folder.join(coupler::run::CASE),
        (None, folder) => {
            let folder = folder.unwrap_or_default();
            let (folder, case) = (folder.display(), coupler::run::CASE);
            return Err(failed(format_args!(
                "failed to find a run in {folder}: there is no {case}; name the folder that the run wrote (its --out)"
            )));
        }
    };
    let mut set = arguments.set.clone();
    set.extend(arguments.checkpoint_every.map(|every| format!("checkpoints.every={every:?}")));
    Ok(CaseArguments { case, set, end_time: arguments.end_time })
}

/// The folder of the run that goes on or is branched from.
fn folder(arguments: &Run) -> Option<PathBuf> {
    let of_file = |path: &PathBuf| match path.is_file() {
        true => path.parent().and_then(Path::parent).unwrap_or(Path::new("")).to_owned(),
        false => path.clone(),
    };
    arguments.resume.clone().or_else(|| arguments.branch.as_ref().map(of_file))
}

/// The scenario of a run: the one that is given, or the changes, without the faults, of the run that goes on
/// or is branched from.
///
/// # Errors
/// The exit code, where it is none, or there would be two.
pub fn scenario_of(arguments: &Run) -> Result<Option<Scenario>, ExitCode> {
    let of_run = folder(arguments).map(|folder| folder.join(scenario::FILE)).filter(|path| path.is_file());
    let goes_on = of_run.is_some();
    let path = match (&arguments.scenario, of_run) {
        (Some(given), Some(there)) => {
            tell(format_args!(
                "error: --scenario {}: the run has one that its branch goes on under, {}; leave the option out",
                given.display(),
                there.display()
            ));
            return Err(ExitCode::from(WRONG));
        }
        (Some(given), None) => given.clone(),
        (None, Some(there)) => there,
        (None, None) => return Ok(None),
    };
    let mut scenario = Scenario::read(&path).map_err(|error| {
        tell(format_args!("error: {error}"));
        ExitCode::from(WRONG)
    })?;
    if goes_on {
        scenario.faults.clear();
    }
    Ok(Some(scenario))
}

/// The checkpoint that the case goes on from, the new seam its last; nothing for a run from the start.
///
/// # Errors
/// Its exit code, where there is none, the case does not fit it, or nothing is left to do.
pub fn from(arguments: &Run, case: &Case) -> Result<Option<Found>, ExitCode> {
    let Some(dir) = folder(arguments) else { return Ok(None) };
    let named = arguments.branch.as_ref().filter(|path| path.is_file());
    let found = match named {
        Some(path) => checkpoint::open(path).map(|found| (found, Vec::new())),
        None => checkpoint::newest(&dir),
    };
    let (mut found, refused) = found.map_err(failed)?;
    for error in refused {
        tell(format_args!("warning: {error}; the checkpoint before it is taken"));
    }
    let is_branch = arguments.branch.is_some();
    let changes = case.changes_since(&found.header.case).map_err(failed)?;
    let is_refused = |change: &&Change| if is_branch { change.is_of_state() } else { !change.is_free() };
    let refused: Vec<_> = changes.iter().filter(is_refused).map(|change| format!("  {change}")).collect();
    if !refused.is_empty() {
        let (what, remedy) = match is_branch {
            true => (
                "the checkpoint is of a run with other particles, probes or scheme",
                "leave these keys as they were, or start a run from the beginning".to_owned(),
            ),
            false => (
                "a run that goes on cannot change what its results depend on",
                format!(
                    "leave these keys as they were, or start another run with --branch {} --out DIR",
                    dir.display()
                ),
            ),
        };
        tell(format_args!("error: {what}:\n{}\n{remedy}", refused.join("\n")));
        return Err(ExitCode::from(WRONG));
    }
    if is_branch && arguments.out.as_ref().is_some_and(|out| found.is_of(out)) {
        return Err(failed("a branch is a run of its own: give another folder with --out"));
    }
    if let Some(reached) = reached(&dir, &found, case, is_branch) {
        if is_branch {
            return Err(failed(format_args!(
                "nothing is left to branch: the run in {} {reached}",
                dir.display()
            )));
        }
        say(format_args!("nothing to do: the run in {} {reached}", dir.display()));
        return Err(ExitCode::SUCCESS);
    }
    let seam = Seam {
        windows: found.header.windows,
        simulated_seconds: found.header.time,
        wall_seconds: found.header.wall_seconds,
        branch_of: is_branch.then(|| dir.display().to_string()),
        changes: changes.iter().map(Change::to_string).collect(),
    };
    say(seam.words());
    found.header.seams.push(seam);
    Ok(Some(found))
}

/// What the run has reached, if nothing is left of the case to do. One that was killed at its very end has no
/// summary, and makes it.
fn reached(dir: &Path, found: &Found, case: &Case, is_branch: bool) -> Option<String> {
    let (time, end) = (found.header.time, case.general.end_time);
    let ended = Summary::read(&dir.join(coupler::run::SUMMARY)).ok();
    let ended = ended.filter(|summary| !is_branch && summary.status == Status::Completed);
    let remedy = format!("and case.end_time is {end} s; give a later one with --end-time");
    match ended {
        Some(Summary { simulated_seconds, message: Some(message), .. }) => {
            Some(format!("has ended at t = {simulated_seconds} s: {message}"))
        }
        Some(Summary { simulated_seconds, .. }) if simulated_seconds >= end => {
            Some(format!("has reached t = {simulated_seconds} s, {remedy}"))
        }
        // Decimals of the time may be off by the last digit.
        _ if time > end * (1.0 + 1e-12) || is_branch && time >= end => {
            Some(format!("has reached t = {time} s, {remedy}"))
        }
        _ => None,
    }
}
