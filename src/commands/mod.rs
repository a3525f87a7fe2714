//! One file a command: from arguments to the one call that does the work, and back to an exit code.

pub mod bench;
pub mod check;
pub mod export_fmu;
pub mod new;
pub mod participant;
pub mod report;
pub mod resume;
pub mod run;
pub mod schema;
pub mod status;
pub mod sweep;
pub mod validate;

use crate::arguments::CaseArguments;
use interfaces::case::{Case, Findings, Sections};
use interfaces::{Address, Participant, Result, Role, new_run, remove_stale};
use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use words::text::tame;

/// Something could not be done.
pub const FAILED: u8 = 1;
/// The case or the arguments are wrong.
pub const WRONG: u8 = 2;
/// Characters of a message on standard error at most: hundreds of mistakes.
const MOST: usize = 100_000;
/// Ended by Ctrl-C or SIGTERM, as shells report it.
pub const INTERRUPTED: u8 = 130;

/// Sections of the case that our own solvers bring.
pub const SECTIONS: [Sections; 2] = [fluid::participant::SECTIONS, structure::participant::SECTIONS];

/// Reads a case with the overrides of the command line; prints all its mistakes if it has any.
fn load(arguments: &CaseArguments) -> Result<Case, ExitCode> {
    Case::load(&arguments.case, &overrides(arguments), &SECTIONS).map_err(|errors| {
        tell(&errors);
        ExitCode::from(WRONG)
    })
}

/// What the command line sets in the case.
fn overrides(arguments: &CaseArguments) -> Vec<String> {
    let mut overrides = arguments.set.clone();
    overrides.extend(arguments.end_time.map(|t| format!("case.end_time={t:?}")));
    overrides
}

/// Tells what was found wrong with a case that was read.
fn refuse(arguments: &CaseArguments, findings: Findings) -> ExitCode {
    tell(Case::refuse(&arguments.case, &overrides(arguments), findings));
    ExitCode::from(WRONG)
}

/// Our own solver for one side of a case, writing its snapshots to `out`.
fn solver(case: &Case, role: Role, out: &Path) -> Result<Box<dyn Participant>> {
    match role {
        Role::Fluid => fluid::participant::from_case(case, out),
        Role::Structure => structure::participant::from_case(case, out),
    }
}

/// Gives rayon as many threads as the case says, before any solver asks for it.
fn set_threads(case: &Case) {
    // It fails if the pool stands already: it then has the threads of the first call, which no result depends
    // on.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(coupler::run::threads(case)).build_global();
}

/// A flag that Ctrl-C, SIGTERM and the terminal's end (SIGHUP, unless `nohup` had it ignored) set; a second
/// signal ends the process at once.
fn stop_flag() -> std::io::Result<Arc<AtomicBool>> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        if signal == SIGHUP && is_ignored(signal) {
            continue;
        }
        signal_hook::flag::register_conditional_shutdown(signal, i32::from(INTERRUPTED), Arc::clone(&stop))?;
        signal_hook::flag::register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}

/// A flag that SIGUSR1 sets, by which a queue warns before it ends a job: a run writes a checkpoint then, and
/// nobody else is ended by it.
pub fn checkpoint_flag() -> std::io::Result<Arc<AtomicBool>> {
    let asked = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(signal_hook::consts::SIGUSR1, Arc::clone(&asked))?;
    Ok(asked)
}

/// Whether this process was started with the signal ignored, where the system tells.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .is_some_and(|m| m >> (signal - 1) & 1 == 1)
}

/// Removes what runs that were killed left in shared memory, all of their processes at once: the next command
/// of any kind does it. Where it cannot, the next run says so.
pub fn tidy() {
    let address = Address::new(new_run(), Role::Fluid);
    let address = match std::env::var("MENISCUS_DOMAIN") {
        Ok(domain) => address.in_domain(domain),
        Err(_) => address,
    };
    if Path::new(&address.root()).is_dir() {
        let _ = remove_stale(&address);
    }
}

fn failed(what: impl std::fmt::Display) -> ExitCode {
    tell(format_args!("error: {what}"));
    ExitCode::from(FAILED)
}

/// Tells the user on standard error, in words that steer no terminal.
fn tell(what: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr(), "{}", tame(&what.to_string(), MOST));
}

/// Prints a line for the user. One who closed the pipe does not want it: that is no error.
fn say(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stdout(), "{}", tame(&line.to_string(), usize::MAX));
}
