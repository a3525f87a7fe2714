//! `modelDescription.xml`, as far as a participant needs it: what the unit can do, and its variables.

use roxmltree::{Document, Node};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Version of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Fmi2,
    /// FMI 3.0.
    Fmi3,
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Fmi2 => "FMI 2.0",
            Self::Fmi3 => "FMI 3.0",
        })
    }
}

/// Type of a variable. Those of FMI 2.0 have the names that they got in FMI 3.0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "names of the standard")]
pub enum Type {
    Float64,
    Float32,
    Int32,
    Int64,
    UInt32,
    UInt64,
    Boolean,
    String,
    /// Any that a participant has no use for.
    Other,
}

impl Type {
    /// Of an element in the list of variables.
    fn of(element: &str) -> Option<Self> {
        Some(match element {
            "Float64" | "Real" => Self::Float64,
            "Float32" => Self::Float32,
            "Int32" | "Integer" => Self::Int32,
            // An enumeration's items are numbered: in FMI 3.0 as Int64.
            "Int64" => Self::Int64,
            "UInt32" => Self::UInt32,
            "UInt64" => Self::UInt64,
            "Boolean" => Self::Boolean,
            "String" => Self::String,
            "Int8" | "Int16" | "UInt8" | "UInt16" | "Binary" | "Clock" | "Enumeration" => Self::Other,
            _ => return None,
        })
    }
}

/// What an importer may do with a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "names of the standard")]
pub enum Causality {
    Independent,
    StructuralParameter,
    Parameter,
    CalculatedParameter,
    Input,
    Output,
    Local,
}

/// A variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Its value reference.
    pub reference: u32,
    /// Its type.
    pub kind: Type,
    /// What may be done with it.
    pub causality: Causality,
    /// Its unit, where it or its type has one.
    pub unit: Option<String>,
    /// Its dimensions; none for a scalar.
    pub dimensions: Vec<Dimension>,
    /// Its start value, as written.
    pub start: Option<String>,
}

/// A dimension of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// A number.
    Fixed(usize),
    /// The value of a structural parameter or constant, by its value reference.
    Of(u32),
}

/// What is known of a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// Version of the standard.
    pub version: Version,
    /// Name of the model.
    pub model: String,
    /// `instantiationToken`; in FMI 2.0 the `guid`.
    pub token: String,
    /// Name of the shared library, without its ending.
    pub identifier: String,
    /// Whether the state can be kept and restored.
    pub keeps_state: bool,
    /// Whether a state can be written as bytes.
    pub serializes_state: bool,
    /// Whether steps may be of different sizes.
    pub variable_steps: bool,
    /// The variables; an alias is one of its own.
    pub variables: Vec<Variable>,
    /// What its units are in SI units, as far as it says.
    pub units: BTreeMap<String, BaseUnit>,
}

/// A unit in SI units: a product of powers, and a factor.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseUnit {
    /// Exponents of kg, m and s, and of others that are none of a coupling's.
    pub exponents: [i32; 4],
    /// How many SI units it is.
    pub factor: f64,
    /// What is added; not 0 for temperatures alone.
    pub offset: f64,
}

impl BaseUnit {
    /// How many of the SI unit `wanted` of a field it is, where it is one.
    pub fn factor_to(&self, wanted: &str) -> Option<f64> {
        let exponents = match wanted {
            "1" => [0, 0, 0, 0],
            "m" => [0, 1, 0, 0],
            "m3" => [0, 3, 0, 0],
            "m/s" => [0, 1, -1, 0],
            "kg/m3" => [1, -3, 0, 0],
            "Pa" => [1, -1, -2, 0],
            "Pa/m" => [1, -2, -2, 0],
            "N" => [1, 1, -2, 0],
            "J" => [1, 2, -2, 0],
            "s" => [0, 0, 1, 0],
            _ => return None,
        };
        let fits = self.exponents == exponents && self.offset == 0.0;
        (fits && self.factor.is_finite() && self.factor > 0.0).then_some(self.factor)
    }
}

impl fmt::Display for BaseUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [kg, m, s, others] = self.exponents;
        write!(f, "{:e} kg^{kg} m^{m} s^{s}", self.factor)?;
        if others != 0 { write!(f, " and more") } else { Ok(()) }
    }
}

impl Description {
    /// Reads a model description.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub fn parse(text: &str) -> Result<Self, String> {
        let document = Document::parse(text).map_err(|error| error.to_string())?;
        let root = document.root_element();
        if root.tag_name().name() != "fmiModelDescription" {
            return Err(format!("its root is `{}`, not `fmiModelDescription`", root.tag_name().name()));
        }
        let version = match needed(root, "fmiVersion")? {
            "2.0" => Version::Fmi2,
            three if three == "3.0" || three.starts_with("3.") => Version::Fmi3,
            other => return Err(format!("it is of FMI {other}; 2.0 and 3.0 are known")),
        };
        let step = child(root, "CoSimulation")
            .ok_or("it has no element `CoSimulation`: the unit was not exported for co-simulation")?;
        let (get, serialize, token) = match version {
            Version::Fmi2 => ("canGetAndSetFMUstate", "canSerializeFMUstate", "guid"),
            Version::Fmi3 => ("canGetAndSetFMUState", "canSerializeFMUState", "instantiationToken"),
        };
        Ok(Self {
            version,
            model: needed(root, "modelName")?.to_owned(),
            token: needed(root, token)?.to_owned(),
            identifier: needed(step, "modelIdentifier")?.to_owned(),
            keeps_state: is_true(step, get),
            serializes_state: is_true(step, serialize),
            variable_steps: is_true(step, "canHandleVariableCommunicationStepSize"),
            variables: variables(root, version)?,
            units: units(root),
        })
    }

    /// The variable of that name.
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.variables.iter().find(|variable| variable.name == name)
    }
}

fn variables(root: Node, version: Version) -> Result<Vec<Variable>, String> {
    let list = child(root, "ModelVariables").ok_or("it has no element `ModelVariables`")?;
    let units = units_of_types(root, version);
    let mut variables = Vec::new();
    for element in list.children().filter(Node::is_element) {
        // In FMI 2.0 the type is an element inside, which carries unit and start.
        let typed = match version {
            Version::Fmi2 => element.children().find(|inner| Type::of(inner.tag_name().name()).is_some()),
            Version::Fmi3 => Some(element),
        };
        let name = needed(element, "name")?.to_owned();
        let kind = typed.and_then(|typed| Type::of(typed.tag_name().name()));
        let (Some(typed), Some(kind)) = (typed, kind) else {
            return Err(format!("variable `{name}` is of no type of the standard"));
        };
        let reference = needed(element, "valueReference")?;
        let reference = reference
            .parse()
            .map_err(|_| format!("variable `{name}` has the value reference {reference}"))?;
        let of_type = typed.attribute("declaredType").and_then(|name| units.get(name).copied());
        let variable = Variable {
            reference,
            kind,
            causality: causality(element.attribute("causality")),
            unit: typed.attribute("unit").or(of_type).map(str::to_owned),
            dimensions: dimensions(element, &name)?,
            start: typed.attribute("start").map(str::to_owned),
            name,
        };
        for alias in element.children().filter(|inner| inner.has_tag_name("Alias")) {
            variables.push(Variable { name: needed(alias, "name")?.to_owned(), ..variable.clone() });
        }
        variables.push(variable);
    }
    let mut names = BTreeSet::new();
    match variables.iter().find(|variable| !names.insert(&variable.name)) {
        Some(twice) => Err(format!("two variables have the name `{}`", twice.name)),
        None => Ok(variables),
    }
}

/// Those of `UnitDefinitions` that say what they are in SI units.
fn units(root: Node) -> BTreeMap<String, BaseUnit> {
    let definitions = child(root, "UnitDefinitions").into_iter().flat_map(|list| list.children());
    definitions
        .filter_map(|definition| {
            let base = child(definition, "BaseUnit")?;
            let exponent = |name: &str| base.attribute(name).map_or(Some(0), |text| text.trim().parse().ok());
            let number = |name: &str, usual: f64| {
                base.attribute(name).map_or(Some(usual), |text| text.trim().parse().ok())
            };
            let mut others = 0_i32;
            for name in ["A", "K", "mol", "cd", "rad"] {
                others = others.checked_add(i32::checked_abs(exponent(name)?)?)?;
            }
            let unit = BaseUnit {
                exponents: [exponent("kg")?, exponent("m")?, exponent("s")?, others],
                factor: number("factor", 1.0)?,
                offset: number("offset", 0.0)?,
            };
            Some((definition.attribute("name")?.to_owned(), unit))
        })
        .collect()
}

fn dimensions(variable: Node, name: &str) -> Result<Vec<Dimension>, String> {
    let dimension = |element: Node| {
        let number = |attribute| element.attribute(attribute);
        match (number("start").map(str::parse), number("valueReference").map(str::parse)) {
            (Some(Ok(length)), _) => Ok(Dimension::Fixed(length)),
            (None, Some(Ok(reference))) => Ok(Dimension::Of(reference)),
            _ => Err(format!("variable `{name}` has a dimension that is no number")),
        }
    };
    variable.children().filter(|inner| inner.has_tag_name("Dimension")).map(dimension).collect()
}

fn units_of_types<'a>(root: Node<'a, '_>, version: Version) -> BTreeMap<&'a str, &'a str> {
    let types = child(root, "TypeDefinitions").into_iter().flat_map(|list| list.children());
    types
        .filter_map(|definition| {
            let holder = match version {
                Version::Fmi2 => child(definition, "Real")?,
                Version::Fmi3 => definition,
            };
            Some((definition.attribute("name")?, holder.attribute("unit")?))
        })
        .collect()
}

fn causality(word: Option<&str>) -> Causality {
    match word {
        Some("independent") => Causality::Independent,
        Some("structuralParameter") => Causality::StructuralParameter,
        Some("parameter") => Causality::Parameter,
        Some("calculatedParameter") => Causality::CalculatedParameter,
        Some("input") => Causality::Input,
        Some("output") => Causality::Output,
        // The standards' default.
        _ => Causality::Local,
    }
}

fn child<'a, 'input>(of: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    of.children().find(|inner| inner.has_tag_name(name))
}

fn needed<'a>(of: Node<'a, '_>, attribute: &str) -> Result<&'a str, String> {
    of.attribute(attribute)
        .ok_or_else(|| format!("an element `{}` has no attribute `{attribute}`", of.tag_name().name()))
}

fn is_true(of: Node, attribute: &str) -> bool {
    matches!(of.attribute(attribute), Some("true" | "1"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit of FMI 3.0 with this in its root, before and in its list of variables.
    fn three(step: &str, variables: &str) -> String {
        format!(
            r#"<fmiModelDescription fmiVersion="3.0" modelName="M" instantiationToken="t">{step}<ModelVariables>{variables}</ModelVariables></fmiModelDescription>"#
        )
    }

    const STEP: &str = r#"<CoSimulation modelIdentifier="m" canGetAndSetFMUState="1"/>"#;

    #[test]
    fn types_lend_units_aliases_are_variables_and_what_is_not_said_is_false() {
        let variables = r#"<Float64 name="x" valueReference="7" declaredType="L"><Dimension start="3"/><Dimension valueReference="8"/><Alias name="y"/></Float64><Binary name="b" valueReference="9"/>"#;
        let types = r#"<TypeDefinitions><Float64Type name="L" unit="mm"/></TypeDefinitions>"#;
        let found = Description::parse(&three(&format!("{STEP}{types}"), variables)).unwrap();
        assert_eq!((found.keeps_state, found.serializes_state, found.variable_steps), (true, false, false));
        for name in ["x", "y"] {
            let variable = found.variable(name).unwrap();
            assert_eq!((variable.reference, variable.unit.as_deref()), (7, Some("mm")));
            assert_eq!(variable.dimensions, [Dimension::Fixed(3), Dimension::Of(8)]);
            assert_eq!((variable.kind, variable.causality), (Type::Float64, Causality::Local));
        }
        assert_eq!(found.variable("b").unwrap().kind, Type::Other);
    }

    #[test]
    fn a_description_that_cannot_be_used_says_why() {
        for (text, why) in [
            ("<fmi".to_owned(), "root"),
            ("<a/>".to_owned(), "its root is `a`"),
            (three("", ""), "was not exported for co-simulation"),
            (three("<CoSimulation/>", ""), "`CoSimulation` has no attribute `modelIdentifier`"),
            (three(STEP, "").replace("3.0", "1.0"), "of FMI 1.0; 2.0 and 3.0 are known"),
            (three(STEP, "<Float64 name=\"x\"/>"), "no attribute `valueReference`"),
            (three(STEP, "<Float64 name=\"x\" valueReference=\"-1\"/>"), "`x` has the value reference -1"),
            (
                three(STEP, "<Quaternion name=\"q\" valueReference=\"1\"/>"),
                "`q` is of no type of the standard",
            ),
            (
                three(STEP, "<Float64 name=\"x\" valueReference=\"1\"><Dimension/></Float64>"),
                "`x` has a dimension that is no number",
            ),
        ] {
            let found = Description::parse(&text).expect_err(why);
            assert!(found.contains(why), "`{why}` is not in: {found}");
        }
    }
}
