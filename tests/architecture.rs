//! The invariants of `ARCHITECTURE.md`, as tests over `cargo metadata` and the sources.

use cargo_metadata::{DependencyKind, MetadataCommand};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Every crate's direct dependencies, without those of its tests.
fn dependencies() -> BTreeMap<String, BTreeSet<String>> {
    let metadata = MetadataCommand::new().no_deps().exec().expect("cargo describes this workspace");
    metadata
        .packages
        .iter()
        .map(|p| {
            let direct = p.dependencies.iter().filter(|d| d.kind == DependencyKind::Normal);
            (p.name.to_string(), direct.map(|d| d.name.clone()).collect())
        })
        .collect()
}

fn rust_files(room: &str) -> Vec<PathBuf> {
    fn walk(folder: &Path, files: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).expect("a room of the workspace") {
            let path = entry.expect("a readable folder").path();
            if path.is_dir() {
                walk(&path, files);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(path);
            }
        }
    }
    let mut files = Vec::new();
    walk(&Path::new(env!("CARGO_MANIFEST_DIR")).join(room).join("src"), &mut files);
    files
}

#[test]
fn dependencies_point_one_way() {
    let rooms = [
        "words",
        "sph",
        "interfaces",
        "output",
        "fluid",
        "structure",
        "structure-fmu",
        "coupler",
        "fmu-host",
        "validation",
        "partners",
        "meniscus",
    ];
    let allowed = BTreeMap::from([
        ("words", vec![]),
        ("sph", vec![]),
        ("interfaces", vec!["words"]),
        ("output", vec!["words"]),
        ("fluid", vec!["words", "sph", "interfaces", "output"]),
        ("structure", vec!["words", "sph", "interfaces", "output"]),
        ("structure-fmu", vec!["words", "sph", "interfaces", "output", "structure"]),
        ("coupler", vec!["words", "interfaces", "output"]),
        ("fmu-host", vec!["words", "interfaces", "output"]),
        ("validation", vec!["words", "interfaces", "output", "coupler"]),
        ("partners", vec!["words", "interfaces"]),
        (
            "meniscus",
            vec![
                "words",
                "interfaces",
                "output",
                "fluid",
                "structure",
                "structure-fmu",
                "coupler",
                "fmu-host",
                "validation",
                "partners",
            ],
        ),
    ]);
    let found = dependencies();
    for room in rooms {
        let of_room = found[room].iter().filter(|d| rooms.contains(&d.as_str()));
        for dependency in of_room {
            assert!(allowed[room].contains(&dependency.as_str()), "{room} must not know {dependency}");
        }
    }
}

#[test]
fn only_interfaces_knows_iceoryx2() {
    for (room, dependencies) in dependencies() {
        let knows = dependencies.iter().any(|d| d.starts_with("iceoryx2"));
        assert_eq!(knows, room == "interfaces", "{room}");
    }
}

/// In a solver one file knows messages, case and outputs; the rest is numerics.
#[test]
fn only_participant_rs_knows_the_world_outside_a_solver() {
    for room in ["fluid", "structure"] {
        for file in rust_files(room) {
            let inside_participant =
                file.components().any(|c| c.as_os_str().to_string_lossy().starts_with("participant"));
            if inside_participant {
                continue;
            }
            let text = fs::read_to_string(&file).expect("a readable source");
            for word in ["interfaces::", "output::", "std::process", "std::net", "Instant::now", "SystemTime"]
            {
                let found = text.lines().find(|l| !l.trim_start().starts_with("//") && l.contains(word));
                assert!(found.is_none(), "{} knows {word}: {}", file.display(), found.unwrap_or_default());
            }
        }
    }
}

/// The coupling loop and condition (46) see participants and slices.
#[test]
fn the_coupling_loop_knows_no_file_socket_or_clock() {
    let pure = [
        "schemes",
        "acceleration",
        "mapping",
        "mapped.rs",
        "convergence.rs",
        "condition46.rs",
        "flat.rs",
        "phase.rs",
        "schedule.rs",
        "side.rs",
        "steady_state.rs",
    ];
    for file in rust_files("coupler") {
        if !file.components().any(|c| pure.iter().any(|p| c.as_os_str() == *p)) {
            continue;
        }
        let text = fs::read_to_string(&file).expect("a readable source");
        for word in ["std::fs", "std::net", "std::process", "std::time", "Instant", "iceoryx2", "output::"] {
            assert!(!text.contains(word), "{} knows {word}", file.display());
        }
    }
}

/// Another transport is another implementation of `Link`, and nothing beside it changes.
#[test]
fn one_transport_knows_iceoryx2() {
    for file in rust_files("interfaces") {
        if file.components().any(|c| c.as_os_str() == "iceoryx2") {
            continue;
        }
        let text = fs::read_to_string(&file).expect("a readable source");
        assert!(!text.contains("use iceoryx2::"), "{}", file.display());
    }
}
