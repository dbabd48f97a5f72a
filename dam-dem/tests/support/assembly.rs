//! Structures built of blocks that are meshed one by one, in any position.

use cofferdam_dam::{Block, Geometry, Mesh, Seam, Section};

use super::top;

/// Nodes on the sides of a block that has been placed; base and top run with the block's own x, the others upwards.
#[derive(Clone, Debug)]
pub struct Placed {
    pub block: usize,
    pub base: Vec<usize>,
    pub top: Vec<usize>,
    pub upstream: Vec<usize>,
    pub downstream: Vec<usize>,
}

/// Blocks and seams, as they are added.
#[derive(Clone, Debug)]
pub struct Assembly {
    pub mesh: Mesh,
}

impl Assembly {
    pub fn new() -> Self {
        let (nodes, cells, blocks, seams) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (upstream, downstream, base) = (Vec::new(), Vec::new(), Vec::new());
        Self {
            mesh: Mesh {
                nodes,
                cells,
                blocks,
                seams,
                upstream,
                downstream,
                base,
                ground: 0..0,
                zones: Vec::new(),
            },
        }
    }

    /// Adds the nodes of `part`, a mesh of one block, at their `place`. The place keeps the sense of rotation.
    pub fn add(&mut self, part: &Mesh, place: impl Fn([f64; 2]) -> [f64; 2]) -> Placed {
        let mesh = &mut self.mesh;
        let (nodes, cells) = (mesh.nodes.len(), mesh.cells.len());
        mesh.nodes.extend(part.nodes.iter().map(|&node| place(node)));
        mesh.cells.extend(part.cells.iter().map(|cell| cell.map(|node| node + nodes)));
        // the centre of a cell is the mean of its corners, also if the place is no linear function
        for cell in &mesh.cells[cells..] {
            let mean = |d: usize| cell[..4].iter().map(|&node| mesh.nodes[node][d]).sum::<f64>() / 4.0;
            mesh.nodes[cell[4]] = [mean(0), mean(1)];
        }
        mesh.blocks.push(Block { nodes: nodes..mesh.nodes.len(), cells: cells..mesh.cells.len() });
        mesh.ground = mesh.nodes.len()..mesh.nodes.len();
        let mut highest = top(part);
        highest.sort_by(|&a, &b| part.nodes[a][0].total_cmp(&part.nodes[b][0]));
        let [base, top, upstream, downstream] = [&part.base, &highest, &part.upstream, &part.downstream]
            .map(|side| side.iter().map(|node| node + nodes).collect());
        Placed { block: mesh.blocks.len() - 1, base, top, upstream, downstream }
    }

    /// Adds a seam between two blocks with the chains of their nodes.
    pub fn join(&mut self, crack: usize, below: (usize, &[usize]), above: (usize, &[usize])) {
        let ((below, lower), (above, upper)) = (below, above);
        self.mesh.seams.push(Seam { crack, below, above, lower: lower.to_vec(), upper: upper.to_vec() });
    }
}

/// A rectangle in `rows` and `columns`.
pub fn rectangle(size: [f64; 2], [columns, rows]: [usize; 2]) -> Mesh {
    let levels = (0..=rows).map(|i| size[1] * i as f64 / rows as f64).collect();
    Mesh::mapped(&Section::rectangle(size[0], size[1]), &[levels], columns)
}

/// A section in an unstructured mesh, with `cracks` through it.
pub fn unstructured(section: &Section, cracks: &[Vec<[f64; 2]>], element_size: f64) -> Mesh {
    Mesh::of_section(&Geometry {
        upstream: &section.upstream,
        downstream: &section.downstream,
        galleries: &[],
        cracks,
        zones: &[],
        upstream_levels: &[],
        downstream_levels: &[],
        element_size,
        crack_sizes: &[],
    })
    .expect("the section is meshed")
}

/// A wall of blocks of 1 m, cut by vertical and horizontal cracks through all of it.
pub fn wall(columns: usize, rows: usize, element_size: f64) -> Mesh {
    let [width, height] = [columns, rows].map(|count| count as f64);
    let upright = (1..columns).map(|i| vec![[i as f64, -1.0], [i as f64, height + 1.0]]);
    let level = (1..rows).map(|i| vec![[-1.0, i as f64], [width + 1.0, i as f64]]);
    unstructured(&Section::rectangle(width, height), &upright.chain(level).collect::<Vec<_>>(), element_size)
}

/// Height of the origin of a turned mesh, m: the ground at y = 0 is far below its blocks.
pub const LIFT: f64 = 20.0;

/// A turned, perhaps mirrored position.
#[derive(Clone, Copy, Debug)]
pub struct Position {
    /// Counter-clockwise, rad, after mirroring.
    pub angle: f64,
    /// Whether x is −x before turning.
    pub mirrored: bool,
}

impl Position {
    /// A vector, or a point about the origin, in this position.
    pub fn of(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle.sin_cos();
        let x = if self.mirrored { -x } else { x };
        [cos * x - sin * y, sin * x + cos * y]
    }

    /// The mesh in this position, with its origin at [`LIFT`]. A mirrored cell and a mirrored chain are written the other way round.
    pub fn of_mesh(self, mut mesh: Mesh) -> Mesh {
        for node in &mut mesh.nodes {
            let [x, y] = self.of(*node);
            *node = [x, y + LIFT];
        }
        if self.mirrored {
            mesh.cells.iter_mut().for_each(|cell| *cell = [cell[1], cell[0], cell[3], cell[2], cell[4]]);
            for seam in &mut mesh.seams {
                seam.lower.reverse();
                seam.upper.reverse();
            }
        }
        mesh
    }

    /// Positions in which the tests are run: as built, turned both ways, upside down, and mirrored.
    pub const ALL: [Self; 6] = [
        Self { angle: 0.0, mirrored: false },
        Self { angle: 0.5, mirrored: false },
        Self { angle: -1.2, mirrored: false },
        Self { angle: 2.8, mirrored: false },
        Self { angle: 0.0, mirrored: true },
        Self { angle: 0.7, mirrored: true },
    ];
}

/// How two blocks are meshed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Meshing {
    /// In rows, with the same columns.
    Matching,
    /// In rows, with different columns.
    Different,
    /// Without rows, each block by itself.
    Unstructured,
}

impl Meshing {
    pub const ALL: [Self; 3] = [Self::Matching, Self::Different, Self::Unstructured];
}

/// Every position with one way of meshing, and every way of meshing in one of them.
pub fn cases() -> impl Iterator<Item = (Position, Meshing)> {
    let positions = Position::ALL.into_iter().map(|position| (position, Meshing::Different));
    positions.chain([Meshing::Matching, Meshing::Unstructured].map(|meshing| (Position::ALL[2], meshing)))
}

/// A block of `size` on a block that is 1 m high and `margin` (m) longer at either end; their joint is y = 0.
pub fn two_blocks(size: [f64; 2], margin: f64, meshing: Meshing) -> Mesh {
    let width = size[0] + 2.0 * margin;
    let per_metre = 2.0;
    let columns = |length: f64, per_metre: f64| ((length * per_metre).round() as usize).max(1);
    let [lower, upper] = match meshing {
        Meshing::Matching => [
            rectangle([width, 1.0], [columns(width, per_metre), 2]),
            rectangle(size, [columns(size[0], per_metre), 2]),
        ],
        Meshing::Different => {
            [rectangle([width, 1.0], [columns(width, 1.57), 1]), rectangle(size, [columns(size[0], 1.3), 2])]
        }
        Meshing::Unstructured => [
            unstructured(&Section::rectangle(width, 1.0), &[], 0.45),
            unstructured(&Section::rectangle(size[0], size[1]), &[], 0.33),
        ],
    };
    let mut assembly = Assembly::new();
    let below = assembly.add(&lower, |[x, y]| [x - margin, y - 1.0]);
    let above = assembly.add(&upper, |place| place);
    assembly.join(0, (below.block, &below.top), (above.block, &above.base));
    assembly.mesh
}
