use super::{Entry, Log, LogReadError, LoggedStep};

/// The `count` communication steps of a log with the most iterations, the worst first; of equal ones that with the
/// larger residual, so that a run that is not iterated (explicit) has an order too, then the earliest.
///
/// Each attempt of a step counts by itself. A log that is cut off gives the steps that it holds.
///
/// **Errors**: the log can no longer be opened, or is damaged.
pub fn worst(log: &Log, count: usize) -> Result<Vec<LoggedStep>, LogReadError> {
    let mut worst: Vec<LoggedStep> = Vec::new();
    for entry in log.entries()? {
        let Entry::Step(step) = entry? else { continue };
        let place = worst.partition_point(|other| !is_worse(&step, other));
        if step.occasion.step > 0 && place < count {
            worst.insert(place, step);
            worst.truncate(count);
        }
    }
    Ok(worst)
}

/// More iterations, or as many and a larger residual.
fn is_worse(a: &LoggedStep, b: &LoggedStep) -> bool {
    let [of_a, of_b] = [a, b].map(|step| step.occasion.iteration);
    of_a > of_b || of_a == of_b && a.residual > b.residual
}
