//! Where the processes of a run are executed: on one core, while that is faster.
//!
//! In serial order only one of three processes works at a time. Where a window takes a fraction of a
//! millisecond, most of it is waking: a core that had nothing to do is asleep, and takes tens of microseconds
//! to come back, the more so on a virtual machine. A process that is woken on the core of the one that wakes
//! it finds that core awake. So the three are put on one core for a block of windows, and stay while blocks
//! there are faster than they were apart. What threads a participant has besides its first stay where they
//! are. No result depends on it.

use rustix::process::Pid;
use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};
use std::time::Instant;

/// Windows that are compared as one.
const BLOCK: usize = 64;
/// Windows that take longer in the median (s) do not gain enough to be tried.
const LIMIT: f64 = 2e-3;
/// A block together must take at most this share of one apart.
const GAIN: f64 = 0.9;
/// Before it is tried for the first time: the caches are cold in the first block.
const FIRST: Decision = Decision::Apart { blocks: 1, rest: SHORTEST_REST };
/// Blocks apart after it did not pay; twice as many each time that it does not. A system may have had them
/// together by itself, and then not.
const SHORTEST_REST: u32 = 4;
const LONGEST_REST: u32 = 256;

/// The processes of a run, apart or on one core.
pub struct Placement {
    cores: Cores,
    decision: Decision,
    last: Instant,
    block: Vec<f64>,
    windows_together: u64,
}

impl Placement {
    /// Of this process and the participants' processes, which begin apart; without any of those there is
    /// nothing to move.
    pub fn new(participants: &[Pid]) -> Self {
        Self {
            cores: Cores::of(participants),
            decision: FIRST,
            last: Instant::now(),
            block: Vec::with_capacity(BLOCK),
            windows_together: 0,
        }
    }

    /// A window has ended. Between blocks the processes may be moved.
    pub fn window(&mut self) {
        if self.cores.processes.is_empty() {
            return;
        }
        let now = Instant::now();
        self.block.push(now.duration_since(self.last).as_secs_f64());
        self.last = now;
        self.windows_together += u64::from(self.decision.is_together());
        if self.block.len() < BLOCK {
            return;
        }
        self.block.sort_unstable_by(f64::total_cmp);
        let median = self.block[BLOCK / 2];
        self.block.clear();
        let before = self.decision.is_together();
        self.decision = self.decision.after(median);
        match (before, self.decision.is_together()) {
            (false, true) if !self.cores.share() => {
                self.decision = Decision::Apart { blocks: LONGEST_REST, rest: LONGEST_REST };
            }
            (true, false) => self.cores.separate(),
            _ => {}
        }
    }

    /// Windows that were solved on one core.
    pub fn windows_together(&self) -> u64 {
        self.windows_together
    }
}

impl Drop for Placement {
    fn drop(&mut self) {
        if self.decision.is_together() {
            self.cores.separate();
        }
    }
}

/// Apart or together, and what the next block is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Decision {
    /// Apart, for so many blocks at least after this one; for `rest` blocks after the next trial that does
    /// not pay.
    Apart { blocks: u32, rest: u32 },
    /// Together, the median window of a block apart having taken so long (s).
    Together { apart: f64, rest: u32 },
}

impl Decision {
    fn is_together(self) -> bool {
        matches!(self, Self::Together { .. })
    }

    /// What follows a block whose median window took `seconds`.
    fn after(self, seconds: f64) -> Self {
        match self {
            Self::Apart { blocks: 0, rest } if seconds < LIMIT => Self::Together { apart: seconds, rest },
            Self::Apart { blocks, rest } => Self::Apart { blocks: blocks.saturating_sub(1), rest },
            Self::Together { apart, rest } if seconds > GAIN * apart => {
                Self::Apart { blocks: rest, rest: LONGEST_REST.min(2 * rest) }
            }
            Self::Together { apart, .. } => Self::Together { apart, rest: SHORTEST_REST },
        }
    }
}

/// The cores on which processes may be executed.
struct Cores {
    /// Each process, ours as none, with where its first thread was allowed to be; empty where they cannot
    /// share a core.
    processes: Vec<(Option<Pid>, CpuSet)>,
}

impl Cores {
    fn of(participants: &[Pid]) -> Self {
        if participants.is_empty() {
            return Self { processes: Vec::new() };
        }
        let ids = [None].into_iter().chain(participants.iter().copied().map(Some));
        let allowed: Option<Vec<_>> = ids.map(|id| Some((id, allowed(id)?))).collect();
        Self { processes: allowed.unwrap_or_default() }
    }

    /// Puts the first thread of each on the core where we are; moves none, and says so, if one of them may
    /// not be there.
    fn share(&self) -> bool {
        let core = sched_getcpu();
        let all_may = self.processes.iter().all(|(_, allowed)| allowed.is_set(core));
        if all_may {
            let mut one = CpuSet::new();
            one.set(core);
            self.processes.iter().for_each(|(id, _)| allow(*id, &one));
        }
        all_may
    }

    /// Lets each be where it was allowed to be, with the threads that it made in the meantime.
    fn separate(&self) {
        for (id, before) in &self.processes {
            for thread in threads(*id) {
                let alone = allowed(Some(thread)).is_some_and(|now| now.count() == 1);
                if alone {
                    allow(Some(thread), before);
                }
            }
        }
    }
}

/// The threads of a process, or of this one. One that has ended has none.
fn threads(id: Option<Pid>) -> Vec<Pid> {
    let folder = id.map_or("/proc/self/task".to_owned(), |id| format!("/proc/{}/task", id.as_raw_nonzero()));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| Pid::from_raw(entry.file_name().to_str()?.parse().ok()?)).collect()
}

/// Where that thread may be, or this one.
fn allowed(thread: Option<Pid>) -> Option<CpuSet> {
    sched_getaffinity(thread).ok()
}

/// Lets that thread, or this one, be there only. Of a process that has ended the coupling hears elsewhere.
fn allow(thread: Option<Pid>, cores: &CpuSet) {
    let _ = sched_setaffinity(thread, cores);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The decisions after blocks of these medians (µs).
    fn together(medians: impl IntoIterator<Item = f64>) -> Vec<bool> {
        let mut decision = FIRST;
        let decisions = medians.into_iter().map(|median| {
            decision = decision.after(1e-6 * median);
            decision.is_together()
        });
        decisions.collect()
    }

    #[test]
    fn one_core_is_kept_while_it_pays() {
        // Cold; apart; together it is faster, and stays so.
        assert_eq!(together([300.0, 80.0, 30.0, 31.0, 70.0]), [false, true, true, true, true]);
        // Together it is no faster.
        assert_eq!(together([300.0, 80.0, 79.0]), [false, true, false]);
        // Somebody else comes to work on that core.
        assert_eq!(together([300.0, 80.0, 30.0, 400.0]), [false, true, true, false]);
    }

    #[test]
    fn long_windows_are_never_tried() {
        assert!(!together([2500.0; 200]).contains(&true));
    }

    #[test]
    fn it_is_tried_again_after_longer_and_longer_rests() {
        let decisions = together(std::iter::repeat_n(80.0, 2000));
        let tries: Vec<usize> = (0..2000).filter(|&i| decisions[i]).collect();
        let rests: Vec<usize> = tries.windows(2).map(|two| two[1] - two[0] - 2).collect();
        assert_eq!(rests[..8], [4, 8, 16, 32, 64, 128, 256, 256]);
        // Once it has paid, soon again.
        let mut decision = Decision::Apart { blocks: 0, rest: LONGEST_REST };
        for median in [80.0, 30.0, 90.0] {
            decision = decision.after(1e-6 * median);
        }
        assert_eq!(decision, Decision::Apart { blocks: SHORTEST_REST, rest: 2 * SHORTEST_REST });
    }

    #[test]
    fn processes_go_to_one_core_and_back() {
        let mut child = std::process::Command::new("sleep").arg("60").spawn().unwrap();
        let id = Pid::from_child(&child);
        let cores = Cores::of(&[id]);
        let before = [allowed(None).unwrap(), allowed(Some(id)).unwrap()];
        assert!(cores.share());
        let during = [allowed(None).unwrap(), allowed(Some(id)).unwrap()];
        assert!(during.iter().all(|set| set.count() == 1) && during[0] == during[1]);
        cores.separate();
        assert!([allowed(None).unwrap(), allowed(Some(id)).unwrap()] == before);
        child.kill().unwrap();
        child.wait().unwrap();
    }
}
