//! Probes over intervals of time, and low-passed: what a gauge with a slow needle, or a smoothed record,
//! would show.
//!
//! The value of an accepted window holds over the window, as the load does: a mean over intervals is the
//! impulse over the interval, windows that reach over its ends cut in proportion. A pressure that is not
//! there, where it is dry, counts as none (0 Pa, the open air's); whatever else is not there does not count.

use interfaces::case::probe::{LOW_PASSED, OVER_INTERVAL, Probe};
use output::columns::Column;
use std::f64::consts::{PI, SQRT_2};
use words::bytes::{self, Reader, Writer};

/// An interval is over up to this part of it before its end: rounding of the sum of window sizes.
const ON_TIME: f64 = 1e-9;

/// What the case wants of its probes besides their values.
#[derive(Debug)]
pub(super) struct Statistics {
    start: f64,
    /// Time (s) up to which windows have been taken; none have before the start.
    time: Option<f64>,
    groups: Vec<Group>,
    filters: Vec<LowPass>,
    /// Rows of the intervals that ended with the last window.
    ended: Vec<Vec<f64>>,
}

/// Columns over intervals of one length.
#[derive(Debug)]
struct Group {
    interval: f64,
    /// Intervals that have ended.
    done: u64,
    /// Time (s) up to which they are summed.
    time: f64,
    /// Place of the first of its cells in a row.
    place: usize,
    sums: Vec<Sum>,
}

/// One column in the interval that goes on.
#[derive(Debug)]
struct Sum {
    column: usize,
    absent: f64,
    integral: f64,
    duration: f64,
    least: f64,
    most: f64,
}

/// A column through a Butterworth low-pass of second order, `y'' + √2 ω y' + ω² y = ω² u` with `ω = 2π f`,
/// exactly for an input `u` that holds over each window. It is causal, and at rest on its first input.
#[derive(Debug)]
struct LowPass {
    column: usize,
    absent: f64,
    /// Cut-off frequency f (Hz).
    frequency: f64,
    /// Value and its rate (1/s), where there is an input.
    state: Option<[f64; 2]>,
}

impl Statistics {
    /// Of those of `probes` that have `columns`, from `start` (s) on.
    pub(super) fn new(start: f64, columns: &[Column], probes: &[Probe], dimension: usize) -> Self {
        let (mut groups, mut filters): (Vec<Group>, Vec<LowPass>) = (Vec::new(), Vec::new());
        for probe in probes {
            for name in probe.columns(dimension) {
                let Some(column) = columns.iter().position(|column| column.name == name) else { continue };
                let absent = if columns[column].content.unit == "Pa" { 0.0 } else { f64::NAN };
                if let Some(interval) = probe.interval {
                    let group = groups.iter().position(|group| group.interval == interval);
                    let group = group.unwrap_or_else(|| {
                        groups.push(Group { interval, done: 0, time: start, place: 0, sums: Vec::new() });
                        groups.len() - 1
                    });
                    groups[group].sums.push(Sum::new(column, absent));
                }
                if let Some(frequency) = probe.low_pass {
                    filters.push(LowPass { column, absent, frequency, state: None });
                }
            }
        }
        let mut place = 1;
        for group in &mut groups {
            group.place = place;
            place += OVER_INTERVAL.len() * group.sums.len();
        }
        Self { start, time: None, groups, filters, ended: Vec::new() }
    }

    /// The columns of low-passed values, of a table with `columns`, behind which they stand.
    pub(super) fn low_passed(&self, columns: &[Column]) -> Vec<Column> {
        let column = |filter: &LowPass| {
            let Column { name, content } = &columns[filter.column];
            let frequency = filter.frequency;
            let meaning = format!(
                "{}, through a causal Butterworth low-pass of second order, {frequency} Hz",
                content.meaning
            );
            Column::new(format!("{name}{LOW_PASSED}"), &content.unit, meaning)
        };
        self.filters.iter().map(column).collect()
    }

    /// The columns of the table of intervals, of probes with `columns`; the time alone where there are none.
    pub(super) fn over_intervals(&self, columns: &[Column]) -> Vec<Column> {
        let mut over = vec![Column::new("t", "s", "time at the interval's end")];
        for group in &self.groups {
            for sum in &group.sums {
                let Column { name, content } = &columns[sum.column];
                over.extend(OVER_INTERVAL.iter().zip(["mean", "least", "largest"]).map(|(end, what)| {
                    let (interval, meaning) = (group.interval, &content.meaning);
                    let meaning = format!("{meaning}: {what} value over {interval} s");
                    Column::new(format!("{name}{end}"), &content.unit, meaning)
                }));
            }
        }
        over
    }

    /// Takes the values of the window that ends at `time` (s), the first time those at the start, and adds
    /// the low-passed ones to them.
    pub(super) fn take(&mut self, time: f64, values: &mut Vec<f64>) {
        self.ended.clear();
        let size = self.time.map_or(0.0, |before| time - before);
        for filter in &mut self.filters {
            let value = present(values[filter.column], filter.absent);
            values.push(filter.pass(size, value));
        }
        let is_start = self.time.is_none();
        self.time = Some(time);
        if is_start {
            return;
        }
        let cells: usize = self.groups.iter().map(|group| OVER_INTERVAL.len() * group.sums.len()).sum();
        for group in &mut self.groups {
            let rounding = ON_TIME * group.interval;
            group.take(self.start, time, values, |end, place, found| {
                // Intervals of two lengths that end together have one row.
                let same = |row: &&mut Vec<f64>| (row[0] - end).abs() <= rounding;
                let row = match self.ended.iter_mut().find(same) {
                    Some(row) => row,
                    None => {
                        let mut row = vec![f64::NAN; 1 + cells];
                        row[0] = end;
                        self.ended.push(row);
                        self.ended.last_mut().expect("it was just pushed")
                    }
                };
                row[place..place + found.len()].copy_from_slice(found);
            });
        }
        self.ended.sort_by(|a, b| a[0].total_cmp(&b[0]));
    }

    /// Rows of the intervals that ended with the last window, in the order of time.
    pub(super) fn ended(&self) -> &[Vec<f64>] {
        &self.ended
    }

    pub(super) fn save(&self, state: &mut Writer) {
        state.f64s(self.time.as_slice());
        state.list(&self.groups, |state, group| {
            state.u64(group.done);
            state.f64(group.time);
            let sums = group.sums.iter().flat_map(|sum| [sum.integral, sum.duration, sum.least, sum.most]);
            state.f64s(&sums.collect::<Vec<_>>());
        });
        state.list(&self.filters, |state, filter| state.f64s(filter.state.as_ref().map_or(&[], |s| s)));
    }

    pub(super) fn restore(&mut self, state: &mut Reader<'_>) -> Result<(), bytes::Error> {
        self.ended.clear();
        self.time = state.f64s("time of probes", None)?.first().copied();
        let mut groups = self.groups.iter_mut();
        state.list("probes over intervals", Some(groups.len()), |state| {
            let group = groups.next().expect("as many were asked for");
            group.done = state.u64("intervals")?;
            group.time = state.f64("time of intervals")?;
            let found = state.f64s("sums over an interval", Some(4 * group.sums.len()))?;
            for (sum, found) in group.sums.iter_mut().zip(found.chunks_exact(4)) {
                (sum.integral, sum.duration, sum.least, sum.most) = (found[0], found[1], found[2], found[3]);
            }
            Ok(())
        })?;
        let mut filters = self.filters.iter_mut();
        state.list("low-passed probes", Some(filters.len()), |state| {
            let found = state.f64s("low-passed value", None)?;
            let filter = filters.next().expect("as many were asked for");
            filter.state = found.try_into().ok();
            Ok(())
        })?;
        Ok(())
    }
}

impl Group {
    /// Takes values that hold up to `time` (s); `ended` is told of each interval that ends by then, with the
    /// place of its cells in a row and what stands in them.
    fn take(&mut self, start: f64, time: f64, values: &[f64], mut ended: impl FnMut(f64, usize, &[f64])) {
        loop {
            let end = start + (self.done + 1) as f64 * self.interval;
            let is_over = time >= end - ON_TIME * self.interval;
            let until = if is_over { end } else { time };
            let duration = until - self.time;
            if duration > 0.0 {
                for sum in &mut self.sums {
                    sum.add(duration, present(values[sum.column], sum.absent));
                }
                self.time = until;
            }
            if !is_over {
                return;
            }
            self.done += 1;
            let found: Vec<f64> = self.sums.iter_mut().flat_map(Sum::end).collect();
            ended(end, self.place, &found);
        }
    }
}

impl Sum {
    fn new(column: usize, absent: f64) -> Self {
        Self { column, absent, integral: 0.0, duration: 0.0, least: f64::NAN, most: f64::NAN }
    }

    fn add(&mut self, duration: f64, value: f64) {
        if value.is_nan() {
            return;
        }
        self.integral += duration * value;
        self.duration += duration;
        // Whichever is a number.
        (self.least, self.most) = (self.least.min(value), self.most.max(value));
    }

    /// Mean, least and largest value, with which a new interval begins.
    fn end(&mut self) -> [f64; OVER_INTERVAL.len()] {
        let ended = std::mem::replace(self, Self::new(self.column, self.absent));
        [ended.integral / ended.duration, ended.least, ended.most]
    }
}

impl LowPass {
    /// The output after `size` (s) of this input.
    fn pass(&mut self, size: f64, input: f64) -> f64 {
        if input.is_nan() {
            self.state = None;
            return f64::NAN;
        }
        let [value, rate] = self.state.get_or_insert([input, 0.0]);
        // With `a = ω/√2` the poles are `−a ± i a`, and what is left of the distance z from the input after a
        // time t is e^(−a t) [z cos a t + (z' + a z)/a sin a t].
        let a = 2.0 * PI * self.frequency / SQRT_2;
        let (sin, cos) = (a * size).sin_cos();
        let (left, distance, before) = ((-a * size).exp(), *value - input, *rate);
        *value = input + left * (distance * cos + (before / a + distance) * sin);
        *rate = left * (before * cos - (before + 2.0 * a * distance) * sin);
        *value
    }
}

fn present(value: f64, absent: f64) -> f64 {
    if value.is_nan() { absent } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use interfaces::case::probe::ProbeSide;
    use words::probe::ProbeQuantity;

    fn probe(name: &str, interval: Option<f64>, low_pass: Option<f64>) -> Probe {
        Probe {
            name: name.to_owned(),
            on: ProbeSide::Wall,
            quantity: ProbeQuantity::Pressure,
            at: None,
            direction: None,
            span: None,
            radius: None,
            interval,
            low_pass,
            bounds: None,
            body: None,
            wall: None,
            relative_to: None,
        }
    }

    /// Pressure `a` and speed `b`.
    fn columns() -> [Column; 2] {
        [Column::new("a.p", "Pa", "pressure"), Column::new("b.p", "m/s", "speed")]
    }

    /// Rows of windows of these sizes with these values of both columns.
    fn rows(statistics: &mut Statistics, windows: &[(f64, [f64; 2])]) -> Vec<Vec<f64>> {
        let mut time = statistics.time.unwrap_or(0.0);
        let mut rows = Vec::new();
        for (size, values) in windows {
            time += size;
            statistics.take(time, &mut values.to_vec());
            rows.extend_from_slice(statistics.ended());
        }
        rows
    }

    /// By hand: 2 for 0.75 s and 6 for 0.75 s make 2·0.75 + 6·0.25 = 3 over the first second. The last window
    /// is longer than an interval. A pressure that is not there is 0, a speed does not count.
    #[test]
    fn windows_are_cut_at_the_ends_of_intervals() {
        let probes = [probe("a", Some(1.0), None), probe("b", Some(1.0), None)];
        let mut statistics = Statistics::new(0.0, &columns(), &probes, 2);
        let names: Vec<String> =
            statistics.over_intervals(&columns()).into_iter().map(|column| column.name).collect();
        assert_eq!(names.join(","), "t,a.p_mean,a.p_min,a.p_max,b.p_mean,b.p_min,b.p_max");
        let windows = [
            (0.0, [9.0, 9.0]),
            (0.75, [2.0, 2.0]),
            (0.75, [6.0, f64::NAN]),
            (0.5, [f64::NAN, f64::NAN]),
            (2.25, [1.0, -4.0]),
        ];
        let none = f64::NAN;
        let expected = [
            [1.0, 3.0, 2.0, 6.0, 2.0, 2.0, 2.0],
            [2.0, 3.0, 0.0, 6.0, none, none, none],
            [3.0, 1.0, 1.0, 1.0, -4.0, -4.0, -4.0],
            [4.0, 1.0, 1.0, 1.0, -4.0, -4.0, -4.0],
        ];
        let found = rows(&mut statistics, &windows);
        assert_eq!(found.len(), 4);
        for (row, expected) in found.iter().zip(expected) {
            let same = |(a, b): (&f64, f64)| *a == b || a.is_nan() && b.is_nan();
            assert!(row.iter().zip(expected).all(same), "{row:?} and not {expected:?}");
        }
    }

    /// A hundred windows of 1e-3 s do not sum up to 0.1 s: the interval ends with the hundredth all the same,
    /// once, and intervals of two lengths that end together share a row.
    #[test]
    fn an_interval_ends_with_the_window_that_is_to_end_it() {
        let probes = [probe("a", Some(0.1), None), probe("b", Some(0.05), None)];
        let mut statistics = Statistics::new(0.0, &columns(), &probes, 2);
        let windows: Vec<_> = (0..=300).map(|i| (if i == 0 { 0.0 } else { 1e-3 }, [5.0, 7.0])).collect();
        let found = rows(&mut statistics, &windows);
        assert_eq!(found.len(), 6, "{found:?}");
        for (i, row) in found.iter().enumerate() {
            assert!((row[0] - 0.05 * (i + 1) as f64).abs() < 1e-12, "{row:?}");
            assert_eq!(row[1].is_nan(), i % 2 == 0, "{row:?}");
            assert!((row[4] - 7.0).abs() < 1e-12 && (row[1].is_nan() || (row[1] - 5.0).abs() < 1e-12));
        }
    }

    /// `1 − e^(−a t) (cos a t + sin a t)`, the step response of a Butterworth low-pass of second order,
    /// whatever the windows; it overshoots by e^(−π), 4.3 %. Tolerance: round-off of 200 windows.
    #[test]
    fn a_step_is_passed_as_theory_has_it_whatever_the_windows() {
        let frequency = 10.0;
        let a = 2.0 * PI * frequency / SQRT_2;
        for sizes in [vec![1e-3; 200], vec![0.2], (1..20).map(|i| 1e-3 * f64::from(i)).collect()] {
            let probes = [probe("a", None, Some(frequency))];
            let mut statistics = Statistics::new(0.0, &columns(), &probes, 2);
            let named = statistics.low_passed(&columns());
            assert_eq!((named[0].name.as_str(), named[0].content.unit.as_str()), ("a.p_butterworth", "Pa"));
            let (mut time, mut values) = (0.0, vec![f64::NAN, 0.0]);
            statistics.take(time, &mut values);
            // A dry wall has no pressure: the blow is not where the filter begins.
            assert_eq!(values[2], 0.0);
            let mut peak = 0.0f64;
            for size in sizes {
                time += size;
                let mut values = vec![1.0, 0.0];
                statistics.take(time, &mut values);
                let exact = 1.0 - (-a * time).exp() * ((a * time).cos() + (a * time).sin());
                assert!((values[2] - exact).abs() < 1e-12, "{} and not {exact} at {time}", values[2]);
                peak = peak.max(values[2]);
            }
            assert!(peak < 1.0 + (-PI).exp() + 1e-12);
        }
    }

    /// A sine at the cut-off comes out at 1/√2 of its amplitude; a window holds its last value, which is half
    /// a window late and sinc(f Δt) smaller: at 200 windows a period 4e-5.
    #[test]
    fn a_sine_at_the_cut_off_has_lost_three_decibels() {
        let mut filter = LowPass { column: 0, absent: 0.0, frequency: 1.0, state: None };
        let (mut most, size) = (0.0f64, 1.0 / 200.0);
        for i in 0..2000 {
            let passed = filter.pass(size, (2.0 * PI * f64::from(i) * size).sin());
            most = if i > 1000 { most.max(passed) } else { 0.0 };
        }
        assert!((most - 1.0 / SQRT_2).abs() < 3e-4, "{most}");
    }

    #[test]
    fn sums_and_filters_go_on_from_a_state() {
        let probes = [probe("a", Some(0.7), Some(3.0)), probe("b", Some(0.3), None)];
        let make = || Statistics::new(0.0, &columns(), &probes, 2);
        let windows: Vec<_> =
            (0..40).map(|i| (0.11 * f64::from(i % 3), [f64::from(i * i % 17), 1.0])).collect();
        let mut whole = make();
        let expected = rows(&mut whole, &windows);
        let mut first = make();
        let mut found = rows(&mut first, &windows[..19]);
        let mut state = Writer::new(b"test0001");
        first.save(&mut state);
        let saved = state.finish();
        let mut second = make();
        let mut reader = Reader::new("state", b"test0001", &saved).unwrap();
        second.restore(&mut reader).unwrap();
        reader.finish().unwrap();
        found.extend(rows(&mut second, &windows[19..]));
        let bits = |rows: &[Vec<f64>]| rows.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&found), bits(&expected));
        assert_eq!(second.filters[0].state, whole.filters[0].state);
    }
}
