//! Mapping of fields between the wet faces of the two units where their points do not match.

mod location;
mod mass_matrix;

use interface::WetFace;
use location::{arc_lengths, check_panels, distance, located};
use mass_matrix::{MassMatrix, products};
use nalgebra::{DMatrix, DVectorView, DVectorViewMut};

/// Maps motion from the dam's points to the reservoir's, and pressure back.
///
/// Both units divide the same wet face into panels, each in its own way. Fields are linear along panels and may jump
/// where two points coincide. With the hat functions N_d and N_r of the two, each field is mapped to the field of the
/// other unit that is nearest in the mean square:
///
/// ```text
/// M_r a_r = C a_d,   M_d p_d = Cᵀ p_r,   C = ∫ N_r N_dᵀ ds,   M = ∫ N Nᵀ ds
/// ```
///
/// The integrals are exact. To rounding, and for all panels: fields that are linear along the face are mapped exactly
/// in both directions; the work `p_dᵀ M_d v_d = p_rᵀ M_r v_r` is conserved; and, because M_d p_d are the nodal forces
/// of the dam, so are force and moment on every part of the dam between double points, if its kinks have two points
/// (the normal is then a field of the dam). Smooth fields converge with order 2. Where a field jumps and the
/// receiving unit has a single point, the mapped field overshoots slightly beside the jump.
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
    dam: MassMatrix,
    reservoir: MassMatrix,
    /// M_r⁻¹ C.
    motion: DMatrix<f64>,
    /// M_d⁻¹ Cᵀ.
    pressure: DMatrix<f64>,
}

/// Two wet faces that cannot be mapped.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MappingError {
    /// The faces end at different points.
    #[error(
        "the wet face ends at ({dam_x}, {dam_y}) in the dam and at ({reservoir_x}, {reservoir_y}) in the reservoir; both \
         need the same water level"
    )]
    End {
        /// x in the dam, m.
        dam_x: f64,
        /// y in the dam, m.
        dam_y: f64,
        /// x in the reservoir, m.
        reservoir_x: f64,
        /// y in the reservoir, m.
        reservoir_y: f64,
    },
    /// A point of one face is not on the other (the furthest one is named): the outlines differ, or a panel cuts off
    /// a kink.
    #[error(
        "point {index} of the {unit}'s wet face, ({x}, {y}), lies {distance:.3e} m beside the {other}'s; {most:.0e} m are the \
         most, so give both the same outline"
    )]
    Apart {
        /// Unit whose point it is.
        unit: &'static str,
        /// The other unit.
        other: &'static str,
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
        unit: &'static str,
        /// Index of its lower point, from 0.
        index: usize,
        /// x of that, m.
        x: f64,
        /// y of that, m.
        y: f64,
        /// Length along the dam's face, m.
        length: f64,
        /// Least length allowed, m.
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

    /// The mapping between the wet faces of `dam` and `reservoir`.
    ///
    /// Positions and lengths are measured along the dam's face, onto which the reservoir's points are projected.
    ///
    /// **Errors**: [`MappingError`], if the faces are more than a millionth of the depth apart anywhere, or panels not
    /// longer than that.
    pub fn new(dam: &WetFace, reservoir: &WetFace) -> Result<Self, MappingError> {
        let near = |share: f64| move |(a, b): (&[f64; 2], &[f64; 2])| distance(*a, *b) <= share * dam.depth();
        if dam.len() == reservoir.len() && dam.points().iter().zip(reservoir.points()).all(near(MATCHING)) {
            return Ok(Self::identity());
        }
        let ends = [dam, reservoir].map(|face| face.points()[face.len() - 1]);
        if !near(APART)((&ends[0], &ends[1])) {
            let [[dam_x, dam_y], [reservoir_x, reservoir_y]] = ends;
            return Err(MappingError::End { dam_x, dam_y, reservoir_x, reservoir_y });
        }
        let most = APART * dam.depth();
        let mut on_reservoir = located(["reservoir", "dam"], reservoir, dam, most)?;
        located(["dam", "reservoir"], dam, reservoir, most)?;
        let on_dam = arc_lengths(dam);
        // Both faces end at the water level.
        on_reservoir[reservoir.len() - 1] = on_dam[dam.len() - 1];
        check_panels("dam", dam, &on_dam, most)?;
        check_panels("reservoir", reservoir, &on_reservoir, most)?;

        let mut motion = products(&on_reservoir, &on_dam);
        let mut pressure = motion.transpose();
        let (dam, reservoir) = (MassMatrix::new(&on_dam), MassMatrix::new(&on_reservoir));
        motion.as_mut_slice().chunks_exact_mut(on_reservoir.len()).for_each(|column| reservoir.solve(column));
        pressure.as_mut_slice().chunks_exact_mut(on_dam.len()).for_each(|column| dam.solve(column));
        Ok(Self { projection: Some(Projection { dam, reservoir, motion, pressure }) })
    }

    /// Whether points match, so that values are only copied.
    pub fn is_identity(&self) -> bool {
        self.projection.is_none()
    }

    /// `reservoir = M_r⁻¹ C dam`: displacement, velocity or acceleration along n.
    ///
    /// **Shapes**: one value a point of the dam's face; one a point of the reservoir's. **Panics** with others.
    pub fn motion_to_reservoir(&self, dam: &[f64], reservoir: &mut [f64]) {
        pass(self.projection.as_ref().map(|p| &p.motion), dam, reservoir);
    }

    /// `dam = M_d⁻¹ Cᵀ reservoir`: pressure, hydrodynamic or hydrostatic.
    ///
    /// **Shapes**: one value a point of the reservoir's face; one a point of the dam's. **Panics** with others.
    pub fn pressure_to_dam(&self, reservoir: &[f64], dam: &mut [f64]) {
        pass(self.projection.as_ref().map(|p| &p.pressure), reservoir, dam);
    }

    /// Difference between the two faces of the work of a pressure p_r of the reservoir on a velocity v_d of the dam,
    /// relative to the sum of the magnitudes of its terms: `|p_dᵀ M_d v_d − p_rᵀ M_r v_r| / Σ|…|`.
    ///
    /// It is of the size of rounding; 0 if points match or if there is no work.
    ///
    /// **Shapes**: one value a point of the reservoir's face; one a point of the dam's. **Panics** with others.
    pub fn work_error(&self, reservoir_pressure: &[f64], dam_velocity: &[f64]) -> f64 {
        let Some(Projection { dam, reservoir, .. }) = &self.projection else { return 0.0 };
        let mut pressure = vec![0.0; dam_velocity.len()];
        let mut velocity = vec![0.0; reservoir_pressure.len()];
        self.pressure_to_dam(reservoir_pressure, &mut pressure);
        self.motion_to_reservoir(dam_velocity, &mut velocity);
        let terms = |p: &[f64], v: Vec<f64>| p.iter().zip(v).map(|(p, v)| p * v).collect::<Vec<f64>>();
        let on_dam = terms(&pressure, dam.times(dam_velocity));
        let on_reservoir = terms(reservoir_pressure, reservoir.times(&velocity));
        let magnitudes: f64 = on_dam.iter().chain(&on_reservoir).map(|term| term.abs()).sum();
        let difference = on_dam.iter().sum::<f64>() - on_reservoir.iter().sum::<f64>();
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
