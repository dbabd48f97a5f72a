//! Forces and strain energy of the cells, with vector instructions for several cells at a time.

use pulp::{Simd, WithSimd};

use super::batch::{Batch, Corners, Nodal, Pairs, ViscousStress};
use crate::damping::StiffnessDamping;
use crate::lanes::{Lanes, Register};

/// A vector, and a tensor `[[11, 12], [21, 22]]`, in triangle k of the cells of one register.
type Vector<S> = [Register<S>; 2];
type Tensor<S> = [[Register<S>; 2]; 2];
/// A symmetric tensor: 11, 22, 12 components.
type Symmetric<S> = [Register<S>; 3];

/// Elastic moduli of plane stress or plane strain: `σ = λ tr(ε) I + 2G ε`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Moduli<T = f64> {
    /// λ in the plane, Pa.
    pub lambda: T,
    /// 2G, Pa.
    pub twice_shear: T,
}

/// [`Moduli`] of all cells.
#[derive(Clone, Copy)]
pub(super) enum ModuliOf<'a> {
    /// The same everywhere.
    All(Moduli),
    /// For each of the batches, those of its cells; 0 in lanes without a cell.
    Batches(&'a [Moduli<Lanes>]),
}

impl ModuliOf<'_> {
    /// Those of one `register` of a batch. `all` are those that are the same everywhere.
    #[inline(always)]
    fn elastic<S: Simd>(&self, simd: S, all: Elastic<S>, batch: usize, register: usize) -> Elastic<S> {
        match self {
            Self::All(_) => all,
            Self::Batches(batches) => {
                let Moduli { lambda, twice_shear } = &batches[batch];
                Elastic { lambda: lambda.load(simd, register), twice_shear: twice_shear.load(simd, register) }
            }
        }
    }

    #[inline(always)]
    fn all(&self) -> Moduli {
        match self {
            Self::All(moduli) => *moduli,
            Self::Batches(_) => Moduli::default(),
        }
    }
}

/// Motion of all nodes, and stiffness damping.
#[derive(Clone, Copy)]
pub(super) struct Deformation<'a> {
    pub displacement: &'a [[f64; 2]],
    pub velocity: &'a [[f64; 2]],
    pub damping: StiffnessDamping,
}

/// Forces of stress and damping; the result is the power of damping, W/m.
pub(super) struct Evaluation<'a, const COROTATIONAL: bool, const DAMPED: bool> {
    pub moduli: ModuliOf<'a>,
    pub of: Deformation<'a>,
    /// The batches to evaluate, and their damping stresses.
    pub batches: &'a [Batch],
    pub viscous: &'a mut [ViscousStress],
    /// Forces on the nodes from `first_node` on.
    pub forces: &'a mut [[f64; 2]],
    pub first_node: usize,
}

impl<const COROTATIONAL: bool, const DAMPED: bool> Evaluation<'_, COROTATIONAL, DAMPED> {
    /// Displacements and velocities of a batch.
    #[inline(always)]
    fn gather(&self, batch: usize, [u, v]: &mut [Pairs; 2]) {
        if let Some(batch) = self.batches.get(batch) {
            batch.gather(self.of.displacement, u);
            if DAMPED {
                batch.gather(self.of.velocity, v);
            }
        }
    }
}

impl<const COROTATIONAL: bool, const DAMPED: bool> WithSimd for Evaluation<'_, COROTATIONAL, DAMPED> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let all = Elastic::new(simd, self.moduli.all());
        let StiffnessDamping { coefficient, memory } = self.of.damping;
        let fresh = Register::splat(simd, (1.0 - memory) * coefficient);
        let memory = Register::splat(simd, memory);
        let mut power = Lanes::default();
        let mut fields = [[Pairs::default(); 2]; 2];
        self.gather(0, &mut fields[0]);
        let zero = Register::splat(simd, 0.0);
        let mut stretched = [[Lanes::default(); 5]; 4];
        let mut forces = Nodal::default();
        for (index, batch) in self.batches.iter().enumerate() {
            self.gather(index + 1, &mut fields[(index + 1) % 2]);
            let [u, v] = &fields[index % 2];
            let u = batch.relative_to_centre(simd, self.of.displacement, u);
            let v = if DAMPED { batch.relative_to_centre(simd, self.of.velocity, v) } else { u };
            // roots and quotients of all triangles first, so that the processor can overlap them
            for register in 0..Lanes::registers::<S>() {
                let u = at(simd, &u, register);
                for (k, stretched) in stretched.iter_mut().enumerate() {
                    let shape = Shape::load(simd, batch, k, register);
                    let Stretched { cos, sin, strain } =
                        polar::<S, COROTATIONAL>(shape.gradient(u[k], u[(k + 1) % 4]));
                    for (to, from) in stretched.iter_mut().zip([cos, sin, strain[0], strain[1], strain[2]]) {
                        to.store(register, from);
                    }
                }
            }
            for register in 0..Lanes::registers::<S>() {
                let v = at(simd, &v, register);
                let mut sum = [[zero; 2]; 4];
                let elastic = self.moduli.elastic(simd, all, index, register);
                let mut lost = power.load(simd, register);
                for (k, [cos, sin, e11, e22, e12]) in stretched.iter().enumerate() {
                    let (cos, sin) = (cos.load(simd, register), sin.load(simd, register));
                    let strain =
                        [e11.load(simd, register), e22.load(simd, register), e12.load(simd, register)];
                    let next = (k + 1) % 4;
                    let shape = Shape::load(simd, batch, k, register);
                    let mut stress = elastic.stress(&strain);
                    if DAMPED {
                        let rate = rotated_rate::<S, COROTATIONAL>(cos, sin, shape.gradient(v[k], v[next]));
                        let viscous = &mut self.viscous[index][k];
                        let target = elastic.stress(&rate);
                        let mut both = target;
                        for i in 0..3 {
                            let before = viscous[i].load(simd, register);
                            let now = memory * before + fresh * target[i];
                            viscous[i].store(register, now);
                            stress[i] += now;
                            both[i] = before + now;
                        }
                        lost += shape.area * contract(&rate, &both);
                    }
                    let [s11, s22, s12] =
                        [stress[0] * shape.area, stress[1] * shape.area, stress[2] * shape.area];
                    let piola = if COROTATIONAL {
                        [
                            [cos * s11 - sin * s12, cos * s12 - sin * s22],
                            [sin * s11 + cos * s12, sin * s12 + cos * s22],
                        ]
                    } else {
                        [[s11, s12], [s12, s22]]
                    };
                    for (corner, gradient) in [(k, shape.gradients[0]), (next, shape.gradients[1])] {
                        for d in 0..2 {
                            sum[corner][d] += piola[d][0] * gradient[0] + piola[d][1] * gradient[1];
                        }
                    }
                }
                power.store(register, lost);
                // a lane without a cell has read nodes of other ones, which may not be numbers
                let used = batch.used.load(simd, register);
                for d in 0..2 {
                    for k in 0..4 {
                        forces[k][d].store(register, used.where_negative(zero - sum[k][d], zero));
                    }
                    let centre = (sum[0][d] + sum[2][d]) + (sum[1][d] + sum[3][d]);
                    forces[4][d].store(register, used.where_negative(centre, zero));
                }
            }
            batch.scatter(&forces, self.first_node, self.forces);
        }
        0.5 * power.sum()
    }
}

/// Strain energy, J/m.
pub(super) struct Energy<'a, const COROTATIONAL: bool> {
    pub moduli: ModuliOf<'a>,
    pub batches: &'a [Batch],
    pub displacement: &'a [[f64; 2]],
}

impl<const COROTATIONAL: bool> WithSimd for Energy<'_, COROTATIONAL> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let all = Elastic::new(simd, self.moduli.all());
        let mut twice = Lanes::default();
        for (index, batch) in self.batches.iter().enumerate() {
            let mut u = Pairs::default();
            batch.gather(self.displacement, &mut u);
            let u = batch.relative_to_centre(simd, self.displacement, &u);
            for register in 0..Lanes::registers::<S>() {
                let u = at(simd, &u, register);
                let elastic = self.moduli.elastic(simd, all, index, register);
                for k in 0..4 {
                    let shape = Shape::load(simd, batch, k, register);
                    let strain = polar::<S, COROTATIONAL>(shape.gradient(u[k], u[(k + 1) % 4])).strain;
                    let energy = shape.area * contract(&strain, &elastic.stress(&strain));
                    let so_far = twice.load(simd, register);
                    twice.store(register, so_far + energy);
                }
            }
        }
        0.5 * twice.sum()
    }
}

/// Values at the corners of the cells of one register.
#[inline(always)]
fn at<S: Simd>(simd: S, field: &Corners, register: usize) -> [Vector<S>; 4] {
    let mut corners = [[Register::splat(simd, 0.0); 2]; 4];
    for k in 0..4 {
        for d in 0..2 {
            corners[k][d] = field[k][d].load(simd, register);
        }
    }
    corners
}

/// Shape functions of triangle k in the cells of one register.
struct Shape<S: Simd> {
    gradients: [Vector<S>; 2],
    area: Register<S>,
}

impl<S: Simd> Shape<S> {
    #[inline(always)]
    fn load(simd: S, batch: &Batch, k: usize, register: usize) -> Self {
        let [[ax, ay], [bx, by]] = &batch.gradients[k];
        Self {
            gradients: [
                [ax.load(simd, register), ay.load(simd, register)],
                [bx.load(simd, register), by.load(simd, register)],
            ],
            area: batch.areas[k].load(simd, register),
        }
    }

    /// `[[∂₁f₁, ∂₂f₁], [∂₁f₂, ∂₂f₂]]` of a field with the values `a` and `b` at the two corners and 0 at the centre.
    #[inline(always)]
    fn gradient(&self, a: Vector<S>, b: Vector<S>) -> Tensor<S> {
        let [g, h] = self.gradients;
        [
            [a[0] * g[0] + b[0] * h[0], a[0] * g[1] + b[0] * h[1]],
            [a[1] * g[0] + b[1] * h[0], a[1] * g[1] + b[1] * h[1]],
        ]
    }
}

/// [`Moduli`] in registers.
#[derive(Clone, Copy)]
struct Elastic<S: Simd> {
    lambda: Register<S>,
    twice_shear: Register<S>,
}

impl<S: Simd> Elastic<S> {
    #[inline(always)]
    fn new(simd: S, Moduli { lambda, twice_shear }: Moduli) -> Self {
        Self { lambda: Register::splat(simd, lambda), twice_shear: Register::splat(simd, twice_shear) }
    }

    /// `D : ε`.
    #[inline(always)]
    fn stress(&self, &[e11, e22, e12]: &Symmetric<S>) -> Symmetric<S> {
        let volumetric = self.lambda * (e11 + e22);
        [volumetric + self.twice_shear * e11, volumetric + self.twice_shear * e22, self.twice_shear * e12]
    }
}

/// Rotation and strain.
#[derive(Clone, Copy)]
struct Stretched<S: Simd> {
    cos: Register<S>,
    sin: Register<S>,
    strain: Symmetric<S>,
}

/// Rotation R and strain from the displacement gradient; `versine` is 1 − cos θ.
#[inline(always)]
fn polar<S: Simd, const COROTATIONAL: bool>([[h11, h12], [h21, h22]]: Tensor<S>) -> Stretched<S> {
    let one = h11.splat_like(1.0);
    if !COROTATIONAL {
        let strain = [h11, h22, (h12 + h21) * h11.splat_like(0.5)];
        return Stretched { cos: one, sin: h11.splat_like(0.0), strain };
    }
    let (a, b) = (one + h11 + (one + h22), h21 - h12);
    let stretch = (a * a + b * b).sqrt();
    // 1 − cos θ = b²/r(r + a) up to a quarter turn and (r − a)²/r(r − a) beyond: no digits are lost at 0, no sum vanishes at 180°
    let sum = stretch + a.abs();
    let inverse = one / (stretch * sum);
    let versine = a.where_negative(sum * sum, b * b) * inverse;
    let (cos, sin) = (one - versine, b * sum * inverse);
    let e11 = cos * h11 + sin * h21 - versine;
    let e22 = cos * h22 - sin * h12 - versine;
    let e12 = cos * h12 + sin * h22 + sin;
    Stretched { cos, sin, strain: [e11, e22, e12] }
}

/// `sym(Rᵀ Ḟ)`.
#[inline(always)]
fn rotated_rate<S: Simd, const COROTATIONAL: bool>(
    cos: Register<S>,
    sin: Register<S>,
    [[f11, f12], [f21, f22]]: Tensor<S>,
) -> Symmetric<S> {
    let half = f11.splat_like(0.5);
    if COROTATIONAL {
        let e12 = half * (cos * (f12 + f21) + sin * (f22 - f11));
        [cos * f11 + sin * f21, cos * f22 - sin * f12, e12]
    } else {
        [f11, f22, half * (f12 + f21)]
    }
}

/// `a : b`.
#[inline(always)]
fn contract<S: Simd>(a: &Symmetric<S>, b: &Symmetric<S>) -> Register<S> {
    let shear = a[2] * b[2];
    a[0] * b[0] + a[1] * b[1] + (shear + shear)
}
