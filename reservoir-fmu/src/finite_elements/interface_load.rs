use super::element::edge_shape;
use super::mesh::BoundaryEdge;
use crate::quadrature::gauss_legendre;
use cofferdam_unit::WetFace;

/// The load matrix L of the wet face and the mass M_Γ of its panels.
///
/// `L_ij = ∫ N_i φ_j ds`, `M_Γ,ij = ∫ φ_i φ_j ds`, with the elements' shape functions N and the panels' hat functions φ, one
/// on either side of a crack. The pressure at the points does the same work on every velocity `Σ v_j φ_j`:
///
/// ```text
/// p_Γ = M_Γ⁻¹ Lᵀ p   ⇒   vᵀ M_Γ p_Γ = ∫ v p ds
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct InterfaceLoad {
    /// Unknown, point and `L_ij` (m).
    entries: Vec<(usize, usize, f64)>,
    /// M_Γ: diagonal entries, and the entry of each point with the next.
    diagonal: Vec<f64>,
    beside: Vec<f64>,
    /// Pivots of the elimination of M_Γ.
    pivots: Vec<f64>,
}

impl InterfaceLoad {
    /// Integrates exactly: between the ends of both edges and panels the integrand is a cubic.
    ///
    /// `edges` are those on the face, upwards; `unknowns` has the unknown of every node.
    pub fn new<'a>(
        face: &WetFace,
        edges: impl Iterator<Item = &'a BoundaryEdge>,
        unknowns: &[Option<usize>],
    ) -> Self {
        let panels: Vec<(usize, f64, f64)> = face
            .panels()
            .scan(0.0, |arc, panel| {
                let start = *arc;
                *arc += panel.length;
                Some((panel.start, start, panel.length))
            })
            .collect();
        let rule = gauss_legendre(2);
        let mut entries = Vec::new();
        let mut first = 0;
        for edge in edges {
            let edge_end = edge.arc + edge.length;
            first += panels[first..].iter().take_while(|p| p.1 + p.2 <= edge.arc).count();
            for &(point, panel_start, panel_length) in panels[first..].iter().take_while(|p| p.1 < edge_end) {
                let start = f64::max(edge.arc, panel_start);
                let length = f64::min(edge_end, panel_start + panel_length) - start;
                let mut local = [[0.0; 2]; 3];
                for q in rule.iter().filter(|_| length > 0.0) {
                    let arc = start + 0.5 * (1.0 + q.position) * length;
                    let along = (arc - panel_start) / panel_length;
                    let shapes = edge_shape((arc - edge.arc) / edge.length);
                    for (row, shape) in local.iter_mut().zip(shapes) {
                        row[0] += 0.5 * q.weight * length * shape * (1.0 - along);
                        row[1] += 0.5 * q.weight * length * shape * along;
                    }
                }
                for (node, row) in edge.nodes.into_iter().zip(local) {
                    if let Some(unknown) = unknowns[node] {
                        entries.push((unknown, point, row[0]));
                        entries.push((unknown, point + 1, row[1]));
                    }
                }
            }
        }
        let (mut diagonal, mut beside) = (vec![0.0; face.len()], vec![0.0; face.len() - 1]);
        for (point, _, length) in panels {
            diagonal[point] += length / 3.0;
            diagonal[point + 1] += length / 3.0;
            beside[point] = length / 6.0;
        }
        let mut pivots = diagonal.clone();
        for i in 1..pivots.len() {
            pivots[i] -= beside[i - 1] * beside[i - 1] / pivots[i - 1];
        }
        Self { entries, diagonal, beside, pivots }
    }

    /// Number of interface points.
    pub fn points(&self) -> usize {
        self.diagonal.len()
    }

    /// The unknowns that have a load, some of them several times.
    pub fn unknowns(&self) -> impl Iterator<Item = usize> {
        self.entries.iter().map(|(unknown, ..)| *unknown)
    }

    /// Adds `f L v` to the load on the unknowns.
    pub fn add(&self, factor: f64, velocity: &[f64], load: &mut [f64]) {
        for &(unknown, point, value) in &self.entries {
            load[unknown] += factor * value * velocity[point];
        }
    }

    /// `M_Γ⁻¹ Lᵀ p` (Pa).
    pub fn pressure(&self, p: &[f64]) -> Vec<f64> {
        let mut result = vec![0.0; self.points()];
        for &(unknown, point, value) in &self.entries {
            result[point] += value * p[unknown];
        }
        for i in 1..result.len() {
            result[i] -= self.beside[i - 1] / self.pivots[i - 1] * result[i - 1];
        }
        for i in (0..result.len()).rev() {
            let next = if i + 1 < result.len() { self.beside[i] * result[i + 1] } else { 0.0 };
            result[i] = (result[i] - next) / self.pivots[i];
        }
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::condition::BoundaryCondition;

    /// Edges and panels that do not match, with a crack: ∫ v p ds of a quadratic p on each edge against Gauss'
    /// rule on the common division; a p that is linear along the face is reproduced.
    #[test]
    fn work_is_the_integral_and_linear_pressure_comes_back() {
        let y = [0.0, 3.0, 5.0, 5.0, 6.5, 10.0];
        let face = WetFace::new(y.iter().map(|y| [0.0, *y]).collect()).unwrap();
        let ends = [0.0, 1.7, 2.5, 5.0, 8.0, 10.0];
        let edges: Vec<BoundaryEdge> = (0..5)
            .map(|e| {
                let (arc, length) = (ends[e], ends[e + 1] - ends[e]);
                let nodes = [2 * e, 2 * e + 1, 2 * e + 2];
                BoundaryEdge { nodes, condition: BoundaryCondition::WetFace, arc, length, normal: [1.0, 0.0] }
            })
            .collect();
        let unknowns: Vec<Option<usize>> = (0..11).map(Some).collect();
        let load = InterfaceLoad::new(&face, edges.iter(), &unknowns);
        let at: Vec<f64> = (0..11)
            .map(|n| if n % 2 == 0 { ends[n / 2] } else { 0.5 * (ends[n / 2] + ends[n / 2 + 1]) })
            .collect();

        let linear: Vec<f64> = at.iter().map(|y| 3.0 - 0.7 * y).collect();
        for (p, y) in load.pressure(&linear).iter().zip(y) {
            assert!((p - (3.0 - 0.7 * y)).abs() < 1e-13);
        }
        let quadratic = |y: f64| 1.0 - y + 0.3 * y * y;
        let p: Vec<f64> = at.iter().map(|y| quadratic(*y)).collect();
        let velocity = [1.0, -2.0, 0.5, 3.0, -1.0, 2.0];
        let given = load.pressure(&p);
        let work: f64 = (0..6)
            .map(|i| {
                let mut row = load.diagonal[i] * given[i];
                row += if i > 0 { load.beside[i - 1] * given[i - 1] } else { 0.0 };
                row += if i < 5 { load.beside[i] * given[i + 1] } else { 0.0 };
                velocity[i] * row
            })
            .sum();
        let rule = gauss_legendre(4);
        let integral: f64 = face
            .panels()
            .map(|panel| {
                let j = panel.start;
                let at = |q: f64| 0.5 * (1.0 + q);
                let part = |q: f64| {
                    quadratic(y[j] + at(q) * panel.length)
                        * (velocity[j] * (1.0 - at(q)) + velocity[j + 1] * at(q))
                };
                rule.iter().map(|q| 0.5 * panel.length * q.weight * part(q.position)).sum::<f64>()
            })
            .sum();
        println!("work {work}, integral {integral}");
        assert!((work / integral - 1.0).abs() < 1e-13);
    }
}
