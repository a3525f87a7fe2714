//! Sweeps: a case at several values of its keys.

use crate::support::Bench;
use std::fs;

#[test]
fn a_member_that_fails_ends_no_other_and_the_next_sweep_takes_what_is_there() {
    let bench = Bench::new();
    let out = bench.path("out").display().to_string();
    let over = |values: &str| {
        let over = format!("fluid.numerics.pressure_iterations_limit={values}");
        let words = ["sweep", "cases/hydrostatic_tank", "--end-time", "0.004", "--no-report", "--jobs", "2"];
        bench.call(&[&words[..], &["--out", &out, "--over", &over]].concat())
    };
    // One iteration is too few.
    let ended = over("1,400");
    assert_eq!(ended.status.code(), Some(1), "{} {}", ended.text, ended.errors);
    assert!(ended.errors.contains("1 of 2 members did not complete"), "{}", ended.errors);
    let table = fs::read_to_string(bench.path("out").join("sweep.csv")).expect("a table");
    let rows: Vec<&str> = table.lines().collect();
    assert!(rows[0].starts_with("folder,fluid.numerics.pressure_iterations_limit,status,windows"), "{table}");
    assert!(rows[1].starts_with("pressure_iterations_limit-1,1,failed,0,"), "{table}");
    assert!(rows[2].starts_with("pressure_iterations_limit-400,400,completed,"), "{table}");
    assert_eq!(rows.len(), 3);
    let ended = over("400,500");
    assert_eq!(ended.status.code(), Some(0), "{} {}", ended.text, ended.errors);
    assert!(ended.text.contains("pressure_iterations_limit = 400: was there"), "{}", ended.text);
    assert!(ended.text.contains("pressure_iterations_limit = 500: completed"), "{}", ended.text);
    let page = fs::read_to_string(bench.path("out").join("sweep.html")).expect("a page");
    assert!(
        page.contains("pressure_iterations_limit = 500") && page.contains("pressure_iterations_limit = 400")
    );

    // Mistakes of all members come before any of them is run.
    let ended = over("-1,\"many\"");
    assert_eq!(ended.status.code(), Some(2), "{}", ended.text);
    for label in ["pressure_iterations_limit = -1:", "pressure_iterations_limit = \"many\":"] {
        assert!(ended.errors.contains(label), "{}", ended.errors);
    }
}
