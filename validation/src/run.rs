//! Runs every variant of a study in this process and takes its measures.

use crate::measure::{self, Tables};
use crate::order::{Convergence, convergence};
use crate::study::{Measure, Series, Study};
use coupler::run::{CASE, Solvers};
use interfaces::case::{Case, Sections};
use interfaces::{Participant, Result, Role};
use output::summary::Status;
use output::table::{self, Columns};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Makes the solver of one side of a case, writing its snapshots to a folder.
pub type Make<'a> = dyn Fn(&Case, Role, &Path) -> Result<Box<dyn Participant>> + 'a;

/// What the command line sets.
pub struct Options {
    /// Folder of the outputs: of `validation.csv`, `validation.html` and the runs.
    pub out: PathBuf,
    /// Whether only the coarse resolutions of each series are run.
    pub coarse: bool,
    /// Whether nothing is drawn on the terminal while a variant runs.
    pub quiet: bool,
    /// Sections of the case that the solvers bring.
    pub sections: Vec<Sections>,
    /// Becomes true when the command is told to stop.
    pub stop: Arc<AtomicBool>,
}

/// What came out of a case.
pub struct CaseResult {
    /// Name of the case folder.
    pub name: String,
    /// The case's title.
    pub title: String,
    /// Its study.
    pub study: Study,
    /// A series each, those that were run.
    pub series: Vec<SeriesResult>,
}

/// What came out of a series.
pub struct SeriesResult {
    /// The series.
    pub series: Series,
    /// The base case as the series changes it, at the last resolution run.
    pub case: Option<Case>,
    /// From coarse to fine.
    pub variants: Vec<Variant>,
    /// Its measures, a value a variant.
    pub measures: Vec<Measured>,
}

/// A run.
pub struct Variant {
    /// Particles along the study's length.
    pub resolution: u32,
    /// Folder of its outputs, below that of the validation.
    pub folder: PathBuf,
    /// Wall time (s) that the solvers computed.
    pub seconds: f64,
    /// Its probes.
    pub probes: Columns,
    /// Its probes over intervals.
    pub intervals: Columns,
    /// Why it did not complete, if it did not.
    pub failure: Option<String>,
}

impl Variant {
    /// The table that has a column of its probes, over intervals or not.
    pub fn table_of(&self, column: &str) -> Option<&Columns> {
        [&self.probes, &self.intervals].into_iter().find(|table| table.get(column).is_some())
    }
}

/// A measure over the variants of a series.
pub struct Measured {
    /// The measure.
    pub measure: Measure,
    /// A value a variant; nothing where the run failed.
    pub values: Vec<Value>,
    /// Observed order, from three resolutions on.
    pub convergence: Option<Convergence>,
}

/// A measure of one run.
#[derive(Clone, Copy, Debug)]
pub struct Value {
    /// Particles along the study's length.
    pub resolution: u32,
    /// The number, not finite where there is none.
    pub found: f64,
    /// Over the reference, or absolute where that is zero.
    pub error: f64,
    /// The paper's value at this resolution.
    pub paper: Option<f64>,
    /// Error allowed.
    pub tolerance: Option<f64>,
}

impl Value {
    /// Whether it is within its tolerance; nothing without one.
    pub fn passes(&self) -> Option<bool> {
        self.tolerance.map(|tolerance| self.error.abs() <= tolerance)
    }
}

/// Why a validation could not be done at all.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A case with the overrides of a series has mistakes.
    #[error("series `{series}`: {errors}")]
    Case {
        /// The series.
        series: String,
        /// All mistakes.
        errors: interfaces::case::CaseErrors,
    },
    /// Outputs cannot be written or read back.
    #[error(transparent)]
    Output(#[from] output::Error),
    /// A measure does not fit the run.
    #[error("{case}, series `{series}`: {source}")]
    Measure {
        /// Folder of the case.
        case: String,
        /// The series.
        series: String,
        /// What does not fit.
        source: Box<measure::MeasureError>,
    },
    /// A folder of outputs cannot be made.
    #[error("failed to make {}: {source}", .path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The command was told to stop.
    #[error("interrupted")]
    Interrupted,
}

/// Runs all studies, and tells of each variant in `tell` as it starts and ends. A variant that fails is a
/// failed measure, no error.
///
/// # Errors
/// Cases with mistakes, measures that do not fit, outputs that cannot be written, interruption.
pub fn run(
    studies: Vec<(PathBuf, Study)>,
    options: &Options,
    make: &Make<'_>,
    tell: &dyn Fn(&str),
) -> Result<Vec<CaseResult>, Error> {
    let resolutions = |s: &Series| if options.coarse { s.coarse.clone() } else { s.resolutions.clone() };
    let total: usize = studies.iter().flat_map(|(_, s)| &s.series).map(|s| resolutions(s).len()).sum();
    let mut count = 0;
    let mut results = Vec::new();
    for (folder, study) in studies {
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut result = CaseResult { name, title: String::new(), study, series: Vec::new() };
        for series in result.study.series.clone() {
            let mut of = SeriesResult { case: None, variants: Vec::new(), measures: Vec::new(), series };
            let mut windows = Vec::new();
            for resolution in resolutions(&of.series) {
                count += 1;
                let called = format!("{}-{resolution}", of.series.name);
                tell(&format!("[{count}/{total}] {} {called}", result.name));
                let case = case_of(&folder, &result.study, &of.series, resolution, &options.sections)?;
                let below = Path::new(&result.name).join(called);
                let (variant, its_windows) = run_variant(&case, resolution, below, options, make)?;
                tell(&match &variant.failure {
                    None => format!("        {:.1} s", variant.seconds),
                    Some(failure) => format!("        failed: {failure}"),
                });
                result.title.clone_from(&case.general.title);
                of.case = Some(case);
                of.variants.push(variant);
                windows.push(its_windows);
            }
            if of.variants.is_empty() {
                continue;
            }
            for measure in result.study.measures.iter().filter(|m| m.is_of(&of.series)) {
                let measured = measured(measure, &result.study, &of, &windows);
                of.measures.push(measured.map_err(|source| Error::Measure {
                    case: result.name.clone(),
                    series: of.series.name.clone(),
                    source: Box::new(source),
                })?);
            }
            result.series.push(of);
        }
        if !result.series.is_empty() {
            results.push(result);
        }
    }
    Ok(results)
}

/// Whether a measure that is judged misses its tolerance, or its run failed.
pub fn fails(results: &[CaseResult]) -> bool {
    let judged = results.iter().flat_map(|r| &r.series).filter(|s| s.series.judged);
    judged
        .flat_map(|s| &s.measures)
        .flat_map(|m| &m.values)
        .any(|v| !v.found.is_finite() || v.passes() == Some(false))
}

fn case_of(
    folder: &Path,
    study: &Study,
    series: &Series,
    resolution: u32,
    sections: &[Sections],
) -> Result<Case, Error> {
    let spacing = study.length / f64::from(resolution);
    let mut overrides = series.set.clone();
    overrides.push(format!("case.particle_spacing={spacing:?}"));
    if let Some(length) = study.structure_length {
        overrides.push(format!("structure.particle_spacing={:?}", length / f64::from(resolution)));
    }
    Case::load(folder, &overrides, sections)
        .map_err(|errors| Error::Case { series: series.name.clone(), errors })
}

/// Runs one variant into `below` the folder of the validation; gives it with its `windows.csv`.
fn run_variant(
    case: &Case,
    resolution: u32,
    below: PathBuf,
    options: &Options,
    make: &Make<'_>,
) -> Result<(Variant, Columns), Error> {
    let out = options.out.join(&below);
    std::fs::create_dir_all(&out).map_err(|source| Error::Folder { path: out.clone(), source })?;
    let build = |role| make(case, role, &out);
    // Participants are called in this process: no executable is started.
    let solvers = Solvers { in_process: &build, executable: Path::new("") };
    let run_options = coupler::run::Options {
        out: out.clone(),
        in_process: true,
        trace: false,
        quiet: options.quiet,
        domain: None,
        stop: Arc::clone(&options.stop),
        checkpoints: None,
        from: None,
        record: None,
    };
    let (summary, result) = coupler::run::run(case, &run_options, &solvers);
    if summary.status == Status::Interrupted {
        return Err(Error::Interrupted);
    }
    let failure = result.err().map(|error| error.to_string());
    let read = |name: &str| {
        let path = out.join(name);
        if path.exists() { table::read(&path) } else { Ok(Columns::default()) }
    };
    let (probes, windows) = (read(coupler::records::PROBES)?, read(coupler::records::WINDOWS)?);
    let intervals = read(coupler::records::INTERVALS)?;
    if out.join(CASE).exists() {
        output::write_report(&out, &output::report::Shown::default())?;
    }
    let seconds = summary.roles.values().map(|role| role.compute_seconds).sum();
    Ok((Variant { resolution, folder: below, seconds, probes, intervals, failure }, windows))
}

fn measured(
    measure: &Measure,
    study: &Study,
    series: &SeriesResult,
    windows: &[Columns],
) -> Result<Measured, measure::MeasureError> {
    let references = series.case.as_ref().map_or(&[][..], |case| &case.references);
    let mut values = Vec::new();
    for (variant, windows) in series.variants.iter().zip(windows) {
        let tables = Tables { probes: &variant.probes, intervals: &variant.intervals, windows };
        let found = match variant.failure {
            Some(_) => f64::NAN,
            None => measure::take(measure, tables, references)?,
        };
        let scale = if measure.reference == 0.0 { 1.0 } else { measure.reference };
        values.push(Value {
            resolution: variant.resolution,
            found,
            error: (found - measure.reference) / scale,
            paper: measure.paper_at(variant.resolution),
            tolerance: measure.tolerance_at(variant.resolution),
        });
    }
    let refined: Vec<(f64, f64)> =
        values.iter().map(|v| (study.length / f64::from(v.resolution), v.found)).collect();
    let convergence = if measure.reference == 0.0 { None } else { convergence(&refined) };
    Ok(Measured { measure: measure.clone(), values, convergence })
}
