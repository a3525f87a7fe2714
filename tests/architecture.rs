//! The invariants of `ARCHITECTURE.md`, as tests over `cargo metadata` and the sources.

use cargo_metadata::{DependencyKind, MetadataCommand};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Folders of the workspace's packages.
const ROOMS: [&str; 12] = [
    "words",
    "sph",
    "interfaces",
    "output",
    "fluid",
    "structure",
    "structure/fmu",
    "coupler",
    "coupler/fmu",
    "validation",
    "tests/partners",
    ".",
];

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

/// The names of modules that lead to a file of a room, none for the root.
fn module(room: &str, file: &Path) -> Vec<String> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join(room).join("src");
    let below = file.strip_prefix(src).expect("a file of the room").with_extension("");
    let mut names: Vec<String> = below.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    if names.last().is_some_and(|name| ["mod", "lib", "main"].contains(&name.as_str())) {
        names.pop();
    }
    names
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
        "mapped",
        "convergence",
        "condition46",
        "flat",
        "phase",
        "schedule",
        "side",
        "steady_state",
    ];
    for file in rust_files("coupler") {
        if !module("coupler", &file).first().is_some_and(|name| pure.contains(&name.as_str())) {
            continue;
        }
        let text = fs::read_to_string(&file).expect("a readable source");
        for word in ["std::fs", "std::net", "std::process", "std::time", "Instant", "iceoryx2", "output::"] {
            assert!(!text.contains(word), "{} knows {word}", file.display());
        }
    }
}

/// Files of a room know each other in one direction: no file leads back to itself by the paths from the
/// crate's root that stand in its code, each followed through re-exports to the file that defines its end.
/// Test modules at a file's end do not count.
#[test]
fn no_circle_of_files_in_any_room() {
    let circles: Vec<String> = ROOMS
        .into_iter()
        .filter_map(|room| Some(format!("{room}: {}", Files::of(room).circle()?.join(" → "))))
        .collect();
    assert!(circles.is_empty(), "files that lead back to themselves:\n{}", circles.join("\n"));
}

/// Code of a room's files, without comments and test modules, by the names of their modules.
struct Files(BTreeMap<Vec<String>, String>);

impl Files {
    fn of(room: &str) -> Self {
        let code = |file: &PathBuf| {
            let text = fs::read_to_string(file).expect("a readable source");
            let lines = text.lines().take_while(|line| *line != "#[cfg(test)]");
            lines.map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
        };
        Self(rust_files(room).iter().map(|file| (module(room, file), code(file))).collect())
    }

    /// Files one after the other, each of which knows the next, the last being the first; nothing where there
    /// are none such.
    fn circle(&self) -> Option<Vec<String>> {
        let known = |(file, code): (&Vec<String>, &String)| {
            let known = paths_after("crate::", code).into_iter().map(|path| self.definition(&[], &path));
            (file.clone(), known.filter(|other| other != file).collect::<BTreeSet<_>>())
        };
        let mut left: BTreeMap<_, BTreeSet<_>> = self.0.iter().map(known).collect();
        // Whoever knows nobody that is left is in no circle; when none such is left, all lead into one.
        while let Some(leaf) = left.keys().find(|file| left[*file].iter().all(|f| !left.contains_key(f))) {
            let leaf = leaf.clone();
            left.remove(&leaf);
        }
        let mut way = vec![left.keys().next()?.clone()];
        loop {
            let next = left[&way[way.len() - 1]].iter().find(|file| left.contains_key(*file))?;
            let before = way.iter().position(|file| file == next);
            way.push(next.clone());
            if let Some(start) = before {
                return Some(way[start..].iter().map(|file| file.join("::")).collect());
            }
        }
    }

    /// The file that defines what `path` names, seen from the module `from`.
    fn definition(&self, from: &[String], path: &[String]) -> Vec<String> {
        let mut at = from.to_vec();
        for (i, name) in path.iter().enumerate() {
            let inner = [&at[..], std::slice::from_ref(name)].concat();
            if self.0.contains_key(&inner) {
                at = inner;
                continue;
            }
            let exported = paths_after("pub use ", self.0.get(&at).map_or("", String::as_str));
            return match exported.iter().find(|exported| exported.last() == Some(name)) {
                Some(exported) if exported[0] == "crate" => self.definition(&[], &exported[1..]),
                Some(exported) if i + 1 == path.len() || exported.len() > 1 => self.definition(&at, exported),
                _ => at,
            };
        }
        at
    }
}

/// The paths that follow `start` in `code`, with what stands in braces taken apart; `self` and `*` at the end
/// are left out.
fn paths_after(start: &str, code: &str) -> Vec<Vec<String>> {
    let mut paths = Vec::new();
    for (at, _) in code.match_indices(start) {
        let before = code[..at].chars().next_back().unwrap_or(' ');
        if before != '$' && !before.is_alphanumeric() {
            take_apart(&code[at + start.len()..], &[], &mut paths);
        }
    }
    paths
}

/// Adds the paths at the start of `code` to `paths`, each after `stem`; gives what follows them.
fn take_apart<'a>(code: &'a str, stem: &[String], paths: &mut Vec<Vec<String>>) -> &'a str {
    let code = code.trim_start();
    if let Some(mut inside) = code.strip_prefix('{') {
        while !inside.trim_start().starts_with('}') && !inside.trim_start().is_empty() {
            inside = take_apart(inside, stem, paths).trim_start();
            inside = inside.strip_prefix(',').unwrap_or(inside);
        }
        return inside.trim_start().strip_prefix('}').unwrap_or_default();
    }
    let end = code.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(code.len());
    let (name, rest) = code.split_at(end);
    let path = if ["", "self"].contains(&name) { stem.to_vec() } else { [stem, &[name.to_owned()]].concat() };
    let rest = rest.strip_prefix('*').unwrap_or(rest);
    if let Some(rest) = rest.strip_prefix("::").filter(|rest| !rest.starts_with('<')) {
        return take_apart(rest, &path, paths);
    }
    paths.push(path);
    match rest.trim_start().strip_prefix("as ") {
        Some(alias) => alias.trim_start_matches(|c: char| c.is_alphanumeric() || c == '_'),
        None => rest,
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

/// Every path in the table of what to touch is a file or folder of the repository.
#[test]
fn what_to_touch_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(root.join("ARCHITECTURE.md")).expect("the map");
    let table = text.split("## To change X, touch Y").nth(1).expect("the table").split("\n## ").next();
    let rows: Vec<&str> =
        table.expect("its rows").lines().filter(|line| line.starts_with("| ")).skip(1).collect();
    assert!(rows.len() > 10, "{} rows", rows.len());
    for row in rows {
        let paths: Vec<&str> = row.split('`').skip(1).step_by(2).collect();
        assert!(!paths.is_empty(), "no path in: {row}");
        for path in paths {
            assert!(root.join(path).exists(), "{path} is not there: {row}");
        }
    }
}

/// Comments are read beside each other: they wrap where code does. Tables, diagrams and single words that are
/// longer stay as they are.
#[test]
fn comments_wrap_at_110_columns() {
    let mut wide = Vec::new();
    for file in ROOMS.into_iter().flat_map(rust_files) {
        let text = fs::read_to_string(&file).expect("a readable source");
        let mut in_fence = false;
        for (number, line) in text.lines().enumerate() {
            let Some(comment) = line.trim_start().strip_prefix("//") else { continue };
            let words = comment.trim_start_matches(['/', '!']).trim();
            in_fence ^= words.starts_with("```");
            if line.chars().count() > 110 && !in_fence && !words.starts_with('|') && words.contains(' ') {
                wide.push(format!("{}:{}", file.display(), number + 1));
            }
        }
    }
    assert!(wide.is_empty(), "comments wider than 110 columns:\n{}", wide.join("\n"));
}
