//! Factors and zones that named authorities require of a gravity dam.
//!
//! Each number has a [`Status`]; numbers that were not compared with any citation are printed as `to be confirmed`.

use serde::{Deserialize, Serialize};

use super::{LoadCombination, ResultantZone};
use crate::uplift::UpliftRule;

/// Whether a number was compared with a published source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Found in the named text, which cites the authority; not read in the authority's document.
    Checked(&'static str),
    /// No citation could be compared, or the citations disagree.
    ToBeConfirmed,
}

impl Status {
    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Status::Checked(_) => "checked in a citation",
            Status::ToBeConfirmed => "to be confirmed",
        }
    }

    /// The name with the text in which the number was found.
    pub fn sentence(self) -> String {
        match self {
            Status::Checked(source) => format!("{}: {source}", self.label()),
            Status::ToBeConfirmed => self.label().to_owned(),
        }
    }

    /// Whether a citation was found.
    pub fn is_checked(self) -> bool {
        matches!(self, Status::Checked(_))
    }
}

const SECTION_CHECK: Status = Status::Checked("gravity_section_check.py (open source), citing both manuals");
const SEAINT: Status = Status::Checked("W. C. Sherman, SEAINT mailing list, 4 November 2005");
const CADAM3D: Status = Status::Checked("CADAM3D help, Uplift in cracks during earthquakes (cadam3d.com)");
const GORAI_MAITY: Status = Status::Checked("Gorai and Maity, Natural Hazards (2020), section 4.5");

/// An authority whose stability criteria are built in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Authority {
    /// US Army Corps of Engineers.
    #[default]
    Usace,
    /// Federal Energy Regulatory Commission.
    Ferc,
    /// US Bureau of Reclamation.
    Usbr,
    /// Canadian Dam Association.
    Cda,
}

impl Authority {
    /// All authorities, in the order of the enum.
    pub const ALL: [Authority; 4] = [Self::Usace, Self::Ferc, Self::Usbr, Self::Cda];

    /// The word used in scene files and on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Usace => "usace",
            Self::Ferc => "ferc",
            Self::Usbr => "usbr",
            Self::Cda => "cda",
        }
    }

    /// The name.
    pub fn label(self) -> &'static str {
        match self {
            Self::Usace => "US Army Corps of Engineers",
            Self::Ferc => "Federal Energy Regulatory Commission",
            Self::Usbr => "US Bureau of Reclamation",
            Self::Cda => "Canadian Dam Association",
        }
    }

    /// The document that states the factors, with its edition.
    pub fn document(self) -> &'static str {
        match self {
            Self::Usace => "USACE, EM 1110-2-2200, Gravity Dam Design, 30 June 1995, table 4-1",
            Self::Ferc => "FERC, Engineering Guidelines, III Gravity Dams, 2002 (2016), tables 2, 2A",
            Self::Usbr => "USBR, Design of Gravity Dams, 1976; Engineering Monograph 19, 1977",
            Self::Cda => "CDA, Dam Safety Guidelines, 2007, bulletin Structural Considerations",
        }
    }

    /// Uplift in cracks while the ground shakes, and the status of this rule.
    ///
    /// USACE (1995) and FERC (1991) keep the pressure from before the earthquake. USBR (1987)
    /// sets it to zero where a crack opens. The Canadian guidelines (CDSA 1997) keep it in areas of
    /// low seismicity, the rule returned here because it is the safer one, and accept zero in open
    /// cracks in areas of high seismicity. ICOLD (1986), full reservoir pressure, is none of these.
    pub fn uplift_rule(self) -> (UpliftRule, Status) {
        let rule = match self {
            Self::Usace | Self::Ferc | Self::Cda => UpliftRule::Unchanged,
            Self::Usbr => UpliftRule::ZeroWhereOpen,
        };
        (rule, CADAM3D)
    }
}

/// Part of the joint in which the resultant has to act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zone {
    /// The middle third.
    MiddleThird,
    /// The middle half.
    MiddleHalf,
    /// Anywhere within the joint.
    InsideBase,
    /// No location is encoded.
    NotPrescribed,
}

/// What an authority requires of a joint in one load combination.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Requirement {
    /// Least factor against sliding, friction and cohesion.
    pub sliding: f64,
    /// Least factor if cohesion is not relied on; `None`: `sliding` applies.
    pub sliding_without_cohesion: Option<f64>,
    /// Where the resultant has to act.
    pub resultant: Zone,
    /// Status of the sliding factors.
    pub status: Status,
    /// Status of the resultant's zone.
    pub resultant_status: Status,
}

/// The requirement of `authority`; `None` if the encoded tables contain none.
///
/// * FERC: values for high and significant hazard potential. No factor is required during the
///   earthquake (pseudostatic analysis is not accepted) but after it. Its extreme combination is
///   the earthquake; floods are unusual, so `Extreme` is `None`. The unusual factor without
///   cohesion may apply to the probable maximum flood only.
/// * USACE, USBR: the earthquake is an extreme combination; no factor for the time after it.
/// * CDA: `sliding` is the factor on peak strength without tests, `sliding_without_cohesion`
///   the factor on residual strength. The citations disagree about the extreme flood.
pub fn required(authority: Authority, combination: LoadCombination) -> Option<Requirement> {
    use Authority::{Cda, Ferc, Usace, Usbr};
    use LoadCombination::{Extreme, PostEarthquake, Seismic, Unusual, Usual};
    use Status::ToBeConfirmed as Tbc;
    use Zone::{InsideBase, MiddleHalf, MiddleThird, NotPrescribed};
    let (sliding, sliding_without_cohesion, status, resultant, resultant_status) =
        match (authority, combination) {
            (Usace, Usual) => (2.0, None, SECTION_CHECK, MiddleThird, SECTION_CHECK),
            (Usace, Unusual) => (1.7, None, SEAINT, MiddleHalf, Tbc),
            (Usace, Extreme | Seismic) => (1.3, None, Tbc, InsideBase, Tbc),
            (Ferc, Usual) => (3.0, Some(1.5), SECTION_CHECK, NotPrescribed, Tbc),
            (Ferc, Unusual) => (2.0, Some(1.3), Tbc, NotPrescribed, Tbc),
            (Ferc, PostEarthquake) => (1.3, Some(1.3), Tbc, NotPrescribed, Tbc),
            (Usbr, Usual) => (3.0, None, Tbc, NotPrescribed, Tbc),
            (Usbr, Unusual) => (2.0, None, Tbc, NotPrescribed, Tbc),
            (Usbr, Extreme | Seismic) => (1.0, None, Tbc, NotPrescribed, Tbc),
            (Cda, Usual) => (3.0, Some(1.5), Tbc, MiddleThird, Tbc),
            (Cda, Unusual) => (2.0, Some(1.3), Tbc, MiddleHalf, Tbc),
            (Cda, Extreme) => (1.3, Some(1.1), Tbc, InsideBase, Tbc),
            (Cda, Seismic) => (1.3, Some(1.0), Tbc, InsideBase, Tbc),
            (Cda, PostEarthquake) => (2.0, Some(1.1), Tbc, InsideBase, Tbc),
            (Ferc, Extreme | Seismic) | (Usace | Usbr, PostEarthquake) => return None,
        };
    Some(Requirement { sliding, sliding_without_cohesion, resultant, status, resultant_status })
}

/// Demand-capacity criterion for linear analyses of gravity dams, USACE EM 1110-2-6051 (2003).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DcrCriterion {
    /// The document that states it.
    pub document: &'static str,
    /// Largest ratio of tensile stress to tensile strength.
    pub largest: f64,
    /// Largest part of the cross-section in which the strength is exceeded.
    pub area: f64,
    /// Cumulative time, s, that the stress may exceed the strength.
    pub duration_at_one: f64,
    /// Status of `largest` and `area`.
    pub status: Status,
    /// Status of the performance curve. Of the two durations in the literature, 0.3 s and 0.4 s (arch dams), this is the shorter.
    pub curve_status: Status,
}

/// The criterion for gravity dams.
pub const DCR: DcrCriterion = DcrCriterion {
    document: "USACE EM 1110-2-6051 (2003)",
    largest: 2.0,
    area: 0.15,
    duration_at_one: 0.3,
    status: GORAI_MAITY,
    curve_status: Status::ToBeConfirmed,
};

impl Zone {
    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::MiddleThird => "middle third",
            Self::MiddleHalf => "middle half",
            Self::InsideBase => "inside the joint",
            Self::NotPrescribed => "not prescribed",
        }
    }

    /// Whether a resultant in this `zone` of the joint lies in it.
    pub fn contains(self, zone: ResultantZone) -> bool {
        match self {
            Self::MiddleThird => zone <= ResultantZone::MiddleThird,
            Self::MiddleHalf => zone <= ResultantZone::MiddleHalf,
            Self::InsideBase => zone <= ResultantZone::Inside,
            Self::NotPrescribed => true,
        }
    }
}

impl DcrCriterion {
    /// Longest cumulative time, s, above `dcr`; infinite below 1, zero from `largest`.
    pub fn allowed_duration(&self, dcr: f64) -> f64 {
        if dcr < 1.0 {
            return f64::INFINITY;
        }
        (self.duration_at_one * (self.largest - dcr) / (self.largest - 1.0)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use LoadCombination::{Extreme, PostEarthquake, Seismic, Unusual, Usual};

    const COMBINATIONS: [LoadCombination; 5] = [Usual, Unusual, Extreme, Seismic, PostEarthquake];

    fn factors(authority: Authority) -> [Option<f64>; 5] {
        COMBINATIONS.map(|c| required(authority, c).map(|r| r.sliding))
    }

    #[test]
    fn factors_have_the_tabulated_values() {
        assert_eq!(factors(Authority::Usace), [Some(2.0), Some(1.7), Some(1.3), Some(1.3), None]);
        assert_eq!(factors(Authority::Ferc), [Some(3.0), Some(2.0), None, None, Some(1.3)]);
        assert_eq!(factors(Authority::Usbr), [Some(3.0), Some(2.0), Some(1.0), Some(1.0), None]);
        let residual = COMBINATIONS.map(|c| required(Authority::Cda, c)?.sliding_without_cohesion);
        assert_eq!(residual, [Some(1.5), Some(1.3), Some(1.1), Some(1.0), Some(1.1)]);
    }

    #[test]
    fn factors_do_not_increase_as_combinations_become_rarer() {
        for authority in Authority::ALL {
            let rows = [Usual, Unusual, Extreme].map(|c| required(authority, c));
            let present: Vec<_> = rows.into_iter().flatten().collect();
            let ordered =
                |f: fn(&Requirement) -> Option<f64>| present.windows(2).all(|p| f(&p[0]) >= f(&p[1]));
            assert!(ordered(|r| Some(r.sliding)), "{authority:?}");
            assert!(ordered(|r| r.sliding_without_cohesion), "{authority:?}");
        }
    }

    #[test]
    fn tables_with_unread_factors_are_to_be_confirmed() {
        let unread = |authority| {
            let mut rows = COMBINATIONS.into_iter().filter_map(move |c| required(authority, c));
            rows.any(|row| row.status == Status::ToBeConfirmed)
        };
        assert!(Authority::ALL.into_iter().all(unread));
        assert!(required(Authority::Usace, Usual).is_some_and(|r| r.status.is_checked()));
    }

    #[test]
    fn allowed_duration_falls_linearly() {
        let durations = [0.9, 1.0, 1.5, 2.0, 3.0].map(|dcr| DCR.allowed_duration(dcr));
        assert_eq!(durations, [f64::INFINITY, 0.3, 0.15, 0.0, 0.0]);
    }
}
