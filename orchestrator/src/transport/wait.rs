use std::time::{Duration, Instant};

/// Until then a waiting process spins: an idle unit answers within. Longer, and two processes that the system has
/// put on one core cost each other their spinning (45 µs an exchange with 20 µs, 11 µs with 3).
const SPIN: Duration = Duration::from_micros(3);
/// Until then it lets others run and looks again at once.
const YIELD: Duration = Duration::from_micros(100);
/// Then it sleeps at least this long between two looks: pure spinning or yielding collapses when there are more
/// processes than cores.
const SHORTEST_NAP: Duration = Duration::from_micros(20);
/// The longer it has waited the longer it sleeps, which delays an answer by no more than this share.
const NAP_SHARE: u32 = 50;
const LONGEST_NAP: Duration = Duration::from_millis(1);

/// Waiting for the other side: spin, then yield, then nap.
pub(super) struct Wait {
    began: Instant,
}

impl Wait {
    pub fn begin() -> Self {
        Self { began: Instant::now() }
    }

    /// Pauses between two looks; returns how long the wait has lasted.
    pub fn pause(&self) -> Duration {
        let waited = self.began.elapsed();
        if waited < SPIN {
            std::hint::spin_loop();
        } else if waited < YIELD {
            std::thread::yield_now();
        } else {
            std::thread::sleep((waited / NAP_SHARE).clamp(SHORTEST_NAP, LONGEST_NAP));
        }
        waited
    }
}

/// Makes naps of the calling thread as short as asked for: by default Linux adds some 50 µs to each.
pub fn shorten_naps() {
    // A nap that lasts longer is no more than slow.
    let _ = rustix::thread::set_current_timer_slack(Some(std::num::NonZeroU64::MIN));
}
