//! `[fluid.numerics]`: [`Options`] as a section of the case.

use crate::isph::options::{Options, Scheme};
use interfaces::case::section::{Json, Sections, and_with, laid_over, schema_of, to_table};
use interfaces::case::{Case, Findings};
use toml::Table;

/// What this solver brings to the case file.
pub const SECTIONS: Sections = Sections { schemas: &[("fluid.numerics", schema)], resolve };

fn schema() -> Json {
    let schema = schema_of::<Options>(&to_table(&Options::default()));
    let mut paper = to_table(&Options::paper());
    paper.remove("scheme");
    and_with(schema, "scheme = \"paper\"", &paper)
}

/// The options of a section in which keys may be left out: they are as the scheme has them.
///
/// # Errors
/// A key or value that is none; a checked case has none.
pub fn options(written: &Table) -> Result<Options, toml::de::Error> {
    let of_scheme = match laid_over::<Options>(&to_table(&Options::default()), written)?.scheme {
        Scheme::EnergyConsistent => Options::default(),
        Scheme::Paper => Options::paper(),
    };
    laid_over(&to_table(&of_scheme), written)
}

fn resolve(file: &mut Case, findings: &mut Findings) {
    let Some(fluid) = &mut file.fluid else { return };
    let options = match options(&fluid.numerics) {
        Ok(options) => options,
        Err(error) => return findings.add("fluid.numerics", error.message(), "compare it with the schema"),
    };
    fluid.numerics = to_table(&options);
    // Under a spacing a particle has no neighbour, and over three it has over a hundred.
    if options.smoothing_ratio < 0.5 || options.smoothing_ratio > 3.0 {
        findings.add("fluid.numerics.smoothing_ratio", "must be 0.5 to 3", "take 1.2 to 1.5");
    }
    let (lower, upper) = options.surface_thresholds;
    if lower >= upper {
        findings.add("fluid.numerics.surface_thresholds", "do not grow", "write the lower threshold first");
    }
    // Two supports of a kernel, so that a pair of particles meets once.
    let least = 4.0 * options.smoothing_ratio * fluid.particle_spacing;
    for (i, axis) in fluid.periodic.iter().enumerate() {
        let (low, high) = (fluid.domain.low.get(axis.index()), fluid.domain.high.get(axis.index()));
        let length = low.zip(high).map(|(low, high)| high - low);
        if let Some(length) = length.filter(|length| *length < least) {
            findings.add(
                format!("fluid.periodic.{i}"),
                format!("fluid.domain is too short to repeat: {length} m"),
                format!("take at least four smoothing lengths, {least} m"),
            );
        }
    }
}
