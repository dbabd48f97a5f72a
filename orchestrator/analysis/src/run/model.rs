//! Messages on the model of a run before the first step.

use crate::variables::known;
use cofferdam_assembly::Assembly;
use cofferdam_assembly::observer::WaterField;
use cofferdam_assembly::units::DAM;
use cofferdam_coupling::participant::ParticipantError;
use cofferdam_coupling::scheme::Graph;
use cofferdam_motion::{GroundMotion, STANDARD_GRAVITY};
use cofferdam_scene::{DampingModel, LoadedScene, Scene, Side};

/// The waters whose pressure the pictures show, and why others are not shown.
pub fn waters(scene: &Scene) -> (Vec<Box<dyn WaterField>>, Vec<String>) {
    let (mut fields, mut notes) = (Vec::new(), Vec::new());
    for side in Side::BOTH.into_iter().filter(|_| scene.snapshots.is_some_and(|plan| plan.water)) {
        match Assembly::of(scene).water_field(side) {
            Ok(field) => fields.extend(field),
            Err(why) => notes.push(format!("no pressure inside the {} in pictures: {why}", side.table())),
        }
    }
    (fields, notes)
}

/// Points where the dam outputs stress, m; none if it does not.
pub fn stress_points(graph: &mut Graph) -> Result<Vec<[f64; 2]>, ParticipantError> {
    let (x, y) = (known(graph[DAM].read("stress_point_x"))?, known(graph[DAM].read("stress_point_y"))?);
    Ok(x.into_iter().zip(y).map(|(x, y)| [x, y]).collect())
}

/// Error and loss of the recursion of each water that has one and tells them.
pub fn recursion(scene: &Scene, graph: &mut Graph) -> Result<Vec<(Side, [f64; 2])>, ParticipantError> {
    let mut found = Vec::new();
    for (id, (side, water)) in graph.ids().skip(1).zip(scene.waters()) {
        if !water.may_be_recursive() {
            continue;
        }
        let [error, loss] = ["recursion_error", "recursion_loss"].map(|name| known(graph[id].read(name)));
        // An automatic method that came to a convolution has neither.
        if let ([error], [loss]) = (&error?[..], &loss?[..])
            && *error > 0.0
        {
            found.push((side, [*error, *loss]));
        }
    }
    Ok(found)
}

/// Source and peak of the ground motion.
pub fn ground_line(motion: &GroundMotion) -> String {
    let (source, (peak, time)) = (motion.source(), motion.peak());
    let vertical = motion.vertical().map_or_else(String::new, |vertical| {
        let (source, (peak, time)) = (vertical.source(), vertical.peak());
        format!("; vertical {source}: peak {:.3} g at {time:.2} s, positive upwards", peak / STANDARD_GRAVITY)
    });
    format!("{:<10} {source}: peak {:.3} g at {time:.2} s{vertical}", "ground", peak / STANDARD_GRAVITY)
}

/// The damping model, which belongs to every value of sliding, and the fidelity if it is not the full one.
pub fn dam_model(
    loaded: &LoadedScene,
    graph: &mut Graph,
) -> Result<Vec<(&'static str, String)>, ParticipantError> {
    let Some(dam) = loaded.scene.dam.as_ref().filter(|dam| !dam.fidelity.is_foreign()) else {
        return Ok(Vec::new());
    };
    let percent = 100.0 * dam.damping.ratio;
    let mut frequencies = graph[DAM].read("damping_frequency_low")?;
    frequencies.extend(graph[DAM].read("damping_frequency_high")?);
    let frequencies: Vec<String> = frequencies.iter().map(|f| format!("{f:.2}")).collect();
    let frequency = frequencies.first().map_or("", String::as_str);
    let damping = match dam.damping.model {
        _ if dam.damping.ratio == 0.0 => "none".to_owned(),
        DampingModel::Rayleigh => {
            format!("Rayleigh, {percent} % at {} rad/s", frequencies.join(" and "))
        }
        DampingModel::Mass => format!("mass-proportional, {percent} % at {frequency} rad/s"),
        DampingModel::Stiffness => format!("stiffness-proportional, {percent} % at {frequency} rad/s"),
        DampingModel::Local => format!("local, {percent} %"),
    };
    let mut model = vec![("damping model of the dam", damping)];
    if dam.fidelity.is_rigid() {
        model.push(("fidelity of the dam", "rigid blocks: unsafe".to_owned()));
    } else if !dam.fidelity.has_elements() {
        model.push(("fidelity of the dam", dam.fidelity.word()));
    }
    Ok(model)
}
