//! The outputs of the dam, computed from its state.

use cofferdam_unit::{CallError, Causality, Packable, Shape, Variable, variables::dam as variable};

use crate::block::best_fit_rotation;
use crate::contact::{ContactStatus, Crack, CrackForces, JointState, MohrCoulomb};
use crate::mesh::CrackPath;
use crate::stress::PrincipalStresses;
use crate::{Dam, DamError, Kinematics};

impl Dam {
    /// Writes the values of `variable`.
    ///
    /// **Errors**: [`CallError::Order`](cofferdam_unit::CallError::Order) before initialisation, for variables
    /// that exist only after it.
    pub(super) fn output(&self, variable: &'static Variable, values: &mut [f64]) -> Result<(), DamError> {
        let state = self.state();
        let from_motion = matches!(variable.causality, Causality::Output | Causality::Local)
            || *variable == variable::CREST_STATIC_DISPLACEMENT;
        if from_motion && !state.initialised {
            return Err(self.order("get").into());
        }
        if !self.parameters().has(variable) {
            // It has no values.
            return Ok(());
        }
        if let Some(found) = self.envelope(variable) {
            // An intact dam has places of contacts, but nothing happens there.
            values.fill(0.0);
            values.iter_mut().zip(found).for_each(|(value, found)| *value = found);
            return Ok(());
        }
        match variable.shape {
            Shape::InterfacePoints | Shape::TailwaterPoints => {
                return copy(&self.at_points(variable)?[self.points(variable)], values);
            }
            Shape::StressPoints => return self.at_stress_points(variable, values),
            Shape::Nodes | Shape::Triangles | Shape::Contacts => return self.field(variable, values),
            _ => {}
        }
        let parameters = self.parameters();
        let energy = state.energy();
        let gained = energy.gained();
        let crest = self.crest;
        let scalar = match *variable {
            variable::GROUND_ACCELERATION => return copy(&state.next.ground_acceleration, values),
            variable::CREST_DISPLACEMENT => return copy(&self.displacement(crest), values),
            variable::CREST_ACCELERATION => return copy(&self.acceleration(crest), values),
            variable::LARGEST_PRINCIPAL_STRESS => self.principal_stresses().largest.0,
            variable::SMALLEST_PRINCIPAL_STRESS => self.principal_stresses().smallest.0,
            variable::LARGEST_PRINCIPAL_STRESS_PLACE => {
                return copy(&self.structure().mesh.nodes[self.principal_stresses().largest.1], values);
            }
            variable::SMALLEST_PRINCIPAL_STRESS_PLACE => {
                return copy(&self.structure().mesh.nodes[self.principal_stresses().smallest.1], values);
            }
            variable::CREST_STATIC_DISPLACEMENT => return copy(&self.at_node(crest, &state.rest), values),
            variable::NATURAL_FREQUENCY => return copy(&self.natural_frequencies(values.len())?, values),
            variable::BASE_SHEAR => state.mean_base_force[0],
            variable::BASE_NORMAL_FORCE => -state.mean_base_force[1],
            variable::KINETIC_ENERGY => gained.kinetic,
            variable::STRAIN_ENERGY => gained.strain,
            variable::CONTACT_ENERGY => gained.contact,
            variable::FRICTION_WORK => energy.work.friction,
            variable::DAMPING_WORK => energy.work.damping,
            variable::INPUT_WORK => energy.work.input,
            variable::ENERGY_BALANCE_ERROR => energy.balance_error(),
            variable::INPUTS_HELD => parameters.inputs_held,
            variable::YOUNG_MODULUS => parameters.material.young_modulus,
            variable::POISSON_RATIO => parameters.material.poisson_ratio,
            variable::DENSITY => parameters.material.density,
            variable::DAMPING_RATIO => parameters.damping.ratio(),
            variable::DAMPING_FREQUENCY_LOW => self.damping_frequencies()[0],
            variable::DAMPING_FREQUENCY_HIGH => self.damping_frequencies()[1],
            variable::ELEMENT_SIZE => parameters.element_size,
            variable::TIME_STEP_LIMIT => self.time_step_limit(),
            variable::ADDED_MASS_INCLUDED => f64::from(parameters.added_mass.is_some()),
            _ => {
                for (crack, value) in values.iter_mut().enumerate() {
                    *value = self.crack_output(variable, crack)?;
                }
                return Ok(());
            }
        };
        copy(&[scalar], values)
    }

    /// Displacements (m) along `axis` at these nodes, NaN where there is none; no others are computed.
    pub(super) fn displacements_at(&self, axis: usize, nodes: &[usize], values: &mut [f64]) {
        let exists = |node: usize| node < self.structure().mesh.nodes.len();
        let at = |node: usize| if exists(node) { self.displacement(node)[axis] } else { f64::NAN };
        values.iter_mut().zip(nodes).for_each(|(value, node)| *value = at(*node));
    }

    fn crack_output(&self, variable: &Variable, crack: usize) -> Result<f64, DamError> {
        let parameters = &self.cracks()[crack];
        // an intact dam has no contacts
        let joints = || self.parts(crack).filter_map(|part| self.state().motion.joints().get(part)).flatten();
        let count = |statuses: &[ContactStatus]| {
            joints().filter(|joint| statuses.contains(&joint.status)).count() as f64
        };
        Ok(match *variable {
            variable::CRACK_SLIDING => self.mean_of_parts(crack, |part| self.sliding(part)),
            variable::CRACK_OPENING => {
                let touching = joints().filter(|joint| joint.status != ContactStatus::Lost);
                touching.map(|joint| joint.gap).fold(0.0, f64::max)
            }
            variable::CRACK_ROTATION => self.mean_of_parts(crack, |part| self.rotation(part)),
            variable::CRACK_STICKING => count(&[ContactStatus::Sticking]),
            variable::CRACK_SLIPPING => count(&[ContactStatus::Slipping]),
            variable::CRACK_OPEN => count(&[ContactStatus::Open, ContactStatus::Lost]),
            variable::CRACK_UPLIFT_FORCE => {
                let Some(joints) = &self.model.body().joints else { return Ok(0.0) };
                let mut pressures = self.state().uplift.clone();
                let contacts = self.state().motion.joints();
                joints.without_relief(&self.structure().cracks, contacts, &mut pressures);
                joints.force(crack, &pressures)
            }
            variable::CRACK_NORMAL_FORCE => self.crack_forces(crack).normal,
            variable::CRACK_SHEAR_FORCE => self.crack_forces(crack).shear,
            variable::CRACK_SHEAR_UTILISATION => match self.crack_forces(crack) {
                CrackForces { strength: 0.0, .. } => 0.0,
                CrackForces { shear, strength, .. } => shear.abs() / strength,
            },
            variable::CRACK_MOMENT => self.crack_moment(crack),
            variable::CRACK_OPEN_SHARE => 1.0 - self.share(crack, Crack::touching).unwrap_or(1.0),
            variable::CRACK_BONDED_SHARE => self.share(crack, Crack::bonded).unwrap_or(0.0),
            variable::CRACK_ACCELERATION_BELOW => {
                self.mean_of_parts(crack, |part| self.side_acceleration(part, 0))
            }
            variable::CRACK_ACCELERATION_ABOVE => {
                self.mean_of_parts(crack, |part| self.side_acceleration(part, 1))
            }
            variable::FRICTION_COEFFICIENT => parameters.friction_coefficient,
            variable::NORMAL_STIFFNESS => parameters.normal_stiffness,
            variable::SHEAR_STIFFNESS => parameters.shear_stiffness,
            _ => return Err(no_value(variable)),
        })
    }

    /// The seams of a crack.
    fn parts(&self, crack: usize) -> impl Iterator<Item = usize> {
        let seams = self.structure().mesh.seams.iter().enumerate();
        seams.filter(move |(_, seam)| seam.crack == crack).map(|(part, _)| part)
    }

    /// Mean of the values of a crack's parts, weighted by their lengths.
    fn mean_of_parts(&self, crack: usize, value: impl Fn(usize) -> f64) -> f64 {
        let mesh = &self.structure().mesh;
        let mut parts = self.parts(crack);
        let (Some(first), second) = (parts.next(), parts.next()) else { return 0.0 };
        let Some(second) = second else { return value(first) };
        let (mut sum, mut whole) = (0.0, 0.0);
        for part in [first, second].into_iter().chain(parts) {
            let length = mesh.length(&mesh.seams[part].upper);
            sum += length * value(part);
            whole += length;
        }
        sum / whole
    }

    /// Forces across a crack, sums over its parts of those normal and tangential to each; zero in an intact dam, which has no
    /// contacts.
    fn crack_forces(&self, crack: usize) -> CrackForces {
        let mut sum = CrackForces::default();
        for part in self.parts(crack) {
            let Some(joints) = self.state().motion.joints().get(part) else { continue };
            let CrackForces { normal, shear, strength } = self.structure().cracks[part].forces(joints);
            sum = CrackForces {
                normal: sum.normal + normal,
                shear: sum.shear + shear,
                strength: sum.strength + strength,
            };
        }
        sum
    }

    /// Moment of the normal forces in a crack about its middle; zero in an intact dam, which has no contacts.
    fn crack_moment(&self, crack: usize) -> f64 {
        let Some(path) = CrackPath::of(&self.structure().mesh, crack) else { return 0.0 };
        let of_part = |&(part, begin): &(usize, f64)| {
            let Some(joints) = self.state().motion.joints().get(part) else { return 0.0 };
            self.structure().cracks[part].moment(joints, begin - 0.5 * path.length)
        };
        path.parts.iter().map(of_part).sum()
    }

    /// A share of a crack's length, from the lengths of its parts; `None` in an intact dam, which has no contacts.
    fn share(
        &self,
        crack: usize,
        lengths: impl Fn(&Crack<MohrCoulomb>, &[JointState]) -> [f64; 2],
    ) -> Option<f64> {
        let parts =
            self.parts(crack).filter_map(|part| Some((part, self.state().motion.joints().get(part)?)));
        let lengths = parts.map(|(part, joints)| lengths(&self.structure().cracks[part], joints));
        let [some, whole] = lengths.fold([0.0; 2], |sum, part| [0, 1].map(|i| sum[i] + part[i]));
        (whole > 0.0).then_some(some / whole)
    }

    /// Stress (xx, yy, xy) in a triangle, Pa. Modes describe rotations to first order only, so that their stress is
    /// computed with small strains.
    fn stress(&self, triangle: usize, nodes: [usize; 3]) -> [f64; 3] {
        let kinematics =
            if self.modes().is_some() { Kinematics::Small } else { self.parameters().kinematics };
        let u = self.state().motion.displacement();
        self.structure().cells.stress(triangle, nodes.map(|node| self.at_node(node, u)), kinematics)
    }

    /// Principal stresses of the current state.
    fn principal_stresses(&self) -> &PrincipalStresses {
        let (coordinates, kinematics) = (self.state().motion.displacement(), self.parameters().kinematics);
        self.derived.stresses.get_or_init(|| {
            let stresses = self.nodal_stresses.stresses(&self.model, coordinates, kinematics);
            self.nodal_stresses.principal(&stresses, &self.stress_points)
        })
    }

    fn at_stress_points(&self, variable: &Variable, values: &mut [f64]) -> Result<(), DamError> {
        for (point, value) in values.iter_mut().enumerate() {
            let place = || self.structure().mesh.nodes[self.stress_points[point]];
            let principal = || self.principal_stresses().at_points[point];
            *value = match *variable {
                variable::STRESS_POINT_X => place()[0],
                variable::STRESS_POINT_Y => place()[1],
                variable::MAJOR_PRINCIPAL_STRESS => principal()[0],
                variable::MINOR_PRINCIPAL_STRESS => principal()[1],
                _ => return Err(no_value(variable)),
            };
        }
        Ok(())
    }

    /// Values of a field variable at all nodes, triangles or contacts.
    fn field(&self, variable: &Variable, values: &mut [f64]) -> Result<(), DamError> {
        let mesh = &self.structure().mesh;
        let fill = |values: &mut [f64], from: &mut dyn Iterator<Item = f64>| {
            values.fill(0.0);
            values.iter_mut().zip(from).for_each(|(value, from)| *value = from);
        };
        let cracks = || self.structure().cracks.iter();
        let joints = || cracks().zip(self.state().motion.joints());
        let corner = |i: usize| mesh.triangles().map(move |nodes| nodes[i] as f64);
        let stress = |i: usize| mesh.triangles().enumerate().map(move |(t, nodes)| self.stress(t, nodes)[i]);
        let all = || (0..mesh.nodes.len()).map(|node| self.displacement(node)).collect();
        let displacements = || self.derived.displacements.get_or_init(all).iter();
        let place = |d: usize| cracks().flat_map(move |crack| crack.places().map(move |place| place[d]));
        let contact = |i: usize| {
            joints().flat_map(move |(crack, joints)| crack.stresses(joints).map(move |stress| stress[i]))
        };
        match *variable {
            variable::NODE_X => fill(values, &mut mesh.nodes.iter().map(|node| node[0])),
            variable::NODE_Y => fill(values, &mut mesh.nodes.iter().map(|node| node[1])),
            variable::TRIANGLE_NODE_1 => fill(values, &mut corner(0)),
            variable::TRIANGLE_NODE_2 => fill(values, &mut corner(1)),
            variable::TRIANGLE_NODE_3 => fill(values, &mut corner(2)),
            variable::TRIANGLE_ZONE => {
                let zone = |cell: usize| mesh.zone_of(cell).map_or(0.0, |zone| (zone + 1) as f64);
                fill(values, &mut (0..4 * mesh.cells.len()).map(|triangle| zone(triangle / 4)));
            }
            variable::CONTACT_X => fill(values, &mut place(0)),
            variable::CONTACT_Y => fill(values, &mut place(1)),
            variable::NODE_DISPLACEMENT_X => fill(values, &mut displacements().map(|u| u[0])),
            variable::NODE_DISPLACEMENT_Y => fill(values, &mut displacements().map(|u| u[1])),
            variable::STRESS_XX => fill(values, &mut stress(0)),
            variable::STRESS_YY => fill(values, &mut stress(1)),
            variable::STRESS_XY => fill(values, &mut stress(2)),
            variable::CONTACT_OPENING => {
                fill(values, &mut joints().flat_map(|(_, joints)| joints.iter().map(|joint| joint.gap)));
            }
            variable::CONTACT_SLIP => {
                fill(values, &mut joints().flat_map(|(crack, joints)| crack.slips(joints)));
            }
            variable::CONTACT_NORMAL_STRESS => fill(values, &mut contact(0)),
            variable::CONTACT_SHEAR_STRESS => fill(values, &mut contact(1)),
            _ => return Err(no_value(variable)),
        }
        Ok(())
    }

    /// Value at a node of a field that is given in the coordinates of the model.
    fn at_node(&self, node: usize, field: &[f64]) -> [f64; 2] {
        self.model.at_node(node, field)
    }

    /// Displacement of a node since time 0, m.
    fn displacement(&self, node: usize) -> [f64; 2] {
        self.at_node(node, self.since_rest())
    }

    /// Displacement since time 0, in the coordinates of the model.
    fn since_rest(&self) -> &[f64] {
        let difference = || {
            let motion = self.state().motion.displacement().iter().zip(&self.state().rest);
            motion.map(|(u, rest)| u - rest).collect()
        };
        self.derived.since_rest.get_or_init(difference)
    }

    /// Total acceleration of a node, mean over the last communication step, m/s².
    fn acceleration(&self, node: usize) -> [f64; 2] {
        let [x, y] = self.at_node(node, &self.state().mean_acceleration);
        let ground = self.state().mean_ground_acceleration;
        [x + ground[0], y + ground[1]]
    }

    /// Position of a node in the state of rest, m.
    fn place_at_rest(&self, node: usize) -> [f64; 2] {
        let (x, u) = (self.structure().mesh.nodes[node], self.at_node(node, &self.state().rest));
        [x[0] + u[0], x[1] + u[1]]
    }

    /// Mean along one side of a part of a crack, weighted by tributary lengths.
    fn side_mean(&self, part: usize, side: usize, value: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
        let crack = &self.structure().cracks[part];
        let (nodes, lengths) = (crack.sides()[side], crack.weights()[side]);
        let mut sum = [0.0; 2];
        for (&node, length) in nodes.iter().zip(lengths) {
            let value = value(node);
            (0..2).for_each(|d| sum[d] += length * value[d]);
        }
        sum.map(|sum| sum / lengths.iter().sum::<f64>())
    }

    /// Mean displacement of the upper side minus that of the lower side since time 0, along the current
    /// direction of the lower side, m.
    fn sliding(&self, part: usize) -> f64 {
        let [below, above] = [0, 1].map(|side| self.side_mean(part, side, |node| self.displacement(node)));
        let [x, y] = [above[0] - below[0], above[1] - below[1]];
        let (sin, cos) = self.lower_side_rotation(part).sin_cos();
        let [p, q] = self.structure().mesh.direction(&self.structure().mesh.seams[part].upper);
        x * (p * cos - q * sin) + y * (p * sin + q * cos)
    }

    /// Mass-weighted best-fit rotation of the block above, minus the best-fit rotation of the nodes on the lower side
    /// (weighted by tributary lengths), both since time 0, rad.
    fn rotation(&self, part: usize) -> f64 {
        let above = self.structure().mesh.seams[part].above;
        if above == self.structure().mesh.blocks.len() {
            // the ground, where a crack folds back along the base
            return -self.lower_side_rotation(part);
        }
        if let Some(modes) = self.modes() {
            return modes.rotation(above, self.since_rest()) - self.lower_side_rotation(part);
        }
        let structure = self.structure();
        let block = structure.mesh.blocks[above].nodes.clone();
        let above = block.map(|n| (structure.mass[n], self.place_at_rest(n), self.displacement(n)));
        best_fit_rotation(above) - self.lower_side_rotation(part)
    }

    fn lower_side_rotation(&self, part: usize) -> f64 {
        let crack = &self.structure().cracks[part];
        let points = crack.sides()[0].iter().zip(crack.weights()[0]);
        let points = points.map(|(&n, &length)| (length, self.place_at_rest(n), self.displacement(n)));
        best_fit_rotation(points.collect::<Vec<_>>().into_iter())
    }

    fn side_acceleration(&self, part: usize, side: usize) -> f64 {
        self.side_mean(part, side, |node| self.acceleration(node))[0]
    }

    /// Total acceleration of the wet face along its normals, mean over the last communication step, m/s².
    pub(super) fn mean_interface_acceleration(&self) -> Vec<f64> {
        self.along_normals(|node| self.acceleration(node))
    }

    fn along_normals(&self, motion: impl Fn(usize) -> [f64; 2]) -> Vec<f64> {
        let points = self.wet().into_iter().flat_map(|wet| wet.nodes.iter().zip(&wet.normals));
        let along = |(&node, n): (&usize, &[f64; 2])| {
            let [x, y] = motion(node);
            x * n[0] + y * n[1]
        };
        points.map(along).collect()
    }

    /// Values of `variable` of either wet face at the points of both.
    fn at_points(&self, variable: &Variable) -> Result<Vec<f64>, DamError> {
        use cofferdam_unit::variables::dam as v;
        let state = self.state();
        let faces = || self.wet().into_iter().flat_map(|wet| wet.faces.iter().flatten());
        let coordinate = |d: usize| faces().flat_map(|face| face.points()).map(|point| point[d]).collect();
        let normal = |d: usize| self.wet().into_iter().flat_map(|wet| &wet.normals).map(|n| n[d]).collect();
        Ok(match *variable {
            v::INTERFACE_PRESSURE | v::TAILWATER_INTERFACE_PRESSURE => state.next.pressure.clone(),
            v::HYDROSTATIC_PRESSURE | v::TAILWATER_HYDROSTATIC_PRESSURE => state.hydrostatic_pressure.clone(),
            v::INTERFACE_DISPLACEMENT | v::TAILWATER_INTERFACE_DISPLACEMENT => {
                self.along_normals(|node| self.displacement(node))
            }
            v::INTERFACE_VELOCITY | v::TAILWATER_INTERFACE_VELOCITY => {
                self.along_normals(|node| self.at_node(node, state.motion.velocity()))
            }
            v::INTERFACE_ACCELERATION | v::TAILWATER_INTERFACE_ACCELERATION => {
                self.mean_interface_acceleration()
            }
            v::INTERFACE_ACCELERATION_END | v::TAILWATER_INTERFACE_ACCELERATION_END => {
                state.interface_acceleration.at_end.clone()
            }
            v::INTERFACE_X | v::TAILWATER_INTERFACE_X => coordinate(0),
            v::INTERFACE_Y | v::TAILWATER_INTERFACE_Y => coordinate(1),
            v::INTERFACE_NORMAL_X | v::TAILWATER_INTERFACE_NORMAL_X => normal(0),
            v::INTERFACE_NORMAL_Y | v::TAILWATER_INTERFACE_NORMAL_Y => normal(1),
            v::INTERFACE_LENGTH | v::TAILWATER_INTERFACE_LENGTH => {
                faces().flat_map(cofferdam_unit::WetFace::tributary_lengths).collect()
            }
            _ => return Err(no_value(variable)),
        })
    }
}

/// The error for a variable that has no arm here.
fn no_value(variable: &Variable) -> DamError {
    CallError::NoValue { unit: Dam::NAME, variable: variable.name }.into()
}

fn copy(from: &[f64], to: &mut [f64]) -> Result<(), DamError> {
    to.copy_from_slice(from);
    Ok(())
}

#[cfg(test)]
mod tests {
    use cofferdam_unit::CoSimulation;

    use super::*;
    use crate::{CrackParameters, DamMotion, DamParameters, Damping, Material, Section};

    /// A rectangle of 6 m × 10 m without weight and water.
    fn rectangle(cracks: Vec<CrackParameters>) -> DamParameters {
        DamParameters {
            section: Section::rectangle(6.0, 10.0),
            water_depth: 0.0,
            cracks,
            material: Material { young_modulus: 1e9, density: 2400.0, ..Default::default() },
            damping: Damping::None,
            element_size: 1.0,
            gravity: 0.0,
            ..Default::default()
        }
    }

    /// The upper block is turned about the middle of the crack and shifted along the crack; then both blocks are
    /// turned together. Sliding and rotation must be those of the upper block relative to the lower one.
    #[test]
    fn sliding_and_rotation_are_relative_to_the_lower_side() -> Result<(), DamError> {
        let crack = CrackParameters::sliding(4.0, 1.0, 1e9, 1e9);
        let mut dam = Dam::new(rectangle(vec![crack]))?;
        dam.initialise(0.0)?;
        let mut state = dam.save_state();
        let (together, apart, slip) = (0.02f64, 0.1f64, 0.3);
        let turn = |[x, y]: [f64; 2], angle: f64, about: [f64; 2]| {
            let (s, c) = angle.sin_cos();
            let [x, y] = [x - about[0], y - about[1]];
            [about[0] + c * x - s * y, about[1] + s * x + c * y]
        };
        for (node, &rest) in dam.structure().mesh.nodes.iter().enumerate() {
            let mut place = rest;
            if dam.structure().mesh.block_of(node) == 1 {
                place = turn(place, apart, [3.0, 4.0]);
                place[0] += slip;
            }
            place = turn(place, together, [0.0, 0.0]);
            if let DamMotion::Nodes(motion) = &mut state.motion {
                motion.displacement[node] = [place[0] - rest[0], place[1] - rest[1]];
            }
        }
        dam.restore_state(&state)?;
        let mut value = [0.0];
        dam.get(variable::CRACK_SLIDING.value_reference, &mut value)?;
        assert!((value[0] - slip).abs() < 1e-13, "sliding {}", value[0]);
        dam.get(variable::CRACK_ROTATION.value_reference, &mut value)?;
        assert!((value[0] - apart).abs() < 1e-13, "rotation {}", value[0]);
        Ok(())
    }

    /// ε_xx = −ε_yy = −1e-7 (x + y), γ = 1e-7 (y − x): the principal stresses ±2G 1e-7 √((x + y)² + (y − x)²/4) are largest in
    /// the corner (6, 10). A step and a restored state are not answered with the stresses of the state before.
    #[test]
    fn the_largest_stresses_are_found_where_they_are() -> Result<(), DamError> {
        let mut dam = Dam::new(rectangle(Vec::new()))?;
        dam.initialise(0.0)?;
        let rest = dam.save_state();
        let mut state = dam.save_state();
        for (node, &[x, y]) in dam.structure().mesh.nodes.iter().enumerate() {
            if let DamMotion::Nodes(motion) = &mut state.motion {
                motion.displacement[node] = [-1e-7 * (x * x / 2.0 + x * y), 1e-7 * (y * y / 2.0 + x * y)];
            }
        }
        dam.restore_state(&state)?;
        let exact = 1e9 / 1.2 * 1e-7 * 16f64.hypot(2.0);
        let found = |dam: &Dam, variable: Variable| -> Result<[f64; 2], DamError> {
            let mut values = [0.0; 2];
            dam.get(variable.value_reference, &mut values[..dam.size(&variable)])?;
            Ok(values)
        };
        for (stress, place, sign) in [
            (variable::LARGEST_PRINCIPAL_STRESS, variable::LARGEST_PRINCIPAL_STRESS_PLACE, 1.0),
            (variable::SMALLEST_PRINCIPAL_STRESS, variable::SMALLEST_PRINCIPAL_STRESS_PLACE, -1.0),
        ] {
            let [stress, _] = found(&dam, stress)?;
            assert!((stress / (sign * exact) - 1.0).abs() < 1e-5, "{stress} Pa, {exact} Pa");
            assert_eq!(found(&dam, place)?, [6.0, 10.0]);
        }
        dam.step(0.0, 1e-3)?;
        let [moved, _] = found(&dam, variable::LARGEST_PRINCIPAL_STRESS)?;
        assert!((moved / exact - 1.0).abs() > 1e-3, "{moved} Pa is that of the new state");
        dam.restore_state(&rest)?;
        assert!(found(&dam, variable::LARGEST_PRINCIPAL_STRESS)?[0] < 1e-6 * exact);
        Ok(())
    }
}
