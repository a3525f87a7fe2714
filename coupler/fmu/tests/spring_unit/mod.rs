//! A unit of another hand, compiled from C when the tests run: points that move together on a spring (`spring.c`).

use std::fmt::Write as _;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// What the unit says of itself.
#[derive(Clone, Copy)]
pub struct Spring {
    /// Version of the standard, 2 or 3.
    pub version: u32,
    /// Whether its state can be kept, and written as bytes.
    pub keeps_state: bool,
    /// Whether its steps may be of different sizes.
    pub variable_steps: bool,
}

impl Spring {
    /// One that can do all.
    pub const fn of(version: u32) -> Self {
        Self { version, keeps_state: true, variable_steps: true }
    }

    /// Compiles and packs it into `folder`.
    ///
    /// # Panics
    /// Without a C compiler, which linking Rust needs too.
    pub fn build(self, folder: &Path) -> PathBuf {
        let library = folder.join(format!("spring{}.so", self.version));
        let source = folder.join("spring.c");
        std::fs::write(&source, include_str!("spring.c")).expect("a source");
        let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
        let compiled = Command::new(&compiler)
            .args(["-shared", "-fPIC", "-O1", "-ffp-contract=off"])
            .arg(format!("-DFMI_VERSION={}", self.version))
            .arg("-o")
            .args([&library, &source])
            .arg("-lm")
            .status();
        assert!(compiled.is_ok_and(|status| status.success()), "{compiler} compiles spring.c");
        let unit = folder.join(format!("spring{}.fmu", self.version));
        let platform = if self.version == 3 { "x86_64-linux" } else { "linux64" };
        let mut archive = ZipWriter::new(File::create(&unit).expect("an archive"));
        let files = [
            ("modelDescription.xml".to_owned(), self.description().into_bytes()),
            (format!("binaries/{platform}/spring.so"), std::fs::read(&library).expect("the library")),
        ];
        for (name, bytes) in files {
            archive.start_file(name, SimpleFileOptions::default()).expect("an entry");
            archive.write_all(&bytes).expect("its bytes");
        }
        archive.finish().expect("an archive");
        unit
    }

    /// Names that are not those of meniscus' ports; units of FMI 2.0 are scalars, of five points.
    fn description(self) -> String {
        let (keeps, varies) = (self.keeps_state, self.variable_steps);
        if self.version == 3 {
            return format!(
                r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Spring" instantiationToken="spring">
  <CoSimulation modelIdentifier="spring" canGetAndSetFMUState="{keeps}" canSerializeFMUState="{keeps}" canHandleVariableCommunicationStepSize="{varies}"/>
  <TypeDefinitions><Float64Type name="Length" unit="m"/></TypeDefinitions>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <UInt64 name="nodes" valueReference="1" causality="structuralParameter" variability="fixed" start="5"/>
    <Float64 name="grad_p" valueReference="2" causality="input" start="0" unit="Pa/m"><Dimension valueReference="1"/><Dimension start="2"/></Float64>
    <Float64 name="r" valueReference="3" causality="output" declaredType="Length"><Dimension valueReference="1"/><Dimension start="2"/><Alias name="coordinates"/></Float64>
    <Float64 name="v" valueReference="4" causality="output" unit="km/h"><Dimension valueReference="1"/><Dimension start="2"/></Float64>
    <Float64 name="volume" valueReference="5" causality="calculatedParameter" variability="fixed"><Dimension valueReference="1"/></Float64>
    <Float64 name="stiffness" valueReference="6" causality="parameter" variability="fixed" start="1e3"/>
    <Int32 name="steps" valueReference="7" causality="parameter" variability="fixed" start="10"/>
    <Int32 name="fault" valueReference="8" causality="parameter" variability="fixed" start="0"/>
    <Float64 name="fault_time" valueReference="9" causality="parameter" variability="fixed" start="1e300"/>
    <Float64 name="kinetic_energy" valueReference="10" causality="local" unit="J"/>
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
