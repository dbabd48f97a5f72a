//! How much work contacts are, in tests: the work of many blocks is that of few, times their number.

use std::cell::Cell;

/// What has been done on this thread.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Effort {
    /// Segments onto which points were projected along cracks.
    pub segments: usize,
    /// Pairs of boxes that were compared.
    pub boxes: usize,
    /// Edges against which points were held where no crack is.
    pub edges: usize,
}

thread_local! {
    static SPENT: Cell<Effort> = const { Cell::new(Effort { segments: 0, boxes: 0, edges: 0 }) };
}

/// What has been done since it was asked last.
pub(crate) fn take() -> Effort {
    SPENT.take()
}

/// Adds to it.
pub(crate) fn spend(change: impl Fn(&mut Effort)) {
    let mut spent = SPENT.get();
    change(&mut spent);
    SPENT.set(spent);
}
