//! A user-defined contact law: a joint filled with oil, whose shear stress is η times the slip rate.
//!
//! A rigid block on such a joint on a slope has the velocity `v = ρ h g sin θ / η (1 − exp(−η t / ρ h))`.
//! Run it with `cargo run --release -p cofferdam_dam --example lubricated_joint`.

use cofferdam_dam::contact::{ContactLaw, Integration, Mask, Real, Response, Touch};
use cofferdam_dam::energy::Work;
use cofferdam_dam::integrator::{CentralDifference, DynamicRelaxation};
use cofferdam_dam::loads::LoadPath;
use cofferdam_dam::{
    CriticalTimeStep, DamError, DampingCoefficients, Kinematics, Material, Mesh, Section, Structure,
};

#[derive(Clone)]
struct Oil {
    normal_stiffness: f64,
    viscosity: f64,
}

impl ContactLaw for Oil {
    #[inline(always)]
    fn respond<N: Real>(&self, touch: &Touch<N>) -> Response<N> {
        let normal = touch.penetration.positive_part() * self.normal_stiffness;
        let closed = normal.constant(0.0).less_than(normal);
        let shear = closed.select(touch.slip_rate * self.viscosity, normal.constant(0.0));
        // the dashpot carries the whole shear stress; the spring slips freely and never stretches
        let none = Response::none(normal);
        Response { normal, shear, slipping: normal.mask(true), dashpots: [none.normal, shear], ..none }
    }

    fn stiffness(&self) -> [f64; 2] {
        [self.normal_stiffness, 1e-3 * self.normal_stiffness]
    }
}

fn main() -> Result<(), DamError> {
    let concrete = Material { young_modulus: 1e8, density: 2400.0, ..Default::default() };
    let mesh = Mesh::mapped(&Section::rectangle(3.0, 2.0), &[vec![0.0, 1.0], vec![1.0, 2.0]], 3);
    let ground: Vec<usize> = mesh.blocks[0].nodes.clone().collect();
    let block = mesh.blocks[1].nodes.clone();
    let oil = Oil { normal_stiffness: 1e8, viscosity: 2e5 };
    let structure =
        Structure::new(mesh, &concrete, Kinematics::Corotational, [(oil, Integration::Nodal)], &ground);

    let (g, angle) = (9.81, 0.1f64);
    let mut motion = structure.at_rest();
    let level = structure.weight([0.0, -g * angle.cos()]);
    DynamicRelaxation::default().relax(&structure, &mut motion, &level)?;

    let sloping = structure.weight([g * angle.sin(), -g * angle.cos()]);
    let damping = DampingCoefficients::NONE;
    structure.accelerate(damping, &mut motion, &sloping);
    let steps = CentralDifference::covering(0.06, 0.9 * CriticalTimeStep::of(&structure, damping)?.limit);
    steps.advance(&structure, damping, &mut motion, &LoadPath::constant(sloping), &mut Work::default());

    let mass: f64 = block.clone().map(|n| structure.mass[n]).sum();
    let velocity = block.map(|n| structure.mass[n] * motion.velocity[n][0]).sum::<f64>() / mass;
    let exact = 2400.0 * g * angle.sin() / 2e5 * (1.0 - (-2e5 * 0.06 / 2400.0f64).exp());
    println!("velocity {velocity:.5} m/s, exact for a rigid block {exact:.5} m/s");
    Ok(())
}
