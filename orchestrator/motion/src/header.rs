use super::units::Units;

/// What a header says of the values under it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Values {
    /// Nothing.
    Unsaid,
    /// They are accelerations in this unit.
    In(Units),
    /// They are something else.
    Other(&'static str),
}

/// Reads a header such as `time (s), acc (cm/s^2)` or `VELOCITY TIME SERIES IN UNITS OF CM/S`.
pub(super) fn values(header: &str) -> Values {
    let plain = header.to_lowercase().replace('²', "2").replace(['^', '*'], "").replace("s-2", "s2");
    let words: Vec<String> = plain
        .split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty())
        .map(|word| word.replace("sec", "s"))
        .collect();
    let mut words: Vec<&str> = words.iter().map(String::as_str).collect();
    if let [first, rest @ ..] = &words[..]
        && (first.starts_with("time") || *first == "t")
        && !rest.starts_with(&["series"])
        && !rest.starts_with(&["history"])
    {
        words = rest.strip_prefix(&["s"]).unwrap_or(rest).to_vec();
    }
    for (start, name) in [("vel", "velocities"), ("disp", "displacements")] {
        if words.iter().any(|word| word.starts_with(start)) {
            return Values::Other(name);
        }
    }
    let unit = |at: usize| match words[at..] {
        ["g", ..] => Some(Values::In(Units::Gravity)),
        ["gal" | "gals", ..] => Some(Values::In(Units::Centimetres)),
        ["m", "s2", ..] | ["m", "s", "s" | "2", ..] => Some(Values::In(Units::Metres)),
        ["cm", "s2", ..] | ["cm", "s", "s" | "2", ..] => Some(Values::In(Units::Centimetres)),
        ["mm", "s2", ..] | ["mm", "s", "s" | "2", ..] => Some(Values::Other("accelerations in mm/s²")),
        ["mm" | "cm" | "m", "s", ..] => Some(Values::Other("velocities")),
        ["mm" | "cm" | "m", ..] => Some(Values::Other("displacements")),
        _ => None,
    };
    (0..words.len()).find_map(unit).unwrap_or(Values::Unsaid)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_say_what_the_values_are() {
        for header in
            ["time_s,acceleration_g", "Time [s] Acc [g]", "ACCELERATION TIME SERIES IN UNITS OF G. HP=0.2 Hz"]
        {
            assert_eq!(values(header), Values::In(Units::Gravity), "{header}");
        }
        for header in
            ["t,m/s2", "Time (sec), a (m/s/s)", "time_s,acc_m_s2", "acc m s^-2", "time,acc [m/sec²]"]
        {
            assert_eq!(values(header), Values::In(Units::Metres), "{header}");
        }
        for header in ["t,acc (cm/s**2)", "time\tgal", "time (s)\tcm/sec/sec", "ACCELERATION IN CM/S2"] {
            assert_eq!(values(header), Values::In(Units::Centimetres), "{header}");
        }
        for header in ["time,vel", "VELOCITY TIME SERIES IN UNITS OF CM/S", "t (s),x (m/s)", "time_s,cm_s"] {
            assert_eq!(values(header), Values::Other("velocities"), "{header}");
        }
        for header in ["DISPLACEMENT TIME SERIES IN UNITS OF CM", "time_s,x_m", "time (s), displ."] {
            assert_eq!(values(header), Values::Other("displacements"), "{header}");
        }
        assert_eq!(values("time, mm/s2"), Values::Other("accelerations in mm/s²"));
        for header in ["", "t,a", "time,acc", "Time (s), ground acceleration", "TIME SERIES"] {
            assert_eq!(values(header), Values::Unsaid, "{header}");
        }
    }
}
