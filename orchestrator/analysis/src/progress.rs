//! Progress of many runs.

use crate::context::Context;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Reports how far the runs are, every few seconds.
pub struct Watch<'a> {
    context: &'a Context<'a>,
    began: Instant,
    wanted: usize,
    done: Mutex<Done>,
}

#[derive(Default)]
struct Done {
    runs: usize,
    failed: usize,
    told: Duration,
}

/// Time between two lines.
const BETWEEN: Duration = Duration::from_secs(5);

impl<'a> Watch<'a> {
    /// For this number of runs.
    pub fn new(wanted: usize, context: &'a Context<'a>) -> Self {
        Self { context, began: Instant::now(), wanted, done: Mutex::default() }
    }

    /// Counts a run, `complete` or failed.
    pub fn tell(&self, complete: bool) {
        let Ok(mut done) = self.done.lock() else { return };
        done.runs += 1;
        done.failed += usize::from(!complete);
        let elapsed = self.began.elapsed();
        if elapsed >= done.told + BETWEEN {
            done.told = elapsed;
            let left = elapsed.as_secs_f64() * (self.wanted - done.runs) as f64 / done.runs as f64;
            let (runs, failed) = (done.runs, done.failed);
            self.context.line(format!("{runs} of {}, {failed} failed, {left:.0} s left", self.wanted));
        }
    }

    /// Reports the whole time.
    pub fn end(&self) {
        let elapsed = self.began.elapsed().as_secs_f64();
        if self.wanted > 0 {
            self.context.line(format!("{} runs in {elapsed:.1} s", self.wanted));
        }
    }
}
