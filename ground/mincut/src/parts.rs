//! Work in parts, one a thread.

use std::ops::Range;

/// What `job` makes of each part, in order: the first on this thread, each other one on its own.
///
/// # Panics
/// As `job` does.
pub(crate) fn each<I: Send, R: Send>(parts: Vec<I>, job: impl Fn(I) -> R + Sync) -> Vec<R> {
    let mut parts = parts.into_iter();
    let Some(first) = parts.next() else { return Vec::new() };
    std::thread::scope(|scope| {
        let job = &job;
        let others: Vec<_> = parts.map(|part| scope.spawn(move || job(part))).collect();
        let first = job(first);
        let join = |thread: std::thread::ScopedJoinHandle<'_, R>| match thread.join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        std::iter::once(first).chain(others.into_iter().map(join)).collect()
    })
}

/// `rows` in about `count` ranges, each but the last a multiple of `step` long.
pub(crate) fn ranges(rows: usize, count: usize, step: usize) -> Vec<Range<usize>> {
    let length = rows.div_ceil(count.max(1)).next_multiple_of(step).max(step);
    (0..rows).step_by(length).map(|start| start..(start + length).min(rows)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_cover_all_rows_once() {
        for (rows, count, step) in
            [(0, 2, 4), (1, 3, 4), (9, 2, 4), (64, 3, 1), (7, 100, 1), (5, 0, 1)]
        {
            let ranges = ranges(rows, count, step);
            assert!(ranges.iter().flat_map(Clone::clone).eq(0..rows), "{rows} {count} {step}");
        }
        assert_eq!(each(vec![1, 2, 3], |n| 2 * n), [2, 4, 6]);
    }
}
