use super::quantity::{Quantity, Subject};
use cofferdam_assembly::observer::{AVERAGED, Histories, LastSecond, STILL_MOVES, STILL_SLIDES};
use cofferdam_assembly::{Equilibrium, UpliftEffect};
use cofferdam_coupling::observer::{Ending, Status};
use cofferdam_motion::STANDARD_GRAVITY;
use cofferdam_scene::{CrackScene, DamFidelityScene, LoadedScene, REST, Scene, Side, Warning, takes_water};
use serde::{Deserialize, Serialize};

mod after;

pub(super) const ENERGY_BALANCE: &str = "energy balance error over peak kinetic energy";
/// Energy balance error, %, above which a summary warns.
pub(super) const ENERGY_ALARM: f64 = 1.0;

/// Text of the warning of a block that still moves.
pub(super) const NOT_AT_REST: &str = "the dam is not at rest at the end";

pub(super) const LOWEST_PRESSURE: &str = "lowest pressure on a wet face, hydrostatic included";
/// Pressure relative to the atmosphere at which water boils, kPa.
pub(super) const CAVITATION: f64 = -99.0;

/// The results of a run in a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// How the run ended.
    pub status: String,
    /// Simulated time reached, s.
    pub simulated_time: f64,
    /// Warnings and notes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// The numbers.
    pub quantities: Vec<Quantity>,
}

impl Summary {
    /// Summarises the histories of a run; quantities that were not recorded or not reached are omitted.
    ///
    /// `static_crest` is the displacement (x, y) of the crest at rest, m, and `stress_points` (x, y), m, are where stress is
    /// watched, of a dam that is computed; its `natural_frequencies` are those without and with the mass of the water; `recursion` are error and loss of the recursion of each water that has one.
    pub fn of(
        loaded: &LoadedScene,
        histories: &Histories,
        ending: &Ending,
        static_crest: Option<[f64; 2]>,
        stress_points: &[[f64; 2]],
        natural_frequencies: [&[f64]; 2],
        recursion: &[(Side, [f64; 2])],
    ) -> Self {
        let time = histories.column("time").unwrap_or(&[]);
        let subject = Subject::AtRest;
        let mut table = Table {
            histories,
            time,
            subject,
            quantities: Vec::new(),
            moving: Vec::new(),
            moving_between: Vec::new(),
        };
        let empty = !loaded.scene.has_water();
        if let Some([x, _]) = static_crest {
            let loads = if empty { "weight" } else { "weight, water" };
            table.add(&format!("static crest displacement ({loads})"), 1e3 * x, "mm", None);
        }
        for (water, frequencies) in ["empty", "full"].into_iter().zip(natural_frequencies) {
            for (mode, frequency) in frequencies.iter().enumerate() {
                let name = format!("natural frequency {} (intact, {water})", mode + 1);
                table.add(&name, *frequency, "rad/s", None);
            }
        }
        table.subject = Subject::Crest;
        table.extremes("dam.crest_displacement.x");
        table.peak("peak crest acceleration", "dam.crest_acceleration.x", 1.0 / STANDARD_GRAVITY, "g");
        let cracks = loaded.scene.dam.as_ref().map_or(&[][..], |d| &d.cracks);
        if !cracks.is_empty() {
            table.crest_after(loaded);
        }
        table.subject = Subject::Cracks;
        let between = between(loaded);
        for (crack, parameters) in cracks.iter().enumerate() {
            let of = |what: &str| of_crack(what, parameters, cracks);
            let column = |name: &str| format!("dam.crack_{name}.{crack}");
            table.peak(&of("peak sliding"), &column("sliding"), 1e3, "mm");
            for Between { shock, rest, next } in &between {
                let name = of(&format!("residual sliding after {shock}"));
                table.residual_between(&name, &column("sliding"), [*rest, *next]);
            }
            table.residual(&of("residual sliding"), &column("sliding"), loaded);
            table.peak(&of("peak opening"), &column("opening"), 1e3, "mm");
            table.peak(&of("peak rotation of the block above"), &column("rotation"), 1e3, "mrad");
            for side in ["below", "above"] {
                let name = of(&format!("peak acceleration {side} the crack"));
                table.peak(&name, &column(&format!("acceleration_{side}")), 1.0 / STANDARD_GRAVITY, "g");
            }
        }
        let fidelity = loaded.scene.dam.as_ref().map(|dam| dam.fidelity);
        if !fidelity.is_some_and(DamFidelityScene::is_intact) {
            for (crack, parameters) in cracks.iter().enumerate() {
                let of = |what: &str| of_crack(what, parameters, cracks);
                let name = of("largest share of the shear strength in use");
                table.peak(&name, &format!("dam.crack_shear_utilisation.{crack}"), 1.0, "1");
                let name = of("largest open share of the length");
                table.peak(&name, &format!("dam.crack_open_share.{crack}"), 1e2, "%");
                table.crack_after(crack, parameters, cracks, loaded);
            }
        }
        table.subject = Subject::Base;
        table.base();
        table.subject = Subject::Stresses;
        // rigid blocks have none
        let stressed = !fidelity.is_some_and(DamFidelityScene::is_rigid);
        for (point, [_, y]) in stress_points.iter().enumerate().filter(|_| stressed) {
            let place = match point {
                0 => "heel".to_owned(),
                1 => "toe".to_owned(),
                _ => {
                    format!(
                        "{}, {} m",
                        if point % 2 == 0 { "upstream face" } else { "downstream face" },
                        (y * 1e3).round() / 1e3
                    )
                }
            };
            let (tension, compression) = (
                format!("dam.major_principal_stress.{point}"),
                format!("dam.minor_principal_stress.{point}"),
            );
            table.largest(&format!("largest tension, {place}"), &tension, 1e-6, "MPa", |stress| stress);
            table.largest(&format!("largest compression, {place}"), &compression, -1e-6, "MPa", |stress| {
                -stress
            });
        }
        if stressed && !stress_points.is_empty() {
            table.heel_in_tension();
        }
        if stressed {
            table.largest_stresses();
        }
        table.subject = Subject::Water;
        let upstream = loaded.scene.hydrostatic_base_pressure(Side::Upstream);
        if upstream > 0.0 {
            let name = "peak hydrodynamic base pressure over hydrostatic";
            table.peak(name, "reservoir.base_pressure", 1.0 / upstream, "1");
        }
        let downstream = loaded.scene.hydrostatic_base_pressure(Side::Downstream);
        if downstream > 0.0 {
            let name = "peak hydrodynamic base pressure of the tailwater over hydrostatic";
            table.peak(name, "tailwater.base_pressure", 1.0 / downstream, "1");
            table.peak("peak hydrodynamic force of the tailwater", "tailwater.total_force", 1e-6, "MN/m");
        }
        if !empty {
            table.largest(LOWEST_PRESSURE, "lowest_pressure", 1e-3, "kPa", |p| -p);
        }
        table.pressure_coefficient(loaded);
        table.subject = Subject::Numerics;
        table.energy_balance();
        table.coupling(ending);
        for (side, [error, loss]) in recursion {
            let water = if *side == Side::Upstream { "water" } else { "tailwater" };
            table.add(&format!("error of the {water}'s recursion"), *error, "1", None);
            table.add(&format!("loss of the {water}'s recursion over rho c"), *loss, "1", None);
        }
        let mut summary = Self {
            status: ending.status.to_string(),
            simulated_time: ending.time,
            notes: Vec::new(),
            quantities: table.quantities,
        };
        summary.notes = summary.remarks(!cracks.is_empty() && table.moving.is_empty());
        summary.notes.extend(table.moving_between);
        summary.notes.extend(table.moving);
        let uplift = loaded.warnings.iter().filter(|w| matches!(w.warning, Warning::NoUplift { .. }));
        summary.notes.extend(uplift.map(|warning| format!("WARNING: {warning}")));
        let planned = loaded.scene.time.duration.unwrap_or(0.0);
        if ending.status == Status::Completed && ending.time < planned - 1e-6 {
            summary
                .notes
                .push(format!("the run ends at t = {:.4} s because the dam is at rest", ending.time));
        }
        summary.notes.extend(loaded.moved_defaults.iter().cloned());
        if let count @ 1.. = ending.statistics.unconverged {
            summary.notes.insert(
                0,
                format!(
                    "WARNING: {count} communication steps did not converge, and the run continued: do not use the results \
                     after the first of these steps; histories.csv and the log list them"
                ),
            );
        }
        summary
    }

    /// Puts the factors of safety of cracks, by their indices, before all else: against sliding, with the uplift that is not modelled where
    /// water would enter, and against overturning.
    pub fn add_equilibria(&mut self, scene: &Scene, found: &[(usize, Equilibrium)]) {
        let cracks = scene.dam.as_ref().map_or(&[][..], |dam| &dam.cracks);
        let mut first = Vec::new();
        for (crack, Equilibrium { sliding, with_uplift, overturning }) in found {
            let mut add = |what: &str, value: f64| {
                let name = of_crack(what, &cracks[*crack], cracks);
                if value.is_finite() {
                    first.push(Quantity {
                        name,
                        subject: Subject::AtRest,
                        value,
                        unit: "1".into(),
                        ..Quantity::default()
                    });
                }
            };
            let uplift = if takes_water(scene, &cracks[*crack]) { "with uplift" } else { "without uplift" };
            add(&format!("factor of safety against sliding, {uplift}"), *sliding);
            if let Some(UpliftEffect { sliding }) = with_uplift {
                add("factor of safety against sliding, with uplift", *sliding);
            }
            add(&format!("factor of safety against overturning, {uplift}"), *overturning);
        }
        self.quantities.splice(0..0, first);
    }

    fn remarks(&self, cracked: bool) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some(error) = self.value(ENERGY_BALANCE).filter(|e| *e > ENERGY_ALARM) {
            notes.push(format!(
                "WARNING: the energy balance error is {error:.1} % (limit {ENERGY_ALARM} %): do not use these \
                 results; lower dam.time_step_safety or refine the mesh"
            ));
        }
        if let Some(pressure) = self.value(LOWEST_PRESSURE).filter(|p| *p < CAVITATION) {
            notes.push(format!(
                "WARNING: the pressure falls to {pressure:.0} kPa relative to the atmosphere; water cavitates near -100 kPa, \
                 the linear model does not"
            ));
        }
        if cracked && self.named("residual sliding").next().is_none() {
            notes.push(format!("no residual sliding: the ground was not at rest for the last {REST} s"));
        }
        notes
    }

    /// The key figures: the larger peak of the crest, residual sliding (or else its peak) of each crack, base
    /// shear, tension, the lowest pressure.
    pub fn key_figures(&self) -> Vec<&Quantity> {
        let crest = self.named("peak crest displacement downstream");
        let crest = crest.chain(self.named("peak crest displacement upstream"));
        let larger = crest.max_by(|a, b| a.value.abs().total_cmp(&b.value.abs()));
        let residual = "residual sliding";
        let sliding = if self.named(residual).count() > 0 { residual } else { "peak sliding" };
        let further = [sliding, "peak base shear", "largest tension in the dam", LOWEST_PRESSURE];
        larger.into_iter().chain(further.into_iter().flat_map(|name| self.named(name))).collect()
    }

    /// The quantities of this name, each of one crack if there are several.
    fn named(&self, name: &'static str) -> impl Iterator<Item = &Quantity> {
        self.quantities.iter().filter(move |quantity| {
            let rest = quantity.name.strip_prefix(name);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(", "))
        })
    }

    /// The value of the quantity `name`.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.quantities.iter().find(|q| q.name == name).map(|q| q.value)
    }
}

/// The name of a quantity of one of the `cracks`: with the crack's where it has one, or where there are others.
fn of_crack(what: &str, crack: &CrackScene, cracks: &[CrackScene]) -> String {
    if cracks.len() > 1 || crack.name.is_some() {
        format!("{what}, {}", crack.label())
    } else {
        what.to_owned()
    }
}

struct Table<'a> {
    histories: &'a Histories,
    time: &'a [f64],
    /// Subject of the quantities that are being added.
    subject: Subject,
    quantities: Vec<Quantity>,
    /// Reason for a missing residual sliding, for each crack with a block that still moves.
    moving: Vec<String>,
    /// The same between the shocks of a sequence.
    moving_between: Vec<String>,
}

/// The time between a shock of a sequence and the next one.
struct Between {
    /// What the shock is called.
    shock: String,
    /// Time from which on the ground is still, s.
    rest: f64,
    /// Time at which the next shock begins, s.
    next: f64,
}

fn between(loaded: &LoadedScene) -> Vec<Between> {
    let motion = &loaded.ground_motion;
    if motion.aftershocks().is_empty() {
        return Vec::new();
    }
    let names = loaded.scene.ground_motion.shocks().into_iter().map(|shock| shock.label);
    let rests = motion.shocks().into_iter().zip(motion.begins());
    let rests = rests.map(|(shock, begin)| begin + shock.rest_from().unwrap_or(f64::INFINITY));
    let each = names.zip(rests).zip(motion.aftershocks());
    each.map(|((shock, rest), next)| Between { shock, rest, next: *next }).collect()
}

impl Table<'_> {
    fn add(&mut self, name: &str, value: f64, unit: &'static str, time: Option<f64>) {
        let (name, subject, unit) = (name.to_owned(), self.subject, unit.into());
        self.quantities.push(Quantity { name, subject, value, unit, time, place: None, band: None });
    }

    /// Adds the value of a column whose `key` is largest; returns its row.
    fn largest(
        &mut self,
        name: &str,
        column: &str,
        factor: f64,
        unit: &'static str,
        key: fn(f64) -> f64,
    ) -> Option<usize> {
        let values = self.histories.column(column)?;
        // The first of equals; what is always zero has no time.
        let (index, value) =
            values.iter().enumerate().rev().max_by(|a, b| key(*a.1).total_cmp(&key(*b.1)))?;
        let time = self.time.get(index).copied().filter(|_| *value != 0.0);
        self.add(name, factor * value, unit, time);
        Some(index)
    }

    /// The largest principal stresses of the whole dam, and where they were.
    fn largest_stresses(&mut self) {
        for (name, column, sign) in [
            ("largest tension in the dam", "dam.largest_principal_stress", 1.0),
            ("largest compression in the dam", "dam.smallest_principal_stress", -1.0),
        ] {
            let key: fn(f64) -> f64 = if sign > 0.0 { |stress| stress } else { |stress| -stress };
            let row = self.largest(name, column, sign * 1e-6, "MPa", key);
            let at = |axis: &str| {
                let values = self.histories.column(&format!("{column}_place.{axis}"))?;
                values.get(row?).map(|place| (place * 1e3).round() / 1e3)
            };
            let place = at("x").zip(at("y")).map(|(x, y)| [x, y]);
            if let Some(quantity) = self.quantities.last_mut().filter(|_| row.is_some()) {
                quantity.place = place;
            }
        }
    }

    fn peak(&mut self, name: &str, column: &str, factor: f64, unit: &'static str) {
        self.largest(name, column, factor, unit, f64::abs);
    }

    fn extremes(&mut self, column: &str) {
        self.largest("peak crest displacement downstream", column, 1e3, "mm", |u| u);
        self.largest("peak crest displacement upstream", column, 1e3, "mm", |u| -u);
    }

    /// Mean over the last second, if the ground was at rest for long enough before.
    fn residual(&mut self, name: &str, column: &str, loaded: &LoadedScene) {
        let Some(last) = LastSecond::of(self.histories, column).filter(|_| self.is_quiet(loaded)) else {
            return;
        };
        if last.is_rest() {
            self.add(name, 1e3 * last.sliding, "mm", None);
        } else {
            let remedy = match loaded.scene.time.longest_quiet {
                None => "set `time.longest_quiet`, the longest time that a run waits for rest",
                Some(_) => "increase `time.longest_quiet`",
            };
            self.moving.push(still_moves(name, &last, NOT_AT_REST, remedy));
        }
    }

    /// The same between two shocks, from the time (s) at which the ground is still to that at which the next one begins.
    fn residual_between(&mut self, name: &str, column: &str, [rest, next]: [f64; 2]) {
        let is_reached = self.time.last().is_some_and(|end| *end + 1e-9 >= next);
        if !is_reached || next + 1e-9 < rest + REST {
            return;
        }
        let Some(last) = LastSecond::until(self.histories, column, next) else { return };
        if last.is_rest() {
            self.add(name, 1e3 * last.sliding, "mm", None);
        } else {
            let when = format!("the dam is not at rest when the next shock begins at {next:.2} s");
            self.moving_between.push(still_moves(name, &last, &when, "increase `rest` of that shock"));
        }
    }

    /// The forces at the base, and the friction that holds it where it is pressed.
    fn base(&mut self) {
        self.peak("peak base shear", "dam.base_shear", 1e-6, "MN/m");
        self.largest("least normal force of the base", "dam.base_normal_force", 1e-6, "MN/m", |force| -force);
        let [shear, normal] = ["dam.base_shear", "dam.base_normal_force"]
            .map(|name| self.histories.column(name).unwrap_or(&[]));
        let pressed = shear.iter().zip(normal).enumerate().filter(|(_, (_, normal))| **normal > 0.0);
        let ratios = pressed.map(|(index, (shear, normal))| (index, shear.abs() / normal));
        if let Some((index, coefficient)) = ratios.max_by(|a, b| a.1.total_cmp(&b.1)) {
            let time = self.time.get(index).copied();
            self.add("largest base shear over normal force", coefficient, "1", time);
        }
    }

    /// C_p = p/(ρah) of a dam that is prescribed, a being the largest ground acceleration, horizontal or vertical.
    fn pressure_coefficient(&mut self, loaded: &LoadedScene) {
        if loaded.scene.prescribed.is_none() {
            return;
        }
        let water = &loaded.scene.reservoir;
        let largest = loaded.ground_motion.largest();
        if largest == 0.0 {
            return;
        }
        let factor = 1.0 / (water.density * largest * loaded.scene.depth());
        self.peak("peak pressure coefficient C_p at the base", "reservoir.base_pressure", factor, "1");
    }

    fn energy_balance(&mut self) {
        let largest = |column: &str| {
            let values = self.histories.column(column)?;
            Some(values.iter().fold(0.0, |a: f64, b| a.max(b.abs())))
        };
        if let (Some(error), Some(kinetic)) =
            (largest("dam.energy_balance_error"), largest("dam.kinetic_energy"))
            && kinetic > 0.0
        {
            self.add(ENERGY_BALANCE, 100.0 * error / kinetic, "%", None);
        }
    }

    fn coupling(&mut self, ending: &Ending) {
        let Some(iterations) = self.histories.column("iterations") else { return };
        // The first row is initialisation.
        let steps = iterations.get(1..).unwrap_or(&[]);
        if !steps.is_empty() {
            let mean = steps.iter().sum::<f64>() / steps.len() as f64;
            let most = steps.iter().copied().fold(0.0, f64::max);
            self.add("dam steps per communication step, mean", mean, "1", None);
            self.add("dam steps per communication step, most", most, "1", None);
        }
        for (unit, [calls, repeated]) in &ending.statistics.calls {
            self.add(&format!("steps of the {unit}, repeated ones included"), *calls as f64, "1", None);
            self.add(&format!("steps of the {unit} that were repeated"), *repeated as f64, "1", None);
        }
        if ending.statistics.fallbacks > 0 {
            let name = "steps in which another acceleration had to take over";
            self.add(name, ending.statistics.fallbacks as f64, "1", None);
        }
        if ending.statistics.rejected > 0 {
            self.add("windows started again", ending.statistics.rejected as f64, "1", None);
        }
        let estimated =
            self.histories.column("interpolation_error").is_some_and(|c| c.iter().any(|e| *e > 0.0));
        if estimated && ending.statistics.largest > 0.0 {
            let share = 100.0 / ending.statistics.largest;
            self.peak("coupling error, estimate beside the tolerance", "interpolation_error", share, "%");
        }
        if let Some(floor) = ending.statistics.rounding_floor {
            self.add("rounding floor of the units, pressure", floor, "Pa", None);
        }
        if ending.statistics.mapping_error > 0.0 {
            self.add(
                "work error of the mapping between wet faces",
                ending.statistics.mapping_error,
                "1",
                None,
            );
        }
        let largest = |column: &str| {
            self.histories.column(column).map(|c| c.iter().fold(0.0, |a: f64, b| a.max(b.abs())))
        };
        if let (Some(produced), Some(work)) =
            (largest("interface_energy_produced"), largest("interface_work"))
            && work > 0.0
        {
            self.add(
                "energy produced by the coupling over interface work",
                100.0 * produced / work,
                "%",
                None,
            );
        }
    }
}

/// The warning of a block without residual sliding, with the remedy.
fn still_moves(name: &str, last: &LastSecond, when: &str, remedy: &str) -> String {
    format!(
        "WARNING: no {name}: {when}. In the last {AVERAGED} s the block slides at {:.2} mm/s (limit for rest {} mm/s), and the kinetic \
         energy is {:.1e} of its peak (limit for rest {STILL_MOVES:e}); {remedy}, and check that the motion decays; `cofferdam check` \
         reports self-excited vibration",
        1e3 * last.speed,
        1e3 * STILL_SLIDES,
        last.kinetic_share
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key_figures(of: &[(&str, f64)]) -> Vec<String> {
        let quantity = |(name, value): &(&str, f64)| Quantity {
            name: (*name).to_owned(),
            value: *value,
            ..Quantity::default()
        };
        let quantities = of.iter().map(quantity).collect();
        let summary = Summary { status: String::new(), simulated_time: 1.0, notes: Vec::new(), quantities };
        summary.key_figures().into_iter().map(|quantity| quantity.name.clone()).collect()
    }

    #[test]
    fn every_crack_has_its_sliding() {
        let sliding = [("peak sliding, neck", 1.0), ("residual sliding, lift", 1.0)];
        let further = [("peak base shear", 1.0), ("residual sliding, neck", 1.0)];
        assert_eq!(
            key_figures(&[sliding, further].concat()),
            ["residual sliding, lift", "residual sliding, neck", "peak base shear"]
        );
        assert_eq!(key_figures(&[("peak opening", 1.0), ("peak sliding", 1.0)]), ["peak sliding"]);
        assert!(key_figures(&[("peak crest displacement downstreamish", 1.0)]).is_empty());
    }

    #[test]
    fn the_crest_has_its_larger_peak() {
        let [down, up] = ["downstream", "upstream"].map(|to| format!("peak crest displacement {to}"));
        assert_eq!(key_figures(&[(&down, 3.0), (&up, -2.0)]), std::slice::from_ref(&down));
        assert_eq!(key_figures(&[(&down, 3.0), (&up, -4.0)]), [up]);
    }
}
