//! `meniscus validate` over its coarse resolutions: every case is within its tolerances, and tables and page
//! are there.

use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// What `validate SUITE --coarse` printed and the folder that it wrote; it must succeed.
fn validated(suite: &str) -> (String, TempDir) {
    let out = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_meniscus"))
        .args(["validate", suite, "--coarse", "--quiet", "--cases"])
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("cases"))
        .arg("--out")
        .arg(out.path())
        .output()
        .expect("the command starts");
    let (text, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{text}\n{errors}");
    (text.into_owned(), out)
}

#[test]
fn the_structure_is_within_its_tolerances_at_the_coarsest_resolutions() {
    let (text, out) = validated("structure");
    for case in ["cantilever_block", "clamped_plate", "oscillating_plate", "static_cantilever", "turek_hron"]
    {
        assert!(text.contains(case), "{text}");
    }
    let folder = out.path().join("validate");
    let table = std::fs::read_to_string(folder.join("validation.csv")).unwrap();
    // A heading, then the judged measures: one of each static case, period and amplitude of the plate.
    assert!(table.lines().count() >= 6, "{table}");
    let page = std::fs::read_to_string(folder.join("validation.html")).unwrap();
    assert!(
        page.contains("<div class=\"chart\"") && page.contains("clamped_plate/static-4/report.html"),
        "{page}"
    );
    assert!(folder.join("clamped_plate/static-4/report.html").exists());
}

/// Fluid and structure together: the column on a soft plate over a period and a half.
#[test]
fn fluid_and_structure_together_are_within_their_tolerances_at_the_coarsest_resolutions() {
    let (_, out) = validated("fsi");
    let folder = out.path().join("validate");
    let table = std::fs::read_to_string(folder.join("validation.csv")).unwrap();
    let rows = |measure: &str| table.lines().filter(|line| line.contains(measure)).count();
    assert_eq!((rows("deflection (m), ringing"), rows("frequency (Hz)")), (1, 1), "{table}");
    let page = std::fs::read_to_string(folder.join("validation.html")).unwrap();
    assert!(page.contains("hydrostatic_column_soft/short-4/report.html"), "{page}");
}

/// What the tests do not run is read all the same: files of the suite, the cases' columns in their figures.
#[test]
fn every_case_of_both_together_has_a_study_that_is_read() {
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
    let found = validation::study::find(&cases, "fsi", None).unwrap();
    let names: Vec<_> = found.iter().map(|(path, _)| path.file_name().unwrap().to_str().unwrap()).collect();
    let wanted = [
        "elastic_gate",
        "hydrostatic_column",
        "hydrostatic_column_soft",
        "liao_baffle",
        "sloshing_baffle",
        "walhorn_baffle",
    ];
    assert_eq!(names, wanted);
    for (path, study) in &found {
        for measure in study.measures.iter().filter(|m| m.tolerance.is_empty()) {
            assert!(!measure.source.is_empty(), "{}: `{}` has no source", path.display(), measure.name);
        }
    }
}

#[test]
fn a_case_that_is_not_there_is_named() {
    let output = Command::new(env!("CARGO_BIN_EXE_meniscus"))
        .args(["validate", "structure", "--case", "nowhere", "--cases"])
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("cases"))
        .output()
        .expect("the command starts");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("`nowhere`"));
}
