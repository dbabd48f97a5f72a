//! Saved states in the middle of the main scene: restored and repeated, every output is equal
//! bit for bit; serialised, they continue in another unit.

use cofferdam_assembly::{Assembly, WaterMass};
use cofferdam_dam::Dam;
use cofferdam_reservoir::Reservoir;
use cofferdam_unit::{Causality, CoSimulation, Variable, WetFace, variables};
use std::num::NonZeroUsize;
use whole_chain::koyna;
use whole_chain::scenario::root;

const H: f64 = 0.0025;

/// The two units of the main scene and a plain staggered iteration.
struct Pair {
    dam: Dam,
    reservoir: Reservoir,
    time: f64,
    pressure: Vec<f64>,
    hydrostatic: Vec<f64>,
}

impl Pair {
    fn new() -> Result<Self, Box<dyn std::error::Error>> {
        let mut dam = Dam::new(koyna::dam(5.0, true))?;
        let wet_face = dam.wet_face().expect("there is water").clone();
        let points = wet_face.len();
        let parameters = koyna::reservoir(wet_face, H, 4.0);
        let mut reservoir = Reservoir::new(parameters, NonZeroUsize::MIN.saturating_add(1))?;
        reservoir.initialise(0.0)?;
        let mut hydrostatic = vec![0.0; points];
        reservoir.get(variables::reservoir::HYDROSTATIC_PRESSURE.value_reference, &mut hydrostatic)?;
        dam.set(variables::dam::HYDROSTATIC_PRESSURE.value_reference, &hydrostatic)?;
        dam.initialise(0.0)?;
        Ok(Self { dam, reservoir, time: 0.0, pressure: vec![0.0; points], hydrostatic })
    }

    /// One step of each unit from the current time with the current guess of pressure.
    fn step(&mut self, ground: [f64; 2]) -> Result<(), Box<dyn std::error::Error>> {
        use variables::{dam, reservoir};
        self.dam.set(dam::INTERFACE_PRESSURE.value_reference, &self.pressure)?;
        self.dam.set(dam::HYDROSTATIC_PRESSURE.value_reference, &self.hydrostatic)?;
        self.dam.set(dam::GROUND_ACCELERATION.value_reference, &ground)?;
        self.dam.step(self.time, H)?;
        let mut acceleration = vec![0.0; self.pressure.len()];
        self.dam.get(dam::INTERFACE_ACCELERATION.value_reference, &mut acceleration)?;
        self.reservoir.set(reservoir::INTERFACE_ACCELERATION.value_reference, &acceleration)?;
        self.reservoir.set(reservoir::GROUND_ACCELERATION.value_reference, &ground)?;
        self.reservoir.step(self.time, H)?;
        Ok(())
    }

    /// Three iterations of a communication step.
    fn advance(&mut self, ground: [f64; 2]) -> Result<(), Box<dyn std::error::Error>> {
        let (dam, water) = (self.dam.save_state(), self.reservoir.save_state());
        for iteration in 0..3 {
            if iteration > 0 {
                self.dam.restore_state(&dam)?;
                self.reservoir.restore_state(&water)?;
            }
            self.step(ground)?;
            let reference = variables::reservoir::INTERFACE_PRESSURE.value_reference;
            self.reservoir.get(reference, &mut self.pressure)?;
        }
        self.time += H;
        Ok(())
    }
}

/// The bits of every output of a unit.
fn outputs<U: CoSimulation>(unit: &U) -> Result<Vec<(&'static str, Vec<u64>)>, U::Error> {
    let outputs = unit.variables().iter().filter(|v| v.causality == Causality::Output);
    let bits = |variable: &'static Variable| {
        let mut values = vec![0.0; unit.size(variable)];
        unit.get(variable.value_reference, &mut values)?;
        Ok((variable.name, values.iter().map(|v| v.to_bits()).collect()))
    };
    outputs.map(bits).collect()
}

/// The units that the tests build without a scene equal those of the scene.
#[test]
fn the_tests_dam_is_that_of_the_scene() -> Result<(), Box<dyn std::error::Error>> {
    let scene = cofferdam_assembly::read_scene(&root().join("scenes/koyna-coarse"), &[])?.scene;
    assert_eq!(koyna::dam(5.0, true), Assembly::of(&scene).dam_parameters(WaterMass::None)?);
    let water = &scene.reservoir;
    let built = koyna::reservoir(WetFace::straight([0.0, scene.depth()], 1)?, H, 1.0);
    assert_eq!(
        (built.density, built.sound_speed, built.gravity),
        (water.density, water.sound_speed, scene.gravity)
    );
    assert_eq!(built.wave_reflection_coefficient, water.wave_reflection_coefficient);
    assert_eq!((koyna::DEPTH, koyna::dam(5.0, true).water_depth), (scene.depth(), scene.depth()));
    Ok(())
}

#[test]
fn states_in_the_middle_of_the_main_scene() -> Result<(), Box<dyn std::error::Error>> {
    let loaded = cofferdam_assembly::read_scene(&root().join("scenes/koyna-coarse"), &[])?;
    // The strong motion begins at 4 s.
    let ground = |time: f64| loaded.ground_motion.at(4.0 + time);
    let mut pair = Pair::new()?;
    let mut lengths = Vec::new();
    for _ in 0..800 {
        pair.advance(ground(pair.time + H))?;
        lengths.push(pair.dam.serialise_state(&pair.dam.save_state())?.len());
    }
    let mut sliding = [0.0];
    pair.dam.get(variables::dam::CRACK_SLIDING.value_reference, &mut sliding)?;
    println!("t = {:.2} s, sliding {:.1} mm", pair.time, 1e3 * sliding[0]);
    assert!(sliding[0].abs() > 1e-3, "the crack slides");
    let (least, most) = (lengths.iter().min(), lengths.iter().max());
    assert_eq!(least, most, "the dam's state does not grow");

    let (dam, water) = (pair.dam.save_state(), pair.reservoir.save_state());
    let end = ground(pair.time + H);
    pair.step(end)?;
    let first = (outputs(&pair.dam)?, outputs(&pair.reservoir)?);
    for repetition in 0..2 {
        pair.dam.restore_state(&dam)?;
        pair.reservoir.restore_state(&water)?;
        pair.step([-2.0 * end[0], 0.0])?;
        pair.dam.restore_state(&dam)?;
        pair.reservoir.restore_state(&water)?;
        pair.step(end)?;
        assert!(first == (outputs(&pair.dam)?, outputs(&pair.reservoir)?), "repetition {repetition} differs");
    }

    // In new units, from bytes.
    let dam_bytes = pair.dam.serialise_state(&dam)?;
    let water_bytes = pair.reservoir.serialise_state(&water)?;
    println!("serialised states: dam {} bytes, reservoir {} bytes", dam_bytes.len(), water_bytes.len());
    let mut other = Pair::new()?;
    other.dam.restore_state(&other.dam.deserialise_state(&dam_bytes)?)?;
    other.reservoir.restore_state(&other.reservoir.deserialise_state(&water_bytes)?)?;
    (other.time, other.pressure) = (pair.time, pair.pressure.clone());
    other.step(end)?;
    assert!(first == (outputs(&other.dam)?, outputs(&other.reservoir)?), "the continued run differs");
    assert!(other.dam.deserialise_state(&water_bytes).is_err(), "a state of another unit is refused");
    Ok(())
}
