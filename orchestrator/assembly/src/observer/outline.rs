//! The outline of the dam's blocks, and its motion during a run.

use crate::observer::Histories;
use crate::observer::histories::Table;
use crate::observer::snapshots::{multiples, pairs};
use crate::units::DAM;
use cofferdam_coupling::observer::{Ending, Observer, ObserverError, Start};
use cofferdam_coupling::participant::{Participant, ParticipantError};
use cofferdam_coupling::scheme::{Graph, WindowReport};
use cofferdam_log::results_file::{ResultsFile, write_error};
use std::collections::{BTreeMap, BTreeSet};
use std::iter::once;
use std::path::{Path, PathBuf};

/// Shortest time from one row to the next, s: the first mode of a dam of 100 m has ten or more in a period.
const INTERVAL: f64 = 0.025;
/// Most rows of a run that comes to its planned end; the time between rows follows.
const ROWS: f64 = 1000.0;
/// Points are left out on sides of the outline where they are closer than this part of its length.
const PARTS: f64 = 80.0;
/// Sine of the angle from which a point is a corner.
const CORNER: f64 = 1e-3;

type Point = [f64; 2];

/// The closed polygons around the dam's blocks and galleries; both sides of a crack are parts of them.
#[derive(Default)]
struct Outline {
    /// Nodes of each polygon that are shown; the concrete lies on the left.
    loops: Vec<Vec<usize>>,
    /// The same as points in the unloaded position, m.
    points: Vec<Vec<Point>>,
}

impl Outline {
    /// That of `dam`, in corners and some of the nodes between them; empty where the dam tells no mesh, or one that cannot be.
    ///
    /// **Errors**: the dam cannot be read.
    fn of(dam: &mut dyn Participant) -> Result<Self, ParticipantError> {
        let readable = &dam.description().readable;
        if ["node_x", "triangle_node_1", "node_displacement_x"]
            .iter()
            .any(|name| readable.range(name).is_none())
        {
            return Ok(Self::default());
        }
        let nodes = pairs(dam, "node_x", "node_y")?;
        let firsts = pairs(dam, "triangle_node_1", "triangle_node_2")?;
        let thirds = dam.read("triangle_node_3")?;
        let triangles: Vec<[usize; 3]> =
            firsts.iter().zip(thirds).map(|([a, b], c)| [*a, *b, c].map(|node| node as usize)).collect();
        if triangles.iter().flatten().any(|node| *node >= nodes.len()) {
            return Ok(Self::default());
        }
        let whole = loops(&triangles);
        let length: f64 = whole.iter().flat_map(|of| sides(of, &nodes)).sum();
        let loops: Vec<Vec<usize>> = whole.iter().map(|of| shown(of, &nodes, length / PARTS)).collect();
        let points = loops.iter().map(|of| of.iter().map(|node| nodes[*node]).collect()).collect();
        Ok(Self { loops, points })
    }
}

/// The sides that only one triangle has, as closed polygons.
fn loops(triangles: &[[usize; 3]]) -> Vec<Vec<usize>> {
    let mut sides = BTreeSet::<[usize; 2]>::new();
    for [a, b, c] in triangles {
        for side in [[*a, *b], [*b, *c], [*c, *a]] {
            if !sides.remove(&[side[1], side[0]]) {
                sides.insert(side);
            }
        }
    }
    let mut next = BTreeMap::<usize, Vec<usize>>::new();
    sides.iter().for_each(|[from, to]| next.entry(*from).or_default().push(*to));
    let mut found = Vec::new();
    while let Some(first) = next.first_key_value().map(|(node, _)| *node) {
        let (mut polygon, mut node) = (Vec::new(), first);
        // Where polygons touch in a node, any of the ways on closes one.
        while let Some(ways) = next.get_mut(&node) {
            polygon.push(node);
            let on = ways.pop();
            if ways.is_empty() {
                next.remove(&node);
            }
            match on {
                Some(on) if on != first => node = on,
                _ => break,
            }
        }
        found.push(polygon);
    }
    found
}

/// Lengths of the sides of a polygon, each from the node before.
fn sides<'a>(polygon: &'a [usize], nodes: &'a [Point]) -> impl Iterator<Item = f64> + 'a {
    let before = polygon.iter().cycle().skip(polygon.len().saturating_sub(1));
    before.zip(polygon).map(|(a, b)| (nodes[*b][0] - nodes[*a][0]).hypot(nodes[*b][1] - nodes[*a][1]))
}

/// The corners of a polygon, and points between them that are at least `spacing` (m) from the one before.
fn shown(polygon: &[usize], nodes: &[Point], spacing: f64) -> Vec<usize> {
    let count = polygon.len();
    let turns = |index: usize| {
        let [a, b, c] = [count - 1, 0, 1].map(|shift| nodes[polygon[(index + shift) % count]]);
        let ([ux, uy], [vx, vy]) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
        let (across, along) = (ux * vy - uy * vx, ux * vx + uy * vy);
        across.abs() > CORNER * ux.hypot(uy) * vx.hypot(vy) || along < 0.0
    };
    let mut kept = Vec::new();
    let mut passed = f64::INFINITY;
    for (index, side) in sides(polygon, nodes).enumerate() {
        passed += side;
        if turns(index) || passed >= spacing {
            kept.push(polygon[index]);
            passed = 0.0;
        }
    }
    kept
}

/// Writes the motion of the outline of the dam as `outline.csv`, for pictures of the dam in motion: the closed polygons around its
/// blocks and galleries, in corners and some of the nodes between them.
///
/// Columns: `time [s]`, then for each point of the outline, polygon after polygon as the manifest has them, `POINT.x [m]` and `POINT.y [m]`:
/// its displacement since time 0, rounded to 0.1 µm. A row at the first end of a communication step at or after each multiple of 25 ms,
/// or of a thousandth of a run that is longer than 25 s. A resumed run continues with the rows of before; those of a branch begin where
/// it leaves the other run.
pub struct OutlineWriter {
    path: PathBuf,
    outline: Outline,
    interval: f64,
    header: Vec<String>,
    /// Number of the next multiple of the interval.
    next: u64,
    /// End of the last accepted step, s.
    time: f64,
    /// Rows of the run that this one continues, and how many of them it has passed.
    earlier: Vec<Vec<f64>>,
    passed: usize,
    table: Option<Table>,
}

impl OutlineWriter {
    /// Name of the file.
    pub const FILE: &'static str = "outline.csv";

    /// Writes into `folder`, once it has [found](Self::find) an outline.
    pub fn new(folder: &Path) -> Self {
        Self {
            path: folder.join(Self::FILE),
            outline: Outline::default(),
            interval: INTERVAL,
            header: Vec::new(),
            next: 0,
            time: 0.0,
            earlier: Vec::new(),
            passed: 0,
            table: None,
        }
    }

    /// The outline of `dam`: the points of each polygon in the unloaded position (x, y), m; none where the dam tells no mesh.
    ///
    /// **Errors**: the dam cannot be read.
    pub fn find(&mut self, dam: &mut dyn Participant) -> Result<&[Vec<[f64; 2]>], ParticipantError> {
        self.outline = Outline::of(dam)?;
        Ok(&self.outline.points)
    }

    /// Begins the file with the rows of before. One that is there stays whole until then: a resumed run may be killed too.
    fn open(&self) -> Result<Table, ObserverError> {
        let draft = self.path.with_extension("csv.part");
        let failed = |cause| write_error(self.path.clone(), cause);
        let file = ResultsFile::create(&draft).map_err(failed)?.or(&self.path);
        let mut table = Table::of(file, self.path.clone(), &self.header)?;
        for row in &self.earlier[..self.passed] {
            table.write(row)?;
        }
        table.flush()?;
        std::fs::rename(draft, &self.path).map_err(failed)?;
        Ok(table)
    }
}

impl Observer for OutlineWriter {
    fn begin(&mut self, start: &Start<'_>) -> Result<(), ObserverError> {
        self.interval = INTERVAL.max(start.stepping.end() / ROWS);
        let count = self.outline.points.iter().map(Vec::len).sum::<usize>();
        let axes = (0..count).flat_map(|point| ["x", "y"].map(|axis| format!("{point}.{axis} [m]")));
        self.header = once("time [s]".to_owned()).chain(axes).collect();
        // Of a run that is resumed; the folder of a new one is empty.
        if let Ok(before) = Histories::read(&self.path)
            && before.names() == self.header
        {
            self.earlier = (0..before.rows()).map(|row| before.row(row)).collect();
        }
        Ok(())
    }

    fn window(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        if report.is_accepted()
            && let Some(step) = report.steps.last()
        {
            self.time = (step.end() * 1e12).round() / 1e12;
        }
        Ok(())
    }

    fn past(&mut self, report: &WindowReport) -> Result<(), ObserverError> {
        self.window(report)?;
        self.next = multiples(self.interval, self.time) + 1;
        while self.earlier.get(self.passed).is_some_and(|row| row[0] <= self.time) {
            self.passed += 1;
        }
        Ok(())
    }

    fn inspect(&mut self, graph: &mut Graph) -> Result<(), ObserverError> {
        let number = multiples(self.interval, self.time);
        if self.outline.points.is_empty() || number < self.next {
            return Ok(());
        }
        self.next = number + 1;
        let (dam, nodes) = (&mut graph[DAM], self.outline.loops.concat());
        let x = dam.read_at("node_displacement_x", &nodes)?;
        let y = dam.read_at("node_displacement_y", &nodes)?;
        let moved = x.into_iter().zip(y).flat_map(|(x, y)| [x, y]);
        let row: Vec<f64> = once(self.time).chain(moved.map(|moved| (moved * 1e7).round() / 1e7)).collect();
        let mut table = match self.table.take() {
            Some(table) => table,
            None => self.open()?,
        };
        table.write(&row)?;
        // Whoever continues from a checkpoint finds all rows before it.
        table.flush()?;
        self.table = Some(table);
        Ok(())
    }

    fn end(&mut self, _ending: &Ending) -> Result<(), ObserverError> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares of two triangles each, the right one of nodes of its own, and one that touches the left in a node only.
    #[test]
    fn loops_go_around_blocks_and_leave_them_on_the_left() {
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7], [2, 8, 9]];
        let mut found = loops(&triangles);
        found.sort();
        let corners: Vec<usize> = found.iter().map(Vec::len).collect();
        assert!(corners == [7, 4] || corners == [4, 3, 4], "{found:?}");
        let count: usize = corners.iter().sum();
        assert_eq!(count, 11, "every side once");
        let follows = |a: usize, b: usize| {
            found.iter().any(|of| (0..of.len()).any(|i| of[i] == a && of[(i + 1) % of.len()] == b))
        };
        for [a, b] in [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [7, 4], [2, 8], [8, 9], [9, 2]] {
            assert!(follows(a, b) && !follows(b, a), "{a} to {b} in {found:?}");
        }
    }

    #[test]
    fn corners_stay_and_points_on_sides_keep_their_distance() {
        // A square of 4 m with a point every metre, a slit of no width in its right side.
        let mut nodes: Vec<Point> = (0..4).map(|i| [f64::from(i), 0.0]).collect();
        nodes.extend([[4.0, 0.0], [4.0, 1.0], [4.0, 2.0], [3.0, 2.0], [4.0, 2.0], [4.0, 3.0]]);
        nodes.extend((0..4).map(|i| [4.0 - f64::from(i), 4.0]));
        nodes.extend((0..4).map(|i| [0.0, 4.0 - f64::from(i)]));
        let polygon: Vec<usize> = (0..nodes.len()).collect();
        let kept = |spacing: f64| shown(&polygon, &nodes, spacing);
        assert_eq!(kept(0.5), polygon);
        // Corners 0, 4, 6, 7, 8, 10, 14; node 2, 2 m from a corner; 12; 16.
        assert_eq!(kept(2.0), [0, 2, 4, 6, 7, 8, 10, 12, 14, 16]);
        assert_eq!(kept(100.0), [0, 4, 6, 7, 8, 10, 14]);
        // The faint kink of a batter of 1 to 20, that of Pine Flat's upstream face, at a third of the height.
        nodes.truncate(4);
        nodes.extend([[4.0, 0.0], [4.0, 4.0], [0.1, 4.0], [0.1, 3.0], [0.1, 2.0], [0.05, 1.0]]);
        let polygon: Vec<usize> = (0..nodes.len()).collect();
        assert_eq!(shown(&polygon, &nodes, 100.0), [0, 4, 5, 6, 8]);
    }
}
