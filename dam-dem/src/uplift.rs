//! Uplift: the pressure of water in a joint.
//!
//! Drains and cracks act as in USACE EM 1110-2-2200, *Gravity Dam Design*, 1995, section 3-3. Pressure acts
//! on the whole area. Everything is per metre of dam; the distance x along the joint is measured from its
//! upstream end.

use serde::{Deserialize, Serialize};

mod error;
mod joint_water;
mod line;
#[cfg(test)]
mod tests;

pub use error::UpliftError;
pub use joint_water::JointWater;
pub(crate) use line::{clipped, relieved};
pub use line::{force, interpolate, moment};

/// Uplift during an earthquake where the crack is open. Everywhere else it stays as before the earthquake,
/// except that with [`FullWhereOpen`](Self::FullWhereOpen) a crack that grows changes the pressure beyond its
/// tip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum UpliftRule {
    /// As before the earthquake, also where the joint cracks.
    #[default]
    Unchanged,
    /// No pressure.
    ZeroWhereOpen,
    /// Full pressure of the water at the mouth of the crack.
    FullWhereOpen,
}

impl UpliftRule {
    /// All rules, in the order of the enum.
    pub const ALL: [Self; 3] = [Self::Unchanged, Self::ZeroWhereOpen, Self::FullWhereOpen];

    /// The word in a scene file, and in the serialised form.
    pub fn word(self) -> &'static str {
        match self {
            Self::Unchanged => "unchanged",
            Self::ZeroWhereOpen => "zero-where-open",
            Self::FullWhereOpen => "full-where-open",
        }
    }

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Unchanged => "uplift as before the earthquake",
            Self::ZeroWhereOpen => "no uplift in the open crack",
            Self::FullWhereOpen => "full water pressure in the open crack",
        }
    }

    /// The document that states the rule.
    pub fn source(self) -> &'static str {
        match self {
            Self::Unchanged => "USACE EM 1110-2-2200, 1995; FERC Engineering Guidelines, chapter III",
            Self::ZeroWhereOpen => "USBR, 1987",
            Self::FullWhereOpen => "ICOLD, 1986",
        }
    }
}

/// A line of drains across the joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drains {
    /// Distance from the upstream end along the joint, m.
    pub position: f64,
    /// Efficiency E, from 0 (no effect) to 1.
    pub efficiency: f64,
    /// Elevation of the gallery into which they drain, above the heel of the dam, m; `None` if it is not
    /// above the tailwater.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gallery_elevation: Option<f64>,
}

/// How the pressure in a joint follows from the water upstream and downstream.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Uplift {
    /// Drains; `None` for pressure that falls linearly.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drains: Option<Drains>,
    /// Measured or computed pressure of the uncracked joint instead of that from the heads: (distance, m;
    /// pressure, Pa), linear between the points and constant beyond the last.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<Vec<[f64; 2]>>,
    /// Pressure in the open crack during an earthquake.
    pub rule: UpliftRule,
    /// Factor on the whole uplift over time: (time, s; factor), linear between the points and constant
    /// outside.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub factor: Option<Vec<[f64; 2]>>,
}

impl Uplift {
    /// Factor on the whole uplift at a `time` (s); 1 without a table.
    pub fn factor_at(&self, time: f64) -> f64 {
        match self.factor.as_deref() {
            None | Some([]) => 1.0,
            Some(table) => interpolate(table, time),
        }
    }

    /// Checks the drains and tables for a joint with this `water` in a dam with its crest at this elevation
    /// (m).
    ///
    /// **Errors**: the first [`UpliftError`], in the order of the fields.
    pub fn check(&self, water: &JointWater, crest: f64) -> Result<(), UpliftError> {
        if let Some(drains) = &self.drains {
            drains.check(water.length, crest)?;
        }
        if let Some(profile) = &self.profile {
            if self.drains.is_some() {
                return Err(UpliftError::ProfileWithDrains);
            }
            check_profile(profile, water.length)?;
        }
        self.factor.as_deref().map_or(Ok(()), check_factor)
    }
}

impl Drains {
    fn check(&self, length: f64, crest: f64) -> Result<(), UpliftError> {
        let Self { position, efficiency, gallery_elevation } = *self;
        if !(position > 0.0 && position < length) {
            return Err(UpliftError::DrainsPosition { position, length });
        }
        if !(0.0..=1.0).contains(&efficiency) {
            return Err(UpliftError::DrainsEfficiency { efficiency });
        }
        match gallery_elevation {
            Some(elevation) if !(elevation.is_finite() && elevation <= crest) => {
                Err(UpliftError::GalleryElevation { elevation, crest })
            }
            _ => Ok(()),
        }
    }
}

fn check_profile(profile: &[[f64; 2]], length: f64) -> Result<(), UpliftError> {
    let &[[first, _], _, ..] = profile else {
        return Err(UpliftError::ProfileTooShort { points: profile.len() });
    };
    if first != 0.0 {
        return Err(UpliftError::ProfileStart { distance: first });
    }
    for (index, &[distance, pressure]) in profile.iter().enumerate() {
        let previous = if index > 0 { profile[index - 1][0] } else { f64::NEG_INFINITY };
        let follows = distance > previous;
        if !follows {
            return Err(UpliftError::ProfileOrder { index, distance, previous });
        }
        if distance > length {
            return Err(UpliftError::ProfileBeyondJoint { index, distance, length });
        }
        if !(pressure >= 0.0 && pressure.is_finite()) {
            return Err(UpliftError::ProfilePressure { index, distance, pressure });
        }
    }
    Ok(())
}

fn check_factor(table: &[[f64; 2]]) -> Result<(), UpliftError> {
    if table.is_empty() {
        return Err(UpliftError::FactorEmpty);
    }
    for (index, &[time, factor]) in table.iter().enumerate() {
        let previous = if index > 0 { table[index - 1][0] } else { f64::NEG_INFINITY };
        if !(time > previous && time.is_finite()) {
            return Err(UpliftError::FactorOrder { index, time, previous });
        }
        if !(factor >= 0.0 && factor.is_finite()) {
            return Err(UpliftError::FactorNegative { index, time, factor });
        }
    }
    Ok(())
}
