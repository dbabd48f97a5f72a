use crate::observer::{Ending, Observer, ObserverError, Start, Status};
use crate::scheme::WindowReport;

/// Ends a run at a time of the user's.
pub struct Until {
    time: Option<f64>,
    reached: f64,
}

impl Until {
    /// Ends it at the first end of a step at `time` (s) or later; never without.
    pub fn new(time: Option<f64>) -> Self {
        Self { time, reached: 0.0 }
    }
}

/// Share of a second by which sums of steps may be rounded.
const ROUNDING: f64 = 1e-9;

impl Observer for Until {
    fn begin(&mut self, _: &Start<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        if report.is_accepted() {
            self.reached = report.end();
        }
        Ok(())
    }

    fn end(&mut self, _: &Ending) -> Result<(), ObserverError> {
        Ok(())
    }

    fn ends(&self) -> Option<Status> {
        let time = self.time.filter(|time| self.reached >= time - ROUNDING)?;
        Some(Status::Stopped(format!("at t = {:.4} s, as --until {time} asks", self.reached)))
    }
}
