//! What is meant where the case leaves a key out that has no one default: it follows from other keys. (One
//! default for all cases stands with its key.)
//!
//! It is written into the table before that is read as a [`Case`](super::Case), whose fields so are never
//! empty. Only where the value follows from checked geometry is it found afterwards
//! ([`characteristic_speed`]).

use super::coupling;
use super::fluid::Fluid;
use super::geometry::AxisBox;
use super::region::Region;
use super::section::to_table;
use toml::{Table, Value};

/// Times that particles off the lattice move to the centroids of their cells where the case does not say:
/// with that many, rows at faces at an angle to the lattice follow the faces.
const RELAXATION: i64 = 10;

/// Fills in the table of a case that has all keys it must have.
pub(super) fn fill_in(table: &mut Table) {
    let general = table.get_mut("case").and_then(Value::as_table_mut).expect("a case must have [case]");
    let dimension = general["dimension"].as_integer().expect("it is a whole number").cast_unsigned() as usize;
    let zero = Value::from(vec![0.0; dimension]);
    default(general, "gravity", zero.clone());
    // A run that is shorter has one output, at its end.
    if number(&general["output_interval"]) > number(&general["end_time"]) {
        general.insert("output_interval".to_owned(), general["end_time"].clone());
    }
    let (spacing, interval) = (general["particle_spacing"].clone(), general["output_interval"].clone());
    for side in ["fluid", "structure"] {
        let Some(side) = table.get_mut(side).and_then(Value::as_table_mut) else { continue };
        default(side, "particle_spacing", spacing.clone());
    }
    if let Some(fluid) = table.get_mut("fluid").and_then(Value::as_table_mut) {
        default(fluid, "max_time_step", interval.clone());
        for region in each(fluid, "region") {
            default(region, "velocity", zero.clone());
            default(region, "velocity_gradient", vec![zero.clone(); dimension]);
        }
        for wall in each(fluid, "wall") {
            default(wall, "slip", "free-slip");
            default(wall, "velocity", zero.clone());
        }
    }
    let of_structure = table.get_mut("structure").and_then(Value::as_table_mut);
    let mut spacing = spacing;
    if let Some(structure) = of_structure {
        spacing = structure["particle_spacing"].clone();
        let cut = each(structure, "clamp").filter(|clamp| clamp.contains_key("circle"));
        let cut: Vec<_> = cut.filter_map(|clamp| clamp.get("body").cloned()).collect();
        for body in each(structure, "body") {
            let is_cut = body.get("name").is_some_and(|name| cut.contains(name));
            let has = |key| body.get(key).and_then(Value::as_float).is_some_and(|number| number != 0.0);
            let off_lattice = dimension == 2 && (is_cut || has("lattice_angle") || has("jitter"));
            default(body, "relaxation", if off_lattice { RELAXATION } else { 0 });
            default(body, "velocity", zero.clone());
        }
        for load in each(structure, "load") {
            default(load, "ramp", vec![vec![0.0, 1.0]]);
        }
    }
    for (what, owner, list) in [("structure", "structure", "body"), ("wall", "fluid", "wall")] {
        let things = table.get(owner).and_then(|owner| owner.get(list)?.as_array());
        let Some([only]) = things.map(Vec::as_slice) else { continue };
        let name = only["name"].clone();
        for probe in each(table, "probe").filter(|probe| probe["on"].as_str() == Some(what)) {
            default(probe, list, name.clone());
        }
    }
    for reference in each(table, "reference") {
        for border in ["low", "high"] {
            default(reference, border, reference["value"].clone());
        }
    }
    let written = table.get("coupling").and_then(Value::as_table).cloned();
    if written.is_some() || (table.contains_key("fluid") && table.contains_key("structure")) {
        let coupling = coupling::resolve(&written.unwrap_or_default(), number(&interval), number(&spacing));
        table.insert("coupling".to_owned(), to_table(&coupling).into());
    }
}

fn number(value: &Value) -> f64 {
    value.as_float().expect("it is a number")
}

fn default(table: &mut Table, key: &str, value: impl Into<Value>) {
    if !table.contains_key(key) {
        table.insert(key.to_owned(), value.into());
    }
}

/// The tables of a list.
fn each<'t>(table: &'t mut Table, list: &str) -> impl Iterator<Item = &'t mut Table> {
    let list = table.get_mut(list).and_then(Value::as_array_mut);
    list.into_iter().flatten().filter_map(Value::as_table_mut)
}

/// √(g H), H the extent of all regions along gravity; without gravity the greatest speed at the start, 0
/// where all is at rest or there are no regions, as of a fluid that is not ours.
pub(super) fn characteristic_speed(fluid: &Fluid, gravity: &[f64]) -> f64 {
    let g = gravity.iter().map(|x| x * x).sum::<f64>().sqrt();
    // A NaN, for a gravity that the check found wrong, goes this way too and comes out as NaN.
    if g != 0.0 && !fluid.regions.is_empty() {
        // The corners of a box reach furthest along g where each coordinate does.
        let reach = |bounds: &AxisBox, far: bool| -> f64 {
            gravity
                .iter()
                .zip(bounds.low.iter().zip(&bounds.high))
                .map(|(gi, (low, high))| if (*gi > 0.0) == far { gi * high } else { gi * low })
                .sum::<f64>()
                / g
        };
        let shapes: Vec<AxisBox> = fluid.regions.iter().filter_map(Region::shape).collect();
        let low = shapes.iter().map(|bounds| reach(bounds, false)).fold(f64::INFINITY, f64::min);
        let high = shapes.iter().map(|bounds| reach(bounds, true)).fold(f64::NEG_INFINITY, f64::max);
        (g * (high - low)).sqrt()
    } else {
        fluid.regions.iter().map(Region::greatest_speed).fold(0.0, f64::max)
    }
}
