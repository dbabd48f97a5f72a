/// The value at `time` (s) of `samples`, `interval` (s) apart: linear between them; afterwards the last one if `held`,
/// otherwise zero, reached within one interval. Zero without samples.
pub fn sampled(samples: &[f64], interval: f64, held: bool, time: f64) -> f64 {
    let Some((&end, _)) = samples.split_last() else { return 0.0 };
    let after = if held { end } else { 0.0 };
    let position = (time / interval).max(0.0);
    if position >= samples.len() as f64 {
        return after;
    }
    let index = position.floor() as usize;
    let a = samples[index];
    let b = samples.get(index + 1).copied().unwrap_or(after);
    a + (position - index as f64) * (b - a)
}
