//! Mutated cases and mutated messages: whatever comes of them, no panic, no abort, no hang, no memory without
//! end. Some hundreds of each with every run of the tests, from a seed; 5,000 of each with
//!
//! ```sh
//! cargo test --release --test fuzz -- --ignored
//! ```

mod cases;

use cases::CASES;
use coupler::schedule::Schedule;
use coupler::schemes::serial_explicit::SerialExplicit;
use coupler::schemes::{Coupled, Onward, Pair, Run};
use coupler::side::Side;
use interfaces::case::Case;
use interfaces::case::coupling::StructureVelocity;
use interfaces::case::participant::Start;
use interfaces::protocol::{Hello, Kind, MessageHeader, Payload, packed};
use interfaces::remote::Listening;
use interfaces::transport::{Connection, Deadlines, WithinProcess};
use interfaces::{
    Address, Description, Direction, Expectations, Fields, Guarded, Participant, Role, SubSteps, new_run,
};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;
use toml::{Table, Value};

/// Longest that a case or a message may take.
const HANG: Duration = Duration::from_secs(10);
/// Largest memory of all that runs here (bytes).
const MEMORY: u64 = 1 << 30;

/// Pseudo-random numbers, after Steele, Lea and Flood 2014 (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound.max(1) as u64) as usize
    }

    fn of<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len())]
    }
}

/// Does `count` of them on a few threads, each within [`HANG`] and without a panic; names those that are not.
fn all(count: u64, seed: u64, one: fn(&mut Random)) {
    let next = Arc::new(AtomicU64::new(0));
    let wrong: Vec<String> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..4)
            .map(|_| {
                scope.spawn(|| {
                    let mut wrong = Vec::new();
                    loop {
                        let number = next.fetch_add(1, Ordering::Relaxed);
                        if number >= count {
                            return wrong;
                        }
                        let (send, ended) = mpsc::channel();
                        std::thread::spawn(move || {
                            let mut random = Random(seed.wrapping_add(number.wrapping_mul(0x1000_0001)));
                            let done = catch_unwind(AssertUnwindSafe(|| one(&mut random)));
                            let _ = send.send(done.is_ok());
                        });
                        match ended.recv_timeout(HANG) {
                            Ok(true) => {}
                            Ok(false) => wrong.push(format!("number {number} of seed {seed} panicked")),
                            Err(_) => wrong.push(format!("number {number} of seed {seed} hangs")),
                        }
                    }
                })
            })
            .collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("workers do not panic")).collect()
    });
    assert!(wrong.is_empty(), "{wrong:#?}");
    let peak = coupler::launch::peak_memory_bytes(None);
    assert!(peak < MEMORY, "{} MB", peak >> 20);
}

#[test]
fn what_is_mutated_is_sound() {
    let sections = [fluid::participant::SECTIONS, structure::participant::SECTIONS];
    for text in CASES {
        let case = Case::parse(text, Path::new("case.toml"), &[], &sections);
        begin(&case.unwrap_or_else(|errors| panic!("{errors}")));
    }
}

#[test]
fn some_mutated_cases_neither_panic_nor_hang() {
    all(300, 1, a_case);
}

#[test]
#[ignore = "minutes; see the head of this file"]
fn thousands_of_mutated_cases_neither_panic_nor_hang() {
    all(5000, 2, a_case);
}

#[test]
fn some_mutated_messages_neither_panic_nor_hang() {
    all(200, 3, a_message);
}

#[test]
#[ignore = "minutes; see the head of this file"]
fn thousands_of_mutated_messages_neither_panic_nor_hang() {
    all(5000, 4, a_message);
}

/// What stands in for a number, a word, a list.
const NUMBERS: [f64; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1e-300,
    1e300,
    -1e300,
    1e-6,
    1e6,
    1e18,
    1e30,
    f64::NAN,
    f64::INFINITY,
    0.5,
    4294967296.0,
    f64::MIN_POSITIVE,
];
const WORDS: [&str; 7] = ["", "\u{1b}[2J", "left", "own", "../../etc", "\0", "stable"];

/// A case: checked, previewed, and where that passes and is small, begun.
fn a_case(random: &mut Random) {
    let mut table: Table = random.of(&CASES).parse().expect("sound cases");
    for _ in 0..1 + random.below(3) {
        let mut value = Value::Table(std::mem::take(&mut table));
        mutate(&mut value, random);
        if let Value::Table(mutated) = value {
            table = mutated;
        }
    }
    let mut text = table.to_string();
    if random.below(8) == 0 {
        let at = (0..=random.below(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
        text.truncate(at);
    }
    let sections = [fluid::participant::SECTIONS, structure::participant::SECTIONS];
    let case = match Case::parse(&text, Path::new("case.toml"), &[], &sections) {
        Ok(case) => case,
        Err(errors) => {
            assert!(!errors.errors.is_empty() && errors.to_string().len() < 1_000_000);
            return;
        }
    };
    let again = Case::parse(&case.to_toml(), Path::new("case.toml"), &[], &sections);
    assert!(again.is_ok_and(|again| again.hash() == case.hash()), "a case as resolved reads back: {text}");
    let particles: f64 = case
        .fluid
        .iter()
        .flat_map(|fluid| &fluid.regions)
        .filter_map(interfaces::case::region::Region::shape)
        .map(|bounds| {
            let spacing = case.fluid.as_ref().map_or(1.0, |fluid| fluid.particle_spacing);
            bounds.extent().into_iter().map(|side| side / spacing).product::<f64>()
        })
        .sum();
    let walls = case.fluid.iter().flat_map(|fluid| fluid.domain.extent()).fold(0.0, f64::max);
    let spacings = [
        case.fluid.as_ref().map(|f| f.particle_spacing),
        case.structure.as_ref().map(|s| s.particle_spacing),
    ];
    let least = spacings.into_iter().flatten().fold(f64::INFINITY, f64::min);
    // What is large and allowed takes its time: it is not what is looked for here.
    if particles > 2e4 || walls / least > 1e4 || too_large(&case) {
        return;
    }
    preview(&case);
    begin(&case);
}

/// What `meniscus check` asks of a sound case.
fn preview(case: &Case) {
    if case.start(Role::Fluid) == Some(Start::Own) {
        let _ = (fluid::participant::preview(case), fluid::participant::time_steps(case));
    }
    if case.start(Role::Structure) == Some(Start::Own) {
        let _ = (structure::participant::preview(case), structure::participant::stable_sub_step(case));
    }
}

fn too_large(case: &Case) -> bool {
    let Some(structure) = &case.structure else { return false };
    let cells =
        |sides: Vec<f64>| sides.into_iter().map(|side| side / structure.particle_spacing).product::<f64>();
    structure.bodies.iter().map(|body| cells(body.bounds.extent())).sum::<f64>() > 5e3
        || case
            .fluid
            .iter()
            .flat_map(|fluid| &fluid.walls)
            .filter_map(|wall| wall.bounds.as_ref())
            .any(|bounds| cells(bounds.extent()) > 1e5)
}

/// The first windows of a run in this process, for half a second.
fn begin(case: &Case) {
    let dir = tempfile::tempdir().expect("a folder");
    let stop = Arc::new(AtomicBool::new(false));
    let options = coupler::run::Options {
        out: dir.path().join("out"),
        in_process: true,
        quiet: true,
        trace: false,
        domain: None,
        stop: Arc::clone(&stop),
        checkpoints: None,
        from: None,
        record: None,
    };
    std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(300));
        stop.store(true, Ordering::Relaxed);
    });
    let build = |role| match role {
        Role::Fluid => fluid::participant::from_case(case, dir.path()),
        Role::Structure => structure::participant::from_case(case, dir.path()),
    };
    let solvers = coupler::run::Solvers { in_process: &build, executable: Path::new("none") };
    let (_, result) = coupler::run::run(case, &options, &solvers);
    if let Err(error) = result {
        assert!(!error.to_string().contains("panicked"), "{error}\n{}", case.to_toml());
    }
}

/// Changes something somewhere below.
fn mutate(value: &mut Value, random: &mut Random) {
    match value {
        Value::Table(table) if !table.is_empty() => {
            let keys: Vec<String> = table.keys().cloned().collect();
            let key = random.of(&keys).clone();
            match random.below(12) {
                0 => drop(table.remove(&key)),
                1 => {
                    let copy = table[&key].clone();
                    let other = random.of(&keys).clone();
                    table.insert(other, copy);
                }
                _ => mutate(table.get_mut(&key).expect("it was listed"), random),
            }
        }
        Value::Array(list) if !list.is_empty() => {
            let index = random.below(list.len());
            match random.below(10) {
                0 => drop(list.remove(index)),
                1 => list.insert(index, list[index].clone()),
                2 => list.clear(),
                _ => mutate(&mut list[index], random),
            }
        }
        leaf => {
            *leaf = match random.below(8) {
                0 => Value::String((*random.of(&WORDS)).to_owned()),
                1 => Value::Integer(*random.of(&[0, -1, 1, 3, i64::MAX, i64::MIN, 1_000_000])),
                2 => Value::Array(vec![]),
                3 => Value::Boolean(true),
                4 => Value::Float(-leaf.as_float().unwrap_or(1.0)),
                _ => Value::Float(*random.of(&NUMBERS)),
            }
        }
    }
}

/// What a participant of three points sends: hello, ready, and solved or failed, one of them mutated.
fn a_message(random: &mut Random) {
    const HASH: &str = "hash";
    let structure = partners::build("spring-mass points=3 stiffness=400").expect("a mock");
    let description = structure.describe().clone();
    let domain = format!("fz-{}", std::process::id());
    let address = Address::new(new_run(), Role::Structure).in_domain(domain);
    let expectations = Expectations { case_hash: HASH.to_owned(), dimension: description.dimension };
    let deadlines = Deadlines { hello: Duration::from_millis(1500), answer: Duration::from_millis(400) };
    let listening =
        Listening::<WithinProcess>::over(&address, expectations, deadlines, &Arc::default()).expect("a link");
    let (seed, other) = (random.next(), address.clone());
    let hostile = std::thread::spawn(move || {
        // Whatever it is told, it goes on until nobody listens.
        let _ = speak(&other, &description, HASH, &mut Random(seed));
    });
    let heard =
        listening.wait_for_hello(Box::new(|| None)).map_err(|error| error.to_string()).and_then(|remote| {
            let fluid = Side::new(Box::new(Guarded::new(
                partners::build("constant gradient=0,1e3").expect("a mock"),
            )));
            let structure = Side::new(Box::new(Guarded::new(remote)));
            let pair = Pair::initialize(fluid, structure, 0.0, StructureVelocity::Mean)
                .map_err(|e| e.to_string())?;
            let explicit = SerialExplicit { relaxation: 1.0, enforce: true, predict: false };
            let schedule = Schedule::new(0.0, 3e-3, 1e-3, 1e-3, SubSteps::Fixed(1));
            let mut run = Run { solver: Coupled::new(pair, explicit), schedule };
            let mut windows = 0;
            run.drive(|_, _| {
                windows += 1;
                Ok(if windows < 50 { Onward::Continue } else { Onward::Stop })
            })
            .map_err(|error| error.to_string())
        });
    if let Err(error) = heard {
        assert!(!error.contains("panicked"), "{error}");
        assert!(
            error.len() < 100_000 && !error.contains('\u{1b}') && !error.contains('\0'),
            "{} bytes",
            error.len()
        );
    }
    let _ = hostile.join();
}

/// One message as it goes out.
struct Sent {
    header: MessageHeader,
    scalars: Vec<f64>,
    text: Vec<u8>,
}

/// Says hello, answers what is asked, and mutates one of its messages.
fn speak(address: &Address, description: &Description, hash: &str, random: &mut Random) -> Option<()> {
    let during = || "by hand".to_owned();
    let wait = Duration::from_secs(2);
    let alive = Box::new(|| None);
    let mut connection = Connection::<WithinProcess>::open(address, wait, Arc::default(), alive).ok()?;
    let victim = random.below(5);
    let outputs = description.fields(Direction::Out, 3);
    let count = description.scalars.len();
    let mut number = 0;
    let mut send = |connection: &mut Connection<WithinProcess>, mut sent: Sent, random: &mut Random| {
        let is_victim = number == victim;
        number += 1;
        let times = if is_victim { distort(&mut sent, random) } else { 1 };
        for _ in 0..times {
            let payload = Payload { scalars: &sent.scalars, fields: None, text: &sent.text };
            // The counts of the header are filled in by the connection: some are wrong all the same.
            connection.send(sent.header, &payload, true, during).ok()?;
        }
        Some(())
    };
    let hello = Hello { case_hash: hash.to_owned(), description: description.clone() };
    let text = serde_json::to_vec(&hello).ok()?;
    send(
        &mut connection,
        Sent { header: MessageHeader::new(Kind::Hello, 0), scalars: vec![], text },
        random,
    )?;
    loop {
        let message = connection.receive(wait, during).ok()?;
        let request = *message.header();
        drop(message);
        let values = |fields: &Fields, every_window: bool| -> Vec<u8> {
            let arrays = fields
                .iter()
                .filter(|(port, _)| !every_window || port.exchange == interfaces::Exchange::EveryWindow);
            arrays.flat_map(|(_, array)| array.iter().flat_map(|value| value.to_ne_bytes())).collect()
        };
        let (kind, text) = match request.kind()? {
            Kind::Initialize => (Kind::Ready, values(&outputs, false)),
            Kind::Start if random.below(6) == 0 => (Kind::Failed, b"particle 3 is inverted".to_vec()),
            Kind::Start => (Kind::Solved, values(&outputs, true)),
            Kind::Goodbye | Kind::Refused => return None,
            _ => continue,
        };
        let header = MessageHeader {
            window: request.window,
            iteration: request.iteration,
            size: 1.0,
            sub_steps: 1,
            ..MessageHeader::new(kind, request.sequence)
        };
        let scalars = if kind == Kind::Failed { vec![] } else { vec![0.0; count] };
        send(&mut connection, Sent { header, scalars, text }, random)?;
    }
}

/// Changes a message; says how many times it is sent.
fn distort(sent: &mut Sent, random: &mut Random) -> usize {
    for _ in 0..1 + random.below(3) {
        let header = &mut sent.header;
        let huge = *random.of(&[0, 1, 2, 17, u64::MAX, 1 << 31, 1_000_000_000_000_000_000]);
        let number = *random.of(&NUMBERS);
        match random.below(14) {
            0 => header.kind = random.below(20) as u32,
            1 => header.sequence = huge,
            2 => header.window = huge,
            3 => header.iteration = huge as u32,
            4 => header.sub_steps = huge as u32,
            5 => header.size = number,
            6 => header.compute_seconds = number,
            7 => header.version = random.below(4) as u32,
            8 => sent.text.truncate(random.below(sent.text.len() + 1)),
            9 => {
                let copy = sent.text.clone();
                sent.text.extend(copy);
            }
            10 if !sent.scalars.is_empty() => {
                let at = random.below(sent.scalars.len());
                sent.scalars[at] = number;
            }
            11 => sent.scalars.resize(random.below(100), number),
            12 => {
                for _ in 0..1 + random.below(16) {
                    let at = random.below(sent.text.len());
                    if let Some(byte) = sent.text.get_mut(at) {
                        *byte = random.next() as u8;
                    }
                }
            }
            _ => replace_a_token(&mut sent.text, random),
        }
    }
    // Text whose bytes are those of a value that is none.
    if random.below(10) == 0 {
        sent.text = packed(&sent.text).flat_map(|_| f64::NAN.to_ne_bytes()).collect();
    }
    1 + random.below(2)
}

/// Puts another number or word in the place of one of a JSON text.
fn replace_a_token(text: &mut Vec<u8>, random: &mut Random) {
    let Ok(mut json) = serde_json::from_slice::<serde_json::Value>(text) else {
        let long = 1 << (10 + random.below(12));
        *text = vec![*random.of(b"x\x1b\0\xff"); long];
        return;
    };
    fn leaves<'a>(value: &'a mut serde_json::Value, found: &mut Vec<&'a mut serde_json::Value>) {
        match value {
            serde_json::Value::Object(map) => map.values_mut().for_each(|value| leaves(value, found)),
            serde_json::Value::Array(list) => list.iter_mut().for_each(|value| leaves(value, found)),
            leaf => found.push(leaf),
        }
    }
    let mut found = Vec::new();
    leaves(&mut json, &mut found);
    let at = random.below(found.len());
    *found.swap_remove(at) = match random.below(6) {
        0 => serde_json::json!(1_000_000_000_000_000_000_u64),
        1 => serde_json::json!(1_000_000_000),
        2 => serde_json::json!(0),
        3 => serde_json::json!("\u{1b}[2J".repeat(1 + random.below(1000))),
        4 => serde_json::json!(null),
        _ => serde_json::json!(-1.5),
    };
    *text = json.to_string().into_bytes();
}
