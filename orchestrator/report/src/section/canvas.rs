//! The sheet on which a section is drawn: scale and axes.

use super::{INK, LEFT, Point, TOP, number};
use std::fmt::Write;

/// From metres to pixels, with one scale for both axes.
pub struct Canvas {
    /// Coordinates of the upper left corner of the frame, m.
    pub origin: Point,
    /// Its right edge, m.
    pub right: f64,
    /// Pixels a metre.
    pub scale: f64,
}

impl Canvas {
    pub fn metres(&self, pixels: f64) -> f64 {
        pixels / self.scale
    }

    pub fn place(&self, [x, y]: Point) -> Point {
        [LEFT + self.scale * (x - self.origin[0]), TOP + self.scale * (self.origin[1] - y)]
    }

    /// Frame, numbers and names of the axes.
    pub fn axes(&self, [least, most]: [Point; 2]) -> String {
        let ([left, bottom], [right, top]) = (self.place(least), self.place(most));
        let step = tick((most[0] - least[0]).max(most[1] - least[1]));
        let within = |axis: usize| {
            let numbers = (least[axis] / step).ceil() as i64..=(most[axis] / step).floor() as i64;
            numbers.map(move |number| step * number as f64)
        };
        let mut text = format!(
            "<rect class=\"frame\" x=\"{left:.3}\" y=\"{top:.3}\" width=\"{:.3}\" height=\"{:.3}\" fill=\"none\" stroke=\"{INK}\"/>\n\
             <g class=\"axes\" stroke=\"none\">\n",
            right - left,
            bottom - top
        );
        for x in within(0) {
            let [at, _] = self.place([x, 0.0]);
            let _ = writeln!(
                text,
                "<path stroke=\"{INK}\" d=\"M{at:.2} {bottom:.2}v5\"/><text x=\"{at:.2}\" y=\"{:.2}\" text-anchor=\"middle\">{}</text>",
                bottom + 18.0,
                number(x)
            );
        }
        for y in within(1) {
            let [_, at] = self.place([0.0, y]);
            let _ = writeln!(
                text,
                "<path stroke=\"{INK}\" d=\"M{left:.2} {at:.2}h-5\"/><text x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"end\">{}</text>",
                left - 8.0,
                at + 4.0,
                number(y)
            );
        }
        let (across, up) = ((left + right) / 2.0, (top + bottom) / 2.0);
        let _ = writeln!(
            text,
            "<text x=\"{across:.2}\" y=\"{:.2}\" text-anchor=\"middle\">x downstream of the heel, m</text>\n\
             <text transform=\"translate(16 {up:.2}) rotate(-90)\" text-anchor=\"middle\">y above the heel, m</text>\n</g>",
            bottom + 38.0
        );
        text
    }
}

/// 1, 2 or 5 times a power of ten, of which at most twelve make the `length`.
fn tick(length: f64) -> f64 {
    let power = 10f64.powf((length / 12.0).log10().floor());
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|factor| factor * power)
        .find(|step| length / step <= 12.0)
        .unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round() {
        assert_eq!([103.0, 7.0, 0.5, 240.1].map(tick), [10.0, 1.0, 0.05, 50.0]);
    }
}
