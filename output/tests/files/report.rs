//! The report of a made-up run: a dam break through a gate, in formulas instead of physics. What it makes
//! stays in the target folder (`tmp/report`), to be looked at.

use output::report::{Shown, View};
use output::summary::{
    Balances, Condition46, EnergyBalance, FluidBalance, Residual, RoleUse, Status, probe_extremes,
};
use output::{Column, Error, ParticleFrame, PointArray, Series, Summary, Table, Values, table, write_report};
use std::fs;
use std::path::{Path, PathBuf};

const END: f64 = 0.4;
const SPACING: f64 = 1.25e-3;

/// Tip of the gate at time `t`: opens, and swings back a little.
fn tip(t: f64) -> (f64, f64) {
    let ux = 0.046 * (1.0 - (-t / 0.05).exp()) * (1.0 - 0.55 * (t - 0.14).max(0.0));
    (ux, 5.5 * ux * ux + 0.1 * ux)
}

fn write_fluid(dir: &Path, frames: usize) {
    let mut series = Series::create(dir, "fluid").unwrap();
    for frame in 0..frames {
        let t = END * frame as f64 / (frames - 1) as f64;
        let (mut positions, mut velocities, mut pressures, mut classes) = (vec![], vec![], vec![], vec![]);
        let level = 0.14 * (1.0 - 1.5 * t);
        for column in 0..80 {
            for row in 0..112 {
                let (x0, y0) = ((column as f64 + 0.5) * SPACING, (row as f64 + 0.5) * SPACING);
                // The lowest layers run out below the gate as a jet that thins and falls back in drops.
                let out = (t / END * 60.0) as usize;
                let (x, y) = if row < 10 && column + out >= 80 {
                    (x0 + 3.5 * t * x0, y0 * 0.8)
                } else {
                    (x0, y0 * level / 0.14)
                };
                positions.extend([x, y]);
                velocities.extend([3.5 * x0, -0.2 * y0]);
                pressures.push(9810.0 * (level - y).max(0.0) * (1.0 - (x - 0.1).max(0.0) / 0.3).max(0.0));
                classes.push(u8::from(row == 111));
            }
        }
        let arrays = [
            PointArray::scalar("pressure", &pressures),
            PointArray::vector("velocity", 2, &velocities),
            PointArray::class("surface_class", &classes),
        ];
        series
            .write(&ParticleFrame { time: t, dimension: 2, positions: &positions, arrays: &arrays })
            .unwrap();
    }
}

fn write_structure(dir: &Path, frames: usize) {
    let mut series = Series::create(dir, "structure").unwrap();
    for frame in 0..frames {
        let t = END * frame as f64 / (frames - 1) as f64;
        let (ux, uy) = tip(t);
        let (mut positions, mut stresses) = (vec![], vec![]);
        for row in 0..64 {
            for layer in 0..4 {
                let s = (row as f64 + 0.5) / 64.0;
                let across = (layer as f64 - 1.5) * SPACING;
                let bent = (1.0 - s) * (1.0 - s) * (2.0 + s) / 2.0;
                positions.extend([0.1025 + across + ux * bent, 0.079 * s + uy * bent]);
                // Bending: largest at the clamp (s = 1) and at the faces.
                stresses.extend([0.0, 2e7 * ux * s * across / SPACING, 0.0, 0.0]);
            }
        }
        let arrays = [PointArray { name: "stress", components: 4, values: Values::F64(&stresses) }];
        series
            .write(&ParticleFrame { time: t, dimension: 2, positions: &positions, arrays: &arrays })
            .unwrap();
    }
}

fn write_tables(dir: &Path) {
    let column = |(name, unit): (&str, &str)| Column::new(name, unit, "");
    let columns =
        [("t", "s"), ("tip.ux", "m"), ("tip.uy", "m"), ("bed.p", "Pa"), ("wall.fx", "N")].map(column);
    output::columns::write(dir, &[("probes.csv", &columns)]).unwrap();
    let mut probes = Table::create(&dir.join("probes.csv"), &columns).unwrap();
    let mut windows = Table::create(
        &dir.join("windows.csv"),
        &[
            "window",
            "time",
            "size",
            "sub_steps",
            "iterations",
            "fluid.ppe_iterations",
            "residual_before",
            "residual_after",
            "fluid.kinetic_energy",
            "fluid.potential_energy",
            "structure.kinetic_energy",
            "structure.strain_energy",
            "structure.potential_energy",
            "interface.work_given",
            "interface.work_taken",
            "fluid.volume_drift",
        ],
    )
    .unwrap();
    for window in 0..4000 {
        let t = END * f64::from(window + 1) / 4000.0;
        let wave = (700.0 * t).sin();
        let (ux, uy) = tip(t);
        let size = 1e-4 * (1.0 + 0.3 * wave);
        let strain = 60.0 * ux * ux * (1.0 + 0.02 * wave);
        let potential = 9.6 - 18.0 * t + 14.0 * t * t;
        windows
            .row(&[
                f64::from(window),
                t,
                size,
                100.0,
                1.0,
                (30.0 + 8.0 * wave).round(),
                0.05 * (1.2 + wave),
                if window % 7 == 0 { 0.0 } else { 1.5e-16 * (2.0 + wave) },
                (9.6 - potential) * 0.97 - strain,
                potential,
                0.02 * (1.0 + wave) * (-t / 0.1).exp(),
                strain,
                5.4 * 0.5 * uy * 0.395,
                strain * 1.05,
                strain * 1.05 * (1.0 - 1e-3),
                -0.004 * t / END,
            ])
            .unwrap();
        if window % 4 == 0 {
            probes.row(&[t, ux, uy, 1370.0 * (1.0 - t) + 60.0 * wave, 96.0 * (1.0 - 2.0 * t)]).unwrap();
        }
    }
}

fn write_case(dir: &Path) {
    fs::write(
        dir.join("case.toml"),
        "title = \"Dam break through an elastic gate <made up>\"\n\
         [[reference]]\nprobe = \"tip.ux\"\nlabel = \"experiment, Antoci 2007\"\n\
         source = \"Antoci, Gallati and Sibilla, Computers & Structures 85 (2007), Fig. 13\"\n\
         time = [0.04, 0.08, 0.12, 0.16, 0.20, 0.24, 0.28, 0.32, 0.36, 0.44]\n\
         value = [0.013, 0.034, 0.044, 0.0462, 0.044, 0.0428, 0.041, 0.040, 0.0373, 0.03]\n\
         low = [0.0125, 0.033, 0.043, 0.045, 0.043, 0.0418, 0.04, 0.039, 0.0363, 0.03]\n\
         high = [0.0135, 0.035, 0.045, 0.047, 0.045, 0.0438, 0.042, 0.041, 0.0383, 0.03]\n\
         [[reference]]\nprobe = \"tip.ux\"\nlabel = \"SPH, peak only\"\nsource = \"the same\"\n\
         time = [0.147]\nvalue = [0.04997]\n\
         [[reference]]\nprobe = \"tip.uy\"\nlabel = \"experiment\"\nsource = \"the same, Fig. 14\"\n\
         time = [0.04, 0.08, 0.12, 0.16, 0.20]\nvalue = [0.001, 0.010, 0.015, 0.017, 0.016]\n",
    )
    .unwrap();
}

fn write_summary(dir: &Path) {
    let role = |compute_seconds: f64| RoleUse {
        compute_seconds,
        wait_seconds: 82.0 - compute_seconds,
        share: compute_seconds / 82.0,
        peak_memory_bytes: 41_000_000,
        ..RoleUse::default()
    };
    let probes = table::read(&dir.join("probes.csv")).unwrap();
    let summary = Summary {
        status: Status::Completed,
        title: "Dam break through an elastic gate <made up>".to_owned(),
        case_hash: "9f".repeat(32),
        version: "0.1.0".to_owned(),
        threads: 1,
        windows: 4000,
        sub_steps: 400_000,
        simulated_seconds: END,
        wall_seconds: 82.0,
        roles: [("fluid", role(61.0)), ("structure", role(18.5)), ("coupler", role(0.7))]
            .map(|(name, role)| (name.to_owned(), role))
            .into(),
        condition_46: Some(Condition46 {
            before: Residual { max: 0.11, rms: 0.07 },
            after: Residual { max: 4.5e-16, rms: 3e-16 },
        }),
        balances: Balances {
            impulse_given_newton_seconds: vec![12.125, -0.75],
            impulse_taken_newton_seconds: vec![12.125, -0.75],
            work_given_joules: Some(0.1273),
            work_taken_joules: Some(0.1272),
            energy: Some(EnergyBalance {
                start_joules: 9.6,
                end_joules: 9.45,
                largest_rise_joules: 0.004,
                moved_joules: 2.0,
            }),
            ..Balances::default()
        },
        fluid: Some(FluidBalance { volume_drift: -0.004, particles_left: 17, ..FluidBalance::default() }),
        probes: probe_extremes(&probes),
        ..Summary::default()
    };
    summary.write(&dir.join("summary.json")).unwrap();
}

fn fresh(name: &str) -> PathBuf {
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&dir);
    fs::create_dir_all(&dir).unwrap();
    dir
}

/// Decodes a PNG and counts pixels that differ from white.
fn drawn_pixels(path: &Path) -> (usize, usize) {
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap())).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    let drawn = pixels.as_chunks::<3>().0.iter().filter(|p| **p != [255; 3]).count();
    (drawn, pixels.len() / 3)
}

/// Every tag is closed in order; what stands in scripts is no HTML.
fn assert_balanced(html: &str) {
    let mut open: Vec<&str> = Vec::new();
    let html: String = html
        .split("</script>")
        .map(|part| part.split_once("<script").map_or(part.to_owned(), |(before, _)| before.to_owned()))
        .collect();
    for piece in html.split('<').skip(1) {
        let tag = piece.split('>').next().unwrap();
        let name = tag.trim_start_matches('/').split([' ', '\n', '/']).next().unwrap();
        let void = tag.ends_with('/') || matches!(name, "!DOCTYPE" | "meta" | "img" | "input" | "?xml");
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "closing tag without its opening");
        } else if !void {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
}

#[test]
fn snapshots_and_collections_are_well_formed() {
    let dir = fresh("well_formed");
    write_structure(&dir, 2);
    assert_balanced(&fs::read_to_string(dir.join("structure.pvd")).unwrap());
    let snapshot = fs::read_to_string(dir.join("structure/structure_000001.vtu")).unwrap();
    assert_balanced(&snapshot);
    let appended = snapshot.split_once("\n_").unwrap().1.split_once('\n').unwrap().0;
    assert!(appended.bytes().all(|b| b.is_ascii_alphanumeric() || b"+/=".contains(&b)));
}

#[test]
fn the_report_has_every_figure_and_stands_alone() {
    let dir = fresh("report");
    write_case(&dir);
    write_fluid(&dir, 21);
    write_structure(&dir, 21);
    write_tables(&dir);
    write_summary(&dir);
    // A picture of an earlier report goes; what else lies there stays.
    fs::create_dir_all(dir.join("frames")).unwrap();
    fs::write(dir.join("frames/t9.0000.png"), "old").unwrap();
    fs::write(dir.join("frames/tip.png"), "mine").unwrap();

    let path = write_report(&dir, &Shown::default()).unwrap().page;
    let html = fs::read_to_string(&path).unwrap();
    assert_balanced(&html);
    for figure in [
        "tip.ux (mm)",
        "tip.uy (mm)",
        "bed.p (kPa)",
        "wall.fx (N)",
        "Residual of condition (46)",
        "Iterations",
        "Work at the interface",
        "Energy of the structure",
        "Energy of the fluid",
        "Energy of the whole",
        "Time window",
        "Sub-steps in a window",
        "Drift of the fluid&#39;s volume",
    ] {
        assert!(html.contains(&format!("aria-label=\"{figure}")), "no figure `{figure}`");
    }
    assert!(html.contains("\"label\":\"experiment, Antoci 2007\"") && html.contains("[0.12,43.0,45.0]"));
    assert!(html.contains("1 later than the run, not drawn"));
    assert!(html.contains("gate &lt;made up&gt;") && !html.contains("<made up>"));
    // The library stands in the page with its licence, and nothing is loaded.
    assert!(html.contains("var uPlot=function") && html.contains("Copyright (c) 2022 Leon Sorokin"));
    assert!(!html.contains("<link") && !html.contains("<script src") && !html.contains("src=\"frames"));
    // Of 21 snapshots 16 evenly, among which those nearest to the extremes of probes are; one of the
    // structure.
    let frames = html.matches("data:image/png;base64,").count();
    assert_eq!(frames, 17);
    assert!(html.contains("nearest to the largest tip.ux"));
    assert!(!html.contains("class=\"notes\""), "nothing to complain about");

    let mut pictures: Vec<_> =
        fs::read_dir(dir.join("frames")).unwrap().map(|e| e.unwrap().file_name()).collect();
    pictures.sort();
    assert_eq!(pictures.len(), frames + 1);
    assert_eq!((&pictures[0], &pictures[frames - 1]), (&"structure.png".into(), &"t0.4000.png".into()));
    let (drawn, all) = drawn_pixels(&dir.join("frames/t0.0000.png"));
    // Water and gate fill more than a tenth of any picture here, and never all of it.
    assert!(drawn > all / 10 && drawn < all, "{drawn} of {all}");

    // Times and a box that the user chose: pictures of these moments alone, twice as wide as high.
    let shown = Shown { times: vec![0.119, 0.3], view: Some(View { x: (0.0, 0.2), y: (0.0, 0.1) }) };
    write_report(&dir, &shown).unwrap();
    let mut pictures: Vec<_> =
        fs::read_dir(dir.join("frames")).unwrap().map(|e| e.unwrap().file_name()).collect();
    pictures.sort();
    assert_eq!(pictures, ["structure.png", "t0.1200.png", "t0.3000.png", "tip.png"]);
    let (_, all) = drawn_pixels(&dir.join("frames/t0.3000.png"));
    assert!((800 * 400..1000 * 600).contains(&all), "{all}");
}

#[test]
fn what_a_killed_run_leaves_is_reported_as_far_as_it_goes() {
    let dir = fresh("killed");
    write_structure(&dir, 2);
    fs::write(dir.join("windows.csv"), "window,time,structure.kinetic_energy\n0,0.1,1\n1,0.2,2\n2,0.")
        .unwrap();
    fs::write(dir.join("probes.csv"), "t,tip.ux\n0,broken\n").unwrap();
    fs::write(dir.join("case.toml"), "[[reference]]\nprobe = \"tip.ux\"\n").unwrap();
    let report = write_report(&dir, &Shown::default()).unwrap();
    let named = |what: &str| report.notes.iter().any(|note| note.contains(what));
    assert!(named("no summary.json") && named("`broken` in column `tip.ux`"), "{:?}", report.notes);
    let html = fs::read_to_string(report.page).unwrap();
    assert_balanced(&html);
    assert!(html.contains("<h1>killed</h1>") && html.contains("no summary.json"));
    assert!(html.contains("`broken` in column `tip.ux`") && html.contains("has no `time`"));
    assert!(html.contains("Energy of the structure") && !html.contains("Energy of the whole"));
    assert_eq!(html.matches("data:image/png;base64,").count(), 2);

    let empty = fresh("empty");
    assert!(matches!(write_report(&empty, &Shown::default()), Err(Error::NoRun { .. })));
}

#[test]
fn three_dimensions_are_seen_from_the_side() {
    let dir = fresh("solid");
    let mut series = Series::create(&dir, "fluid").unwrap();
    let positions: Vec<f64> =
        (0..1000).flat_map(|i| [f64::from(i % 10), f64::from(i / 10 % 10), f64::from(i / 100)]).collect();
    // Pressure falls with y: the near side (y = 0) has the largest, and covers all others.
    let pressures: Vec<f64> = positions.as_chunks::<3>().0.iter().map(|p| 9.0 - p[1]).collect();
    let arrays = [PointArray::scalar("pressure", &pressures)];
    series.write(&ParticleFrame { time: 0.0, dimension: 3, positions: &positions, arrays: &arrays }).unwrap();
    write_report(&dir, &Shown::default()).unwrap();
    let (drawn, all) = drawn_pixels(&dir.join("frames/t0.0000.png"));
    assert!(drawn > all / 10, "{drawn} of {all}");
}
