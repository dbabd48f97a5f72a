//! What the library of an FMU changes of its process. It has a process of its own: others must not change it meanwhile.

mod support;

use cofferdam_coupling::participant::{Level, Participant};
use std::error::Error;
use std::hint::black_box;
use std::time::{Duration, Instant};
use support::{Foreign, initialise, step, texts};

/// 1 / 3 rounded, half of the smallest normal number, and that 0 / 0 is no error.
#[inline(never)]
fn arithmetic() -> [u64; 3] {
    let quotients = [1.0 / black_box(3.0), black_box(f64::MIN_POSITIVE) / 2.0, 0.0 / black_box(0.0_f64)];
    [quotients[0].to_bits(), quotients[1].to_bits(), u64::from(quotients[2].is_nan())]
}

#[test]
fn changes_are_undone_after_each_call_and_warned_of_once() -> Result<(), Box<dyn Error>> {
    let here = std::env::current_dir()?;
    let before = arithmetic();
    assert_eq!(before, [0x3FD5_5555_5555_5555, 0x0008_0000_0000_0000, 1]);
    // A program inside a library may live on signals such as SIGSEGV.
    let mut unit = Foreign::new(&["CHANGES_THE_PROCESS"], &[]).unit()?;
    let unchanged = || {
        assert_eq!((arithmetic(), std::env::current_dir().ok()), (before, Some(here.clone())));
        let status = std::fs::read_to_string("/proc/self/status").expect("its own status");
        let ignored =
            status.lines().find_map(|line| line.strip_prefix("SigIgn:\t")).expect("ignored signals");
        let ignored = u64::from_str_radix(ignored, 16).expect("hexadecimal digits");
        // Rust ignores SIGPIPE, 13; SIGTERM, 15, has its default.
        assert_eq!(ignored & (1 << 12 | 1 << 14), 1 << 12);
    };
    unchanged();
    let named = |messages: &[&str]| {
        let begins = "the library of FMU water changed ";
        let text =
            |text: &&str| text.strip_prefix(begins).map(|t| t.split(';').next().unwrap_or(t).to_owned());
        messages.iter().map(text).collect::<Option<Vec<String>>>().expect("they name the FMU")
    };
    let messages = unit.messages();
    assert_eq!(
        named(&texts(&messages, Level::Warning)),
        [
            "the handler of SIGTERM",
            "the locale, to C.UTF-8",
            "the rounding of floating-point numbers",
            "the working directory, to /"
        ]
    );
    initialise(&mut unit)?;
    for number in 1..=3 {
        step(&mut unit, number)?;
        unchanged();
        let messages = unit.messages();
        let warnings = texts(&messages, Level::Warning);
        match number {
            1 => assert_eq!(
                named(&warnings),
                [
                    "the handler of SIGPIPE",
                    "the traps of floating-point exceptions",
                    "the treatment of denormal numbers (flush to zero)"
                ]
            ),
            _ => assert_eq!(warnings, [""; 0], "each is named once"),
        }
    }
    // As by -ffast-math.
    let mut unit = Foreign::new(&["FLUSHES_WHEN_LOADED"], &[]).unit()?;
    unchanged();
    let messages = unit.messages();
    assert!(texts(&messages, Level::Warning).concat().contains("flush to zero"), "{messages:?}");

    let mut quiet = Foreign::new(&[], &[]).unit()?;
    initialise(&mut quiet)?;
    assert_eq!(quiet.messages(), []);
    let (began, steps) = (Instant::now(), 20_000);
    for number in 1..=steps {
        step(&mut quiet, number)?;
    }
    println!(
        "{:.2} µs for a step that does next to nothing",
        1e6 * began.elapsed().as_secs_f64() / steps as f64
    );
    assert!(began.elapsed() < Duration::from_secs(20));
    Ok(())
}
