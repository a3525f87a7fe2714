//! Time, kept by the coupler alone: `t0 + Σ size` over the accepted windows, and sizes that arrive at output
//! and end times without slivers.

use interfaces::{SubSteps, TimeWindow};
use words::bytes::{self, Reader, Writer};

/// Counts windows, keeps the time, and sets each window's size.
#[derive(Clone, Debug)]
pub struct Schedule {
    start_time: f64,
    time: f64,
    end_time: f64,
    output_interval: f64,
    max_window: f64,
    sub_steps: SubSteps,
    windows: u64,
    outputs: u64,
    /// Output intervals that have passed: as many as outputs, unless the end was one, or the run went on with
    /// another interval.
    intervals: u64,
    /// Longest window that was allowed when the last one was set (s).
    allowed: f64,
}

/// What is left behind the last output before the end is joined to the windows before it where it is shorter
/// than this fraction of the longest window allowed: a sliver of a window has accelerations of its own.
const SLIVER: f64 = 0.5;
/// Shortest interval between outputs, over the longest window allowed, that is taken while a run goes on.
const SHORTEST_INTERVAL: f64 = 0.1;
/// What is left of an output interval counts as none below this fraction of the interval: rounding of the sum
/// of window sizes.
const ARRIVED: f64 = 1e-9;

impl Schedule {
    /// From `start_time` to `end_time` (s), an output every `output_interval` (s), no window longer than
    /// `max_window` (s).
    pub fn new(
        start_time: f64,
        end_time: f64,
        output_interval: f64,
        max_window: f64,
        sub_steps: SubSteps,
    ) -> Self {
        Self {
            start_time,
            time: start_time,
            end_time,
            output_interval,
            max_window,
            sub_steps,
            windows: 0,
            outputs: 0,
            intervals: 0,
            allowed: 0.0,
        }
    }

    /// The next window (iteration 0), or nothing at the end time. `limit` (s) is the least that all
    /// participants allow.
    ///
    /// The way to the next output or end time is divided evenly into as few windows as the limit permits, so
    /// that none is a sliver.
    pub fn next(&mut self, limit: f64) -> Option<TimeWindow> {
        if self.finished() {
            return None;
        }
        let largest = limit.min(self.max_window);
        self.allowed = largest;
        let left = self.target() - self.time;
        let size = if largest >= left { left } else { left / (left / largest - ARRIVED).ceil() };
        Some(TimeWindow {
            index: self.windows,
            iteration: 0,
            start: self.time,
            size,
            sub_steps: self.sub_steps,
        })
    }

    /// The window is final. Gives the number of the output that is due at its end, if one is; the end time
    /// always has one.
    pub fn accept(&mut self, window: &TimeWindow) -> Option<u64> {
        let target = self.target();
        self.windows += 1;
        self.time = window.end();
        if target - self.time > self.nothing() {
            return None;
        }
        self.time = target;
        self.outputs += 1;
        self.intervals += 1;
        Some(self.outputs)
    }

    /// The window is final and the last: as [`Schedule::accept`], with the end time at its end.
    pub fn accept_last(&mut self, window: &TimeWindow) -> Option<u64> {
        self.end_time = self.end_time.min(window.end());
        self.accept(window)
    }

    /// Writes where the time is. End, interval and sizes are the case's, and may be others when the run goes
    /// on.
    pub fn save(&self, state: &mut Writer) {
        state.f64(self.time);
        state.u64(self.windows);
        state.u64(self.outputs);
    }

    /// Goes to what [`save`](Self::save) wrote.
    pub fn restore(&mut self, state: &mut Reader<'_>) -> Result<(), bytes::Error> {
        self.time = state.f64("time")?;
        if self.time.is_nan() || self.time < self.start_time {
            return Err(state
                .refuse("time", format!("{} s, and the case starts at {} s", self.time, self.start_time)));
        }
        self.windows = state.u64("windows")?;
        self.outputs = state.u64("outputs")?;
        // With the interval as it is now, which may be another.
        self.count_intervals();
        Ok(())
    }

    /// Sets another interval between outputs (s), which is counted from the start as ever. Gives the one
    /// before.
    ///
    /// # Errors
    /// One so short that it would make slivers of the windows: the least that is taken (s).
    pub fn set_output_interval(&mut self, interval: f64) -> Result<f64, f64> {
        let least = SHORTEST_INTERVAL * self.allowed;
        if interval < least {
            return Err(least);
        }
        let before = std::mem::replace(&mut self.output_interval, interval);
        self.count_intervals();
        Ok(before)
    }

    /// How many of the intervals, as they are now, have passed.
    fn count_intervals(&mut self) {
        self.intervals = ((self.time - self.start_time) / self.output_interval + 0.5 * ARRIVED) as u64;
    }

    /// Whether the end time is reached.
    pub fn finished(&self) -> bool {
        self.time >= self.end_time
    }

    /// Time now (s).
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Windows accepted.
    pub fn windows(&self) -> u64 {
        self.windows
    }

    /// What counts as no time (s): rounding of the sum of window sizes. An interval longer than the run is no
    /// measure of that.
    fn nothing(&self) -> f64 {
        ARRIVED * self.output_interval.min(self.end_time - self.start_time)
    }

    /// The next output's time, counted and not added up, or the end time. An output of which the end is less
    /// than a sliver away, or none at all but for rounding, is that of the end.
    fn target(&self) -> f64 {
        let output = self.start_time + (self.intervals + 1) as f64 * self.output_interval;
        let nothing = self.nothing();
        let sliver = nothing.max(SLIVER * self.allowed.min(self.output_interval));
        let passed = output - self.time <= nothing;
        if passed || self.end_time - output < sliver { self.end_time } else { output }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs a schedule with a limit that varies, and gives the sizes and the times of outputs.
    fn walk(end: f64, interval: f64, limit: impl Fn(u64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let mut schedule = Schedule::new(0.0, end, interval, 0.05, SubSteps::Stable);
        let (mut sizes, mut outputs) = (Vec::new(), Vec::new());
        while let Some(window) = schedule.next(limit(schedule.windows())) {
            assert_eq!(window.index as usize, sizes.len());
            sizes.push(window.size);
            if schedule.accept(&window).is_some() {
                outputs.push(schedule.time());
            }
        }
        (sizes, outputs)
    }

    #[test]
    fn outputs_are_met_exactly_and_no_window_is_a_sliver() {
        let (sizes, outputs) = walk(0.4, 0.03, |n| 0.0071 + 0.001 * (n % 3) as f64);
        assert_eq!(outputs.len(), 14);
        for (k, time) in outputs.iter().enumerate() {
            assert_eq!(*time, (0.03 * (k + 1) as f64).min(0.4));
        }
        // The way to the next output is at least one interval's last part, 0.01 s, in windows of at most
        // 0.0091 s.
        assert!(sizes.iter().all(|&s| s >= 0.5 * 0.0071), "{sizes:?}");
        assert!(sizes.iter().all(|&s| s <= 0.0091 * (1.0 + 1e-8)));
    }

    /// Gone on from any window, a schedule is the same; with another end or interval it has the outputs of a
    /// run that had them from the start, numbered on.
    #[test]
    fn a_schedule_goes_on_from_any_window_also_with_another_end_or_interval() {
        let make = |end, interval| Schedule::new(0.0, end, interval, 0.011, SubSteps::Stable);
        let walk = |schedule: &mut Schedule, most: u64| {
            let (mut outputs, mut ends) = (Vec::new(), Vec::new());
            while let Some(window) = schedule.next(0.0071).filter(|window| window.index < most) {
                let output = schedule.accept(&window);
                outputs.extend(output.map(|number| (number, schedule.time())));
                ends.push(schedule.time());
            }
            (outputs, ends)
        };
        let gone_on = |from: &Schedule, end, interval| {
            let mut state = Writer::new(b"test0001");
            from.save(&mut state);
            let bytes = state.finish();
            let mut schedule = make(end, interval);
            schedule.restore(&mut Reader::new("schedule", b"test0001", &bytes).unwrap()).unwrap();
            schedule
        };
        let (_, whole) = walk(&mut make(0.4, 0.03), u64::MAX);
        for windows in 0..whole.len() {
            let mut first = make(0.4, 0.03);
            walk(&mut first, windows as u64);
            let (_, rest) = walk(&mut gone_on(&first, 0.4, 0.03), u64::MAX);
            assert_eq!(rest, whole[windows..], "{windows}");
        }
        let mut first = make(0.1, 0.03);
        let (outputs, _) = walk(&mut first, u64::MAX);
        assert_eq!(outputs.last(), Some(&(4, 0.1)));
        let (outputs, _) = walk(&mut gone_on(&first, 0.2, 0.03), u64::MAX);
        assert_eq!(outputs, [(5, 0.12), (6, 0.15), (7, 0.18), (8, 0.2)]);
        let (outputs, _) = walk(&mut gone_on(&first, 0.2, 0.05), u64::MAX);
        assert_eq!(outputs, [(5, 3.0 * 0.05), (6, 0.2)]);
    }

    #[test]
    fn a_run_that_ends_early_ends_with_an_output() {
        let mut schedule = Schedule::new(0.0, 1.0, 0.1, 0.03, SubSteps::Stable);
        let first = schedule.next(f64::INFINITY).expect("a window");
        assert_eq!(schedule.accept(&first), None);
        let second = schedule.next(f64::INFINITY).expect("a window");
        assert_eq!(schedule.accept_last(&second), Some(1));
        assert!(schedule.finished() && schedule.next(f64::INFINITY).is_none());
        assert_eq!((schedule.time(), schedule.windows()), (second.end(), 2));
    }

    /// Of every pair of an end and an interval with few decimals, and of ends just behind an output: no
    /// window is a sliver, the end is met to the bit, and there are as many outputs as intervals.
    #[test]
    fn what_is_left_at_the_end_is_no_window_of_its_own() {
        for interval in [0.0003, 0.001, 0.0007, 0.0025, 0.0125, 0.03, 0.1] {
            for count in 1..=60_u32 {
                // As people write them: decimal numbers.
                let end: f64 = format!("{:.6}", interval * f64::from(count)).parse().unwrap();
                for limit in [1.0, 0.4 * interval, 0.013 * interval] {
                    let (sizes, outputs) = walk(end, interval, |_| limit);
                    assert_eq!(outputs.len(), count as usize, "{end} over {interval}");
                    assert_eq!(outputs.last(), Some(&end));
                    let allowed = limit.min(0.05).min(interval);
                    assert!(
                        sizes.iter().all(|&s| s >= 0.5 * allowed * (1.0 - 1e-8)),
                        "{end} over {interval}"
                    );
                }
            }
        }
        let (sizes, outputs) = walk(0.1, 0.0033333, |_| 2e-4);
        assert_eq!((outputs.len(), outputs.last()), (30, Some(&0.1)));
        assert!(sizes.iter().all(|&s| (1.9e-4..2e-4).contains(&s)));
        // What is worth a window has one.
        let (sizes, outputs) = walk(0.1, 0.03, |_| 0.012);
        assert_eq!((outputs.len(), sizes.last()), (4, Some(&(0.1 - 3.0 * 0.03))));
    }

    /// Windows follow each other without a gap, none is longer than what both allow, none shorter than half
    /// of that but where the way itself is, and every output and the end are met to the bit; whatever the
    /// interval, the end and the limits.
    #[test]
    fn no_sliver_for_any_limits() {
        let mut seed = 1_u64;
        let mut random = move || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..300 {
            let (interval, cap) = (10.0_f64.powf(-3.0 * random()), 10.0_f64.powf(-3.0 * random()));
            let end = interval * (1.0 + 20.0 * random());
            let mut schedule = Schedule::new(0.0, end, interval, cap, SubSteps::Stable);
            let (mut last, mut outputs) = (0.0, 0);
            while schedule.windows() < 2000 {
                let limit = cap * (0.3 + random());
                let Some(window) = schedule.next(limit) else { break };
                let (allowed, left) = (limit.min(cap), schedule.target() - schedule.time());
                assert_eq!(window.start, last);
                assert!(window.size <= allowed * (1.0 + 1e-8), "{} {allowed}", window.size);
                assert!(
                    window.size >= 0.5 * allowed.min(left) * (1.0 - 1e-8),
                    "{} {allowed} {left}",
                    window.size
                );
                if let Some(number) = schedule.accept(&window) {
                    outputs += 1;
                    assert_eq!(number, outputs);
                    let regular = (outputs as f64 * interval).min(end);
                    assert!(schedule.time() == regular || (schedule.time() == end && end - regular < cap));
                }
                last = schedule.time();
            }
            assert!(schedule.windows() == 2000 || schedule.time() == end);
        }
    }

    /// An interval beyond the end leaves windows and end as they are, also where it comes while the run goes
    /// on.
    #[test]
    fn an_interval_far_beyond_the_end_is_none() {
        for interval in [1.0, 1e12, 1e300, f64::MAX] {
            let (sizes, outputs) = walk(0.4, interval, |_| 0.007);
            assert_eq!((sizes.len(), &outputs[..]), (58, &[0.4][..]), "{interval}");
            let mut schedule = Schedule::new(0.0, 0.4, 0.03, 0.05, SubSteps::Stable);
            while schedule.time() < 0.1 {
                let window = schedule.next(0.007).expect("a window");
                schedule.accept(&window);
            }
            assert_eq!(schedule.set_output_interval(interval), Ok(0.03));
            let mut last = schedule.time();
            while let Some(window) = schedule.next(0.007) {
                assert_eq!(window.start, last);
                assert!(window.size <= 0.007 * (1.0 + 1e-8));
                schedule.accept(&window);
                assert!((schedule.time() - window.end()).abs() < 1e-8);
                last = schedule.time();
            }
            assert_eq!(last, 0.4);
        }
    }

    #[test]
    fn windows_are_capped_and_one_window_may_reach_the_end() {
        assert_eq!(walk(0.1, 0.1, |_| f64::INFINITY).0.len(), 2);
        assert_eq!(walk(0.04, 0.1, |_| f64::INFINITY).0, vec![0.04]);
    }
}
