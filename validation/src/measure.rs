//! Numbers made of a column over time.

use crate::course::{extreme, first_over, line, mean, period, ringing, swings, value_at, vertex};
use crate::study::{Kind, Measure};
use interfaces::case::probe::Reference;
use output::sums::{Energies, EnergySum};
use output::table::Columns;

/// Why a measure could not be taken of a run.
#[derive(Debug, thiserror::Error)]
pub enum MeasureError {
    /// The column is not there.
    #[error("the measure `{measure}` is of `{column}`, which the run has not written; it has {there}")]
    Column {
        /// The measure.
        measure: String,
        /// The column.
        column: String,
        /// The columns that are there.
        there: String,
    },
    /// The reference is not there.
    #[error(
        "the measure `{measure}` is against the reference `{label}` of `{column}`, which the case has not"
    )]
    Reference {
        /// The measure.
        measure: String,
        /// The label.
        label: String,
        /// The column.
        column: String,
    },
    /// The rows do not give the number.
    #[error("the measure `{measure}` cannot be made of the run: {what}")]
    Rows {
        /// The measure.
        measure: String,
        /// What is missing.
        what: String,
    },
}

/// The tables of a run.
#[derive(Clone, Copy, Debug)]
pub struct Tables<'a> {
    /// `probes.csv`.
    pub probes: &'a Columns,
    /// `probes_intervals.csv`.
    pub intervals: &'a Columns,
    /// `windows.csv`.
    pub windows: &'a Columns,
}

impl<'a> Tables<'a> {
    /// Times and values of a column, of the first table that has it.
    fn course(self, column: &str) -> Option<(&'a [f64], &'a [f64])> {
        [(self.windows, "time"), (self.probes, "t"), (self.intervals, "t")]
            .into_iter()
            .find_map(|(table, time)| Some((table.get(time)?, table.get(column)?)))
    }
}

/// Takes the measure of a run's tables, against the case's references.
///
/// # Errors
/// A column or reference that is not there, or too little of a course in it.
pub fn take(measure: &Measure, tables: Tables<'_>, references: &[Reference]) -> Result<f64, MeasureError> {
    let missing = |column: &str, there: &[&Columns]| MeasureError::Column {
        measure: measure.name.clone(),
        column: column.to_owned(),
        there: there.iter().flat_map(|table| table.names.clone()).collect::<Vec<_>>().join(", "),
    };
    let rows = |what: &str| MeasureError::Rows { measure: measure.name.clone(), what: what.to_owned() };
    if measure.kind.is_of_energy() {
        let of = if measure.kind == Kind::EnergyDrift { energy_drift } else { energy_rise };
        let number =
            of(tables.windows).ok_or_else(|| missing("structure.kinetic_energy", &[tables.windows]))?;
        return Ok(measure.scale * number);
    }
    let (times, values) = tables
        .course(&measure.column)
        .ok_or_else(|| missing(&measure.column, &[tables.probes, tables.intervals]))?;
    if measure.kind.is_against() {
        let is_meant = |r: &&Reference| r.probe == measure.column && r.label == measure.against;
        let reference = references.iter().find(is_meant).ok_or_else(|| MeasureError::Reference {
            measure: measure.name.clone(),
            label: measure.against.clone(),
            column: measure.column.clone(),
        })?;
        let pairs = passages(measure, times, values, reference);
        let [mean, mean_reference, slope] =
            line(&pairs).ok_or_else(|| rows("it passes fewer than three of the reference's values"))?;
        let number = if measure.kind == Kind::Lead { mean_reference - mean } else { slope };
        return Ok(measure.scale * number);
    }
    if measure.kind == Kind::ValueAt {
        let value =
            value_at(times, values, measure.from).ok_or_else(|| rows("its time is not in the run"))?;
        return Ok(measure.scale * value);
    }
    let first = times.partition_point(|&t| t < measure.from);
    let end = times.partition_point(|&t| t <= measure.until);
    if end < first + 3 {
        return Err(rows("fewer than three rows between `from` and `until`"));
    }
    let (times, values) = (&times[first..end], &values[first..end]);
    let number = match measure.kind {
        Kind::Max => extreme(times, values, 1.0),
        Kind::Min => extreme(times, values, -1.0),
        Kind::TimeOfMax => vertex(times, values, 1.0).0,
        Kind::TimeOfMin => vertex(times, values, -1.0).0,
        Kind::FirstOver => {
            first_over(times, values, measure.level).ok_or_else(|| rows("it never is over its level"))?
        }
        Kind::MeanOver => mean(times, values),
        Kind::Last => values[values.len() - 1],
        Kind::Amplitude => 0.5 * (extreme(times, values, 1.0) - extreme(times, values, -1.0)),
        Kind::Period | Kind::Frequency => {
            let period =
                period(times, values).ok_or_else(|| rows("it passes its middle in one direction once"))?;
            if measure.kind == Kind::Period { period } else { 1.0 / period }
        }
        Kind::RingingMean | Kind::RingingFrequency => {
            let [mean, frequency] =
                ringing(times, values).ok_or_else(|| rows("it passes its middle in one direction once"))?;
            if measure.kind == Kind::RingingMean { mean } else { frequency }
        }
        Kind::MaxAbs => values.iter().fold(0.0f64, |largest, v| largest.max(v.abs())),
        Kind::DecayRate => {
            let logarithms: Vec<(f64, f64)> = times.iter().zip(values).map(|(&t, v)| (t, v.ln())).collect();
            let [.., slope] = line(&logarithms).ok_or_else(|| rows("it is not over zero throughout"))?;
            -slope
        }
        Kind::SwingDecay => {
            let [.., slope] =
                line(&swings(times, values)).ok_or_else(|| rows("it swings less than twice"))?;
            -slope
        }
        Kind::ValueAt | Kind::EnergyDrift | Kind::EnergyRise | Kind::SpeedRatio | Kind::Lead => {
            unreachable!("taken above")
        }
    };
    Ok(measure.scale * number)
}

/// Times at which a course first passes the reference's values from below or above, with the reference's
/// times: `(own, reference's)`.
fn passages(measure: &Measure, times: &[f64], values: &[f64], reference: &Reference) -> Vec<(f64, f64)> {
    let wanted = |t: f64| t >= measure.from && t <= measure.until;
    let first = |value: f64| {
        let passes =
            |i: &usize| (values[i - 1] - value) * (values[*i] - value) <= 0.0 && values[i - 1] != values[*i];
        let i = (1..values.len()).find(passes)?;
        let part = (value - values[i - 1]) / (values[i] - values[i - 1]);
        Some(times[i - 1] + part * (times[i] - times[i - 1]))
    };
    let course = reference.time.iter().zip(&reference.value).filter(|(t, _)| wanted(**t));
    course.filter_map(|(&t, &value)| Some((first(value)?, t))).collect()
}

/// Largest rise of the fluid's energy, less what structure and walls gave, over the least before; over the
/// energy that its motion has.
fn energy_rise(windows: &Columns) -> Option<f64> {
    let of_fluid = energies(windows, |name| name.strip_prefix("fluid."))?;
    let works: Vec<&[f64]> = ["structure_work", "wall_work"]
        .iter()
        .filter_map(|work| windows.get(&format!("fluid.{work}")))
        .collect();
    let own = |row: usize| of_fluid[row].total() - works.iter().map(|work| work[row]).sum::<f64>();
    let (_, rise) = (0..of_fluid.len()).fold((f64::INFINITY, 0.0f64), |(least, rise), row| {
        let least = least.min(own(row));
        (least, rise.max(own(row) - least))
    });
    Some(rise / moved(&of_fluid))
}

/// Largest departure of the energy of the whole from that of the first window, over the energy that the
/// motion has.
fn energy_drift(windows: &Columns) -> Option<f64> {
    let whole = energies(windows, |name| name.rsplit('.').next())?;
    let first = whole.first()?.total();
    let departure = whole.iter().fold(0.0f64, |largest, e| largest.max((e.total() - first).abs()));
    Some(departure / moved(&whole))
}

/// The energies of each row, of the columns that `name_of` gives the name of a balance; nothing if none of
/// them is an energy.
fn energies(windows: &Columns, name_of: impl Fn(&str) -> Option<&str>) -> Option<Vec<Energies>> {
    let mut rows = vec![Energies::default(); windows.rows()];
    let mut found = false;
    for (name, values) in windows.iter() {
        let Some(name) = name_of(name) else { continue };
        for (row, value) in rows.iter_mut().zip(values) {
            found |= row.add(name, *value);
        }
    }
    found.then_some(rows)
}

/// The energy that the motion has in these rows, of which there is one at least (J).
fn moved(rows: &[Energies]) -> f64 {
    let mut sum = EnergySum::new(rows[0]);
    rows.iter().for_each(|energies| sum.add(*energies));
    sum.moved()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// 2 + 3 sin(2π t / 0.8) at 40 rows a period, over 2.4 periods.
    fn swing() -> Columns {
        let times: Vec<f64> = (0..=96).map(|i| 0.02 * f64::from(i)).collect();
        let values = times.iter().map(|t| 2.0 + 3.0 * (TAU * t / 0.8 + 0.1).sin()).collect();
        Columns {
            names: vec!["t".into(), "tip.uy".into()],
            columns: vec![times, values],
            ..Columns::default()
        }
    }

    /// The measure of these probes.
    fn of_probes(measure: &Measure, probes: &Columns) -> Result<f64, MeasureError> {
        let nothing = Columns::default();
        take(measure, Tables { probes, intervals: &nothing, windows: &nothing }, &[])
    }

    /// The measure of these windows.
    fn of_windows(measure: &Measure, windows: &Columns) -> f64 {
        let nothing = Columns::default();
        take(measure, Tables { probes: &nothing, intervals: &nothing, windows }, &[]).unwrap()
    }

    fn of(kind: Kind) -> Result<f64, MeasureError> {
        let measure = Measure {
            name: "m".into(),
            series: Vec::new(),
            column: "tip.uy".into(),
            against: String::new(),
            kind,
            from: 0.1,
            until: f64::INFINITY,
            level: 0.0,
            scale: 1.0,
            reference: 1.0,
            source: String::new(),
            tolerance: Vec::new(),
            paper: Vec::new(),
        };
        of_probes(&measure, &swing())
    }

    #[test]
    fn a_swing_that_decays_about_its_rest_tells_its_rate() {
        let times: Vec<f64> = (0..=500).map(|i| 0.01 * f64::from(i)).collect();
        let values: Vec<f64> =
            times.iter().map(|t| 0.5 + 0.02 * (-0.3 * t).exp() * (TAU * t / 1.1).cos()).collect();
        let [.., slope] = line(&swings(&times, &values)).unwrap();
        assert!((slope + 0.3).abs() < 1e-3, "{slope}");
        assert!(line(&swings(&times[..80], &values[..80])).is_none());
    }

    /// Three rows of 40 a period, the middle one half a row from a sine's peak at worst: their parabola
    /// misses it by at most 3·(2π/40)⁴/32 ≈ 6e-5.
    #[test]
    fn numbers_of_a_sine_are_its_own() {
        let near = |kind, value: f64, tolerance: f64| {
            let found = of(kind).unwrap();
            assert!((found - value).abs() < tolerance, "{kind:?}: {found} for {value}");
        };
        near(Kind::Max, 5.0, 6e-5);
        near(Kind::Min, -1.0, 6e-5);
        near(Kind::Amplitude, 3.0, 6e-5);
        near(Kind::Period, 0.8, 2e-5);
        near(Kind::Frequency, 1.25, 4e-5);
        // Cubic remainder of the parabola: 3·(2π/40)³·0.064 at worst.
        near(Kind::ValueAt, 2.0 + 3.0 * (TAU * 0.125 + 0.1).sin(), 1e-3);
    }

    #[test]
    fn a_ringing_of_no_whole_periods_tells_mean_and_frequency() {
        let of = |kind| of(kind).unwrap();
        assert!((of(Kind::RingingMean) - 2.0).abs() < 1e-6);
        assert!((of(Kind::RingingFrequency) - 1.25).abs() < 1e-6);
    }

    fn by_hand(text: &str) -> Measure {
        let head = "name = 'm'\nreference = 1.0\nsource = ''\n";
        toml::from_str(&format!("{head}{text}")).unwrap()
    }

    fn columns(names: &[&str], columns: Vec<Vec<f64>>) -> Columns {
        Columns { names: names.iter().map(|n| (*n).to_owned()).collect(), columns, ..Columns::default() }
    }

    #[test]
    fn a_decay_is_found_in_the_windows() {
        let times: Vec<f64> = (0..20).map(|i| 0.1 * f64::from(i)).collect();
        let values = times.iter().map(|t| 3.0 * (-1.7 * t).exp()).collect();
        let windows = columns(&["time", "fluid.kinetic_energy"], vec![times, values]);
        let measure = by_hand("column = 'fluid.kinetic_energy'\nkind = 'decay-rate'");
        let rate = of_windows(&measure, &windows);
        assert!((rate - 1.7).abs() < 1e-12, "{rate}");
    }

    /// A front 1.25 times as fast as the reference's, both straight, through the reference's origin 0.1 s
    /// before it.
    #[test]
    fn a_front_is_held_against_another_in_speed_and_time() {
        let times: Vec<f64> = (0..50).map(|i| 0.05 * f64::from(i)).collect();
        let values = times.iter().map(|t| 2.5 * t).collect();
        let probes = columns(&["t", "front.right"], vec![times, values]);
        let time = vec![0.1, 0.6, 1.1, 1.6];
        let reference = Reference {
            probe: "front.right".into(),
            label: "experiment".into(),
            source: String::new(),
            value: time.iter().map(|t| 2.0 * (t - 0.1)).collect(),
            low: Vec::new(),
            high: Vec::new(),
            time,
        };
        let of = |kind: &str| {
            let measure =
                by_hand(&format!("column = 'front.right'\nagainst = 'experiment'\nkind = '{kind}'"));
            let nothing = Columns::default();
            let tables = Tables { probes: &probes, intervals: &nothing, windows: &nothing };
            take(&measure, tables, std::slice::from_ref(&reference)).unwrap()
        };
        assert!((of("speed-ratio") - 1.25).abs() < 1e-12);
        // Own times 0, 0.4, 0.8, 1.2 against 0.1 to 1.6.
        assert!((of("lead") - 0.25).abs() < 1e-12);
    }

    #[test]
    fn a_rise_counts_from_the_least_before_it_without_the_work_of_walls() {
        let names = ["fluid.kinetic_energy", "fluid.potential_energy", "fluid.wall_work"];
        let energies = vec![vec![0.0, 1.0, 2.0, 3.0], vec![10.0, 8.0, 7.5, 7.5], vec![0.0, 0.0, 0.0, 0.75]];
        let rise = of_windows(&by_hand("kind = 'energy-rise'"), &columns(&names, energies));
        // 10, 9, 9.5 and 9.75 when the wall's work is taken out, beside a kinetic energy of 3.
        assert!((rise - 0.25).abs() < 1e-15);
    }

    /// A parabola over three rows, 1 − (t − 0.25)²/4, and a line of means over intervals.
    #[test]
    fn times_of_extremes_and_passages_are_found_in_every_table() {
        let times: Vec<f64> = vec![-2.0, -1.0, 0.0, 1.0, 2.0];
        let values: Vec<f64> = times.iter().map(|t| 1.0 - (t - 0.25f64).powi(2) / 4.0).collect();
        let probes = columns(&["t", "tip.ux"], vec![times, values]);
        let intervals = columns(&["t", "wall.fx_mean"], vec![vec![1.0, 2.0, 3.0], vec![0.0, 3.0, 1.0]]);
        let of = |text: &str| {
            let nothing = Columns::default();
            let tables = Tables { probes: &probes, intervals: &intervals, windows: &nothing };
            take(&by_hand(&format!("from = -5.0\n{text}")), tables, &[])
        };
        let number = |text: &str| of(text).unwrap();
        assert!((number("column = 'tip.ux'\nkind = 'time-of-max'") - 0.25).abs() < 1e-12);
        assert!((number("column = 'tip.ux'\nkind = 'max'") - 1.0).abs() < 1e-12);
        assert_eq!(number("column = 'tip.ux'\nkind = 'time-of-min'"), -2.0);
        assert!((number("column = 'wall.fx_mean'\nkind = 'first-over'\nlevel = 1.5") - 1.5).abs() < 1e-12);
        assert!(of("column = 'wall.fx_mean'\nkind = 'first-over'\nlevel = 5.0").is_err());
        // Upside down, as the least value is found.
        assert_eq!(vertex(&[0.0, 1.0, 2.0], &[1.0, -1.0, 1.0], -1.0), (1.0, -1.0));
    }

    #[test]
    fn what_is_not_there_is_named() {
        let mut table = swing();
        table.names[1] = "tip.ux".into();
        let measure: Measure =
            toml::from_str("name = 'm'\ncolumn = 'tip.uy'\nkind = 'max'\nreference = 1.0\nsource = ''")
                .unwrap();
        let message = of_probes(&measure, &table).unwrap_err().to_string();
        assert!(message.contains("`tip.uy`") && message.contains("tip.ux"), "{message}");
    }
}
