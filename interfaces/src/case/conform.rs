//! Holds the table of a case against the schema: unknown keys, missing keys, wrong types, words that are
//! none, numbers out of their range.
//!
//! So that one mistake does not hide the others, what is wrong is mended in passing: a misspelt key is
//! renamed, a word becomes one of those allowed, and a number becomes NaN, which every later check takes for
//! "not known". Where that cannot be done the later checks have nothing to stand on.

use super::document::join;
use super::errors::CaseError;
use super::nearest::nearest;
use super::schema::{Kind, Node};
use toml::{Table, Value};

/// What came of it.
pub(super) struct Conformity {
    /// The mistakes.
    pub errors: Vec<CaseError>,
    /// Misspelt keys, and the keys that they were taken for.
    pub renamed: Vec<(String, String)>,
    /// Whether the mended table is a case as typed, and can be checked further.
    pub usable: bool,
}

/// Holds the table against the schema and mends it.
pub(super) fn conform(table: &mut Table, schema: &serde_json::Value) -> Conformity {
    let dimension = table.get("case").and_then(|case| case.get("dimension")?.as_integer());
    let dimension = dimension.and_then(|d| usize::try_from(d).ok()).filter(|d| (2..=3).contains(d));
    let mut walk = Walk { errors: Vec::new(), renamed: Vec::new(), root: Node::root(schema), dimension };
    let usable = walk.table(table, walk.root, "");
    Conformity { errors: walk.errors, renamed: walk.renamed, usable }
}

/// Largest number of a case: that of any quantity in SI units is smaller, and powers and products of a few
/// such numbers are finite.
const LARGEST: f64 = 1e30;

struct Walk<'s> {
    errors: Vec<CaseError>,
    renamed: Vec<(String, String)>,
    root: Node<'s>,
    /// Of space, if the case says one that it can have.
    dimension: Option<usize>,
}

impl<'s> Walk<'s> {
    fn report(&mut self, key: &str, problem: impl Into<String>, remedy: impl Into<String>) {
        self.errors.push(CaseError::new(key, problem, remedy));
    }

    /// Each of these says whether the value can be read as typed afterwards.
    fn table(&mut self, table: &mut Table, node: Node<'s>, key: &str) -> bool {
        if node.is_open() {
            return true;
        }
        let mut usable = true;
        for unknown in table.keys().filter(|k| node.property(k).is_none()).cloned().collect::<Vec<_>>() {
            let value = table.remove(&unknown).expect("it was just listed");
            let meant = nearest(&unknown, node.keys());
            self.report(&join(key, &unknown), "there is no such key", self.remedy_for(&unknown, meant, node));
            if let Some(meant) = meant.filter(|meant| !table.contains_key(*meant)) {
                table.insert(meant.to_owned(), value);
                self.renamed.push((join(key, &unknown), join(key, meant)));
            }
        }
        for (name, value) in table.iter_mut() {
            let property = node.property(name).expect("unknown keys were removed");
            usable &= self.value(value, property, &join(key, name));
        }
        for required in node.required() {
            if table.contains_key(required) {
                continue;
            }
            let property = node.property(required).expect("a required key is a property");
            self.report(&join(key, required), "is missing", format!("add it; {}", meaning(property)));
            match placeholder(property) {
                Some(value) => {
                    table.insert(required.to_owned(), value);
                }
                None => usable = false,
            }
        }
        usable
    }

    fn remedy_for(&self, unknown: &str, meant: Option<&str>, node: Node<'s>) -> String {
        if let Some(meant) = meant {
            return format!("did you mean \"{meant}\"?");
        }
        let mut elsewhere = Vec::new();
        places(self.root, unknown, "", &mut elsewhere);
        if (1..=2).contains(&elsewhere.len()) {
            return format!("there is {}", elsewhere.join(" and "));
        }
        format!("the keys here are {}", node.keys().collect::<Vec<_>>().join(", "))
    }

    fn value(&mut self, value: &mut Value, node: Node<'s>, key: &str) -> bool {
        match (node.kind(), &mut *value) {
            (Kind::OneOf(choices), _) => match choices.iter().find(|choice| fits(value, **choice)) {
                Some(choice) => self.value(value, *choice, key),
                None => self.wrong_type(value, node, key),
            },
            (Kind::Table, Value::Table(table)) => self.table(table, node, key),
            (Kind::List(element), Value::Array(list)) => self.list(list, node, element, key),
            (Kind::Number, Value::Float(number)) => {
                let number = *number;
                if !self.in_range(number, node, key) {
                    *value = Value::Float(f64::NAN);
                }
                true
            }
            (Kind::Number, Value::Integer(number)) => {
                let number = *number as f64;
                *value = Value::Float(if self.in_range(number, node, key) { number } else { f64::NAN });
                true
            }
            (Kind::Integer, Value::Integer(number)) => {
                let number = *number;
                self.integer(number, node, key).is_none_or(|mended| {
                    *value = Value::Integer(mended);
                    node.allowed().is_none()
                })
            }
            (Kind::Words(words), Value::String(word)) => {
                if !words.contains(&word.as_str()) {
                    let remedy = match nearest(word, words.iter().copied()) {
                        Some(meant) => format!("did you mean \"{meant}\"?"),
                        None => "take one of them".to_owned(),
                    };
                    self.report(key, format!("is none of {}", quoted(&words)), remedy);
                    words[0].clone_into(word);
                }
                true
            }
            (Kind::Text, Value::String(_)) | (Kind::Boolean, Value::Boolean(_)) => true,
            _ => self.wrong_type(value, node, key),
        }
    }

    fn list(&mut self, list: &mut Vec<Value>, node: Node<'s>, element: Node<'s>, key: &str) -> bool {
        let length = list.len() as f64;
        if node.bound("minItems").is_some_and(|least| length < least)
            || node.bound("maxItems").is_some_and(|most| length > most)
        {
            // Lists of fixed length only: pairs.
            let expected = node.bound("minItems").expect("a generated schema bounds both or neither");
            self.report(key, format!("has {length} elements, but must have {expected}"), meaning(node));
            return false;
        }
        if let Some(d) = self.dimension.filter(|d| node.is_per_axis() && list.len() != *d) {
            let (elements, unknown) = match element.kind() {
                Kind::Number => ("numbers", Value::Float(f64::NAN)),
                _ => ("rows", vec![f64::NAN; d].into()),
            };
            let problem = format!("has {} {elements} in {d} dimensions", list.len());
            self.report(key, problem, format!("write {d} {elements}"));
            *list = vec![unknown; d];
            return true;
        }
        let mut usable = true;
        for (index, value) in list.iter_mut().enumerate() {
            usable &= self.value(value, element, &join(key, &index.to_string()));
        }
        usable
    }

    fn in_range(&mut self, number: f64, node: Node<'s>, key: &str) -> bool {
        let (least, over) = (node.bound("minimum"), node.bound("exclusiveMinimum"));
        let (most, under) = (node.bound("maximum"), node.bound("exclusiveMaximum"));
        let inside = number.abs() <= LARGEST
            && least.is_none_or(|bound| number >= bound)
            && over.is_none_or(|bound| number > bound)
            && most.is_none_or(|bound| number <= bound)
            && under.is_none_or(|bound| number < bound);
        if !inside {
            let bounds = node.range().filter(|_| number.abs() <= LARGEST);
            let bounds = bounds.unwrap_or_else(|| match number.is_finite() {
                true => format!("at most {LARGEST:e} in size"),
                false => "finite".to_owned(),
            });
            self.report(key, format!("must be {bounds}"), meaning(node));
        }
        inside
    }

    /// A stand-in where the number will not do.
    fn integer(&mut self, number: i64, node: Node<'s>, key: &str) -> Option<i64> {
        if let Some(allowed) = node.allowed() {
            if allowed.contains(&number) {
                return None;
            }
            let allowed: Vec<_> = allowed.iter().map(ToString::to_string).collect();
            self.report(key, format!("must be {}", allowed.join(" or ")), meaning(node));
            return Some(number);
        }
        let least = node.bound("minimum").unwrap_or(0.0);
        let most = node.bound("maximum").unwrap_or(f64::from(u32::MAX));
        if (least..=most).contains(&(number as f64)) {
            return None;
        }
        let bounds =
            if (number as f64) < least { format!("at least {least}") } else { format!("at most {most}") };
        self.report(key, format!("must be {bounds}"), meaning(node));
        Some(least as i64)
    }

    fn wrong_type(&mut self, value: &mut Value, node: Node<'s>, key: &str) -> bool {
        let expected = expectation(node);
        let problem = match (node.kind(), &*value) {
            // A word where a word may stand, but not this one.
            (Kind::OneOf(_), Value::String(_)) => format!("must be {expected}"),
            (_, value) => format!("is {}, but must be {expected}", type_name(value)),
        };
        self.report(key, problem, meaning(node));
        match placeholder(node) {
            Some(mended) => {
                *value = mended;
                true
            }
            None => false,
        }
    }
}

/// What may stand in for a value that is missing or wrong without leading the later checks astray.
fn placeholder(node: Node<'_>) -> Option<Value> {
    match node.kind() {
        Kind::Number => Some(Value::Float(f64::NAN)),
        Kind::Words(words) => Some(Value::String(words[0].to_owned())),
        _ => None,
    }
}

fn fits(value: &Value, node: Node<'_>) -> bool {
    match node.kind() {
        Kind::Table => value.is_table(),
        Kind::List(_) => value.is_array(),
        Kind::Number => value.is_float() || value.is_integer(),
        Kind::Integer => value.is_integer(),
        Kind::Boolean => value.is_bool(),
        Kind::Text => value.is_str(),
        Kind::Words(words) => value.as_str().is_some_and(|word| words.contains(&word)),
        Kind::OneOf(choices) => choices.iter().any(|choice| fits(value, *choice)),
    }
}

fn expectation(node: Node<'_>) -> String {
    match node.kind() {
        Kind::Table => {
            let keys: Vec<_> = node.required().collect();
            if keys.is_empty() {
                "a section".to_owned()
            } else {
                format!("a section with {}", keys.join(", "))
            }
        }
        Kind::List(element) => match element.kind() {
            Kind::Table => "a list of sections [[...]]".to_owned(),
            Kind::Number => "a list of numbers".to_owned(),
            Kind::Text => "a list of strings".to_owned(),
            _ => "a list of lists of numbers".to_owned(),
        },
        Kind::Number => "a number".to_owned(),
        Kind::Integer => "a whole number".to_owned(),
        Kind::Boolean => "true or false".to_owned(),
        Kind::Text => "a string".to_owned(),
        Kind::Words(words) if words.len() == 1 => quoted(&words),
        Kind::Words(words) => format!("one of {}", quoted(&words)),
        Kind::OneOf(choices) => {
            choices.iter().map(|choice| expectation(*choice)).collect::<Vec<_>>().join(" or ")
        }
    }
}

fn type_name(value: &Value) -> &'static str {
    match value {
        Value::String(_) => "a string",
        Value::Integer(_) => "a whole number",
        Value::Float(_) => "a number",
        Value::Boolean(_) => "true or false",
        Value::Datetime(_) => "a date",
        Value::Array(_) => "a list",
        Value::Table(_) => "a section",
    }
}

fn quoted(words: &[&str]) -> String {
    words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ")
}

/// What the key is, for one who has to mend it.
fn meaning(node: Node<'_>) -> String {
    let mut letters = node.description().trim_end_matches('.').chars();
    let first = letters.next().into_iter().flat_map(char::to_lowercase);
    format!("its meaning: {}", first.chain(letters).collect::<String>())
}

/// Where else in the schema a key of this name is.
fn places(node: Node<'_>, name: &str, at: &str, found: &mut Vec<String>) {
    match node.kind() {
        Kind::Table => {
            for key in node.keys() {
                let path = join(at, key);
                if key == name {
                    found.push(path.clone());
                }
                places(node.property(key).expect("it is one of its keys"), name, &path, found);
            }
        }
        Kind::List(element) => places(element, name, at, found),
        _ => {}
    }
}
