//! Vectors have as many numbers as the case has dimensions.

use crate::case::findings::Findings;
use crate::case::geometry::AxisBox;
use crate::case::keys::Case;
use crate::case::region::FluidVelocity;
use crate::case::velocity::InitialVelocity;

struct Vectors<'a> {
    dimension: usize,
    findings: &'a mut Findings,
}

/// Reports vectors of another length, and replaces them by NaN of the right one.
pub(super) fn check(file: &mut Case, findings: &mut Findings) {
    let mut vectors = Vectors { dimension: file.general.dimension, findings };
    vectors.vector("case.gravity", &mut file.general.gravity);
    if let Some(fluid) = &mut file.fluid {
        vectors.bounds("fluid.domain", &mut fluid.domain);
        for (i, region) in fluid.regions.iter_mut().enumerate() {
            if let Some(bounds) = &mut region.bounds {
                vectors.bounds(&format!("fluid.region.{i}.box"), bounds);
            }
            if let Some(ball) = &mut region.ball {
                vectors.vector(&format!("fluid.region.{i}.ball.centre"), &mut ball.centre);
            }
            if let FluidVelocity::Uniform(v) = &mut region.velocity {
                vectors.vector(&format!("fluid.region.{i}.velocity"), v);
            }
            let key = format!("fluid.region.{i}.velocity_gradient");
            vectors.square(&key, &mut region.velocity_gradient);
        }
        for (i, wall) in fluid.walls.iter_mut().enumerate() {
            if let Some(bounds) = &mut wall.bounds {
                vectors.bounds(&format!("fluid.wall.{i}.box"), bounds);
            }
            for (k, point) in wall.polyline.iter_mut().flatten().enumerate() {
                vectors.vector(&format!("fluid.wall.{i}.polyline.{k}"), point);
            }
            vectors.vector(&format!("fluid.wall.{i}.velocity"), &mut wall.velocity);
            if let Some(motion) = &mut wall.motion {
                vectors.optional(&format!("fluid.wall.{i}.motion.direction"), &mut motion.direction);
                vectors.optional(&format!("fluid.wall.{i}.motion.pivot"), &mut motion.pivot);
            }
        }
    }
    if let Some(structure) = &mut file.structure {
        for (i, body) in structure.bodies.iter_mut().enumerate() {
            vectors.bounds(&format!("structure.body.{i}.box"), &mut body.bounds);
            match &mut body.velocity {
                InitialVelocity::Uniform(v) => vectors.vector(&format!("structure.body.{i}.velocity"), v),
                InitialVelocity::Mode(mode) => {
                    let key = format!("structure.body.{i}.velocity.tip_velocity");
                    vectors.vector(&key, &mut mode.tip_velocity);
                }
            }
        }
        for (i, clamp) in structure.clamps.iter_mut().enumerate() {
            if let Some(bounds) = &mut clamp.bounds {
                vectors.bounds(&format!("structure.clamp.{i}.box"), bounds);
            }
            if let Some(circle) = &mut clamp.circle {
                vectors.vector(&format!("structure.clamp.{i}.circle.centre"), &mut circle.centre);
            }
        }
        for (i, load) in structure.loads.iter_mut().enumerate() {
            vectors.optional(&format!("structure.load.{i}.at"), &mut load.at);
            vectors.vector(&format!("structure.load.{i}.force"), &mut load.force);
        }
    }
    for (i, probe) in file.probes.iter_mut().enumerate() {
        vectors.optional(&format!("probe.{i}.at"), &mut probe.at);
        if let Some(bounds) = &mut probe.bounds {
            vectors.bounds(&format!("probe.{i}.box"), bounds);
        }
    }
}

impl Vectors<'_> {
    fn vector(&mut self, key: &str, vector: &mut Vec<f64>) {
        if vector.len() != self.dimension {
            self.findings.add(
                key,
                format!("has {} numbers in {} dimensions", vector.len(), self.dimension),
                format!("write {} numbers", self.dimension),
            );
            *vector = vec![f64::NAN; self.dimension];
        }
    }

    fn square(&mut self, key: &str, matrix: &mut Vec<Vec<f64>>) {
        if matrix.len() != self.dimension {
            self.findings.add(
                key,
                format!("has {} rows in {} dimensions", matrix.len(), self.dimension),
                format!("write {} rows", self.dimension),
            );
            *matrix = vec![vec![f64::NAN; self.dimension]; self.dimension];
        }
        for (i, row) in matrix.iter_mut().enumerate() {
            self.vector(&format!("{key}.{i}"), row);
        }
    }

    fn optional(&mut self, key: &str, vector: &mut Option<Vec<f64>>) {
        if let Some(vector) = vector {
            self.vector(key, vector);
        }
    }

    fn bounds(&mut self, key: &str, bounds: &mut AxisBox) {
        self.vector(&format!("{key}.low"), &mut bounds.low);
        self.vector(&format!("{key}.high"), &mut bounds.high);
    }
}
