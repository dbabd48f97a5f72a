//! Messages of `cofferdam check` on mesh, time step and record.

use cofferdam_assembly::{LimitingPart, Mesh, PartKind};
use cofferdam_motion::{Component, GroundMotion, STANDARD_GRAVITY};
use cofferdam_scene::{CrackScene, LoadedScene};
use cofferdam_unit::number::plain;

/// Ratio of the time step that the median element would allow to the one taken, from which a warning is given.
pub const SLOW: f64 = 3.0;

/// Numbers and shapes of the dam's elements.
pub fn shapes(mesh: &Mesh) -> String {
    let quality = mesh.quality();
    let at = |(value, [x, y]): (f64, [f64; 2])| format!("{value:.2} at ({x:.2}, {y:.2})");
    let with = |unit: &str, (value, [x, y]): (f64, [f64; 2])| format!("{value:.2}{unit} at ({x:.2}, {y:.2})");
    format!(
        "{} cells, {} elements, {} nodes, {}; smallest angle {}, largest ratio of side to altitude {}, smallest altitude {}",
        mesh.cells.len(),
        4 * mesh.cells.len(),
        mesh.nodes.len(),
        match mesh.blocks.len() {
            1 => "1 block".to_owned(),
            blocks => format!("{blocks} blocks"),
        },
        with("°", quality.smallest_angle),
        at(quality.largest_ratio),
        with(" m", quality.smallest_altitude),
    )
}

/// The part that limits the time step, and its place.
pub fn limit(part: &LimitingPart, cracks: &[CrackScene]) -> String {
    let what = match part.kind {
        PartKind::Element { block } => format!("an element of block {block}"),
        PartKind::Contact { crack } => {
            format!("a contact of {}", cracks.get(crack).map_or_else(String::new, CrackScene::phrase))
        }
    };
    let [x, y] = part.place;
    format!(
        "{what} at ({}, {}) m; {:.2} times as long if all parts were like the median element",
        plain(x),
        plain(y),
        part.slowdown()
    )
}

/// Cost of a short time step, and the remedy.
pub fn slow(part: &LimitingPart, described: &str) -> String {
    let remedy = match part.kind {
        PartKind::Element { .. } => {
            "separate what is close together there (cracks, corners, water level), do not use a smaller `element_size` for cracks there, or \
             improve the mesh"
        }
        PartKind::Contact { .. } => {
            "lower its `normal_stiffness` and `shear_stiffness`, use larger elements along it, or increase the distance to nearby corners"
        }
    };
    format!("one small or stiff part limits the time step of the dam: it is set by {described}; {remedy}")
}

/// Frequencies in a line.
pub fn list(frequencies: &[f64]) -> String {
    let frequencies: Vec<String> = frequencies.iter().map(|f| format!("{f:.2}")).collect();
    frequencies.join(", ")
}

/// Intensity of the records, one line for each component.
pub fn strengths(loaded: &LoadedScene) -> Vec<String> {
    let (shocks, motions) = (loaded.scene.ground_motion.shocks(), loaded.ground_motion.shocks());
    let mut lines = Vec::new();
    for ((shock, motion), begin) in shocks.iter().zip(&motions).zip(loaded.ground_motion.begins()) {
        let (mut name, mut source) = (String::new(), motion.source().to_owned());
        let mut vertical_source =
            motion.vertical().map_or_else(String::new, |vertical| vertical.source().to_owned());
        if motions.len() > 1 {
            name = format!("{} from {begin:.2} s, ", shock.label);
            source = shock.file_name();
            vertical_source = shock.vertical_file_name().unwrap_or_default();
        }
        lines.push(format!("  ground: {name}{}", strength(&source, motion)));
        lines.extend(
            motion.vertical().map(|vertical| {
                format!("  vertical: {name}{}", vertical_strength(&vertical_source, vertical))
            }),
        );
    }
    lines
}

fn vertical_strength(source: &str, vertical: &Component) -> String {
    let [velocity, displacement] = vertical.drift().map(|drift| drift.peak);
    format!(
        "{source}, {:.2} s: at most {:.3} g, {velocity:.3} m/s, {displacement:.3} m",
        vertical.duration(),
        vertical.largest() / STANDARD_GRAVITY,
    )
}

fn strength(source: &str, motion: &GroundMotion) -> String {
    let peak = motion.horizontal().largest();
    let [velocity, displacement] = motion.drift().map(|drift| drift.peak);
    let (intensity, duration) = motion.arias_intensity();
    format!(
        "{source}, {:.2} s: at most {:.3} g, {velocity:.3} m/s, {displacement:.3} m; Arias intensity {intensity:.3} m/s, 5 to 95 % \
         of it within {duration:.2} s",
        motion.horizontal().duration(),
        peak / STANDARD_GRAVITY,
    )
}
