//! A case at every combination of some values of its keys, each a run of its own in a folder below the
//! sweep's. Start at [`run`].
//!
//! A member that is there already is not run again, and one that was cut off goes on from its checkpoint: the
//! same command ends a sweep that was interrupted, and a longer list of values adds to one.

pub mod over;
pub mod page;
pub mod table;

pub use over::{Over, Overs};

use coupler::run::{CASE, SUMMARY, checkpoint};
use interfaces::case::{Case, CaseErrors, Change, Sections};
use output::summary::{Status, Summary};
use rustix::process::{Pid, Signal, kill_process};
use std::fs::File;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Members at most: more are a slip of the fingers.
pub const MOST: usize = 1000;

/// How often a member is looked at.
const LOOK: Duration = Duration::from_millis(50);

/// What the command line sets.
pub struct Options {
    /// The executable that runs a case: `<executable> run …`.
    pub executable: PathBuf,
    /// Case file or folder.
    pub case: PathBuf,
    /// Overrides that all members have: `key=value`.
    pub set: Vec<String>,
    /// Keys and their values.
    pub overs: Overs,
    /// Members that run at once.
    pub jobs: usize,
    /// Whether members have a report of their own.
    pub reports: bool,
    /// Folder of the sweep.
    pub out: PathBuf,
    /// Sections of the case that the solvers bring.
    pub sections: Vec<Sections>,
    /// Becomes true when the command is told to stop.
    pub stop: Arc<AtomicBool>,
}

/// One run of a sweep.
#[derive(Clone, Debug)]
pub struct Member {
    /// Its values, in the order of [`Overs`].
    pub values: Vec<String>,
    /// Its folder below the sweep's, made of keys and values: the same in another sweep.
    pub folder: String,
    /// The case with its values, as resolved.
    case: Case,
    /// Its overrides, those of all members among them.
    set: Vec<String>,
}

/// What became of a member.
#[derive(Clone, Debug)]
pub struct Result {
    /// The member.
    pub member: Member,
    /// How it ended: its summary, or a failed one with the reason where it left none.
    pub summary: Summary,
    /// Whether it was there before.
    pub was_there: bool,
}

/// The members of a sweep, each held against the rules of a case before any is run.
///
/// # Errors
/// Each member's mistakes with its label.
pub fn members(options: &Options) -> std::result::Result<Vec<Member>, Vec<(String, CaseErrors)>> {
    let (mut members, mut mistakes) = (Vec::new(), Vec::new());
    for values in options.overs.combinations() {
        let set = [options.set.clone(), options.overs.overrides(&values)].concat();
        match Case::load(&options.case, &set, &options.sections) {
            Ok(case) => {
                let folder = options.overs.folder(&values);
                members.push(Member { values, folder, case, set });
            }
            Err(errors) => mistakes.push((options.overs.label(&values), errors)),
        }
    }
    if mistakes.is_empty() { Ok(members) } else { Err(mistakes) }
}

/// Runs all members, at most [`Options::jobs`] at once, and tells of each as it ends: how many have, the
/// member, its result. One that fails ends none of the others. The results are in the members' order; those
/// that were not begun when the sweep was told to stop have none.
pub fn run(
    members: &[Member],
    options: &Options,
    tell: &(dyn Fn(usize, &Result) + Sync),
) -> Vec<Option<Result>> {
    let (next, ended) = (AtomicUsize::new(0), Mutex::new((0, vec![None; members.len()])));
    let work = || {
        while !options.stop.load(Ordering::Relaxed) {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(member) = members.get(index) else { break };
            let result = run_member(member, options);
            let mut ended = ended.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            ended.0 += 1;
            tell(ended.0, &result);
            ended.1[index] = Some(result);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..options.jobs.min(members.len()) {
            scope.spawn(work);
        }
    });
    ended.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner).1
}

/// What a member's folder holds of it.
enum Begun {
    /// All of it.
    Ended(Box<Summary>),
    /// A part that it can go on from.
    Checkpoint,
    /// Nothing that serves.
    Nothing,
}

fn run_member(member: &Member, options: &Options) -> Result {
    let dir = options.out.join(&member.folder);
    let of = |summary, was_there| Result { member: member.clone(), summary, was_there };
    let mut command = Command::new(&options.executable);
    command.arg("run").arg(&options.case);
    match begun(member, &dir) {
        Begun::Ended(summary) => return of(*summary, true),
        Begun::Checkpoint => command.arg("--resume").arg(&dir),
        Begun::Nothing => command.arg("--out").arg(&dir),
    };
    command.arg("--quiet").args(member.set.iter().flat_map(|set| ["--set", set]));
    let takes_threads = |set: &String| set.starts_with("case.threads=");
    if options.jobs > 1 && !member.set.iter().any(takes_threads) {
        // No result depends on it.
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        command.args(["--set", &format!("case.threads={}", (cores / options.jobs).max(1))]);
    }
    if !options.reports {
        command.arg("--no-report");
    }
    let log = options.out.join(format!("{}.log", member.folder));
    let summary = match ended(&mut command, &log, &options.stop) {
        Err(error) => failed(format!("failed to run it: {error}")),
        // Codes over 2 are of runs that left a summary, or of a death.
        Ok(status) => match Summary::read(&dir.join(SUMMARY)) {
            Ok(summary) if status.code() != Some(2) => summary,
            _ => failed(last_words(&log, status)),
        },
    };
    of(summary, false)
}

/// What is there of this member, and of no other with the same folder.
fn begun(member: &Member, dir: &Path) -> Begun {
    let is_same = |before: &str| {
        member.case.changes_since(before).is_ok_and(|changes| changes.iter().all(Change::is_free))
    };
    let before = output::files::read_text(&dir.join(CASE), output::files::WORDS);
    if !before.is_ok_and(|before| is_same(&before)) {
        return Begun::Nothing;
    }
    if let Ok(summary) = Summary::read(&dir.join(SUMMARY))
        && summary.status == Status::Completed
        && (summary.simulated_seconds >= member.case.general.end_time || summary.message.is_some())
    {
        return Begun::Ended(Box::new(summary));
    }
    match checkpoint::newest(dir) {
        Ok((found, _)) if is_same(&found.header.case) => Begun::Checkpoint,
        _ => Begun::Nothing,
    }
}

/// Starts the command and waits for its end; told to stop, it tells the member once.
fn ended(command: &mut Command, log: &Path, stop: &AtomicBool) -> std::io::Result<ExitStatus> {
    let log = File::create(log)?;
    let mut child = command
        .stdin(Stdio::null())
        .stdout(log.try_clone()?)
        .stderr(log)
        // Ctrl-C reaches the sweep alone: a member that is told twice writes no checkpoint.
        .process_group(0)
        .spawn()?;
    let mut is_told = false;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if stop.load(Ordering::Relaxed) && !is_told {
            tell_to_stop(&child);
            is_told = true;
        }
        std::thread::sleep(LOOK);
    }
}

fn tell_to_stop(child: &Child) {
    let pid = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
    // One that has ended meanwhile needs no word.
    let _ = pid.map(|pid| kill_process(pid, Signal::TERM));
}

fn failed(message: String) -> Summary {
    Summary { status: Status::Failed, message: Some(message), ..Summary::default() }
}

/// What a run that left no summary said last.
fn last_words(log: &Path, status: ExitStatus) -> String {
    let text = output::files::read_text(log, output::files::WORDS).unwrap_or_default();
    let said = text.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("it said nothing");
    format!("ended with {status}: {said}")
}
