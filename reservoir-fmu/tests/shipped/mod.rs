//! The shipped records, and their velocities.

/// Times (s) and accelerations (m/s²) of a shipped record.
pub fn read(name: &str) -> Vec<(f64, f64)> {
    let path = format!("{}/../scenes/records/{name}.csv", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let sample = |line: &str| {
        let (time, value) = line.split_once(',')?;
        Some((time.trim().parse().ok()?, 9.81 * value.trim().parse::<f64>().ok()?))
    };
    text.lines().filter_map(sample).collect()
}

/// Acceleration at the ends of `count` − 1 steps of `h` (s), linear between the samples; 0 after them.
pub fn accelerations(record: &[(f64, f64)], h: f64, count: usize) -> Vec<f64> {
    let mut k = 0;
    (0..count)
        .map(|n| {
            let t = n as f64 * h;
            while k + 1 < record.len() && record[k + 1].0 <= t + 1e-9 {
                k += 1;
            }
            let (start, a) = record[k];
            match record.get(k + 1) {
                Some(&(end, b)) => a + (b - a) * (t - start) / (end - start),
                None if t > start + 1e-9 => 0.0,
                None => a,
            }
        })
        .collect()
}

/// Velocity at the steps' ends.
pub fn velocities(record: &[(f64, f64)], h: f64, count: usize) -> Vec<f64> {
    let (mut velocity, mut v, mut k) = (Vec::with_capacity(count), 0.0, 0);
    let at = |t: f64, k: usize| {
        let [(t0, a0), (t1, a1)] = [record[k], record[(k + 1).min(record.len() - 1)]];
        if t1 > t0 { a0 + (a1 - a0) * (t - t0) / (t1 - t0) } else { a0 }
    };
    for n in 0..count {
        velocity.push(v);
        let (start, end) = (n as f64 * h, (n + 1) as f64 * h);
        while k + 1 < record.len() && record[k + 1].0 <= start + 1e-9 {
            k += 1;
        }
        v += 0.5 * h * (at(start, k) + at(end, k));
    }
    velocity
}
