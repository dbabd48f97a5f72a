use std::time::{Duration, Instant};

/// Until then a waiting process spins: an idle unit answers within. Longer, and two processes that the system has
/// put on one core cost each other their spinning (45 µs an exchange with 20 µs, 17 with 6).
const SPIN: Duration = Duration::from_micros(6);
/// Until then it lets others run and looks again at once.
const YIELD: Duration = Duration::from_micros(100);
/// Then it sleeps at least this long between two looks: pure spinning or yielding collapses when there are more
/// processes than cores.
const SHORTEST_NAP: Duration = Duration::from_micros(20);
/// The longer it has waited the longer it sleeps, which delays an answer by no more than this share.
const NAP_SHARE: u32 = 50;
const LONGEST_NAP: Duration = Duration::from_millis(1);
/// This long before and after the end of the last wait it looks at once again: solves take nearly the same time,
/// and a nap on an idle core lasts 40 µs longer than asked for.
const AROUND: Duration = Duration::from_micros(150);

/// Waiting for the other side, again and again: spin, then yield, then nap until the other side is expected.
pub(super) struct Wait {
    began: Instant,
    /// How long the last wait lasted.
    last: Duration,
}

impl Wait {
    pub fn new() -> Self {
        Self { began: Instant::now(), last: Duration::ZERO }
    }

    /// Begins to wait.
    pub fn begin(&mut self) {
        self.began = Instant::now();
    }

    /// Ends a wait.
    pub fn end(&mut self) {
        self.last = self.began.elapsed();
    }

    /// Pauses between two looks; returns how long the wait has lasted.
    pub fn pause(&self) -> Duration {
        let waited = self.began.elapsed();
        let soon = self.last.saturating_sub(AROUND);
        if waited < SPIN {
            std::hint::spin_loop();
        } else if waited < YIELD || (soon..self.last + AROUND).contains(&waited) {
            std::thread::yield_now();
        } else {
            let nap = (waited / NAP_SHARE).clamp(SHORTEST_NAP, LONGEST_NAP);
            std::thread::sleep(if waited < soon { nap.min(soon - waited) } else { nap });
        }
        waited
    }
}

/// Makes naps of the calling thread as short as asked for: by default Linux adds some 50 µs to each.
pub fn shorten_naps() {
    // A nap that lasts longer is no more than slow.
    let _ = rustix::thread::set_current_timer_slack(Some(std::num::NonZeroU64::MIN));
}
