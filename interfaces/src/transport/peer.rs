//! Whether the process on the other side lives.

use std::thread::sleep;
use std::time::{Duration, Instant};

/// Between two looks by what the link knows, which may cost half a millisecond each.
const BY_LINK: Duration = Duration::from_millis(100);
/// For the status of a process that has closed its files.
const STATUS: Duration = Duration::from_millis(200);

/// Says how a process that the caller started has ended (`exit status: 1`), or nothing while it lives.
pub type Alive = Box<dyn FnMut() -> Option<String>>;

/// The process on the other side of a connection.
#[derive(Default)]
pub(super) struct Peer {
    alive: Option<Alive>,
    end: Option<String>,
    /// When the link was asked last.
    asked: Option<Instant>,
}

impl Peer {
    /// Asks this of the process that was started, besides what the transport knows.
    pub(super) fn watch(&mut self, alive: Alive) {
        self.alive = Some(alive);
    }

    /// How the other side ended, if that was seen already.
    pub(super) fn end(&self) -> Option<&str> {
        self.end.as_deref()
    }

    /// Looks how the other side ended, which `of_link` says as far as the transport knows. Says whether it is
    /// seen now for the first time.
    pub(super) fn look(&mut self, of_link: impl FnOnce() -> Option<String>) -> bool {
        if self.end.is_some() {
            return false;
        }
        self.end = self.status().or_else(|| {
            // A process that was started is known by its status at once.
            if self.asked.is_some_and(|asked| asked.elapsed() < BY_LINK) {
                return None;
            }
            self.asked = Some(Instant::now());
            let how = of_link()?;
            // Its files are closed a moment before its status is there, which says more.
            let end = Instant::now() + STATUS;
            while self.alive.is_some() && Instant::now() < end {
                if let Some(status) = self.status() {
                    return Some(status);
                }
                sleep(Duration::from_millis(5));
            }
            Some(how)
        });
        self.end.is_some()
    }

    fn status(&mut self) -> Option<String> {
        self.alive.as_mut().and_then(|alive| alive())
    }
}
