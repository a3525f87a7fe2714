//! What is other in a case than in an earlier one of the same run.

use super::keys::Case;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use toml::{Table, Value};

/// Keys, and sections, that change no result: a run may go on with others.
const FREE: [&str; 11] = [
    "case.title",
    "case.end_time",
    "case.output_interval",
    "case.record_interval",
    "case.threads",
    "checkpoints",
    "coupling.deadline",
    "coupling.share_core",
    "fluid.participant",
    "structure.participant",
    "reference",
];

/// Keys, and sections, that decide what a state consists of.
const OF_STATE: [&str; 16] = [
    "case.dimension",
    "case.particle_spacing",
    "coupling.acceleration.method",
    "coupling.extrapolation",
    "coupling.fluid_mapping",
    "coupling.mapping",
    "coupling.scheme",
    "coupling.steady_state",
    "fluid.domain",
    "fluid.particle_spacing",
    "fluid.region",
    "motion",
    "probe",
    "structure.body",
    "structure.clamp",
    "structure.particle_spacing",
];

/// A key that has another value than before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// Its path: `coupling.relaxation`, `probe.0.name`.
    pub key: String,
    /// Its value before, as the case file has it; nothing where there was none.
    pub before: Option<String>,
    /// Its value now.
    pub now: Option<String>,
}

impl Change {
    /// Whether no result depends on it.
    pub fn is_free(&self) -> bool {
        FREE.iter().any(|free| self.is_below(free))
    }

    /// Whether a state from before is none of the case now.
    pub fn is_of_state(&self) -> bool {
        // A body's own material is none of it, as that of all bodies is not.
        let mut words = self.key.strip_prefix("structure.body.").unwrap_or("").split('.');
        OF_STATE.iter().any(|key| self.is_below(key)) && words.nth(1) != Some("material")
    }

    fn is_below(&self, key: &str) -> bool {
        self.key.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = |value: &Option<String>| value.clone().unwrap_or_else(|| "left out".to_owned());
        write!(f, "{} = {} (was {})", self.key, word(&self.now), word(&self.before))
    }
}

impl Case {
    /// The keys that are other than in `earlier`, a case as resolved ([`Case::to_toml`]), in their order.
    ///
    /// # Errors
    /// A text that is no TOML.
    pub fn changes_since(&self, earlier: &str) -> Result<Vec<Change>, String> {
        let earlier: Table = earlier.parse().map_err(|error: toml::de::Error| error.message().to_owned())?;
        let now: Table = self.to_toml().parse().expect("a case reads back");
        let (mut before, mut after) = (BTreeMap::new(), BTreeMap::new());
        flatten("", &Value::Table(earlier), &mut before);
        flatten("", &Value::Table(now), &mut after);
        let keys: BTreeSet<&String> = before.keys().chain(after.keys()).collect();
        let changed = keys.into_iter().filter(|key| before.get(*key) != after.get(*key));
        let change = |key: &String| Change {
            key: key.clone(),
            before: before.get(key).cloned(),
            now: after.get(key).cloned(),
        };
        Ok(changed.map(change).collect())
    }
}

/// Every value that is no table, by its path; lists of tables by the number of the element.
fn flatten(path: &str, value: &Value, flat: &mut BTreeMap<String, String>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        Value::Table(table) => table.iter().for_each(|(key, value)| flatten(&below(key), value, flat)),
        Value::Array(list) if list.iter().any(Value::is_table) => {
            list.iter()
                .enumerate()
                .for_each(|(index, value)| flatten(&below(&index.to_string()), value, flat));
        }
        _ => {
            flat.insert(path.to_owned(), value.to_string());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Change;

    #[test]
    fn a_branch_may_have_other_materials_and_no_other_bodies() {
        let of_state = |key: &str| Change { key: key.to_owned(), before: None, now: None }.is_of_state();
        assert!(of_state("structure.body.0.box.low") && of_state("structure.body.1.name"));
        assert!(!of_state("structure.body.0.material.youngs_modulus"));
        assert!(!of_state("structure.material.youngs_modulus"));
    }
}
