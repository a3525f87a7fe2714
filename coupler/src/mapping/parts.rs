//! Rows of consecutive parts of the targets, gathered at the same time.
//!
//! What a target's row is does not depend on the part that it is in, so that results are the same for any number of threads.

use super::error::MappingError;
use super::rows::Rows;
use std::ops::Range;
use std::thread::{Scope, ScopedJoinHandle, scope};

/// Fewest targets for which a thread is started: some tens of microseconds' worth of them.
const FEWEST: usize = 1000;

/// Scratch memory of each part, and its rows before they are put behind those of the part before.
#[derive(Clone, Debug, Default)]
pub(super) struct Parts<T> {
    first: T,
    others: Vec<(T, Rows)>,
}

impl<T: Default + Send> Parts<T> {
    /// Calls `fill(targets, scratch, rows)` for parts of `0..targets`, at most `threads` at a time, and puts the rows of all in order. The error is that of
    /// the first part that has one.
    pub fn gather(
        &mut self,
        targets: usize,
        threads: usize,
        rows: &mut Rows,
        fill: impl Fn(Range<usize>, &mut T, &mut Rows) -> Result<(), MappingError> + Sync,
    ) -> Result<(), MappingError> {
        let count = threads.min(targets / FEWEST).max(1);
        let part = |k: usize| targets * k / count..targets * (k + 1) / count;
        self.others.resize_with(count - 1, Default::default);
        let Self { first, others } = self;
        let fill = &fill;
        scope(|scope| {
            let started: Vec<_> = others
                .iter_mut()
                .enumerate()
                .map(|(k, other)| start(scope, part(k + 1), other, fill))
                .collect();
            let mut result = fill(part(0), first, rows);
            for thread in started {
                let found = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
                result = result.and(found);
            }
            result
        })?;
        for (_, other) in others {
            rows.append(other);
        }
        Ok(())
    }
}

fn start<'scope, T: Send>(
    scope: &'scope Scope<'scope, '_>,
    part: Range<usize>,
    (scratch, rows): &'scope mut (T, Rows),
    fill: &'scope (impl Fn(Range<usize>, &mut T, &mut Rows) -> Result<(), MappingError> + Sync),
) -> ScopedJoinHandle<'scope, Result<(), MappingError>> {
    scope.spawn(move || {
        rows.clear();
        fill(part, scratch, rows)
    })
}
