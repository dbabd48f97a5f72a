//! When a log holds a checkpoint, and whose states.

/// Lets checkpoints take a share of a log at most: twice the share where states of units grow with the run.
///
/// The state of the run and those of units that keep their size are written together, once the log since the last checkpoint is
/// so long that they take no more than the share. A state that grows, because it holds the unit's whole history, is written when
/// the log since it was written last is so long: at intervals that grow like it, so that the log grows linearly. Between them the
/// unit is brought on by what it was asked, which the log has anyway.
#[derive(Debug)]
pub struct Budget {
    share: f64,
    /// Bytes of the log so far and at the last checkpoint, and the bytes of its parts that keep their size.
    total: u64,
    before: u64,
    steady: u64,
    units: Vec<Option<OfUnit>>,
}

/// Sizes of the first and of the last state of a unit, bytes, and the bytes of the log then.
#[derive(Debug)]
struct OfUnit {
    first: u64,
    last: u64,
    at: u64,
}

/// A state that is so many times its first size grows.
const GROWN: u64 = 2;

impl OfUnit {
    fn grows(&self) -> bool {
        self.last >= GROWN * self.first
    }
}

impl Budget {
    /// For the states of `units`, and `share` of the log; 0 for no checkpoint.
    pub fn new(share: f64, units: usize) -> Self {
        let units = (0..units).map(|_| None).collect();
        Self { share, total: 0, before: 0, steady: 0, units }
    }

    /// Takes so many bytes of the log.
    pub fn add(&mut self, bytes: u64) {
        self.total += bytes;
    }

    /// The units whose states are to be written now; `None` if it is no time for a checkpoint.
    pub fn wishes(&self) -> Option<Vec<bool>> {
        let affords = |size: f64, since: u64| size <= self.share * (self.total - since) as f64;
        let wanted = |unit: &Option<OfUnit>| match unit {
            // It grows like the log.
            Some(unit) if unit.grows() => {
                affords(unit.last as f64 * self.total as f64 / unit.at.max(1) as f64, unit.at)
            }
            _ => true,
        };
        let due = self.share > 0.0 && affords(self.steady as f64, self.before);
        due.then(|| self.units.iter().map(wanted).collect())
    }

    /// Takes the sizes of a checkpoint that was written: of the run's state, and of those of the units.
    pub fn written(&mut self, run: u64, units: &[Option<u64>]) {
        (self.before, self.steady) = (self.total, run);
        for (unit, size) in self.units.iter_mut().zip(units) {
            if let Some(last) = *size {
                let first = unit.as_ref().map_or(last, |unit| unit.first);
                *unit = Some(OfUnit { first, last, at: self.total });
            }
            if !unit.as_ref().is_some_and(OfUnit::grows) {
                self.steady += size.unwrap_or(0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run of `steps` steps of 10 kB, one state of 40 kB and one that grows by 200 bytes a step: sizes of all states, and the
    /// longest time without a checkpoint.
    fn run(share: f64, steps: u64) -> (u64, u64) {
        let (mut budget, mut total, mut last, mut longest) = (Budget::new(share, 2), 0, 0, 0);
        for step in 1..=steps {
            budget.add(10_000);
            if let Some(wishes) = budget.wishes() {
                let sizes = [40_000, 200 * step];
                let sizes: Vec<_> =
                    sizes.iter().zip(wishes).map(|(size, wish)| wish.then_some(*size)).collect();
                budget.written(8_000, &sizes);
                total += 8_000 + sizes.iter().flatten().sum::<u64>();
                (longest, last) = (longest.max(step - last), step);
            }
        }
        (total, longest)
    }

    #[test]
    fn the_share_is_kept_however_long_the_run_and_checkpoints_stay_close() {
        for steps in [1_000, 10_000, 100_000] {
            let (total, longest) = run(0.05, steps);
            let share = total as f64 / (10_000 * steps) as f64;
            assert!((0.04..0.101).contains(&share), "{steps} steps: {share}");
            assert!(longest <= 150, "{steps} steps: {longest} without a checkpoint");
        }
        assert_eq!(run(0.0, 100), (0, 0));
    }
}
