//! Picture of a scene's section to scale, as SVG: dam, mesh, zones, cracks, water, wet points, ground.

use cofferdam_assembly::{Assembly, AssemblyError, Mesh};
mod canvas;

use canvas::Canvas;
use cofferdam_scene::{Scene, Side};
use quick_xml::escape::escape;
use std::collections::BTreeMap;
use std::fmt::Write;

type Point = [f64; 2];

/// Colours that the colour-blind tell apart: M. Okabe and K. Ito, *Color universal design*, 2008.
const COLOURS: [&str; 6] = ["#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#000000"];
/// Dashes of a line after each round of the colours, in its widths.
const DASHES: [&[f64]; 4] = [&[], &[3.0, 1.5], &[1.0, 1.0], &[4.0, 1.5, 1.0, 1.5]];
const WATER: &str = "#cfe4f5";
const INK: &str = "#222222";
const POINTS: &str = "#1f4e79";
const CONCRETE: &str = "#eeece6";
/// Tints of zones, one after the other.
const TINTS: [&str; 6] = ["#e3c9a8", "#c5d3b4", "#d9c0d0", "#b9cdd6", "#ead7d0", "#cfcaa0"];
const GROUND: &str = "#d8cdbd";

/// Largest width and height of the section, pixels.
const SIZE: [f64; 2] = [640.0, 560.0];
/// Margins left, above and below for numbers, title and names of the axes.
const LEFT: f64 = 64.0;
const TOP: f64 = 46.0;
const BELOW: f64 = 52.0;
/// Margin on the right without a legend: half of the last number.
const RIGHT: f64 = 16.0;
/// Width of the legend, and height of its lines.
const LEGEND: [f64; 2] = [300.0, 20.0];
/// Longest text in the legend, characters, and about the width of one.
const LONGEST: usize = 44;
const LETTER: f64 = 7.0;
/// Most elements whose edges are drawn; more would be black.
const MOST_EDGED: usize = 40_000;

/// A line of the legend: a sample, drawn in a box of 26 by 12 pixels, and a text.
struct Explained {
    sample: String,
    text: String,
}

/// Water before a face.
struct Body {
    side: Side,
    level: f64,
    /// Points of the dam at which it exchanges, from the base up, and those of the water, if it has its own.
    points: Vec<Point>,
    own_points: Vec<Point>,
    /// Of the bed, from the base of the face to the end of the picture.
    bed: Vec<Point>,
}

/// What is to be drawn, m.
struct Section {
    mesh: Option<Mesh>,
    /// The dam's, where there is no mesh; of a prescribed dam nothing is known but the face.
    outline: Vec<Point>,
    waters: Vec<Body>,
    ground: Vec<Point>,
    /// Least and largest x and y.
    bounds: [Point; 2],
}

/// The picture of a scene, with its title and a legend on the right.
///
/// **Errors**: the dam's mesh or a wet face cannot be made.
pub fn picture(scene: &Scene) -> Result<String, AssemblyError> {
    drawn(scene, false)
}

/// The same without the title and with the legend below, for a page.
///
/// **Errors**: as of [`picture`].
pub fn figure(scene: &Scene) -> Result<String, AssemblyError> {
    drawn(scene, true)
}

fn drawn(scene: &Scene, narrow: bool) -> Result<String, AssemblyError> {
    let section = Section::of(scene)?;
    let [[x0, y0], [x1, y1]] = section.bounds;
    let scale = (SIZE[0] / (x1 - x0)).min(SIZE[1] / (y1 - y0));
    let canvas = Canvas { origin: [x0, y1], right: x1, scale };
    let [width, height] = [x1 - x0, y1 - y0].map(|length| scale * length);
    let mut legend = Vec::new();
    let shapes = section.draw(scene, &canvas, &mut legend);
    let lines = legend.len() as f64;
    // Beside the section, or in two columns below its axis.
    let [whole, tall] = if narrow {
        [LEFT + width + RIGHT, TOP + height + BELOW + LEGEND[1] * (lines / 2.0).ceil()]
    } else {
        [LEFT + width + 24.0 + LEGEND[0], TOP + height.max(LEGEND[1] * lines) + BELOW]
    };
    let [whole, tall] = [whole, tall].map(f64::ceil);
    let place = |line: usize| match narrow {
        true => {
            [LEFT + width / 2.0 * (line % 2) as f64, TOP + height + BELOW + LEGEND[1] * (line / 2) as f64]
        }
        false => [LEFT + width + 24.0, TOP + LEGEND[1] * line as f64],
    };
    let cut = if narrow { (width / 2.0 / LETTER) as usize - 5 } else { LONGEST };
    let title = escape(&scene.title);
    // A page has a title of its own.
    let top = if narrow { TOP - 10.0 } else { 0.0 };
    // Writing to a string cannot fail.
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 {top} {whole} {}\" width=\"{whole}\" height=\"{}\" \
         font-family=\"sans-serif\" font-size=\"12\" fill=\"{INK}\">\n<title>{title}</title>\n\
         <rect width=\"{whole}\" height=\"{tall}\" fill=\"#ffffff\"/>\n",
        tall - top,
        tall - top
    );
    if !narrow {
        let _ = writeln!(text, "<text x=\"{LEFT}\" y=\"26\" font-size=\"16\">{title}</text>");
    }
    let _ = writeln!(
        text,
        "<clipPath id=\"frame\"><rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{width:.3}\" height=\"{height:.3}\"/></clipPath>"
    );
    text += &shapes;
    text += &canvas.axes(section.bounds);
    for (line, Explained { sample, text: name }) in legend.iter().enumerate() {
        let [x, y] = place(line);
        let name: String = match name.char_indices().nth(cut) {
            Some((end, _)) => format!("{}…", &name[..end]),
            None => name.clone(),
        };
        let _ = writeln!(
            text,
            "<g class=\"legend\" transform=\"translate({x:.2} {y:.2})\">{sample}<text x=\"34\" y=\"10\">{}</text></g>",
            escape(&name)
        );
    }
    Ok(text + "</svg>\n")
}

impl Section {
    fn of(scene: &Scene) -> Result<Self, AssemblyError> {
        let mesh = Assembly::of(scene).dam_mesh()?;
        let outline: Vec<Point> = match &scene.dam {
            Some(dam) => {
                dam.section.upstream.iter().chain(dam.section.downstream.iter().rev()).copied().collect()
            }
            None => Assembly::of(scene).dam_face(Side::Upstream)?.points().to_vec(),
        };
        let over =
            |axis: usize| outline.iter().fold((0.0f64, 0.0f64), |(a, b), p| (a.min(p[axis]), b.max(p[axis])));
        let ((first, last), (_, crest)) = (over(0), over(1));
        let toe = scene.dam.as_ref().and_then(|dam| dam.section.downstream.first()).map_or(0.0, |toe| toe[0]);
        let filled: Vec<Side> =
            scene.waters().filter(|(_, water)| !water.is_empty()).map(|(side, _)| side).collect();
        let room = |side| crest * if filled.contains(&side) { 0.45 } else { 0.15 };
        let [left, right] = [first - room(Side::Upstream), last + room(Side::Downstream)];
        let mut waters = Vec::new();
        for side in filled {
            let (face, own) = (Assembly::of(scene).dam_face(side)?, Assembly::of(scene).water_face(side)?);
            let corners = scene.water(side).map_or(&[][..], |water| &water.bed);
            // As the water sees it, the dam lies downstream of it.
            let bed = match side {
                Side::Upstream => bed(corners, left),
                Side::Downstream => {
                    bed(corners, toe - right).into_iter().map(|[x, y]| [toe - x, y]).collect()
                }
            };
            let own_points = if own.points() == face.points() { Vec::new() } else { own.points().to_vec() };
            waters.push(Body { side, level: face.depth(), points: face.points().to_vec(), own_points, bed });
        }
        let of = |side, end: Point, base: Point| {
            let body: Option<&Body> = waters.iter().find(|body| body.side == side);
            body.map_or_else(|| vec![base, end], |body| body.bed.clone())
        };
        let mut ground = of(Side::Upstream, [left, 0.0], [0.0, 0.0]);
        ground.reverse();
        ground.extend(of(Side::Downstream, [right, 0.0], [toe, 0.0]));
        let lowest = ground.iter().fold(0.0f64, |least, point| least.min(point[1])) - 0.08 * crest;
        ground.extend([[right, lowest], [left, lowest]]);
        let highest = waters.iter().fold(crest, |most, body| most.max(body.level)) + 0.06 * crest;
        let bounds = [[left, lowest], [right, highest]];
        Ok(Self { mesh, outline, waters, ground, bounds })
    }

    fn draw(&self, scene: &Scene, canvas: &Canvas, legend: &mut Vec<Explained>) -> String {
        let px = |pixels: f64| canvas.metres(pixels);
        let (mut shapes, mut labels) = (String::new(), String::new());
        let _ = writeln!(
            shapes,
            "<polygon class=\"ground\" fill=\"{GROUND}\" stroke=\"{INK}\" stroke-width=\"{}\" points=\"{}\"/>",
            px(1.0),
            points(&self.ground)
        );
        for body in &self.waters {
            let table = body.side.table();
            let end = body.bed.last().map_or(0.0, |end| end[0]);
            let outline: Vec<Point> = body.points.iter().chain(&[[end, body.level]]).copied().collect();
            let outline: Vec<Point> = outline.into_iter().chain(body.bed.iter().rev().copied()).collect();
            let _ = writeln!(
                shapes,
                "<polygon class=\"water\" id=\"{table}\" fill=\"{WATER}\" points=\"{}\"/>",
                points(&outline)
            );
            let level = [[end, body.level], body.points.last().copied().unwrap_or([end, body.level])];
            let _ = writeln!(
                shapes,
                "<polyline class=\"level\" stroke=\"{POINTS}\" stroke-width=\"{}\" points=\"{}\"/>",
                px(1.5),
                points(&level)
            );
            let name = if body.side == Side::Upstream { "water" } else { "tailwater" };
            legend.push(Explained { sample: block(WATER), text: format!("{name} up to {} m", body.level) });
        }
        legend.push(Explained { sample: block(GROUND), text: "ground, rigid".to_owned() });
        match &self.mesh {
            Some(mesh) => {
                self.concrete(mesh, scene, canvas, &mut shapes, legend);
                zones(mesh, scene, canvas, [&mut shapes, &mut labels], legend);
                cracks(mesh, scene, canvas, [&mut shapes, &mut labels], legend);
            }
            None => {
                let (closed, text) = match &scene.dam {
                    Some(_) => ("polygon", "dam of another program, without its mesh"),
                    None => ("polyline", "prescribed dam: wet face only"),
                };
                let fill = if scene.dam.is_some() { CONCRETE } else { "none" };
                let _ = writeln!(
                    shapes,
                    "<{closed} class=\"outline\" fill=\"{fill}\" stroke=\"{INK}\" stroke-width=\"{}\" points=\"{}\"/>",
                    px(1.5),
                    points(&self.outline)
                );
                for gallery in scene.dam.iter().flat_map(|dam| &dam.section.galleries) {
                    let _ = writeln!(
                        shapes,
                        "<polygon class=\"gallery\" fill=\"#ffffff\" stroke=\"{INK}\" stroke-width=\"{}\" points=\"{}\"/>",
                        px(1.5),
                        points(gallery)
                    );
                }
                let sample = match &scene.dam {
                    Some(_) => block(fill),
                    None => format!("<path d=\"M0 6h26\" stroke=\"{INK}\" stroke-width=\"1.5\"/>"),
                };
                legend.push(Explained { sample, text: text.to_owned() });
            }
        }
        for (own, fill) in [(false, POINTS), (true, "none")] {
            let of = |body: &Body| if own { body.own_points.clone() } else { body.points.clone() };
            let wet: Vec<Point> = self.waters.iter().flat_map(of).collect();
            let style =
                |unit: f64| format!("fill=\"{fill}\" stroke=\"{POINTS}\" stroke-width=\"{}\"", number(unit));
            let radius = if own { 5.0 } else { 2.4 };
            for [x, y] in &wet {
                let _ = writeln!(
                    shapes,
                    "<circle class=\"{}\" {} cx=\"{}\" cy=\"{}\" r=\"{}\"/>",
                    if own { "own-point" } else { "wet-point" },
                    style(px(0.8)),
                    number(*x),
                    number(*y),
                    px(radius)
                );
            }
            if !wet.is_empty() {
                let whose = if own { "water" } else { "dam" };
                legend.push(Explained {
                    sample: format!("<circle {} cx=\"13\" cy=\"6\" r=\"{radius}\"/>", style(0.8)),
                    text: format!("{} wet points of the {whose}", wet.len()),
                });
            }
        }
        let [x, y] = canvas.origin;
        let scale = canvas.scale;
        format!(
            "<g clip-path=\"url(#frame)\">\n<g id=\"section\" fill=\"none\" stroke-linejoin=\"round\" \
             transform=\"translate({} {}) scale({scale} {})\">\n<desc>x downstream, y up from the heel, m</desc>\n{shapes}</g>\n\
             </g>\n{labels}",
            LEFT - scale * x,
            TOP + scale * y,
            -scale
        )
    }

    /// Elements, and what they end at.
    fn concrete(
        &self,
        mesh: &Mesh,
        scene: &Scene,
        canvas: &Canvas,
        shapes: &mut String,
        legend: &mut Vec<Explained>,
    ) {
        let (mut path, mut count) = (String::new(), 0);
        let mut edges = BTreeMap::<[usize; 2], usize>::new();
        for triangle in mesh.triangles() {
            let [a, b, c] = triangle.map(|node| mesh.nodes[node].map(number));
            let _ = write!(path, "M{} {}L{} {}L{} {}Z", a[0], a[1], b[0], b[1], c[0], c[1]);
            for k in 0..3 {
                let [a, b] = [triangle[k], triangle[(k + 1) % 3]];
                *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
            }
            count += 1;
        }
        let edged = count <= MOST_EDGED;
        let stroke = if edged { "#9a958a" } else { CONCRETE };
        let thin = canvas.metres(0.4);
        let _ = writeln!(
            shapes,
            "<path class=\"mesh\" fill=\"{CONCRETE}\" stroke=\"{stroke}\" stroke-width=\"{thin}\" d=\"{path}\"/>"
        );
        let mut rim = String::new();
        for ([a, b], _) in edges.into_iter().filter(|(_, times)| *times == 1) {
            let [a, b] = [a, b].map(|node| mesh.nodes[node].map(number));
            let _ = write!(rim, "M{} {}L{} {}", a[0], a[1], b[0], b[1]);
        }
        let _ = writeln!(
            shapes,
            "<path class=\"rim\" stroke=\"{INK}\" stroke-width=\"{}\" stroke-linecap=\"round\" d=\"{rim}\"/>",
            canvas.metres(1.2)
        );
        let edged = if edged { "" } else { ", too many to draw" };
        let size = scene.dam.as_ref().map_or(0.0, |dam| dam.element_size);
        let text = format!("concrete: {count} elements of about {size} m{edged}");
        legend.push(Explained { sample: block(CONCRETE), text });
    }
}

/// The zones, each with its name at its centroid.
fn zones(
    mesh: &Mesh,
    scene: &Scene,
    canvas: &Canvas,
    [shapes, labels]: [&mut String; 2],
    legend: &mut Vec<Explained>,
) {
    let zones = scene.dam.as_ref().map_or(&[][..], |dam| &dam.zones);
    for (index, zone) in zones.iter().enumerate() {
        let (tint, name) = (TINTS[index % TINTS.len()], escape(&zone.name));
        let (mut path, mut sum) = (String::new(), [0.0; 3]);
        let own = mesh.cells.iter().enumerate().filter(|(cell, _)| mesh.zone_of(*cell) == Some(index));
        for (_, corners) in own {
            let [a, b, c, d, centre] = corners.map(|node| mesh.nodes[node]);
            let area = 0.5 * ((c[0] - a[0]) * (d[1] - b[1]) - (d[0] - b[0]) * (c[1] - a[1]));
            sum = [sum[0] + area * centre[0], sum[1] + area * centre[1], sum[2] + area];
            for (k, point) in [a, b, c, d].into_iter().enumerate() {
                let [x, y] = point.map(number);
                let _ = write!(path, "{}{x} {y}", if k == 0 { 'M' } else { 'L' });
            }
            path.push('Z');
        }
        let _ = writeln!(
            shapes,
            "<path class=\"zone\" fill=\"{tint}\" fill-opacity=\"0.6\" d=\"{path}\"><title>{name}</title></path>"
        );
        let [x, y] = canvas.place([sum[0] / sum[2], sum[1] / sum[2]]);
        let _ = writeln!(
            labels,
            "<text class=\"zone-name\" x=\"{x:.2}\" y=\"{y:.2}\" text-anchor=\"middle\" stroke=\"#ffffff\" \
             stroke-width=\"3\" paint-order=\"stroke\">{name}</text>"
        );
        let dam = scene.dam.as_ref().map(|dam| zone.material(&dam.material));
        let of = dam.map_or(String::new(), |material| {
            format!(": {} GPa, {} kg/m³", number(material.young_modulus / 1e9), number(material.density))
        });
        legend.push(Explained { sample: block(tint), text: format!("zone: {}{of}", zone.name) });
    }
}

/// The cracks, each with its name at its downstream end.
fn cracks(
    mesh: &Mesh,
    scene: &Scene,
    canvas: &Canvas,
    [shapes, labels]: [&mut String; 2],
    legend: &mut Vec<Explained>,
) {
    let parameters = scene.dam.as_ref().map_or(&[][..], |dam| &dam.cracks);
    let mut ends = Vec::new();
    for (index, crack) in parameters.iter().enumerate() {
        let colour = COLOURS[index % COLOURS.len()];
        let dash = |width: f64| {
            let lengths = DASHES[(index / COLOURS.len()) % DASHES.len()].iter();
            let lengths: Vec<String> = lengths.map(|length| number(width * length).to_string()).collect();
            let dashes = if lengths.is_empty() { "none".to_owned() } else { lengths.join(" ") };
            format!("stroke=\"{colour}\" stroke-width=\"{}\" stroke-dasharray=\"{dashes}\"", number(width))
        };
        let label = crack.label();
        let _ = writeln!(
            shapes,
            "<g class=\"crack\" {}><title>{}</title>",
            dash(canvas.metres(2.6)),
            escape(&label)
        );
        let mut end: Option<Point> = None;
        for seam in mesh.seams.iter().filter(|seam| seam.crack == index) {
            // The lower side of a joint along the base continues beyond heel and toe.
            let chain: Vec<Point> = seam.upper.iter().map(|&node| mesh.nodes[node]).collect();
            let _ = writeln!(shapes, "<polyline points=\"{}\"/>", points(&chain));
            end = chain.into_iter().chain(end).max_by(|a, b| a[0].total_cmp(&b[0]));
        }
        shapes.push_str("</g>\n");
        ends.extend(end.map(|end| (canvas.place(end), label.clone())));
        let sample = format!("<line x1=\"0\" y1=\"6\" x2=\"26\" y2=\"6\" {}/>", dash(2.6));
        legend.push(Explained { sample, text: format!("crack: {label}") });
    }
    let [right, _] = canvas.place([canvas.right, 0.0]);
    // From below upwards, apart by a line.
    ends.sort_by(|(a, _), (b, _)| b[1].total_cmp(&a[1]));
    let mut free = f64::INFINITY;
    for ([x, y], label) in ends {
        let x = (x + 6.0).min(right - LETTER * label.chars().count() as f64).max(LEFT);
        let y = (y - 4.0).min(free);
        free = y - 14.0;
        let _ = writeln!(
            labels,
            "<text class=\"name\" x=\"{x:.2}\" y=\"{y:.2}\" stroke=\"#ffffff\" stroke-width=\"3\" paint-order=\"stroke\">{}</text>",
            escape(&label)
        );
    }
}

/// The bed with these corners as the water sees it, from the face at 0 upstream to x = `end`, beyond its last corner level.
fn bed(corners: &[Point], end: f64) -> Vec<Point> {
    let mut bed: Vec<Point> = vec![[0.0, 0.0]];
    let mut from = [0.0, 0.0];
    for &corner in corners {
        if corner[0] <= end {
            let share = (end - from[0]) / (corner[0] - from[0]);
            bed.push([end, from[1] + share * (corner[1] - from[1])]);
            return bed;
        }
        bed.push(corner);
        from = corner;
    }
    bed.push([end, from[1]]);
    bed
}

/// A box of the legend.
fn block(fill: &str) -> String {
    format!("<rect width=\"26\" height=\"12\" fill=\"{fill}\" stroke=\"{INK}\" stroke-width=\"0.6\"/>")
}

/// A length to a tenth of a millimetre.
fn number(value: f64) -> f64 {
    // No -0.
    (value * 1e4).round() / 1e4 + 0.0
}

fn points(of: &[Point]) -> String {
    let pairs: Vec<String> = of.iter().map(|[x, y]| format!("{},{}", number(*x), number(*y))).collect();
    pairs.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bed_ends_where_the_picture_does() {
        assert_eq!(bed(&[], -40.0), [[0.0, 0.0], [-40.0, 0.0]]);
        assert_eq!(bed(&[[-80.0, 20.0]], -40.0), [[0.0, 0.0], [-40.0, 10.0]]);
        assert_eq!(bed(&[[-20.0, 5.0]], -40.0), [[0.0, 0.0], [-20.0, 5.0], [-40.0, 5.0]]);
    }
}
