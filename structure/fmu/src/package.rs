//! The archive: description, resources, libraries, documentation.

use crate::description::{Version, model_description, terminals};
use crate::model::{Model, ModelError};
use crate::reduction::spread_out;
use crate::resources::{CASE, POINTS, Points, Resources};
use crate::variables::{Causality, Source, Variable, table};
use crate::{MODEL_IDENTIFIER, icon, library, system};
use interfaces::case::Case;
use output::report::escape;
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;

/// A library for a platform.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Library {
    /// The platform as FMI 3.0 names it: `x86_64-linux`, `aarch64-darwin`, `x86_64-windows`, …
    pub platform: String,
    /// The shared library.
    pub file: PathBuf,
}

/// Why a unit could not be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The case makes no structure.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A library is not there.
    #[error("failed to read the library {}: {source}", .path.display())]
    Library {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A platform that FMI 2.0 has no name for.
    #[error(
        "FMI 2.0 has no name for the platform {0}; it knows x86 and x86_64 with linux, windows and darwin"
    )]
    Platform(String),
    /// Arrays as connectors of a system.
    #[error("SSP 1.0 has no arrays: export scalar variables (--scalars, or --fmi 2)")]
    Arrays,
    /// The archive could not be made.
    #[error("failed to make the archive: {0}")]
    Archive(#[from] zip::result::ZipError),
    /// The archive could not be written.
    #[error(transparent)]
    Write(#[from] output::Error),
}

/// What was exported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exported {
    /// Interface particles.
    pub particles: usize,
    /// Points that stand for them, where scalar variables are exported.
    pub points: Option<usize>,
    /// Variables in the description.
    pub variables: usize,
    /// Bytes of the archive.
    pub bytes: usize,
    /// What the libraries need of the systems that they run on, one line each where there is something.
    pub needs: Vec<String>,
}

/// Exports the structure of a case to the file `to`, its interface whole (FMI 3.0) or as scalar variables at
/// so many points of it; as the one component of a system where the file is an `.ssp`.
///
/// # Errors
/// A case without a structure, a library or a file that cannot be read or written, arrays for a standard
/// without any.
pub fn export(
    case: &Case,
    version: Version,
    points: Option<usize>,
    libraries: &[Library],
    to: &Path,
) -> Result<Exported, ExportError> {
    let is_system = to.extension().is_some_and(|ending| ending == "ssp");
    if points.is_none() && (is_system || version == Version::Fmi2) {
        return Err(ExportError::Arrays);
    }
    let mut resources = Resources::new(case, None);
    let mut model = Model::new(resources.clone())?;
    let mut particles = [0.0];
    model.read(Source::InterfacePoints, &mut particles)?;
    if let Some(points) = points {
        let mut positions = vec![0.0; model.length(Source::Position)];
        model.read(Source::Position, &mut positions)?;
        resources.points = Some(Points { points: spread_out(model.dimension(), &positions, points) });
        model = Model::new(resources.clone())?;
    }
    let variables = table(model.describe(), model.reduced_points());
    let mut files = vec![
        ("modelDescription.xml".to_owned(), model_description(&mut model, version)?.into_bytes()),
        (format!("resources/{CASE}"), resources.case.clone().into_bytes()),
        ("documentation/index.html".to_owned(), documentation(case, &variables, version).into_bytes()),
        ("documentation/licenses/LICENSE-MIT".to_owned(), include_bytes!("../../../LICENSE-MIT").to_vec()),
        (
            "documentation/licenses/LICENSE-APACHE".to_owned(),
            include_bytes!("../../../LICENSE-APACHE").to_vec(),
        ),
    ];
    if let Some(points) = resources.points_text() {
        files.push((format!("resources/{POINTS}"), points.into_bytes()));
    }
    match version {
        Version::Fmi3 => {
            files.push((
                "terminalsAndIcons/terminalsAndIcons.xml".to_owned(),
                terminals(&variables).into_bytes(),
            ));
            files.push(("terminalsAndIcons/icon.png".to_owned(), icon::png()));
        }
        Version::Fmi2 => files.push(("model.png".to_owned(), icon::png())),
    }
    let mut needs = Vec::new();
    for Library { platform, file } in libraries {
        let bytes =
            std::fs::read(file).map_err(|source| ExportError::Library { path: file.clone(), source })?;
        if let Some((major, minor)) = library::needed_glibc(&bytes) {
            needs.push(format!("{platform} needs the GNU C library {major}.{minor} or later"));
        }
        let ending = match platform.rsplit('-').next() {
            Some("windows") => "dll",
            Some("darwin") => "dylib",
            _ => "so",
        };
        let folder = match version {
            Version::Fmi3 => platform.clone(),
            Version::Fmi2 => folder_2(platform)?.to_owned(),
        };
        files.push((format!("binaries/{folder}/{MODEL_IDENTIFIER}.{ending}"), library::stripped(bytes)));
    }
    let mut bytes = archive(files)?;
    if is_system {
        let described = system::description(&case.general.title, case.general.end_time, &variables);
        let parts = [(system::DESCRIPTION, described.into_bytes()), (system::UNIT, bytes)];
        bytes = archive(parts.map(|(name, bytes)| (name.to_owned(), bytes)).into())?;
    }
    output::atomic::write_file(to, &bytes)?;
    let (particles, points) = (particles[0] as usize, model.reduced_points().map(<[_]>::len));
    Ok(Exported { particles, points, variables: variables.len(), bytes: bytes.len(), needs })
}

/// The same date in every archive: what is exported twice is the same to the bit.
fn archive(files: Vec<(String, Vec<u8>)>) -> Result<Vec<u8>, ExportError> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().unix_permissions(0o644);
    for (name, bytes) in files {
        archive.start_file(name, options)?;
        archive.write_all(&bytes).map_err(zip::result::ZipError::Io)?;
    }
    Ok(archive.finish()?.into_inner())
}

fn folder_2(platform: &str) -> Result<&'static str, ExportError> {
    Ok(match platform {
        "x86_64-linux" => "linux64",
        "x86-linux" => "linux32",
        "x86_64-windows" => "win64",
        "x86-windows" => "win32",
        "x86_64-darwin" => "darwin64",
        other => return Err(ExportError::Platform(other.to_owned())),
    })
}

/// The platform of this build, as FMI 3.0 names it.
pub fn this_platform() -> String {
    let system = match std::env::consts::OS {
        "macos" => "darwin",
        other => other,
    };
    format!("{}-{system}", std::env::consts::ARCH)
}

/// The file name of the shared library on this platform, as cargo makes it.
pub fn library_name() -> String {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    format!("{DLL_PREFIX}{MODEL_IDENTIFIER}{DLL_SUFFIX}")
}

fn documentation(case: &Case, variables: &[Variable], version: Version) -> String {
    let mut rows = String::new();
    for variable in variables {
        let shape = match variable.shape {
            crate::variables::Shape::Scalar => "",
            crate::variables::Shape::Points => "[interface_points]",
            crate::variables::Shape::PointVectors => "[interface_points][dimension]",
        };
        let _ = writeln!(
            rows,
            "<tr><td><code>{}</code>{shape}</td><td>{:?}</td><td>{}</td><td>{}</td></tr>",
            escape(&variable.name),
            variable.causality,
            variable.quantity.map_or("", |q| q.unit()),
            escape(&variable.description)
        );
    }
    let inputs: Vec<&str> =
        variables.iter().filter(|v| v.causality == Causality::Input).map(|v| v.name.as_str()).collect();
    let title = escape(&case.general.title);
    let number = match version {
        Version::Fmi3 => "3.0",
        Version::Fmi2 => "2.0",
    };
    let reduced = variables.iter().any(|variable| matches!(variable.source, Source::PointForce(..)));
    let standard = format!("FMI {number}{}", if reduced { ", the interface reduced to points" } else { "" });
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title></head><body>\n<h1>{title}</h1>\n<p>The elastic structure of a meniscus case as a co-simulation unit ({standard}): total-Lagrangian SPH, fourth-order Runge and Kutta steps. A communication step holds the load that is set ({}) and sub-steps inside it; outputs are those at its end and depend on no input of the same instant. Damping, loads and supports are those of <code>resources/{CASE}</code>.</p>\n<table>\n<tr><th>variable</th><th>causality</th><th>unit</th><th></th></tr>\n{rows}</table>\n<p>License: MIT or Apache-2.0, at your choice (<code>licenses</code>).</p>\n</body></html>\n",
        escape(inputs.first().copied().unwrap_or("none"))
    )
}
