//! Sums over all pairs, which take long, shared by all cores.

use std::{panic, thread};

/// Results of `each` for 0 to n, in order, computed on all cores.
pub(crate) fn map<T: Send>(n: usize, each: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let share = n.div_ceil(thread::available_parallelism().map_or(1, usize::from)).max(1);
    let part = |first: usize| (first..n.min(first + share)).map(&each).collect::<Vec<T>>();
    let part = &part;
    thread::scope(|scope| {
        let parts: Vec<_> = (0..n).step_by(share).map(|first| scope.spawn(move || part(first))).collect();
        parts.into_iter().flat_map(|part| part.join().unwrap_or_else(|cause| panic::resume_unwind(cause))).collect()
    })
}
