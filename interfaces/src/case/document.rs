//! The text of a case as a table that still knows its lines, and what `--set` makes of it.

use super::errors::CaseError;
use std::collections::{BTreeMap, BTreeSet};
use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

/// A parsed case file. Keys are paths (`fluid.wall.0.slip`), elements of lists by their index.
#[derive(Debug)]
pub(super) struct Document {
    /// The content, overrides applied.
    pub table: Table,
    /// Line of each key, from 1.
    lines: BTreeMap<String, usize>,
    /// Keys that came from an override.
    overridden: BTreeSet<String>,
}

impl Document {
    /// Parses the text; the errors are those of TOML's grammar, several where the parser finds its way again.
    pub fn parse(text: &str) -> Result<Self, Vec<CaseError>> {
        let (tree, errors) = DeTable::parse_recoverable(text);
        let starts = LineStarts::of(text);
        let mut errors: Vec<_> = errors
            .iter()
            .map(|error| CaseError {
                line: error.span().map(|span| starts.line(span.start)),
                ..CaseError::new("", format!("is not TOML: {}", error.message()), "mend the line")
            })
            .collect();
        // A line with two faults is reported once: what follows a fault in its line is seldom a second one.
        errors.dedup_by_key(|error| error.line);
        if !errors.is_empty() {
            return Err(errors);
        }
        let table = toml::from_str(text).map_err(|error: toml::de::Error| {
            let line = error.span().map(|span| starts.line(span.start));
            let error = CaseError::new("", format!("is not TOML: {}", error.message()), "mend the line");
            vec![CaseError { line, ..error }]
        })?;
        let mut lines = BTreeMap::new();
        lines_of_table(tree.get_ref(), "", &starts, &mut lines);
        Ok(Self { table, lines, overridden: BTreeSet::new() })
    }

    /// Sets a key from `section.key=value`. The value is TOML; what is not, is taken as a word. Elements of
    /// lists go by index or by name.
    pub fn set(&mut self, assignment: &str) -> Result<(), CaseError> {
        let fail = |key: &str, problem: String, remedy: String| CaseError {
            overridden: true,
            ..CaseError::new(key, problem, remedy)
        };
        let Some((path, text)) = assignment.split_once('=') else {
            let problem = format!("\"{assignment}\" has no \"=\"");
            return Err(fail("", problem, "write --set section.key=value".to_owned()));
        };
        let segments: Vec<_> = path.split('.').map(str::trim).collect();
        if segments.iter().any(|segment| segment.is_empty()) {
            let problem = format!("\"{path}\" is no key");
            return Err(fail("", problem, "write --set section.key=value".to_owned()));
        }
        let mut key = String::new();
        let mut at = Slot::Table(&mut self.table);
        for (i, segment) in segments.iter().enumerate() {
            let index = at.index_of(segment).map_err(|(problem, remedy)| fail(&key, problem, remedy))?;
            key = join(&key, &index);
            if i + 1 == segments.len() {
                at.put(&index, parse_value(text.trim()));
                break;
            }
            at = at.enter(&index).map_err(|(problem, remedy)| fail(&key, problem, remedy))?;
        }
        self.overridden.insert(key);
        Ok(())
    }

    /// A key that was taken for another: what is found wrong with the other is told with the line and origin
    /// of the key as written.
    pub fn take_for(&mut self, written: &str, meant: &str) {
        if let Some(line) = self.lines.get(written) {
            self.lines.insert(meant.to_owned(), *line);
        }
        if self.overridden.contains(written) {
            self.overridden.insert(meant.to_owned());
        }
    }

    /// Fills in lines, origins and values of errors from their keys, in the order of the lines.
    pub fn locate_all(&self, errors: Vec<CaseError>) -> Vec<CaseError> {
        let mut errors: Vec<_> = errors.into_iter().map(|error| self.locate(error)).collect();
        errors.sort_by_key(|error| (error.overridden, error.line));
        errors
    }

    fn locate(&self, mut error: CaseError) -> CaseError {
        if error.key.is_empty() {
            return error;
        }
        let value = self.value(&error.key);
        error.overridden |= prefixes(&error.key).any(|prefix| self.overridden.contains(prefix));
        error.line =
            error.line.or_else(|| prefixes(&error.key).find_map(|prefix| self.lines.get(prefix).copied()));
        error.value = error.value.or_else(|| value.filter(|value| !value.is_table()).map(shown));
        error
    }

    fn value(&self, key: &str) -> Option<&Value> {
        let mut segments = key.split('.');
        let mut value = self.table.get(segments.next()?)?;
        for segment in segments {
            value = match value {
                Value::Table(table) => table.get(segment)?,
                Value::Array(list) => list.get(segment.parse::<usize>().ok()?)?,
                _ => return None,
            };
        }
        Some(value)
    }
}

/// A key and the keys it lies in, the longest first.
fn prefixes(key: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(Some(key), |key| key.rfind('.').map(|end| &key[..end]))
}

/// `parent.child`, or the child alone at the root.
pub(super) fn join(parent: &str, child: &str) -> String {
    if parent.is_empty() { child.to_owned() } else { format!("{parent}.{child}") }
}

/// The value as one writes it in TOML, cut where it is long.
fn shown(value: &Value) -> String {
    // A decimal number of hundreds of digits is none that people read.
    if let Value::Float(number) = value
        && *number != 0.0
        && number.is_finite()
        && !(1e-6..1e15).contains(&number.abs())
    {
        return format!("{number:e}");
    }
    const LONGEST: usize = 60;
    let text = match value {
        Value::Array(list) if list.first().is_some_and(Value::is_table) => {
            format!("({} sections)", list.len())
        }
        value => value.to_string(),
    };
    if text.chars().count() <= LONGEST {
        text
    } else {
        text.chars().take(LONGEST).chain("...".chars()).collect()
    }
}

fn parse_value(text: &str) -> Value {
    let parsed: Result<Table, _> = toml::from_str(&format!("value = {text}"));
    match parsed {
        Ok(mut table) if table.len() == 1 => {
            table.remove("value").expect("it is the one key that was written")
        }
        _ => Value::String(text.to_owned()),
    }
}

/// Where an override's path has come to.
enum Slot<'a> {
    Table(&'a mut Table),
    List(&'a mut Vec<Value>),
}

impl<'a> Slot<'a> {
    /// The key or index that a segment means here.
    fn index_of(&self, segment: &str) -> Result<String, (String, String)> {
        let Self::List(list) = self else { return Ok(segment.to_owned()) };
        let name = |value: &Value| value.get("name").and_then(Value::as_str).map(str::to_owned);
        let by_index = segment.parse::<usize>().ok().filter(|index| *index < list.len());
        let index = list.iter().position(|value| name(value).as_deref() == Some(segment)).or(by_index);
        index.map(|index| index.to_string()).ok_or_else(|| {
            let names: Vec<_> = list.iter().filter_map(name).map(|name| format!("\"{name}\"")).collect();
            let names = if names.is_empty() { String::new() } else { format!(", or {}", names.join(", ")) };
            let remedy = match list.len() {
                0 => "add it to the file".to_owned(),
                1 => format!("write 0{names}"),
                n => format!("write 0 to {}{names}", n - 1),
            };
            (format!("has no element \"{segment}\""), remedy)
        })
    }

    fn put(self, index: &str, value: Value) {
        match self {
            Self::Table(table) => {
                table.insert(index.to_owned(), value);
            }
            Self::List(list) => {
                let index: usize = index.parse().expect("index_of gives numbers for lists");
                list[index] = value;
            }
        }
    }

    /// Goes into an element; a section that is not there yet is made, and the check then tells what else it
    /// needs.
    fn enter(self, index: &str) -> Result<Self, (String, String)> {
        let value: &'a mut Value = match self {
            Self::Table(table) => table.entry(index.to_owned()).or_insert_with(|| Value::Table(Table::new())),
            Self::List(list) => {
                let index: usize = index.parse().expect("index_of gives numbers for lists");
                &mut list[index]
            }
        };
        match value {
            Value::Table(table) => Ok(Self::Table(table)),
            Value::Array(list) => Ok(Self::List(list)),
            other => Err((
                format!("is no section, but {other}"),
                "set the key itself, without a key below it".to_owned(),
            )),
        }
    }
}

/// Where the lines of a text begin.
struct LineStarts(Vec<usize>);

impl LineStarts {
    fn of(text: &str) -> Self {
        Self(std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect())
    }

    /// The line, from 1, of an offset.
    fn line(&self, offset: usize) -> usize {
        self.0.partition_point(|start| *start <= offset)
    }
}

fn lines_of_table(
    table: &DeTable<'_>,
    parent: &str,
    starts: &LineStarts,
    lines: &mut BTreeMap<String, usize>,
) {
    for (key, value) in table {
        let path = join(parent, key.get_ref());
        lines.insert(path.clone(), starts.line(key.span().start));
        lines_of_value(value, &path, starts, lines);
    }
}

fn lines_of_value(
    value: &Spanned<DeValue<'_>>,
    path: &str,
    starts: &LineStarts,
    lines: &mut BTreeMap<String, usize>,
) {
    match value.get_ref() {
        DeValue::Table(table) => lines_of_table(table, path, starts, lines),
        DeValue::Array(list) => {
            for (index, element) in list.iter().enumerate() {
                let path = join(path, &index.to_string());
                lines.insert(path.clone(), starts.line(element.span().start));
                lines_of_value(element, &path, starts, lines);
            }
        }
        _ => {}
    }
}
