//! Mapping of fields between the faces of two units whose points do not match.

mod location;
mod mass_matrix;

use cofferdam_unit::WetFace;
use location::{arc_lengths, check_panels, distance, located};
use mass_matrix::{MassMatrix, products};
use nalgebra::{DMatrix, DVectorView, DVectorViewMut};

/// Maps fields forward from the points of a first unit to those of a second, and back by the adjoint.
///
/// Both units divide the same face into panels, each in its own way. Fields are linear along panels and may jump
/// where two points coincide. With the hat functions N₁ and N₂ of the two, each field is mapped to the field of the
/// other unit that is nearest in mean square:
///
/// ```text
/// M₂ v₂ = C v₁,   M₁ p₁ = Cᵀ p₂,   C = ∫ N₂ N₁ᵀ ds,   M = ∫ N Nᵀ ds
/// ```
///
/// The forward mapping is *consistent*: fields that are linear along the face are mapped exactly, in both directions. The
/// adjoint is *conservative*: the work `p₁ᵀ M₁ v₁ = p₂ᵀ M₂ v₂` is the same on both sides; and, because M₁ p₁ are the nodal
/// forces of the first unit, so are force and moment on every part of it between double points, if its kinks have two points
/// (the normal is then a field of the first unit). Both hold to rounding and for all panels; the integrals are exact. Smooth
/// fields converge at second order. Where a field jumps and the receiving unit has a single point, the mapped field overshoots
/// slightly next to the jump.
///
/// If the points match, values are copied unchanged.
///
/// **Source**: the mortar projection of Bernardi, Maday and Patera (1994), applied on both sides; conservation as in
/// Farhat, Lesoinne and Le Tallec (1998).
#[derive(Clone, Debug)]
pub struct Mapping {
    /// `None` where points match.
    projection: Option<Projection>,
}

#[derive(Clone, Debug)]
struct Projection {
    first: MassMatrix,
    second: MassMatrix,
    /// M₂⁻¹ C.
    forward: DMatrix<f64>,
    /// M₁⁻¹ Cᵀ.
    adjoint: DMatrix<f64>,
}

/// Two faces that cannot be mapped.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MappingError {
    /// The faces end at different points.
    #[error(
        "the wet face ends at ({}, {}) in the {} and at ({}, {}) in the {}; both need the same end, at one \
         level", first[0], first[1], units[0], second[0], second[1], units[1]
    )]
    End {
        /// Names of the first unit and of the second.
        units: [String; 2],
        /// End of the first unit's face (x, y), m.
        first: [f64; 2],
        /// End of the second unit's face (x, y), m.
        second: [f64; 2],
    },
    /// A point of one face is not on the other (the furthest one is named): the outlines differ, or a panel cuts off
    /// a kink.
    #[error(
        "point {index} of the {unit}'s wet face, ({x}, {y}), lies {distance:.3e} m beside the {other}'s; {most:.0e} m are the \
         most, so give both the same outline"
    )]
    Apart {
        /// Unit whose point it is.
        unit: String,
        /// The other unit.
        other: String,
        /// Index of the point, from 0.
        index: usize,
        /// x, m.
        x: f64,
        /// y, m.
        y: f64,
        /// Distance from the other face, m.
        distance: f64,
        /// Largest distance allowed, m.
        most: f64,
    },
    /// A panel that is not longer than faces may lie apart.
    #[error(
        "the panel above point {index} of the {unit}'s wet face, ({x}, {y}), is {length:.3e} m long; {least:.0e} m are the \
         least, so leave one of its points out"
    )]
    ShortPanel {
        /// Unit whose panel it is.
        unit: String,
        /// Index of its lower point, from 0.
        index: usize,
        /// x of that, m.
        x: f64,
        /// y of that, m.
        y: f64,
        /// Length along the first unit's face, m.
        length: f64,
        /// Smallest length allowed, m.
        least: f64,
    },
}

/// Points closer than this share of the depth match.
const MATCHING: f64 = 1e-9;
/// Largest distance of the faces from each other, as a share of the depth.
const APART: f64 = 1e-6;

impl Mapping {
    /// The mapping between points that match.
    pub fn identity() -> Self {
        Self { projection: None }
    }

    /// The mapping from the face of a `first` unit to that of a `second`; `units` are their names, for messages.
    ///
    /// Positions and lengths are measured along the first face, onto which the points of the second are projected.
    ///
    /// **Errors**: [`MappingError`], if the faces are more than a millionth of the depth apart anywhere, or panels not
    /// longer than that.
    pub fn between(units: [&str; 2], first: &WetFace, second: &WetFace) -> Result<Self, MappingError> {
        let [first_name, second_name] = units;
        let near =
            |share: f64| move |(a, b): (&[f64; 2], &[f64; 2])| distance(*a, *b) <= share * first.depth();
        if first.len() == second.len() && first.points().iter().zip(second.points()).all(near(MATCHING)) {
            return Ok(Self::identity());
        }
        let ends = [first, second].map(|face| face.points()[face.len() - 1]);
        if !near(APART)((&ends[0], &ends[1])) {
            let [first, second] = ends;
            return Err(MappingError::End { units: units.map(str::to_owned), first, second });
        }
        let most = APART * first.depth();
        let mut on_second = located([second_name, first_name], second, first, most)?;
        located(units, first, second, most)?;
        let on_first = arc_lengths(first);
        // Both faces end at the same point.
        on_second[second.len() - 1] = on_first[first.len() - 1];
        check_panels(first_name, first, &on_first, most)?;
        check_panels(second_name, second, &on_second, most)?;

        let mut forward = products(&on_second, &on_first);
        let mut adjoint = forward.transpose();
        let (first, second) = (MassMatrix::new(&on_first), MassMatrix::new(&on_second));
        forward.as_mut_slice().chunks_exact_mut(on_second.len()).for_each(|column| second.solve(column));
        adjoint.as_mut_slice().chunks_exact_mut(on_first.len()).for_each(|column| first.solve(column));
        Ok(Self { projection: Some(Projection { first, second, forward, adjoint }) })
    }

    /// Whether points match, so that values are only copied.
    pub fn is_identity(&self) -> bool {
        self.projection.is_none()
    }

    /// `second = M₂⁻¹ C first`: the consistent mapping of a field of the first unit.
    ///
    /// **Shapes**: one value a point of the first unit's face; one a point of the second's. **Panics** with others.
    pub fn forward(&self, first: &[f64], second: &mut [f64]) {
        pass(self.projection.as_ref().map(|p| &p.forward), first, second);
    }

    /// `first = M₁⁻¹ Cᵀ second`: the conservative mapping of a field of the second unit.
    ///
    /// **Shapes**: one value a point of the second unit's face; one a point of the first's. **Panics** with others.
    pub fn adjoint(&self, second: &[f64], first: &mut [f64]) {
        pass(self.projection.as_ref().map(|p| &p.adjoint), second, first);
    }

    /// Difference between the two faces of the work of a field p₂ of the second unit on a field v₁ of the first,
    /// relative to the sum of the magnitudes of its terms: `|p₁ᵀ M₁ v₁ − p₂ᵀ M₂ v₂| / Σ|…|`.
    ///
    /// It is of the size of rounding; 0 if points match or if there is no work.
    ///
    /// **Shapes**: one value a point of the second unit's face; one a point of the first's. **Panics** with others.
    pub fn work_error(&self, second_effort: &[f64], first_flow: &[f64]) -> f64 {
        let Some(Projection { first, second, .. }) = &self.projection else { return 0.0 };
        let mut effort = vec![0.0; first_flow.len()];
        let mut flow = vec![0.0; second_effort.len()];
        self.adjoint(second_effort, &mut effort);
        self.forward(first_flow, &mut flow);
        let terms = |p: &[f64], v: Vec<f64>| p.iter().zip(v).map(|(p, v)| p * v).collect::<Vec<f64>>();
        let on_first = terms(&effort, first.times(first_flow));
        let on_second = terms(second_effort, second.times(&flow));
        let magnitudes: f64 = on_first.iter().chain(&on_second).map(|term| term.abs()).sum();
        let difference = on_first.iter().sum::<f64>() - on_second.iter().sum::<f64>();
        if magnitudes == 0.0 { 0.0 } else { difference.abs() / magnitudes }
    }
}

fn pass(matrix: Option<&DMatrix<f64>>, from: &[f64], to: &mut [f64]) {
    match matrix {
        Some(matrix) => {
            let (from, size) = (DVectorView::from_slice(from, from.len()), to.len());
            DVectorViewMut::from_slice(to, size).gemv(1.0, matrix, &from, 0.0);
        }
        None => to.copy_from_slice(from),
    }
}
