//! What the FMU's boundary costs: a step of 3,000 particles in 100 sub-steps as a participant, and through an
//! instance with load set, step and outputs read; `cargo bench -p structure-fmu`. The C functions themselves
//! add a look-up in a table and a lock a call.

use criterion::{Criterion, criterion_group, criterion_main};
use interfaces::case::Case;
use interfaces::{Direction, SubSteps, TimeWindow};
use meniscus_structure::instance::Instance;
use meniscus_structure::phase::Phase;
use meniscus_structure::resources::Resources;
use std::path::Path;

/// A clamped beam of 20 × 150 particles.
const BEAM: &str = r#"
[case]
title = "Beam"
dimension = 2
end_time = 1.0
output_interval = 0.1
particle_spacing = 1e-3
threads = 1

[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 2e6
poisson_ratio = 0.4
density = 1000.0
assumption = "plane-strain"

[[structure.body]]
name = "beam"
box = { low = [0.0, 0.0], high = [0.15, 0.02] }

[[structure.clamp]]
name = "root"
body = "beam"
face = "left"
"#;

const SUB_STEPS: u32 = 100;

fn boundary(criterion: &mut Criterion) {
    let case = Case::parse(BEAM, Path::new("case.toml"), &[], &[structure::participant::SECTIONS])
        .expect("the case is sound");
    let mut group = criterion.benchmark_group("a step of 3,000 particles");
    let mut native = structure::participant::without_snapshots(&case).expect("the case is sound");
    let mut inputs = native.describe().fields(Direction::In, 0);
    let mut outputs = native.describe().fields(Direction::Out, 0);
    let readiness = native.initialize(0.0, &inputs, &mut outputs).expect("it starts");
    let size = 0.5 * readiness.window_limit;
    let load = inputs.get_mut("pressure_gradient").expect("a structure takes a load");
    load.fill(1.0);
    let load = load.to_vec();
    let mut index = 0;
    // As many threads as the case says, as the instance has.
    let pool =
        rayon::ThreadPoolBuilder::new().num_threads(case.general.threads).build().expect("threads start");
    group.bench_function("participant", |bencher| {
        let mut step = || {
            let sub_steps = SubSteps::Fixed(SUB_STEPS);
            let window = TimeWindow { index, iteration: 0, start: index as f64 * size, size, sub_steps };
            native.start(&window, &inputs).expect("it is stable");
            native.finish(&mut outputs).expect("it was started");
            native.accept(None).expect("it was solved");
            index += 1;
        };
        bencher.iter(|| pool.install(&mut step));
    });

    let resources = Resources::new(&case, None);
    let token = resources.token();
    let mut instance =
        Instance::new(resources, &token, false, Box::new(|_, _| ()), false).expect("the unit is sound");
    let reference = |instance: &Instance, name: &str| {
        instance.variables().iter().position(|v| v.name == name).expect("the unit has it") as u32
    };
    let [gradient, position, velocity, sub_steps] =
        ["pressure_gradient", "position", "velocity", "sub_steps"].map(|name| reference(&instance, name));
    instance.write(&[sub_steps], true, &[f64::from(SUB_STEPS)]).expect("a parameter");
    instance.initialize(0.0).expect("it starts");
    instance.enter(Phase::Step);
    let mut motion = vec![0.0; 2 * load.len()];
    let mut index = 0;
    group.bench_function("instance", |bencher| {
        bencher.iter(|| {
            instance.write(&[gradient], false, &load).expect("a load");
            instance.step(f64::from(index) * size, size).expect("it is stable");
            instance.read(&[position, velocity], false, &mut motion).expect("outputs");
            index += 1;
        });
    });
}

criterion_group!(benches, boundary);
criterion_main!(benches);
