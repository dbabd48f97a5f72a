use super::domain::Domain;
use super::interface_load::InterfaceLoad;
use super::matrices::Entry;
use super::mesh::BoundaryEdge;
use crate::condition::BoundaryCondition;
use crate::parameters::ALMOST_RIGID;
use crate::rational::{Recursion, recursion};
use crate::time_domain::{Memory, TimeDomain};
use crate::{Fidelity, Method, ReservoirError, ReservoirParameters};
use cofferdam_unit::WetFace;
use nalgebra::{DMatrix, DVector};

/// The channel upstream of the far end, as a recursion of its own.
///
/// At the far end both waters have the same pressure at the points of its panels, and the same velocity v along the channel's
/// normal out of it, linear along the panels. A step of the channel gives
///
/// ```text
/// p = p_free + Z v,   Z = ∂p/∂v < 0,   so that   v = Z⁻¹ (P p_field − p_free),   P = M_Γ⁻¹ Lᵀ
/// ```
///
/// with L and M_Γ of the far end as on the face. For the finite elements −ρ L Z⁻¹ P is a damping, symmetric because M_Γ Z is, and the
/// rest is a load. Finite elements and recursion are passive and do the same work on each other: nothing can grow.
pub struct FarField {
    channel: Recursion,
    load: InterfaceLoad,
}

/// The channel after a step.
#[derive(Clone)]
pub struct ChannelState {
    memory: Memory,
    /// Velocity at the points of the far end, m/s.
    velocity: Vec<f64>,
}

/// A step of the channel for which its pressure at the end is known.
pub struct Begun {
    /// p_free, Pa.
    free: Vec<f64>,
    /// The load's velocity: mean over the step, less what the pressure's mean causes.
    pub known: Vec<f64>,
}

/// Z⁻¹ for steps of one length.
pub struct Admittance(DMatrix<f64>);

impl FarField {
    /// The channel of the parameters' water, fitted for steps of `step` (s); others take more time.
    ///
    /// An almost rigid bed, which no recursion fits, counts as rigid; gravity waves are left out.
    ///
    /// **Errors**: [`ReservoirError::NotFitted`], [`ReservoirError::Recursion`], [`ReservoirError::Mesh`].
    pub fn new(parameters: &ReservoirParameters, domain: &Domain, step: f64) -> Result<Self, ReservoirError> {
        let depth = parameters.channel_depth();
        let panels = (depth / parameters.element_size).ceil();
        let end = WetFace::straight([0.0, depth], panels as usize).map_err(|_| ReservoirError::Mesh)?;
        let alpha = parameters.wave_reflection_coefficient;
        let of_channel = ReservoirParameters {
            density: parameters.density,
            sound_speed: parameters.sound_speed,
            gravity: parameters.gravity,
            wave_reflection_coefficient: if alpha < ALMOST_RIGID { alpha } else { 1.0 },
            fidelity: Fidelity::Compressible,
            method: Method::Recursive,
            communication_step: step,
            ..ReservoirParameters::before(end.clone())
        };
        let (channel, _) = recursion(&of_channel)?;
        // Upwards, as on a face.
        let mut edges: Vec<BoundaryEdge> = domain.mesh.edges(BoundaryCondition::Radiation).cloned().collect();
        edges.reverse();
        let mut arc = 0.0;
        for edge in &mut edges {
            edge.nodes.reverse();
            edge.arc = arc;
            arc += edge.length;
        }
        Ok(Self { channel, load: InterfaceLoad::new(&end, edges.iter(), &domain.unknowns) })
    }

    /// The channel at rest.
    pub fn at_rest(&self) -> ChannelState {
        ChannelState { memory: self.channel.at_rest(), velocity: vec![0.0; self.load.points()] }
    }

    /// Z⁻¹ of steps of `length` (s); none if it is singular.
    pub fn admittance(&self, length: f64) -> Option<Admittance> {
        let response = self.channel.instantaneous(length);
        response.columns(0, self.load.points()).into_owned().try_inverse().map(Admittance)
    }

    /// −ρ L Z⁻¹ P, the far end's part of the damping matrix over the density; `size` is the number of unknowns.
    pub fn damping(&self, Admittance(inverse): &Admittance, density: f64, size: usize) -> Vec<Entry> {
        let mut unknowns: Vec<usize> = self.load.unknowns().collect();
        unknowns.sort_unstable();
        unknowns.dedup();
        let mut columns = Vec::with_capacity(unknowns.len());
        for &unknown in &unknowns {
            let (mut unit, mut column) = (vec![0.0; size], vec![0.0; size]);
            unit[unknown] = 1.0;
            let velocity = inverse * DVector::from_vec(self.load.pressure(&unit));
            self.load.add(-density, velocity.as_slice(), &mut column);
            columns.push(column);
        }
        let entry = |(i, j): (usize, usize)| {
            let value = 0.5 * (columns[j][unknowns[i]] + columns[i][unknowns[j]]);
            (unknowns[i], unknowns[j], [0.0, value, 0.0])
        };
        let count = unknowns.len();
        (0..count).flat_map(|i| (0..count).map(move |j| (i, j))).map(entry).collect()
    }

    /// Begins a step from pressures at the unknowns, with the ground's velocity at its end; none for a foreign state.
    pub fn begin(
        &self,
        state: &ChannelState,
        Admittance(inverse): &Admittance,
        length: f64,
        pressure: &[f64],
        ground: &[f64],
    ) -> Option<Begun> {
        let free = self.channel.pressure(
            &state.memory,
            &with_ground(&vec![0.0; self.load.points()], ground),
            length,
        )?;
        let sum = DVector::from_vec(self.load.pressure(pressure)) + DVector::from_column_slice(&free);
        let known = 0.5 * (DVector::from_column_slice(&state.velocity) - inverse * sum);
        Some(Begun { free, known: known.data.into() })
    }

    /// Adds `f L v` to the load on the unknowns.
    pub fn add(&self, factor: f64, velocity: &[f64], load: &mut [f64]) {
        self.load.add(factor, velocity, load);
    }

    /// Ends it with the pressures at the unknowns there; none for a foreign state.
    pub fn end(
        &self,
        state: &ChannelState,
        Admittance(inverse): &Admittance,
        begun: &Begun,
        length: f64,
        pressure: &[f64],
        ground: &[f64],
    ) -> Option<ChannelState> {
        let difference =
            DVector::from_vec(self.load.pressure(pressure)) - DVector::from_column_slice(&begun.free);
        let velocity: Vec<f64> = (inverse * difference).data.into();
        let memory = self.channel.push(&state.memory, &with_ground(&velocity, ground), length)?;
        Some(ChannelState { memory, velocity })
    }
}

fn with_ground(velocity: &[f64], ground: &[f64]) -> Vec<f64> {
    [velocity, ground].concat()
}
