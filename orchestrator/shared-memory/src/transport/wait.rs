use std::time::{Duration, Instant};

/// Waiting time up to which a process yields to others between two checks. It never spins: of three processes on two cores, two
/// share one, and each waits out the spin of the other.
const YIELD: Duration = Duration::from_micros(100);
/// Shortest sleep between two checks after that: pure spinning or yielding fails when there are more processes than
/// cores.
const SHORTEST_NAP: Duration = Duration::from_micros(20);
/// A sleep lasts the time waited so far divided by this number, which bounds the relative delay of an answer.
const NAP_SHARE: u32 = 50;
const LONGEST_NAP: Duration = Duration::from_millis(1);
/// Time before and after the length of the last wait in which it does not sleep: solves take nearly the same time,
/// and a sleep on an idle core lasts 40 µs longer than asked for.
const AROUND: Duration = Duration::from_micros(150);
/// A yield that takes longer has given the core to a program that computes for its whole slice, some milliseconds. Who sleeps is let in
/// before such a program, who yields is not. A yield to another unit is mostly shorter.
const CROWDED: Duration = Duration::from_millis(1);
/// Time after such a yield in which naps take its place: long beside the yield, so that little is lost, and short, so that a
/// single long yield, as while a unit begins, does no harm.
const SHY: Duration = Duration::from_millis(50);

/// Waits for the other process: yields, then sleeps until the answer is expected; sleeps at once where other programs keep the
/// cores busy.
pub(super) struct Wait {
    began: Instant,
    /// Length of the last wait.
    last: Duration,
    /// Until when it does not yield.
    shy_until: Option<Instant>,
}

impl Wait {
    pub fn new() -> Self {
        Self { began: Instant::now(), last: Duration::ZERO, shy_until: None }
    }

    /// Begins to wait.
    pub fn begin(&mut self) {
        self.began = Instant::now();
    }

    /// Ends a wait.
    pub fn end(&mut self) {
        self.last = self.began.elapsed();
    }

    /// Pauses between two checks; returns the time waited so far.
    pub fn pause(&mut self) -> Duration {
        let waited = self.began.elapsed();
        let soon = self.last.saturating_sub(AROUND);
        if waited < YIELD || (soon..self.last + AROUND).contains(&waited) {
            self.give_way(self.began + waited);
        } else {
            let nap = (waited / NAP_SHARE).clamp(SHORTEST_NAP, LONGEST_NAP);
            std::thread::sleep(if waited < soon { nap.min(soon - waited) } else { nap });
        }
        waited
    }

    /// Lets others run for a moment, from `now` on.
    fn give_way(&mut self, now: Instant) {
        if self.shy_until.is_some_and(|end| now < end) {
            return std::thread::sleep(SHORTEST_NAP);
        }
        std::thread::yield_now();
        self.shy_until = (now.elapsed() > CROWDED).then(|| now + SHY);
    }
}

/// Makes sleeps of the calling thread precise: by default Linux adds some 50 µs to each.
pub fn shorten_naps() {
    // If this fails, sleeps are only longer.
    let _ = rustix::thread::set_current_timer_slack(Some(std::num::NonZeroU64::MIN));
}
