//! Work on all cores.

use std::convert::Infallible;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::Builder;

/// The results of `work` on all `items`, in their order, on up to `threads` threads: on fewer, where the system makes no more.
/// The caller's is one of them.
///
/// **Errors**: the first one that `work` returns; no further item is begun.
pub fn try_map<A: Sync, B: Send, E: Send>(
    items: &[A],
    threads: NonZeroUsize,
    work: impl Fn(&A) -> Result<B, E> + Sync,
) -> Result<Vec<B>, E> {
    let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let worker = || {
        let mut done = Vec::new();
        while !failed.load(Ordering::Relaxed) {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(index) else { break };
            let result = work(item).inspect_err(|_| failed.store(true, Ordering::Relaxed));
            done.push((index, result));
        }
        done
    };
    let mut done = std::thread::scope(|scope| {
        let more = 1..threads.get().min(items.len());
        let others: Vec<_> = more.map_while(|_| Builder::new().spawn_scoped(scope, worker).ok()).collect();
        let mut done = worker();
        for other in others {
            done.extend(other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        done
    });
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}

/// The same for work that cannot fail.
pub fn map<A: Sync, B: Send>(items: &[A], threads: NonZeroUsize, work: impl Fn(&A) -> B + Sync) -> Vec<B> {
    match try_map(items, threads, |item| Ok::<_, Infallible>(work(item))) {
        Ok(results) => results,
        Err(never) => match never {},
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order_and_the_first_error_ends_the_work() {
        let items: Vec<usize> = (0..100).collect();
        for threads in [1, 3, 200].map(|n| NonZeroUsize::new(n).expect("not 0")) {
            assert_eq!(map(&items, threads, |i| 2 * i), (0..200).step_by(2).collect::<Vec<_>>());
            let begun = AtomicUsize::new(0);
            let failed = try_map(&items, threads, |&i| {
                begun.fetch_add(1, Ordering::Relaxed);
                if i == 0 { Err("no") } else { Ok(i) }
            });
            assert_eq!(failed, Err("no"));
            assert!(threads.get() > 1 || begun.into_inner() == 1);
        }
    }
}
