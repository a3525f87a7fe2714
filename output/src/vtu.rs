//! Particle snapshots as VTU files: VTK XML unstructured grids of one vertex cell a particle, as ParaView,
//! pyvista and meshio open them. The reader for the report is [`read`].
//!
//! The layout is that of the VTK file format, version 1.0: arrays `appended` to the XML part in base64 (so
//! the whole file is well-formed XML), little-endian, each with a `UInt64` byte count before it. Points and
//! vectors have three components in VTK; two-dimensional ones are padded with zeros. The time stands in the
//! field array `TimeValue`, the dimension in `Dimension`.

mod reader;

pub use reader::{Array, Frame, read};

use crate::atomic;
use crate::error::{Error, Result};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use std::fmt::Write as _;
use std::path::Path;

/// The particles of one medium at one time, borrowed from the solver.
#[derive(Debug, Clone, Copy)]
pub struct ParticleFrame<'a> {
    /// Simulated time in s.
    pub time: f64,
    /// Components of a position: 2 or 3.
    pub dimension: usize,
    /// Positions in m, `dimension` values a particle, particle after particle.
    pub positions: &'a [f64],
    /// What the particles carry.
    pub arrays: &'a [PointArray<'a>],
}

/// One quantity on all particles of a frame.
#[derive(Debug, Clone, Copy)]
pub struct PointArray<'a> {
    /// Name as it stands in the file, for example `pressure`.
    pub name: &'a str,
    /// Values a particle: 1 for a scalar, `dimension` for a vector (padded to 3 in the file), any other
    /// number is written as it is (a symmetric tensor in two dimensions: 4 for `xx, yy, xy, zz`, say).
    pub components: usize,
    /// The values, `components` a particle, particle after particle.
    pub values: Values<'a>,
}

impl<'a> PointArray<'a> {
    /// A real number a particle.
    pub fn scalar(name: &'a str, values: &'a [f64]) -> Self {
        Self { name, components: 1, values: Values::F64(values) }
    }

    /// A vector a particle, of as many components as the frame has dimensions.
    pub fn vector(name: &'a str, dimension: usize, values: &'a [f64]) -> Self {
        Self { name, components: dimension, values: Values::F64(values) }
    }

    /// A small whole number a particle: a surface class, a part.
    pub fn class(name: &'a str, values: &'a [u8]) -> Self {
        Self { name, components: 1, values: Values::U8(values) }
    }
}

/// Values of a [`PointArray`], and with them their type in the file.
#[derive(Debug, Clone, Copy)]
pub enum Values<'a> {
    /// `Float64`.
    F64(&'a [f64]),
    /// `Float32`: half the size where six digits are enough.
    F32(&'a [f32]),
    /// `Int32`.
    I32(&'a [i32]),
    /// `UInt8`.
    U8(&'a [u8]),
}

impl Values<'_> {
    fn len(&self) -> usize {
        match self {
            Self::F64(v) => v.len(),
            Self::F32(v) => v.len(),
            Self::I32(v) => v.len(),
            Self::U8(v) => v.len(),
        }
    }

    fn type_name(&self) -> &'static str {
        match self {
            Self::F64(_) => "Float64",
            Self::F32(_) => "Float32",
            Self::I32(_) => "Int32",
            Self::U8(_) => "UInt8",
        }
    }

    /// Little-endian bytes, `components` a particle padded with zeros to `padded`.
    fn bytes(&self, components: usize, padded: usize) -> Vec<u8> {
        match self {
            Self::F64(v) => pad(v, components, padded, f64::to_le_bytes),
            Self::F32(v) => pad(v, components, padded, f32::to_le_bytes),
            Self::I32(v) => pad(v, components, padded, i32::to_le_bytes),
            Self::U8(v) => pad(v, components, padded, u8::to_le_bytes),
        }
    }
}

fn pad<T: Copy + Default, const N: usize>(
    values: &[T],
    components: usize,
    padded: usize,
    to_bytes: impl Fn(T) -> [u8; N],
) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(values.len() / components * padded * N);
    for particle in values.chunks_exact(components) {
        particle.iter().for_each(|&value| bytes.extend(to_bytes(value)));
        (components..padded).for_each(|_| bytes.extend(to_bytes(T::default())));
    }
    bytes
}

/// Writes `frame` to `path` in one piece (see [`atomic::write_file`]).
///
/// Values are written as they are, not-a-number included: a snapshot of a broken state helps to find the
/// break.
///
/// # Errors
/// [`Error::Frame`] if the dimension is neither 2 nor 3, an array's length is not `components` times the
/// number of particles, or a name is empty or used twice; [`Error::Write`] if the file cannot be written.
pub fn write(path: &Path, frame: &ParticleFrame) -> Result<()> {
    check(frame)?;
    atomic::write_file(path, document(frame).as_bytes())
}

fn check(frame: &ParticleFrame) -> Result<()> {
    let fail = |reason: String| Err(Error::Frame { time: frame.time, reason });
    if !(2..=3).contains(&frame.dimension) {
        return fail(format!("dimension is {}, it has to be 2 or 3", frame.dimension));
    }
    if !frame.positions.len().is_multiple_of(frame.dimension) {
        return fail(format!("{} coordinates are no multiple of {}", frame.positions.len(), frame.dimension));
    }
    let particles = frame.positions.len() / frame.dimension;
    for (index, array) in frame.arrays.iter().enumerate() {
        if array.name.is_empty() || frame.arrays[..index].iter().any(|other| other.name == array.name) {
            return fail(format!("array {index} needs a name of its own, it has `{}`", array.name));
        }
        if array.components == 0 || array.values.len() != particles * array.components {
            return fail(format!(
                "array `{}` has {} values; {particles} particles of {} components need {}",
                array.name,
                array.values.len(),
                array.components,
                particles * array.components
            ));
        }
    }
    Ok(())
}

fn document(frame: &ParticleFrame) -> String {
    let particles = frame.positions.len() / frame.dimension;
    // Connectivity 0, 1, 2, … and offsets 1, 2, 3, …: one vertex a cell.
    let connectivity: Vec<i32> = (0..particles as i32).collect();
    let offsets: Vec<i32> = (1..=particles as i32).collect();
    const VTK_VERTEX: u8 = 1;
    let types = vec![VTK_VERTEX; particles];

    let mut appended = Appended::default();
    let mut xml = String::new();
    xml.push_str("<?xml version=\"1.0\"?>\n");
    xml.push_str(
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n",
    );
    xml.push_str("<UnstructuredGrid>\n<FieldData>\n");
    xml.push_str(&appended.array("TimeValue", &Values::F64(&[frame.time]), 1, 1, Some(1)));
    xml.push_str(&appended.array("Dimension", &Values::I32(&[frame.dimension as i32]), 1, 1, Some(1)));
    let _ = writeln!(
        xml,
        "</FieldData>\n<Piece NumberOfPoints=\"{particles}\" NumberOfCells=\"{particles}\">\n<Points>"
    );
    xml.push_str(&appended.array("Points", &Values::F64(frame.positions), frame.dimension, 3, None));
    xml.push_str("</Points>\n<Cells>\n");
    xml.push_str(&appended.array("connectivity", &Values::I32(&connectivity), 1, 1, None));
    xml.push_str(&appended.array("offsets", &Values::I32(&offsets), 1, 1, None));
    xml.push_str(&appended.array("types", &Values::U8(&types), 1, 1, None));
    xml.push_str("</Cells>\n<PointData>\n");
    for array in frame.arrays {
        let padded = if array.components == 2 { 3 } else { array.components };
        xml.push_str(&appended.array(array.name, &array.values, array.components, padded, None));
    }
    xml.push_str("</PointData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"base64\">\n_");
    xml.push_str(&appended.text);
    xml.push_str("\n</AppendedData>\n</VTKFile>\n");
    xml
}

/// The text after the underscore of `AppendedData`; offsets count its characters.
#[derive(Default)]
struct Appended {
    text: String,
}

impl Appended {
    /// Appends the values and returns the `DataArray` element that points at them.
    fn array(
        &mut self,
        name: &str,
        values: &Values,
        components: usize,
        padded: usize,
        tuples: Option<usize>,
    ) -> String {
        let data = values.bytes(components, padded);
        let mut block = (data.len() as u64).to_le_bytes().to_vec();
        block.extend(data);
        let offset = self.text.len();
        BASE64.encode_string(&block, &mut self.text);
        let tuples = tuples.map(|n| format!(" NumberOfTuples=\"{n}\"")).unwrap_or_default();
        format!(
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{padded}\"{tuples} format=\"appended\" \
             offset=\"{offset}\"/>\n",
            values.type_name(),
            crate::xml::escape(name),
        )
    }
}
