//! The command line.

use clap::{Args, Parser, Subcommand, ValueEnum};
use output::report::View;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use validation::sweep::Over;

/// Couples a particle fluid (ISPH) and an elastic structure (TLSPH), each a process of its own, over shared
/// memory.
#[derive(Parser)]
#[command(version, arg_required_else_help = true, after_help = EXAMPLES)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  meniscus run cases/elastic_gate                       the dam break through an elastic gate, into out/elastic_gate
  meniscus run cases/elastic_gate --set coupling.sub_steps=stable --end-time 0.1
  meniscus check my_case.toml                           all mistakes of a case at once, and what would run
  meniscus report out/elastic_gate --times 0.04,0.12    report.html with curves, balances and these frames
  meniscus validate structure                           benchmarks against their references, into out/validate
  meniscus validate fsi --case walhorn_baffle           fluid and structure together, one case of them
  meniscus export-fmu cases/oscillating_plate -o plate.fmu    the structure for FMPy and other FMI tools
  meniscus run my_case.toml --set structure.participant.fmu=plate.fmu    an FMU in the place of a solver
  meniscus run --resume out/elastic_gate                go on from the last checkpoint of a run
  meniscus status out/elastic_gate                      what a run is at: rate, time left, who waits for whom
  meniscus sweep my_case.toml --over structure.material.youngs_modulus=0.5e6,1e6,4e6    one run for each modulus
  meniscus run my_case.toml --record my.record          keep all that crosses, to play either side back
  meniscus mock --help                                  partners to test a solver of your own against";

/// Exit codes: 0 done, 1 failed, 2 the case or the arguments are wrong, 130 interrupted.
#[derive(Subcommand)]
pub enum Command {
    /// Run a case: coupler, fluid and structure as processes; a case of one side runs that solver alone
    Run(Run),
    /// Write a commented case that runs, to start from
    New(New),
    /// Check a case, report every mistake at once, and print what would run
    Check(Check),
    /// Tell what a run is at: how far, how fast, who waits for whom, since when; exit code 1 if it was killed
    /// or failed
    Status(Status),
    /// Ask a run that goes on for a checkpoint, for its end, or for outputs at another interval
    Ask(Ask),
    /// Make report.html (and frames as PNG) from the outputs of a run
    Report(Report),
    /// Run cases at several resolutions and hold them against their references; exit code 1 if one misses its
    /// tolerance
    Validate(Validate),
    /// Run a case at every combination of some values of its keys, and lay the curves side by side; the same
    /// command goes on with a sweep that was cut off
    Sweep(Sweep),
    /// Serve a case's fluid to a coupler (started by `run`, or by hand)
    Fluid(Solver),
    /// Serve a case's structure to a coupler (started by `run`, or by hand)
    Structure(Solver),
    /// Serve the functional mock-up unit (FMU) that a case names for a side (started by `run`, or by hand)
    Fmu(Fmu),
    /// Serve a mock partner to a coupler
    Mock(Mock),
    /// Package the structure of a case as a functional mock-up unit (FMU) for co-simulation in other tools
    ExportFmu(ExportFmu),
    /// Load and instantiate the unit of a side (started by `check`)
    #[command(hide = true, name = "probe-fmu")]
    ProbeFmu {
        /// Side that the unit solves
        #[arg(value_enum)]
        role: Side,
        /// The case.
        #[command(flatten)]
        case: CaseArguments,
    },
    /// End what is left of a run whose coupler was killed (started by `run`)
    #[command(hide = true)]
    Guard {
        /// The run
        run: String,
    },
    /// Become another program once the run says so, or end with it (started by `run`)
    #[command(hide = true)]
    Become {
        /// The program and its arguments
        #[arg(required = true, trailing_var_arg = true, allow_hyphen_values = true)]
        words: Vec<String>,
    },
    /// Measure what the coupling itself takes
    #[command(subcommand)]
    Bench(Bench),
    /// Print the JSON schema of case files, for editors
    Schema(Schema),
}

impl Command {
    /// Whether a person gives it, rather than a run, and it does not look after shared memory itself.
    pub fn is_of_the_user(&self) -> bool {
        matches!(
            self,
            Self::New(_)
                | Self::Check(_)
                | Self::Status(_)
                | Self::Ask(_)
                | Self::Report(_)
                | Self::Validate(_)
                | Self::Sweep(_)
                | Self::ExportFmu(_)
                | Self::Schema(_)
        )
    }
}

/// A case and changes to it.
#[derive(Args)]
pub struct CaseArguments {
    /// Case file, or the folder that holds it as case.toml
    pub case: PathBuf,
    /// Override a key of the case, for example --set coupling.relaxation=0.4; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Override case.end_time (s)
    #[arg(long, value_name = "SECONDS")]
    pub end_time: Option<f64>,
}

/// `meniscus new`.
#[derive(Args)]
pub struct New {
    /// Folder to write case.toml into
    pub name: PathBuf,
    /// What it is a case of
    #[arg(long, value_enum, default_value = "dam-break")]
    pub template: Template,
}

/// Cases to start from.
#[derive(Clone, Copy, ValueEnum)]
pub enum Template {
    /// Water that falls into an empty tank
    DamBreak,
    /// Water in a tank that rolls: a wall with a motion
    Tank,
    /// An elastic plate alone
    Plate,
    /// Water on an elastic plate
    Coupled,
}

/// `meniscus check`.
#[derive(Args)]
pub struct Check {
    /// The case.
    #[command(flatten)]
    pub case: CaseArguments,
    /// Run the beginning of the case for some seconds, and say what the whole would take
    #[arg(long)]
    pub time: bool,
}

/// `meniscus run`.
#[derive(Args)]
#[command(after_help = RESTART)]
pub struct Run {
    /// Case file, or the folder that holds it as case.toml; that of the run that goes on, where left out
    #[arg(required_unless_present_any = ["resume", "branch"])]
    pub case: Option<PathBuf>,
    /// Override a key of the case, for example --set coupling.relaxation=0.4; repeatable
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Override case.end_time (s)
    #[arg(long, value_name = "SECONDS")]
    pub end_time: Option<f64>,
    /// Folder of the outputs [default: out/NAME, the name of the case]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Go on with the run in this folder from its newest checkpoint, to the bit
    #[arg(long, value_name = "DIR", conflicts_with_all = ["out", "branch"])]
    pub resume: Option<PathBuf>,
    /// Start another run, into --out, from the newest checkpoint in this folder, or from this checkpoint; any
    /// key may be another that leaves particles, probes and scheme what they are
    #[arg(long, value_name = "DIR", requires = "out")]
    pub branch: Option<PathBuf>,
    /// Write a checkpoint after every so much simulated time (s): checkpoints.every
    #[arg(long, value_name = "SECONDS")]
    pub checkpoint_every: Option<f64>,
    /// Call the solvers in this process: the same results to the bit, no processes, no shared memory
    #[arg(long)]
    pub in_process: bool,
    /// Show no progress
    #[arg(long)]
    pub quiet: bool,
    /// Change what crosses, or have participants fail, as this file says: for tests and for sensitivity
    /// (docs/scenarios.md)
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    pub scenario: Option<PathBuf>,
    /// Write trace.json: who computed, waited, mapped and sent, when; for ui.perfetto.dev or chrome://tracing
    #[arg(long)]
    pub trace: bool,
    /// Record all that crosses between the coupler and both sides into this file, which must not be there
    /// yet; `meniscus mock --replay FILE` then stands in for either side
    #[arg(long, value_name = "FILE", conflicts_with_all = ["resume", "branch"])]
    pub record: Option<PathBuf>,
    /// Size of that file at most, for example 500MB: the recording ends there, and the run goes on
    #[arg(long, value_name = "SIZE", default_value = "4GB", value_parser = size, requires = "record")]
    pub record_limit: u64,
    /// Do not make the report at the end
    #[arg(long)]
    pub no_report: bool,
    /// Prefix of everything in shared memory; whoever of a domain finds what a killed run of it left removes
    /// it
    #[arg(long, env = "MENISCUS_DOMAIN", value_name = "NAME", hide = true)]
    pub domain: Option<String>,
}

const RESTART: &str = "\
Checkpoints: the state of the whole run, in OUT/checkpoints, from which it goes on to the bit. One is written
every 10 minutes on the clock, at the times that the case or --checkpoint-every asks for, on SIGUSR1 (the run goes
on), and on Ctrl-C or SIGTERM after the window at hand (the run ends; a second signal ends it at once). The keys
are those of [checkpoints]; all of it is in docs/restart.md.

  meniscus run case.toml --out out/a --checkpoint-every 0.01
  meniscus run --resume out/a                       go on where it was killed, or has ended
  meniscus run --resume out/a --end-time 2          a run that has ended, longer
  meniscus run --branch out/a --out out/b --set structure.material.youngs_modulus=2e6

Recordings: all that crossed, to the bit, from which either side is played back where its program is not there, or
to find where another build, machine or option first departs; all of it is in docs/record.md.

  meniscus run case.toml --record gate.record
  meniscus run case.toml --out out/c --set 'fluid.participant={command=[\"meniscus\", \"mock\", \"--replay\", \"gate.record\"]}'";

/// A number of bytes, with kB, MB or GB after it.
fn size(text: &str) -> Result<u64, String> {
    let units = [("kB", 1e3), ("MB", 1e6), ("GB", 1e9), ("B", 1.0)];
    let found = units.into_iter().find_map(|(unit, bytes)| Some((text.strip_suffix(unit)?, bytes)));
    let (number, bytes) = found.unwrap_or((text, 1.0));
    match number.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number * bytes < 1e18 => Ok((number * bytes) as u64),
        _ => Err("give a number with its unit, for example 500MB or 4GB".to_owned()),
    }
}

/// `meniscus status`.
#[derive(Args)]
pub struct Status {
    /// Folder of the run's outputs
    pub dir: PathBuf,
}

/// `meniscus ask`.
#[derive(Args)]
#[command(after_help = ASKING, group = clap::ArgGroup::new("what").required(true).multiple(true))]
pub struct Ask {
    /// Folder of the run's outputs
    pub dir: PathBuf,
    /// Write a checkpoint
    #[arg(long, group = "what")]
    pub checkpoint: bool,
    /// End in order, with a checkpoint unless checkpoints.at_stop is false
    #[arg(long, group = "what")]
    pub stop: bool,
    /// Write outputs at this interval from now on (s of simulated time)
    #[arg(long, value_name = "SECONDS", group = "what", allow_negative_numbers = true)]
    pub output_interval: Option<f64>,
    /// Wait so long for the answer (s)
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    pub wait: f64,
}

const ASKING: &str = "\
Exit code 0: it was taken up; 1: not yet, or no run goes on there.

The run takes it up after the window at hand. The request is a file in its folder, so the run may go on on
another host of a cluster.

  meniscus ask out/gate --checkpoint
  meniscus ask out/gate --output-interval 0.001";

/// `meniscus export-fmu`.
#[derive(Args)]
pub struct ExportFmu {
    /// The case.
    #[command(flatten)]
    pub case: CaseArguments,
    /// The archive to write; NAME.ssp is a system (SSP 1.0) of the unit and its connectors
    #[arg(short, long, value_name = "FILE", default_value = "structure.fmu")]
    pub output: PathBuf,
    /// Version of the standard: 3 with arrays of the whole interface, 2 with scalar variables at some points
    #[arg(long, value_enum, default_value = "3")]
    pub fmi: FmiVersion,
    /// Scalar variables at some points in FMI 3.0 too, for tools that know no arrays
    #[arg(long)]
    pub scalars: bool,
    /// Points that stand for the interface where variables are scalars, as far apart as can be [default: 8]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    pub points: Option<u32>,
    /// Library of another platform to pack too, for example aarch64-darwin=libmeniscus_structure.dylib;
    /// repeatable
    #[arg(long, value_name = "PLATFORM=FILE", value_parser = library)]
    pub library: Vec<meniscus_structure::package::Library>,
}

/// Versions of FMI.
#[derive(Clone, Copy, ValueEnum)]
pub enum FmiVersion {
    /// FMI 2.0
    #[value(name = "2")]
    Two,
    /// FMI 3.0
    #[value(name = "3")]
    Three,
}

fn library(text: &str) -> Result<meniscus_structure::package::Library, String> {
    let (platform, file) = text
        .split_once('=')
        .ok_or("give PLATFORM=FILE, for example x86_64-windows=meniscus_structure.dll")?;
    Ok(meniscus_structure::package::Library { platform: platform.to_owned(), file: file.into() })
}

/// `meniscus report`.
#[derive(Args)]
pub struct Report {
    /// Folder of the outputs of a run
    pub dir: PathBuf,
    /// Draw the snapshots nearest to these times (s) [default: evenly over the run, and at extremes of
    /// probes]
    #[arg(long, value_name = "SECONDS", value_delimiter = ',')]
    pub times: Vec<f64>,
    /// Draw this box (m) [default: all of the structure, and the fluid without drops that fly far]
    #[arg(long, value_name = "LEFT,BOTTOM,RIGHT,TOP", value_parser = view, allow_hyphen_values = true)]
    pub view: Option<View>,
}

fn view(text: &str) -> Result<View, String> {
    let numbers: Vec<f64> = text.split(',').map_while(|number| number.trim().parse().ok()).collect();
    match numbers[..] {
        [left, bottom, right, top]
            if left < right && bottom < top && (right - left + top - bottom).is_finite() =>
        {
            Ok(View { x: (left, right), y: (bottom, top) })
        }
        _ => Err("give four numbers, for example --view=-0.1,0,0.5,0.3".to_owned()),
    }
}

/// `meniscus validate`.
#[derive(Args)]
pub struct Validate {
    /// Which cases
    pub suite: Suite,
    /// Only this case
    #[arg(long, value_name = "NAME")]
    pub case: Option<String>,
    /// Only the coarse resolutions: seconds instead of minutes
    #[arg(long)]
    pub coarse: bool,
    /// Folder that holds the case folders
    #[arg(long, value_name = "DIR", default_value = "cases")]
    pub cases: PathBuf,
    /// Folder of the outputs: tables and a page in DIR/validate, each run below it
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Show no progress
    #[arg(long)]
    pub quiet: bool,
}

/// `meniscus sweep`.
#[derive(Args)]
pub struct Sweep {
    /// The case.
    #[command(flatten)]
    pub case: CaseArguments,
    /// A key and its values, for example --over structure.material.youngs_modulus=0.5e6,1e6,4e6; repeatable,
    /// for all combinations
    #[arg(long, value_name = "KEY=VALUE,VALUE,…", required = true)]
    pub over: Vec<Over>,
    /// Members that run at once; they share the cores
    #[arg(long, value_name = "N", default_value = "1")]
    pub jobs: NonZeroUsize,
    /// Folder of the outputs: sweep.csv, sweep.html, and a folder per member [default: out/CASE-sweep]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Make no report of each member
    #[arg(long)]
    pub no_report: bool,
}

/// The cases of `meniscus validate`: those whose `validation.toml` says so.
#[derive(Clone, Copy, ValueEnum)]
pub enum Suite {
    /// The structure alone
    Structure,
    /// The fluid alone
    Fluid,
    /// Fluid and structure together
    Fsi,
}

/// `meniscus fluid`, `meniscus structure`.
#[derive(Args)]
pub struct Solver {
    /// Case file as the coupler resolved it: case.toml in the folder of the outputs, where this participant
    /// writes too
    #[arg(env = "MENISCUS_CASE")]
    pub case: PathBuf,
    /// The run.
    #[command(flatten)]
    pub join: Join,
}

/// `meniscus fmu`.
#[derive(Args)]
pub struct Fmu {
    /// Side that the unit solves
    #[arg(value_enum, env = "MENISCUS_ROLE")]
    pub role: Side,
    /// The case and the run.
    #[command(flatten)]
    pub solver: Solver,
}

/// The run that a participant joins.
#[derive(Args)]
pub struct Join {
    /// Name of the run to join, as the coupler prints or passes it
    #[arg(long, env = "MENISCUS_RUN", value_name = "ID")]
    pub run: String,
    /// Process of the coupler; the participant ends when it does, also before it could join
    #[arg(long, env = "MENISCUS_COUPLER", value_name = "PROCESS", hide = true)]
    pub coupler: Option<u32>,
}

/// `meniscus mock`.
#[derive(Args)]
#[command(after_help = partners::help())]
pub struct Mock {
    /// Kind of partner and its settings, for example: spring-mass points=40 stiffness=1e4
    #[arg(
        required_unless_present = "replay",
        conflicts_with = "replay",
        trailing_var_arg = true,
        allow_hyphen_values = true
    )]
    pub words: Vec<String>,
    /// Instead stand in for one side of the run that `meniscus run --record FILE` recorded: give what it
    /// gave, to the bit, and compare what is taken with what it took
    #[arg(long, value_name = "FILE")]
    pub replay: Option<PathBuf>,
    /// With --replay: the side to stand in for, as the coupler passes it
    #[arg(long, value_enum, env = "MENISCUS_ROLE")]
    pub role: Option<Side>,
    /// With --replay: what to do where the run departs from the recording, after saying where and by how much
    #[arg(long, value_enum, default_value = "end")]
    pub on_departure: OnDeparture,
    /// Case file as the coupler resolved it
    #[arg(long, env = "MENISCUS_CASE", value_name = "FILE")]
    pub case: PathBuf,
    /// The run.
    #[command(flatten)]
    pub join: Join,
}

/// What a replay does where the run departs from the recording.
#[derive(Clone, Copy, ValueEnum)]
pub enum OnDeparture {
    /// End the run as failed: what was recorded is no answer to what is asked then
    End,
    /// Answer as recorded, and tell the largest departure of each field at the end
    Continue,
}

/// `meniscus bench`.
#[derive(Subcommand)]
pub enum Bench {
    /// Time of a window whose participants do nothing, beside the raw transfer of the same messages
    Exchange(Exchange),
    /// The other end of a raw transfer (started by `bench exchange`)
    #[command(hide = true)]
    Echo(Echo),
}

/// `meniscus bench exchange`.
#[derive(Args)]
pub struct Exchange {
    /// Numbers of interface points
    #[arg(default_values_t = [100, 1_000, 10_000, 100_000])]
    pub points: Vec<usize>,
    /// Windows a measurement [default: about a second of them]
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u64).range(10..))]
    pub windows: Option<u64>,
    /// Leave each process where the system puts it, as coupling.share_core = false does
    #[arg(long)]
    pub apart: bool,
    /// Prefix of everything in shared memory
    #[arg(long, env = "MENISCUS_DOMAIN", value_name = "NAME", hide = true)]
    pub domain: Option<String>,
}

/// `meniscus bench echo`.
#[derive(Args)]
pub struct Echo {
    /// Role of the end
    #[arg(value_enum)]
    pub role: Side,
    /// Doubles of a message taken
    pub taken: usize,
    /// Doubles of a message given
    pub given: usize,
    /// The run to join
    #[arg(long)]
    pub run: String,
}

/// `meniscus schema`.
#[derive(Args)]
pub struct Schema {
    /// Instead, make the tables of keys in this page anew, as in docs/case-file.md
    #[arg(long, value_name = "FILE")]
    pub docs: Option<PathBuf>,
}

/// A side of the coupling.
#[derive(Clone, Copy, ValueEnum)]
pub enum Side {
    /// The fluid
    Fluid,
    /// The structure
    Structure,
}

impl From<Side> for interfaces::Role {
    fn from(side: Side) -> Self {
        match side {
            Side::Fluid => Self::Fluid,
            Side::Structure => Self::Structure,
        }
    }
}
