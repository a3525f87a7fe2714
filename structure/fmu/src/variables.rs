//! What an importer can read and set, in one table for the description and for the functions: a variable's
//! value reference is its place in it.

use interfaces::port::names;
use interfaces::{Description, ScalarKind};

/// Where a value is in the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Time (s).
    Time,
    /// Number of interface particles.
    InterfacePoints,
    /// A number of the case.
    Parameter(Parameter),
    /// Sub-steps a communication step; 0 for as many as stability asks.
    SubSteps,
    /// Pressure gradient (Pa/m) at all interface particles.
    PressureGradient,
    /// Position (m) of all interface particles.
    Position,
    /// Velocity (m/s) of all interface particles.
    Velocity,
    /// Reference volume (m³) of all interface particles.
    ReferenceVolume,
    /// Density (kg/m³) of all interface particles, 0 of those that are held.
    InterfaceDensity,
    /// Force (N) at a point of a reduced interface, one component.
    PointForce(usize, usize),
    /// Position (m) of a point, one component.
    PointPosition(usize, usize),
    /// Velocity (m/s) of a point, one component.
    PointVelocity(usize, usize),
    /// A scalar that the structure reports: energies, probes; behind them the sub-steps of the last step.
    Scalar(usize),
    /// Largest next step that the sub-steps are stable with (s).
    LargestStep,
    /// Largest von Mises stress (Pa).
    LargestStress,
}

/// Numbers of the case that can be set before initialisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Parameter {
    /// Young's modulus (Pa).
    YoungsModulus,
    /// Poisson's ratio.
    PoissonRatio,
    /// Reference density (kg/m³).
    Density,
    /// Spacing of the particles (m): the resolution.
    ParticleSpacing,
    /// Viscous damping (1/s).
    Damping,
}

impl Parameter {
    /// All.
    pub const ALL: [Self; 5] =
        [Self::YoungsModulus, Self::PoissonRatio, Self::Density, Self::ParticleSpacing, Self::Damping];

    /// Its key in the case file.
    pub fn key(self) -> &'static str {
        match self {
            Self::YoungsModulus => "structure.material.youngs_modulus",
            Self::PoissonRatio => "structure.material.poisson_ratio",
            Self::Density => "structure.material.density",
            Self::ParticleSpacing => "structure.particle_spacing",
            Self::Damping => "structure.numerics.damping",
        }
    }

    /// The last part of the key.
    pub fn name(self) -> &'static str {
        self.key().rsplit('.').next().expect("a key has a last part")
    }

    fn range(self) -> [Option<f64>; 2] {
        match self {
            Self::PoissonRatio => [Some(-1.0), Some(0.5)],
            _ => [Some(0.0), None],
        }
    }

    fn quantity(self) -> Quantity {
        match self {
            Self::YoungsModulus => Quantity::Stress,
            Self::PoissonRatio => Quantity::Ratio,
            Self::Density => Quantity::Density,
            Self::ParticleSpacing => Quantity::Length,
            Self::Damping => Quantity::Rate,
        }
    }

    fn description(self) -> &'static str {
        match self {
            Self::YoungsModulus => "Young's modulus",
            Self::PoissonRatio => "Poisson's ratio",
            Self::Density => "Reference density",
            Self::ParticleSpacing => "Spacing of the particles; sets how many interface particles there are",
            Self::Damping => "Viscous damping: acceleration against the velocity, a unit of it",
        }
    }
}

/// What a value is: a type definition of the unit, with its SI unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Quantity {
    Length,
    Velocity,
    PressureGradient,
    Stress,
    Density,
    Volume,
    Force,
    Moment,
    Energy,
    Rate,
    Ratio,
    Time,
}

impl Quantity {
    /// All.
    pub const ALL: [Self; 12] = [
        Self::Length,
        Self::Velocity,
        Self::PressureGradient,
        Self::Stress,
        Self::Density,
        Self::Volume,
        Self::Force,
        Self::Moment,
        Self::Energy,
        Self::Rate,
        Self::Ratio,
        Self::Time,
    ];

    /// The SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Length => "m",
            Self::Velocity => "m/s",
            Self::PressureGradient => "Pa/m",
            Self::Stress => "Pa",
            Self::Density => "kg/m3",
            Self::Volume => "m3",
            Self::Force => "N",
            Self::Moment => "N*m",
            Self::Energy => "J",
            Self::Rate => "1/s",
            Self::Ratio => "1",
            Self::Time => "s",
        }
    }

    /// Exponents of kg, m and s in the unit.
    fn exponents(self) -> [i32; 3] {
        match self {
            Self::Length => [0, 1, 0],
            Self::Velocity => [0, 1, -1],
            Self::PressureGradient => [1, -2, -2],
            Self::Stress => [1, -1, -2],
            Self::Density => [1, -3, 0],
            Self::Volume => [0, 3, 0],
            Self::Force => [1, 1, -2],
            Self::Moment | Self::Energy => [1, 2, -2],
            Self::Rate => [0, 0, -1],
            Self::Ratio => [0, 0, 0],
            Self::Time => [0, 0, 1],
        }
    }

    /// The unit as attributes of an element `BaseUnit`.
    pub fn base_unit(self) -> String {
        let exponents = ["kg", "m", "s"].into_iter().zip(self.exponents());
        let is_there = exponents.filter(|(_, exponent)| *exponent != 0);
        is_there.map(|(base, exponent)| format!(" {base}=\"{exponent}\"")).collect()
    }

    /// Of a unit as the participants write it.
    fn of_unit(unit: &str) -> Self {
        Self::ALL.into_iter().find(|quantity| quantity.unit() == unit).unwrap_or(Self::Ratio)
    }
}

/// What an importer may do with a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "terms of the standards")]
pub enum Causality {
    Independent,
    StructuralParameter,
    Parameter,
    CalculatedParameter,
    Input,
    Output,
    Local,
}

/// The shape of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One number.
    Scalar,
    /// One an interface particle.
    Points,
    /// `dimension` numbers an interface particle.
    PointVectors,
}

/// A variable.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// What it means.
    pub description: String,
    /// Where it is.
    pub source: Source,
    /// What may be done with it.
    pub causality: Causality,
    /// What it is; counts have none.
    pub quantity: Option<Quantity>,
    /// Its shape.
    pub shape: Shape,
    /// Least and largest value that it can have, where there is one.
    pub range: [Option<f64>; 2],
}

impl Variable {
    fn new(
        name: impl Into<String>,
        source: Source,
        causality: Causality,
        quantity: Quantity,
        description: impl Into<String>,
    ) -> Self {
        Self {
            name: name.into(),
            description: description.into(),
            source,
            causality,
            quantity: Some(quantity),
            shape: Shape::Scalar,
            range: [None; 2],
        }
    }

    fn count(name: &str, source: Source, causality: Causality, description: &str) -> Self {
        let (name, description) = (name.to_owned(), description.to_owned());
        let range = [Some(0.0), None];
        Self { name, description, source, causality, quantity: None, shape: Shape::Scalar, range }
    }

    fn at_least(self, least: f64) -> Self {
        Self { range: [Some(least), self.range[1]], ..self }
    }

    fn shaped(self, shape: Shape) -> Self {
        Self { shape, ..self }
    }
}

/// The value reference of the number of interface particles, by which arrays are dimensioned.
pub const INTERFACE_POINTS: u32 = 1;

/// The table of a structure with a whole interface, or one reduced to these points (m), of scalars alone.
pub fn table(structure: &Description, points: Option<&[Vec<f64>]>) -> Vec<Variable> {
    use Causality::{Independent, Local, Output, StructuralParameter};
    let mut all = vec![
        Variable::new("time", Source::Time, Independent, Quantity::Time, "Simulation time"),
        Variable::count(
            "interface_points",
            Source::InterfacePoints,
            if points.is_none() { StructuralParameter } else { Local },
            "Number of interface particles; follows from the particle spacing, and is set in configuration mode where that was changed",
        )
        .at_least(1.0),
    ];
    all.extend(Parameter::ALL.map(|p| {
        let parameter = Variable::new(
            p.name(),
            Source::Parameter(p),
            Causality::Parameter,
            p.quantity(),
            p.description(),
        );
        Variable { range: p.range(), ..parameter }
    }));
    all.push(Variable::count(
        "sub_steps",
        Source::SubSteps,
        Causality::Parameter,
        "Sub-steps of the structure in a communication step; 0: as many as its stability asks",
    ));
    match points {
        None => whole_interface(&mut all),
        Some(points) => reduced_interface(&mut all, points, structure.dimension),
    }
    for (n, scalar) in structure.scalars.iter().enumerate() {
        let of_name = || scalar.name.replace('_', " ").replace('.', ", ");
        let described = if scalar.meaning.is_empty() { of_name() } else { scalar.meaning.clone() };
        // A probe is what the case's author wants to see: importers record outputs without being asked.
        let causality = if scalar.kind == ScalarKind::Probe { Output } else { Local };
        let quantity = Quantity::of_unit(&scalar.unit);
        let variable = Variable::new(&scalar.name, Source::Scalar(n), causality, quantity, described);
        let positive = [names::KINETIC_ENERGY, names::STRAIN_ENERGY].contains(&scalar.name.as_str());
        all.push(if positive { variable.at_least(0.0) } else { variable });
    }
    all.push(Variable::new(
        "largest_step",
        Source::LargestStep,
        Local,
        Quantity::Time,
        "Largest next communication step that the sub-steps are stable with; the largest number where any is",
    )
    .at_least(0.0));
    all.push(Variable::count(
        "steps_taken",
        Source::Scalar(structure.scalars.len()),
        Local,
        "Sub-steps of the last communication step",
    ));
    all.push(
        Variable::new(
            "largest_von_mises_stress",
            Source::LargestStress,
            Local,
            Quantity::Stress,
            "Largest von Mises stress of the particles; computed when it is read",
        )
        .at_least(0.0),
    );
    all
}

fn whole_interface(all: &mut Vec<Variable>) {
    use Causality::{CalculatedParameter, Input, Output};
    let vectors = Shape::PointVectors;
    all.extend([
        Variable::new(
            "pressure_gradient",
            Source::PressureGradient,
            Input,
            Quantity::PressureGradient,
            "Pressure gradient at the interface particles, the fluid's load: force -V grad p on each; held over a step",
        )
        .shaped(vectors),
        Variable::new("position", Source::Position, Output, Quantity::Length, "Position of the interface particles")
            .shaped(vectors),
        Variable::new("velocity", Source::Velocity, Output, Quantity::Velocity, "Velocity of the interface particles")
            .shaped(vectors),
        Variable::new(
            "reference_volume",
            Source::ReferenceVolume,
            CalculatedParameter,
            Quantity::Volume,
            "Reference volume of the interface particles (two dimensions: for one metre of depth)",
        )
        .shaped(Shape::Points)
        .at_least(0.0),
        Variable::new(
            "interface_density",
            Source::InterfaceDensity,
            CalculatedParameter,
            Quantity::Density,
            "Reference density of the interface particles; 0 of those that are held and do not yield",
        )
        .shaped(Shape::Points)
        .at_least(0.0),
    ]);
}

fn reduced_interface(all: &mut Vec<Variable>, points: &[Vec<f64>], dimension: usize) {
    use Causality::{Input, Output};
    const AXES: [&str; 3] = ["x", "y", "z"];
    type Part = fn(usize, usize) -> Source;
    let parts: [(&str, Part, Causality, Quantity, &str); 3] = [
        (
            "force",
            Source::PointForce,
            Input,
            Quantity::Force,
            "Force on the structure at the point, held over a step",
        ),
        ("position", Source::PointPosition, Output, Quantity::Length, "Position of the point"),
        ("velocity", Source::PointVelocity, Output, Quantity::Velocity, "Velocity of the point"),
    ];
    for (point, at) in points.iter().enumerate() {
        let at: Vec<String> = at.iter().map(|x| format!("{x:?}")).collect();
        let at = at.join(", ");
        for (name, source, causality, quantity, described) in parts {
            for (component, axis) in AXES.iter().enumerate().take(dimension) {
                let name = format!("point[{}].{name}.{axis}", point + 1);
                all.push(Variable::new(
                    name,
                    source(point, component),
                    causality,
                    quantity,
                    format!("{described}, {axis}; it is that of the material at ({at}) m at the start"),
                ));
            }
        }
    }
}
