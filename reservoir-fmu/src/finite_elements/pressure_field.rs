use super::FarEnd;
use super::domain::Domain;
use super::far_field::{Admittance, ChannelState, FarField};
use super::matrices::{Matrices, solve};
use crate::{Fidelity, ReservoirError, ReservoirParameters};
use cofferdam_unit::EndAcceleration;
use faer::sparse::linalg::solvers::Llt;

/// Steps that a wave takes through an element, and the most of them in a communication step: the motion is no finer than that.
const STEPS_PER_ELEMENT: f64 = 6.0;
const MOST_STEPS: f64 = 8.0;
/// Elements of the depth, and the time in which a wave passes one, s, at most: a quarter of a wave of 25 Hz.
const ELEMENTS: f64 = 8.0;
const PASSED: f64 = 0.01;
/// Size of the triangles at the outline's corners, over that of the others.
const AT_CORNERS: f64 = 1.0 / 16.0;
/// Distance of the far end, in depths.
const DEPTHS: f64 = 2.0;
/// Viscosity over ℓ²/(hc), ℓ the size of the elements: waves that they do not represent, above all in small elements at corners, die away.
const VISCOSITY: f64 = 0.004;
/// Lengths of steps whose factors are kept.
const KEPT: usize = 4;

/// Pressure inside the water before a dam whose motion is known: for pictures of a run.
///
/// Quadratic triangles between face, bed, surface and far end; upstream of it the water continues as a channel of constant depth, in which
/// waves travel away (`far_field`). They are stepped by the trapezoidal rule as in [`FiniteElements`](super::FiniteElements),
///
/// ```text
/// (M + τ/2 (C + C_f) + τ²/4 K) p̄ = M p₀ − τ/2 (K ψ₀ + ρ (L v̄ + L_g v̄_g) − ρ L_f v̄_f),   p₁ = 2 p̄ − p₀,  ψ₁ = ψ₀ + τ p̄
/// ```
///
/// with C_f and v_f of the far field. Incompressible water answers with `K p = −ρ (L a + L_g a_g)` and the acceleration
/// ([`EndAcceleration`]) at the step's end.
///
/// The pressure on the face is that of another method than the run's, not the run's own: where they differ is seen beside each other.
pub struct PressureField {
    domain: Domain,
    density: f64,
    gravity: f64,
    depth: f64,
    toe: Option<f64>,
    motion: Motion,
}

/// How the water answers.
enum Motion {
    Compressible(Box<Waves>),
    Incompressible { factors: Box<Llt<usize, f64>>, face: EndAcceleration, ground: [f64; 2] },
}

/// Compressible water.
struct Waves {
    far: FarField,
    state: State,
    /// The longest step that resolves waves in the elements, s.
    longest: f64,
    steps: Vec<Step>,
}

/// The water at an instant.
struct State {
    /// Pressure and its integral over time, at the unknowns.
    pressure: Vec<f64>,
    integral: Vec<f64>,
    /// Velocities of the interface points and of the ground, m/s.
    velocity: Vec<f64>,
    channel: ChannelState,
}

/// What steps of one length need.
struct Step {
    length: f64,
    factors: Llt<usize, f64>,
    admittance: Admittance,
}

impl PressureField {
    /// The mesh for pictures: h/8 and no more than a quarter of a wave of 25 Hz, finer at corners; the far end at 2h.
    pub fn usual_mesh(parameters: &ReservoirParameters) -> ReservoirParameters {
        let depth = parameters.wet_face.depth();
        let mut size = depth / ELEMENTS;
        if parameters.fidelity.has_memory() {
            size = size.min(parameters.sound_speed * PASSED);
        }
        ReservoirParameters {
            element_size: size,
            bed_element_size: None,
            corner_element_size: Some(size * AT_CORNERS),
            far_end_distance: DEPTHS * depth,
            ..parameters.clone()
        }
    }

    /// The water at rest in elements of the parameters' sizes; steps are usually of their communication step.
    ///
    /// **Errors**: parameters out of range, [`ReservoirError::NoField`] for Westergaard's water, [`ReservoirError::Mesh`],
    /// [`ReservoirError::TooMuch`], [`ReservoirError::FiniteElementSystem`], and those of a recursion for the channel.
    pub fn new(parameters: &ReservoirParameters) -> Result<Self, ReservoirError> {
        parameters.validate()?;
        let ReservoirParameters { density, gravity, toe, .. } = *parameters;
        let (domain, motion) = match parameters.fidelity {
            Fidelity::Compressible => {
                let mut domain = Domain::new(parameters, FarEnd::Rigid)?;
                let share = parameters.element_size / parameters.wet_face.depth();
                let passed = parameters.element_size / parameters.sound_speed;
                domain.matrices = domain.matrices.with_viscosity(VISCOSITY * share * passed);
                let longest = passed / STEPS_PER_ELEMENT;
                let (_, usual) = divided(parameters.communication_step, longest);
                // Fitted for waves that long steps, too, pass through elements.
                let far = FarField::new(parameters, &domain, usual.min(longest))?;
                let size = domain.matrices.size();
                let state = State {
                    pressure: vec![0.0; size],
                    integral: vec![0.0; size],
                    velocity: vec![0.0; parameters.wet_face.len() + 2],
                    channel: far.at_rest(),
                };
                (domain, Motion::Compressible(Box::new(Waves { far, state, longest, steps: Vec::new() })))
            }
            Fidelity::Incompressible => {
                let still = ReservoirParameters {
                    sound_speed: f64::INFINITY,
                    wave_reflection_coefficient: 1.0,
                    ..parameters.clone()
                };
                let domain = Domain::new(&still, FarEnd::Decay)?;
                // M and C are zero: what is left of a step of 2 s is K.
                let factors = Box::new(domain.matrices.factor(2.0)?);
                let face = EndAcceleration::at_rest(parameters.wet_face.len());
                (domain, Motion::Incompressible { factors, face, ground: [0.0; 2] })
            }
            Fidelity::Westergaard | Fidelity::WestergaardExact => return Err(ReservoirError::NoField),
        };
        let depth = parameters.wet_face.depth();
        Ok(Self { domain, density, gravity, depth, toe, motion })
    }

    /// Goes on by `length` (s): mean acceleration of the interface points along n, acceleration of the ground (x, y) at the begin and the
    /// end, linear in between, all in m/s² and in the dam's coordinates.
    ///
    /// **Errors**: [`ReservoirError::NotPositive`], [`ReservoirError::FiniteElementSystem`].
    pub fn advance(
        &mut self,
        face: &[f64],
        ground: [[f64; 2]; 2],
        length: f64,
    ) -> Result<(), ReservoirError> {
        if !(length > 0.0 && length.is_finite()) {
            let parameter = "communication_step";
            return Err(ReservoirError::NotPositive { parameter, value: length, unit: "s" });
        }
        let [begin, end] = ground.map(|[x, y]| [if self.toe.is_some() { -x } else { x }, y]);
        match &mut self.motion {
            Motion::Incompressible { face: mean, ground, .. } => {
                mean.step(face, length);
                *ground = end;
                Ok(())
            }
            Motion::Compressible(waves) => {
                let (count, step) = divided(length, waves.longest);
                let at = waves.prepared(step, self.density, &self.domain)?;
                for i in 0..count {
                    let share = (i as f64 + 0.5) / count as f64;
                    let of_ground = [0, 1].map(|axis| begin[axis] + (end[axis] - begin[axis]) * share);
                    let means: Vec<f64> = face.iter().chain(&of_ground).copied().collect();
                    waves.step(at, &means, self.density, &self.domain)?;
                }
                Ok(())
            }
        }
    }

    /// Hydrodynamic pressure at every node, Pa.
    pub fn pressure(&self) -> Vec<f64> {
        match &self.motion {
            Motion::Compressible(waves) => self.domain.at_nodes(&waves.state.pressure),
            Motion::Incompressible { factors, face, ground } => {
                let mut load = vec![0.0; self.domain.matrices.size()];
                let accelerations: Vec<f64> = face.at_end.iter().chain(ground).copied().collect();
                self.domain.add(-self.density, &accelerations, &mut load);
                self.domain.at_nodes(&solve(factors, &load))
            }
        }
    }

    /// Hydrostatic pressure ρg(h − y) at every node, Pa.
    pub fn hydrostatic_pressure(&self) -> Vec<f64> {
        let nodes = self.domain.mesh.nodes.iter();
        nodes.map(|node| self.density * self.gravity * (self.depth - node[1])).collect()
    }

    /// The nodes in the dam's coordinates, m.
    pub fn nodes(&self) -> Vec<[f64; 2]> {
        let nodes = self.domain.mesh.nodes.iter();
        nodes.map(|&[x, y]| [self.toe.map_or(x, |toe| toe - x), y]).collect()
    }

    /// The nodes of each triangle: corners counterclockwise, then the middles of the sides from the first corner to the second, the second
    /// to the third, the third to the first.
    pub fn triangles(&self) -> Vec<[usize; 6]> {
        let own = self.domain.mesh.triangles.iter().copied();
        // In the mirror the corners go round the other way.
        own.map(
            |[a, b, c, ab, bc, ca]| {
                if self.toe.is_some() { [a, c, b, ca, bc, ab] } else { [a, b, c, ab, bc, ca] }
            },
        )
        .collect()
    }
}

/// A length in equal steps, of at most `longest` if they are not too many: their number and length.
fn divided(length: f64, longest: f64) -> (usize, f64) {
    let count = (length / longest * (1.0 - 1e-9)).ceil().clamp(1.0, MOST_STEPS);
    (count as usize, length / count)
}

impl Waves {
    /// The place of what steps of `length` need, made if it is not there.
    fn prepared(&mut self, length: f64, density: f64, domain: &Domain) -> Result<usize, ReservoirError> {
        if let Some(at) = self.steps.iter().position(|step| step.length == length) {
            return Ok(at);
        }
        let singular = || ReservoirError::FiniteElementSystem { rate: 2.0 / length };
        let admittance = self.far.admittance(length).ok_or_else(singular)?;
        let size = domain.matrices.size();
        let damped: Matrices = domain.matrices.plus(self.far.damping(&admittance, density, size));
        if self.steps.len() == KEPT {
            self.steps.remove(0);
        }
        self.steps.push(Step { length, factors: damped.factor(length)?, admittance });
        Ok(self.steps.len() - 1)
    }

    /// A step with mean accelerations of interface points and ground.
    fn step(
        &mut self,
        at: usize,
        means: &[f64],
        density: f64,
        domain: &Domain,
    ) -> Result<(), ReservoirError> {
        let Self { far, state, steps, .. } = self;
        let Step { length, factors, admittance } = &steps[at];
        let half = 0.5 * length;
        let before = state.velocity.clone();
        state.velocity.iter_mut().zip(means).for_each(|(v, a)| *v += length * a);
        let mean: Vec<f64> = before.iter().zip(&state.velocity).map(|(a, b)| 0.5 * (a + b)).collect();
        let ground = &state.velocity[before.len() - 2..];

        let mut right = domain.matrices.mass_and_stiffness(&state.pressure, -half, &state.integral);
        domain.add(-half * density, &mean, &mut right);
        let begun = far.begin(&state.channel, admittance, *length, &state.pressure, ground);
        let begun = begun.ok_or(ReservoirError::ForeignMemory)?;
        far.add(half * density, &begun.known, &mut right);
        let means = solve(factors, &right);
        for ((p, psi), mean) in state.pressure.iter_mut().zip(&mut state.integral).zip(&means) {
            *psi += length * mean;
            *p = 2.0 * mean - *p;
        }
        let channel = far.end(&state.channel, admittance, &begun, *length, &state.pressure, ground);
        state.channel = channel.ok_or(ReservoirError::ForeignMemory)?;
        Ok(())
    }
}
