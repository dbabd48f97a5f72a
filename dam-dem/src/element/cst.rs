use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::Arc;

use pulp::Arch;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::batch::{Batch, ViscousStress};
use super::evaluation::{Deformation, Energy, Evaluation, Moduli, ModuliOf};
use super::parts::{Part, Parts};
use crate::damping::StiffnessDamping;
use crate::lanes::Lanes;
use crate::{DamError, Kinematics, Material, Materials, Mesh};

/// Cells of four constant-strain triangles each (crossed diagonals).
///
/// Triangle k has the corners k, k+1 and the centre c. With `h` the displacement gradient,
///
/// ```text
/// h = (u_k − u_c) ⊗ ∇N_k + (u_{k+1} − u_c) ⊗ ∇N_{k+1},   F = I + h
/// ```
///
/// *Small strain*: `ε = sym h`. *Corotational*: `F = R U` in closed form, with `a = F₁₁+F₂₂`, `b = F₂₁−F₁₂`,
/// `r = √(a² + b²)`, `cos θ = a/r`, `sin θ = b/r`, and the Biot strain `ε = U − I`, computed from h and
/// `1 − cos θ = b²/r(r+a)` to avoid the loss of digits in `U − I`, beyond a quarter turn `(r−a)/r`.
/// The energy is `W = A/2 ε : D : ε`. Because D is isotropic, the stress `σ = D : ε` and U
/// have the same principal axes, so that `P = ∂W/∂F / A = R σ`, and `f_i = −A P ∇N_i` is the exact gradient
/// of the energy.
///
/// Stiffness damping adds `β D : ε̇` to σ, with `ε̇ = sym(Rᵀ Ḟ)`; its power `A β ε̇ : D : ε̇` is
/// never negative. In a strained element that rotates, ε̇ differs from U̇ by a term of the order of
/// (strain × spin), which is negligible in a dam.
#[derive(Clone, Debug)]
pub struct CrossedCells {
    batches: Vec<Batch>,
    parts: Parts,
    /// Threads that evaluate the parts; without them the caller does.
    pool: Option<Arc<ThreadPool>>,
    kinematics: Kinematics,
    /// One of the whole dam, or those of each batch.
    moduli: CellModuli,
}

/// Moduli as the cells hold them.
#[derive(Clone, Debug)]
enum CellModuli {
    All(Moduli),
    Batches(Vec<Moduli<Lanes>>),
}

impl CellModuli {
    /// Those of some batches.
    fn of(&self, batches: Range<usize>) -> ModuliOf<'_> {
        match self {
            Self::All(moduli) => ModuliOf::All(*moduli),
            Self::Batches(all) => ModuliOf::Batches(&all[batches]),
        }
    }

    /// Those of a cell, given its batch and lane.
    fn of_cell(&self, (batch, lane): (usize, usize)) -> Moduli {
        match self {
            Self::All(moduli) => *moduli,
            Self::Batches(all) => {
                let Moduli { lambda, twice_shear } = &all[batch];
                Moduli { lambda: lambda[lane], twice_shear: twice_shear[lane] }
            }
        }
    }
}

/// Consecutive parts, with the damping stresses from the first batch of the first part on, and the forces
/// from its first node on.
struct Share<'a> {
    parts: &'a [Part],
    viscous: &'a mut [ViscousStress],
    forces: &'a mut [[f64; 2]],
}

impl CrossedCells {
    /// The cells of `mesh`.
    pub fn new(mesh: &Mesh, materials: &Materials, kinematics: Kinematics) -> Self {
        let batches = Batch::of(mesh);
        let of = |material: &Material| Moduli {
            lambda: material.plane_lambda(),
            twice_shear: 2.0 * material.shear_modulus(),
        };
        let of_batch = |batch: usize| {
            let mut moduli = Moduli::<Lanes>::default();
            let Batch { first_cell, cells, .. } = &batches[batch];
            for lane in 0..cells.len() {
                let Moduli { lambda, twice_shear } = of(materials.of_cell(mesh, first_cell + lane));
                (moduli.lambda[lane], moduli.twice_shear[lane]) = (lambda, twice_shear);
            }
            moduli
        };
        let moduli = match materials.of_zones.is_empty() {
            true => CellModuli::All(of(&materials.general)),
            false => CellModuli::Batches((0..batches.len()).map(of_batch).collect()),
        };
        Self { parts: Parts::of(&batches), batches, pool: None, kinematics, moduli }
    }

    /// The same cells, evaluated on `threads` threads if there are enough cells for this to be faster (from about
    /// twenty thousand triangles on). Results are the same, bit for bit, with any number of threads.
    ///
    /// **Errors**: [`DamError::Threads`].
    pub fn on_threads(mut self, threads: NonZeroUsize) -> Result<Self, DamError> {
        let wanted = threads.get().min(self.parts.parts.len());
        self.pool = match wanted {
            1 => None,
            _ => Some(Arc::new(ThreadPoolBuilder::new().num_threads(wanted).build()?)),
        };
        Ok(self)
    }

    /// Runs `many` evaluations inside the thread pool, if there is one, so that the threads are not woken for each of
    /// them.
    pub(crate) fn among_threads<R: Send>(&self, many: impl FnOnce() -> R + Send) -> R {
        match &self.pool {
            Some(pool) => pool.install(many),
            None => many(),
        }
    }

    /// Number of parts that can be evaluated in parallel.
    pub(crate) fn part_count(&self) -> usize {
        self.parts.parts.len()
    }

    /// Both results, computed in parallel if there are threads. Must be called inside
    /// [`among_threads`](Self::among_threads).
    pub(crate) fn both<R: Send>(
        &self,
        first: impl FnOnce() -> R + Send,
        second: impl FnOnce() -> R + Send,
    ) -> [R; 2] {
        let (first, second) = match &self.pool {
            Some(_) => rayon::join(first, second),
            None => (first(), second()),
        };
        [first, second]
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.batches.iter().map(|batch| 4 * batch.cells.len()).sum()
    }

    /// Damping stresses of 0 in all cells.
    pub fn viscous_at_rest(&self) -> Vec<ViscousStress> {
        vec![ViscousStress::default(); self.batches.len()]
    }

    /// Adds the forces of stress and of stiffness damping to `forces`. Returns the power of damping, W/m,
    /// with the mean damping stress of the step that ends here: `A ½(σ_before + σ_now) : ε̇`.
    ///
    /// **Shapes and units**: `displacement` (m), `velocity` (m/s) and `forces` (N/m) hold one pair
    /// for each node; `damping` is β (s), with or without memory; `viscous` holds the damping stresses of each
    /// batch of cells, the previous ones on entry and the current ones on return.
    pub fn add_forces(
        &self,
        displacement: &[[f64; 2]],
        velocity: &[[f64; 2]],
        damping: impl Into<StiffnessDamping>,
        viscous: &mut [ViscousStress],
        forces: &mut [[f64; 2]],
    ) -> f64 {
        let of = Deformation { displacement, velocity, damping: damping.into() };
        match (self.kinematics, of.damping.coefficient != 0.0) {
            (Kinematics::Corotational, true) => self.evaluate::<true, true>(of, viscous, forces),
            (Kinematics::Corotational, false) => self.evaluate::<true, false>(of, viscous, forces),
            (Kinematics::Small, true) => self.evaluate::<false, true>(of, viscous, forces),
            (Kinematics::Small, false) => self.evaluate::<false, false>(of, viscous, forces),
        }
    }

    /// Evaluates the parts, in parallel if there are threads, and then the seams.
    fn evaluate<const COROTATIONAL: bool, const DAMPED: bool>(
        &self,
        of: Deformation<'_>,
        viscous: &mut [ViscousStress],
        forces: &mut [[f64; 2]],
    ) -> f64 {
        let Parts { parts, seams } = &self.parts;
        let share = Share { parts, viscous: &mut *viscous, forces: &mut *forces };
        let mut power = self.among_threads(|| self.evaluate_parts::<COROTATIONAL, DAMPED>(of, share));
        for seam in seams {
            power += Arch::new().dispatch(Evaluation::<COROTATIONAL, DAMPED> {
                moduli: self.moduli.of(seam.clone()),
                of,
                batches: &self.batches[seam.clone()],
                viscous: if DAMPED { &mut viscous[seam.clone()] } else { &mut [] },
                forces,
                first_node: 0,
            });
        }
        power
    }

    fn evaluate_parts<const COROTATIONAL: bool, const DAMPED: bool>(
        &self,
        of: Deformation<'_>,
        share: Share<'_>,
    ) -> f64 {
        let Share { parts, viscous, forces } = share;
        let (left, right) = parts.split_at(parts.len() / 2);
        if let ([first, ..], [middle, ..]) = (left, right) {
            let (of_left, of_right) =
                viscous.split_at_mut(if DAMPED { middle.batches.start - first.batches.start } else { 0 });
            let (to_left, to_right) = forces.split_at_mut(middle.first_node - first.first_node);
            let left = Share { parts: left, viscous: of_left, forces: to_left };
            let right = Share { parts: right, viscous: of_right, forces: to_right };
            let [left, right] = self.both(
                || self.evaluate_parts::<COROTATIONAL, DAMPED>(of, left),
                || self.evaluate_parts::<COROTATIONAL, DAMPED>(of, right),
            );
            return left + right;
        }
        let [part] = right else { return 0.0 };
        Arch::new().dispatch(Evaluation::<COROTATIONAL, DAMPED> {
            moduli: self.moduli.of(part.batches.clone()),
            of,
            batches: &self.batches[part.batches.clone()],
            viscous,
            forces,
            first_node: part.first_node,
        })
    }

    /// Adds `−K u`, with the stiffness of the unstrained state, to `forces`; shapes as in
    /// [`add_forces`](Self::add_forces).
    pub fn add_linear_forces(&self, displacement: &[[f64; 2]], forces: &mut [[f64; 2]]) {
        let of = Deformation { displacement, velocity: displacement, damping: 0.0.into() };
        self.evaluate::<false, false>(of, &mut [], forces);
    }

    /// Strain energy, J/m, without the work of damping.
    pub fn strain_energy(&self, displacement: &[[f64; 2]]) -> f64 {
        let (moduli, batches) = (self.moduli.of(0..self.batches.len()), &self.batches[..]);
        match self.kinematics {
            Kinematics::Corotational => {
                Arch::new().dispatch(Energy::<true> { moduli, batches, displacement })
            }
            Kinematics::Small => Arch::new().dispatch(Energy::<false> { moduli, batches, displacement }),
        }
    }

    /// Stress (xx, yy, xy; tension positive, Pa) in `triangle` of the mesh, whose nodes are displaced by `u`
    /// (m). With corotational `kinematics` the stress rotates with the triangle.
    pub fn stress(&self, triangle: usize, u: [[f64; 2]; 3], kinematics: Kinematics) -> [f64; 3] {
        let (cell, k) = (triangle / 4, triangle % 4);
        let (batch, lane) = Batch::place_of(&self.batches, cell);
        let [a, b] = self.batches[batch].gradients_of(k, lane);
        let apart = |corner: usize| [u[corner][0] - u[2][0], u[corner][1] - u[2][1]];
        let (p, q) = (apart(0), apart(1));
        let h = |i: usize, j: usize| p[i] * a[j] + q[i] * b[j];
        self.stress_of(cell, [[h(0, 0), h(0, 1)], [h(1, 0), h(1, 1)]], kinematics)
    }

    /// Stress (xx, yy, xy; tension positive, Pa) of the displacement gradient `h[i][j] = ∂u_i/∂x_j` in a `cell`.
    pub fn stress_of(&self, cell: usize, h: [[f64; 2]; 2], kinematics: Kinematics) -> [f64; 3] {
        let (cos, sin) = match kinematics {
            Kinematics::Small => (1.0, 0.0),
            Kinematics::Corotational => {
                let (sine, cosine) = (h[1][0] - h[0][1], 2.0 + h[0][0] + h[1][1]);
                let stretch = (sine * sine + cosine * cosine).sqrt();
                (cosine / stretch, sine / stretch)
            }
        };
        // U − 1 = sym(Rᵀ F) − 1
        let xx = cos * (1.0 + h[0][0]) + sin * h[1][0] - 1.0;
        let yy = cos * (1.0 + h[1][1]) - sin * h[0][1] - 1.0;
        let xy = (cos * (h[0][1] + h[1][0]) + sin * (h[1][1] - h[0][0])) / 2.0;
        let Moduli { lambda, twice_shear } = self.moduli.of_cell(Batch::place_of(&self.batches, cell));
        let volumetric = lambda * (xx + yy);
        let [s, t, r] = [volumetric + twice_shear * xx, volumetric + twice_shear * yy, twice_shear * xy];
        [
            cos * cos * s + sin * sin * t - 2.0 * sin * cos * r,
            sin * sin * s + cos * cos * t + 2.0 * sin * cos * r,
            sin * cos * (s - t) + (cos * cos - sin * sin) * r,
        ]
    }

    /// The triangles: nodes (two corners, then the centre), area (m²), gradients of their shape
    /// functions (1/m).
    pub fn triangles(&self) -> impl Iterator<Item = ([usize; 3], f64, [[f64; 2]; 3])> + '_ {
        self.batches.iter().flat_map(|batch| {
            batch.cells.iter().enumerate().flat_map(move |(lane, nodes)| {
                (0..4).map(move |k| {
                    let [a, b] = batch.gradients_of(k, lane);
                    let corners = [nodes[k], nodes[(k + 1) % 4], nodes[4]];
                    (corners, batch.areas[k][lane], [a, b, [-a[0] - b[0], -a[1] - b[1]]])
                })
            })
        })
    }

    /// Stiffness block `K_ij = A ∫ B_iᵀ D B_j` of two gradients `a` = ∇N_i, `b` = ∇N_j over area 1 of a
    /// `triangle`, Pa/m².
    pub fn stiffness_block(&self, triangle: usize, a: [f64; 2], b: [f64; 2]) -> [[f64; 2]; 2] {
        let Moduli { lambda, twice_shear } =
            self.moduli.of_cell(Batch::place_of(&self.batches, triangle / 4));
        let shear = twice_shear / 2.0;
        let dot = a[0] * b[0] + a[1] * b[1];
        let entry = |p: usize, q: usize| {
            let diagonal = if p == q { shear * dot } else { 0.0 };
            lambda * a[p] * b[q] + shear * a[q] * b[p] + diagonal
        };
        [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
    }
}

#[cfg(test)]
mod tests {
    use pulp::WithSimd;

    use super::*;
    use crate::{Plane, Section};

    fn cell(kinematics: Kinematics) -> (Mesh, CrossedCells) {
        let mut mesh = Mesh::mapped(&Section::rectangle(2.0, 1.0), &[vec![0.0, 1.0]], 1);
        mesh.nodes[4] = [0.9, 0.6];
        let material = Material { young_modulus: 3.0, density: 1.0, ..Default::default() };
        let cells = CrossedCells::new(&mesh, &Materials::from(&material), kinematics);
        (mesh, cells)
    }

    #[test]
    fn forces_are_the_gradient_of_the_strain_energy() {
        for kinematics in [Kinematics::Small, Kinematics::Corotational] {
            let (_, cells) = cell(kinematics);
            let u = [[0.1, -0.2], [0.3, 0.1], [-0.2, 0.3], [0.0, 0.2], [0.1, 0.0]];
            let mut forces = [[0.0; 2]; 5];
            cells.add_forces(&u, &u, 0.0, &mut [], &mut forces);
            for (node, d) in (0..5).flat_map(|n| [(n, 0), (n, 1)]) {
                let energy = |shift: f64| {
                    let mut moved = u;
                    moved[node][d] += shift;
                    cells.strain_energy(&moved)
                };
                let slope = (energy(1e-5) - energy(-1e-5)) / 2e-5;
                assert!((forces[node][d] + slope).abs() < 1e-9, "{kinematics:?} {node} {d}");
            }
        }
    }

    /// Numbers of columns of a wall in 13 rows: batches of cells above each other, the last one partly filled; of a row with a
    /// lane left; of a row, and of two rows.
    const COLUMNS: [usize; 3] = [1, 7, 19];

    fn wall(kinematics: Kinematics, columns: usize) -> (Mesh, CrossedCells, [Vec<[f64; 2]>; 2]) {
        let rows: Vec<f64> = (0..=13).map(f64::from).collect();
        let mut mesh = Mesh::mapped(&Section::rectangle(1.2 * columns as f64, 13.0), &[rows], columns);
        for (i, [x, y]) in mesh.nodes.iter_mut().enumerate() {
            *x += 0.2 * (7.0 * i as f64).sin();
            *y += 0.2 * (5.0 * i as f64).cos();
        }
        let material = Material { young_modulus: 3.0, density: 1.0, ..Default::default() };
        let cells = CrossedCells::new(&mesh, &Materials::from(&material), kinematics);
        let field = |scale: f64, shift: f64| {
            let of =
                |i: usize| [scale * (3.0 * i as f64 + shift).sin(), scale * (2.0 * i as f64 + shift).cos()];
            (0..mesh.nodes.len()).map(of).collect()
        };
        let fields = [field(0.2, 0.0), field(1.0, 1.0)];
        (mesh, cells, fields)
    }

    /// Reference: a loop over triangles, with the rotation from an angle and the strain from `RᵀF − I`.
    #[test]
    fn forces_are_those_of_a_loop_over_triangles() {
        let both = [Kinematics::Small, Kinematics::Corotational];
        for (kinematics, columns) in both.into_iter().flat_map(|one| COLUMNS.map(|columns| (one, columns))) {
            let (mesh, cells, [u, v]) = wall(kinematics, columns);
            let damping = StiffnessDamping { coefficient: 0.3, memory: 0.6 };
            let mut forces = vec![[0.0; 2]; mesh.nodes.len()];
            let mut viscous = cells.viscous_at_rest();
            let power = [0, 1].map(|_| {
                forces.fill([0.0; 2]);
                cells.add_forces(&u, &v, damping, &mut viscous, &mut forces)
            });
            let mut powers = [0.0; 2];
            let mut size = 0.0f64;
            for (nodes, area, gradients) in cells.triangles() {
                let gradient = |field: &[[f64; 2]]| {
                    [0, 1].map(|p| {
                        [0, 1].map(|q| (0..3).map(|i| field[nodes[i]][p] * gradients[i][q]).sum::<f64>())
                    })
                };
                let ([[a, b], [c, d]], rate) = (gradient(&u), gradient(&v));
                let angle = if kinematics == Kinematics::Small { 0.0 } else { (c - b).atan2(2.0 + a + d) };
                let (sin, cos) = angle.sin_cos();
                let turned = |[[a, b], [c, d]]: [[f64; 2]; 2]| {
                    let t = [[cos * a + sin * c, cos * b + sin * d], [cos * c - sin * a, cos * d - sin * b]];
                    [t[0][0], t[1][1], (t[0][1] + t[1][0]) / 2.0]
                };
                let [s11, s22, s12] = turned([[1.0 + a, b], [c, 1.0 + d]]);
                let (strain, rate) = ([s11 - 1.0, s22 - 1.0, s12], turned(rate));
                let Moduli { lambda, twice_shear: shear } = cells.moduli.of_cell((0, 0));
                let stress = |e: [f64; 3]| {
                    [
                        lambda * (e[0] + e[1]) + shear * e[0],
                        lambda * (e[0] + e[1]) + shear * e[1],
                        shear * e[2],
                    ]
                };
                let full = stress(rate).map(|s| 0.3 * s);
                let [first, second] = [0.4, 0.4 + 0.6 * 0.4].map(|share| full.map(|s| share * s));
                let dot = |s: [f64; 3]| area * (s[0] * rate[0] + s[1] * rate[1] + 2.0 * s[2] * rate[2]);
                powers[0] += dot(first) / 2.0;
                powers[1] += (dot(first) + dot(second)) / 2.0;
                let elastic = stress(strain);
                let [t11, t22, t12] = [0, 1, 2].map(|i| area * (elastic[i] + second[i]));
                let piola = [
                    [cos * t11 - sin * t12, cos * t12 - sin * t22],
                    [sin * t11 + cos * t12, sin * t12 + cos * t22],
                ];
                for (&node, g) in nodes.iter().zip(gradients) {
                    for d in 0..2 {
                        let force = piola[d][0] * g[0] + piola[d][1] * g[1];
                        forces[node][d] += force;
                        size = size.max(force.abs());
                    }
                }
            }
            let error = forces.iter().flatten().fold(0.0f64, |a, f| a.max(f.abs())) / size;
            println!(
                "{kinematics:?}, {columns} columns: forces of the batches against triangles {error:.1e} of the largest"
            );
            assert!(error < 1e-13);
            for (a, b) in power.iter().zip(powers) {
                assert!((a / b - 1.0).abs() < 1e-13, "power {a}, of triangles {b}");
            }
        }
    }

    /// Forces, powers and energy of two evaluations, in bits.
    fn bits<const COROTATIONAL: bool, const DAMPED: bool>(scalar: bool, columns: usize) -> Vec<u64> {
        let (mesh, cells, [u, v]) = wall(Kinematics::Small, columns);
        let mut viscous = cells.viscous_at_rest();
        let mut forces = vec![[0.0; 2]; mesh.nodes.len()];
        for _ in 0..2 {
            let damping = StiffnessDamping { coefficient: 0.3, memory: 0.6 };
            let evaluation = Evaluation::<COROTATIONAL, DAMPED> {
                moduli: cells.moduli.of(0..cells.batches.len()),
                of: Deformation { displacement: &u, velocity: &v, damping },
                batches: &cells.batches,
                viscous: &mut viscous,
                forces: &mut forces,
                first_node: 0,
            };
            let (moduli, batches) = (cells.moduli.of(0..cells.batches.len()), &cells.batches[..]);
            let energy = Energy::<COROTATIONAL> { moduli, batches, displacement: &u };
            let sums = match scalar {
                true => [evaluation.with_simd(pulp::Scalar::new()), energy.with_simd(pulp::Scalar::new())],
                false => [Arch::new().dispatch(evaluation), Arch::new().dispatch(energy)],
            };
            forces.push(sums);
        }
        forces.into_iter().flatten().map(f64::to_bits).collect()
    }

    /// The widest registers of this processor give the same bits as scalar arithmetic.
    #[test]
    fn the_bits_do_not_depend_on_the_processor() {
        for columns in COLUMNS {
            assert_eq!(bits::<true, true>(false, columns), bits::<true, true>(true, columns));
            assert_eq!(bits::<true, false>(false, columns), bits::<true, false>(true, columns));
            assert_eq!(bits::<false, true>(false, columns), bits::<false, true>(true, columns));
            assert_eq!(bits::<false, false>(false, columns), bits::<false, false>(true, columns));
        }
    }

    /// Twin: the same wall with its nodes in another order, so that no cells are a row.
    #[test]
    fn rows_have_the_forces_of_cells_in_any_order() {
        for columns in COLUMNS {
            let (mesh, cells, [u, v]) = wall(Kinematics::Corotational, columns);
            let count = mesh.nodes.len();
            let turned = |field: &[[f64; 2]]| field.iter().rev().copied().collect::<Vec<_>>();
            let mut shuffled = mesh.clone();
            shuffled.nodes = turned(&mesh.nodes);
            shuffled.cells.iter_mut().flatten().for_each(|node| *node = count - 1 - *node);
            let material = Material { young_modulus: 3.0, density: 1.0, ..Default::default() };
            let general = CrossedCells::new(&shuffled, &Materials::from(&material), Kinematics::Corotational);
            let in_rows = |cells: &CrossedCells| cells.batches.iter().filter(|batch| batch.is_row()).count();
            println!("{columns} columns: {} of {} batches are rows", in_rows(&cells), cells.batches.len());
            assert!(in_rows(&general) == 0 && (columns == 1 || in_rows(&cells) >= 12));
            let damping = StiffnessDamping { coefficient: 0.3, memory: 0.6 };
            let of = |cells: &CrossedCells, u: &[[f64; 2]], v: &[[f64; 2]]| {
                let (mut viscous, mut forces) = (cells.viscous_at_rest(), vec![[0.0; 2]; count]);
                let power = [0, 1].map(|_| cells.add_forces(u, v, damping, &mut viscous, &mut forces));
                (forces, power, cells.strain_energy(u))
            };
            let (forces, power, energy) = of(&cells, &u, &v);
            let (others, other_power, other_energy) = of(&general, &turned(&u), &turned(&v));
            let largest = forces.iter().flatten().fold(0.0f64, |most, f| most.max(f.abs()));
            for (a, b) in forces.iter().flatten().zip(turned(&others).iter().flatten()) {
                assert!((a - b).abs() < 1e-14 * largest);
            }
            assert!(power.iter().zip(other_power).all(|(a, b)| (a / b - 1.0).abs() < 1e-13));
            assert!((energy / other_energy - 1.0).abs() < 1e-13);
        }
    }

    /// What is not a number at one node stays with the triangles of this node, though lanes without a cell read others.
    #[test]
    fn lanes_without_a_cell_touch_no_node() {
        let (mesh, cells, [u, v]) = wall(Kinematics::Corotational, 7);
        for node in 0..mesh.nodes.len() {
            let mut broken = u.clone();
            broken[node] = [f64::NAN; 2];
            let mut forces = vec![[0.0; 2]; mesh.nodes.len()];
            cells.add_forces(&broken, &v, 0.0, &mut cells.viscous_at_rest(), &mut forces);
            let mut near: Vec<usize> =
                mesh.triangles().filter(|corners| corners.contains(&node)).flatten().collect();
            near.sort_unstable();
            near.dedup();
            let touched = (0..forces.len()).filter(|&i| forces[i].iter().any(|f| f.is_nan()));
            assert!(touched.eq(near), "node {node}");
        }
    }

    /// `f_i = −A σ R ∇N_i`, and the stress of a strained triangle rotates with it.
    #[test]
    fn stresses_are_those_of_the_forces_and_turn_with_the_triangle() {
        for kinematics in [Kinematics::Small, Kinematics::Corotational] {
            let (mesh, cells) = cell(kinematics);
            let u = [[0.1, -0.2], [0.3, 0.1], [-0.2, 0.3], [0.0, 0.2], [0.1, 0.0]];
            let (mut forces, mut of_stress) = (vec![[0.0; 2]; 5], vec![[0.0; 2]; 5]);
            cells.add_forces(&u, &u, 0.0, &mut [], &mut forces);
            for (triangle, (nodes, area, gradients)) in cells.triangles().enumerate() {
                let displaced = nodes.map(|node| u[node]);
                let [s, t, r] = cells.stress(triangle, displaced, kinematics);
                let turn = |angle: f64| [[angle.cos(), -angle.sin()], [angle.sin(), angle.cos()]];
                let mut h = [[0.0; 2]; 2];
                for (u, g) in displaced.iter().zip(gradients) {
                    (0..4).for_each(|i| h[i / 2][i % 2] += u[i / 2] * g[i % 2]);
                }
                let angle = match kinematics {
                    Kinematics::Small => 0.0,
                    Kinematics::Corotational => (h[1][0] - h[0][1]).atan2(2.0 + h[0][0] + h[1][1]),
                };
                let own = turn(angle);
                for (&node, g) in nodes.iter().zip(gradients) {
                    let g = [0, 1].map(|i| own[i][0] * g[0] + own[i][1] * g[1]);
                    of_stress[node][0] -= area * (s * g[0] + r * g[1]);
                    of_stress[node][1] -= area * (r * g[0] + t * g[1]);
                }
                if kinematics == Kinematics::Corotational {
                    let q = turn(2.0);
                    let turned = nodes.map(|node| {
                        let x = [0, 1].map(|d| mesh.nodes[node][d] + u[node][d]);
                        [0, 1].map(|d| q[d][0] * x[0] + q[d][1] * x[1] - mesh.nodes[node][d])
                    });
                    let [s2, t2, r2] = cells.stress(triangle, turned, kinematics);
                    let along = |a: [f64; 2], b: [f64; 2]| {
                        a[0] * (s * b[0] + r * b[1]) + a[1] * (r * b[0] + t * b[1])
                    };
                    let errors = [s2 - along(q[0], q[0]), t2 - along(q[1], q[1]), r2 - along(q[0], q[1])];
                    assert!(errors.iter().all(|e| e.abs() < 1e-13), "{errors:?}");
                }
            }
            for (a, b) in forces.iter().flatten().zip(of_stress.iter().flatten()) {
                assert!((a - b).abs() < 1e-13, "{kinematics:?}: {a}, {b}");
            }
        }
    }

    /// Forces and damping of a large mesh on different numbers of threads.
    #[test]
    fn the_bits_do_not_depend_on_the_threads() -> Result<(), DamError> {
        let mesh = Mesh::new(&Section::rectangle(60.0, 100.0), &[31.0], &[], 0.45);
        let material =
            Material { young_modulus: 3.0, density: 1.0, plane: Plane::Strain, ..Default::default() };
        let field = |shift: f64| -> Vec<[f64; 2]> {
            mesh.nodes.iter().map(|[x, y]| [(x + shift).sin() * 1e-2, (y * x + shift).cos() * 1e-2]).collect()
        };
        let (u, v) = (field(0.0), field(1.0));
        let mut results = Vec::new();
        for threads in [1, 2, 3] {
            let threads = NonZeroUsize::new(threads).unwrap_or(NonZeroUsize::MIN);
            let cells = CrossedCells::new(&mesh, &Materials::from(&material), Kinematics::Corotational)
                .on_threads(threads)?;
            assert!(cells.triangle_count() > 100_000 && cells.parts.parts.len() > 8);
            let mut viscous = cells.viscous_at_rest();
            let mut forces = vec![[0.0; 2]; mesh.nodes.len()];
            let damping = StiffnessDamping { coefficient: 0.3, memory: 0.6 };
            let powers = [0, 1].map(|_| cells.add_forces(&u, &v, damping, &mut viscous, &mut forces));
            // reference: all batches in sequence
            let mut plain = vec![[0.0; 2]; mesh.nodes.len()];
            cells.add_forces(&u, &v, 0.0, &mut [], &mut plain);
            let mut serial = vec![[0.0; 2]; mesh.nodes.len()];
            Arch::new().dispatch(Evaluation::<true, false> {
                moduli: cells.moduli.of(0..cells.batches.len()),
                of: Deformation { displacement: &u, velocity: &v, damping: 0.0.into() },
                batches: &cells.batches,
                viscous: &mut [],
                forces: &mut serial,
                first_node: 0,
            });
            let largest = serial.iter().flatten().fold(0.0f64, |most, f| most.max(f.abs()));
            let apart = serial.iter().flatten().zip(plain.iter().flatten()).map(|(a, b)| (a - b).abs());
            assert!(apart.fold(0.0, f64::max) < 1e-14 * largest, "parts and seams are all batches");
            results.push((powers.map(f64::to_bits), forces));
        }
        assert!(results.iter().all(|result| result.0 == results[0].0 && result.1 == results[0].1));
        Ok(())
    }

    #[test]
    fn damping_power_is_that_of_its_forces() {
        let (_, cells) = cell(Kinematics::Corotational);
        let u = [[0.1, -0.2], [0.3, 0.1], [-0.2, 0.3], [0.0, 0.2], [0.1, 0.0]];
        let v = [[1.0, 0.3], [-0.4, 0.2], [0.1, 0.7], [0.5, -0.6], [0.3, 0.3]];
        let (mut with, mut without) = ([[0.0; 2]; 5], [[0.0; 2]; 5]);
        let mut viscous = [ViscousStress::default()];
        cells.add_forces(&u, &v, 0.3, &mut viscous, &mut [[0.0; 2]; 5]);
        let power = cells.add_forces(&u, &v, 0.3, &mut viscous, &mut with);
        cells.add_forces(&u, &v, 0.0, &mut [], &mut without);
        let of_forces: f64 =
            (0..5).map(|n| (0..2).map(|d| (without[n][d] - with[n][d]) * v[n][d]).sum::<f64>()).sum();
        assert!(power > 0.0 && (power - of_forces).abs() < 1e-13 * power);
    }

    #[test]
    fn stiffness_blocks_are_those_of_the_linear_forces() {
        let (mesh, cells) = cell(Kinematics::Small);
        let u: Vec<[f64; 2]> = mesh.nodes.iter().map(|&[x, y]| [x * y, y - x * x]).collect();
        let mut forces = vec![[0.0; 2]; 5];
        cells.add_linear_forces(&u, &mut forces);
        for (triangle, (nodes, area, gradients)) in cells.triangles().enumerate() {
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let block = cells.stiffness_block(triangle, gradients[i], gradients[j]);
                for p in 0..2 {
                    forces[nodes[i]][p] +=
                        area * (block[p][0] * u[nodes[j]][0] + block[p][1] * u[nodes[j]][1]);
                }
            }
        }
        assert!(forces.iter().flatten().all(|f| f.abs() < 1e-14));
    }
}
