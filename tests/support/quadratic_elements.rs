//! The intact Koyna section with eight-node elements and consistent mass: a discretisation
//! that shares nothing with the dam's.

use crate::frequency_domain::LinearDam;
use crate::koyna;
use cofferdam_unit::WetFace;
use faer::Mat;
use std::collections::HashMap;

const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// Local coordinates of the eight nodes: corners counter-clockwise, then the middles of the sides.
const NODES: [[f64; 2]; 8] =
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]];

/// Shape functions and their local derivatives at (ξ, η).
fn shape([x, y]: [f64; 2]) -> [[f64; 3]; 8] {
    NODES.map(|[a, b]| match (a == 0.0, b == 0.0) {
        (false, false) => {
            let (p, q) = (1.0 + a * x, 1.0 + b * y);
            let n = 0.25 * p * q * (a * x + b * y - 1.0);
            [n, 0.25 * a * q * (2.0 * a * x + b * y), 0.25 * b * p * (a * x + 2.0 * b * y)]
        }
        (true, _) => {
            let q = 1.0 + b * y;
            [0.5 * (1.0 - x * x) * q, -x * q, 0.5 * (1.0 - x * x) * b]
        }
        (_, true) => {
            let p = 1.0 + a * x;
            [0.5 * p * (1.0 - y * y), 0.5 * a * (1.0 - y * y), -p * y]
        }
    })
}

/// The intact Koyna dam with `columns` elements a row and rows of about `size` (m), and its wet face.
pub fn koyna(columns: usize, size: f64, rayleigh: [f64; 2]) -> (LinearDam, WetFace) {
    let mut levels = vec![0.0];
    for (from, to) in [(0.0, koyna::NECK), (koyna::NECK, koyna::DEPTH), (koyna::DEPTH, koyna::CREST)] {
        let rows = ((to - from) / size).round().max(1.0) as usize;
        levels.extend((1..=rows).map(|i| from + (to - from) * i as f64 / rows as f64));
    }
    let rows = levels.len() - 1;
    // Nodes at (half column, half row), centres left out; those of the base are fixed.
    let mut nodes: HashMap<(usize, usize), usize> = HashMap::new();
    let mut coordinates = Vec::new();
    for j in 0..=2 * rows {
        for i in (0..=2 * columns).filter(|i| i % 2 == 0 || j % 2 == 0) {
            let y = if j % 2 == 0 { levels[j / 2] } else { 0.5 * (levels[j / 2] + levels[j / 2 + 1]) };
            // Straight element sides: a middle node lies half way between its corners.
            let x = koyna::width(y) * i as f64 / (2 * columns) as f64;
            nodes.insert((i, j), coordinates.len());
            coordinates.push([x, y]);
        }
    }
    let fixed = 2 * columns + 1;
    let free = 2 * (coordinates.len() - fixed);
    let dof = |node: usize, axis: usize| (node >= fixed).then(|| 2 * (node - fixed) + axis);
    let mut stiffness = Mat::<f64>::zeros(free, free);
    let mut mass = Mat::<f64>::zeros(free, free);
    let mut ground_inertia = [0, 1].map(|_| vec![0.0; free]);
    let (e, nu, rho) = (koyna::YOUNG_MODULUS, koyna::POISSON_RATIO, koyna::DENSITY);
    let c = e / (1.0 - nu * nu);
    let elasticity = [[c, c * nu, 0.0], [c * nu, c, 0.0], [0.0, 0.0, 0.5 * c * (1.0 - nu)]];
    for row in 0..rows {
        for column in 0..columns {
            let corner = (2 * column + 1, 2 * row + 1);
            let local =
                NODES.map(|[a, b]| nodes[&((corner.0 as f64 + a) as usize, (corner.1 as f64 + b) as usize)]);
            for (x, wx) in GAUSS {
                for (y, wy) in GAUSS {
                    let shapes = shape([x, y]);
                    let mut jacobian = [[0.0; 2]; 2];
                    for (n, node) in shapes.iter().zip(local) {
                        for axis in 0..2 {
                            jacobian[0][axis] += n[1] * coordinates[node][axis];
                            jacobian[1][axis] += n[2] * coordinates[node][axis];
                        }
                    }
                    let det = jacobian[0][0] * jacobian[1][1] - jacobian[0][1] * jacobian[1][0];
                    let weight = wx * wy * det;
                    let gradient = shapes.map(|n| {
                        [
                            (jacobian[1][1] * n[1] - jacobian[0][1] * n[2]) / det,
                            (jacobian[0][0] * n[2] - jacobian[1][0] * n[1]) / det,
                        ]
                    });
                    // Strain of a unit displacement of a node along an axis.
                    let strain = |n: usize, axis: usize| {
                        let [dx, dy] = gradient[n];
                        if axis == 0 { [dx, 0.0, dy] } else { [0.0, dy, dx] }
                    };
                    for n in 0..8 {
                        for (axis, ground) in ground_inertia.iter_mut().enumerate() {
                            let Some(i) = dof(local[n], axis) else { continue };
                            let b = strain(n, axis);
                            let stress = elasticity.map(|d| d[0] * b[0] + d[1] * b[1] + d[2] * b[2]);
                            for m in 0..8 {
                                let inertia = rho * shapes[n][0] * shapes[m][0] * weight;
                                ground[i] += inertia;
                                if let Some(j) = dof(local[m], axis) {
                                    mass[(i, j)] += inertia;
                                }
                                for other in 0..2 {
                                    if let Some(j) = dof(local[m], other) {
                                        let b = strain(m, other);
                                        let energy = stress[0] * b[0] + stress[1] * b[1] + stress[2] * b[2];
                                        stiffness[(i, j)] += energy * weight;
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }

    // The wet face: every node of the upstream side up to the water level is a point.
    let face: Vec<usize> = (0..=2 * rows)
        .map(|j| nodes[&(0, j)])
        .take_while(|n| coordinates[*n][1] <= koyna::DEPTH + 1e-9)
        .collect();
    let mut pressure_force = Mat::<f64>::zeros(free, face.len());
    let mut normal = Mat::<f64>::zeros(free, face.len());
    for (point, node) in face.iter().enumerate() {
        if let Some(i) = dof(*node, 0) {
            normal[(i, point)] = 1.0;
        }
    }
    for start in (0..face.len() - 2).step_by(2) {
        let length = coordinates[face[start + 2]][1] - coordinates[face[start]][1];
        for half in 0..2 {
            for (g, w) in GAUSS {
                let eta = 0.5 * (g - 1.0) + half as f64;
                let quadratic = [0.5 * eta * (eta - 1.0), 1.0 - eta * eta, 0.5 * eta * (eta + 1.0)];
                let linear = [(half, 0.5 * (1.0 - g)), (half + 1, 0.5 * (1.0 + g))];
                for (n, shape) in quadratic.iter().enumerate() {
                    let Some(i) = dof(face[start + n], 0) else { continue };
                    for (m, pressure) in linear {
                        pressure_force[(i, start + m)] += shape * pressure * 0.25 * w * length;
                    }
                }
            }
        }
    }
    let wet_face = WetFace::new(face.iter().map(|n| coordinates[*n]).collect()).expect("nodes ascend");
    let crest = [0, 1].map(|axis| dof(nodes[&(0, 2 * rows)], axis).expect("the crest is free"));
    let normals = vec![[1.0, 0.0]; face.len()];
    let dam = LinearDam { stiffness, mass, rayleigh, pressure_force, normal, normals, ground_inertia, crest };
    (dam, wet_face)
}
