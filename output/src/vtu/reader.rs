//! Reads the VTU files that this crate writes, and no others.

use crate::error::{Result, parse_error, read_error};
use crate::files;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use std::path::Path;

/// A snapshot as it was read back.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Simulated time in s.
    pub time: f64,
    /// Dimension of the run, 2 or 3.
    pub dimension: usize,
    /// Positions in m, three values a particle (the third is zero in two dimensions).
    pub positions: Vec<f64>,
    /// What the particles carry, in the file's order.
    pub arrays: Vec<Array>,
}

/// A quantity on all particles of a [`Frame`]; every type of the file becomes `f64`.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Its name.
    pub name: String,
    /// Values a particle; vectors have 3.
    pub components: usize,
    /// `components` values a particle, particle after particle.
    pub values: Vec<f64>,
}

impl Frame {
    /// Number of particles.
    pub fn particles(&self) -> usize {
        self.positions.len() / 3
    }

    /// The array of this name.
    pub fn array(&self, name: &str) -> Option<&Array> {
        self.arrays.iter().find(|array| array.name == name)
    }
}

/// Reads a file written by [`super::write`].
///
/// # Errors
/// [`crate::Error::Read`] if it cannot be read, [`crate::Error::Parse`] if it is not of that layout.
pub fn read(path: &Path) -> Result<Frame> {
    let text = files::read_text(path, files::SNAPSHOT).map_err(read_error(path))?;
    parse(&text).map_err(|reason| parse_error(path, reason))
}

fn parse(text: &str) -> std::result::Result<Frame, String> {
    const OPEN: &str = "<AppendedData encoding=\"base64\">\n_";
    let (head, tail) = text.split_once(OPEN).ok_or("it has no base64 AppendedData section")?;
    let data = tail.split_once('\n').ok_or("its AppendedData section has no end")?.0;

    let mut frame = Frame { time: f64::NAN, dimension: 3, positions: Vec::new(), arrays: Vec::new() };
    let mut section = "";
    for line in head.lines() {
        if line.starts_with("<DataArray ") {
            let array = data_array(line, data)?;
            match (section, array.name.as_str()) {
                ("<FieldData>", "TimeValue") => frame.time = first(&array)?,
                ("<FieldData>", "Dimension") => frame.dimension = first(&array)? as usize,
                ("<Points>", _) => frame.positions = array.values,
                ("<PointData>", _) => frame.arrays.push(array),
                _ => {}
            }
        } else {
            section = line;
        }
    }
    let particles = frame.particles();
    let fits = |array: &&Array| particles.checked_mul(array.components) == Some(array.values.len());
    match frame.arrays.iter().find(|array| !fits(array)) {
        Some(array) => Err(format!("array `{}` does not fit its {particles} points", array.name)),
        None => Ok(frame),
    }
}

fn first(array: &Array) -> std::result::Result<f64, String> {
    array.values.first().copied().ok_or_else(|| format!("array `{}` is empty", array.name))
}

fn data_array(line: &str, data: &str) -> std::result::Result<Array, String> {
    let name = crate::xml::unescape(attribute(line, "Name")?);
    let components: usize = number(line, "NumberOfComponents")?;
    let bytes = block(data, number(line, "offset")?).map_err(|reason| format!("array `{name}`: {reason}"))?;
    let values = match attribute(line, "type")? {
        "Float64" => decode(&bytes, f64::from_le_bytes),
        "Float32" => decode(&bytes, |b| f64::from(f32::from_le_bytes(b))),
        "Int32" => decode(&bytes, |b| f64::from(i32::from_le_bytes(b))),
        "UInt8" => decode(&bytes, |b| f64::from(u8::from_le_bytes(b))),
        other => return Err(format!("array `{name}` has type {other}, which this crate does not write")),
    };
    Ok(Array { name, components, values })
}

/// The bytes of the block that starts at character `offset`: its first eight bytes say how many follow.
fn block(data: &str, offset: usize) -> std::result::Result<Vec<u8>, String> {
    const HEADER: usize = 8;
    let cut = |length: usize| {
        // Four characters hold three bytes.
        let end = length.div_ceil(3).checked_mul(4).and_then(|long| offset.checked_add(long));
        end.and_then(|end| data.get(offset..end)).ok_or("its data end early")
    };
    let decoded = |text: &str| BASE64.decode(text).map_err(|error| format!("its base64 is broken: {error}"));
    let length = {
        // Twelve characters are nine bytes; a block without data ends in padding after eight.
        let head = decoded(cut(HEADER)?)?;
        // Padding within may leave fewer.
        let head = head.first_chunk::<HEADER>().ok_or("its length is missing")?;
        usize::try_from(u64::from_le_bytes(*head)).map_err(|_| "its length is out of range".to_owned())?
    };
    if length > data.len() {
        return Err(format!("it claims {length} bytes, more than the file has"));
    }
    let mut bytes = decoded(cut(HEADER + length)?)?;
    if bytes.len() < HEADER + length {
        return Err("its data end early".to_owned());
    }
    Ok(bytes.split_off(HEADER))
}

fn decode<const N: usize>(bytes: &[u8], from_bytes: impl Fn([u8; N]) -> f64) -> Vec<f64> {
    bytes.as_chunks::<N>().0.iter().map(|&chunk| from_bytes(chunk)).collect()
}

fn attribute<'a>(line: &'a str, name: &str) -> std::result::Result<&'a str, String> {
    line.split_once(&format!(" {name}=\""))
        .and_then(|(_, rest)| rest.split_once('"'))
        .map(|(value, _)| value)
        .ok_or_else(|| format!("attribute {name} is missing in `{line}`"))
}

fn number(line: &str, name: &str) -> std::result::Result<usize, String> {
    attribute(line, name)?.parse().map_err(|_| format!("attribute {name} is no whole number in `{line}`"))
}

#[cfg(test)]
mod tests {
    use super::super::{ParticleFrame, PointArray, Values, write};
    use super::*;

    #[test]
    fn two_dimensional_frames_come_back_padded() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("fluid.vtu");
        let arrays = [
            PointArray::scalar("pressure", &[1.5, f64::NAN, -0.0]),
            PointArray::vector("velocity", 2, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
            PointArray::class("surface_class", &[0, 2, 255]),
            PointArray { name: "a<b & \"c\"", components: 4, values: Values::F32(&[0.25; 12]) },
            PointArray { name: "index", components: 1, values: Values::I32(&[-1, 0, i32::MAX]) },
        ];
        let frame = ParticleFrame {
            time: 0.1,
            dimension: 2,
            positions: &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0],
            arrays: &arrays,
        };
        write(&path, &frame).unwrap();
        let back = read(&path).unwrap();
        assert_eq!((back.time, back.dimension, back.particles()), (0.1, 2, 3));
        assert_eq!(back.positions, [0.0, 1.0, 0.0, 2.0, 3.0, 0.0, 4.0, 5.0, 0.0]);
        assert_eq!(back.array("velocity").unwrap().values, [1.0, 2.0, 0.0, 3.0, 4.0, 0.0, 5.0, 6.0, 0.0]);
        let bits: Vec<u64> = back.array("pressure").unwrap().values.iter().map(|v| v.to_bits()).collect();
        assert_eq!(bits, [1.5f64.to_bits(), f64::NAN.to_bits(), (-0.0f64).to_bits()]);
        assert_eq!(back.array("surface_class").unwrap().values, [0.0, 2.0, 255.0]);
        assert_eq!(back.array("a<b & \"c\"").unwrap().components, 4);
        assert_eq!(back.array("index").unwrap().values, [-1.0, 0.0, 2147483647.0]);
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1, "no temporary file stays");
    }

    #[test]
    fn every_number_of_particles_decodes() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("p.vtu");
        // 0 to 6 single bytes go through every case of base64 padding.
        for n in 0..7u8 {
            let classes: Vec<u8> = (0..n).collect();
            let positions: Vec<f64> = (0..3 * n).map(f64::from).collect();
            let arrays = [PointArray::class("c", &classes)];
            write(&path, &ParticleFrame { time: 0.0, dimension: 3, positions: &positions, arrays: &arrays })
                .unwrap();
            let back = read(&path).unwrap();
            assert_eq!(back.positions, positions);
            assert_eq!(back.arrays[0].values.len(), usize::from(n));
        }
    }

    /// Found by the fuzz target `snapshot`: padding before the eighth byte, offsets and counts near the
    /// largest.
    #[test]
    fn offsets_counts_and_padding_of_any_kind_are_errors() {
        let file = |attributes: &str, data: &str| {
            format!(
                "<PointData>\n<DataArray type=\"UInt8\" Name=\"c\" {attributes}/>\n<AppendedData encoding=\"base64\">\n_{data}\n"
            )
        };
        let most = usize::MAX;
        for (attributes, data) in [
            ("NumberOfComponents=\"1\" offset=\"0\"".to_owned(), "AAAAAAAAAA=="),
            ("NumberOfComponents=\"1\" offset=\"0\"".to_owned(), "AQAAAAAAAA=="),
            (format!("NumberOfComponents=\"1\" offset=\"{most}\""), "AAAAAAAAAAA="),
            (format!("NumberOfComponents=\"{most}\" offset=\"0\""), "AQAAAAAAAAAB"),
        ] {
            assert!(parse(&file(&attributes, data)).is_err(), "{attributes} {data}");
        }
    }

    #[test]
    fn ill_fitting_arrays_and_broken_files_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("p.vtu");
        let arrays = [PointArray::scalar("pressure", &[1.0])];
        let frame = ParticleFrame { time: 2.0, dimension: 2, positions: &[0.0; 4], arrays: &arrays };
        let message = write(&path, &frame).unwrap_err().to_string();
        assert!(message.contains("`pressure`") && message.contains("2 particles"), "{message}");
        assert!(!path.exists());

        let good = ParticleFrame { arrays: &[], ..frame };
        write(&path, &good).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &text[..text.len() - 120]).unwrap();
        assert!(matches!(read(&path), Err(crate::Error::Parse { .. })));
    }
}
