//! What a section, its galleries and its cracks can be refused for.

use std::fmt;

use cofferdam_unit::number::{exact, plain};

/// What an edge or a point belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Feature {
    /// The straight line from heel to toe.
    Base,
    /// The downstream side.
    Downstream,
    /// The straight line between the upper ends of the two sides.
    Crest,
    /// The upstream side.
    Upstream,
    /// A zone's outline, by its index.
    Zone(usize),
    /// A gallery, by its index.
    Gallery(usize),
    /// A crack, by its index.
    Crack(usize),
}

impl Feature {
    /// Whether the concrete ends there.
    pub(super) fn is_boundary(self) -> bool {
        !matches!(self, Self::Crack(_) | Self::Zone(_))
    }
}

impl fmt::Display for Feature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Base => f.write_str("the base"),
            Self::Downstream => f.write_str("the downstream side"),
            Self::Crest => f.write_str("the crest"),
            Self::Upstream => f.write_str("the upstream side"),
            Self::Zone(index) => write!(f, "zone {index}"),
            Self::Gallery(index) => write!(f, "gallery {index}"),
            Self::Crack(index) => write!(f, "crack {index}"),
        }
    }
}

/// A point in a message.
fn place(point: &[f64; 2]) -> String {
    format!("({}, {})", exact(point[0]), exact(point[1]))
}

/// A computed point in a message.
fn near(point: &[f64; 2]) -> String {
    format!("({}, {})", plain(point[0]), plain(point[1]))
}

/// Why a cracked section cannot be meshed. Indices count from 0, coordinates are in m.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// Too few points.
    #[error("{feature} has {found} points; give {needed} or more")]
    TooFewPoints {
        /// Where.
        feature: Feature,
        /// Number of points.
        found: usize,
        /// Number needed.
        needed: usize,
    },
    /// A coordinate that is not finite, or farther than 10⁶ m from the heel.
    #[error(
        "point {index} of {feature} is {place}; coordinates must be finite and within 1e6 m of the heel",
        place = place(point)
    )]
    NotFinite {
        /// Where.
        feature: Feature,
        /// Index of the point.
        index: usize,
        /// The point.
        point: [f64; 2],
    },
    /// The upstream side does not start at the origin.
    #[error("the upstream side starts at {place}; the heel must be the origin, so shift the section",
        place = place(point)
    )]
    HeelNotAtOrigin {
        /// First point of the upstream side.
        point: [f64; 2],
    },
    /// The downstream side does not start at y = 0 to the right of the heel.
    #[error("the downstream side starts at {place}; the toe must be at y = 0 and x > 0", place = place(point))]
    ToeNotOnBase {
        /// First point of the downstream side.
        point: [f64; 2],
    },
    /// A point of the outline or of a gallery at or below the base.
    #[error("point {index} of {feature}, {place}, is not above the base; raise it above y = 0",
        place = place(point)
    )]
    BelowBase {
        /// Where.
        feature: Feature,
        /// Index of the point.
        index: usize,
        /// The point.
        point: [f64; 2],
    },
    /// An outline or gallery that crosses or touches itself or turns back on itself.
    #[error("{first} meets {second} at {place}; an outline must not cross or touch itself: move its points apart",
        place = near(point)
    )]
    OutlineCrosses {
        /// One part.
        first: Feature,
        /// The other.
        second: Feature,
        /// Where they meet.
        point: [f64; 2],
    },
    /// A gallery that is not within the section, or within another gallery.
    #[error("gallery {gallery} lies outside the concrete, as at {place}; move it inside, or leave it out",
        place = near(point)
    )]
    GalleryOutside {
        /// Index of the gallery.
        gallery: usize,
        /// One of its points.
        point: [f64; 2],
    },
    /// A gallery that touches a side or another gallery.
    #[error("gallery {gallery} meets {other} at {place}; leave concrete between them, or make it part of the outline",
        place = near(point)
    )]
    GalleryTouches {
        /// Index of the gallery.
        gallery: usize,
        /// What it meets.
        other: Feature,
        /// Where.
        point: [f64; 2],
    },
    /// A zone without any concrete of its own.
    #[error(
        "zone {zone} holds no concrete: it lies outside the section, or later zones cover it; move it, or leave it out"
    )]
    EmptyZone {
        /// Index of the zone.
        zone: usize,
    },
    /// A crack of which nothing lies within the concrete or on the base.
    #[error("crack {crack} lies outside the concrete; move it inside or onto the base, or leave it out")]
    CrackOutside {
        /// Index of the crack.
        crack: usize,
    },
    /// Two cracks on the same line.
    #[error(
        "crack {first} and crack {second} share the line from {from} to {to}; let one of them end there, or make them one",
        from = near(from), to = near(to)
    )]
    SharedStretch {
        /// Index of one.
        first: usize,
        /// Index of the other.
        second: usize,
        /// Start of a shared line.
        from: [f64; 2],
        /// Its end.
        to: [f64; 2],
    },
    /// A crack that ends within a block.
    #[error(
        "crack {crack} ends inside the concrete at {end}; lead it to {nearest} at {target}, {distance} m away, or to another \
         side or crack; fracture is not modelled",
        end = near(end), target = near(target), distance = plain(*distance)
    )]
    CrackEndsInside {
        /// Index of the crack.
        crack: usize,
        /// Its end.
        end: [f64; 2],
        /// What is nearest.
        nearest: Feature,
        /// The nearest point.
        target: [f64; 2],
        /// Its distance, m.
        distance: f64,
    },
    /// A crack with the same block on both sides, such as one that ends in a gallery.
    #[error(
        "crack {crack} does not separate the concrete: one block lies on both sides of it at {place}; continue it, or the \
         crack it leads to, to another side (beyond a gallery, if it ends in one); fracture is not modelled",
        place = near(point)
    )]
    NotSeparating {
        /// Index of the crack.
        crack: usize,
        /// An end of the stretch that does not separate.
        point: [f64; 2],
    },
    /// Features that would lead to tiny elements.
    #[error(
        "{first} at {place} and {second} at {other} are {distance} m apart, and the minimum is {least} m (0.05 `element_size`); \
         move them apart or together, or take a smaller `element_size`",
        place = near(point), other = near(other), distance = plain(*distance), least = plain(*least)
    )]
    TooClose {
        /// One feature.
        first: Feature,
        /// The other.
        second: Feature,
        /// Place on the first.
        point: [f64; 2],
        /// Place on the other.
        other: [f64; 2],
        /// Distance, m.
        distance: f64,
        /// Least distance, m.
        least: f64,
    },
    /// Edges that meet at a small angle.
    #[error(
        "{first} and {second} meet at {place} at {angle:.1}°, and the minimum is {least}°; let them meet at a larger angle",
        place = near(point)
    )]
    SmallAngle {
        /// One feature.
        first: Feature,
        /// The other.
        second: Feature,
        /// Where they meet.
        point: [f64; 2],
        /// Angle of the concrete between them, degrees.
        angle: f64,
        /// Least angle, degrees.
        least: f64,
    },
    /// An element size that is not positive, or larger than the section.
    #[error("{name} is {size} m; it must be above 0 and at most the section's height of {height} m",
        size = exact(*size), height = exact(*height)
    )]
    ElementSize {
        /// What is sized: `element_size` or that of a crack.
        name: String,
        /// Size, m.
        size: f64,
        /// Height of the section, m.
        height: f64,
    },
    /// Too many cells.
    #[error(
        "the element sizes lead to more than {most:.0e} cells (about {cells:.1e}); take a larger `element_size`, \
        or larger ones at the cracks"
    )]
    TooManyCells {
        /// Number of cells expected, or reached so far.
        cells: f64,
        /// Largest number.
        most: f64,
    },
    /// A block that is too small for a cell.
    #[error(
        "the block at {place} has an area of {area} m², and the minimum is {least} m² (a tenth of `element_size`, squared); \
         move the cracks around it, or take a smaller `element_size`",
        place = near(point), area = plain(*area), least = plain(*least)
    )]
    TinyBlock {
        /// Its centroid.
        point: [f64; 2],
        /// Its area, m².
        area: f64,
        /// Least area, m².
        least: f64,
    },
    /// A thin or inverted triangle.
    #[error(
        "the mesh has a triangle with an angle of {angle:.2}° at {place}, and the minimum is {least}°; move cracks and corners \
         near it apart, or take another `element_size`",
        place = near(point)
    )]
    Sliver {
        /// Where.
        point: [f64; 2],
        /// Its smallest angle, degrees; negative if inverted.
        angle: f64,
        /// Least angle, degrees.
        least: f64,
    },
    /// A triangulation that does not contain all edges.
    #[error("the section cannot be triangulated near {place}; move cracks and corners there apart", place = near(point))]
    NotTriangulated {
        /// Where.
        point: [f64; 2],
    },
}

impl GeometryError {
    /// The message with `names` of cracks, such as `the crack "neck"`, in place of their indices.
    pub fn with_names(&self, names: &[Option<String>]) -> String {
        let message = self.to_string();
        let indices = |(index, name)| Some((Feature::Crack(index).to_string(), Option::as_ref(name)?));
        let known: Vec<(String, &String)> = names.iter().enumerate().filter_map(indices).collect();
        let (mut named, mut rest) = (String::new(), message.as_str());
        while let Some(first) = rest.chars().next() {
            let found = known.iter().find_map(|(index, name)| {
                let after = rest.strip_prefix(index.as_str())?;
                (!after.starts_with(|next: char| next.is_ascii_digit())).then_some((name, after))
            });
            match found {
                Some((name, after)) => {
                    named.push_str(name);
                    rest = after;
                }
                None => {
                    named.push(first);
                    rest = &rest[first.len_utf8()..];
                }
            }
        }
        named
    }

    /// The parts of the section that it names.
    pub fn features(&self) -> Vec<Feature> {
        match *self {
            Self::TooFewPoints { feature, .. }
            | Self::NotFinite { feature, .. }
            | Self::BelowBase { feature, .. } => vec![feature],
            Self::HeelNotAtOrigin { .. } => vec![Feature::Upstream],
            Self::ToeNotOnBase { .. } => vec![Feature::Downstream],
            Self::OutlineCrosses { first, second, .. }
            | Self::TooClose { first, second, .. }
            | Self::SmallAngle { first, second, .. } => vec![first, second],
            Self::GalleryOutside { gallery, .. } => vec![Feature::Gallery(gallery)],
            Self::GalleryTouches { gallery, other, .. } => vec![Feature::Gallery(gallery), other],
            Self::EmptyZone { zone } => vec![Feature::Zone(zone)],
            Self::CrackOutside { crack }
            | Self::CrackEndsInside { crack, .. }
            | Self::NotSeparating { crack, .. } => vec![Feature::Crack(crack)],
            Self::SharedStretch { first, second, .. } => vec![Feature::Crack(first), Feature::Crack(second)],
            Self::ElementSize { .. }
            | Self::TooManyCells { .. }
            | Self::TinyBlock { .. }
            | Self::Sliver { .. }
            | Self::NotTriangulated { .. } => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cracks_are_called_by_their_names() {
        let error =
            GeometryError::SharedStretch { first: 1, second: 10, from: [5.0, 40.0], to: [15.0, 40.0] };
        let mut names = vec![None; 11];
        assert_eq!(error.with_names(&names), error.to_string());
        names[1] = Some("the crack \"crack 10\"".to_owned());
        let named = error.with_names(&names);
        assert!(named.starts_with("the crack \"crack 10\" and crack 10 share the line"), "{named}");
        names[10] = Some("the crack \"neck\"".to_owned());
        let named = error.with_names(&names);
        assert!(named.starts_with("the crack \"crack 10\" and the crack \"neck\" share the line"), "{named}");
    }
}
