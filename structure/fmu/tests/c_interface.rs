//! The shared library as an importer meets it: opened by name, called through C, in order and out of order.

#![expect(unsafe_code, reason = "functions of the standard are called through pointers, as importers do")]

use interfaces::case::Case;
use interfaces::{Direction, SubSteps, TimeWindow};
use libloading::{Library, Symbol};
use meniscus_structure::resources::{Points, Resources};
use std::ffi::{CStr, CString, c_char, c_void};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

type Handle = *mut c_void;
const OK: i32 = 0;
const ERROR: i32 = 3;

/// A plate of 3 × 30 particles that swings, as `cases/oscillating_plate`, on a base that begins to move.
const PLATE: &str = r#"
[case]
title = "Plate <&> beam"
dimension = 2
end_time = 0.1
output_interval = 0.01
particle_spacing = 6.666666666666667e-3
gravity = [0.0, -9.81]
threads = 1

[structure.material]
law = "saint-venant-kirchhoff"
youngs_modulus = 2e6
poisson_ratio = 0.4
density = 1000.0
assumption = "plane-strain"

[[structure.body]]
name = "plate"
box = { low = [0.0, -0.01], high = [0.2, 0.01] }
velocity = { mode = "cantilever", clamped_face = "left", tip_velocity = [0.0, 0.5] }

[[structure.clamp]]
name = "root"
body = "plate"
face = "left"
motion = { direction = [0.0, 1.0], amplitude = 2e-3, period = 0.05, start = 2e-3, ramp = 0.01 }

[[probe]]
name = "tip"
on = "structure"
quantity = "displacement"
at = [0.2, 0.0]
"#;

fn library() -> Library {
    let executable = std::env::current_exe().expect("a test is a file");
    let file = executable.parent().expect("in a folder").join(meniscus_structure::package::library_name());
    // SAFETY: our own library, which does nothing when it is opened.
    unsafe { Library::new(&file) }.unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// What the logger was told, by all instances of this process.
static SAID: Mutex<Vec<String>> = Mutex::new(Vec::new());

extern "C" fn hear(
    _environment: *mut c_void,
    _status: i32,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the library passes texts that end with a zero.
    let message = unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned();
    SAID.lock().unwrap().push(message);
}

/// Whether somebody was told something with these words.
fn heard(words: &str) -> bool {
    SAID.lock().unwrap().iter().any(|message| message.contains(words))
}

/// An unpacked unit's resources.
struct Unit {
    folder: tempfile::TempDir,
    token: CString,
}

impl Unit {
    fn new(points: Option<Vec<Vec<f64>>>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let case =
            Case::parse(PLATE, Path::new("case.toml"), &[], &[structure::participant::SECTIONS]).unwrap();
        let resources = Resources::new(&case, points.map(|points| Points { points }));
        std::fs::write(folder.path().join("case.toml"), &resources.case).unwrap();
        if let Some(points) = resources.points_text() {
            std::fs::write(folder.path().join("points.toml"), points).unwrap();
        }
        Self { token: CString::new(resources.token()).unwrap(), folder }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().to_owned()
    }

    fn c_path(&self) -> CString {
        CString::new(self.path().to_str().unwrap()).unwrap()
    }
}

/// Calls a function of the library by name; the types are those of the arguments given.
macro_rules! c {
    ($library:expr, $name:literal ($($argument:expr => $type:ty),*) -> $result:ty) => {{
        // SAFETY: the types are those of the standard's header.
        unsafe {
            let function: Symbol<unsafe extern "C" fn($($type),*) -> $result> = $library.get($name).expect("the library exports it");
            function($($argument),*)
        }
    }};
}

fn instantiate(library: &Library, unit: &Unit, token: &CStr) -> Handle {
    let name = c"instance";
    let path = unit.c_path();
    type Hear = extern "C" fn(*mut c_void, i32, *const c_char, *const c_char);
    c!(library, b"fmi3InstantiateCoSimulation" (
        name.as_ptr() => *const c_char, token.as_ptr() => *const c_char, path.as_ptr() => *const c_char,
        false => bool, false => bool, false => bool, false => bool, std::ptr::null() => *const u32, 0 => usize,
        std::ptr::null_mut() => *mut c_void, hear => Hear, std::ptr::null() => *const c_void
    ) -> Handle)
}

fn simple(library: &Library, name: &[u8], instance: Handle) -> i32 {
    // SAFETY: a function of one instance.
    unsafe { library.get::<unsafe extern "C" fn(Handle) -> i32>(name).expect("exported")(instance) }
}

fn enter_initialization(library: &Library, instance: Handle) -> i32 {
    c!(library, b"fmi3EnterInitializationMode" (instance => Handle, false => bool, 0.0 => f64, 0.0 => f64, false => bool, 0.0 => f64) -> i32)
}

fn initialize(library: &Library, instance: Handle) {
    assert_eq!(enter_initialization(library, instance), OK);
    assert_eq!(simple(library, b"fmi3ExitInitializationMode", instance), OK);
}

fn step(library: &Library, instance: Handle, start: f64, size: f64) -> (i32, f64) {
    let (mut flags, mut last) = ([true; 3], f64::NAN);
    let [event, terminate, early] = &mut flags;
    let status = c!(library, b"fmi3DoStep" (
        instance => Handle, start => f64, size => f64, true => bool,
        event => *mut bool, terminate => *mut bool, early => *mut bool, &raw mut last => *mut f64
    ) -> i32);
    if status == OK {
        assert_eq!(flags, [false; 3]);
    }
    (status, last)
}

fn get(library: &Library, instance: Handle, reference: u32, values: &mut [f64]) -> i32 {
    c!(library, b"fmi3GetFloat64" (
        instance => Handle, &raw const reference => *const u32, 1 => usize, values.as_mut_ptr() => *mut f64, values.len() => usize
    ) -> i32)
}

fn set(library: &Library, instance: Handle, reference: u32, values: &[f64]) -> i32 {
    c!(library, b"fmi3SetFloat64" (
        instance => Handle, &raw const reference => *const u32, 1 => usize, values.as_ptr() => *const f64, values.len() => usize
    ) -> i32)
}

fn count(library: &Library, instance: Handle) -> u64 {
    let (reference, mut value) = (1_u32, 0_u64);
    let status = c!(library, b"fmi3GetUInt64" (
        instance => Handle, &raw const reference => *const u32, 1 => usize, &raw mut value => *mut u64, 1 => usize
    ) -> i32);
    assert_eq!(status, OK);
    value
}

fn set_count(library: &Library, instance: Handle, value: u64) -> i32 {
    let reference = 1_u32;
    c!(library, b"fmi3SetUInt64" (
        instance => Handle, &raw const reference => *const u32, 1 => usize, &raw const value => *const u64, 1 => usize
    ) -> i32)
}

fn free(library: &Library, instance: Handle) {
    c!(library, b"fmi3FreeInstance" (instance => Handle) -> ());
}

/// Value references of the whole interface: see `variables::table`.
const YOUNGS_MODULUS: u32 = 2;
const PARTICLE_SPACING: u32 = 5;
const PRESSURE_GRADIENT: u32 = 8;
const POSITION: u32 = 9;
const PARTICLES: usize = 90;
const DT: f64 = 1e-3;

/// A load that changes from step to step and from particle to particle.
fn load(step: usize) -> Vec<f64> {
    (0..2 * PARTICLES).map(|n| 200.0 * ((n + 7 * step) as f64).sin()).collect()
}

/// Positions after each of `steps` steps of the native participant.
fn native(steps: usize) -> Vec<Vec<f64>> {
    let case = Case::parse(PLATE, Path::new("case.toml"), &[], &[structure::participant::SECTIONS]).unwrap();
    let mut structure = structure::participant::without_snapshots(&case).unwrap();
    let mut inputs = structure.describe().fields(Direction::In, 0);
    let mut outputs = structure.describe().fields(Direction::Out, 0);
    structure.initialize(0.0, &inputs, &mut outputs).unwrap();
    (0..steps)
        .map(|n| {
            inputs.get_mut("pressure_gradient").unwrap().copy_from_slice(&load(n));
            let window = TimeWindow {
                index: n as u64,
                iteration: 0,
                start: n as f64 * DT,
                size: DT,
                sub_steps: SubSteps::Stable,
            };
            structure.start(&window, &inputs).unwrap();
            structure.finish(&mut outputs).unwrap();
            structure.accept(None).unwrap();
            outputs.get("position").unwrap().to_vec()
        })
        .collect()
}

fn loaded_step(library: &Library, instance: Handle, n: usize) -> Vec<f64> {
    assert_eq!(set(library, instance, PRESSURE_GRADIENT, &load(n)), OK);
    let start = n as f64 * DT;
    assert_eq!(step(library, instance, start, DT), (OK, start + DT));
    let mut positions = vec![0.0; 2 * PARTICLES];
    assert_eq!(get(library, instance, POSITION, &mut positions), OK);
    positions
}

#[test]
fn a_unit_gives_the_native_run_to_the_bit_and_so_do_two_at_once() {
    let (library, unit) = (library(), Unit::new(None));
    let expected = native(6);
    let instances = [0, 1].map(|_| instantiate(&library, &unit, &unit.token));
    for instance in instances {
        assert!(!instance.is_null());
        assert_eq!(count(&library, instance), PARTICLES as u64);
        initialize(&library, instance);
    }
    for (n, expected) in expected.iter().enumerate() {
        for instance in instances {
            assert_eq!(&loaded_step(&library, instance, n), expected, "step {n}");
        }
    }
    for instance in instances {
        assert_eq!(simple(&library, b"fmi3Terminate", instance), OK);
        free(&library, instance);
    }
}

#[test]
fn a_state_kept_or_serialised_goes_on_to_the_bit() {
    let (library, unit) = (library(), Unit::new(None));
    let expected = native(6);
    let instance = instantiate(&library, &unit, &unit.token);
    initialize(&library, instance);
    for n in 0..3 {
        loaded_step(&library, instance, n);
    }
    let mut state: Handle = std::ptr::null_mut();
    let place = &raw mut state;
    assert_eq!(c!(library, b"fmi3GetFMUState" (instance => Handle, place => *mut Handle) -> i32), OK);
    let mut size = 0_usize;
    let wanted = c!(library, b"fmi3SerializedFMUStateSize" (instance => Handle, state => Handle, &raw mut size => *mut usize) -> i32);
    assert_eq!(wanted, OK);
    let mut bytes = vec![0_u8; size];
    let serialize = |bytes: &mut [u8]| c!(library, b"fmi3SerializeFMUState" (instance => Handle, state => Handle, bytes.as_mut_ptr() => *mut u8, bytes.len() => usize) -> i32);
    assert_eq!(serialize(&mut bytes), OK);
    assert_eq!(serialize(&mut bytes[1..]), ERROR);
    for n in 3..6 {
        assert_eq!(loaded_step(&library, instance, n), expected[n]);
    }
    let kept = state;
    // Back, in the same instance.
    assert_eq!(c!(library, b"fmi3SetFMUState" (instance => Handle, state => Handle) -> i32), OK);
    assert_eq!(loaded_step(&library, instance, 3), expected[3]);
    assert_eq!(c!(library, b"fmi3FreeFMUState" (instance => Handle, place => *mut Handle) -> i32), OK);
    assert!(state.is_null());
    // A freed state is none.
    assert_eq!(c!(library, b"fmi3SetFMUState" (instance => Handle, kept => Handle) -> i32), ERROR);
    // On, in another instance that was only made.
    let other = instantiate(&library, &unit, &unit.token);
    let mut read: Handle = std::ptr::null_mut();
    let deserialize = |length: usize, read: *mut Handle| c!(library, b"fmi3DeserializeFMUState" (other => Handle, bytes.as_ptr() => *const u8, length => usize, read => *mut Handle) -> i32);
    assert_eq!(deserialize(size - 1, &raw mut read), ERROR);
    assert!(heard("the unit's state is cut off"));
    assert_eq!(deserialize(size, &raw mut read), OK);
    assert_eq!(c!(library, b"fmi3SetFMUState" (other => Handle, read => Handle) -> i32), OK);
    for n in 3..6 {
        assert_eq!(loaded_step(&library, other, n), expected[n]);
    }
    free(&library, instance);
    free(&library, other);
}

#[test]
fn what_is_out_of_order_or_wrong_is_an_error_with_a_message() {
    let (library, unit) = (library(), Unit::new(None));
    assert!(instantiate(&library, &unit, c"{another}").is_null());
    assert!(heard("model description and resources are of two units"));
    let instance = instantiate(&library, &unit, &unit.token);
    assert_eq!(step(&library, instance, 0.0, DT).0, ERROR);
    assert!(heard("fmi3DoStep: fmi3DoStep is not allowed now"));
    assert_eq!(simple(&library, b"fmi3ExitInitializationMode", instance), ERROR);
    // Outside of configuration mode.
    assert_eq!(set_count(&library, instance, 7), ERROR);
    assert!(heard("it is set in configuration mode"));
    // Wrong lengths, references, values.
    let mut positions = vec![0.0; 2 * PARTICLES];
    assert_eq!(get(&library, instance, POSITION, &mut positions[1..]), ERROR);
    assert!(heard("179 values are given for variables that have 180"));
    assert_eq!(get(&library, instance, 99, &mut [0.0]), ERROR);
    assert_eq!(get(&library, instance, 1, &mut [0.0]), ERROR);
    assert!(heard("value reference 1 is no real variable"));
    assert_eq!(set(&library, instance, POSITION, &positions), ERROR);
    assert!(heard("the unit computes it"));
    positions[5] = f64::NAN;
    assert_eq!(set(&library, instance, PRESSURE_GRADIENT, &positions), ERROR);
    assert!(heard("not finite: value 5 is NaN"));
    let null = c!(library, b"fmi3GetFloat64" (
        instance => Handle, std::ptr::null() => *const u32, 1 => usize, positions.as_mut_ptr() => *mut f64, 1 => usize
    ) -> i32);
    assert_eq!(null, ERROR);
    assert!(heard("valueReferences is a null pointer"));
    // A parameter that the case cannot hold with: initialisation says why.
    assert_eq!(set(&library, instance, YOUNGS_MODULUS, &[-1.0]), OK);
    assert_eq!(enter_initialization(&library, instance), ERROR);
    assert!(heard("youngs_modulus"));
    assert_eq!(simple(&library, b"fmi3Reset", instance), OK);
    initialize(&library, instance);
    assert_eq!(set(&library, instance, YOUNGS_MODULUS, &[1e6]), ERROR);
    assert!(heard("parameters are fixed"));
    // Steps that do not follow, or are none.
    for (start, size) in [(0.5, DT), (0.0, 0.0), (0.0, -DT), (f64::NAN, DT), (0.0, f64::INFINITY)] {
        assert_eq!(step(&library, instance, start, size).0, ERROR, "{start} {size}");
    }
    assert!(heard("but the last ended at 0 s"));
    // A load that tears the plate: the step fails, the instance is broken, and reset brings it back.
    assert_eq!(set(&library, instance, PRESSURE_GRADIENT, &vec![1e12; 2 * PARTICLES]), OK);
    assert_eq!(step(&library, instance, 0.0, DT).0, ERROR);
    assert!(heard("is inverted or torn") || heard("is not finite;"));
    assert_eq!(step(&library, instance, 0.0, DT).0, ERROR);
    assert_eq!(simple(&library, b"fmi3Reset", instance), OK);
    initialize(&library, instance);
    assert_eq!(step(&library, instance, 0.0, DT).0, OK);
    free(&library, instance);
    // Freed twice, and used after it.
    free(&library, instance);
    assert_eq!(step(&library, instance, DT, DT).0, ERROR);
    assert_eq!(simple(&library, b"fmi3Terminate", 0xdead_0000 as Handle), ERROR);
    assert_eq!(simple(&library, b"fmi3Reset", std::ptr::null_mut()), ERROR);
}

#[test]
fn a_coarser_plate_has_fewer_particles_and_says_how_many() {
    let (library, unit) = (library(), Unit::new(None));
    let instance = instantiate(&library, &unit, &unit.token);
    // Four layers: 40 columns.
    assert_eq!(set(&library, instance, PARTICLE_SPACING, &[5e-3]), OK);
    assert_eq!(enter_initialization(&library, instance), ERROR);
    assert!(heard("set interface_points to 160 in configuration mode"));
    assert_eq!(simple(&library, b"fmi3Reset", instance), OK);
    assert_eq!(set(&library, instance, PARTICLE_SPACING, &[5e-3]), OK);
    assert_eq!(simple(&library, b"fmi3EnterConfigurationMode", instance), OK);
    assert_eq!(set_count(&library, instance, 160), OK);
    assert_eq!(simple(&library, b"fmi3ExitConfigurationMode", instance), OK);
    initialize(&library, instance);
    assert_eq!(step(&library, instance, 0.0, DT).0, OK);
    let mut positions = vec![0.0; 320];
    assert_eq!(get(&library, instance, POSITION, &mut positions), OK);
    assert!(positions.iter().all(|x| x.is_finite()));
    free(&library, instance);
}

/// Memory of this process (pages); nothing where the system does not tell.
fn pages() -> Option<usize> {
    std::fs::read_to_string("/proc/self/statm").ok()?.split(' ').nth(1)?.parse().ok()
}

#[test]
fn a_thousand_instances_leave_nothing_behind() {
    let (library, unit) = (library(), Unit::new(None));
    let cycle = || {
        let instance = instantiate(&library, &unit, &unit.token);
        initialize(&library, instance);
        assert_eq!(step(&library, instance, 0.0, 1e-4).0, OK);
        let mut state: Handle = std::ptr::null_mut();
        let place = &raw mut state;
        assert_eq!(c!(library, b"fmi3GetFMUState" (instance => Handle, place => *mut Handle) -> i32), OK);
        assert_eq!(c!(library, b"fmi3FreeFMUState" (instance => Handle, place => *mut Handle) -> i32), OK);
        free(&library, instance);
    };
    (0..100).for_each(|_| cycle());
    let before = pages();
    (0..900).for_each(|_| cycle());
    if let (Some(before), Some(after)) = (before, pages()) {
        // An instance takes about 200 kB, 900 that leaked would be 45,000 pages; the allocator may keep some
        // of its own.
        assert!(after < before + 2000, "{before} pages before, {after} after");
    }
}

#[test]
fn fmi_2_has_scalar_variables_at_points_that_keep_force_and_motion() {
    let library = library();
    let unit = Unit::new(Some(vec![vec![0.19, 0.0], vec![0.1, 0.005]]));
    extern "C" fn hear_2(
        _: *mut c_void,
        _: *const c_char,
        _: i32,
        _: *const c_char,
        _: *const c_char,
        message: *const c_char,
    ) {
        hear(std::ptr::null_mut(), 3, std::ptr::null(), message);
    }
    type Hear = extern "C" fn(*mut c_void, *const c_char, i32, *const c_char, *const c_char, *const c_char);
    #[repr(C)]
    struct Callbacks(Hear, *const c_void, *const c_void, *const c_void, *const c_void);
    let null = std::ptr::null();
    let callbacks = Callbacks(hear_2, null, null, null, null);
    let location = CString::new(format!("file://{}", unit.path().display())).unwrap();
    let made = |token: &CStr| {
        c!(library, b"fmi2Instantiate" (
            c"two".as_ptr() => *const c_char, 1 => i32, token.as_ptr() => *const c_char, location.as_ptr() => *const c_char,
            (&raw const callbacks).cast() => *const c_void, 0 => i32, 0 => i32
        ) -> Handle)
    };
    assert!(made(c"{none}").is_null());
    let instance = made(&unit.token);
    assert!(!instance.is_null());
    let setup = c!(library, b"fmi2SetupExperiment" (instance => Handle, 0 => i32, 0.0 => f64, 0.0 => f64, 0 => i32, 0.0 => f64) -> i32);
    assert_eq!(setup, OK);
    assert_eq!(simple(&library, b"fmi2EnterInitializationMode", instance), OK);
    assert_eq!(simple(&library, b"fmi2ExitInitializationMode", instance), OK);
    // point[1]: force.x, force.y, position.x, position.y, velocity.x, velocity.y
    let read = |reference: u32| {
        let mut value = f64::NAN;
        let status = c!(library, b"fmi2GetReal" (instance => Handle, &raw const reference => *const u32, 1 => usize, &raw mut value => *mut f64) -> i32);
        assert_eq!(status, OK);
        value
    };
    assert!((read(10) - 0.19).abs() < 1e-12 && read(11).abs() < 1e-12);
    assert!((read(16) - 0.1).abs() < 1e-12 && (read(17) - 0.005).abs() < 1e-12);
    let (reference, pull) = (9_u32, 30.0);
    let set = c!(library, b"fmi2SetReal" (instance => Handle, &raw const reference => *const u32, 1 => usize, &raw const pull => *const f64) -> i32);
    assert_eq!(set, OK);
    // Scalars follow the points: kinetic, strain and potential energy, load work.
    let energy = |n: u32| read(20 + n);
    let (height, potential, work) = (read(11), energy(2), energy(3));
    for n in 0..5 {
        assert_eq!(
            c!(library, b"fmi2DoStep" (instance => Handle, f64::from(n) * DT => f64, DT => f64, 1 => i32) -> i32),
            OK
        );
    }
    // The work of the force on its point is that of all loads less gravity's, which potential energy tells.
    let (of_force, of_loads) = (pull * (read(11) - height), energy(3) - work + energy(2) - potential);
    assert!(of_force > 1e-3 && (of_force / of_loads - 1.0).abs() < 1e-6, "{of_force} {of_loads}");
    c!(library, b"fmi2FreeInstance" (instance => Handle) -> ());
    assert_eq!(simple(&library, b"fmi2Reset", instance), ERROR);
}

/// What goes into a unit is the library without its debuggers' part: an eighth of it, and it answers as
/// before.
#[test]
#[cfg(target_os = "linux")]
fn a_stripped_library_is_small_and_answers_as_before() {
    use meniscus_structure::library::{needed_glibc, stripped};
    let executable = std::env::current_exe().unwrap();
    let file = executable.parent().unwrap().join(meniscus_structure::package::library_name());
    let whole = std::fs::read(file).unwrap();
    let (length, needed) = (whole.len(), needed_glibc(&whole));
    let short = stripped(whole);
    assert!(short.len() < length / 3, "{} of {length}", short.len());
    // Nothing more is left to take away, and it needs what it needed: some version of the last twenty years.
    assert_eq!(stripped(short.clone()).len(), short.len());
    assert_eq!(needed_glibc(&short), needed);
    if cfg!(target_env = "gnu") {
        assert!(needed.is_some_and(|version| version > (2, 2) && version <= (2, 35)), "{needed:?}");
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("short.so");
    std::fs::write(&file, short).unwrap();
    // SAFETY: our own library, which does nothing when it is opened.
    let library = unsafe { Library::new(&file) }.unwrap();
    let unit = Unit::new(None);
    let instance = instantiate(&library, &unit, &unit.token);
    initialize(&library, instance);
    assert_eq!(loaded_step(&library, instance, 0), native(1)[0]);
    free(&library, instance);
}
