//! Functions over the depth of the channel: continuous piecewise polynomials, and the modes computed with them.

use crate::ReservoirError;
use crate::boundary::Element;
use crate::quadrature::{gauss_legendre, legendre};
use nalgebra::{DMatrix, SymmetricEigen};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Largest number of elements of one panel.
const PANEL: usize = 16;
/// Largest ratio of two element lengths in one panel.
const ALIKE: f64 = 4.5;

/// Largest relative error of λ_m for which a mode counts as resolved.
const RESOLVED: f64 = 0.1;

/// A panel of the far end and the polynomials on it.
struct Panel {
    /// Lower and upper end, m.
    ends: [f64; 2],
    /// Degree of the polynomials.
    degree: usize,
    /// Index of the function that is 1 at the lower end, of the one at the upper end (none where p = 0), and of
    /// the first of those that vanish at both.
    indices: (usize, Option<usize>, usize),
}

/// The modes of the channel over a rigid bed: eigenfunctions φ_m of −d²/dy², orthonormal over the depth.
pub(super) struct Channel {
    panels: Vec<Panel>,
    /// λ_m² ≥ 0, ascending, 1/m². Resolved modes have the exact values of the cosines, because the response depends
    /// strongly on them near a cut-off frequency.
    pub squared_eigenvalues: Vec<f64>,
    /// Coefficients of φ_m: functions × modes.
    vectors: DMatrix<f64>,
}

impl Channel {
    /// The modes for the far end's `elements`, from the surface down.
    ///
    /// At the surface p = 0, or with `free_top` the natural condition ∂φ/∂y = 0. A panel of n elements has
    /// polynomials up to the degree √(`resolved` n), but at most 5/8 of the number of its nodes, `nodes` per element.
    pub fn new(
        elements: &[Element],
        free_top: bool,
        resolved: usize,
        nodes: usize,
    ) -> Result<Self, ReservoirError> {
        let mut panels: Vec<Panel> = Vec::new();
        // Vertices are numbered first, from the surface down, then the other functions.
        let groups = groups(elements);
        let mut bubbles = groups.len() + usize::from(free_top);
        for (index, group) in groups.iter().enumerate() {
            let (first, last) = (group[0], group[group.len() - 1]);
            let degree = (resolved * group.len()).isqrt().min(5 * nodes * group.len() / 8).max(1);
            let upper = if free_top { Some(index) } else { index.checked_sub(1) };
            let lower = upper.map_or(0, |i| i + 1);
            panels.push(Panel {
                ends: [last.end[1], first.start[1]],
                degree,
                indices: (lower, upper, bubbles),
            });
            bubbles += degree - 1;
        }
        let (mut mass, mut stiffness) =
            (DMatrix::<f64>::zeros(bubbles, bubbles), DMatrix::<f64>::zeros(bubbles, bubbles));
        for panel in &panels {
            let half = 0.5 * (panel.ends[1] - panel.ends[0]);
            for q in gauss_legendre(panel.degree + 2).iter() {
                let values = panel.functions(q.position);
                for &(i, value, slope) in &values {
                    for &(j, other, other_slope) in &values {
                        mass[(i, j)] += q.weight * half * value * other;
                        stiffness[(i, j)] += q.weight / half * slope * other_slope;
                    }
                }
            }
        }
        let singular = || ReservoirError::FarEnd { frequency: Complex64::ZERO };
        let lower = mass.cholesky().ok_or_else(singular)?.unpack();
        let half = lower.solve_lower_triangular(&stiffness).ok_or_else(singular)?;
        let reduced = lower.solve_lower_triangular(&half.transpose()).ok_or_else(singular)?;
        let eigen = SymmetricEigen::new(0.5 * (&reduced + reduced.transpose()));
        let mut order: Vec<usize> = (0..bubbles).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let vectors = lower.transpose().solve_upper_triangular(&eigen.eigenvectors).ok_or_else(singular)?;
        let surface = elements.first().map_or(0.0, |e| e.start[1]);
        let depth = surface - elements.last().map_or(0.0, |e| e.end[1]);
        order.truncate(nodes * elements.len());
        let squared_eigenvalues = order.iter().enumerate().map(|(m, &index)| {
            let found = eigen.eigenvalues[index].max(0.0);
            let exact = if free_top { m as f64 } else { m as f64 + 0.5 } * PI / depth;
            if found.sqrt() <= (1.0 + RESOLVED) * exact { exact * exact } else { found }
        });
        Ok(Self {
            squared_eigenvalues: squared_eigenvalues.collect(),
            panels,
            vectors: vectors.select_columns(&order),
        })
    }

    /// Number of modes.
    pub fn size(&self) -> usize {
        self.squared_eigenvalues.len()
    }

    /// Largest degree of a panel's polynomials.
    pub fn degree(&self) -> usize {
        self.panels.iter().map(|panel| panel.degree).max().unwrap_or(0)
    }

    /// φ_m at the elevation y (m), for all m.
    pub fn values(&self, y: f64) -> Vec<f64> {
        let found = self.panels.iter().find(|panel| y >= panel.ends[0]);
        let Some(panel) = found.or(self.panels.last()) else { return Vec::new() };
        let [low, high] = panel.ends;
        let t = ((y - low) - (high - y)) / (high - low);
        let functions = panel.functions(t);
        (0..self.size())
            .map(|m| functions.iter().map(|&(i, value, _)| self.vectors[(i, m)] * value).sum())
            .collect()
    }
}

impl Panel {
    /// Index, value and slope d/dt of the functions that do not vanish on the panel, at t in [−1, 1].
    fn functions(&self, t: f64) -> Vec<(usize, f64, f64)> {
        let (lower, upper, bubbles) = self.indices;
        let mut functions = vec![(lower, 0.5 * (1.0 - t), -0.5)];
        functions.extend(upper.map(|index| (index, 0.5 * (1.0 + t), 0.5)));
        functions.extend((1..self.degree).map(|n| {
            let ((above, above_slope), (below, below_slope)) = (legendre(n + 1, t), legendre(n - 1, t));
            let scale = 1.0 / (2.0 * (2 * n + 1) as f64).sqrt();
            (bubbles + n - 1, scale * (above - below), scale * (above_slope - below_slope))
        }));
        functions
    }
}

/// Consecutive elements of similar length, in equal groups of at most [`PANEL`].
fn groups(elements: &[Element]) -> Vec<&[Element]> {
    let mut groups = Vec::new();
    let mut rest = elements;
    while let Some(first) = rest.first() {
        let (mut low, mut high) = (first.length(), first.length());
        let alike = |element: &&Element| {
            (low, high) = (low.min(element.length()), high.max(element.length()));
            high <= ALIKE * low
        };
        let count = rest.iter().take_while(alike).count();
        let (run, after) = rest.split_at(count);
        let parts = count.div_ceil(PANEL);
        groups.extend((0..parts).map(|i| &run[i * count / parts..(i + 1) * count / parts]));
        rest = after;
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::condition::BoundaryCondition;

    /// The far end of depth 103 m whose elements have the given ends, from the surface down.
    fn far_end(ends: &[f64]) -> Vec<Element> {
        let element = |pair: &[f64]| Element {
            start: [0.0, pair[0]],
            end: [0.0, pair[1]],
            condition: BoundaryCondition::Radiation,
        };
        ends.windows(2).map(element).collect()
    }

    /// One panel, several, graded ones; with p = 0 and ∂p/∂y = 0 at the surface. Galerkin's method converges
    /// exponentially for modes with π points per wave.
    #[test]
    fn modes_over_a_rigid_bed_are_the_cosines() -> Result<(), ReservoirError> {
        let depth = 103.0;
        let uniform = |n: i32| (0..=n).map(|i| depth * f64::from(n - i) / f64::from(n)).collect::<Vec<_>>();
        let mut graded: Vec<f64> = (0..=10).map(|j| depth - 0.02 * (2f64.powi(j) - 1.0)).collect();
        let reached = graded[10];
        graded.extend((1..=10).map(|i| reached * (1.0 - f64::from(i) / 10.0)));
        for (what, ends) in [("16", uniform(16)), ("100", uniform(100)), ("graded", graded)] {
            for free_top in [false, true] {
                let channel = Channel::new(&far_end(&ends), free_top, 14, 2)?;
                let mut worst: f64 = 0.0;
                for m in 0..4 {
                    let exact = if free_top { m as f64 } else { m as f64 + 0.5 } * PI / depth;
                    worst = worst.max((channel.squared_eigenvalues[m].sqrt() - exact).abs() * depth);
                    let norm = (2.0 / depth).sqrt() * if free_top && m == 0 { 0.5f64.sqrt() } else { 1.0 };
                    let sign = channel.values(0.0)[m].signum();
                    for i in 0..=50 {
                        let y = depth * f64::from(i) / 50.0;
                        worst = worst.max((channel.values(y)[m] * sign / norm - (exact * y).cos()).abs());
                    }
                }
                println!(
                    "{what} elements, free top {free_top}: {} functions, modes off by {worst:.1e}",
                    channel.size()
                );
                assert!(worst < 2e-3);
            }
        }
        Ok(())
    }

    #[test]
    fn groups_are_of_like_length_and_not_too_large() {
        let uniform: Vec<f64> = (0..=1000).map(f64::from).rev().collect();
        let elements = far_end(&uniform);
        let sizes: Vec<usize> = groups(&elements).iter().map(|g| g.len()).collect();
        assert_eq!(sizes.iter().sum::<usize>(), 1000);
        assert!(sizes.iter().all(|n| (15..=16).contains(n)));
        let doubling: Vec<f64> = (0..=9).map(|j| -(2f64.powi(j))).collect();
        let elements = far_end(&doubling);
        assert_eq!(groups(&elements).iter().map(|g| g.len()).collect::<Vec<_>>(), [3, 3, 3]);
    }
}
