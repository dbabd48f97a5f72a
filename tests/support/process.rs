//! Processes of runs: signals, and waiting for their end.

use std::process::Command;
use std::time::{Duration, Instant};

/// Sends `signal` (`-KILL`) to a process that exists.
pub fn signal(process: u32, signal: &str) {
    let status = Command::new("kill").args([signal, &process.to_string()]).status();
    assert!(status.expect("kill runs").success(), "kill {signal} {process}");
}

/// Waits up to 20 s until `condition` holds; whether it does.
pub fn wait_until(condition: impl Fn() -> bool) -> bool {
    let began = Instant::now();
    while began.elapsed() < Duration::from_secs(20) {
        if condition() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    false
}

/// The process does not exist, or only its entry is left because its exit status was not collected.
pub fn is_gone(process: u32) -> bool {
    let state = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    state.rsplit(") ").next().is_none_or(|s| s.is_empty() || s.starts_with('Z'))
}
