//! `meniscus check`: what it prints, refuses and advises.

use crate::support::Bench;
use std::fs;

#[test]
fn check_prints_what_would_run_and_writes_nothing() {
    let bench = Bench::new();
    let ended = bench.call(&["check", "cases/elastic_gate", "--set", "case.particle_spacing=2.5e-3"]);
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    for word in
        ["no mistakes found", "fluid", "structure", "particles", "stable sub-step", "expected windows"]
    {
        assert!(ended.text.contains(word), "{word}: {}", ended.text);
    }
    // Geometry that a solver refuses is found before the run, too.
    let ended = bench.call(&["check", "cases/elastic_gate", "--set", "case.particle_spacing=5e-3"]);
    assert_ne!(ended.status.code(), Some(0), "{}", ended.text);
    assert!(ended.errors.contains("at least two particles through the thickness"), "{}", ended.errors);
}

/// What a run cannot start is told by `check`, and by the run before it starts anything.
#[test]
fn check_and_run_agree_on_what_cannot_start() {
    let bench = Bench::new();
    let folder = bench.path("coupled").display().to_string();
    bench.call(&["new", &folder, "--template", "coupled"]);
    for program in ["no-such-solver-anywhere", "/no/such/solver", "/etc"] {
        let setting = format!("structure.participant={{ command = [\"{program}\"] }}");
        let out = bench.path("out").display().to_string();
        for words in [&["check"][..], &["run", "--out", &out]] {
            let ended = bench.call(&[words, &[&folder, "--set", &setting]].concat());
            assert_eq!(ended.status.code(), Some(2), "{}", ended.errors);
            let named = format!(
                "coupled/case.toml: 1 mistake:\n  --set: structure.participant.command.0 = \"{program}\": there is no such program, or it may not be executed; write its path"
            );
            assert!(ended.errors.contains(&named), "{}", ended.errors);
            assert!(!ended.text.contains("no mistakes"), "{}", ended.text);
        }
    }
    for (setting, limit) in [
        ("structure.material.youngs_modulus=1e30", "structure: its stable sub-step"),
        ("structure.material.density=1e-30", "structure: its stable sub-step"),
        ("structure.numerics.step_fraction=1e-20", "structure: its stable sub-step"),
        ("case.gravity=[0.0, -1e30]", "fluid: its time step"),
    ] {
        let ended = bench.call(&["check", &folder, "--set", setting]);
        assert_eq!(ended.status.code(), Some(2), "{setting}: {}", ended.text);
        assert!(ended.errors.contains(limit) && ended.errors.contains("never end"), "{}", ended.errors);
        assert!(!ended.text.contains("no mistakes"), "{}", ended.text);
    }
    let ended = bench.call(&["check", "cases/elastic_gate"]);
    assert!(ended.text.contains("100 in each window, where stability asks for 21:"), "{}", ended.text);
    let ended = bench.call(&["check", "cases/elastic_gate", "--set", "coupling.sub_steps=stable"]);
    assert!(!ended.text.contains("where stability asks"), "{}", ended.text);
    let ended = bench.call(&["check", &folder, "--time", "--end-time", "0.01"]);
    assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
    assert!(ended.text.contains("wall time") && ended.text.contains("windows"), "{}", ended.text);
}

/// A clamp whose law is over before the structure's sub-steps see it.
#[test]
fn a_clamp_that_swings_faster_than_the_sub_steps_is_told() {
    const SHAKEN: &str = r#"
[case]
title = "Shaken plate"
dimension = 2
end_time = 0.02
output_interval = 0.005
particle_spacing = 5e-3
[motion.m]
direction = [1.0, 0.0]
amplitude = 0.001
period = 1e-3
ramp = 0.005
[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 2e6
poisson_ratio = 0.3
density = 1000.0
[[structure.body]]
name = "plate"
box = { low = [0.0, 0.0], high = [0.02, 0.1] }
[[structure.clamp]]
name = "foot"
body = "plate"
face = "bottom"
motion = "m"
"#;
    let bench = Bench::new();
    let file = bench.path("case.toml");
    fs::write(&file, SHAKEN).expect("a case");
    let file = file.display().to_string();
    for (period, told) in [("1e-3", true), ("1e-2", false)] {
        let ended = bench.call(&["check", &file, "--set", &format!("motion.m.period={period}")]);
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        assert_eq!(
            ended.text.contains("the clamp \"foot\" swings once in 8.5 sub-steps"),
            told,
            "{}",
            ended.text
        );
    }
}

/// What holds a structure that is far lighter than the fluid; and a clamp beside sub-steps that are not
/// counted.
#[test]
fn light_structures_and_uncounted_sub_steps_are_advised() {
    let bench = Bench::new();
    let check = |words: &[&str]| {
        let ended = bench.call(&[&["check", "cases/elastic_gate"], words].concat());
        assert_eq!(ended.status.code(), Some(0), "{}", ended.errors);
        ended.text
    };
    let light = "structure.material.density=10.0";
    let advice = "coupling.compliance = false holds it";
    assert!(check(&["--set", light]).contains(advice));
    assert!(!check(&["--set", light, "--set", "coupling.scheme=serial-implicit"]).contains(advice));
    let swings = "structure.clamp=[{ name = 'top', body = 'gate', face = 'top', motion = { direction = [1.0, 0.0], amplitude = 1e-4, period = 1e-4 } }]";
    let apart = "fluid.wall=[]";
    let text = check(&[
        "--set",
        swings,
        "--set",
        apart,
        "--set",
        "probe=[]",
        "--set",
        "reference=[]",
        "--set",
        "coupling.sub_steps=stable",
    ]);
    assert!(text.contains("the clamp \"top\" swings once in "), "{text}");
}
