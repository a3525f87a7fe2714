//! `modelDescription.xml` of both versions of the standard, and the terminal of the interface.

use crate::MODEL_IDENTIFIER;
use crate::model::{Model, ModelError};
use crate::variables::{Causality, INTERFACE_POINTS, Quantity, Shape, Source, Variable, table};
use output::report::escape;
use std::fmt::Write as _;

/// Version of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0: scalar variables alone.
    Fmi2,
    /// FMI 3.0: arrays too.
    Fmi3,
}

const LOG_CATEGORIES: &str = r#"  <LogCategories>
    <Category name="logStatusError" description="Why a call failed"/>
    <Category name="logEvents" description="What goes on"/>
  </LogCategories>
"#;

/// The description of a model that was just made.
///
/// # Errors
/// Start values that cannot be read.
pub fn model_description(model: &mut Model, version: Version) -> Result<String, ModelError> {
    let variables = table(model.describe(), model.reduced_points());
    let title = escape(&model.case().general.title);
    let token = model.token();
    let general = &model.case().general;
    let experiment = format!(
        "  <DefaultExperiment startTime=\"0\" stopTime=\"{:?}\" stepSize=\"{:?}\"/>\n",
        general.end_time,
        // A hundred steps an output: a master's own choice follows from its partner.
        general.output_interval / 100.0
    );
    let common = format!(
        "modelName=\"{title}\" description=\"Elastic structure (total-Lagrangian SPH) of a meniscus case\" version=\"{0}\" license=\"MIT OR Apache-2.0\" generationTool=\"meniscus {0}\" variableNamingConvention=\"structured\"",
        env!("CARGO_PKG_VERSION")
    );
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    match version {
        Version::Fmi3 => {
            let _ = writeln!(
                xml,
                "<fmiModelDescription fmiVersion=\"3.0\" instantiationToken=\"{token}\" {common}>\n  <CoSimulation modelIdentifier=\"{MODEL_IDENTIFIER}\" canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\" canHandleVariableCommunicationStepSize=\"true\" maxOutputDerivativeOrder=\"0\" providesIntermediateUpdate=\"false\" providesDirectionalDerivatives=\"false\" hasEventMode=\"false\"/>"
            );
        }
        Version::Fmi2 => {
            let _ = writeln!(
                xml,
                "<fmiModelDescription fmiVersion=\"2.0\" guid=\"{token}\" {common}>\n  <CoSimulation modelIdentifier=\"{MODEL_IDENTIFIER}\" canHandleVariableCommunicationStepSize=\"true\" canInterpolateInputs=\"false\" maxOutputDerivativeOrder=\"0\" canNotUseMemoryManagementFunctions=\"true\" canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\" providesDirectionalDerivative=\"false\"/>"
            );
        }
    }
    units_and_types(&mut xml, version);
    xml.push_str(LOG_CATEGORIES);
    xml.push_str(&experiment);
    xml.push_str("  <ModelVariables>\n");
    for (reference, variable) in variables.iter().enumerate() {
        if version == Version::Fmi2 && variable.causality == Causality::Independent {
            // Version 2.0 does not ask for it, and FMI Library, which libcosim and others read units with,
            // wants a start value that the standard forbids.
            continue;
        }
        let value = format!("{}{}", start_value(model, variable)?, range_and_nominal(model, variable)?);
        match version {
            Version::Fmi3 => variable_3(&mut xml, reference, variable, &value, model.dimension()),
            Version::Fmi2 => variable_2(&mut xml, reference, variable, &value),
        }
    }
    xml.push_str("  </ModelVariables>\n");
    structure(&mut xml, &variables, version);
    xml.push_str("</fmiModelDescription>\n");
    Ok(xml)
}

fn units_and_types(xml: &mut String, version: Version) {
    xml.push_str("  <UnitDefinitions>\n");
    for quantity in Quantity::ALL {
        let base = quantity.base_unit();
        let _ = writeln!(xml, "    <Unit name=\"{}\"><BaseUnit{base}/></Unit>", quantity.unit());
    }
    xml.push_str("  </UnitDefinitions>\n  <TypeDefinitions>\n");
    for quantity in Quantity::ALL {
        let (name, unit) = (type_name(quantity), quantity.unit());
        let _ = match version {
            Version::Fmi3 => {
                writeln!(xml, "    <Float64Type name=\"{name}\" quantity=\"{quantity:?}\" unit=\"{unit}\"/>")
            }
            Version::Fmi2 => writeln!(
                xml,
                "    <SimpleType name=\"{name}\"><Real quantity=\"{quantity:?}\" unit=\"{unit}\"/></SimpleType>"
            ),
        };
    }
    xml.push_str("  </TypeDefinitions>\n");
}

/// Types have names of their own, unlike any variable's.
fn type_name(quantity: Quantity) -> String {
    format!("{quantity:?}Type")
}

/// A number as an attribute's value; a count has no point.
fn number(variable: &Variable, value: f64) -> String {
    if variable.quantity.is_some() { format!("{value:?}") } else { format!("{value}") }
}

/// The attribute with the value that a variable starts with, where the importer may see it: of inputs zero,
/// of parameters the case's.
fn start_value(model: &mut Model, variable: &Variable) -> Result<String, ModelError> {
    match variable.causality {
        Causality::Input => Ok(" start=\"0\"".to_owned()),
        Causality::Parameter | Causality::StructuralParameter => {
            let mut value = [0.0];
            model.read(variable.source, &mut value)?;
            Ok(format!(" start=\"{}\"", number(variable, value[0])))
        }
        _ => Ok(String::new()),
    }
}

/// Attributes with the values that a variable can have, and with their size: of real parameters the case's,
/// of positions how far the interface reaches. Those of loads and motion are the importer's to know.
fn range_and_nominal(model: &mut Model, variable: &Variable) -> Result<String, ModelError> {
    let mut attributes = String::new();
    for (name, bound) in ["min", "max"].iter().zip(variable.range) {
        if let Some(bound) = bound {
            let _ = write!(attributes, " {name}=\"{}\"", number(variable, bound));
        }
    }
    let nominal = match variable.source {
        Source::Parameter(_) => {
            let mut value = [0.0];
            model.read(variable.source, &mut value)?;
            value[0].abs()
        }
        Source::Position | Source::PointPosition(..) => {
            let mut positions = vec![0.0; model.length(Source::Position)];
            model.read(Source::Position, &mut positions)?;
            positions.iter().fold(0.0_f64, |farthest, x| farthest.max(x.abs()))
        }
        _ => 0.0,
    };
    if nominal > 0.0 {
        let _ = write!(attributes, " nominal=\"{nominal:?}\"");
    }
    Ok(attributes)
}

fn causality(of: Causality) -> &'static str {
    match of {
        Causality::Independent => "independent",
        Causality::StructuralParameter => "structuralParameter",
        Causality::Parameter => "parameter",
        Causality::CalculatedParameter => "calculatedParameter",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Local => "local",
    }
}

fn variability(of: &Variable) -> &'static str {
    match of.causality {
        Causality::StructuralParameter | Causality::Parameter | Causality::CalculatedParameter => "fixed",
        _ if of.source == Source::InterfacePoints => "fixed",
        _ if of.quantity.is_none() => "discrete",
        _ => "continuous",
    }
}

fn variable_3(xml: &mut String, reference: usize, variable: &Variable, value: &str, dimension: usize) {
    let Variable { name, description, .. } = variable;
    let (causality, variability) = (causality(variable.causality), variability(variable));
    let element = if variable.quantity.is_some() { "Float64" } else { "UInt64" };
    let _ = write!(
        xml,
        "    <{element} name=\"{}\" valueReference=\"{reference}\" causality=\"{causality}\" variability=\"{variability}\" description=\"{}\"",
        escape(name),
        escape(description)
    );
    if let Some(quantity) = variable.quantity {
        let _ = write!(xml, " declaredType=\"{}\"", type_name(quantity));
    }
    xml.push_str(value);
    let components = format!("<Dimension start=\"{dimension}\"/>");
    let points = format!("<Dimension valueReference=\"{INTERFACE_POINTS}\"/>");
    let _ = match variable.shape {
        Shape::Scalar => writeln!(xml, "/>"),
        Shape::Points => writeln!(xml, ">{points}</{element}>"),
        Shape::PointVectors => writeln!(xml, ">{points}{components}</{element}>"),
    };
}

fn variable_2(xml: &mut String, reference: usize, variable: &Variable, value: &str) {
    let Variable { name, description, .. } = variable;
    let (causality, variability) = (causality(variable.causality), variability(variable));
    let value = match variable.quantity {
        Some(quantity) => format!("<Real declaredType=\"{}\"{value}/>", type_name(quantity)),
        None => format!("<Integer{value}/>"),
    };
    let _ = writeln!(
        xml,
        "    <ScalarVariable name=\"{}\" valueReference=\"{reference}\" causality=\"{causality}\" variability=\"{variability}\" description=\"{}\">{value}</ScalarVariable>",
        escape(name),
        escape(description)
    );
}

/// Outputs and what is computed at initialisation. Outputs depend on no input of the same instant.
fn structure(xml: &mut String, variables: &[Variable], version: Version) {
    xml.push_str("  <ModelStructure>\n");
    let of = |causality: &[Causality]| -> Vec<usize> {
        let wanted = |v: &Variable| causality.contains(&v.causality);
        (0..variables.len()).filter(|&n| wanted(&variables[n])).collect()
    };
    let outputs = of(&[Causality::Output]);
    let unknown = of(&[Causality::Output, Causality::CalculatedParameter]);
    match version {
        Version::Fmi3 => {
            for n in outputs {
                let _ = writeln!(xml, "    <Output valueReference=\"{n}\" dependencies=\"\"/>");
            }
            for n in unknown {
                let _ = writeln!(xml, "    <InitialUnknown valueReference=\"{n}\"/>");
            }
        }
        Version::Fmi2 => {
            for (element, members) in [("Outputs", outputs), ("InitialUnknowns", unknown)] {
                let _ = writeln!(xml, "    <{element}>");
                for n in members {
                    let dependencies = if element == "Outputs" { " dependencies=\"\"" } else { "" };
                    // Counted from 1 in the list of variables, which leaves out the first of the table, time.
                    let _ = writeln!(xml, "      <Unknown index=\"{n}\"{dependencies}/>");
                }
                let _ = writeln!(xml, "    </{element}>");
            }
        }
    }
    xml.push_str("  </ModelStructure>\n");
}

/// `terminalsAndIcons.xml`: the interface as one plug, with one inside it for each point of a reduced one,
/// and the icon (FMI 3.0).
pub fn terminals(variables: &[Variable]) -> String {
    let mut members = String::new();
    let mut open = None;
    for variable in variables {
        let point = match variable.source {
            Source::PressureGradient | Source::Position | Source::Velocity => None,
            Source::PointForce(point, _)
            | Source::PointPosition(point, _)
            | Source::PointVelocity(point, _) => Some(point),
            _ => continue,
        };
        let name = &variable.name;
        let (mut indent, mut member) = ("      ", name.as_str());
        if let Some((of_point, own)) = point.and(name.split_once('.')) {
            if open != point {
                let close = if open.is_some() { "      </Terminal>\n" } else { "" };
                let _ =
                    writeln!(members, "{close}      <Terminal name=\"{of_point}\" matchingRule=\"plug\">");
            }
            (indent, member, open) = ("        ", own, point);
        }
        let _ = writeln!(
            members,
            "{indent}<TerminalMemberVariable variableKind=\"signal\" variableName=\"{name}\" memberName=\"{member}\"/>"
        );
    }
    if open.is_some() {
        members.push_str("      </Terminal>\n");
    }
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiTerminalsAndIcons fmiVersion="3.0">
  <Terminals>
    <Terminal name="interface" matchingRule="plug" terminalKind="org.meniscus.fluid-structure-interface" description="What a fluid and the structure exchange at the interface particles">
{members}    </Terminal>
  </Terminals>
  <GraphicalRepresentation>
    <CoordinateSystem x1="-100" y1="-100" x2="100" y2="100" suggestedScalingFactorTo_mm="0.1"/>
    <Icon x1="-100" y1="-100" x2="100" y2="100"/>
  </GraphicalRepresentation>
</fmiTerminalsAndIcons>
"#
    )
}
