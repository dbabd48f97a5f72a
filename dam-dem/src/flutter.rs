//! Whether a block that slides vibrates by itself.

use crate::model::Model;
use crate::reduction::{HIGHEST_REPRESENTED, Sliding};
use crate::{CrackParameters, DamError, DamParameters, Damping, Fidelity};

/// The fastest growing vibration of a dam whose blocks above a crack slide steadily.
///
/// Shear that follows the normal stress feeds a vibration in which a block is pressed less while it moves forwards. Two
/// modes of the elastic blocks whose frequencies this brings together become one that grows (mode coupling). Then the
/// block hops while it slides, and a thrust below its frictional strength may keep it moving. A vibration that decays
/// slowest has a negative growth.
///
/// The dam is that of the parameters as reduced blocks, up to 80 Hz, with its added mass; water with a memory is not part of it, and
/// local damping, which does not act against vibration about a steady motion, counts as none.
///
/// **Source**: N. Hoffmann, M. Fischer, R. Allgaier, L. Gaul, *A minimal model for studying properties of the mode-coupling
/// type instability in friction induced oscillations*, Mechanics Research Communications 29 (2002); tested in
/// `tests/flutter.rs`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flutter {
    /// Index of the crack, from the base up.
    pub crack: usize,
    /// Mean elevation of the crack, m.
    pub elevation: f64,
    /// Whether the blocks slide downstream; otherwise upstream.
    pub downstream: bool,
    /// Circular frequency, rad/s.
    pub frequency: f64,
    /// Rate of growth, 1/s.
    pub growth: f64,
}

/// Frequency below which a motion is steady sliding and no vibration, as a share of the largest eigenvalue: zero eigenvalues
/// are found to the square root of the rounding error.
const STEADY: f64 = 1e-6;

impl DamParameters {
    /// For each crack, from the base up, sliding downstream and then upstream, under weight and hydrostatic pressure with
    /// this `specific_weight` of the water (N/m³); none where the blocks tip over instead, none of a crack that other cracks divide
    /// or whose sides are both held, and none of an intact dam.
    ///
    /// **Errors**: as [`check`](Self::check) and [`Dam::new`](crate::Dam::new), and [`DamError::Singular`] if eigenvalues
    /// are not found.
    pub fn flutter(&self, specific_weights: [f64; 2]) -> Result<Vec<Flutter>, DamError> {
        self.check()?;
        let mut modal = self.clone();
        if let Damping::Local { .. } = modal.damping {
            modal.damping = Damping::None;
        }
        if modal.fidelity.level().has_elements() {
            modal.fidelity = Fidelity::Reduced { modes: None };
        }
        let mut cracks = self.cracks.clone();
        cracks.sort_by(CrackParameters::from_the_base_up);
        let (model, _) = Model::new(&modal, &cracks)?;
        let Some(modes) = model.superposition().filter(|_| self.fidelity.is_cracked()) else {
            return Ok(Vec::new());
        };
        let pressure =
            model.body().wet.as_ref().map_or_else(Vec::new, |wet| wet.hydrostatic(specific_weights));
        let loads = modes.forces(&model.body().loads, &model.body().at_rest(0.0, pressure));
        let mut found = Vec::new();
        let structure = &model.body().structure;
        let mesh = &structure.mesh;
        for (index, crack) in cracks.iter().enumerate() {
            let mut parts = (0..mesh.seams.len()).filter(|&seam| mesh.seams[seam].crack == index);
            let (Some(seam), None) = (parts.next(), parts.next()) else { continue };
            let is_held = |body: usize| mesh.blocks.get(body).is_none_or(|block| structure.is_held(block));
            if is_held(mesh.seams[seam].below) && is_held(mesh.seams[seam].above) {
                continue;
            }
            for (downstream, direction) in [(true, 1.0), (false, -1.0)] {
                let Some(sliding) = Sliding::steady(modes, seam, direction, &loads) else { continue };
                let eigenvalues = sliding.eigenvalues()?;
                let largest = eigenvalues.iter().map(|value| value.norm()).fold(0.0, f64::max);
                let vibrations =
                    eigenvalues.iter().filter(|z| z.im > STEADY * largest && z.im < HIGHEST_REPRESENTED);
                if let Some(fastest) = vibrations.max_by(|a, b| a.re.total_cmp(&b.re)) {
                    let (frequency, growth) = (fastest.im, fastest.re);
                    let elevation = crack.line.elevation();
                    found.push(Flutter { crack: index, elevation, downstream, frequency, growth });
                }
            }
        }
        Ok(found)
    }
}
