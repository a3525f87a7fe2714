//! A unit as a system of System Structure and Parameterization (SSP 1.0): an archive with the unit and
//! `SystemStructure.ssd`, in which the unit's connectors are those of the system. Tools that compose systems
//! take it as it is, or its component into one of theirs.

use crate::variables::{Causality, Quantity, Variable};
use output::report::escape;
use std::fmt::Write as _;

/// The unit's place in the archive.
pub const UNIT: &str = "resources/structure.fmu";
/// The description of the system.
pub const DESCRIPTION: &str = "SystemStructure.ssd";

/// The description of the system of one unit of scalar variables, which has this title.
pub fn description(title: &str, end_time: f64, variables: &[Variable]) -> String {
    let (mut connectors, mut connections) = (String::new(), String::new());
    for variable in variables {
        let kind = match variable.causality {
            Causality::Input => "input",
            Causality::Output => "output",
            Causality::Parameter => "parameter",
            _ => continue,
        };
        let name = escape(&variable.name);
        let value = match variable.quantity {
            Some(quantity) => format!("<ssc:Real unit=\"{}\"/>", quantity.unit()),
            // Whether it is of 32 bits or of 64 is the unit's: the standards have different types for counts.
            None => String::new(),
        };
        let _ = writeln!(
            connectors,
            "<ssd:Connector name=\"{name}\" kind=\"{kind}\" description=\"{}\">{value}</ssd:Connector>",
            escape(&variable.description)
        );
        let (from, to) = match variable.causality {
            Causality::Output => ("startElement=\"structure\"", ""),
            _ => ("", "endElement=\"structure\""),
        };
        let _ = writeln!(
            connections,
            "<ssd:Connection {from} startConnector=\"{name}\" {to} endConnector=\"{name}\"/>"
        );
    }
    let mut units = String::new();
    for quantity in Quantity::ALL {
        let base = quantity.base_unit();
        let _ = writeln!(units, "<ssc:Unit name=\"{}\"><ssc:BaseUnit{base}/></ssc:Unit>", quantity.unit());
    }
    let (title, version) = (escape(title), env!("CARGO_PKG_VERSION"));
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" version="1.0" name="{title}" generationTool="meniscus {version}">
<ssd:System name="system" description="{title}">
<ssd:Connectors>
{connectors}</ssd:Connectors>
<ssd:Elements>
<ssd:Component name="structure" type="application/x-fmu-sharedlibrary" implementation="CoSimulation" source="{UNIT}">
<ssd:Connectors>
{connectors}</ssd:Connectors>
</ssd:Component>
</ssd:Elements>
<ssd:Connections>
{connections}</ssd:Connections>
</ssd:System>
<ssd:Units>
{units}</ssd:Units>
<ssd:DefaultExperiment startTime="0" stopTime="{end_time:?}"/>
</ssd:SystemStructureDescription>
"#
    )
}
