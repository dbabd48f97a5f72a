//! What a library can change of the process that loads it, and what it must find again afterwards.

#![allow(unsafe_code)] // registers of the processor, and functions of C

use std::collections::BTreeSet;
use std::ffi::{CStr, CString};
use std::mem::MaybeUninit;
use std::path::PathBuf;

/// State of the process and of this thread before a call into a library.
///
/// Signals that programs inside libraries live on, such as SIGSEGV for virtual machines, are theirs; those by which a run is ended
/// are not.
pub struct Surroundings {
    arithmetic: Arithmetic,
    locale: Option<CString>,
    folder: Option<PathBuf>,
    handlers: [libc::sigaction; SIGNALS.len()],
}

/// The signals whose handlers are kept: they end a run, or would end it where files are full and readers are gone.
const SIGNALS: [(libc::c_int, &str); 6] = [
    (libc::SIGHUP, "SIGHUP"),
    (libc::SIGINT, "SIGINT"),
    (libc::SIGQUIT, "SIGQUIT"),
    (libc::SIGPIPE, "SIGPIPE"),
    (libc::SIGTERM, "SIGTERM"),
    (libc::SIGXFSZ, "SIGXFSZ"),
];

/// A flag that the C library sets by itself when a handler is set for the first time, `SA_RESTORER`.
const RESTORER: libc::c_int = 0x0400_0000;

/// What a library had changed.
pub type Changes = BTreeSet<String>;

impl Surroundings {
    /// The present state.
    pub fn now() -> Self {
        Self {
            arithmetic: Arithmetic::now(),
            locale: locale(),
            folder: std::env::current_dir().ok(),
            handlers: SIGNALS.map(|(signal, _)| handler(signal)),
        }
    }

    /// Restores what differs, and names it.
    pub fn restore(&self) -> Changes {
        let mut changes = self.arithmetic.restore();
        let locale = locale();
        if let Some(before) = self.locale.as_ref().filter(|before| Some(*before) != locale.as_ref()) {
            // It was the locale before, so it can be set.
            unsafe { libc::setlocale(libc::LC_ALL, before.as_ptr()) };
            let found = locale.as_deref().map_or_else(|| "?".into(), CStr::to_string_lossy);
            changes.insert(format!("the locale, to {found}"));
        }
        let folder = std::env::current_dir().ok();
        if let Some(before) = self.folder.as_ref().filter(|before| Some(*before) != folder.as_ref())
            && std::env::set_current_dir(before).is_ok()
        {
            let found = folder.map_or_else(|| "?".to_owned(), |folder| folder.display().to_string());
            changes.insert(format!("the working directory, to {found}"));
        }
        for ((signal, name), before) in SIGNALS.iter().zip(&self.handlers) {
            let now = handler(*signal);
            if now.sa_sigaction != before.sa_sigaction || (now.sa_flags ^ before.sa_flags) & !RESTORER != 0 {
                // What the system gave is valid; nothing is written.
                unsafe { libc::sigaction(*signal, before, std::ptr::null_mut()) };
                changes.insert(format!("the handler of {name}"));
            }
        }
        changes
    }
}

fn locale() -> Option<CString> {
    // The text is copied before another call changes it.
    let name = unsafe { libc::setlocale(libc::LC_ALL, std::ptr::null()) };
    (!name.is_null()).then(|| unsafe { CStr::from_ptr(name) }.to_owned())
}

fn handler(signal: libc::c_int) -> libc::sigaction {
    let mut found = MaybeUninit::zeroed();
    // Zeros are a valid handler, the default, if the system should refuse.
    unsafe {
        libc::sigaction(signal, std::ptr::null(), found.as_mut_ptr());
        found.assume_init()
    }
}

/// Control registers of floating-point arithmetic, a nanosecond to read: of SSE, and of x87 for `long double`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arithmetic {
    mxcsr: u32,
    x87: u16,
}

/// Bits of MXCSR: exceptions that have occurred, denormals are zeros, masks of exceptions, rounding, flush to zero.
const OCCURRED: u32 = 0x003F;
const DENORMALS: u32 = 0x8040;
const MASKS: u32 = 0x1F80;
const ROUNDING: u32 = 0x6000;

impl Arithmetic {
    /// The present state.
    pub fn now() -> Self {
        let (mut mxcsr, mut x87) = (0_u32, 0_u16);
        // Both write where they are told.
        unsafe {
            std::arch::asm!(
                "stmxcsr [{}]",
                "fnstcw [{}]",
                in(reg) &raw mut mxcsr,
                in(reg) &raw mut x87,
                options(nostack, preserves_flags)
            );
        }
        Self { mxcsr, x87 }
    }

    /// Restores what differs, and names it.
    pub fn restore(&self) -> Changes {
        let now = Self::now();
        let changed = (now.mxcsr ^ self.mxcsr) & !OCCURRED;
        let mut changes = Changes::new();
        if changed == 0 && now.x87 == self.x87 {
            return changes;
        }
        // Exceptions that are still to be raised are dropped first: loading the word would raise them.
        let (mxcsr, x87) = (self.mxcsr, self.x87);
        unsafe {
            std::arch::asm!(
                "fnclex",
                "fldcw [{}]",
                "ldmxcsr [{}]",
                in(reg) &raw const x87,
                in(reg) &raw const mxcsr,
                options(nostack, preserves_flags)
            );
        }
        let x87 = now.x87 ^ self.x87;
        let mut name = |is_changed, what: &str| is_changed && changes.insert(what.to_owned());
        name(changed & ROUNDING != 0 || x87 & 0x0C00 != 0, "the rounding of floating-point numbers");
        name(changed & MASKS != 0 || x87 & 0x003F != 0, "the traps of floating-point exceptions");
        name(changed & DENORMALS != 0, "the treatment of denormal numbers (flush to zero)");
        name(x87 & 0x0300 != 0, "the precision of the x87 unit");
        changes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::hint::black_box;

    /// Computed where it is called: the compiler may move a quotient, but not a call.
    #[inline(never)]
    fn quotient(numerator: f64, denominator: f64) -> f64 {
        black_box(black_box(numerator) / black_box(denominator))
    }

    fn set(mxcsr: u32, x87: u16) {
        unsafe {
            std::arch::asm!("fldcw [{}]", "ldmxcsr [{}]", in(reg) &raw const x87, in(reg) &raw const mxcsr);
        }
    }

    #[test]
    fn arithmetic_is_restored_and_what_differed_is_named() {
        let before = Arithmetic::now();
        let third = quotient(1.0, 3.0);
        // Rounding upwards is not that of the default.
        set(before.mxcsr & !ROUNDING | 0x4000, before.x87);
        let upwards = quotient(1.0, 3.0);
        let named = before.restore();
        assert!(upwards > third && quotient(1.0, 3.0) == third);
        assert_eq!(named, Changes::from(["the rounding of floating-point numbers".to_owned()]));
        set(before.mxcsr | DENORMALS, before.x87);
        let flushed = quotient(f64::MIN_POSITIVE, 2.0);
        let named = before.restore();
        assert!(flushed == 0.0 && quotient(f64::MIN_POSITIVE, 2.0) > 0.0);
        assert_eq!(named, Changes::from(["the treatment of denormal numbers (flush to zero)".to_owned()]));
        set(before.mxcsr & !MASKS, before.x87 & !0x003F);
        let named = before.restore();
        assert!(quotient(0.0, 0.0).is_nan(), "nothing is trapped");
        assert_eq!(named, Changes::from(["the traps of floating-point exceptions".to_owned()]));
        set(before.mxcsr, before.x87 & !0x0300);
        assert_eq!(before.restore(), Changes::from(["the precision of the x87 unit".to_owned()]));
        assert_eq!((before.restore(), Arithmetic::now().x87), (Changes::new(), before.x87));
        // Exceptions that occurred are no change.
        quotient(1.0, 0.0);
        assert_eq!(before.restore(), Changes::new());
    }

    #[test]
    fn signals_folder_and_locale_are_restored() {
        let before = Surroundings::now();
        let here = std::env::current_dir().expect("a folder");
        unsafe {
            libc::signal(libc::SIGTERM, libc::SIG_IGN);
            libc::signal(libc::SIGPIPE, libc::SIG_DFL);
            libc::setlocale(libc::LC_ALL, c"C.UTF-8".as_ptr());
        }
        std::env::set_current_dir("/").expect("it is there");
        let named: Vec<String> = before.restore().into_iter().collect();
        assert_eq!(
            named,
            [
                "the handler of SIGPIPE",
                "the handler of SIGTERM",
                "the locale, to C.UTF-8",
                "the working directory, to /"
            ]
        );
        assert_eq!(std::env::current_dir().expect("a folder"), here);
        assert_eq!(before.restore(), Changes::new());
        assert_eq!(locale().as_deref(), Some(c"C"));
    }
}
