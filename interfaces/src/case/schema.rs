//! The JSON schema of the case file, made of [`super::typed`]: for editors, and for [`super::conform`].

use super::typed::CaseFile;
use serde_json::{Map, Value, json};

/// The schema (JSON Schema 2020-12) of a `case.toml`.
pub fn schema() -> Value {
    let mut schema = schemars::schema_for!(CaseFile).to_value();
    schema["title"] = json!("meniscus case");
    without_null(&mut schema);
    schema
}

/// TOML has no null: what is optional is left out. Removes `null` from every choice of types.
fn without_null(value: &mut Value) {
    match value {
        Value::Object(node) => {
            if let Some(Value::Array(types)) = node.get_mut("type") {
                types.retain(|one| one != "null");
                if let [only] = types.as_slice() {
                    let only = only.clone();
                    node.insert("type".to_owned(), only);
                }
            }
            if let Some(Value::Array(choices)) = node.get_mut("anyOf") {
                choices.retain(|choice| choice != &json!({"type": "null"}));
                if let [Value::Object(only)] = choices.as_slice() {
                    let only = only.clone();
                    node.remove("anyOf");
                    for (key, value) in only {
                        node.entry(key).or_insert(value);
                    }
                }
            }
            if node.get("default") == Some(&Value::Null) {
                node.remove("default");
            }
            node.values_mut().for_each(without_null);
        }
        Value::Array(list) => list.iter_mut().for_each(without_null),
        _ => {}
    }
}

/// A node of the schema, with its reference followed.
#[derive(Clone, Copy)]
pub(super) struct Node<'s> {
    root: &'s Value,
    /// Where the key stands: its description.
    here: &'s Map<String, Value>,
    /// What it refers to: its type.
    target: &'s Map<String, Value>,
    /// What the list it is an element of says of itself.
    of_list: &'s str,
}

/// What a node allows.
pub(super) enum Kind<'s> {
    Table,
    List(Node<'s>),
    Number,
    Integer,
    Boolean,
    Text,
    Words(Vec<&'s str>),
    OneOf(Vec<Node<'s>>),
}

impl<'s> Node<'s> {
    /// The root of a schema.
    pub fn root(schema: &'s Value) -> Self {
        Self::new(schema, schema)
    }

    fn new(root: &'s Value, value: &'s Value) -> Self {
        let here = value.as_object().expect("every node of this schema is an object");
        let target = match here.get("$ref").and_then(Value::as_str) {
            Some(reference) => root
                .pointer(reference.trim_start_matches('#'))
                .and_then(Value::as_object)
                .expect("every reference of a generated schema has its definition"),
            None => here,
        };
        Self { root, here, target, of_list: "" }
    }

    /// What the key is, in the words of its documentation; for an element of a list that has none, what the
    /// list is.
    pub fn description(&self) -> &'s str {
        let text = |map: &'s Map<String, Value>| map.get("description").and_then(Value::as_str);
        text(self.here).or_else(|| text(self.target)).unwrap_or(self.of_list)
    }

    /// Which values it allows.
    pub fn kind(&self) -> Kind<'s> {
        let nodes = |choices: &'s Value| -> Vec<Node<'s>> {
            choices.as_array().into_iter().flatten().map(|choice| Node::new(self.root, choice)).collect()
        };
        if let Some(choices) = self.target.get("anyOf") {
            return Kind::OneOf(nodes(choices));
        }
        let words = self.target.get("oneOf").and_then(Value::as_array).map(Vec::as_slice);
        if let Some(words) = words.or(self.target.contains_key("const").then_some(&[])) {
            let own = self.target.get("const").and_then(Value::as_str);
            return Kind::Words(
                own.into_iter().chain(words.iter().filter_map(|w| w["const"].as_str())).collect(),
            );
        }
        match self.target.get("type").and_then(Value::as_str) {
            Some("object") => Kind::Table,
            Some("array") => {
                let element = Node::new(self.root, &self.target["items"]);
                Kind::List(Node { of_list: self.description(), ..element })
            }
            Some("number") => Kind::Number,
            Some("integer") => Kind::Integer,
            Some("boolean") => Kind::Boolean,
            Some("string") => Kind::Text,
            other => unreachable!("the case's types make no schema of type {other:?}"),
        }
    }

    /// A table's key; where keys are names of the user's own, any.
    pub fn property(&self, key: &str) -> Option<Node<'s>> {
        let named = self.target.get("properties").and_then(|properties| properties.get(key));
        let any = || self.target.get("additionalProperties").filter(|value| value.is_object());
        named.or_else(any).map(|value| Node::new(self.root, value))
    }

    /// A table's keys.
    pub fn keys(&self) -> impl Iterator<Item = &'s str> {
        self.target
            .get("properties")
            .and_then(Value::as_object)
            .into_iter()
            .flatten()
            .map(|(key, _)| key.as_str())
    }

    /// A table's keys that must be there.
    pub fn required(&self) -> impl Iterator<Item = &'s str> {
        self.target.get("required").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str)
    }

    /// A bound: `minimum`, `exclusiveMinimum`, `maximum`, `exclusiveMaximum`, `minItems`, `maxItems`.
    pub fn bound(&self, name: &str) -> Option<f64> {
        self.here.get(name).or_else(|| self.target.get(name)).and_then(Value::as_f64)
    }

    /// Whole numbers that it is confined to.
    pub fn allowed(&self) -> Option<Vec<i64>> {
        let list = self.here.get("enum").and_then(Value::as_array)?;
        Some(list.iter().filter_map(Value::as_i64).collect())
    }
}
