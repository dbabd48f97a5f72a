use super::made::failed;
use super::{Instance, Mode, is_input};
use crate::export::{ELEMENTS, ExportError};
use crate::variables::{TIME, dam::INPUTS_HELD};
use crate::{CallError, Packable};

impl<U: Packable> Instance<U> {
    /// Sets time derivatives of single values of inputs for the next step alone: what was set is the value at its start, and
    /// the value at its end follows.
    ///
    /// **Errors**: not an input, an order other than 1, a derivative that is not finite.
    pub fn set_slopes(
        &mut self,
        call: &'static str,
        references: &[u32],
        orders: &[i32],
        slopes: &[f64],
    ) -> Result<(), ExportError> {
        let remedy = "set derivatives of inputs between steps";
        self.expect(call, &[Mode::Instantiated, Mode::Initialization, Mode::Step], remedy)?;
        if self.holds_inputs() {
            return Err(ExportError::HeldInputs { call });
        }
        for (reference, (order, slope)) in references.iter().zip(orders.iter().zip(slopes)) {
            let (variable, index) = self.value(*reference)?;
            if *order != 1 || !is_input(variable) || variable.is_fixed_input() {
                let (variable, order) = (variable.name, *order);
                return Err(ExportError::InputDerivative { unit: U::NAME, variable, order });
            }
            if !slope.is_finite() {
                let (unit, variable, value, time) = (U::NAME, variable.name, *slope, self.time);
                return Err(CallError::NonFinite { unit, variable, index, value, time }.into());
            }
        }
        self.slopes.extend(references.iter().copied().zip(slopes.iter().copied()));
        Ok(())
    }

    /// Whether a parameter says that inputs are constant within a step.
    fn holds_inputs(&mut self) -> bool {
        let held = U::VARIABLES.iter().find(|variable| variable.name == INPUTS_HELD.name);
        held.is_some_and(|held| U::numbers(&mut self.parameters, held).iter().any(|flag| **flag != 0.0))
    }

    /// The inputs that have derivatives: their references, and what they are now.
    pub(super) fn sloping(&mut self, call: &'static str) -> Result<(Vec<u32>, Vec<f64>), ExportError> {
        let references: Vec<u32> = self.slopes.keys().copied().collect();
        let mut values = vec![0.0; references.len()];
        self.get_values(call, &references, &mut values)?;
        Ok((references, values))
    }
    /// `sensitivity = Σ ∂(unknown)/∂(known) · seed` of one communication step, for all unknowns and knowns.
    pub fn directional_derivative(
        &mut self,
        call: &'static str,
        [unknowns, knowns]: [&[u32]; 2],
        seed: &[f64],
        sensitivity: &mut [f64],
    ) -> Result<(), ExportError> {
        self.expect(call, &[Mode::Step], "derivatives exist only of communication steps, in Step Mode")?;
        let seeds = self.seeds(call, knowns, seed)?;
        let unknown_sizes = self.sizes(call, unknowns, sensitivity.len())?;
        let mut rest = sensitivity;
        let mut last = (TIME, Vec::new());
        for (unknown, size) in unknowns.iter().zip(unknown_sizes) {
            let (own, others) = rest.split_at_mut(size);
            rest = others;
            let (of, first) = match *unknown {
                ELEMENTS.. => (unknown / ELEMENTS, (unknown % ELEMENTS) as usize),
                unknown => (unknown, 0),
            };
            if last.0 != of || of == TIME {
                let mut sum = vec![0.0; if of == TIME { 1 } else { self.variable(of)?.1 }];
                let mut part = sum.clone();
                let unit = &self.made()?.unit;
                for (known, seed) in &seeds {
                    if [of, *known].contains(&TIME) {
                        let (unknown, known) = (of, *known);
                        return Err(CallError::Derivative { unit: U::NAME, unknown, known }.into());
                    }
                    unit.directional_derivative(of, *known, seed, &mut part).map_err(failed)?;
                    sum.iter_mut().zip(&part).for_each(|(sum, part)| *sum += part);
                }
                last = (of, sum);
            }
            own.copy_from_slice(&last.1[first..first + size]);
        }
        Ok(())
    }

    /// The seed of each variable among `knowns`, zero for the single values that are not among them.
    fn seeds(
        &self,
        call: &'static str,
        knowns: &[u32],
        seed: &[f64],
    ) -> Result<Vec<(u32, Vec<f64>)>, ExportError> {
        let mut seeds: Vec<(u32, Vec<f64>)> = Vec::new();
        let mut rest = seed;
        for (known, size) in knowns.iter().zip(self.sizes(call, knowns, seed.len())?) {
            let (own, others) = rest.split_at(size);
            rest = others;
            if *known < ELEMENTS {
                seeds.push((*known, own.to_vec()));
                continue;
            }
            let (variable, index) = self.value(*known)?;
            let of = variable.value_reference;
            let place = match seeds.iter().position(|(known, _)| *known == of) {
                Some(place) => place,
                None => {
                    seeds.push((of, vec![0.0; self.variable(of)?.1]));
                    seeds.len() - 1
                }
            };
            seeds[place].1[index] += own[0];
        }
        Ok(seeds)
    }
}
