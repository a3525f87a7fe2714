//! The JSON schema of the case file, made of [`super::keys`] and of the sections that solvers bring: for
//! editors, for [`super::conform`] and for [`super::docs`].

use super::coupling;
use super::geometry::PER_AXIS;
use super::keys::Case;
use super::section::Sections;
use serde_json::{Map, Value, json};

/// The schema (JSON Schema 2020-12) of a `case.toml` with the sections of these solvers.
pub fn schema(solvers: &[Sections]) -> Value {
    let mut schema = schemars::schema_for!(Case).to_value();
    schema["title"] = json!("meniscus case");
    put_section(&mut schema, "coupling", coupling::schema());
    for (place, section) in solvers.iter().flat_map(|solver| solver.schemas) {
        put_section(&mut schema, place, section());
    }
    without_null(&mut schema);
    in_one_line(&mut schema);
    schema
}

/// Comments are wrapped where the source is; descriptions are not.
fn in_one_line(value: &mut Value) {
    match value {
        Value::Object(node) => {
            if let Some(Value::String(text)) = node.get_mut("description") {
                *text = text.replace('\n', " ");
            }
            node.values_mut().for_each(in_one_line);
        }
        Value::Array(list) => list.iter_mut().for_each(in_one_line),
        _ => {}
    }
}

/// Describes the table at `place` (`fluid.numerics`) by the schema of its own, whose definitions join the
/// others.
fn put_section(schema: &mut Value, place: &str, mut section: Value) {
    if let Value::Object(node) = &mut section {
        let _ = (node.remove("$schema"), node.remove("title"));
        for (name, definition) in node.remove("$defs").iter().filter_map(Value::as_object).flatten() {
            let before = &mut schema["$defs"][name];
            assert!(before.is_null() || before == definition, "two types of the case are called {name}");
            *before = definition.clone();
        }
    }
    schema["$defs"][place] = section;
    let mut names = place.split('.').rev();
    let key = names.next().expect("a place has a name");
    // `fluid.numerics` is a property of the definition `Fluid`.
    let owner = names.next().map(|owner| owner[..1].to_uppercase() + &owner[1..]);
    let table = match &owner {
        Some(owner) => &mut schema["$defs"][owner],
        None => schema,
    };
    let property = &mut table["properties"][key];
    *property = json!({ "description": property["description"], "$ref": format!("#/$defs/{place}") });
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

    /// Whether it is a table that another than this schema describes.
    pub fn is_open(&self) -> bool {
        self.target.get("additionalProperties") == Some(&Value::Bool(true))
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

    /// The bounds of a number in words, where it has any.
    pub fn range(&self) -> Option<String> {
        // What cannot be negative by its type goes without saying.
        let counts = self.target.get("type").and_then(Value::as_str) == Some("integer");
        let bounds: Vec<_> = [
            self.bound("exclusiveMinimum").map(|bound| format!("over {bound}")),
            self.bound("minimum").filter(|b| !(counts && *b == 0.0)).map(|bound| format!("at least {bound}")),
            self.bound("exclusiveMaximum").map(|bound| format!("under {bound}")),
            self.bound("maximum")
                .filter(|b| !(counts && *b >= 255.0))
                .map(|bound| format!("at most {bound}")),
        ]
        .into_iter()
        .flatten()
        .collect();
        (!bounds.is_empty()).then(|| bounds.join(" and "))
    }

    /// The words that it allows, and what they mean.
    pub fn words(&self) -> Vec<(&'s str, &'s str)> {
        let words = self.target.get("oneOf").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let text = |word: &'s Value, key: &str| word.get(key).and_then(Value::as_str);
        words
            .iter()
            .filter_map(|word| Some((text(word, "const")?, text(word, "description").unwrap_or_default())))
            .collect()
    }

    /// Whether it is a list with an element for each axis.
    pub fn is_per_axis(&self) -> bool {
        self.target.contains_key(PER_AXIS)
    }

    /// What it is where it is left out.
    pub fn default(&self) -> Option<&'s Value> {
        self.here.get("default")
    }

    /// What it is instead beside another key: `scheme = "paper"`.
    pub fn other_defaults(&self) -> impl Iterator<Item = (&'s String, &'s Value)> {
        self.here.get("x-defaults").and_then(Value::as_object).into_iter().flatten()
    }

    /// Whole numbers that it is confined to.
    pub fn allowed(&self) -> Option<Vec<i64>> {
        let list = self.here.get("enum").and_then(Value::as_array)?;
        Some(list.iter().filter_map(Value::as_i64).collect())
    }
}
