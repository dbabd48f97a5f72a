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
mod tests;
