//! Which columns of a run's tables become which figure. A figure whose columns are not there is left out.

use super::plot::{Curve, Mark, Marks, Plot};
use super::references::Reference;
use super::scale;
use crate::summary::EnergyBalance;
use crate::sums::Energies;
use crate::table::Columns;
use words::balances;

/// A picture and what stands below it.
pub(crate) struct Figure {
    pub plot: Plot,
    pub caption: String,
}

/// How far the run is from one reference, at the reference's times within the run.
pub(crate) struct Comparison {
    pub probe: String,
    pub label: String,
    pub points: usize,
    pub unit: String,
    pub root_mean_square: f64,
    pub largest: f64,
    pub reference_peak: f64,
    pub run_peak: f64,
}

const WORKS: &str = "Since the start. Those on our fluid are together the change of its kinetic and potential energy: what the pressure \
     projection takes is what all others leave.";

/// The time column of a table: `time` or `t`.
fn times(table: &Columns) -> Option<&[f64]> {
    table.get("time").or_else(|| table.get("t"))
}

fn is_time(name: &str) -> bool {
    matches!(name, "time" | "t")
}

/// The part of a column's name after its last dot: `kinetic_energy` of `fluid.kinetic_energy`.
fn quantity_of(column: &str) -> &str {
    column.rsplit('.').next().unwrap_or(column)
}

fn owner_of(column: &str) -> &str {
    column.rsplit_once('.').map_or("", |(owner, _)| owner)
}

/// A figure for each column that has references, and one for the other columns of each probe and unit.
pub(crate) fn probes(table: &Columns, references: &[Reference]) -> Vec<Figure> {
    let Some(times) = times(table) else { return Vec::new() };
    let mut plots: Vec<(Plot, String, String)> = Vec::new();
    for (name, values) in table.iter().filter(|(name, _)| !is_time(name)) {
        let unit = table.unit(name);
        let own: Vec<&Reference> = references.iter().filter(|r| r.probe == name).collect();
        let owner = owner_of(name).to_owned();
        if own.is_empty() {
            let shared =
                plots.iter_mut().find(|(p, o, _)| *o == owner && p.unit == unit && p.marks.is_empty());
            if let Some((plot, _, _)) = shared {
                plot.curves.push(curve(quantity_of(name), times, values));
                plot.title.clone_from(&owner);
            } else {
                let curves = vec![curve(quantity_of(name), times, values)];
                plots.push((
                    Plot { title: name.to_owned(), unit, curves, ..Plot::default() },
                    owner,
                    String::new(),
                ));
            }
        } else {
            let curves = vec![curve("this run", times, values)];
            let marks = own.iter().map(|r| marks(r)).collect();
            let sources = sources(&own, times);
            plots.push((
                Plot { title: name.to_owned(), unit, curves, marks, ..Plot::default() },
                owner,
                sources,
            ));
        }
    }
    plots.into_iter().map(|(plot, _, caption)| Figure { plot, caption }).collect()
}

/// The same of probes over intervals, each column without the rows at which no interval of it ends.
pub(crate) fn intervals(table: &Columns, references: &[Reference]) -> Vec<Figure> {
    let mut figures = probes(table, references);
    for Figure { plot, caption } in &mut figures {
        for Curve { times, values, .. } in &mut plot.curves {
            let numbers: Vec<(f64, f64)> =
                times.iter().copied().zip(values.iter().copied()).filter(|(_, v)| !v.is_nan()).collect();
            (*times, *values) = numbers.into_iter().unzip();
        }
        plot.title = format!("{}, over intervals", plot.title);
        *caption = format!("Mean, least and largest value over each interval, at its end. {caption}");
    }
    figures
}

fn curve(label: &str, times: &[f64], values: &[f64]) -> Curve {
    Curve { label: label.replace('_', " "), times: times.to_vec(), values: values.to_vec() }
}

fn marks(reference: &Reference) -> Marks {
    let point = |(index, (&time, &value)): (usize, (&f64, &f64))| {
        let range = reference.range.as_ref().map(|range| range[index]).filter(|(low, high)| high > low);
        Mark { time, value, range }
    };
    let points = reference.time.iter().zip(&reference.value).enumerate().map(point).collect();
    Marks { label: reference.label.clone(), points }
}

fn sources(references: &[&Reference], times: &[f64]) -> String {
    let end = times.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let one = |r: &&Reference| {
        let beyond = r.time.iter().filter(|&&t| t > end).count();
        let left_out =
            if beyond > 0 { format!(" ({beyond} later than the run, not drawn)") } else { String::new() };
        let source = if r.source.is_empty() { "no source given" } else { &r.source };
        format!("{}: {source}{left_out}.", r.label)
    };
    references.iter().map(one).collect::<Vec<_>>().join(" ")
}

/// How far the run is from each reference, the run's values interpolated linearly to the reference's times.
pub(crate) fn comparisons(table: &Columns, references: &[Reference]) -> Vec<Comparison> {
    let compare = |reference: &Reference| {
        let (times, values) = (times(table)?, table.get(&reference.probe)?);
        let differences: Vec<f64> = reference
            .time
            .iter()
            .zip(&reference.value)
            .filter_map(|(&time, &value)| Some(interpolated(times, values, time)? - value))
            .collect();
        let points = differences.len();
        let mean_square = differences.iter().map(|d| d * d).sum::<f64>() / points as f64;
        let by_size = |a: &f64, b: &f64| a.abs().total_cmp(&b.abs());
        Some(Comparison {
            probe: reference.probe.clone(),
            label: reference.label.clone(),
            points,
            unit: table.unit(&reference.probe),
            root_mean_square: mean_square.sqrt(),
            largest: differences.iter().copied().max_by(by_size)?,
            reference_peak: reference.value.iter().copied().max_by(by_size)?,
            run_peak: values.iter().copied().filter(|v| v.is_finite()).max_by(by_size)?,
        })
    };
    references.iter().filter_map(compare).collect()
}

fn interpolated(times: &[f64], values: &[f64], time: f64) -> Option<f64> {
    let after = times.partition_point(|&t| t < time);
    if times.get(after) == Some(&time) {
        return Some(values[after]);
    }
    let before = after.checked_sub(1)?;
    let (&t0, &t1) = (times.get(before)?, times.get(after)?);
    Some(values[before] + (values[after] - values[before]) * (time - t0) / (t1 - t0))
}

/// Condition (46), iterations and what crossed the interface.
pub(crate) fn coupling(windows: &Columns) -> Vec<Figure> {
    let residual = |name: &str| name.contains("residual_before") || name.contains("residual_after");
    [
        figure(
            windows,
            "Residual of condition (46)",
            residual,
            true,
            "Before: as the fluid sent the load. After: as the structure received it, enforced. Zeros have no place \
             on a logarithmic axis.",
        ),
        figure(windows, "Iterations", |name| quantity_of(name).ends_with("iterations"), false, ""),
        figure(
            windows,
            "Force at the interface",
            |name| quantity_of(name).starts_with("force"),
            false,
            "On the structure: given by the fluid, before and after condition (46) is enforced, applied to the structure.",
        ),
        figure(windows, "Power at the interface", |name| quantity_of(name).starts_with("power"), false, ""),
        figure(
            windows,
            "Impulse at the interface",
            |name| quantity_of(name).starts_with("impulse"),
            false,
            "The force, summed over time: what is given and not applied is momentum lost between the two.",
        ),
        figure(
            windows,
            "Work at the interface",
            |name| quantity_of(name).starts_with("work"),
            false,
            "The power, summed over time: given by the fluid, applied to the structure. Their difference is energy that \
             the coupling made or took.",
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Length of the windows, what they took, and what the fluid's state says of itself.
pub(crate) fn progress(windows: &Columns) -> Vec<Figure> {
    [
        figure(windows, "Time window", |name| matches!(quantity_of(name), "size" | "dt"), false, ""),
        figure(windows, "Sub-steps in a window", |name| quantity_of(name) == "sub_steps", false, ""),
        figure(
            windows,
            "Wall time of a window",
            |name| quantity_of(name) == "compute_seconds",
            false,
            "Own work of each participant, without its waits.",
        ),
        figure(
            windows,
            "Drift of the fluid's volume",
            |name| quantity_of(name) == balances::VOLUME_DRIFT,
            false,
            "As a fraction of the volume at the start.",
        ),
        figure(
            windows,
            "Particles out of the fluid",
            |name| {
                matches!(quantity_of(name), "splashes" | balances::PARTICLES_LEFT | balances::PARTICLES_LOST)
            },
            false,
            "Splashes fly alone; who left went out of the domain; who is lost is inside a wall or the structure.",
        ),
        figure(windows, "Greatest speed", |name| quantity_of(name) == "max_speed", false, ""),
        figure(
            windows,
            "Solver residual",
            |name| quantity_of(name).ends_with("residual"),
            true,
            "Zeros have no place on a logarithmic axis.",
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// One figure of all columns that `choose` takes.
fn figure(
    table: &Columns,
    title: &str,
    choose: impl Fn(&str) -> bool,
    logarithmic: bool,
    caption: &str,
) -> Option<Figure> {
    let times = times(table)?;
    let chosen: Vec<(&str, &[f64])> = table.iter().filter(|(name, _)| choose(name)).collect();
    let unit = table.unit(chosen.first()?.0);
    let curves = chosen.iter().map(|(name, values)| curve(&name.replace('.', " "), times, values)).collect();
    let plot = Plot { title: title.to_owned(), unit, logarithmic, curves, ..Plot::default() };
    Some(Figure { plot, caption: caption.to_owned() })
}

/// Energies `<side>.<kind>_energy`: one figure a side with its total, then the whole (the paper's Figs. 11
/// and 20).
pub(crate) fn energy(windows: &Columns) -> Vec<Figure> {
    let Some(times) = times(windows) else { return Vec::new() };
    let mut sides: Vec<&str> = Vec::new();
    for (name, _) in windows.iter().filter(|(name, _)| name.ends_with("_energy")) {
        let owner = owner_of(name);
        if !owner.is_empty() && !sides.contains(&owner) {
            sides.push(owner);
        }
    }
    // The paper's order: the structure first.
    sides.sort_by_key(|side| *side != "structure");
    let mut figures = Vec::new();
    let mut totals = Vec::new();
    for side in sides {
        let (curves, total) = side_energy(windows, times, side);
        let caption = if side == "structure" { "As the paper's Figs. 11 and 20(a)–(d)." } else { "" };
        figures.push(energy_figure(&format!("Energy of the {side}"), curves, caption.to_owned()));
        figures.extend(work_figure(windows, times, side));
        let of_work = |name: &str| {
            let of_walls = if side == "structure" { balances::WALL_WORK } else { balances::CLAMP_WORK };
            let energy = [balances::LOAD_WORK, balances::CLAMP_WORK, of_walls].contains(&quantity_of(name));
            owner_of(name) == side && name.ends_with("_work") && !energy
        };
        figures.extend(figure(windows, &format!("Works on the {side}"), of_work, false, WORKS));
        totals.push((side, total));
    }
    let whole = windows.get("total_energy").map(<[f64]>::to_vec);
    if totals.len() > 1 || whole.is_some() {
        let total = whole.unwrap_or_else(|| sum(totals.iter().map(|(_, total)| total.as_slice())));
        let caption = EnergyBalance::of(energies(windows, &total)).map(|balance| {
            format!(
                "Start {}, end {}, largest rise above an earlier value {} (the paper's Fig. 20(f)), {} of the energy that the motion has.",
                scale::quantity(balance.start_joules, "J"),
                scale::quantity(balance.end_joules, "J"),
                scale::quantity(balance.largest_rise_joules, "J"),
                scale::short(balance.largest_rise_joules / balance.moved_joules)
            )
        });
        let mut curves: Vec<Curve> = totals.iter().map(|(side, total)| curve(side, times, total)).collect();
        curves.push(curve("total", times, &total));
        figures.push(energy_figure("Energy of the whole", curves, caption.unwrap_or_default()));
    }
    figures
}

/// The energies of the whole, row by row; of a participant that tells a total alone, that.
fn energies<'a>(windows: &'a Columns, total: &'a [f64]) -> impl Iterator<Item = Energies> + 'a {
    (0..total.len()).map(|row| {
        let (mut sum, mut any) = (Energies::default(), false);
        for (name, values) in windows.iter() {
            any |= sum.add(quantity_of(name), values[row]);
        }
        if any { sum } else { Energies { potential: total[row], ..Energies::default() } }
    })
}

fn energy_figure(title: &str, curves: Vec<Curve>, caption: String) -> Figure {
    let plot = Plot { title: title.to_owned(), unit: "J".to_owned(), curves, ..Plot::default() };
    Figure { plot, caption }
}

/// The work of all loads on a side (gravity among them), that of clamps and walls that move, and what became
/// of it: kinetic, strain, contact's and dissipated energy. Without `load_work` there is none.
fn work_figure(windows: &Columns, times: &[f64], side: &str) -> Option<Figure> {
    let column = |name: &str| windows.get(&format!("{side}.{name}"));
    let of_loads = column(balances::LOAD_WORK)?;
    let of_clamps = column(balances::CLAMP_WORK);
    let of_walls = column(balances::WALL_WORK);
    let work = sum(std::iter::once(of_loads).chain(of_clamps).chain(of_walls));
    let kept = [
        balances::KINETIC_ENERGY,
        balances::STRAIN_ENERGY,
        balances::CONTACT_ENERGY,
        balances::DISSIPATED_ENERGY,
        balances::FRICTION_LOSS,
    ];
    let stored = sum(kept.into_iter().filter_map(column));
    let first = stored.first()? - work.first()?;
    let error = |(e, w): (&f64, &f64)| (e - w - first).abs();
    let largest = stored.iter().zip(&work).map(error).fold(0.0, f64::max);
    let scale = stored.iter().fold(0.0, |most: f64, e| most.max(e.abs()));
    let and_others = match (of_clamps, of_walls) {
        (None, None) => "",
        (Some(_), None) => ", and of clamps that move",
        (None, Some(_)) => ", and of walls that move",
        (Some(_), Some(_)) => ", and of clamps and walls that move",
    };
    let caption = format!(
        "Kinetic, strain and dissipated energy together, and the work of all loads, gravity among them{and_others}. Since the first window their \
         difference has changed by {} at most, {} of the largest energy.",
        scale::quantity(largest, "J"),
        scale::short(if scale > 0.0 { largest / scale } else { 0.0 })
    );
    let mut curves =
        vec![curve("kinetic + strain + dissipated", times, &stored), curve("work of loads", times, of_loads)];
    let others = [("work of clamps", of_clamps), ("work of walls", of_walls)];
    curves.extend(others.iter().filter_map(|(name, values)| Some(curve(name, times, (*values)?))));
    if curves.len() > 2 {
        curves.push(curve(if curves.len() > 3 { "work of all" } else { "work of both" }, times, &work));
    }
    Some(energy_figure(&format!("Energy and work, {side}"), curves, caption))
}

/// Curves of the kinds of energy of a side and of their total; and the total.
fn side_energy(windows: &Columns, times: &[f64], side: &str) -> (Vec<Curve>, Vec<f64>) {
    let kinds: Vec<(&str, &[f64])> = windows
        .iter()
        .filter(|(name, _)| owner_of(name) == side)
        .filter_map(|(name, values)| Some((quantity_of(name).strip_suffix("_energy")?, values)))
        .collect();
    let given = kinds.iter().find(|(kind, _)| matches!(*kind, "total" | "mechanical"));
    let parts: Vec<(&str, &[f64])> =
        kinds.iter().copied().filter(|(kind, _)| !matches!(*kind, "total" | "mechanical")).collect();
    // What damping took is no energy of the side any more.
    let held = parts.iter().filter(|(kind, _)| *kind != "dissipated").map(|(_, values)| *values);
    let total = given.map_or_else(|| sum(held), |(_, values)| values.to_vec());
    // Nothing but zero (no gravity, no damping) would only fill the legend.
    let shown = parts.iter().filter(|(_, values)| parts.len() == 1 || values.iter().any(|&v| v != 0.0));
    let mut curves: Vec<Curve> = shown.map(|(kind, values)| curve(kind, times, values)).collect();
    if parts.len() != 1 {
        curves.push(curve("total", times, &total));
    }
    (curves, total)
}

fn sum<'a>(parts: impl Iterator<Item = &'a [f64]>) -> Vec<f64> {
    let mut total: Vec<f64> = Vec::new();
    for part in parts {
        if total.is_empty() {
            total = part.to_vec();
        } else {
            total.iter_mut().zip(part).for_each(|(t, p)| *t += p);
        }
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::Content;

    fn table(columns: &[(&str, &[f64])]) -> Columns {
        Columns {
            names: columns.iter().map(|(name, _)| (*name).to_owned()).collect(),
            columns: columns.iter().map(|(_, values)| values.to_vec()).collect(),
            contents: columns.iter().map(|(name, _)| content(name)).collect(),
        }
    }

    /// As a run says of the columns that these tests have.
    fn content(name: &str) -> (String, Content) {
        let unit = match quantity_of(name) {
            "ux" | "uy" => "m",
            "vx" | "vy" => "m/s",
            "p" => "Pa",
            _ => "1",
        };
        (name.to_owned(), Content { unit: unit.to_owned(), ..Content::default() })
    }

    #[test]
    fn missing_columns_leave_their_figures_out() {
        assert!(coupling(&table(&[])).is_empty());
        assert!(energy(&table(&[("fluid.kinetic_energy", &[1.0])])).is_empty(), "no time, no figure");
        let windows =
            table(&[("time", &[0.0, 1.0]), ("window", &[0.0, 1.0]), ("residual_before", &[0.5, 0.4])]);
        assert_eq!(coupling(&windows).len(), 1);
        assert!(energy(&windows).is_empty() && progress(&windows).is_empty());
    }

    #[test]
    fn energies_of_each_side_add_up() {
        let windows = table(&[
            ("time", &[0.0, 1.0]),
            ("fluid.kinetic_energy", &[0.0, 3.0]),
            ("fluid.potential_energy", &[10.0, 6.0]),
            ("structure.strain_energy", &[0.0, 0.5]),
            ("structure.kinetic_energy", &[0.0, 0.25]),
        ]);
        let figures = energy(&windows);
        assert_eq!(figures.len(), 3);
        assert_eq!(figures[0].plot.title, "Energy of the structure");
        assert_eq!(figures[2].plot.curves[2].values, [10.0, 9.75]);
        assert!(
            figures[2].caption.starts_with("Start 10 J, end 9.75 J, largest rise above an earlier value 0")
        );
    }

    #[test]
    fn work_and_energy_are_held_against_each_other() {
        let windows = table(&[
            ("time", &[0.0, 1.0]),
            ("structure.kinetic_energy", &[1.0, 2.0]),
            ("structure.strain_energy", &[0.0, 2.0]),
            ("structure.potential_energy", &[0.0, 0.0]),
            ("structure.load_work", &[0.0, 4.5]),
            ("structure.dissipated_energy", &[0.0, 1.0]),
        ]);
        let figures = energy(&windows);
        assert_eq!(figures.len(), 2);
        // Held is what is not dissipated; a gravity that does not act has no curve.
        let labels: Vec<_> = figures[0].plot.curves.iter().map(|curve| curve.label.as_str()).collect();
        assert_eq!(labels, ["kinetic", "strain", "dissipated", "total"]);
        assert_eq!(figures[0].plot.curves[3].values, [1.0, 4.0]);
        // 5 − 4.5 at the end, 1 at the start: a change of 0.5, a tenth of 5.
        let caption = &figures[1].caption;
        assert!(caption.contains("by 500 mJ at most, 0.1 of"), "{caption}");
        let driven = table(&[
            ("time", &[0.0, 1.0]),
            ("structure.kinetic_energy", &[0.0, 5.0]),
            ("structure.load_work", &[0.0, 1.5]),
            ("structure.clamp_work", &[0.0, 3.0]),
        ]);
        let figures = energy(&driven);
        assert_eq!(figures.len(), 2);
        assert_eq!(figures[1].plot.curves[3].values, [0.0, 4.5]);
        assert!(figures[1].caption.contains("by 500 mJ at most, 0.1 of"), "{}", figures[1].caption);
    }

    #[test]
    fn probes_are_grouped_and_compared() {
        let probes = table(&[
            ("t", &[0.0, 1.0, 2.0]),
            ("tip.ux", &[0.0, 0.02, 0.04]),
            ("tip.uy", &[0.0, 0.01, 0.01]),
            ("wall.p", &[0.0, 1e3, 2e3]),
            ("tip.vx", &[0.0, 1.0, 2.0]),
            ("tip.vy", &[0.0, 1.0, 2.0]),
        ]);
        let reference = Reference {
            probe: "tip.ux".to_owned(),
            label: "experiment".to_owned(),
            source: "somebody".to_owned(),
            time: vec![0.5, 2.0, 3.0],
            value: vec![0.013, 0.036, 1.0],
            range: None,
        };
        // tip.ux with its reference, tip.uy, wall.p, and the two velocities together.
        let figures = probes_titles(&probes, std::slice::from_ref(&reference));
        assert_eq!(figures, ["tip.ux", "tip.uy", "wall.p", "tip"]);
        let comparison = &comparisons(&probes, &[reference])[0];
        // Differences: 0.010 − 0.013 and 0.040 − 0.036; the third time is later than the run.
        assert_eq!(comparison.points, 2);
        assert!((comparison.largest - 0.004).abs() < 1e-15);
        assert!((comparison.root_mean_square - (12.5e-6f64).sqrt()).abs() < 1e-15);
    }

    fn probes_titles(table: &Columns, references: &[Reference]) -> Vec<String> {
        probes(table, references).into_iter().map(|figure| figure.plot.title).collect()
    }
}
