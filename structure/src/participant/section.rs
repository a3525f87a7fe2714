//! `[structure.numerics]`, `[structure.material]`, a body's own `material` and `[structure.contact]`:
//! [`Options`], [`Material`] and [`ContactOptions`] as sections of the case.

use crate::contact::ContactOptions;
use crate::materials::{Law, Material, Plane};
use crate::options::{Gradient, Options};
use interfaces::case::participant::Start;
use interfaces::case::section::{Json, Sections, and_with, laid_over, schema_of, to_table};
use interfaces::case::structure::Structure;
use interfaces::case::{Case, Findings};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Table;

/// What this solver brings to the case file.
pub const SECTIONS: Sections = Sections {
    schemas: &[
        ("structure.numerics", numerics_schema),
        ("structure.material", material_schema),
        ("structure.body.material", own_material_schema),
        ("structure.contact", contact_schema),
    ],
    resolve,
};

/// Material of a body, or of those that name none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(extend("additionalProperties" = false))]
pub struct Elastic {
    /// The material itself.
    #[serde(flatten)]
    pub material: Material,
    /// Density in the reference configuration (kg/m³).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub density: f64,
}

fn numerics_schema() -> Json {
    let schema = schema_of::<Options>(&to_table(&Options::default()));
    let mut first_order = to_table(&Options::of(Gradient::FirstOrder));
    first_order.remove("gradient");
    and_with(schema, "gradient = \"first-order\"", &first_order)
}

fn contact_schema() -> Json {
    schema_of::<ContactOptions>(&to_table(&ContactOptions::default()))
}

fn material_schema() -> Json {
    schema_of::<Elastic>(&assumption(Plane::Strain))
}

/// As the material of all bodies, and every key may be left out.
fn own_material_schema() -> Json {
    let mut schema = schema_of::<Elastic>(&Table::new());
    if let Some(keys) = schema.as_object_mut() {
        keys.remove("required");
    }
    schema
}

fn assumption(plane: Plane) -> Table {
    to_table(&std::collections::BTreeMap::from([("assumption", plane)]))
}

/// The options of a section in which keys may be left out: they are as the gradient has them.
///
/// # Errors
/// A key or value that is none; a checked case has none.
pub fn options(written: &Table) -> Result<Options, toml::de::Error> {
    let gradient = laid_over::<Options>(&to_table(&Options::default()), written)?.gradient;
    laid_over(&to_table(&Options::of(gradient)), written)
}

/// What may meet what, of a section in which keys may be left out.
///
/// # Errors
/// A key or value that is none; a checked case has none.
pub fn contact(written: &Table) -> Result<ContactOptions, toml::de::Error> {
    laid_over(&to_table(&ContactOptions::default()), written)
}

/// The material of a section in which the assumption may be left out.
///
/// # Errors
/// A key or value that is none; a checked case has none.
pub fn material(written: &Table, dimension: usize) -> Result<Elastic, toml::de::Error> {
    let plane = if dimension == 2 { Plane::Strain } else { Plane::ThreeDimensional };
    if written.contains_key("youngs_modulus") || !law_of(written).is_some_and(Law::has_constants) {
        return laid_over(&assumption(plane), written);
    }
    // What is left out of a law with constants, until they say it.
    let mut usual = assumption(plane);
    usual.insert("youngs_modulus".to_owned(), 1.0.into());
    let mut elastic: Elastic = laid_over(&usual, written)?;
    if let Some(modulus) = elastic.material.modulus_of_constants() {
        elastic.material.youngs_modulus = modulus;
    }
    Ok(elastic)
}

/// The material of a body with one of its own, which is laid over the `common` one. A law and its stiffness
/// are one thing: a body that names another law does not take over constants, nor a modulus made of them.
///
/// # Errors
/// A key or value that is none; a checked case has none.
pub fn material_of(common: &Table, own: &Table, dimension: usize) -> Result<Elastic, toml::de::Error> {
    let from_constants = |table| law_of(table).is_some_and(Law::has_constants);
    let mut whole = common.clone();
    if own.contains_key("law") && law_of(own) != law_of(common) {
        whole.remove("constants");
        whole.remove("exponents");
    }
    if from_constants(common) || from_constants(own) {
        whole.remove("youngs_modulus");
    }
    material(&laid_over(&whole, own)?, dimension)
}

fn resolve(file: &mut Case, findings: &mut Findings) {
    let dimension = file.general.dimension;
    let Some(structure) = &mut file.structure else { return };
    let common = structure.material.clone();
    match material(&common, dimension) {
        Ok(material) => {
            structure.material = to_table(&material);
            check_material("structure.material", &material.material, dimension, findings);
        }
        Err(error) => findings.add("structure.material", error.message(), "compare it with the schema"),
    }
    for (i, body) in structure.bodies.iter().enumerate().filter(|(_, body)| !body.material.is_empty()) {
        let key = format!("structure.body.{i}.material");
        let names = |name| body.material.contains_key(name);
        if names("law") && !names("youngs_modulus") && lacks_modulus(&common, &body.material) {
            let problem = "is left out, and structure.material has it from its law's constants";
            findings.add(format!("{key}.youngs_modulus"), problem, "give it, in Pa");
            continue;
        }
        match material_of(&common, &body.material, dimension) {
            // It stays as it is written, so that the common material may still change under it.
            Ok(material) => check_material(&key, &material.material, dimension, findings),
            Err(error) => findings.add(&key, error.message(), "compare it with the schema"),
        }
    }
    match contact(&structure.contact) {
        Ok(options) => structure.contact = to_table(&options),
        Err(error) => findings.add("structure.contact", error.message(), "compare it with the schema"),
    }
    match options(&structure.numerics) {
        Ok(options) => {
            structure.numerics = to_table(&options);
            // Under half a spacing a particle has no neighbour, and over three it has over a hundred.
            if options.smoothing_ratio < 0.5 || options.smoothing_ratio > 3.0 {
                findings.add("structure.numerics.smoothing_ratio", "must be 0.5 to 3", "take 1 to 1.5");
            }
            if options.gradient == Gradient::Quadratic && structure.participant.start() == Start::Own {
                check_layers(structure, findings);
            }
            resolve_clamps(structure, options.gradient, dimension, findings);
        }
        Err(error) => findings.add("structure.numerics", error.message(), "compare it with the schema"),
    }
}

/// Whether a body's law wants a modulus that the common material has not, as its law has constants.
fn lacks_modulus(common: &Table, own: &Table) -> bool {
    law_of(common).is_some_and(Law::has_constants) && law_of(own).is_some_and(|law| !law.has_constants())
}

fn law_of(material: &Table) -> Option<Law> {
    material.get("law").and_then(|law| Law::deserialize(law.clone()).ok())
}

/// Bodies bend by the quadratic gradient only where they are three layers of particles thick.
fn check_layers(structure: &Structure, findings: &mut Findings) {
    const LEAST: f64 = 3.0;
    let spacing = structure.particle_spacing;
    for (i, body) in structure.bodies.iter().enumerate() {
        let least = body.bounds.extent().into_iter().fold(f64::INFINITY, f64::min);
        let layers = (least / spacing).round().max(1.0);
        if layers < LEAST && least >= spacing * (1.0 - 1e-9) {
            findings.add(
                format!("structure.body.{i}.box"),
                format!("is {layers} layers of particles thick, and the quadratic gradient needs {LEAST}"),
                format!(
                    "take a particle_spacing of at most {:.3e} m, or structure.numerics.gradient = \"first-order\"",
                    least / LEAST
                ),
            );
        }
    }
}

fn check_material(section: &str, material: &Material, dimension: usize, findings: &mut Findings) {
    let key = |name: &str| format!("{section}.{name}");
    match (dimension, material.assumption) {
        (2, Plane::ThreeDimensional) => {
            let remedy = "take \"plane-strain\" or \"plane-stress\"";
            return findings.add(key("assumption"), "does not fit two dimensions", remedy);
        }
        (3, Plane::Strain | Plane::Stress) => {
            let problem = "does not fit three dimensions";
            return findings.add(key("assumption"), problem, "leave it out");
        }
        _ => {}
    }
    if let Some((name, problem, remedy)) = material.wrong_constants() {
        return findings.add(key(name), problem, remedy);
    }
    if let Some(modulus) = material.modulus_of_constants()
        && (modulus / material.youngs_modulus - 1.0).abs() > 1e-9
    {
        let problem = format!("is not that of the constants, {modulus:.6e} Pa");
        return findings.add(key("youngs_modulus"), problem, "leave it out");
    }
    let ratio = material.poisson_ratio;
    if ratio <= -1.0 || ratio >= 0.5 {
        let remedy = "take 0.3 for metals, 0.4 to 0.49 for rubber";
        findings.add(key("poisson_ratio"), "must be over -1 and under 0.5", remedy);
    }
}

/// Clamps as the gradient wants them: on the face itself for the quadratic one; by rows as deep as its
/// support for the first-order one, which does not see fixed points.
fn resolve_clamps(structure: &mut Structure, gradient: Gradient, dimension: usize, findings: &mut Findings) {
    let usual = match gradient {
        Gradient::Quadratic => 0,
        Gradient::FirstOrder => 3,
    };
    for clamp in structure.clamps.iter_mut().filter(|clamp| clamp.face.is_some()) {
        clamp.rows.get_or_insert(usual);
    }
    for (i, clamp) in structure.clamps.iter().enumerate() {
        let key = format!("structure.clamp.{i}");
        let kinds = [clamp.face.is_some(), clamp.bounds.is_some(), clamp.circle.is_some()];
        if kinds.iter().filter(|is_there| **is_there).count() > 1 {
            // Two clamps in one, which is reported elsewhere.
            continue;
        }
        let mut bodies = structure.bodies.iter().filter(|body| body.name == clamp.body);
        let off_lattice = bodies.next().is_some_and(|body| body.is_off_lattice(&structure.clamps));
        if clamp.face.is_some() && clamp.rows != Some(0) && off_lattice {
            let problem = "its fixed rows would go on with a lattice that the body has not";
            findings.add(&key, problem, "take the quadratic gradient and rows = 0, or a box");
        }
        if clamp.circle.is_some() && dimension == 2 && gradient == Gradient::FirstOrder {
            let problem = "is held by fixed points, which the first-order gradient does not see";
            findings.add(format!("{key}.circle"), problem, "take the quadratic gradient, or a box");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Table, material_of};
    use crate::Law;

    const COMMON: &str = "law = 'neo-hookean'\nyoungs_modulus = 1e6\npoisson_ratio = 0.3\ndensity = 1000.0";
    const RUBBER: &str = "law = 'ogden'\nconstants = [4e5, 1e5]\nexponents = [2.0, 4.0]\npoisson_ratio = 0.49\ndensity = 1100.0";

    fn of(common: &str, own: &str) -> Result<super::Elastic, toml::de::Error> {
        let table = |text: &str| -> Table { text.parse().unwrap() };
        material_of(&table(common), &table(own), 2)
    }

    #[test]
    fn what_a_body_leaves_out_is_as_in_the_common_material() {
        assert_eq!(of(COMMON, "").unwrap(), super::material(&COMMON.parse().unwrap(), 2).unwrap());
        let stiff = of(COMMON, "youngs_modulus = 5e6").unwrap();
        assert_eq!((stiff.material.youngs_modulus, stiff.density), (5e6, 1000.0));
        assert_eq!(stiff.material.law, Law::NeoHookean);
        let other = of(COMMON, "law = 'saint-venant-kirchhoff'").unwrap();
        assert_eq!((other.material.law, other.material.youngs_modulus), (Law::StVenantKirchhoff, 1e6));
    }

    /// `E = 2 (1 + ν) μ`: `μ = 2 C₁₀` of Yeoh's law, `½ Σ μ_p α_p` of Ogden's.
    #[test]
    fn constants_and_the_modulus_made_of_them_go_with_their_law() {
        let rubber = of(COMMON, "law = 'yeoh'\nconstants = [2e5]").unwrap().material;
        assert!((rubber.youngs_modulus - 2.0 * 1.3 * 4e5).abs() < 1e-3);
        let softer = of(RUBBER, "constants = [2e5, 1e5]").unwrap().material;
        assert!((softer.youngs_modulus - 2.0 * 1.49 * 4e5).abs() < 1e-3);
        let plain = of(RUBBER, "law = 'neo-hookean'\nyoungs_modulus = 3e6").unwrap().material;
        assert!(plain.wrong_constants().is_none());
        assert!(of(RUBBER, "law = 'neo-hookean'").is_err());
    }
}
