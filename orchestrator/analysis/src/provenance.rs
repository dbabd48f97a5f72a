//! Whether a run was made by this build on this machine.

use cofferdam_log::Head;
use cofferdam_report::Build;

/// Difference of the program or the machine from that of a log; `None` if both are the same.
pub fn other_build(head: &Head) -> Option<String> {
    let here = Build::here();
    let pairs = [
        ("version", &*here.version, &head.version),
        ("commit", &here.commit, &head.commit),
        ("profile", &here.profile, &head.profile),
        ("processor's features", &here.features, &head.features),
        ("system", &here.system, &head.system),
    ];
    let other = pairs.into_iter().find(|(_, now, then)| now != then)?;
    let (what, now, then) = other;
    Some(format!("the run was made by another {what} ({then:?}, here {now:?})"))
}
