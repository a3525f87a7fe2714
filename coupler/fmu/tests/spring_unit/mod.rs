//! Units of another hand, compiled from C when the tests run: points that move together on a spring
//! (`spring.c`), and a fluid that drags points (`drag.c`).

use std::fmt::Write as _;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// A case of nothing but what units and mocks need, whose sides these participants solve; coupled where it
/// says how.
pub fn case_text(fluid: &str, structure: &str, end_time: f64, coupling: &str) -> String {
    let output_interval = 0.1 * end_time;
    format!(
        r#"
[case]
title = "Spring"
dimension = 2
end_time = {end_time}
output_interval = {output_interval}
particle_spacing = 0.01

[fluid]
density = 1000.0
kinematic_viscosity = 1e-6
domain = {{ low = [0.0, 0.0], high = [1.0, 1.0] }}
participant = {fluid}

[structure]
participant = {structure}

[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 1e6
poisson_ratio = 0.3
density = 1000.0

{coupling}
"#
    )
}

/// What the unit says of itself.
#[derive(Clone, Copy)]
pub struct Spring {
    /// Version of the standard, 2 or 3.
    pub version: u32,
    /// Whether its state can be kept, and written as bytes.
    pub keeps_state: bool,
    /// Whether its steps may be of different sizes.
    pub variable_steps: bool,
    /// What its source is compiled with.
    pub define: &'static str,
}

impl Spring {
    /// One that can do all.
    pub const fn of(version: u32) -> Self {
        Self { version, keeps_state: true, variable_steps: true, define: "WHOLE" }
    }

    /// Compiles and packs it into `folder`.
    ///
    /// # Panics
    /// Without a C compiler, which linking Rust needs too.
    pub fn build(self, folder: &Path) -> PathBuf {
        let platform = if self.version == 3 { "x86_64-linux" } else { "linux64" };
        let version = format!("-DFMI_VERSION={}", self.version);
        let name = format!("spring{}", self.version);
        let defines = [version, format!("-D{}", self.define)];
        let library = compile(folder, &name, include_str!("spring.c"), &defines);
        pack(folder, &name, &self.description(), &format!("binaries/{platform}/spring.so"), &library)
    }

    /// Names that are not those of meniscus' ports; units of FMI 2.0 are scalars, of five points.
    fn description(self) -> String {
        let (keeps, varies) = (self.keeps_state, self.variable_steps);
        if self.version == 3 {
            return format!(
                r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Spring" instantiationToken="spring">
  <CoSimulation modelIdentifier="spring" canGetAndSetFMUState="{keeps}" canSerializeFMUState="{keeps}" canHandleVariableCommunicationStepSize="{varies}"/>
  <UnitDefinitions><Unit name="speed"><BaseUnit m="1" s="-1"/></Unit></UnitDefinitions>
  <TypeDefinitions><Float64Type name="Length" unit="m"/></TypeDefinitions>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <UInt64 name="nodes" valueReference="1" causality="structuralParameter" variability="fixed" start="5"/>
    <Float64 name="grad_p" valueReference="2" causality="input" start="0" unit="Pa/m"><Dimension valueReference="1"/><Dimension start="2"/></Float64>
    <Float64 name="r" valueReference="3" causality="output" declaredType="Length"><Dimension valueReference="1"/><Dimension start="2"/><Alias name="coordinates"/></Float64>
    <Float64 name="v" valueReference="4" causality="output" unit="speed"><Dimension valueReference="1"/><Dimension start="2"/></Float64>
    <Float64 name="volume" valueReference="5" causality="calculatedParameter" variability="fixed"><Dimension valueReference="1"/></Float64>
    <Float64 name="stiffness" valueReference="6" causality="parameter" variability="fixed" start="1e3"/>
    <Int32 name="steps" valueReference="7" causality="parameter" variability="fixed" start="10"/>
    <Int32 name="fault" valueReference="8" causality="parameter" variability="fixed" start="0"/>
    <Float64 name="fault_time" valueReference="9" causality="parameter" variability="fixed" start="1e300"/>
    <Float64 name="kinetic_energy" valueReference="10" causality="local" unit="J"/>
    <Float64 name="swing" valueReference="11" causality="parameter" variability="fixed" start="0"/>
  </ModelVariables>
  <ModelStructure/>
</fmiModelDescription>
"#
            );
        }
        let mut variables = String::new();
        let blocks = [("g", "input", " start=\"0\""), ("r", "output", ""), ("v", "output", "")];
        for (block, (letter, causality, start)) in blocks.into_iter().enumerate() {
            for n in 0..10 {
                let (point, axis, reference) = (n / 2 + 1, ["x", "y"][n % 2], 100 + 1000 * block + n);
                let _ = writeln!(
                    variables,
                    r#"    <ScalarVariable name="node[{point}].{letter}{axis}" valueReference="{reference}" causality="{causality}"><Real{start}/></ScalarVariable>"#
                );
            }
        }
        format!(
            r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Spring" guid="spring">
  <CoSimulation modelIdentifier="spring" canGetAndSetFMUstate="{keeps}" canSerializeFMUstate="{keeps}" canHandleVariableCommunicationStepSize="{varies}"/>
  <ModelVariables>
{variables}    <ScalarVariable name="stiffness" valueReference="6" causality="parameter" variability="fixed"><Real start="1e3"/></ScalarVariable>
    <ScalarVariable name="steps" valueReference="7" causality="parameter" variability="fixed"><Integer start="10"/></ScalarVariable>
    <ScalarVariable name="fault" valueReference="8" causality="parameter" variability="fixed"><Integer start="0"/></ScalarVariable>
    <ScalarVariable name="fault_time" valueReference="9" causality="parameter" variability="fixed"><Real start="1e300"/></ScalarVariable>
    <ScalarVariable name="kinetic_energy" valueReference="10" causality="local"><Real unit="J"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure/>
</fmiModelDescription>
"#
        )
    }

    /// `[structure.participant]` of a case with this unit, as a TOML value.
    pub fn participant(self, unit: &Path, parameters: &str) -> String {
        let file = unit.display();
        let variables = if self.version == 3 {
            "position = \"r\", velocity = \"v\", reference_volume = \"volume\", pressure_gradient = \"grad_p\""
        } else {
            "position = \"node[{point}].r{axis}\", velocity = \"node[{point}].v{axis}\", reference_volume = 1e-4, pressure_gradient = \"node[{point}].g{axis}\""
        };
        format!(
            "{{ fmu = \"{file}\", variables = {{ {variables}, density = 1000.0, sub_steps = \"steps\" }}, parameters = {{ {parameters} }} }}"
        )
    }
}

/// A fluid that drags every point by 0.5 N s/m against its velocity, for five points, FMI 3.0, with the names
/// of meniscus' ports.
pub fn drag(folder: &Path) -> PathBuf {
    let description = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Drag" instantiationToken="drag">
  <CoSimulation modelIdentifier="drag" canGetAndSetFMUState="true" canSerializeFMUState="true" canHandleVariableCommunicationStepSize="true"/>
  <ModelVariables>
    <Float64 name="reference_volume" valueReference="1" causality="parameter" variability="fixed" start="1 1 1 1 1"><Dimension start="5"/></Float64>
    <Float64 name="position" valueReference="2" causality="input" start="0 0 0 0 0 0 0 0 0 0"><Dimension start="5"/><Dimension start="2"/></Float64>
    <Float64 name="velocity" valueReference="3" causality="input" start="0 0 0 0 0 0 0 0 0 0"><Dimension start="10"/></Float64>
    <Float64 name="pressure_gradient" valueReference="4" causality="output"><Dimension start="5"/><Dimension start="2"/></Float64>
    <Float64 name="dissipated_energy" valueReference="5" causality="local"/>
  </ModelVariables>
  <ModelStructure/>
</fmiModelDescription>
"#;
    let library = compile(folder, "drag", include_str!("drag.c"), &["-DFMI_VERSION=3".to_owned()]);
    pack(folder, "drag", description, "binaries/x86_64-linux/drag.so", &library)
}

fn compile(folder: &Path, name: &str, text: &str, defines: &[String]) -> PathBuf {
    let (library, source) = (folder.join(format!("{name}.so")), folder.join(format!("{name}.c")));
    std::fs::write(&source, text).expect("a source");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let compiled = Command::new(&compiler)
        .args(["-shared", "-fPIC", "-O1", "-ffp-contract=off"])
        .args(defines)
        .arg("-o")
        .args([&library, &source])
        .arg("-lm")
        .status();
    assert!(compiled.is_ok_and(|status| status.success()), "{compiler} compiles {name}.c");
    library
}

fn pack(folder: &Path, name: &str, description: &str, entry: &str, library: &Path) -> PathBuf {
    let unit = folder.join(format!("{name}.fmu"));
    let mut archive = ZipWriter::new(File::create(&unit).expect("an archive"));
    let library = std::fs::read(library).expect("the library");
    for (name, bytes) in [("modelDescription.xml", description.as_bytes()), (entry, library.as_slice())] {
        archive.start_file(name, SimpleFileOptions::default()).expect("an entry");
        archive.write_all(bytes).expect("its bytes");
    }
    archive.finish().expect("an archive");
    unit
}
