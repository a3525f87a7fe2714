//! The keys of a case, each declared once: name, meaning, type and range of a key are those of its field,
//! here and in [`super::fluid`], [`super::structure`], [`super::motion`], [`super::probe`],
//! [`super::coupling`], [`super::checkpoints`] and the solvers' sections. A field whose schema is an `Option`
//! may be left out, and `defaults` says what it is then.

use super::checkpoints::Checkpoints;
use super::coupling::Coupling;
use super::fluid::Fluid;
use super::geometry::PerAxis;
use super::motion::Motion;
use super::participant::Start;
use super::probe::{Probe, Reference};
use super::section::AnyTable;
use super::structure::Structure;
use crate::participant::Role;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// A meniscus case. SI units throughout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// What concerns the whole.
    #[serde(rename = "case")]
    pub general: General,
    /// The fluid; a case without it runs the structure alone.
    pub fluid: Option<Fluid>,
    /// The structure; a case without it runs the fluid alone.
    pub structure: Option<Structure>,
    /// The coupling of fluid and structure.
    #[schemars(with = "Option<AnyTable>")]
    pub coupling: Option<Coupling>,
    /// Checkpoints, from which the run can go on.
    #[serde(default)]
    pub checkpoints: Checkpoints,
    /// Motions by name, for walls, clamps and probes.
    #[serde(default, rename = "motion", skip_serializing_if = "BTreeMap::is_empty")]
    pub motions: BTreeMap<String, Motion>,
    /// Quantities recorded at every window.
    #[serde(default, rename = "probe")]
    pub probes: Vec<Probe>,
    /// Values from elsewhere, drawn beside probes in the report.
    #[serde(default, rename = "reference")]
    pub references: Vec<Reference>,
}

impl Case {
    /// Who solves a side, where there is one.
    pub fn start(&self, role: Role) -> Option<Start<'_>> {
        match role {
            Role::Fluid => self.fluid.as_ref().map(|fluid| fluid.participant.start()),
            Role::Structure => self.structure.as_ref().map(|structure| structure.participant.start()),
        }
    }

    /// What a probe may go with: the names of motions, walls and clamps, and how each moves, where it does.
    pub fn frames(&self) -> Vec<(&str, Option<&Motion>)> {
        let motions = self.motions.iter().map(|(name, motion)| (name.as_str(), Some(motion)));
        let walls = self.fluid.iter().flat_map(|fluid| &fluid.walls);
        let walls = walls.map(|wall| (wall.name.as_str(), wall.moves()));
        let clamps = self.structure.iter().flat_map(|structure| &structure.clamps);
        let clamps = clamps.map(|clamp| (clamp.name.as_str(), clamp.moves()));
        motions.chain(walls).chain(clamps).collect()
    }

    /// How the frame of a probe moves, where it does.
    pub fn frame_of(&self, probe: &Probe) -> Option<&Motion> {
        let name = probe.relative_to.as_deref()?;
        self.frames().into_iter().find(|(frame, _)| *frame == name)?.1
    }

    /// Makes the files that the case names absolute: they are sought from where `file`, the case file, is.
    pub(super) fn seek_files_from(&mut self, file: &Path) {
        let folder = file.parent().unwrap_or(Path::new(""));
        let participants = [
            self.fluid.as_mut().map(|fluid| &mut fluid.participant),
            self.structure.as_mut().map(|structure| &mut structure.participant),
        ];
        for unit in participants.into_iter().flatten().filter_map(|participant| participant.fmu.as_mut()) {
            let found = folder.join(&unit);
            *unit = std::path::absolute(&found).unwrap_or(found);
        }
    }
}

/// What concerns the whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct General {
    /// Title, one line.
    pub title: String,
    /// Space dimension, 2 or 3.
    #[schemars(extend("enum" = [2, 3]))]
    pub dimension: usize,
    /// Time at which the run ends (s); it starts at 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub end_time: f64,
    /// Time between snapshots (s); of a run that is shorter, its end time.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub output_interval: f64,
    /// Time between rows of the tables at least (s); 0, the default, is a row for every window. An output
    /// always has a row.
    #[serde(default)]
    #[schemars(extend("minimum" = 0))]
    pub record_interval: f64,
    /// Acceleration of gravity on fluid and structure (m/s²); none if left out.
    #[schemars(with = "Option<PerAxis<f64>>")]
    pub gravity: Vec<f64>,
    /// Threads of each solver; 0, the default, is as many as the machine has, and more than four for each of
    /// its cores are not started.
    #[serde(default)]
    #[schemars(extend("maximum" = 4096))]
    pub threads: usize,
    /// Particle spacing Δx of both solvers (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub particle_spacing: f64,
}
