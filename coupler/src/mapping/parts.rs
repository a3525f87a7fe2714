//! Parts of the targets at the same time.
//!
//! What a target's row is does not depend on the part that it is in, so that results are the same for any
//! number of threads.

use super::error::MappingError;
use super::rows::Rows;
use std::ops::Range;
use std::thread::scope;

/// Fewest targets for which a thread is started: some tens of microseconds' worth of them.
const FEWEST: usize = 1000;

/// How many parts of `targets` points are worth so many threads.
pub(super) fn count(targets: usize, threads: usize) -> usize {
    threads.min(targets / FEWEST).max(1)
}

/// One of `count` consecutive parts of `0..targets`.
pub(super) fn part(targets: usize, count: usize, k: usize) -> Range<usize> {
    targets * k / count..targets * (k + 1) / count
}

/// Does `work` for all `tasks` at the same time, the first by this thread. The error is that of the first
/// task that has one.
pub(super) fn work_off<T: Send>(
    tasks: impl IntoIterator<Item = T>,
    work: impl Fn(T) -> Result<(), MappingError> + Sync,
) -> Result<(), MappingError> {
    let mut tasks = tasks.into_iter();
    let Some(first) = tasks.next() else { return Ok(()) };
    let work = &work;
    scope(|scope| {
        let started: Vec<_> = tasks.map(|task| scope.spawn(move || work(task))).collect();
        let mut result = work(first);
        for thread in started {
            let found = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            result = result.and(found);
        }
        result
    })
}

/// Scratch memory of each part, and the rows of all but the first before they are put behind those of the
/// part before.
#[derive(Clone, Debug, Default)]
pub(super) struct Parts<T> {
    first: T,
    others: Vec<(T, Rows)>,
}

impl<T: Default + Send> Parts<T> {
    /// Calls `fill(targets, scratch, rows)` for parts of `0..targets`, at most `threads` at a time, and puts
    /// the rows of all in order. The error is that of the first part that has one.
    pub fn gather(
        &mut self,
        targets: usize,
        threads: usize,
        rows: &mut Rows,
        fill: impl Fn(Range<usize>, &mut T, &mut Rows) -> Result<(), MappingError> + Sync,
    ) -> Result<(), MappingError> {
        let count = count(targets, threads);
        self.others.resize_with(count - 1, Default::default);
        let Self { first, others } = self;
        let others = others.iter_mut().map(|(scratch, rows)| {
            rows.clear();
            (scratch, rows)
        });
        let tasks = std::iter::once((first, &mut *rows)).chain(others).enumerate();
        work_off(tasks, |(k, (scratch, rows))| fill(part(targets, count, k), scratch, rows))?;
        for (_, other) in &self.others {
            rows.append(other);
        }
        Ok(())
    }
}
