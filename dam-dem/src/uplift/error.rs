use std::fmt;

/// What is wrong with the description of uplift.
#[derive(Clone, Debug, PartialEq)]
pub enum UpliftError {
    /// Drains at or beyond an end of the joint.
    DrainsPosition {
        /// Distance given, m.
        position: f64,
        /// Length of the joint, m.
        length: f64,
    },
    /// An efficiency that is not a share.
    DrainsEfficiency {
        /// Efficiency given.
        efficiency: f64,
    },
    /// A gallery above the crest, or not at a finite elevation.
    GalleryElevation {
        /// Elevation given, m.
        elevation: f64,
        /// Elevation of the crest, m.
        crest: f64,
    },
    /// A profile and drains for the same joint.
    ProfileWithDrains,
    /// A profile of fewer than two points.
    ProfileTooShort {
        /// Number of points.
        points: usize,
    },
    /// A profile that does not start at the upstream end.
    ProfileStart {
        /// Distance of the first point, m.
        distance: f64,
    },
    /// Distances of the profile that do not increase.
    ProfileOrder {
        /// Index of the point.
        index: usize,
        /// Its distance, m.
        distance: f64,
        /// Distance of the point before, m.
        previous: f64,
    },
    /// A point of the profile beyond the downstream end.
    ProfileBeyondJoint {
        /// Index of the point.
        index: usize,
        /// Its distance, m.
        distance: f64,
        /// Length of the joint, m.
        length: f64,
    },
    /// A negative pressure, or one that is not finite.
    ProfilePressure {
        /// Index of the point.
        index: usize,
        /// Its distance, m.
        distance: f64,
        /// Its pressure, Pa.
        pressure: f64,
    },
    /// A table of factors without rows.
    FactorEmpty,
    /// Times of the factors that do not increase, or are not finite.
    FactorOrder {
        /// Index of the row.
        index: usize,
        /// Its time, s.
        time: f64,
        /// Time of the row before, s; −∞ for the first.
        previous: f64,
    },
    /// A negative factor, or one that is not finite.
    FactorNegative {
        /// Index of the row.
        index: usize,
        /// Its time, s.
        time: f64,
        /// Its factor.
        factor: f64,
    },
}

impl UpliftError {
    /// The key to change, below that of the uplift.
    pub fn key(&self) -> &'static str {
        match self {
            Self::DrainsPosition { .. } => "drains.position",
            Self::DrainsEfficiency { .. } => "drains.efficiency",
            Self::GalleryElevation { .. } => "drains.gallery_elevation",
            Self::ProfileWithDrains
            | Self::ProfileTooShort { .. }
            | Self::ProfileStart { .. }
            | Self::ProfileOrder { .. }
            | Self::ProfileBeyondJoint { .. }
            | Self::ProfilePressure { .. } => "profile",
            Self::FactorEmpty | Self::FactorOrder { .. } | Self::FactorNegative { .. } => "factor",
        }
    }
}

impl fmt::Display for UpliftError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let key = self.key();
        match *self {
            Self::DrainsPosition { position, length } => write!(
                f,
                "`{key}` is {position} m; it must lie within the joint, more than 0 and less than {length} \
                 m from its upstream end"
            ),
            Self::DrainsEfficiency { efficiency } => write!(
                f,
                "`{key}` is {efficiency}; it must be between 0 (no effect) and 1 (give 67 % as 0.67)"
            ),
            Self::GalleryElevation { elevation, crest } => write!(
                f,
                "`{key}` is {elevation} m; give an elevation above the heel of the dam that is not above \
                 the crest at {crest} m, or leave it out if the gallery is not above the tailwater"
            ),
            Self::ProfileWithDrains => write!(
                f,
                "`{key}` gives the pressure with the effect of drains, and `drains` are given as well; \
                 leave one of them out"
            ),
            Self::ProfileTooShort { points } => {
                write!(f, "`{key}` has {points} points; give at least 2, the first at 0 m")
            }
            Self::ProfileStart { distance } => write!(
                f,
                "`{key}` starts at {distance} m; its first point must be the upstream end of the joint, \
                 at 0 m"
            ),
            Self::ProfileOrder { index, distance, previous } => write!(
                f,
                "`{key}`: point {index} at {distance} m does not follow the one before, at {previous} m; \
                 distances from the upstream end must increase"
            ),
            Self::ProfileBeyondJoint { index, distance, length } => write!(
                f,
                "`{key}`: point {index} at {distance} m lies beyond the joint, which is {length} m long; \
                 remove it or check the distances"
            ),
            Self::ProfilePressure { index, distance, pressure } => write!(
                f,
                "`{key}`: the pressure of point {index} at {distance} m is {pressure} Pa; it must be 0 \
                 or more"
            ),
            Self::FactorEmpty => {
                write!(f, "`{key}` has no rows; give at least one time and factor, or leave it out")
            }
            Self::FactorOrder { index, time, previous } if time.is_finite() => write!(
                f,
                "`{key}`: the time of row {index}, {time} s, does not follow the one before, {previous} s; \
                 times must increase"
            ),
            Self::FactorOrder { index, time, .. } => {
                write!(f, "`{key}`: the time of row {index} is {time} s; it must be finite")
            }
            Self::FactorNegative { index, time, factor } => write!(
                f,
                "`{key}`: the factor of row {index} at {time} s is {factor}; it must be 0 or more, with 1 \
                 for the whole uplift"
            ),
        }
    }
}

impl std::error::Error for UpliftError {}
