//! The participants of a run: in this process, started as processes, or waited for.

use super::folder::CASE;
use super::options::{Options, RunError};
use crate::launch::guard::Guard;
use crate::launch::{self, Child};
use crate::mapped::fluid::MappedFluid;
use crate::mapped::{Filling, Mapped};
use crate::placement::Placement;
use crate::recording::Recording;
use crate::scenario::{Altered, Did, ScenarioError};
use crate::schemes::SchemeError;
use crate::side::{Side, SideError};
use crate::status::Task;
use crate::timing::Timing;
use interfaces::case::Case;
use interfaces::case::coupling::{Mapping, MappingMethod};
use interfaces::case::participant::Start;
use interfaces::port::names;
use interfaces::transport::{Alive, FOLDER};
use interfaces::{
    Address, Deadlines, Description, Direction, Expectations, Guarded, Participant, ParticipantError,
    RemoteParticipant, Result, Role, new_run, remove_stale,
};
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use words::text::tame;

/// Makes a participant in this process.
pub type Build<'a> = dyn Fn(Role) -> Result<Box<dyn Participant>> + 'a;

/// Where our own solvers come from.
pub struct Solvers<'a> {
    /// Makes one in this process.
    pub in_process: &'a Build<'a>,
    /// The executable whose commands `fluid` and `structure` serve them, and whose command `fmu` serves a
    /// unit.
    pub executable: &'a Path,
}

/// How long a participant that was told to end may take.
const GRACE: Duration = Duration::from_millis(1500);
/// How long a participant that has to be started by hand may take to come, and to hear of a fault.
const BY_HAND: Duration = Duration::from_secs(600);

/// What a participant is at until it has said what it is.
const SHAKING_HANDS: &str = "shaking hands";

/// Participants by role.
type ByRole<T> = BTreeMap<Role, T>;

/// The participants of a run, and the processes behind them.
pub struct Participants {
    /// The clock of the run.
    pub(crate) timing: Timing,
    sides: ByRole<Side>,
    children: ByRole<Rc<RefCell<Child>>>,
    /// An address of the run, where it has any.
    address: Option<Address>,
    guard: Option<Guard>,
    did: Did,
    /// Who was found to have ended while another was waited for, and how.
    fallen: Rc<RefCell<Option<(Role, String)>>>,
    /// Whether participants end in order from now on.
    leaving: Rc<Cell<bool>>,
    /// The folder of the outputs, locked.
    folder: Option<File>,
    interruption: Rc<Interruption>,
    /// Where all that crosses is recorded.
    recording: Option<Recording>,
    /// One ended before it was heard of: nobody has anything to finish.
    died_at_the_start: bool,
}

impl Participants {
    /// None yet, of a run that is told to stop by that flag, and whose locked folder this is.
    pub fn new(timing: Timing, stop: &Arc<AtomicBool>, folder: Option<File>) -> Self {
        Self {
            timing,
            sides: ByRole::new(),
            children: ByRole::new(),
            address: None,
            guard: None,
            did: Did::default(),
            fallen: Rc::default(),
            leaving: Rc::default(),
            folder,
            interruption: Rc::new(Interruption::by(stop)),
            recording: None,
            died_at_the_start: false,
        }
    }

    /// Records all that crosses to and from those that are started from now on.
    pub(crate) fn record(&mut self, recording: Recording) {
        self.recording = Some(recording);
    }

    /// From now on, who is told to stop waits so long for the window at hand. At first it does not wait.
    pub(crate) fn be_patient(&self, patience: Duration) {
        self.interruption.patience.set(patience);
    }

    /// Makes or starts all participants of the case, and waits until each was heard of. Whatever comes of it,
    /// [`Participants::end`] ends those that were started.
    pub fn start(&mut self, case: &Case, options: &Options, solvers: &Solvers) -> Result<(), RunError> {
        let roles = [Role::Structure, Role::Fluid].into_iter();
        let mut starts: Vec<_> = roles.filter_map(|role| Some((role, case.start(role)?))).collect();
        if options.in_process {
            for (role, _) in starts {
                let made = (solvers.in_process)(role).map_err(|e| failed(role, "while starting", e))?;
                self.timing.board().came(role, &made.describe().solver);
                let side = self.side(case, made, options)?;
                self.sides.insert(role, side);
            }
            return Ok(());
        }

        let run = new_run();
        // Those that a person starts come last: what the others find wrong is heard of at once.
        starts.sort_by_key(|(_, start)| *start == Start::ByHand);
        // All are listened for before any is started, and all are started before any is waited for: they
        // build their particles at the same time.
        let mut listening = Vec::new();
        for (role, start) in starts {
            let mut address = Address::new(run.clone(), role);
            if let Some(domain) = &options.domain {
                address = address.in_domain(domain);
            }
            let failed = |e| failed(role, "while opening its connection", e);
            remove_stale(&address).map_err(failed)?;
            let expectations = Expectations { case_hash: case.hash(), dimension: case.general.dimension };
            let waits = deadlines(case, start == Start::ByHand);
            let open = RemoteParticipant::listen(&address, expectations, waits, &self.interruption.waits_end);
            let open = open.map_err(failed)?;
            self.address = Some(address.clone());
            listening.push((role, start, address, open));
        }
        if let Some(address) = &self.address {
            self.guard = Some(Guard::start(solvers.executable, address, self.folder.as_ref())?);
        }
        for (role, start, address, _) in &listening {
            self.launch(*role, *start, address, &case.hash(), options, solvers)?;
        }
        for (role, _, _, open) in listening {
            self.timing.board().waits_for(role);
            let remote = open.wait_for_hello(self.alive(role)).map_err(|error| {
                self.died_at_the_start = matches!(error, ParticipantError::Died { .. });
                failed(role, &format!("while {SHAKING_HANDS}"), error)
            })?;
            self.timing.board().came(role, &remote.describe().solver);
            let side = self.side(case, Box::new(remote), options)?;
            self.sides.insert(role, side);
        }
        Ok(())
    }

    /// A participant behind the table of legal calls, timed, and recorded where that is asked for; one with
    /// points of its own behind its mapping.
    fn side(
        &self,
        case: &Case,
        participant: Box<dyn Participant>,
        options: &Options,
    ) -> Result<Side, RunError> {
        let participant = self.altered(participant, options)?;
        let timed = self.timing.timed(Guarded::new(participant));
        let timed: Box<dyn Participant> = match &self.recording {
            Some(recording) => Box::new(recording.recorder(timed, self.timing.announce())),
            None => Box::new(timed),
        };
        let Some(coupling) = &case.coupling else { return Ok(Side::new(timed)) };
        let (role, announce) = (timed.describe().role, self.timing.announce());
        let mapping = coupling.mapping.clone().or_else(|| mapping_of_forces(case, timed.describe()));
        // What a mapping makes of finite fields is checked again before it is passed on.
        Ok(Side::new(match (role, &mapping, &coupling.fluid_mapping) {
            (Role::Structure, Some(mapping), _) => {
                let filling = Filling::of(case, mapping.spacing);
                let mapped = Mapped::new(timed, mapping.clone(), filling, announce);
                let mut mapped = mapped.map_err(|e| failed(role, "while shaking hands", e))?;
                // While weights are made, nobody solves.
                mapped.use_threads(threads(case));
                Box::new(Guarded::new(mapped))
            }
            (Role::Fluid, _, Some(mapping)) => {
                let mapped = MappedFluid::new(timed, mapping.clone(), announce);
                let mut mapped = mapped.map_err(|e| failed(role, "while shaking hands", e))?;
                mapped.use_threads(threads(case));
                Box::new(Guarded::new(mapped))
            }
            _ => timed,
        }))
    }

    /// The participant under what of a scenario is its own.
    fn altered(
        &self,
        participant: Box<dyn Participant>,
        options: &Options,
    ) -> Result<Box<dyn Participant>, RunError> {
        let role = participant.describe().role;
        let scenario = options.scenario.as_ref().and_then(|scenario| Some((scenario, scenario.of(role)?)));
        let Some((scenario, of)) = scenario else { return Ok(participant) };
        let process = self.children.get(&role).map(|child| child.borrow().id());
        let strike = move |blow| match process {
            Some(process) => launch::strike(process, blow).map_err(|error| error.to_string()),
            None => Err(format!("the {role} has no process that this run started")),
        };
        let altered = Altered::new(participant, of, Box::new(strike), self.did.clone());
        let altered = altered.map_err(|mistakes| ScenarioError { path: scenario.path.clone(), mistakes })?;
        Ok(Box::new(altered))
    }

    /// What a scenario did, once all sides have ended.
    pub(crate) fn did(&self) -> Did {
        self.did.clone()
    }

    /// Processor time of all processes that were started (s).
    pub(crate) fn cpu_seconds(&self) -> f64 {
        self.children.values().map(|child| child.borrow().cpu_seconds()).sum()
    }

    /// Where the processes are executed: apart, unless the case lets both that we started share a core with
    /// us.
    pub(crate) fn placement(&self, case: &Case) -> Placement {
        let may = case.coupling.as_ref().is_some_and(|coupling| coupling.share_core);
        let started: Vec<_> = self.children.values().map(|child| child.borrow().id()).collect();
        Placement::new(if may && started.len() == 2 { &started } else { &[] })
    }

    /// Hands over the side of that role, if the case has it.
    pub fn take(&mut self, role: Role) -> Option<Side> {
        self.sides.remove(&role)
    }

    /// Notes how much memory each process has used so far.
    pub fn look_at_memory(&mut self) {
        for child in self.children.values() {
            child.borrow_mut().peak_memory_bytes();
        }
    }

    /// Waits for the processes to end, kills those that do not, and removes what they leave in shared memory
    /// then. Gives the largest memory of each role (bytes), and how those ended that did not end in order.
    /// After a failure there is nothing to wait for: whoever still runs does so because it hangs.
    pub fn end(mut self, in_order: bool) -> (BTreeMap<String, u64>, Vec<SideError>) {
        // Sides that nobody took are told by this that nothing more is wanted.
        self.sides.clear();
        self.look_at_memory();
        let mut memory = BTreeMap::from([("coupler".to_owned(), launch::peak_memory_bytes(None))]);
        let mut ends = Vec::new();
        let grace = match in_order {
            true => GRACE,
            // The others wait for us, as we would for them.
            false if self.died_at_the_start => Duration::ZERO,
            false => GRACE / 3,
        };
        let deadline = Instant::now() + grace;
        for (role, child) in &self.children {
            let mut child = child.borrow_mut();
            memory.insert(role.to_string(), child.peak_memory_bytes());
            if let Some(how) = child.end(deadline) {
                let source = ParticipantError::failed(how);
                ends.push(SideError { role: *role, during: "after its last answer".to_owned(), source });
            }
        }
        if let Some(address) = &self.address {
            // What cannot be removed now is removed by the next run; it is no reason to call this one failed.
            let _ = remove_stale(address);
        }
        (memory, ends)
    }

    fn launch(
        &mut self,
        role: Role,
        start: Start<'_>,
        address: &Address,
        hash: &str,
        options: &Options,
        solvers: &Solvers,
    ) -> Result<(), RunError> {
        self.timing.board().asked(role, Task::Come);
        let case = options.out.join(CASE);
        // Who starts a participant by hand may stand elsewhere.
        let case = std::path::absolute(&case).unwrap_or(case);
        let command = match start {
            Start::Own => {
                let executable = solvers.executable.display().to_string();
                vec![executable, role.to_string(), case.display().to_string()]
            }
            // A coupler that is killed before its guard knows of the program must not leave it behind, and
            // such a program does not look for itself.
            Start::Command(words) => {
                let executable = solvers.executable.display().to_string();
                [&[executable, "become".to_owned()], words].concat()
            }
            Start::Fmu(_) => {
                let executable = solvers.executable.display().to_string();
                vec![executable, "fmu".to_owned(), role.to_string(), case.display().to_string()]
            }
            Start::ByHand => {
                eprintln!(
                    "waiting for the {role}; start it with MENISCUS_RUN={} {FOLDER}={} MENISCUS_CASE={} MENISCUS_CASE_HASH={hash}, for example before `meniscus {role}`",
                    address.connect(),
                    address.root(),
                    tame(&case.display().to_string(), usize::MAX)
                );
                return Ok(());
            }
        };
        let environment = [
            ("MENISCUS_RUN", address.connect()),
            (FOLDER, address.root()),
            ("MENISCUS_CASE", case.display().to_string()),
            ("MENISCUS_CASE_HASH", hash.to_owned()),
            ("MENISCUS_ROLE", role.to_string()),
            ("MENISCUS_COUPLER", std::process::id().to_string()),
        ];
        let log = options.out.join(format!("{role}.log"));
        let mut child = Child::spawn(role, &command, &environment, &log)?;
        self.timing.board().started(role, child.id().as_raw_nonzero().get().unsigned_abs());
        if let Some(guard) = &mut self.guard {
            guard.watch(child.id());
        }
        child.release();
        self.children.insert(role, Rc::new(RefCell::new(child)));
        Ok(())
    }

    /// Says how the process of that role ended, as far as we started one; and ends the wait for it where that
    /// of another role has: nobody waits for the answer of one while the other is gone already.
    fn alive(&self, role: Role) -> Alive {
        let child = self.children.get(&role).map(Rc::clone);
        let others: Vec<_> = self.children.iter().filter(|(other, _)| **other != role).collect();
        let others: Vec<_> = others.into_iter().map(|(other, child)| (*other, Rc::clone(child))).collect();
        let (interruption, leaving) = (Rc::clone(&self.interruption), Rc::clone(&self.leaving));
        let fallen = Rc::clone(&self.fallen);
        Box::new(move || {
            let ended = child.as_ref().and_then(|child| child.borrow_mut().ended());
            let mut ends =
                others.iter().filter_map(|(other, child)| Some((*other, child.borrow_mut().ended()?)));
            let other = if leaving.get() { None } else { ends.next() };
            interruption.look(ended.is_some() || other.is_some());
            if ended.is_some() || interruption.is_asked() {
                return ended;
            }
            let (other, how) = other?;
            let words = format!("the {other} has ended");
            fallen.replace(Some((other, how)));
            Some(words)
        })
    }

    /// From now on participants end, and it is no failure.
    pub(crate) fn leave(&self) {
        self.leaving.set(true);
    }

    /// The failure of a wait, laid at the door of the one whose end broke it off.
    pub(crate) fn blame(&self, error: RunError) -> RunError {
        let RunError::Scheme(SchemeError::Side(SideError { role, during, source })) = error else {
            return error;
        };
        let fallen = self.fallen.take().filter(|(fallen, _)| *fallen != role);
        let (role, during, source) = match (fallen, source) {
            (Some((fallen, how)), ParticipantError::Died { .. }) => {
                // Both shake hands at once; later one has its turn.
                let (during, when) = match during.strip_prefix("while ") {
                    Some(rest) if rest != SHAKING_HANDS => {
                        (format!("while the {role} was {rest}"), "before its turn")
                    }
                    _ => (during, "while connecting"),
                };
                (fallen, during, ParticipantError::Died { during: format!("{when} ({how})") })
            }
            (_, source) => (role, during, source),
        };
        SideError { role, during, source }.into()
    }
}

/// Ends waits for participants when the run is told to stop: at once, or after the window at hand.
struct Interruption {
    asked: Arc<AtomicBool>,
    since: Cell<Option<Instant>>,
    patience: Cell<Duration>,
    /// What the waits look at.
    waits_end: Arc<AtomicBool>,
}

impl Interruption {
    fn by(stop: &Arc<AtomicBool>) -> Self {
        Self {
            asked: Arc::clone(stop),
            since: Cell::new(None),
            patience: Cell::new(Duration::ZERO),
            waits_end: Arc::default(),
        }
    }

    /// Whether the run was told to stop.
    fn is_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    /// Several times a second, in every wait. What tells a run to stop often ends its participants too.
    fn look(&self, participant_has_ended: bool) {
        if !self.is_asked() {
            return;
        }
        let since = self.since.get().unwrap_or_else(Instant::now);
        self.since.set(Some(since));
        if participant_has_ended || since.elapsed() >= self.patience.get() {
            self.waits_end.store(true, Ordering::Relaxed);
        }
    }
}

/// Threads of a solver for each core at most: more take time and memory, and win nothing.
const THREADS_PER_CORE: usize = 4;

/// Threads that a solver is given.
pub fn threads(case: &Case) -> usize {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    if case.general.threads == 0 { all } else { case.general.threads.min(THREADS_PER_CORE * all) }
}

/// The mapping of a structure that takes nothing but forces, at points of its own, where the case names none:
/// to points as far apart as the structure's particles. There may be few of its own, and no other is too far
/// from them.
fn mapping_of_forces(case: &Case, structure: &Description) -> Option<Mapping> {
    let takes =
        |name| structure.ports.iter().any(|port| port.name == name && port.direction == Direction::In);
    let section = case.structure.as_ref().filter(|section| !section.bodies.is_empty())?;
    let diagonals =
        section.bodies.iter().map(|body| body.bounds.extent().iter().map(|x| x * x).sum::<f64>().sqrt());
    let reach = diagonals.fold(0.0, f64::max);
    (takes(names::FORCE) && !takes(names::PRESSURE_GRADIENT)).then_some(Mapping {
        method: MappingMethod::RadialBasis,
        spacing: section.particle_spacing,
        reach,
        rebuild: false,
    })
}

/// How long a participant of this case waits for the coupler, which may be waiting for the other one to be
/// started by hand.
pub fn participant_deadlines(case: &Case) -> Deadlines {
    let by_hand = |role| case.start(role) == Some(Start::ByHand);
    deadlines(case, by_hand(Role::Structure) || by_hand(Role::Fluid))
}

fn deadlines(case: &Case, by_hand: bool) -> Deadlines {
    let usual = Deadlines::default();
    let answer = case.coupling.as_ref().map_or(usual.answer, |c| Duration::from_secs_f64(c.deadline));
    Deadlines { hello: if by_hand { BY_HAND } else { usual.hello }, answer }
}

fn failed(role: Role, during: &str, source: ParticipantError) -> SchemeError {
    SideError { role, during: during.to_owned(), source }.into()
}
