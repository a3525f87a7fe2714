//! What can be wrong with point sets that are to be mapped.

use std::fmt;
use thiserror::Error;

/// Which of the two point sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointSet {
    /// The points whose motion is known.
    Source,
    /// The points that are to follow.
    Target,
}

impl fmt::Display for PointSet {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Source => "source",
            Self::Target => "target",
        })
    }
}

/// Why a mapping could not be built, or a load not be mapped. Points are counted from zero.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MappingError {
    /// Neither a plane nor space.
    #[error("points of {dimension} coordinates cannot be mapped: give 2 or 3")]
    Dimension {
        /// Coordinates of a point.
        dimension: usize,
    },
    /// A flat slice that holds no whole number of points.
    #[error("{length} {set} coordinates are no whole number of points of {dimension}")]
    Length {
        /// The point set.
        set: PointSet,
        /// Doubles given.
        length: usize,
        /// Coordinates of a point.
        dimension: usize,
    },
    /// A coordinate that is not a number or infinite.
    #[error("{set} point {point} is at {position:?}: its participant gave a position that is not finite")]
    NotFinite {
        /// The point set.
        set: PointSet,
        /// The point.
        point: usize,
        /// Its coordinates (m).
        position: Vec<f64>,
    },
    /// There are targets and nothing to map from.
    #[error("there are {targets} target points and no source point to map from")]
    NoSource {
        /// Number of targets.
        targets: usize,
    },
    /// A target too far from what it is to follow.
    #[error(
        "target point {point} at {position:?} lies {distance} m from the nearest source point or boundary, and the reach of the \
         mapping is {reach} m: bring the point sets into one configuration, or raise the reach"
    )]
    OutOfReach {
        /// The point.
        point: usize,
        /// Its coordinates (m).
        position: Vec<f64>,
        /// How far it is off (m).
        distance: f64,
        /// How far it may be (m).
        reach: f64,
    },
    /// Source points around a target that do not determine a linear field there.
    #[error(
        "target point {point} at {position:?} cannot follow a rotation: the {sources} source points around it are fewer than \
         needed, or lie on a line or plane that the target is off; add source points across that line or plane, or map by \
         `nearest-projection` with a boundary that has a far side"
    )]
    Degenerate {
        /// The point.
        point: usize,
        /// Its coordinates (m).
        position: Vec<f64>,
        /// Source points that were looked at.
        sources: usize,
    },
    /// Two source points in one place, where each needs a value of its own.
    #[error(
        "source points {first} and {second} coincide: radial basis functions need them apart; leave one out"
    )]
    Coincident {
        /// One of them.
        first: usize,
        /// The other.
        second: usize,
    },
    /// A target off a boundary that has no other side behind it.
    #[error(
        "target point {point} at {position:?} cannot follow a rotation: it lies {distance} m off the boundary, and no line through it \
         meets the boundary's far side; close the boundary, or turn its facets outwards (anticlockwise in the plane)"
    )]
    NoFarSide {
        /// The point.
        point: usize,
        /// Its coordinates (m).
        position: Vec<f64>,
        /// Distance to the nearest point of the boundary (m).
        distance: f64,
    },
    /// A list of facets that does not fit the points.
    #[error("facet {facet} of the boundary names point {vertex}, and there are {points} source points")]
    Vertex {
        /// The facet.
        facet: usize,
        /// The vertex it names.
        vertex: usize,
        /// Source points there are.
        points: usize,
    },
    /// A list of facets that holds no whole number of them, or none.
    #[error(
        "a boundary of {length} vertex numbers is no whole, positive number of facets of {dimension} vertices"
    )]
    Facets {
        /// Vertex numbers given.
        length: usize,
        /// Vertices of a facet: the dimension.
        dimension: usize,
    },
    /// A facet without extent.
    #[error(
        "facet {facet} of the boundary has no extent: its vertices {vertices:?} coincide or lie on a line"
    )]
    FlatFacet {
        /// The facet.
        facet: usize,
        /// Its vertices.
        vertices: Vec<usize>,
    },
    /// A closed boundary turned inside out.
    #[error(
        "the closed boundary has its facets turned inwards (it encloses {volume} m³): swap two vertices of every facet"
    )]
    Inwards {
        /// Signed volume enclosed (m³, in the plane m² times one metre).
        volume: f64,
    },
    /// A load per volume asked for a point without volume.
    #[error(
        "source point {point} has the volume {volume} m³: a load per volume needs a positive one; map forces instead"
    )]
    Volume {
        /// The point.
        point: usize,
        /// Its volume (m³).
        volume: f64,
    },
}
