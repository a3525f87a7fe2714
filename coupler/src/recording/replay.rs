//! A recorded side, played back in its place.

use super::departure::{Departures, Place};
use super::entry::{Decoder, Event, Outcome, is_kept};
use super::file::{Block, Error, Header, Reading};
use interfaces::{
    Description, Fields, Participant, ParticipantError, Readiness, Result, Role, TimeWindow, WindowReport,
};
use std::path::Path;
use std::time::Instant;
use words::text::{EXPLANATION, tame};

/// What a replay does where its inputs depart from those recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnDeparture {
    /// It fails and says where: what it would answer is no answer to these inputs.
    End,
    /// It says so once, answers as recorded, and tells the largest departure of each field at the end.
    Continue,
}

/// A participant that gives what was recorded of one side, and compares what it takes with what that side
/// took, bit by bit.
///
/// A window that is solved more often than recorded is answered by its last solution again, one that is
/// solved less often is left where it is accepted; both are departures. It cannot be saved.
pub struct Replay {
    source: Source,
    role: Role,
    description: Description,
    on_departure: OnDeparture,
    tell: Box<dyn FnMut(&str)>,
    departures: Departures,
    /// The last solution of the window that was solved last, by its number.
    solution: Option<(u64, Solution)>,
    /// The window that was started, when, and whether its solution is given again.
    begun: Option<(TimeWindow, Instant, bool)>,
    told: bool,
}

/// What a side gave for a window.
type Solution = (Vec<Vec<f64>>, WindowReport);

impl Replay {
    /// Opens a recording to stand in for the side `role` of it. `tell` hears what a user should read: the
    /// first departure, and what became of all at the end.
    ///
    /// # Errors
    /// A file that cannot be read, or in which this side was not recorded.
    pub fn open(
        path: &Path,
        role: Role,
        on_departure: OnDeparture,
        tell: impl FnMut(&str) + 'static,
    ) -> Result<Self, Error> {
        let mut source = Source::open(path)?;
        let Some(Event::Described(description)) = source.next_of(role)? else {
            let end = &source.end;
            let what =
                format!("no {role} was recorded in it: {end}; name the other side, or record the run again");
            return Err(Error { doing: "read", path: path.to_owned(), what });
        };
        let version = &source.reading.header.version;
        let note = format!("it is replayed from {}, recorded by meniscus {version}", path.display());
        let description = Description { saves: false, notes: vec![tame(&note, NOTE)], ..*description };
        Ok(Self {
            source,
            role,
            description,
            on_departure,
            tell: Box::new(tell),
            departures: Departures::default(),
            solution: None,
            begun: None,
            told: false,
        })
    }

    /// What the file says of its run.
    pub fn header(&self) -> &Header {
        &self.source.reading.header
    }

    /// Adds a note for the summary.
    pub fn note(&mut self, note: &str) {
        self.description.notes.push(tame(note, NOTE));
    }

    /// The next event of this side.
    fn next(&mut self) -> Result<Option<Event>> {
        self.source.next_of(self.role).map_err(|error| ParticipantError::failed(error.to_string()))
    }

    /// The error where the recording has no such call.
    fn ends(&mut self, wanted: &str, found: Option<&Event>) -> ParticipantError {
        let path = self.source.reading.path().display();
        ParticipantError::failed(match found {
            Some(event) => {
                format!("the recording {path} has {} where the run goes on {wanted}", named(event))
            }
            None => {
                format!("the recording {path} ends where the run goes on {wanted}: {}", self.source.end)
            }
        })
    }

    fn compare(&mut self, place: Place, recorded: &[Vec<f64>], now: &Fields) -> Result<()> {
        let found = self.departures.compare(place, recorded, now).map_err(ParticipantError::Failed)?;
        match found {
            Some((first, 1)) => self.depart(&first.to_string()),
            Some((first, count)) => {
                self.depart(&format!("{first}; {count} values of its inputs depart there"))
            }
            None => Ok(()),
        }
    }

    /// Times or calls that are other.
    fn depart_otherwise(&mut self, what: &str) -> Result<()> {
        self.departures.otherwise.get_or_insert_with(|| what.to_owned());
        self.depart(what)
    }

    fn depart(&mut self, what: &str) -> Result<()> {
        let path = self.source.reading.path().display();
        let what =
            format!("the {} is replayed from {path}, and the run departs from it first {what}", self.role);
        match self.on_departure {
            OnDeparture::End => Err(ParticipantError::failed(format!(
                "{what}; go on all the same with --on-departure continue"
            ))),
            OnDeparture::Continue => {
                if !std::mem::replace(&mut self.told, true) {
                    (self.tell)(&what);
                }
                Ok(())
            }
        }
    }

    fn compare_windows(&mut self, recorded: &TimeWindow, now: &TimeWindow) -> Result<()> {
        let bits = |window: &TimeWindow| (window.start.to_bits(), window.size.to_bits());
        let place = Place::Solution(*now);
        if bits(recorded) != bits(now) {
            self.depart_otherwise(&format!(
                "{place}: it lasts {:e} s, and one from t = {:e} s that lasts {:e} s was recorded",
                now.size, recorded.start, recorded.size
            ))?;
        }
        if (recorded.iteration, recorded.sub_steps) != (now.iteration, now.sub_steps) {
            self.depart_otherwise(&format!(
                "{place}: it is iteration {} with sub-steps {:?}, and iteration {} with {:?} was recorded",
                now.iteration, now.sub_steps, recorded.iteration, recorded.sub_steps
            ))?;
        }
        Ok(())
    }
}

/// Characters of a note.
const NOTE: usize = EXPLANATION / 4;

impl Participant for Replay {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn initialize(&mut self, start: f64, inputs: &Fields, outputs: &mut Fields) -> Result<Readiness> {
        let (was, recorded, given) = match self.next()? {
            Some(Event::Initialized { start, inputs, given }) => (start, inputs, given),
            found => return Err(self.ends("to initialise", found.as_ref())),
        };
        if was.to_bits() != start.to_bits() {
            self.depart_otherwise(&format!("at initialisation: at t = {start} s, and {was} s was recorded"))?;
        }
        self.compare(Place::Initialisation, &recorded, inputs)?;
        let (arrays, ready) = answer(given)?;
        write(&arrays, outputs, true)?;
        Ok(ready)
    }

    fn start(&mut self, window: &TimeWindow, inputs: &Fields) -> Result<()> {
        let began = Instant::now();
        let wanted = || format!("for {}", Place::Solution(*window));
        let again = match self.next()? {
            Some(Event::Started { window: recorded, inputs: was, given })
                if recorded.index == window.index =>
            {
                self.compare_windows(&recorded, window)?;
                self.compare(Place::Solution(*window), &was, inputs)?;
                answer(given)?;
                false
            }
            Some(accepted @ Event::Accepted { .. })
                if self.solution.as_ref().is_some_and(|(of, _)| *of == window.index) =>
            {
                self.source.put_back(accepted);
                let place = Place::Solution(*window);
                self.depart_otherwise(&format!("{place}: the recording has fewer solutions of this window"))?;
                true
            }
            found => return Err(self.ends(&wanted(), found.as_ref())),
        };
        self.begun = Some((*window, began, again));
        Ok(())
    }

    fn finish(&mut self, outputs: &mut Fields) -> Result<WindowReport> {
        let Some((window, began, again)) = self.begun.take() else {
            return Err(ParticipantError::failed("no window was started"));
        };
        if !again {
            self.solution = match self.next()? {
                Some(Event::Finished(given)) => Some((window.index, answer(given)?)),
                found => {
                    let wanted = format!("for the solution {}", Place::Solution(window));
                    return Err(self.ends(&wanted, found.as_ref()));
                }
            };
        }
        let Some((_, (arrays, report))) = &self.solution else {
            return Err(ParticipantError::failed("no window was solved"));
        };
        write(arrays, outputs, false)?;
        // Its own work is what a participant reports, and the one that was recorded does none now.
        Ok(WindowReport { compute_seconds: began.elapsed().as_secs_f64(), ..report.clone() })
    }

    fn accept(&mut self, _snapshot: Option<u64>) -> Result<()> {
        loop {
            match self.next()? {
                Some(Event::Accepted { given, .. }) => return answer(given),
                Some(Event::Started { window, .. })
                    if self.solution.as_ref().is_some_and(|(of, _)| *of == window.index) =>
                {
                    let place = Place::Solution(window);
                    self.depart_otherwise(&format!("{place}: it was recorded and is not asked for"))?;
                }
                // That of the solution which is not asked for.
                Some(Event::Finished(_)) if self.departures.otherwise.is_some() => {}
                found => return Err(self.ends("to accept its solution", found.as_ref())),
            }
        }
    }

    fn save(&mut self) -> Result<Vec<u8>> {
        Err(ParticipantError::failed("a replay cannot be saved"))
    }

    fn restore(&mut self, _state: &[u8], _outputs: &mut Fields) -> Result<Readiness> {
        Err(ParticipantError::failed("a replay cannot go to a saved state; start the run from its beginning"))
    }

    fn terminate(&mut self) -> Result<()> {
        for line in self.departures.summary() {
            (self.tell)(&line);
        }
        Ok(())
    }
}

/// What was given, or the failure that was recorded.
fn answer<T>(given: Outcome<T>) -> Result<T> {
    given.map_err(|error| ParticipantError::failed(format!("it failed so when it was recorded: {error}")))
}

/// Writes recorded arrays to fields given.
fn write(arrays: &[Vec<f64>], outputs: &mut Fields, initial: bool) -> Result<()> {
    let kept = outputs.iter_mut().filter(|(port, _)| is_kept(port, initial));
    for ((port, place), array) in kept.zip(arrays) {
        if place.len() != array.len() {
            return Err(interfaces::fields::wrong_length(port, array.len()).into());
        }
        place.copy_from_slice(array);
    }
    Ok(())
}

fn named(event: &Event) -> &'static str {
    match event {
        Event::Described(_) => "a description",
        Event::Initialized { .. } => "an initialisation",
        Event::Started { .. } => "the start of another window",
        Event::Finished(_) => "a solution",
        Event::Accepted { .. } => "the acceptance of a window",
        Event::Terminated(_) => "the run's end",
    }
}

/// The entries of a file, in their order.
struct Source {
    reading: Reading,
    decoder: Decoder,
    block: Vec<u8>,
    at: usize,
    ahead: Option<Event>,
    /// Why there are no more, once that is so.
    end: String,
}

impl Source {
    fn open(path: &Path) -> Result<Self, Error> {
        let reading = Reading::open(path)?;
        let (block, decoder) = (Vec::new(), Decoder::default());
        Ok(Self { reading, decoder, block, at: 0, ahead: None, end: String::new() })
    }

    /// The next event of that side; the other's are passed over.
    fn next_of(&mut self, role: Role) -> Result<Option<Event>, Error> {
        if let Some(event) = self.ahead.take() {
            return Ok(Some(event));
        }
        loop {
            while self.at < self.block.len() {
                let rest = &self.block[self.at..];
                let framed = rest.split_first_chunk::<4>().and_then(|(length, rest)| {
                    let length = u32::from_le_bytes(*length) as usize;
                    Some((4 + length, rest.get(..length)?))
                });
                let Some((taken, entry)) = framed else {
                    return Err(self.reading.damaged("an entry goes on after its block"));
                };
                self.at += taken;
                let read = self.decoder.entry(entry);
                let entry = read.map_err(|error| self.reading.damaged(&error.to_string()))?;
                if entry.role == role {
                    return Ok(Some(entry.event));
                }
            }
            match self.reading.next_block()? {
                Block::Entries(entries) => (self.block, self.at) = (entries, 0),
                Block::End(end) => {
                    let early = end.early.map(|why| format!("the recording ended early: {why}"));
                    self.end = early.unwrap_or_else(|| "the run that was recorded ended there".to_owned());
                    return Ok(None);
                }
                Block::Cut(at) => {
                    self.end =
                        format!("the run that was recorded was cut off there, at byte {at} of its file");
                    return Ok(None);
                }
            }
        }
    }

    /// Gives this event next.
    fn put_back(&mut self, event: Event) {
        self.ahead = Some(event);
    }
}
