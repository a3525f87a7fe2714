//! `validation.toml` of a case folder: which variants are run, and what they are held against.

use serde::Deserialize;
use std::path::{Path, PathBuf};

/// File of a study, in a case folder.
pub const FILE: &str = "validation.toml";

/// What the file of a case says.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// The suite that the case belongs to: `structure`, `fluid`, `fsi`.
    pub suite: String,
    /// Length (m) that a resolution divides: `Δx = length / resolution`.
    pub length: f64,
    /// Length (m) that a resolution divides for the structure where its spacing is one of its own:
    /// `structure.particle_spacing = structure_length / resolution`.
    #[serde(default)]
    pub structure_length: Option<f64>,
    /// The case with overrides, at several resolutions each.
    pub series: Vec<Series>,
    /// What is measured of each run.
    #[serde(rename = "measure")]
    pub measures: Vec<Measure>,
    /// Figures in which several series stand beside each other.
    #[serde(default, rename = "figure")]
    pub figures: Vec<Figure>,
}

/// A column of several series in one figure, each at its finest resolution.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// Heading.
    pub title: String,
    /// Column of `probes.csv` or `probes_intervals.csv`.
    pub column: String,
    /// Names of the series, in the order of the legend.
    pub series: Vec<String>,
}

/// One variant of the case at several resolutions.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Series {
    /// Letters, digits, `-`: names folders.
    pub name: String,
    /// Overrides as in `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Particles along the study's length, coarsest first.
    pub resolutions: Vec<u32>,
    /// The resolutions of a coarse run; none leaves the series out.
    #[serde(default)]
    pub coarse: Vec<u32>,
    /// Whether a measure out of its tolerance fails the command.
    #[serde(default = "yes")]
    pub judged: bool,
    /// Labels of the case's references that are drawn with the series.
    #[serde(default)]
    pub references: Vec<String>,
}

/// A number made of a run, and what it is held against.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// For tables.
    pub name: String,
    /// Names of the series that it is taken of; all without any.
    #[serde(default)]
    pub series: Vec<String>,
    /// Column of `probes.csv`, `probes_intervals.csv` or `windows.csv`; none for the energy's drift and rise.
    #[serde(default)]
    pub column: String,
    /// How the number is made of the column.
    pub kind: Kind,
    /// Label of the case's reference that the column is compared with, for `speed-ratio` and `lead`.
    #[serde(default)]
    pub against: String,
    /// Start of the part of the run that is looked at, and the time of `value-at` (s).
    #[serde(default)]
    pub from: f64,
    /// End of the part of the run that is looked at (s).
    #[serde(default = "forever")]
    pub until: f64,
    /// The value that `first-over` waits for, in the column's unit.
    #[serde(default)]
    pub level: f64,
    /// Factor of the number, as where a paper gives it without unit.
    #[serde(default = "one")]
    pub scale: f64,
    /// The true value.
    pub reference: f64,
    /// Where the true value is from.
    pub source: String,
    /// Pairs of a resolution and the error allowed from it on, as a fraction (absolute where the reference is
    /// zero); none is only shown.
    #[serde(default)]
    pub tolerance: Vec<(u32, f64)>,
    /// Pairs of a resolution and the paper's value at it; resolution 0 stands for every one.
    #[serde(default)]
    pub paper: Vec<(u32, f64)>,
}

/// How a number is made of a column over time.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Its largest value, of the parabola through the three rows about it.
    Max,
    /// Its least value, likewise.
    Min,
    /// When it has its largest value (s), likewise.
    TimeOfMax,
    /// When it has its least value (s), likewise.
    TimeOfMin,
    /// When it first is over `level` (s), linear between rows.
    FirstOver,
    /// Its mean over time.
    MeanOver,
    /// Its last value.
    Last,
    /// Its value at the time `from`, of the parabola through the rows about it.
    ValueAt,
    /// Mean time between its passages through the middle of its range, those in the same direction (s).
    Period,
    /// One over the period (Hz).
    Frequency,
    /// Half its range.
    Amplitude,
    /// Mean of the sinusoid about a mean that fits it best, by least squares: of a ringing that lasts a few
    /// periods, not whole ones.
    RingingMean,
    /// Frequency (Hz) of that sinusoid.
    RingingFrequency,
    /// Largest departure of the mechanical energy from that of the first window, over the energy that the
    /// motion has (the greatest kinetic energy, or what gravity's or strain's went through); of
    /// `windows.csv`.
    EnergyDrift,
    /// Largest rise of the mechanical energy over the least that it had before, works of structure and walls
    /// taken out, over the energy that the motion has; of `windows.csv`.
    EnergyRise,
    /// Its largest magnitude.
    MaxAbs,
    /// Rate of its decay (1/s), the slope of its logarithm with the sign turned, by least squares.
    DecayRate,
    /// Rate (1/s) at which what swings about its rest decays: the slope of the logarithm of its swings, each
    /// from one extreme to the next, with the sign turned, by least squares.
    SwingDecay,
    /// How many times as fast as the reference `against` it passes the reference's values: the slope of the
    /// reference's times over its own, by least squares, of the values between `from` and `until` of the
    /// reference's time.
    SpeedRatio,
    /// How long it passes the same values before the reference (s), in the mean.
    Lead,
}

impl Kind {
    /// Whether it is made of the energies, and of no one column.
    pub fn is_of_energy(self) -> bool {
        matches!(self, Self::EnergyDrift | Self::EnergyRise)
    }

    /// Whether it compares a column with a reference over time.
    pub fn is_against(self) -> bool {
        matches!(self, Self::SpeedRatio | Self::Lead)
    }
}

fn yes() -> bool {
    true
}

fn one() -> f64 {
    1.0
}

fn forever() -> f64 {
    f64::INFINITY
}

/// Why a study cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A folder or file cannot be read.
    #[error("failed to read {}: {source}", .path.display())]
    Read {
        /// The folder or file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file is not as [`Study`] says.
    #[error("{}: {what}", .path.display())]
    Wrong {
        /// The file.
        path: PathBuf,
        /// What is wrong, and what would be right.
        what: String,
    },
    /// No case is of the suite.
    #[error("{} holds no case with a {FILE} of the suite `{suite}`{}; name the folder of the cases with --cases", .folder.display(), .of.as_ref().map_or(String::new(), |n| format!(" and the name `{n}`")))]
    None {
        /// Where cases were looked for.
        folder: PathBuf,
        /// The suite.
        suite: String,
        /// The only case that was asked for.
        of: Option<String>,
    },
}

impl Study {
    /// Reads the study of a case folder.
    ///
    /// # Errors
    /// A file that cannot be read, keys that are none, names of series that are not there.
    pub fn read(folder: &Path) -> Result<Self, StudyError> {
        let path = folder.join(FILE);
        let text = std::fs::read_to_string(&path)
            .map_err(|source| StudyError::Read { path: path.clone(), source })?;
        Self::parse(&text).map_err(|what| StudyError::Wrong { path, what })
    }

    fn parse(text: &str) -> Result<Self, String> {
        let study: Self = toml::from_str(text).map_err(|e| e.to_string())?;
        for measure in &study.measures {
            for name in &measure.series {
                if !study.series.iter().any(|s| s.name == *name) {
                    return Err(format!("measure `{}`: there is no series `{name}`", measure.name));
                }
            }
            if measure.against.is_empty() && measure.kind.is_against() {
                return Err(format!(
                    "measure `{}` names no reference; write against = \"<label>\"",
                    measure.name
                ));
            }
            if measure.column.is_empty() && !measure.kind.is_of_energy() {
                return Err(format!(
                    "measure `{}` names no column; write column = \"<probe>.<component>\"",
                    measure.name
                ));
            }
        }
        for figure in &study.figures {
            if let Some(name) =
                figure.series.iter().find(|name| !study.series.iter().any(|s| s.name == **name))
            {
                return Err(format!("figure `{}`: there is no series `{name}`", figure.title));
            }
        }
        let resolutions = || study.series.iter().flat_map(|s| s.resolutions.iter().chain(&s.coarse));
        if study.length <= 0.0
            || study.structure_length.is_some_and(|l| l <= 0.0)
            || resolutions().any(|&n| n == 0)
        {
            return Err("length and resolutions must be over zero".to_owned());
        }
        Ok(study)
    }
}

impl Measure {
    /// Whether it is taken of the series.
    pub fn is_of(&self, series: &Series) -> bool {
        self.series.is_empty() || self.series.contains(&series.name)
    }

    /// The error allowed at a resolution.
    pub fn tolerance_at(&self, resolution: u32) -> Option<f64> {
        let from = self.tolerance.iter().filter(|(n, _)| *n <= resolution);
        from.max_by_key(|(n, _)| *n).map(|(_, tolerance)| *tolerance)
    }

    /// The paper's value at a resolution.
    pub fn paper_at(&self, resolution: u32) -> Option<f64> {
        self.paper.iter().find(|(n, _)| *n == resolution || *n == 0).map(|(_, value)| *value)
    }
}

/// The case folders below `folder` that have a study of the suite, with it, in the order of their names; only
/// the one called `only`, if any is.
///
/// # Errors
/// A study that cannot be read, or that there is none.
pub fn find(folder: &Path, suite: &str, only: Option<&str>) -> Result<Vec<(PathBuf, Study)>, StudyError> {
    let unreadable = |source| StudyError::Read { path: folder.to_owned(), source };
    let mut folders = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let wanted = only.is_none_or(|name| path.file_name().is_some_and(|n| n == name));
        if wanted && path.join(FILE).exists() {
            folders.push(path);
        }
    }
    folders.sort();
    let mut found = Vec::new();
    for path in folders {
        let study = Study::read(&path)?;
        if study.suite == suite {
            found.push((path, study));
        }
    }
    if found.is_empty() {
        let (suite, of) = (suite.to_owned(), only.map(str::to_owned));
        return Err(StudyError::None { folder: folder.to_owned(), suite, of });
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"
        suite = "structure"
        length = 0.02
        [[series]]
        name = "default"
        resolutions = [4, 10]
        [[measure]]
        name = "period"
        column = "tip.uy"
        kind = "period"
        reference = 1.0
        source = "by hand"
        tolerance = [[4, 0.015], [10, 0.01]]
        paper = [[10, 1.1]]
    "#;

    #[test]
    fn tolerances_hold_from_their_resolution_on() {
        let study = Study::parse(TEXT).unwrap();
        let measure = &study.measures[0];
        assert!(study.series[0].judged && measure.is_of(&study.series[0]));
        let at = |n| measure.tolerance_at(n);
        assert_eq!((at(3), at(6), at(20)), (None, Some(0.015), Some(0.01)));
        assert_eq!((measure.paper_at(4), measure.paper_at(10)), (None, Some(1.1)));
    }

    #[test]
    fn mistakes_are_told() {
        let wrong = |from: &str, to: &str| Study::parse(&TEXT.replace(from, to)).unwrap_err();
        assert!(wrong("reference", "referense").contains("referense"));
        assert!(wrong("column = \"tip.uy\"", "").contains("names no column"));
        assert!(wrong("kind", "series = [\"quick\"]\nkind").contains("no series `quick`"));
        assert!(wrong("[4, 10]", "[0, 10]").contains("over zero"));
        assert!(wrong("length = 0.02", "length = 0.02\nstructure_length = 0.0").contains("over zero"));
        let figure = "paper = [[10, 1.1]]\n[[figure]]\ntitle = 'both'\ncolumn = 'tip.uy'\nseries = ['soft']";
        assert!(wrong("paper = [[10, 1.1]]", figure).contains("figure `both`: there is no series `soft`"));
    }
}
