//! Reference values of a case: the `[[reference]]` tables of the `case.toml` that a run leaves.

use crate::error::{Result, parse_error, read_error};
use crate::files;
use std::path::Path;

/// Values of others for one column of `probes.csv`, in the column's unit.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reference {
    /// Column, for example `tip.ux`.
    pub probe: String,
    /// What the legend says.
    pub label: String,
    /// Where the values are from.
    pub source: String,
    /// Times in s, and the values at them.
    pub time: Vec<f64>,
    pub value: Vec<f64>,
    /// Range of each value, where the source gives one; of the length of `time` then.
    pub range: Option<Vec<(f64, f64)>>,
}

/// What the report takes from `case.toml`.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Case {
    /// `title`, `case.title`, `name` or `case.name`, whichever is there first.
    pub title: Option<String>,
    pub references: Vec<Reference>,
}

/// Reads the case.
///
/// # Errors
/// [`crate::Error::Read`] if it cannot be read; [`crate::Error::Parse`] if it is no TOML, or a reference
/// lacks its `probe`, `time` or `value`, or their lengths differ.
pub(crate) fn read_case(path: &Path) -> Result<Case> {
    let text = files::read_text(path, files::WORDS).map_err(read_error(path))?;
    let table: toml::Table =
        text.parse().map_err(|error: toml::de::Error| parse_error(path, error.to_string()))?;
    let inner = table.get("case").and_then(toml::Value::as_table);
    let title = ["title", "name"].iter().find_map(|key| {
        [Some(&table), inner].into_iter().flatten().find_map(|t| Some(t.get(*key)?.as_str()?.to_owned()))
    });
    let empty = Vec::new();
    let tables = table.get("reference").map_or(Some(&empty), toml::Value::as_array);
    let references = tables
        .ok_or("`reference` is no list of tables; write it as [[reference]]".to_owned())
        .and_then(|tables| tables.iter().enumerate().map(|(index, value)| reference(index, value)).collect())
        .map_err(|reason| parse_error(path, reason))?;
    Ok(Case { title, references })
}

fn reference(index: usize, value: &toml::Value) -> std::result::Result<Reference, String> {
    let text = |key: &str| value.get(key).and_then(toml::Value::as_str).map(str::to_owned);
    let probe = text("probe").ok_or(format!("[[reference]] {} has no `probe`", index + 1))?;
    let numbers = |key: &str| -> std::result::Result<Option<Vec<f64>>, String> {
        let Some(list) = value.get(key) else { return Ok(None) };
        let number = |v: &toml::Value| v.as_float().or_else(|| v.as_integer().map(|i| i as f64));
        let list = list.as_array().and_then(|list| list.iter().map(number).collect::<Option<Vec<f64>>>());
        list.map(Some).ok_or(format!("[[reference]] for `{probe}`: `{key}` is no list of numbers"))
    };
    let missing = |key: &str| format!("[[reference]] for `{probe}` has no `{key}`");
    let time = numbers("time")?.ok_or(missing("time"))?;
    let value = numbers("value")?.ok_or(missing("value"))?;
    let (low, high) = (numbers("low")?, numbers("high")?);
    for (key, list) in [("value", Some(&value)), ("low", low.as_ref()), ("high", high.as_ref())] {
        if let Some(list) = list.filter(|list| list.len() != time.len()) {
            let (found, expected) = (list.len(), time.len());
            return Err(format!("[[reference]] for `{probe}`: {found} in `{key}`, {expected} in `time`"));
        }
    }
    // One bound alone: the value itself is the other.
    let range = (low.is_some() || high.is_some()).then(|| {
        let (low, high) = (low.unwrap_or_else(|| value.clone()), high.unwrap_or_else(|| value.clone()));
        low.into_iter().zip(high).collect()
    });
    let label = text("label").unwrap_or_else(|| "reference".to_owned());
    Ok(Reference { probe, label, source: text("source").unwrap_or_default(), time, value, range })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Case> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("case.toml");
        std::fs::write(&path, text).unwrap();
        read_case(&path)
    }

    #[test]
    fn references_are_read_with_ranges_and_whole_numbers() {
        let case = read(
            "title = \"Gate\"\n[[reference]]\nprobe = \"tip.ux\"\nlabel = \"experiment\"\nsource = \"Antoci 2007\"\n\
             time = [0, 0.04]\nvalue = [0, 0.013]\nlow = [0, 0.0125]\nother = true\n",
        )
        .unwrap();
        assert_eq!(case.title.as_deref(), Some("Gate"));
        assert_eq!(case.references[0].time, [0.0, 0.04]);
        assert_eq!(case.references[0].range, Some(vec![(0.0, 0.0), (0.0125, 0.013)]));
        assert_eq!(read("[case]\nname = \"n\"").unwrap().title.as_deref(), Some("n"));
    }

    #[test]
    fn mistakes_are_named() {
        for (text, part) in [
            ("[[reference]]\ntime = [1]", "no `probe`"),
            ("[[reference]]\nprobe = \"a.b\"\ntime = [1]", "`a.b` has no `value`"),
            ("[[reference]]\nprobe = \"a.b\"\ntime = [1]\nvalue = [1, 2]", "2 in `value`, 1 in `time`"),
            ("[[reference]]\nprobe = \"a.b\"\ntime = [\"x\"]\nvalue = [1]", "`time` is no list"),
            ("reference = 3", "[[reference]]"),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
