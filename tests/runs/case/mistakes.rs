//! Every mistake has its line, key, value, problem and remedy.

use super::rows::ROWS;
use super::*;

#[test]
fn every_mistake_has_line_key_value_problem_and_remedy() {
    for (from, to, expected) in ROWS {
        assert_eq!(mistakes(parse(&changed(from, to), &[])), [*expected], "{from:?} -> {to:?}");
    }
}

#[test]
fn a_second_body_must_not_overlap_and_a_probe_must_name_one() {
    let second =
        "[[structure.body]]\nname = \"second\"\nbox = { low = [0.5, -0.1], high = [0.6, -0.04] }\n[[probe]]";
    assert_eq!(
        mistakes(parse(&changed("[[probe]]", second), &[])),
        [
            "line 51: structure.body.1.box: the body \"second\" overlaps the body \"plate\"; move or shrink one of them; they may touch",
            "line 52: probe.0.body: is missing, and there is more than one body; add one of \"plate\", \"second\"",
        ]
    );
}

#[test]
fn missing_sections_are_named() {
    let general = SOUND.split("[fluid]").next().unwrap();
    assert_eq!(
        mistakes(parse(general, &[])),
        ["the case has neither [fluid] nor [structure]; add at least one of them"]
    );
    assert_eq!(mistakes(parse("", &[])), ["case: is missing; add it; its meaning: what concerns the whole"]);
    let structure = SOUND.find("[structure.material]").unwrap();
    let probe = SOUND.find("[[probe]]").unwrap();
    let fluid_only = format!("{}[coupling]\n", &SOUND[..structure]);
    assert_eq!(
        mistakes(parse(&fluid_only, &[])),
        ["line 27: coupling: there is no [structure] to couple; add [structure], or leave [coupling] out"]
    );
    let probe_without = format!("{}{}", &SOUND[..structure], &SOUND[probe..]);
    assert_eq!(
        mistakes(parse(&probe_without, &[])),
        ["line 29: probe.0.on = \"structure\": there is no [structure]; add one, or leave the probe out"]
    );
}

#[test]
fn all_mistakes_come_at_once_in_the_order_of_lines() {
    let text = changed("density = 1000.0", "densty = -1000.0")
        .replacen("end_time = 0.1", "end_time = \"long\"", 1)
        .replacen("poisson_ratio = 0.3", "poisson_ratio = 0.7", 1)
        .replacen("[[0.0, 0.8], [0.0, 0.0]]", "[[0.0, 0.8]]", 1)
        .replacen("face = \"right\"", "face = \"top\"\nrows = 3", 1);
    let found = mistakes(parse(&text, &["coupling.relaxation=0"]));
    let keys: Vec<_> = found.iter().map(|message| message.split([' ', ':']).nth(2).unwrap_or("")).collect();
    assert_eq!(found.len(), 7, "{found:#?}");
    assert!(found[0].starts_with("line 4: case.end_time = \"long\": is a string"), "{keys:?}");
    assert!(found[1].starts_with("line 10: fluid.densty = -1000.0: there is no such key"));
    // A misspelt key is read as what it was meant to be: its value is looked at too.
    assert!(found[2].starts_with("line 10: fluid.density: must be over 0"));
    assert_eq!(found[6].split(':').next(), Some("--set"));
}

#[test]
fn text_that_is_no_toml_is_told_with_its_line() {
    let found = mistakes(parse(&changed("density = 1000.0", "density 1000.0"), &[]));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].starts_with("line 10: is not TOML: "), "{found:?}");
    let twice = mistakes(parse(&changed("density = 1000.0", "density = 1000.0\ndensity = 2"), &[]));
    assert!(twice[0].starts_with("line 11: is not TOML: duplicate key"), "{twice:?}");
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let errors = Case::load(Path::new("no/such/case.toml"), &[], &[]).unwrap_err();
    let message = errors.to_string();
    assert!(message.starts_with("no/such/case.toml: 1 mistake:\n  cannot be read: "), "{message}");
}

/// A record of a shaken table has some ten thousand rows: as many lines, or one.
#[test]
fn a_long_table_is_read_in_no_time() {
    for end in ["\n", ""] {
        let rows: Vec<String> =
            (0..50_000).map(|i| format!("[{i}e-4, {}e-6],{end}", i % 7 * i.min(1))).collect();
        let motion = format!("motion = {{ direction = [1.0, 0.0], table = [{}] }}", rows.concat());
        let text = changed("solid_side = \"right\"", &format!("solid_side = \"right\"\n{motion}"));
        let started = std::time::Instant::now();
        assert_eq!(mistakes(parse(&text, &[])), [""; 0]);
        // Seconds, where it was minutes.
        assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
    }
}

/// Of what would take more than this machine has, the largest part is named, with particles and memory.
#[test]
fn what_would_not_fit_into_memory_is_refused_before_it_is_made() {
    for (from, to, key) in [
        ("particle_spacing = 0.01", "particle_spacing = 1e-9", "fluid.region.0.box"),
        ("low = [-0.1, -0.2], high = [1.1, 1.0]", "low = [-1e9, -0.2], high = [1e9, 1e9]", "fluid.domain"),
    ] {
        let started = std::time::Instant::now();
        let found = mistakes(Case::parse(&changed(from, to), Path::new("case.toml"), &[], &SECTIONS));
        let named =
            |line: &&String| line.contains(key) && line.contains("GB of memory, and this machine has");
        assert!(found.iter().any(|line| named(&line)), "{key}: {found:#?}");
        assert!(started.elapsed().as_secs() < 5);
    }
    let wall = "[[fluid.wall]]\nname = \"long\"\nbox = { low = [0.0, -0.2], high = [1e12, -0.1] }\n[[structure.body]]";
    let found =
        mistakes(Case::parse(&changed("[[structure.body]]", wall), Path::new("case.toml"), &[], &SECTIONS));
    assert!(found.iter().any(|line| line.contains("\"long\"") || line.contains("fluid.wall.")), "{found:#?}");
    // Bodies are filled for a structure of another make, too, which is mapped to what fills them.
    let mapped =
        ["structure.participant.command=[\"sh\"]", "coupling.mapping.spacing=1e-7"].map(str::to_owned);
    let found = mistakes(Case::parse(SOUND, Path::new("case.toml"), &mapped, &SECTIONS));
    assert!(found.iter().any(|line| line.contains("coupling.mapping.spacing = 1e-7: ")), "{found:#?}");
}

/// Overlaps that a run would not survive, and those that are meant.
#[test]
fn what_moves_overlaps_nothing_and_bodies_stay_out_of_solids() {
    let wall = |name: &str, low: &str, high: &str, more: &str| {
        format!("[[fluid.wall]]\nname = \"{name}\"\nbox = {{ low = {low}, high = {high} }}\n{more}\n")
    };
    let lifts = "motion = { direction = [0.0, 1.0], table = [[0.0, 0.0], [1.0, 1.0]] }";
    let bed = wall("bed2", "[0.0, -0.19]", "[1.0, -0.1]", "");
    let found = |more: String| {
        let text = changed("[[structure.body]]", &format!("{more}[[structure.body]]"));
        mistakes(Case::parse(&text, Path::new("case.toml"), &[], &SECTIONS))
    };
    let fixed = found(bed.clone() + &wall("post", "[0.2, -0.15]", "[0.25, -0.05]", ""));
    assert!(!fixed.iter().any(|line| line.contains("overlaps the wall")), "{fixed:#?}");
    let gate = found(bed.clone() + &wall("gate2", "[0.2, -0.15]", "[0.25, -0.05]", lifts));
    assert!(
        gate.iter()
            .any(|line| line.contains("\"gate2\" overlaps the wall \"bed2\", and the wall \"gate2\" moves")),
        "{gate:#?}"
    );
    let held = |motion: &str| {
        let text = changed("face = \"right\"", "face = \"right\"\nrows = 3");
        let text = text.replacen("name = \"right\"\n", &format!("name = \"right\"\n{motion}\n"), 1);
        mistakes(Case::parse(&text, Path::new("case.toml"), &[], &SECTIONS))
    };
    assert_eq!(held(""), [""; 0], "rows may lie in a wall that stays");
    let gone = held(lifts);
    let named = "structure.clamp.0: it holds in the wall \"right\", which moves, and the clamp stays; let it move with the wall: with_wall = \"right\"";
    assert!(gone.iter().any(|line| line.contains(named)), "{gone:#?}");
    let thin = found(wall("foil", "[0.2, -0.15]", "[0.201, -0.05]", ""));
    assert!(
        thin.iter().any(|line| line.contains("is thinner (0.001 m) than one particle spacing")),
        "{thin:#?}"
    );
}

/// A clamp in a wall, along its surface or behind it goes with the wall; one that only touches its edge, or
/// along which it slides, may stay.
#[test]
fn a_clamp_goes_with_the_wall_that_it_holds_in() {
    let lifts = "motion = { direction = [0.0, 1.0], table = [[0.0, 0.0], [1.0, 1.0]] }";
    let rolls = "motion = { pivot = [0.5, 0.0], amplitude = 0.07, period = 1.2, ramp = 0.1 }";
    let text = |wall: &str, of_wall: &str, post: &str, clamp: &str| {
        format!(
            "[case]\ntitle = \"Post\"\ndimension = 2\nend_time = 1\noutput_interval = 1\ngravity = [0, -9.81]\nparticle_spacing = 0.01\n\
             [fluid]\ndensity = 1000\nkinematic_viscosity = 0\ndomain = {{ low = [-1, -1], high = [2, 2] }}\n\
             [[fluid.region]]\nname = \"water\"\nbox = {{ low = [0.6, 0], high = [1, 0.2] }}\n\
             [[fluid.wall]]\nname = \"tank\"\n{wall}\n{of_wall}\n\
             [structure.material]\nlaw = \"neo-hookean\"\nyoungs_modulus = 1e6\npoisson_ratio = 0.3\ndensity = 1000\n\
             [[structure.body]]\nname = \"post\"\nbox = {post}\n[[structure.clamp]]\nname = \"foot\"\nbody = \"post\"\n{clamp}\n"
        )
    };
    let polyline = "polyline = [[0, 0.5], [0, 0], [1, 0], [1, 0.5]]\nsolid_side = \"right\"";
    let bed = "box = { low = [0.0, -0.1], high = [1.0, 0.0] }";
    let gate = "box = { low = [0.4, 0.0], high = [0.5, 1.0] }";
    let (post, beside) =
        ("{ low = [0.5, 0.0], high = [0.54, 0.2] }", "{ low = [0.5, -0.1], high = [0.54, 0.2] }");
    let (face, rows) = ("face = \"bottom\"", "face = \"bottom\"\nrows = 3");
    let held = "box = { low = [0.4, -0.1], high = [0.6, 0.05] }";
    let with = |clamp: &str| format!("{clamp}\nwith_wall = \"tank\"");
    for (wall, of_wall, body, clamp, refused) in [
        (polyline, rolls, post, face.to_owned(), true),
        (polyline, rolls, post, rows.to_owned(), true),
        (polyline, rolls, post, held.to_owned(), true),
        (polyline, rolls, post, with(face), false),
        (polyline, rolls, post, format!("{face}\n{rolls}"), false),
        (polyline, rolls, post, format!("{face}\n{lifts}"), true),
        (polyline, "", post, face.to_owned(), false),
        (bed, lifts, post, face.to_owned(), true),
        (bed, lifts, post, rows.to_owned(), true),
        (bed, lifts, post, with(rows), false),
        // Beside a gate that lifts: its edge is touched, or it slides along.
        (gate, lifts, post, face.to_owned(), false),
        (gate, lifts, beside, held.to_owned(), false),
        (gate, rolls, beside, held.to_owned(), true),
    ] {
        let text = text(wall, of_wall, body, &clamp);
        let found = mistakes(Case::parse(&text, Path::new("case.toml"), &[], &SECTIONS));
        let told = found.iter().any(|line| line.contains("it holds in the wall \"tank\""));
        assert_eq!(told, refused, "{wall} {of_wall} {body} {clamp}: {found:#?}");
        assert!(refused || found.is_empty(), "{wall} {of_wall} {body} {clamp}: {found:#?}");
    }
}

/// What is behind a polyline is in its solid, behind its corners too; beyond its ends it has none. A wall
/// that moves stays out of it.
#[test]
fn nothing_stands_in_the_solid_behind_a_polyline() {
    let found = |line: &str, more: &str| {
        let text = changed("polyline = [[0.0, 0.8], [0.0, 0.0]]", &format!("polyline = {line}"));
        let text = text.replacen("[structure.material]", &format!("{more}[structure.material]"), 1);
        mistakes(Case::parse(&text, Path::new("case.toml"), &[], &SECTIONS))
    };
    let hook = "[[0.0, 0.8], [0.0, -0.05], [1.0, -0.05]]";
    assert_eq!(found(hook, ""), [""; 0]);
    let region = |low: &str, high: &str| {
        format!("[[fluid.region]]\nname = \"more\"\nbox = {{ low = {low}, high = {high} }}\n")
    };
    // Left of the corner and under it: no piece has it before it.
    let behind = found(hook, &region("[-0.08, -0.15]", "[-0.02, -0.1]"));
    let named = "line 21: fluid.wall.0.solid_side = \"right\": puts the region \"more\" into the solid; take the other side, or move what is in it";
    assert_eq!(behind, [named]);
    // Beyond the end of the wall on the left, which stands on nothing there.
    assert_eq!(found("[[0.0, 0.8], [0.0, 0.0]]", &region("[-0.08, -0.15]", "[-0.02, -0.1]")), [""; 0]);
    let body = "[[structure.body]]\nname = \"post\"\nbox = { low = [-0.06, -0.11], high = [-0.01, -0.06] }\n";
    let body = found(hook, body);
    assert!(body.iter().any(|line| line.contains("puts the body \"post\" into the solid")), "{body:#?}");
    // In the open, far behind the wall's particles.
    let far = "[[structure.body]]\nname = \"post\"\nbox = { low = [-2.08, 0.15], high = [-2.02, 0.2] }\n";
    let far = found(hook, far);
    assert!(!far.iter().any(|line| line.contains("into the solid")), "{far:#?}");

    let gate = |low: &str, moves: bool| {
        let motion = "motion = { direction = [0.0, 1.0], table = [[0.0, 0.0], [1.0, 1.0]] }\n";
        let motion = if moves { motion } else { "" };
        let gate = format!("box = {{ low = {low}, high = [1.05, 0.9] }}");
        format!("[[fluid.wall]]\nname = \"gate\"\n{gate}\n{motion}")
    };
    let line = "[[0.0, 0.8], [0.0, -0.05], [1.1, -0.05]]";
    let overlap = |line: &&String| {
        line.contains(
            "the wall \"gate\" overlaps the solid of the wall \"left\", and the wall \"gate\" moves",
        )
    };
    for (low, moves, refused) in
        [("[1.0, -0.1]", true, true), ("[1.0, -0.1]", false, false), ("[1.0, -0.05]", true, false)]
    {
        let found = found(line, &gate(low, moves));
        assert_eq!(found.iter().filter(overlap).count(), usize::from(refused), "{low} {moves}: {found:#?}");
    }
}

/// Where two boxes touch at a corner alone and there is water on one side of it, the other side must hold
/// something.
#[test]
fn walls_that_touch_at_a_corner_alone_are_told() {
    let found = |bed: &str, more: &str| {
        let text = changed("low = [1.0, -0.1], high = [1.1, 0.8]", "low = [1.0, 0.0], high = [1.1, 0.8]");
        let text = text.replacen(
            "[structure.material]",
            &format!("[[fluid.wall]]\nname = \"bed\"\nbox = {bed}\n{more}[structure.material]"),
            1,
        );
        let text =
            text.replacen("low = [0.0, -0.05], high = [1.0, 0.0]", "low = [0.4, 0.5], high = [0.6, 0.6]", 1);
        let text = text.replacen("face = \"right\"", "box = { low = [0.4, 0.5], high = [0.5, 0.6] }", 1);
        let found = mistakes(Case::parse(&text, Path::new("case.toml"), &[], &SECTIONS));
        found.into_iter().filter(|line| line.contains("at an edge alone")).collect::<Vec<_>>()
    };
    let bed = "{ low = [0.0, -0.1], high = [1.0, 0.0] }";
    let [told] = &found(bed, "")[..] else { panic!("one corner is open") };
    let wanted = "fluid.wall.2.box: the wall \"bed\" touches the wall \"right\" at an edge alone, and what is behind it is open; let one of them reach behind the other";
    assert!(told.contains(wanted), "{told}");
    assert_eq!(found("{ low = [0.0, -0.1], high = [1.1, 0.0] }", ""), [""; 0]);
    let third = "[[fluid.wall]]\nname = \"foot\"\nbox = { low = [1.0, -0.1], high = [1.1, 0.0] }\n";
    assert_eq!(found(bed, third), [""; 0]);
}
