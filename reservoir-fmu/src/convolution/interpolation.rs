use crate::ReservoirError;
use nalgebra::DMatrix;
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Chebyshev nodes per piece.
const NODES: usize = 24;
/// Smallest Bernstein parameter of a piece with respect to every known singularity:
/// 3⁻²⁴ times the decay of a square root's coefficients is about 1e-13.
const ELLIPSE: f64 = 2.4;
/// Largest error of a shortest piece, in tolerances.
const LARGEST: f64 = 100.0;

/// Piecewise Chebyshev interpolant of a complex matrix function of a real variable.
pub(crate) struct Interpolant {
    pieces: Vec<Piece>,
    shape: (usize, usize),
}

struct Piece {
    start: f64,
    end: f64,
    /// Chebyshev coefficients, entry after entry (column-major), `NODES` each.
    coefficients: Vec<Complex64>,
}

impl Interpolant {
    /// Interpolates `function` on `[start, end]` within about `tolerance` of its largest entry.
    ///
    /// Pieces are bisected towards the complex `singularities` beforehand and wherever the
    /// last coefficients are not below the tolerance, down to pieces of length `shortest`.
    ///
    /// **Errors**: [`ReservoirError::NotInterpolated`] if one of those is off by more than [`LARGEST`] tolerances, and
    /// those of the function.
    pub fn new(
        function: impl Fn(f64) -> Result<DMatrix<Complex64>, ReservoirError> + Sync,
        [start, end]: [f64; 2],
        singularities: &[Complex64],
        tolerance: f64,
        shortest: f64,
    ) -> Result<Self, ReservoirError> {
        let (accepted, mut pending) = (LARGEST * tolerance, Vec::new());
        grade(start, end, singularities, shortest, &mut pending);
        let (mut pieces, mut scale, mut shape): (Vec<Piece>, f64, (usize, usize)) = (Vec::new(), 0.0, (0, 0));
        while !pending.is_empty() {
            let nodes: Vec<f64> =
                pending.iter().flat_map(|&[a, b]| (0..NODES).map(move |i| node(a, b, i))).collect();
            let values =
                nodes.par_iter().map(|&x| function(x)).collect::<Result<Vec<_>, ReservoirError>>()?;
            if values.iter().flat_map(|v| v.iter()).any(|z| !z.is_finite()) {
                return Err(ReservoirError::NotInterpolated { error: f64::NAN, tolerance: accepted });
            }
            shape = values[0].shape();
            scale = values.iter().flat_map(|v| v.iter()).fold(scale, |s, z| s.max(z.norm()));
            let mut refined = Vec::new();
            for (&[start, end], values) in pending.iter().zip(values.chunks(NODES)) {
                let piece = Piece { start, end, coefficients: coefficients(values) };
                if piece.tail() <= tolerance * scale || end - start <= shortest {
                    pieces.push(piece);
                } else {
                    let middle = 0.5 * (start + end);
                    refined.extend([[start, middle], [middle, end]]);
                }
            }
            pending = refined;
        }
        let worst = pieces.iter().map(Piece::tail).fold(0.0, f64::max);
        if worst > accepted * scale {
            return Err(ReservoirError::NotInterpolated { error: worst / scale, tolerance: accepted });
        }
        pieces.sort_by(|a, b| a.start.total_cmp(&b.start));
        Ok(Self { pieces, shape })
    }

    /// Number of rows and columns of the matrix.
    pub fn shape(&self) -> (usize, usize) {
        self.shape
    }

    /// Number of nodes of all pieces.
    #[cfg(test)]
    pub fn nodes(&self) -> usize {
        self.pieces.len() * NODES
    }

    /// For every point (ascending): its piece and the values of the Chebyshev polynomials there.
    pub fn basis(&self, points: &[f64]) -> Vec<(usize, [f64; NODES])> {
        let mut piece = 0;
        points
            .iter()
            .map(|&x| {
                while piece + 1 < self.pieces.len() && x > self.pieces[piece].end {
                    piece += 1;
                }
                let Piece { start, end, .. } = self.pieces[piece];
                let angle = (2.0 * (x - start) / (end - start) - 1.0).clamp(-1.0, 1.0).acos();
                (piece, std::array::from_fn(|degree| (degree as f64 * angle).cos()))
            })
            .collect()
    }

    /// One matrix entry (column-major index) at a point given by its [`basis`](Self::basis).
    pub fn evaluate(&self, entry: usize, (piece, basis): &(usize, [f64; NODES])) -> Complex64 {
        let coefficients = &self.pieces[*piece].coefficients[entry * NODES..][..NODES];
        coefficients.iter().zip(basis).map(|(c, b)| c * b).sum()
    }
}

impl Piece {
    /// Largest of the last three coefficients of any entry.
    fn tail(&self) -> f64 {
        self.coefficients
            .chunks(NODES)
            .flat_map(|c| &c[NODES - 3..])
            .fold(0.0, |worst, c| worst.max(c.norm()))
    }
}

/// Bisects `[start, end]` until every piece is far enough from the singularities.
fn grade(start: f64, end: f64, singularities: &[Complex64], shortest: f64, pieces: &mut Vec<[f64; 2]>) {
    let half = 0.5 * (end - start);
    let too_close = |singularity: &Complex64| {
        let z = (singularity - (start + half)) / half;
        let root = (z * z - 1.0).sqrt();
        (z + root).norm().max((z - root).norm()) < ELLIPSE
    };
    if 2.0 * half > shortest && singularities.iter().any(too_close) {
        grade(start, start + half, singularities, shortest, pieces);
        grade(start + half, end, singularities, shortest, pieces);
    } else {
        pieces.push([start, end]);
    }
}

fn node(start: f64, end: f64, index: usize) -> f64 {
    0.5 * (start + end) + 0.5 * (end - start) * (PI * (index as f64 + 0.5) / NODES as f64).cos()
}

fn coefficients(values: &[DMatrix<Complex64>]) -> Vec<Complex64> {
    let transform: Vec<f64> = (0..NODES * NODES)
        .map(|index| {
            let (degree, node) = ((index / NODES) as f64, (index % NODES) as f64);
            let factor = if degree == 0.0 { 1.0 } else { 2.0 };
            factor / NODES as f64 * (degree * PI * (node + 0.5) / NODES as f64).cos()
        })
        .collect();
    (0..values[0].len())
        .flat_map(|entry| {
            transform
                .chunks(NODES)
                .map(move |row| row.iter().zip(values).map(|(t, v)| v[entry] * t).sum())
                .collect::<Vec<Complex64>>()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square root 0.002 off the interval, as at a cut-off frequency, with and without its singularity given.
    #[test]
    fn resolves_branch_points() -> Result<(), ReservoirError> {
        let singularity = Complex64::new(1.0, -0.002);
        let exact = |x: f64| 1.0 / (x - singularity).sqrt();
        let function = |x: f64| Ok(DMatrix::from_element(1, 1, exact(x)));
        let points: Vec<f64> = (0..4000).map(|i| 3.0 * i as f64 / 3999.0).collect();
        for told in [vec![singularity], vec![]] {
            let interpolant = Interpolant::new(function, [0.0, 3.0], &told, 1e-10, 1e-5)?;
            let worst = points.iter().zip(interpolant.basis(&points)).fold(0.0, |worst: f64, (&x, basis)| {
                worst.max((interpolant.evaluate(0, &basis) - exact(x)).norm())
            });
            println!("branch point, {} nodes: error {worst:.1e}", interpolant.nodes());
            assert!(worst < 1e-9 * 0.002f64.powf(-0.5));
        }
        Ok(())
    }

    /// A jump is resolved by no polynomial; a number that is none is found out too.
    #[test]
    fn what_is_not_smooth_is_an_error() {
        for jump in [1.0, f64::NAN] {
            let function =
                |x: f64| Ok(DMatrix::from_element(1, 1, (if x < 0.7 { 2.0 } else { 2.0 + jump }).into()));
            let found = Interpolant::new(function, [0.0, 1.0], &[], 1e-9, 1e-3);
            assert!(matches!(found, Err(ReservoirError::NotInterpolated { .. })));
        }
    }
}
