//! Progress of a run on the terminal; quiet where standard error is not one.

use crate::side::Side;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::fmt::Write as _;
use std::time::{Duration, Instant};

/// Steps of the bar over the simulated time.
const STEPS: u64 = 10_000;
/// Redraws a second.
const REDRAWS: u8 = 5;

/// A bar with simulated time, windows a second, remaining time, and each participant's share of the wall
/// time.
pub struct Progress {
    bar: ProgressBar,
    started: Instant,
    drawn: Instant,
    start_time: f64,
    end_time: f64,
}

impl Progress {
    /// A bar from `start_time` to `end_time` (s of simulated time); invisible if `quiet` or where standard
    /// error is no terminal.
    pub fn new(start_time: f64, end_time: f64, quiet: bool) -> Self {
        let target =
            if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr_with_hz(REDRAWS) };
        let bar = ProgressBar::with_draw_target(Some(STEPS), target);
        let style = ProgressStyle::with_template("{bar:30} {msg}  {left} left")
            .expect("the template is constant and well formed")
            .with_key("left", |state: &ProgressState, text: &mut dyn std::fmt::Write| {
                // Nothing sensible can be said if the terminal's string refuses to grow.
                let _ = write!(text, "{}", minutes(state.eta()));
            });
        bar.set_style(style);
        Self { bar, started: Instant::now(), drawn: Instant::now(), start_time, end_time }
    }

    /// After an accepted window: `time` (s) and number of windows so far.
    pub fn window(&mut self, time: f64, windows: u64, sides: &[&Side]) {
        if self.bar.is_hidden() || self.drawn.elapsed() < Duration::from_millis(1000 / u64::from(REDRAWS)) {
            return;
        }
        self.drawn = Instant::now();
        let wall = self.started.elapsed().as_secs_f64();
        let mut message =
            format!("t = {time:.4}/{} s  {:.1} windows/s ", self.end_time, windows as f64 / wall);
        for side in sides {
            let share = 100.0 * side.compute_seconds / wall;
            write!(message, " {} {share:.0} %", side.role()).expect("strings grow");
        }
        let part = (time - self.start_time) / (self.end_time - self.start_time);
        self.bar.set_position((part * STEPS as f64) as u64);
        self.bar.set_message(message);
    }

    /// Takes the bar off the terminal.
    pub fn end(self) {
        self.bar.finish_and_clear();
    }
}

fn minutes(duration: Duration) -> String {
    let seconds = duration.as_secs();
    if seconds < 60 { format!("{seconds} s") } else { format!("{} min {:02} s", seconds / 60, seconds % 60) }
}
