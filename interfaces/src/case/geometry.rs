//! Boxes and their faces. Vectors in the case are lists of as many numbers as the case has dimensions; the
//! check has compared their lengths.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::marker::PhantomData;
use words::geometry::Face;

/// Word of the schema for lists of as many elements as the case has dimensions.
pub(super) const PER_AXIS: &str = "x-per-axis";

/// The schema of a list with an element for each axis: a vector, or the rows of a matrix.
pub struct PerAxis<T>(PhantomData<T>);

impl<T: JsonSchema> JsonSchema for PerAxis<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        format!("PerAxis_{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "array", "items": generator.subschema_for::<T>(), "x-per-axis": true })
    }
}

/// A box along the axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisBox {
    /// Corner with the least coordinates (m).
    #[schemars(with = "PerAxis<f64>")]
    pub low: Vec<f64>,
    /// Corner with the greatest coordinates (m).
    #[schemars(with = "PerAxis<f64>")]
    pub high: Vec<f64>,
}

impl AxisBox {
    /// Edge lengths (m).
    pub fn extent(&self) -> Vec<f64> {
        self.low.iter().zip(&self.high).map(|(low, high)| high - low).collect()
    }

    /// Cells that a lattice of about `spacing` (m) has along each axis: `round(length/spacing)`, at least
    /// one, half a cell to 1e-6 counting as one; the rule of `sph::lattice`.
    pub fn lattice_counts(&self, spacing: f64) -> Vec<usize> {
        let cells = |length: &f64| ((length / spacing + 0.5 + 1e-6).floor() as usize).max(1);
        self.extent().iter().map(cells).collect()
    }

    /// Particles on the lattice of [`Self::lattice_counts`].
    pub fn particle_count(&self, spacing: f64) -> usize {
        self.lattice_counts(spacing).iter().product()
    }

    /// Whether the boxes share more than `tolerance` (m) along every axis; touching is not overlapping.
    pub fn overlaps(&self, other: &Self, tolerance: f64) -> bool {
        let before = |low: f64, high: f64| low < high - tolerance;
        let axes = self.low.iter().zip(&self.high).zip(other.low.iter().zip(&other.high));
        axes.into_iter().all(|((low, high), (other_low, other_high))| {
            before(*low, *other_high) && before(*other_low, *high)
        })
    }

    /// Where a face of it stands on the face's axis (m).
    pub fn coordinate(&self, face: Face) -> f64 {
        if face.sign() < 0.0 { self.low[face.axis()] } else { self.high[face.axis()] }
    }

    /// The box that lies on a face of it, `depth` (m) thick.
    pub fn beyond(&self, face: Face, depth: f64) -> Self {
        let mut beyond = self.clone();
        let at = self.coordinate(face);
        beyond.low[face.axis()] = at.min(at + face.sign() * depth);
        beyond.high[face.axis()] = at.max(at + face.sign() * depth);
        beyond
    }

    /// Whether the point is farther than `tolerance` (m) from the box along some axis.
    pub fn is_clear_of(&self, point: &[f64], tolerance: f64) -> bool {
        let axes = point.iter().zip(self.low.iter().zip(&self.high));
        axes.into_iter().any(|(x, (low, high))| *x < low - tolerance || *x > high + tolerance)
    }
}

/// A ball; in two dimensions a disc.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ball {
    /// Centre (m).
    #[schemars(with = "PerAxis<f64>")]
    pub centre: Vec<f64>,
    /// Radius (m).
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: f64,
}

impl Ball {
    /// The box that just holds it.
    pub fn bounds(&self) -> AxisBox {
        let shifted = |by: f64| self.centre.iter().map(|c| c + by).collect();
        AxisBox { low: shifted(-self.radius), high: shifted(self.radius) }
    }
}

/// The list as an array.
///
/// # Panics
/// Where the list has not `D` numbers: the case's vectors have as many as its dimension, so `D` is not that.
pub fn array<const D: usize>(vector: &[f64]) -> [f64; D] {
    vector.try_into().expect("a checked case has vectors of its own dimension")
}
