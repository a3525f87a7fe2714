//! The folder of a run's outputs.

use super::checkpoint;
use super::found::Found;
use super::options::RunError;
use crate::scenario::Scenario;
use crate::trace::TRACE;
use interfaces::case::Case;
use output::files;
use std::fs::{File, TryLockError};
use std::io::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

/// File of the case as resolved, in the folder of the outputs.
pub const CASE: &str = "case.toml";
/// The line that tells a case as resolved from a case as written, which must not be overwritten.
const RESOLVED: &str = "# The case as resolved by meniscus: every default filled in, all overrides applied.";
/// Folders into which a role's functional mock-up unit is unpacked while it runs.
const UNPACKED: [&str; 2] = ["fluid_fmu", "structure_fmu"];
/// File that keeps room for the summary on the disk while the run goes on.
const ROOM: &str = ".room";
/// More than a summary takes.
const ROOM_BYTES: usize = 64 << 10;
/// How long the participants of a killed run, which may still write, have to end: longer than its guard gives
/// them.
const LEAVING: Duration = Duration::from_secs(3);
/// Between two looks whether they have.
const LOOK: Duration = Duration::from_millis(5);
/// File of the summary.
pub const SUMMARY: &str = "summary.json";

/// The locks of a run on its folder.
pub(crate) struct Held {
    /// The folder: held by the coupler and its guard, so that nobody writes there before what a killed run
    /// left has ended.
    pub folder: File,
    /// The resolved case: held by the coupler alone, so that others know at once whether it lives.
    _case: File,
}

/// Makes the folder, or empties it of an earlier run; writes the case as resolved. Gives the folder, locked
/// while it is open.
pub(crate) fn prepare(out: &Path, case: &Case) -> Result<Held, RunError> {
    let folder = |what: String| RunError::Folder { path: out.to_owned(), what };
    std::fs::create_dir_all(out).map_err(|e| folder(e.to_string()))?;
    let mut entries = std::fs::read_dir(out).map_err(|e| folder(e.to_string()))?;
    let locked = locked(out)?;
    let written = files::read_text(&out.join(CASE), files::WORDS);
    let holds_a_run = written.is_ok_and(|text| text.lines().next() == Some(RESOLVED));
    if !holds_a_run && entries.next().is_some() {
        return Err(folder("it holds files that are not of an earlier run".to_owned()));
    }
    let folders = ["fluid", "structure", "walls", "failed_solve", "frames", super::found::FOLDER];
    for name in folders.into_iter().chain(UNPACKED) {
        remove(&out.join(name), |p| std::fs::remove_dir_all(p)).map_err(|e| folder(e.to_string()))?;
    }
    let files = [
        SUMMARY,
        ROOM,
        crate::status::FILE,
        crate::request::FILE,
        crate::scenario::FILE,
        crate::records::WINDOWS,
        crate::records::PROBES,
        crate::records::INTERVALS,
        crate::records::ITERATIONS,
        output::columns::FILE,
        TRACE,
        "report.html",
        "fluid.pvd",
        "structure.pvd",
        "walls.pvd",
        "failed_solve.pvd",
        "fluid.log",
        "structure.log",
    ];
    for name in files {
        remove(&out.join(name), |p| std::fs::remove_file(p)).map_err(|e| folder(e.to_string()))?;
    }
    begin(locked, out, case).map_err(folder)
}

/// Locks the folder of a run that is to go on from what was `found` in it, and writes the case as it is now;
/// what is made anew is removed.
pub(crate) fn go_on(out: &Path, case: &Case, found: &Found) -> Result<Held, RunError> {
    let folder = |what: String| RunError::Folder { path: out.to_owned(), what };
    let locked = locked(out)?;
    // A run that lived when the checkpoint was found has written others since.
    if !checkpoint::newest(out).is_ok_and(|(newest, _)| newest.path == found.path) {
        return Err(folder("a run has just ended there; give the command again".to_owned()));
    }
    for name in UNPACKED {
        remove(&out.join(name), |p| std::fs::remove_dir_all(p)).map_err(|e| folder(e.to_string()))?;
    }
    // Collections are made again of the snapshots that are there.
    let made_anew = [SUMMARY, ROOM, TRACE, "report.html", "fluid.pvd", "structure.pvd", "walls.pvd"];
    for name in made_anew.into_iter().chain([crate::status::FILE, crate::request::FILE]) {
        remove(&out.join(name), |p| std::fs::remove_file(p)).map_err(|e| folder(e.to_string()))?;
    }
    begin(locked, out, case).map_err(folder)
}

/// Brings tables and snapshots of the run that a checkpoint is of into the folder of a branch: tables are
/// copied, snapshots are the same files where the disk can do that.
pub(crate) fn branch(out: &Path, found: &Found) -> Result<(), RunError> {
    let folder = |what: String| RunError::Folder { path: out.to_owned(), what };
    let of = found.run();
    for name in found.header.tables.keys().map(String::as_str).chain([output::columns::FILE]) {
        let copied = files::open(&of.join(name), u64::MAX).and_then(|mut from| {
            std::io::copy(&mut from, &mut files::create(&out.join(name))?)?;
            Ok(())
        });
        copied.map_err(|error| folder(format!("{name} of the run could not be copied: {error}")))?;
    }
    for series in ["fluid", "structure", "walls"] {
        let Ok(snapshots) = std::fs::read_dir(of.join(series)) else { continue };
        files::folder(&out.join(series)).map_err(|e| folder(e.to_string()))?;
        for snapshot in snapshots.flatten() {
            let (from, to) = (snapshot.path(), out.join(series).join(snapshot.file_name()));
            let taken = std::fs::hard_link(&from, &to).or_else(|_| std::fs::copy(&from, &to).map(drop));
            taken.map_err(|error| folder(format!("{} could not be taken: {error}", from.display())))?;
        }
    }
    Ok(())
}

/// The folder, locked while it is open. What a killed run left there still to end is waited for; a run that
/// lives is not.
fn locked(out: &Path) -> Result<File, RunError> {
    let folder = |what: String| RunError::Folder { path: out.to_owned(), what };
    let opened = File::open(out).map_err(|e| folder(e.to_string()))?;
    let deadline = Instant::now() + LEAVING;
    loop {
        match opened.try_lock() {
            // Some file systems know no locks; the run does not depend on them.
            Ok(()) | Err(TryLockError::Error(_)) => return Ok(opened),
            Err(TryLockError::WouldBlock) if is_alive(out) || Instant::now() >= deadline => {
                return Err(folder("another run writes to it".to_owned()));
            }
            Err(TryLockError::WouldBlock) => std::thread::sleep(LOOK),
        }
    }
}

/// Whether the coupler of the run in a folder lives, on any host whose locks are seen here: it holds the lock
/// of its case, which its guard does not.
pub fn is_alive(out: &Path) -> bool {
    File::open(out.join(CASE)).is_ok_and(|case| matches!(case.try_lock(), Err(TryLockError::WouldBlock)))
}

/// Writes the case as resolved, and keeps room for the summary.
fn begin(folder: File, out: &Path, case: &Case) -> Result<Held, String> {
    let (path, text) = (out.join(CASE), format!("{RESOLVED}\n\n{}", case.to_toml()));
    output::atomic::write_file(&path, text.as_bytes()).map_err(|e| e.to_string())?;
    let held = File::open(&path).map_err(|e| e.to_string())?;
    // One who looks whether we live holds it for no time; a stranger who keeps it is not waited for.
    let deadline = Instant::now() + LEAVING;
    while matches!(held.try_lock(), Err(TryLockError::WouldBlock)) && Instant::now() < deadline {
        std::thread::sleep(LOOK);
    }
    let room = files::create(&out.join(ROOM));
    room.and_then(|mut room| room.write_all(&[0; ROOM_BYTES])).map_err(|e| e.to_string())?;
    Ok(Held { folder, _case: held })
}

/// Keeps the scenario of a run beside its outputs: it goes on under it.
pub(super) fn keep_scenario(out: &Path, scenario: Option<&Scenario>) -> Result<(), RunError> {
    let Some(scenario) = scenario else { return Ok(()) };
    Ok(output::atomic::write_file(&out.join(crate::scenario::FILE), scenario.text.as_bytes())?)
}

/// Gives room on the disk back for the summary, which then is there also where the disk is full.
pub(super) fn free_room(out: &Path) {
    // Where it cannot be removed, the summary may still find room.
    let _ = std::fs::remove_file(out.join(ROOM));
}

fn remove(path: &Path, how: impl Fn(&Path) -> std::io::Result<()>) -> std::io::Result<()> {
    match how(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Removes what a unit's process could not remove because it died. What is left all the same, the next run
/// removes.
pub(super) fn remove_unpacked(out: &Path) {
    for name in UNPACKED {
        let _ = std::fs::remove_dir_all(out.join(name));
    }
}
