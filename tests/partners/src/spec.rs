//! Mocks from words of a command line:
//! `spring-mass --points 40 --dimension 2 --stiffness 1e4 --fault nan@12`.

use crate::{
    AddedMassColumn, Constant, Fault, Faulty, GivenVelocity, Harmonic, Hydrostatic, Idle, Integration, Law,
    Points, Prescribed, SurfacePressure,
};
use crate::{Model, Rigid, Script, Scripted, SpringMass, StandIn, WallModel, fluid::Load};
use interfaces::{Participant, Role};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::str::FromStr;
use thiserror::Error;

/// An option of a mock: its key, its default (nothing: it must be given), its meaning with the unit.
type Choice = (&'static str, Option<&'static str>, &'static str);

/// A kind of mock: its name, what it is, its own options besides those of its side.
struct Kind {
    name: &'static str,
    side: Side,
    summary: &'static str,
    options: &'static [Choice],
}

#[derive(Clone, Copy, PartialEq)]
enum Side {
    Structure,
    Fluid,
    /// No options but its own.
    FluidOfItsOwnPoints,
    Either,
}

const ANY: &[Choice] = &[
    ("dimension", Some("2"), "space dimension, 2 or 3"),
    ("window_limit", Some("inf"), "largest window it asks for (s)"),
];

const STRUCTURE: &[Choice] = &[
    ("points", Some("10"), "interface points, on a line along x"),
    ("grid", Some(""), "interface points on a box instead, as 4x10 or 4x10x2"),
    (
        "outline",
        Some(""),
        "instead the outline of a box of cells, as 8x2: a boundary mesh that takes forces; two dimensions",
    ),
    ("spacing", Some("0.01"), "distance of neighbouring points (m)"),
    ("origin", Some("0"), "position of the first point (m): one number, or one a component"),
    ("density", Some("1000"), "density (kg/m³)"),
];

const FLUID: &[Choice] =
    &[("reaction_factor", Some("1"), "what it says it received, as a multiple of the load it gives")];

const KINDS: &[Kind] = &[
    Kind { name: "rigid", side: Side::Structure, summary: "a structure that never moves", options: &[] },
    Kind {
        name: "prescribed",
        side: Side::Structure,
        summary: "a structure that moves by a law of time",
        options: &[
            ("law", Some("heave"), "heave, constant-velocity or swing"),
            ("amplitude", Some("0,0.01"), "heave: amplitude (m), one a component"),
            ("frequency", Some("1"), "heave: frequency (Hz)"),
            ("velocity", Some("0"), "constant-velocity: velocity (m/s), one a component"),
            ("pivot", Some("0"), "swing: the point that stays (m)"),
            ("angle", Some("1.5707963267948966"), "swing: angle when open (rad)"),
            ("duration", Some("1"), "swing: time it takes (s)"),
        ],
    },
    Kind {
        name: "spring-mass",
        side: Side::Structure,
        summary: "a structure whose points move together on a spring and a damper",
        options: &[
            ("stiffness", Some("1e4"), "spring (N/m)"),
            ("damping", Some("0"), "damper (N s/m)"),
            ("displacement", Some("0"), "displacement at the start (m), one a component"),
            ("velocity", Some("0"), "velocity at the start (m/s), one a component"),
            ("integration", Some("exact"), "exact, or rk4 in the sub-steps asked for"),
            ("load", Some("held"), "within a window: held, or linear"),
        ],
    },
    Kind {
        name: "hydrostatic",
        side: Side::Fluid,
        summary: "a fluid at rest, p = ρ g (H − y)",
        options: &[
            ("density", Some("1000"), "density (kg/m³)"),
            ("gravity", Some("9.81"), "gravity (m/s²)"),
            ("level", None, "height H of the surface (m)"),
            (
                "plate_thickness",
                Some("0"),
                "thickness (m) of a plate that is dry beneath; 0: a submerged body",
            ),
        ],
    },
    Kind {
        name: "surface-pressure",
        side: Side::FluidOfItsOwnPoints,
        summary: "a fluid at rest around a body, on a boundary mesh of its own: behind coupling.fluid_mapping; two dimensions",
        options: &[
            ("outline", None, "cells of the box whose outline it is, as 8x2"),
            ("spacing", Some("0.01"), "their width (m)"),
            ("origin", Some("0"), "its lower left corner (m)"),
            ("density", Some("1000"), "density (kg/m³)"),
            ("gravity", Some("9.81"), "gravity (m/s²)"),
            ("level", None, "height H of the surface (m)"),
        ],
    },
    Kind {
        name: "constant",
        side: Side::Fluid,
        summary: "a fluid with the same load at every point at all times",
        options: &[
            ("gradient", Some("0"), "pressure gradient (Pa/m), one a component"),
            ("pressure", Some("0"), "pressure (Pa)"),
            ("end_after", Some("inf"), "time (s) from which it asks for the end of the run"),
        ],
    },
    Kind {
        name: "harmonic",
        side: Side::Fluid,
        summary: "a fluid whose load swings, the same at every point",
        options: &[
            ("gradient", Some("0"), "amplitude of the pressure gradient (Pa/m), one a component"),
            ("frequency", Some("1"), "frequency of its sine (Hz)"),
        ],
    },
    Kind {
        name: "added-mass-column",
        side: Side::Fluid,
        summary: "a rigid column of fluid that rides on the structure",
        options: &[
            ("mass", None, "mass of the column (kg)"),
            ("wall", Some("moving"), "what it takes the structure for: moving or compliant"),
            (
                "velocity",
                Some("mean"),
                "what the coupler gives a compliant wall, as coupling.structure_velocity: mean or end",
            ),
            ("axis", Some("up"), "out of the structure into the column: x, y, z or up (the last)"),
            ("gravity", Some("0"), "gravity against the axis (m/s²)"),
            ("area", Some("1"), "area over which its force is a pressure (m²)"),
        ],
    },
    Kind {
        name: "idle",
        side: Side::Either,
        summary: "a participant that does nothing, in two dimensions",
        options: &[
            ("role", None, "fluid or structure"),
            ("points", Some("10"), "interface points"),
            ("varies", Some("no"), "fluid: yes to give another load at every solution, or no"),
            (
                "interpolates",
                Some("no"),
                "structure: yes to read the load at every sub-step, linear within the window, or no",
            ),
        ],
    },
    Kind {
        name: "scripted",
        side: Side::Either,
        summary: "a participant that plays a script, and complains when the coupler leaves it",
        options: &[("file", None, "the script, a JSON file")],
    },
];

/// A mock as written: a kind, its options, and faults. [`MockSpec::build`] makes it.
#[derive(Clone, Debug, PartialEq)]
pub struct MockSpec {
    kind: String,
    values: BTreeMap<String, String>,
    faults: Vec<Fault>,
}

/// All that is wrong with the words for a mock.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("the mock cannot be made:\n  {}", .0.join("\n  "))]
pub struct SpecError(
    /// One line a mistake.
    pub Vec<String>,
);

impl MockSpec {
    /// From words: the kind, then options as `--key value`, `--key=value` or `key=value`; hyphens in keys
    /// stand for underscores, `fault` may come several times.
    pub fn from_words<S: AsRef<str>>(words: &[S]) -> Result<Self, SpecError> {
        let mut words = words.iter().map(AsRef::as_ref);
        let names = || KINDS.iter().map(|k| k.name).collect::<Vec<_>>().join(", ");
        let Some(kind) = words.next() else {
            return Err(SpecError(vec![format!("no kind is named: one of {}", names())]));
        };
        let Some(known) = KINDS.iter().find(|k| k.name == kind) else {
            return Err(SpecError(vec![format!("there is no mock `{kind}`: one of {}", names())]));
        };
        let mut spec = Self { kind: kind.to_owned(), values: BTreeMap::new(), faults: Vec::new() };
        let mut mistakes = Vec::new();
        while let Some(word) = words.next() {
            let (key, value) = match (word.split_once('='), word.strip_prefix("--")) {
                (Some((key, value)), _) => (key.trim_start_matches('-'), Some(value)),
                (None, Some(key)) => (key, words.next()),
                (None, None) => {
                    mistakes.push(format!("`{word}` is no option: write key=value or --key value"));
                    continue;
                }
            };
            let key = key.replace('-', "_");
            match value {
                None => mistakes.push(format!("option `{key}` has no value")),
                Some(text) if key == "fault" => match text.parse() {
                    Ok(fault) => spec.faults.push(fault),
                    Err(error) => mistakes.push(error.to_string()),
                },
                Some(_) if !options(known).any(|(name, ..)| name == key) => {
                    let names: Vec<_> = options(known).map(|(name, ..)| name).collect();
                    mistakes
                        .push(format!("`{kind}` has no option `{key}`: it has {}, fault", names.join(", ")));
                }
                Some(value) => {
                    if spec.values.insert(key.clone(), value.to_owned()).is_some() {
                        mistakes.push(format!("option `{key}` is given twice"));
                    }
                }
            }
        }
        if mistakes.is_empty() { Ok(spec) } else { Err(SpecError(mistakes)) }
    }

    /// Makes the mock, unguarded: put it behind [`interfaces::Guarded`] where nothing else watches the order
    /// of calls.
    pub fn build(&self) -> Result<Box<dyn Participant>, SpecError> {
        let kind = KINDS.iter().find(|k| k.name == self.kind).expect("the kind was found before");
        let mut read = Read { spec: self, kind, mistakes: Vec::new() };
        let mock = make(&mut read);
        match mock {
            Some(mock) if read.mistakes.is_empty() && self.faults.is_empty() => Ok(mock),
            Some(mock) if read.mistakes.is_empty() => Ok(Box::new(Faulty::new(mock, self.faults.clone()))),
            _ => Err(SpecError(read.mistakes)),
        }
    }
}

impl FromStr for MockSpec {
    type Err = SpecError;

    fn from_str(text: &str) -> Result<Self, SpecError> {
        Self::from_words(&text.split_whitespace().collect::<Vec<_>>())
    }
}

/// Makes a mock from one line of words; see [`MockSpec::from_words`].
pub fn build(spec: &str) -> Result<Box<dyn Participant>, SpecError> {
    spec.parse::<MockSpec>()?.build()
}

/// All kinds with their options, for a command's help.
pub fn help() -> String {
    let mut text = String::new();
    let mut list = |title: &str, options: &[Choice]| {
        writeln!(text, "{title}").expect("a string takes all");
        for (name, default, meaning) in options {
            let default = match default {
                Some("") => String::new(),
                Some(value) => format!(" [{value}]"),
                None => " (required)".to_owned(),
            };
            writeln!(text, "    --{:<16} {meaning}{default}", name.replace('_', "-"))
                .expect("a string takes all");
        }
    };
    for kind in KINDS {
        list(&format!("{}: {}", kind.name, kind.summary), kind.options);
    }
    list("every structure", STRUCTURE);
    list("every fluid but surface-pressure", FLUID);
    list("every mock but idle, scripted and surface-pressure", ANY);
    let fault: Choice = (
        "fault",
        Some(""),
        "KIND@WHERE, may be repeated: error, panic, nan[:POINT], inf[:POINT], bit[:POINT], no-points,",
    );
    list("every mock", &[fault]);
    text.push_str(
        "                       scalars, limit:SECONDS, hang, slow:SECONDS, abort, exit, kill or stop, at WINDOW[.ITERATION][/CALL],\n                       *[/CALL] or CALL, as nan@12, kill@3.1/start, error@terminate\n",
    );
    text
}

fn options(kind: &Kind) -> impl Iterator<Item = Choice> {
    let (any, side): (&[Choice], &[Choice]) = match kind.side {
        Side::Structure => (ANY, STRUCTURE),
        Side::Fluid => (ANY, FLUID),
        Side::FluidOfItsOwnPoints | Side::Either => (&[], &[]),
    };
    kind.options.iter().chain(side).chain(any).copied()
}

fn make(read: &mut Read) -> Option<Box<dyn Participant>> {
    if read.kind.name == "scripted" {
        return read.script().map(|script| Box::new(Scripted::new(script)) as _);
    }
    if read.kind.name == "idle" {
        return read.idle().map(|idle| Box::new(idle) as _);
    }
    if read.kind.name == "surface-pressure" {
        let outline = read.text("outline")?;
        let (origin, spacing) = (read.vector("origin", 2), read.positive("spacing"));
        let mock = SurfacePressure {
            density: read.positive("density"),
            gravity: read.number("gravity"),
            level: read.number("level"),
            outline: read.outline(&outline, 2, &origin, spacing, 1.0)?,
        };
        return stand_in(Some(mock), f64::INFINITY);
    }
    let d = read.dimension()?;
    let limit = read.positive("window_limit");
    match read.kind.name {
        "rigid" => stand_in(read.points(d).map(|points| Rigid { points }), limit),
        "prescribed" => {
            let law = match read.one_of("law", &["heave", "constant-velocity", "swing"])? {
                "heave" => {
                    Law::Heave { amplitude: read.vector("amplitude", d), frequency: read.number("frequency") }
                }
                "constant-velocity" => Law::ConstantVelocity { velocity: read.vector("velocity", d) },
                _ => Law::Swing {
                    pivot: read.vector("pivot", d),
                    angle: read.number("angle"),
                    duration: read.positive("duration"),
                },
            };
            stand_in(read.points(d).map(|points| Prescribed { points, law }), limit)
        }
        "spring-mass" => {
            let integration = match read.one_of("integration", &["exact", "rk4"])? {
                "exact" => Integration::Exact,
                _ => Integration::Rk4,
            };
            let linear = read.one_of("load", &["held", "linear"])? == "linear";
            let (stiffness, damping) = (read.at_least("stiffness", 0.0), read.at_least("damping", 0.0));
            let (displacement, velocity) = (read.vector("displacement", d), read.vector("velocity", d));
            let mock = read.points(d).map(|points| SpringMass {
                points,
                stiffness,
                damping,
                displacement,
                velocity,
                integration,
                linear,
            });
            stand_in(mock, limit)
        }
        "hydrostatic" => {
            let thickness = read.at_least("plate_thickness", 0.0);
            let mock = Hydrostatic {
                load: read.load(d),
                density: read.positive("density"),
                gravity: read.number("gravity"),
                level: read.number("level"),
                plate_thickness: (thickness > 0.0).then_some(thickness),
            };
            stand_in(Some(mock), limit)
        }
        "constant" => {
            let mock = Constant {
                load: read.load(d),
                gradient: read.vector("gradient", d),
                pressure: read.number("pressure"),
                end_after: read.positive("end_after"),
            };
            stand_in(Some(mock), limit)
        }
        "harmonic" => {
            let mock = Harmonic {
                load: read.load(d),
                gradient: read.vector("gradient", d),
                frequency: read.number("frequency"),
            };
            stand_in(Some(mock), limit)
        }
        "added-mass-column" => {
            let wall = match read.one_of("wall", &["moving", "compliant"])? {
                "moving" => WallModel::Moving,
                _ => WallModel::Compliant,
            };
            let axis = match read.one_of("axis", &["x", "y", "z", "up"])? {
                "x" => 0,
                "y" => 1,
                "z" if d < 3 => {
                    read.mistakes.push("option `axis` is z, which takes three dimensions".to_owned());
                    return None;
                }
                _ => d - 1,
            };
            let mut mock = AddedMassColumn::new(d, read.at_least("mass", 0.0), axis, wall);
            mock.velocity = match read.one_of("velocity", &["mean", "end"])? {
                "mean" => GivenVelocity::Mean,
                _ => GivenVelocity::End,
            };
            mock.load = read.load(d);
            mock.gravity = read.number("gravity");
            mock.area = read.positive("area");
            stand_in(Some(mock), limit)
        }
        name => unreachable!("`{name}` stands in the list of kinds and has an arm here"),
    }
}

fn stand_in<M: Model + 'static>(model: Option<M>, limit: f64) -> Option<Box<dyn Participant>> {
    Some(Box::new(StandIn::new(model?).with_window_limit(limit)))
}

/// Reads options with their defaults, and gathers the mistakes.
struct Read<'a> {
    spec: &'a MockSpec,
    kind: &'a Kind,
    mistakes: Vec<String>,
}

impl Read<'_> {
    fn text(&mut self, key: &str) -> Option<String> {
        let (_, default, meaning) =
            options(self.kind).find(|(name, ..)| *name == key).expect("a listed option is read");
        let text = self.spec.values.get(key).map(String::as_str).or(default);
        if text.is_none() {
            self.mistakes.push(format!("option `{key}` must be given: {meaning}"));
        }
        text.map(str::to_owned)
    }

    fn wrong<T>(&mut self, key: &str, text: &str, wanted: &str) -> Option<T> {
        self.mistakes.push(format!("option `{key}` is `{text}`, which is not {wanted}"));
        None
    }

    fn number(&mut self, key: &str) -> f64 {
        self.bounded(key, "a number", |_| true)
    }

    fn positive(&mut self, key: &str) -> f64 {
        self.bounded(key, "a positive number", |x| x > 0.0)
    }

    fn at_least(&mut self, key: &str, least: f64) -> f64 {
        self.bounded(key, &format!("a number of at least {least}"), |x| x >= least)
    }

    /// A mistake gives 1, which is never used: mistakes make no mock.
    fn bounded(&mut self, key: &str, wanted: &str, fits: impl Fn(f64) -> bool) -> f64 {
        let Some(text) = self.text(key) else { return 1.0 };
        match text.parse::<f64>() {
            Ok(value)
                if fits(value)
                    && !value.is_nan()
                    && (value.is_finite() || ["window_limit", "end_after"].contains(&key)) =>
            {
                value
            }
            _ => self.wrong(key, &text, wanted).unwrap_or(1.0),
        }
    }

    /// One number for all components, or one each; more than `d` numbers are a mistake unless they are the
    /// default.
    fn vector(&mut self, key: &str, d: usize) -> Vec<f64> {
        let Some(text) = self.text(key) else { return vec![0.0; d] };
        let values: Vec<f64> = text.split(',').map_while(|x| x.trim().parse().ok()).collect();
        let whole = values.len() == text.split(',').count() && values.iter().all(|x| x.is_finite());
        match values.len() {
            1 if whole => vec![values[0]; d],
            n if whole && n == d => values,
            // A default is written for two dimensions.
            n if n < d && !self.spec.values.contains_key(key) => [vec![0.0; d - n], values].concat(),
            _ => {
                let wanted = format!("one number or {d} numbers with commas");
                self.wrong(key, &text, &wanted).unwrap_or_else(|| vec![0.0; d])
            }
        }
    }

    fn one_of(&mut self, key: &str, choices: &[&'static str]) -> Option<&'static str> {
        let text = self.text(key)?;
        let found = choices.iter().find(|choice| **choice == text).copied();
        found.or_else(|| self.wrong(key, &text, &format!("one of {}", choices.join(", "))))
    }

    fn dimension(&mut self) -> Option<usize> {
        match self.one_of("dimension", &["2", "3"])? {
            "2" => Some(2),
            _ => Some(3),
        }
    }

    fn load(&mut self, d: usize) -> Load {
        Load { reaction_factor: self.number("reaction_factor"), ..Load::new(d) }
    }

    fn points(&mut self, d: usize) -> Option<Points> {
        let grid = self.text("grid")?;
        let mut counts = vec![1; d];
        if grid.is_empty() {
            let text = self.text("points")?;
            counts[0] = match text.parse::<usize>() {
                Ok(count) if count > 0 => count,
                _ => return self.wrong("points", &text, "a positive whole number"),
            };
        } else {
            let read: Vec<usize> = grid.split('x').filter_map(|n| n.parse().ok()).collect();
            if read.len() != d || grid.split('x').count() != d || read.contains(&0) {
                let wanted = format!("{d} positive whole numbers with x between them");
                return self.wrong("grid", &grid, &wanted);
            }
            counts = read;
        }
        let origin = self.vector("origin", d);
        let (spacing, density) = (self.positive("spacing"), self.positive("density"));
        let outline = self.text("outline")?;
        if !outline.is_empty() {
            return self.outline(&outline, d, &origin, spacing, density);
        }
        Some(Points::on_lattice(&counts, &origin, spacing, density))
    }

    fn outline(
        &mut self,
        text: &str,
        d: usize,
        origin: &[f64],
        spacing: f64,
        density: f64,
    ) -> Option<Points> {
        let counts: Vec<usize> = text.split('x').filter_map(|n| n.parse().ok()).collect();
        match counts[..] {
            [nx, ny] if d == 2 && nx > 0 && ny > 0 && text.split('x').count() == 2 => {
                Some(Points::on_outline([nx, ny], origin, spacing, density))
            }
            _ => {
                let wanted = "two positive whole numbers with x between them, in two dimensions";
                self.wrong("outline", text, wanted)
            }
        }
    }

    fn idle(&mut self) -> Option<Idle> {
        let role = match self.one_of("role", &["fluid", "structure"])? {
            "fluid" => Role::Fluid,
            _ => Role::Structure,
        };
        let count = self.at_least("points", 1.0) as usize;
        let [varies, interpolates] =
            ["varies", "interpolates"].map(|key| self.one_of(key, &["no", "yes"]).map(|word| word == "yes"));
        Some(Idle::new(role, count, varies?, interpolates?))
    }

    fn script(&mut self) -> Option<Script> {
        let path = self.text("file")?;
        let script = std::fs::read_to_string(&path).map_err(|error| error.to_string());
        match script.and_then(|text| serde_json::from_str(&text).map_err(|error| error.to_string())) {
            Ok(script) => Some(script),
            Err(error) => {
                self.mistakes.push(format!("failed to read the script {path}: {error}"));
                None
            }
        }
    }
}
