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
///
/// Of a process with several threads the entry may say `Z` while others still end, and with them the files and locks that
/// they share: all threads have to be gone.
pub fn is_gone(process: u32) -> bool {
    let threads = std::fs::read_dir(format!("/proc/{process}/task")).into_iter().flatten().flatten();
    threads.map(|thread| std::fs::read_to_string(thread.path().join("stat")).unwrap_or_default()).all(
        |stat| {
            let state = stat.rsplit(") ").next();
            state.is_none_or(|state| state.is_empty() || state.starts_with('Z'))
        },
    )
}
