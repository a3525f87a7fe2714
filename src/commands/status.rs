//! `meniscus status` and `meniscus ask`: a run that goes on, from outside.

use super::{FAILED, WRONG, failed, say, tell};
use crate::arguments::{Ask, Status as Asked};
use coupler::request::Request;
use coupler::run::{CASE, SUMMARY, checkpoint, is_alive};
use coupler::status::Status;
use output::summary::{self, Summary};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant, SystemTime};

/// A run that has written its status within this time lives, whatever is known of its lock.
const RECENT: Duration = Duration::from_secs(5);
/// Between two looks for an answer.
const LOOK: Duration = Duration::from_millis(100);

/// What is found in a folder.
enum Found {
    /// A run that goes on; what it is at, if it has told already.
    Alive(Option<(Status, Duration)>),
    /// A run that has ended and made its summary.
    Ended(Box<Summary>),
    /// A run that has neither.
    Killed(Option<(Status, Duration)>),
}

/// Tells what a run is at.
pub fn status(arguments: &Asked) -> ExitCode {
    let dir = &arguments.dir;
    let found = match find(dir) {
        Ok(found) => found,
        Err(code) => return code,
    };
    match found {
        Found::Alive(None) => say("starting    it has told nothing yet"),
        Found::Alive(Some((status, old))) => {
            status.lines(old).iter().for_each(say);
            tell_of_silence(&status, old);
        }
        Found::Ended(summary) => {
            let Summary { windows, simulated_seconds, wall_seconds, .. } = *summary;
            say(&summary.title);
            say(format_args!(
                "{:<12}{windows} windows to t = {simulated_seconds} s in {wall_seconds:.1} s",
                summary.status.word()
            ));
            summary.message.iter().for_each(|message| say(format_args!("because     {message}")));
            if summary.status != summary::Status::Completed {
                tell_of_checkpoint(dir);
                return ExitCode::from(FAILED);
            }
        }
        Found::Killed(last) => {
            say("killed      it has ended without a summary: it was killed, or its host went down");
            if let Some((status, old)) = last {
                say(format_args!("last seen   {} s ago", old.as_secs()));
                status.lines(old).iter().for_each(say);
            }
            tell_of_checkpoint(dir);
            return ExitCode::from(FAILED);
        }
    }
    ExitCode::SUCCESS
}

/// Tells of a run that lives and has told nothing for a while.
fn tell_of_silence(status: &Status, old: Duration) {
    if old > RECENT {
        let seconds = old.as_secs();
        say(format_args!(
            "silent      it has told nothing for {seconds} s: process {} is stopped, or cannot write to its folder",
            status.process
        ));
    }
}

fn tell_of_checkpoint(dir: &Path) {
    match checkpoint::newest(dir) {
        Ok((found, _)) => say(format_args!(
            "go on       meniscus run --resume {}, from t = {} s",
            dir.display(),
            found.header.time
        )),
        Err(_) => say("go on       it cannot: there is no checkpoint"),
    }
}

/// What is in that folder.
fn find(dir: &Path) -> Result<Found, ExitCode> {
    if !dir.join(CASE).is_file() {
        return Err(failed(format_args!(
            "failed to find a run in {}: there is no {CASE}; name the folder that the run writes (its --out)",
            dir.display()
        )));
    }
    let status = Status::read(dir).ok().map(|status| {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let old = (now.as_secs_f64() - status.written).max(0.0);
        (status, Duration::try_from_secs_f64(old).unwrap_or_default())
    });
    if is_alive(dir) || status.as_ref().is_some_and(|(_, old)| *old < RECENT && !is_free(dir)) {
        return Ok(Found::Alive(status));
    }
    match Summary::read(&dir.join(SUMMARY)) {
        Ok(summary) => Ok(Found::Ended(Box::new(summary))),
        Err(_) => Ok(Found::Killed(status)),
    }
}

/// Whether nobody holds the lock of a run that lives, where the file system tells.
fn is_free(dir: &Path) -> bool {
    std::fs::File::open(dir.join(CASE)).is_ok_and(|case| case.try_lock().is_ok())
}

/// Asks a run for something, and waits for what comes of it.
pub fn ask(arguments: &Ask) -> ExitCode {
    let Ask { dir, checkpoint, stop, output_interval, wait } = arguments;
    if let Some(interval) = output_interval.filter(|interval| !(*interval > 0.0 && interval.is_finite())) {
        tell(format_args!(
            "error: --output-interval {interval}: it has to be positive; give seconds, as 0.001"
        ));
        return ExitCode::from(WRONG);
    }
    match find(dir) {
        Ok(Found::Alive(_)) => {}
        Ok(_) => {
            return failed(format_args!("no run goes on in {}; see meniscus status", dir.display()));
        }
        Err(code) => return code,
    }
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let number = u64::try_from(now.as_nanos()).unwrap_or(u64::MAX);
    let request = Request { number, checkpoint: *checkpoint, stop: *stop, output_interval: *output_interval };
    if let Err(error) = request.write(dir) {
        return failed(error);
    }
    let deadline = Instant::now() + Duration::try_from_secs_f64(*wait).unwrap_or_default();
    loop {
        let found = match find(dir) {
            Ok(found) => found,
            Err(code) => return code,
        };
        match found {
            Found::Alive(Some((Status { answered: Some(answered), .. }, _))) if answered.number >= number => {
                answered.what.iter().for_each(say);
                return ExitCode::SUCCESS;
            }
            Found::Alive(told) if Instant::now() >= deadline => {
                say("asked       it has not been taken up yet, and will be after the window at hand");
                if let Some((status, old)) = &told {
                    status.waits().iter().for_each(say);
                    tell_of_silence(status, *old);
                }
                return ExitCode::from(FAILED);
            }
            Found::Alive(_) => std::thread::sleep(LOOK),
            Found::Ended(_) if *stop => return ended(dir),
            Found::Ended(_) | Found::Killed(_) => {
                return failed(format_args!("the run in {} ended before it took that up", dir.display()));
            }
        }
    }
}

/// Tells how a run ended that was asked to.
fn ended(dir: &Path) -> ExitCode {
    status(&Asked { dir: dir.to_owned() });
    ExitCode::SUCCESS
}
