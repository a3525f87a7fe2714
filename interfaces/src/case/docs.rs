//! The tables of keys in `docs/case-file.md`, made of the schema.
//!
//! A line `<!-- keys of fluid.region -->` of the page begins a table, `<!-- end of keys -->` ends it; what is
//! between them is made anew.

use super::schema::{Kind, Node};
use serde_json::Value;
use std::fmt::Write as _;

const BEGIN: &str = "<!-- keys of ";
const END: &str = "<!-- end of keys -->";

/// The page with all its tables made anew.
///
/// # Errors
/// A table of a section that the schema has not, or without an end.
pub fn filled(page: &str, schema: &Value) -> Result<String, String> {
    let mut made = String::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        made.push_str(line);
        made.push('\n');
        let Some(place) = line.strip_prefix(BEGIN).and_then(|rest| rest.strip_suffix(" -->")) else {
            continue;
        };
        let node = section(schema, place).ok_or(format!("the schema has no section {place}"))?;
        let _ = write!(made, "\n{}\n{END}\n", table(node));
        lines.by_ref().find(|line| *line == END).ok_or(format!("the table of {place} has no end"))?;
    }
    Ok(made)
}

/// The table at a place such as `fluid.region`, elements of a list for the list.
fn section<'s>(schema: &'s Value, place: &str) -> Option<Node<'s>> {
    let mut node = Node::root(schema);
    for key in place.split('.') {
        node = node.property(key)?;
        while let Some(inner) = match node.kind() {
            Kind::List(element) => Some(element),
            Kind::OneOf(choices) => choices.into_iter().find(|choice| matches!(choice.kind(), Kind::Table)),
            _ => None,
        } {
            node = inner;
        }
    }
    matches!(node.kind(), Kind::Table).then_some(node)
}

fn table(node: Node<'_>) -> String {
    let required: Vec<_> = node.required().collect();
    let mut table = "| key | meaning | default |\n|---|---|---|\n".to_owned();
    for key in node.keys() {
        let property = node.property(key).expect("it is one of its keys");
        let default = if required.contains(&key) { "must be there".to_owned() } else { default(property) };
        let _ = writeln!(table, "| `{key}` | {} | {default} |", meaning(property));
    }
    table
}

/// What the key is, its words and its range.
fn meaning(node: Node<'_>) -> String {
    let mut text = node.description().trim_end_matches('.').to_owned();
    let element = match node.kind() {
        Kind::List(element) => element,
        _ => node,
    };
    let described = |word: &str, meaning: &str| match meaning.trim_end_matches('.') {
        "" => format!("`{word}`"),
        meaning => format!("`{word}`: {meaning}"),
    };
    let mut parts: Vec<_> =
        element.words().into_iter().map(|(word, text)| described(&format!("\"{word}\""), text)).collect();
    // A small table has none of its own in the page.
    if matches!(element.kind(), Kind::Table) && element.keys().count() <= 2 {
        let of_key = |key| element.property(key).map_or("", |property| property.description());
        parts.extend(element.keys().map(|key| described(key, of_key(key))));
    }
    if !parts.is_empty() {
        let _ = write!(text, ". {}", parts.join("; "));
    }
    if let Some(range) = node.range().filter(|range| !text.contains(range)) {
        let _ = write!(text, "; {range}");
    }
    text.replace('|', "\\|")
}

fn default(node: Node<'_>) -> String {
    let Some(value) = node.default() else { return String::new() };
    let mut text = shown(value);
    for (word, other) in node.other_defaults() {
        let _ = write!(text, "; {} with `{word}`", shown(other));
    }
    text
}

fn shown(value: &Value) -> String {
    match value {
        Value::Array(list) if list.is_empty() => "none".to_owned(),
        Value::Object(_) => String::new(),
        value => format!("`{value}`"),
    }
}
