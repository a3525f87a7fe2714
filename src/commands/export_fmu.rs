//! `meniscus export-fmu`.

use super::{failed, load, say, tell};
use crate::arguments::{ExportFmu, FmiVersion};
use meniscus_structure::description::Version;
use meniscus_structure::package::{self, Library};
use std::path::PathBuf;
use std::process::ExitCode;

/// Points that stand for the interface where the user does not say.
const POINTS: usize = 8;

/// Packages the structure of a case as a functional mock-up unit.
pub fn export_fmu(arguments: &ExportFmu) -> ExitCode {
    let case = match load(&arguments.case) {
        Ok(case) => case,
        Err(code) => return code,
    };
    let version = match arguments.fmi {
        FmiVersion::Two => Version::Fmi2,
        FmiVersion::Three => Version::Fmi3,
    };
    let mut libraries = arguments.library.clone();
    let own = package::this_platform();
    if !libraries.iter().any(|library| library.platform == own) {
        match own_library() {
            Some(file) => libraries.push(Library { platform: own, file }),
            None => {
                let name = package::library_name();
                return failed(format_args!(
                    "no {name} beside this executable: build it with `cargo build --release -p structure-fmu`, or name it with --library {own}=FILE"
                ));
            }
        }
    }
    let scalars = arguments.scalars || version == Version::Fmi2;
    if arguments.points.is_some() && !scalars {
        return failed("--points is for scalar variables: add --scalars, or --fmi 2");
    }
    let points = scalars.then(|| arguments.points.map_or(POINTS, |points| points as usize));
    match package::export(&case, version, points, &libraries, &arguments.output) {
        Ok(exported) => {
            let platforms: Vec<&str> = libraries.iter().map(|library| library.platform.as_str()).collect();
            say(format_args!(
                "{}: {} interface particles, {} variables, {:.1} MB, for {}",
                arguments.output.display(),
                exported.particles,
                exported.variables,
                exported.bytes as f64 / 1e6,
                platforms.join(", ")
            ));
            exported.needs.iter().for_each(say);
            if let (Some(wanted), Some(found)) = (arguments.points, exported.points)
                && found < wanted as usize
            {
                tell(format_args!(
                    "warning: --points {wanted}: the unit has {found} points, as many as there are interface particles"
                ));
            }
            ExitCode::SUCCESS
        }
        Err(error) => failed(error),
    }
}

/// The shared library that cargo made with this executable: beside it, or in `deps`.
fn own_library() -> Option<PathBuf> {
    let executable = std::env::current_exe().ok()?;
    let folder = executable.parent()?;
    let name = package::library_name();
    [folder.join("deps").join(&name), folder.join(&name), folder.join("../lib").join(&name)]
        .into_iter()
        .find(|file| file.is_file())
}
