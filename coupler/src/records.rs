//! What the coupler writes of accepted windows: `windows.csv`, `probes.csv`, `probes_intervals.csv`, and
//! beside them the sums over all windows for `summary.json`.

mod interface;
mod running;
mod statistics;

use crate::condition46::Resultant;
use crate::convergence::Residual;
use crate::schemes::{Accepted, InterfaceState};
use crate::side::Side;
use interface::{InterfaceProbes, InterfaceSnapshots};
use interfaces::case::Case;
use interfaces::{Scalar, ScalarKind, TimeWindow};
use output::columns::Column;
use output::summary::{Balances, Condition46, Extremes, FluidBalance, Iterations};
use output::table::Table;
use running::Running;
use statistics::Statistics;
use std::collections::BTreeMap;
use std::path::Path;
use words::bytes::{self, Reader, Writer};

/// File of one row a window.
pub const WINDOWS: &str = "windows.csv";
/// File of one row a window of probe values.
pub const PROBES: &str = "probes.csv";
/// File of one row an interval of probe values.
pub const INTERVALS: &str = "probes_intervals.csv";

/// File of one row an iteration; only with an implicit scheme.
pub const ITERATIONS: &str = "iterations.csv";
/// All tables that a run may have.
pub const TABLES: [&str; 4] = [WINDOWS, PROBES, INTERVALS, ITERATIONS];
/// A row is due up to this part of the interval before: rounding of the sum of window sizes.
const ON_TIME: f64 = 1e-9;

/// What a case wants recorded.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted<'a> {
    /// Whether there are iterations, which have a table then.
    pub iterations: bool,
    /// Time (s) that is at least between two rows, but where an output is due.
    pub interval: f64,
    /// The case, for its probes: which of them go over intervals, are low-passed, or are on a structure that
    /// does not report them. Nobody's are without one.
    pub case: Option<&'a Case>,
    /// Whether the run goes on from a checkpoint, in the tables of an earlier run.
    pub goes_on: bool,
}

/// Bytes of each table, by its file.
pub type Lengths = BTreeMap<String, u64>;

/// The tables of a run, being written.
pub struct Records {
    windows: Table,
    probes: Option<Table>,
    intervals: Option<Table>,
    iterations: Option<Table>,
    statistics: Statistics,
    /// Probes and snapshots of a structure that does not give its own.
    on_interface: Option<InterfaceProbes>,
    snapshots: Option<InterfaceSnapshots>,
    /// The probes' values in the accepted state, in the order of their columns.
    values: Vec<f64>,
    solved: IterationSums,
    running: Running,
    /// Time between rows (s); none between those of every window.
    interval: f64,
    /// Time of the last row.
    recorded: f64,
    dimension: usize,
    coupled: bool,
    impulse_given: [f64; 3],
    impulse_applied: [f64; 3],
    work_given: f64,
    work_applied: f64,
    row: Vec<f64>,
    seconds: Vec<f64>,
}

/// Components of a vector and their names in a column's name.
type Axes = &'static [(usize, &'static str)];

/// Which parts of a resultant are recorded: force components, moment components.
fn axes(dimension: usize) -> (Axes, Axes) {
    match dimension {
        2 => (&[(0, "x"), (1, "y")], &[(2, "z")]),
        _ => (&[(0, "x"), (1, "y"), (2, "z")], &[(0, "x"), (1, "y"), (2, "z")]),
    }
}

/// Columns of what crosses the interface: how well condition (46) holds, resultants and power of the load at
/// each stage, impulse and work since the start.
fn interface_columns(dimension: usize) -> Vec<Column> {
    let (forces, moments) = axes(dimension);
    let stages = [
        ("given", "that the fluid gave"),
        ("before", "before condition (46) is enforced"),
        ("after", "after condition (46) is enforced"),
        ("applied", "that the structure received"),
    ];
    let residual = "residual of condition (46) over the load,";
    let mut columns = vec![
        Column::new("residual_before", "1", format!("{residual} before it is enforced")),
        Column::new("residual_after", "1", format!("{residual} after it is enforced")),
    ];
    for (stage, of) in stages {
        let parts = [("force", "N", forces), ("moment", "N*m", moments)];
        for (what, unit, axes) in parts {
            columns.extend(axes.iter().map(|(_, axis)| {
                Column::new(format!("{what}_{stage}_{axis}"), unit, format!("{what} on the structure {of}"))
            }));
        }
        columns.push(Column::new(format!("power_{stage}"), "W", format!("power of the load {of}")));
    }
    for (stage, of) in [stages[0], stages[3]] {
        columns.extend(forces.iter().map(|(_, axis)| {
            Column::new(format!("impulse_{stage}_{axis}"), "N*s", format!("impulse since the start {of}"))
        }));
        columns.push(Column::new(format!("work_{stage}"), "J", format!("work since the start {of}")));
    }
    columns
}

impl Records {
    /// Makes the tables in `dir` for the sides of a run, and writes the probes' values at `time` (s), the
    /// start.
    pub fn create(
        dir: &Path,
        (sides, interface): (&[&Side], Option<InterfaceState<'_>>),
        time: f64,
        wanted: &Wanted<'_>,
    ) -> output::Result<Self> {
        let dimension = sides.iter().map(|s| s.describe().dimension).max().unwrap_or(2);
        let coupled = sides.len() > 1;
        let mut columns = vec![
            Column::new("window", "1", "number of the window"),
            Column::new("time", "s", "time at its end"),
            Column::new("size", "s", "its size"),
            Column::new("iterations", "1", "solutions of it"),
        ];
        if coupled {
            columns.extend(interface_columns(dimension));
        }
        let mut probe_columns = vec![Column::new("t", "s", "time")];
        for side in sides {
            let role = side.role();
            let of_work = "wall time of the participant's own work on the window";
            columns.push(Column::new(format!("{role}.compute_seconds"), "s", of_work));
            for Scalar { name, unit, kind, meaning } in &side.describe().scalars {
                match kind {
                    ScalarKind::Balance => columns.push(Column::new(format!("{role}.{name}"), unit, meaning)),
                    ScalarKind::Probe => probe_columns.push(Column::new(name, unit, meaning)),
                }
            }
        }
        let (case, start) = (wanted.case, interface.as_ref());
        let on_interface =
            case.zip(start).map(|(case, start)| InterfaceProbes::new(case, &probe_columns, start));
        probe_columns.extend(on_interface.iter().flat_map(InterfaceProbes::columns).cloned());
        let probes = case.map_or(&[][..], |case| &case.probes);
        let statistics = Statistics::new(time, &probe_columns[1..], probes, dimension);
        probe_columns.extend(statistics.low_passed(&probe_columns[1..]));
        let interval_columns = statistics.over_intervals(&probe_columns[1..]);
        let table = |name: &str, columns: &[Column]| match wanted.goes_on {
            true => Table::reopen(&dir.join(name), columns),
            false => Table::create(&dir.join(name), columns),
        };
        let is_there = |columns: &[Column]| columns.len() > 1;
        let of_iterations = iteration_columns();
        let mut described = vec![(WINDOWS, &columns[..]), (PROBES, &probe_columns)];
        described.extend(is_there(&interval_columns).then_some((INTERVALS, &interval_columns[..])));
        described.extend(wanted.iterations.then_some((ITERATIONS, &of_iterations[..])));
        output::columns::write(dir, &described)?;
        let mut records = Self {
            windows: table(WINDOWS, &columns)?,
            probes: is_there(&probe_columns).then(|| table(PROBES, &probe_columns)).transpose()?,
            intervals: is_there(&interval_columns)
                .then(|| table(INTERVALS, &interval_columns))
                .transpose()?,
            iterations: wanted.iterations.then(|| table(ITERATIONS, &of_iterations)).transpose()?,
            statistics,
            on_interface,
            snapshots: match start.filter(|_| case.is_some()) {
                Some(start) => InterfaceSnapshots::create(dir, time, start)?,
                None => None,
            },
            values: Vec::with_capacity(probe_columns.len()),
            solved: IterationSums::default(),
            running: Running::new(&probe_columns[1..]),
            interval: wanted.interval,
            recorded: time,
            dimension,
            coupled,
            impulse_given: [0.0; 3],
            impulse_applied: [0.0; 3],
            work_given: 0.0,
            work_applied: 0.0,
            row: Vec::with_capacity(columns.len()),
            seconds: vec![0.0; sides.len()],
        };
        records.read_probes(time, sides, start);
        if !wanted.goes_on {
            records.probe_row(time)?;
        }
        Ok(records)
    }

    /// Reads the probes of the accepted state at a time (s).
    fn read_probes(&mut self, time: f64, sides: &[&Side], interface: Option<&InterfaceState<'_>>) {
        self.values.clear();
        for side in sides {
            self.values.extend(scalars(side, ScalarKind::Probe));
        }
        if let (Some(probes), Some(state)) = (&self.on_interface, interface) {
            probes.read(time, state, &mut self.values);
        }
        self.statistics.take(time, &mut self.values);
        self.running.probes(time, &self.values);
    }

    /// Records an accepted window, and what each of its iterations left; nothing with an explicit scheme.
    /// After an error all tables end with the last window that is whole in each of them, and take no more.
    pub fn record(
        &mut self,
        accepted: &Accepted,
        residuals: &[Residual],
        (sides, interface): (&[&Side], Option<InterfaceState<'_>>),
    ) -> output::Result<()> {
        let is_due = self.interval == 0.0
            || accepted.output.is_some()
            || accepted.time - self.recorded >= self.interval * (1.0 - ON_TIME);
        let recorded = self
            .iterations(&accepted.window, residuals, is_due)
            .and_then(|()| self.window(accepted, (sides, interface.as_ref()), is_due));
        if recorded.is_err() {
            // The error to tell is the one that was first.
            let _ = self.cut();
        }
        recorded
    }

    /// Ends all tables with the same window.
    fn cut(&mut self) -> output::Result<()> {
        let mut whole = self.windows.whole_rows()?;
        if let Some(probes) = &self.probes {
            whole = whole.min(probes.whole_rows()?.saturating_sub(1));
        }
        self.windows.cut(|row, _| row < whole)?;
        if let Some(probes) = &mut self.probes {
            probes.cut(|row, _| row <= whole)?;
            let last = probes.last_first_cell()?;
            if let Some(intervals) = &mut self.intervals {
                intervals.cut(|_, end| last.is_some_and(|last| end <= last))?;
            }
        }
        let last = self.windows.last_first_cell()?;
        if let Some(iterations) = &mut self.iterations {
            iterations.cut(|_, window| last.is_some_and(|last| window <= last))?;
        }
        Ok(())
    }

    fn iterations(
        &mut self,
        window: &TimeWindow,
        residuals: &[Residual],
        is_due: bool,
    ) -> output::Result<()> {
        let Some(table) = &mut self.iterations else { return Ok(()) };
        let rows = if is_due { residuals } else { &[] };
        for (iteration, left) in rows.iter().enumerate() {
            table.row(&[
                window.index as f64,
                iteration as f64,
                left.absolute,
                left.relative,
                left.of_first,
            ])?;
        }
        let solved = &mut self.solved;
        (solved.windows, solved.total) = (solved.windows + 1, solved.total + residuals.len() as u64);
        solved.most = solved.most.max(residuals.len() as u64);
        solved.not_converged += u64::from(residuals.last().is_some_and(|left| !left.converged));
        Ok(())
    }

    fn window(
        &mut self,
        accepted: &Accepted,
        (sides, interface): (&[&Side], Option<&InterfaceState<'_>>),
        is_due: bool,
    ) -> output::Result<()> {
        let window = &accepted.window;
        let mut row = std::mem::take(&mut self.row);
        row.clear();
        row.extend([window.index as f64, accepted.time, window.size, f64::from(window.iteration + 1)]);
        if self.coupled {
            let found = accepted.condition46.unwrap_or_default();
            let applied = accepted.applied.unwrap_or_default();
            for i in 0..3 {
                self.impulse_given[i] += window.size * found.given.force[i];
                self.impulse_applied[i] += window.size * applied.force[i];
            }
            self.work_given += window.size * found.given.power;
            self.work_applied += window.size * applied.power;
            self.running.condition_46(found.residual_before, found.residual_after);
            row.extend([found.residual_before, found.residual_after]);
            for resultant in [&found.given, &found.before, &found.after, &applied] {
                self.push_resultant(resultant, &mut row);
            }
            let forces = axes(self.dimension).0;
            row.extend(forces.iter().map(|(i, _)| self.impulse_given[*i]));
            row.push(self.work_given);
            row.extend(forces.iter().map(|(i, _)| self.impulse_applied[*i]));
            row.push(self.work_applied);
        }
        self.running.balances(sides);
        self.read_probes(accepted.time, sides, interface);
        if let Some(table) = &mut self.intervals {
            for row in self.statistics.ended() {
                table.row(row)?;
            }
        }
        if !is_due {
            self.row = row;
            return Ok(());
        }
        self.recorded = accepted.time;
        for (side, before) in sides.iter().zip(&mut self.seconds) {
            row.push(side.compute_seconds - *before);
            *before = side.compute_seconds;
            row.extend(scalars(side, ScalarKind::Balance));
        }
        let written = self.windows.row(&row);
        self.row = row;
        written?;
        self.probe_row(accepted.time)?;
        if accepted.output.is_some() {
            if let (Some(snapshots), Some(state)) = (&mut self.snapshots, interface) {
                snapshots.write(accepted.time, state)?;
            }
            self.flush()?;
        }
        Ok(())
    }

    /// Hands all rows so far to the operating system.
    pub fn flush(&mut self) -> output::Result<()> {
        self.windows.flush()?;
        for table in [&mut self.probes, &mut self.intervals, &mut self.iterations].into_iter().flatten() {
            table.flush()?;
        }
        Ok(())
    }

    fn probe_row(&mut self, time: f64) -> output::Result<()> {
        let Some(table) = &mut self.probes else { return Ok(()) };
        self.row.clear();
        self.row.push(time);
        self.row.extend(&self.values);
        table.row(&self.row)
    }

    fn push_resultant(&self, resultant: &Resultant, row: &mut Vec<f64>) {
        let (forces, moments) = axes(self.dimension);
        row.extend(forces.iter().map(|(i, _)| resultant.force[*i]));
        row.extend(moments.iter().map(|(i, _)| resultant.moment[*i]));
        row.push(resultant.power);
    }

    /// The tables that there are, and their files.
    fn tables(&mut self) -> impl Iterator<Item = (&'static str, &mut Table)> {
        let others = [
            (PROBES, &mut self.probes),
            (INTERVALS, &mut self.intervals),
            (ITERATIONS, &mut self.iterations),
        ];
        let others = others.into_iter().filter_map(|(name, table)| Some((name, table.as_mut()?)));
        [(WINDOWS, &mut self.windows)].into_iter().chain(others)
    }

    /// Forces all rows so far to the disk. Gives the bytes that the tables have then.
    pub fn sync(&mut self) -> output::Result<Lengths> {
        self.tables().map(|(name, table)| Ok((name.to_owned(), table.sync()?))).collect()
    }

    /// Cuts the tables of an earlier run to these lengths, and goes on behind them.
    pub fn go_on(&mut self, lengths: &Lengths) -> output::Result<()> {
        self.tables().try_for_each(|(name, table)| table.go_on(lengths.get(name).copied().unwrap_or(0)))?;
        match &mut self.snapshots {
            Some(snapshots) => snapshots.go_on(),
            None => Ok(()),
        }
    }

    /// Writes the sums that a next row adds to, and the times of snapshots.
    pub fn save(&self, state: &mut Writer) {
        for sums in [&self.impulse_given[..], &self.impulse_applied, &self.seconds] {
            state.f64s(sums);
        }
        state.f64(self.work_given);
        state.f64(self.work_applied);
        state.f64(self.recorded);
        self.running.save(state);
        self.statistics.save(state);
        let IterationSums { windows, total, most, not_converged } = self.solved;
        [windows, total, most, not_converged].into_iter().for_each(|count| state.u64(count));
        state.option(self.snapshots.as_ref(), |state, snapshots| state.f64s(snapshots.times()));
    }

    /// Goes to what [`save`](Self::save) wrote of a run of the same case.
    pub fn restore(&mut self, state: &mut Reader<'_>) -> Result<(), bytes::Error> {
        for sums in [&mut self.impulse_given[..], &mut self.impulse_applied, &mut self.seconds] {
            sums.copy_from_slice(&state.f64s("sums over the windows", Some(sums.len()))?);
        }
        self.work_given = state.f64("work given")?;
        self.work_applied = state.f64("work taken")?;
        self.recorded = state.f64("time of the last row")?;
        self.running.restore(state)?;
        self.statistics.restore(state)?;
        let IterationSums { windows, total, most, not_converged } = &mut self.solved;
        for count in [windows, total, most, not_converged] {
            *count = state.u64("sums over the iterations")?;
        }
        let times = state.option("snapshots", |state| state.f64s("times of snapshots", None))?;
        if let (Some(snapshots), Some(times)) = (&mut self.snapshots, times) {
            snapshots.stand_at(times);
        }
        Ok(())
    }

    /// Hands over all rows, and gives what all windows say in sum.
    pub fn balances(&mut self) -> (Sums, output::Result<()>) {
        let written = self.flush().inspect_err(|_| {
            // The error to tell is the one that was first.
            let _ = self.cut();
        });
        let mut balances = Balances { energy: self.running.energy(), ..Balances::default() };
        if self.coupled {
            balances.impulse_given_newton_seconds = self.impulse_given[..self.dimension].to_vec();
            balances.impulse_taken_newton_seconds = self.impulse_applied[..self.dimension].to_vec();
            balances.work_given_joules = Some(self.work_given);
            balances.work_taken_joules = Some(self.work_applied);
        }
        let condition_46 = self.coupled.then(|| self.running.spreads());
        let iterations = self.iterations.as_ref().map(|_| self.solved.summary());
        let (fluid, probes) = (self.running.fluid(), self.running.extremes());
        (Sums { balances, condition_46, fluid, probes, iterations }, written)
    }
}

fn iteration_columns() -> [Column; 5] {
    [
        Column::new("window", "1", "number of the window"),
        Column::new("iteration", "1", "which solution of it"),
        Column::new("residual_absolute", "Pa/m", "norm of the residual of the load"),
        Column::new("residual_relative", "1", "residual over the values"),
        Column::new("residual_of_first", "1", "residual over that of the window's first iteration"),
    ]
}

/// Iterations over the accepted windows.
#[derive(Clone, Copy, Debug, Default)]
struct IterationSums {
    windows: u64,
    total: u64,
    most: u64,
    not_converged: u64,
}

impl IterationSums {
    fn summary(&self) -> Iterations {
        let Self { windows, total, most, not_converged } = *self;
        Iterations { mean: total as f64 / windows.max(1) as f64, most, not_converged }
    }
}

/// What the tables of a run say in sum.
pub struct Sums {
    /// Iterations; nothing with an explicit scheme.
    pub iterations: Option<Iterations>,
    /// Impulse, work, energy.
    pub balances: Balances,
    /// Residuals; nothing for a run of one side.
    pub condition_46: Option<Condition46>,
    /// Volume and particles; nothing without a fluid that reports them.
    pub fluid: Option<FluidBalance>,
    /// Extremes by probe column.
    pub probes: BTreeMap<String, Extremes>,
}

fn scalars(side: &Side, kind: ScalarKind) -> impl Iterator<Item = f64> {
    let described = side.describe().scalars.iter();
    described.zip(&side.scalars).filter(move |(s, _)| s.kind == kind).map(|(_, value)| *value)
}
