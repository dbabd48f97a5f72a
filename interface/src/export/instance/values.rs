use super::made::failed;
use super::{Instance, Mode, is_input};
use crate::export::{ELEMENTS, ExportError};
use crate::variables::TIME;
use crate::{CallError, Causality, DataType, Packable, Variable};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

impl<U: Packable> Instance<U> {
    pub(super) fn variable(&self, reference: u32) -> Result<(&'static Variable, usize), CallError> {
        let unknown = CallError::UnknownVariable { unit: U::NAME, value_reference: reference };
        self.variables.get(&reference).copied().ok_or(unknown)
    }

    /// The variable of a single value, and its index.
    pub(super) fn value(&self, reference: u32) -> Result<(&'static Variable, usize), CallError> {
        let (of, index) = (reference / ELEMENTS, (reference % ELEMENTS) as usize);
        let found = self.variable(of).ok().filter(|(_, size)| index < *size);
        let unknown = CallError::UnknownVariable { unit: U::NAME, value_reference: reference };
        found.map(|(variable, _)| (variable, index)).ok_or(unknown)
    }

    /// Number of values of each reference; checks that `found` is their sum.
    pub(super) fn sizes(
        &self,
        call: &'static str,
        references: &[u32],
        found: usize,
    ) -> Result<Vec<usize>, ExportError> {
        let size = |reference: &u32| match *reference {
            TIME => Ok(1),
            ELEMENTS.. => self.value(*reference).map(|_| 1),
            reference => self.variable(reference).map(|(_, size)| size),
        };
        let sizes = references.iter().map(size).collect::<Result<Vec<usize>, CallError>>()?;
        let expected = sizes.iter().sum();
        if expected == found { Ok(sizes) } else { Err(ExportError::Values { call, expected, found }) }
    }

    /// Checks that all variables are of the type of the `call`, such as `fmi2GetReal` or `fmi3SetBoolean`.
    fn expect_type(
        &self,
        call: &'static str,
        data_type: DataType,
        references: &[u32],
    ) -> Result<(), ExportError> {
        for reference in references {
            let (variable, found) = match *reference {
                TIME => ("time", DataType::Real),
                ELEMENTS.. => self.value(*reference).map(|(v, _)| (v.name, v.data_type))?,
                reference => self.variable(reference).map(|(v, _)| (v.name, v.data_type))?,
            };
            if found != data_type {
                let is_fmi2 = call.starts_with("fmi2");
                let named = if is_fmi2 { found.fmi2_name() } else { found.fmi3_name() };
                let asked = if is_fmi2 { data_type.fmi2_name() } else { data_type.fmi3_name() };
                let remedy = call.strip_suffix(asked).unwrap_or_default().to_owned() + named;
                return Err(ExportError::Type { call, variable, data_type: named, remedy });
            }
        }
        Ok(())
    }

    /// Sets variables of this type from `values`, all of them or none.
    ///
    /// **Errors**: unknown or unsettable variable, one of another type, wrong number of values, a value that is not finite.
    pub fn set(
        &mut self,
        call: &'static str,
        data_type: DataType,
        references: &[u32],
        values: &[f64],
    ) -> Result<(), ExportError> {
        self.expect_type(call, data_type, references)?;
        self.set_values(call, references, values)
    }

    /// Copies the values of variables of this type, one after the other, into `values`.
    ///
    /// **Errors**: unknown variable, one of another type, wrong number of values, an output before the unit has outputs.
    pub fn get(
        &mut self,
        call: &'static str,
        data_type: DataType,
        references: &[u32],
        values: &mut [f64],
    ) -> Result<(), ExportError> {
        self.expect_type(call, data_type, references)?;
        self.get_values(call, references, values)
    }

    /// Sets variables from `values`, all of them or none.
    pub(super) fn set_values(
        &mut self,
        call: &'static str,
        references: &[u32],
        values: &[f64],
    ) -> Result<(), ExportError> {
        if self.mode == Mode::Terminated {
            return Err(self.refused(call, "reset the instance first"));
        }
        if references.iter().all(|reference| *reference < ELEMENTS) {
            return self.set_whole(call, references, values);
        }
        let (references, values) = self.whole(call, references, values)?;
        self.set_whole(call, &references, &values)
    }

    /// Whole variables in place of single values; the other values of these variables stay what they are.
    fn whole(
        &mut self,
        call: &'static str,
        references: &[u32],
        values: &[f64],
    ) -> Result<(Vec<u32>, Vec<f64>), ExportError> {
        let mut whole = BTreeMap::<u32, Vec<f64>>::new();
        let mut rest = values;
        for (reference, size) in references.iter().zip(self.sizes(call, references, values.len())?) {
            let (own, others) = rest.split_at(size);
            rest = others;
            let (of, first) = match *reference {
                ELEMENTS.. => (reference / ELEMENTS, (reference % ELEMENTS) as usize),
                reference => (reference, 0),
            };
            let all = match whole.entry(of) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(free) => free.insert(self.now(of)?),
            };
            all[first..first + size].copy_from_slice(own);
        }
        let (references, values): (Vec<_>, Vec<_>) = whole.into_iter().unzip();
        Ok((references, values.concat()))
    }

    /// The values that an input or parameter has; zeros for what cannot be set and need not have a value now.
    fn now(&mut self, reference: u32) -> Result<Vec<f64>, ExportError> {
        if reference == TIME {
            return Ok(vec![self.time]);
        }
        let (variable, size) = self.variable(reference)?;
        let mut now = vec![0.0; size];
        if is_input(variable) || variable.causality == Causality::Parameter {
            self.get_one(variable, &mut now)?;
        }
        Ok(now)
    }

    fn set_whole(
        &mut self,
        call: &'static str,
        references: &[u32],
        values: &[f64],
    ) -> Result<(), ExportError> {
        let (mut settings, mut rest) = (Vec::with_capacity(references.len()), values);
        for (reference, size) in references.iter().zip(self.sizes(call, references, values.len())?) {
            let (own, others) = rest.split_at(size);
            rest = others;
            if *reference == TIME {
                return Err(ExportError::Time);
            }
            let (variable, _) = self.variable(*reference)?;
            self.check_setting(call, variable, own)?;
            settings.push((variable, own));
        }
        // If the unit refuses one input, the others must not stay set.
        let before = match &self.made {
            Some(made) if settings.len() > 1 => Some((made.unit.save_state(), made.before_outputs.clone())),
            _ => None,
        };
        let (parameters, inputs): (Vec<_>, Vec<_>) =
            settings.into_iter().partition(|(variable, _)| variable.causality == Causality::Parameter);
        for (variable, values) in inputs {
            if let Err(error) = self.set_input(variable, values) {
                if let (Some(made), Some((before, before_outputs))) = (&mut self.made, before) {
                    made.unit.restore_state(&before).map_err(failed)?;
                    made.before_outputs = before_outputs;
                }
                return Err(error);
            }
        }
        parameters.into_iter().try_for_each(|(variable, values)| self.set_parameter(variable, values))
    }

    /// Checks whether a variable can be set to these values, as far as possible without the unit.
    fn check_setting(
        &self,
        call: &'static str,
        variable: &'static Variable,
        values: &[f64],
    ) -> Result<(), ExportError> {
        let (unit, variable_name, time) = (U::NAME, variable.name, self.time);
        let not_finite = values.iter().position(|v| !v.is_finite()).map(|index| (index, values[index]));
        match (variable.causality, not_finite) {
            (Causality::CalculatedParameter | Causality::Output | Causality::Local, _) => {
                Err(CallError::NotSettable { unit, variable: variable_name }.into())
            }
            (Causality::Parameter, Some((index, value))) => {
                Err(ExportError::NonFiniteParameter { unit, variable: variable_name, index, value })
            }
            (Causality::Parameter, None) => {
                let remedy = "parameters are set before initialisation ends";
                self.expect(call, &[Mode::Instantiated, Mode::Initialization], remedy)
            }
            (Causality::Input, Some((index, value))) => {
                Err(CallError::NonFinite { unit, variable: variable_name, index, value, time }.into())
            }
            (Causality::Input, None) if variable.is_fixed_input() => {
                let remedy = "the variable is fixed when initialisation ends";
                self.expect(call, &[Mode::Instantiated, Mode::Initialization], remedy)
            }
            (Causality::Input, None) => Ok(()),
        }
    }

    pub(super) fn set_input(
        &mut self,
        variable: &'static Variable,
        values: &[f64],
    ) -> Result<(), ExportError> {
        let Some(made) = &mut self.made else {
            self.inputs.insert(variable.value_reference, values.to_vec());
            return Ok(());
        };
        if let Some(before) = made.before_outputs.take() {
            made.unit.restore_state(&before).map_err(failed)?;
        }
        made.unit.set(variable.value_reference, values).map_err(failed)
    }

    fn set_parameter(&mut self, variable: &'static Variable, values: &[f64]) -> Result<(), ExportError> {
        let mut numbers = U::numbers(&mut self.parameters, variable);
        if numbers.iter().map(|number| **number).eq(values.iter().copied()) {
            return Ok(());
        }
        numbers.iter_mut().zip(values).for_each(|(number, value)| **number = *value);
        self.unmake()
    }

    /// Copies the values of the variables, one after the other, into `values`.
    pub(super) fn get_values(
        &mut self,
        call: &'static str,
        references: &[u32],
        values: &mut [f64],
    ) -> Result<(), ExportError> {
        let mut rest = values;
        // Single values of one variable mostly follow each other.
        let mut last = (TIME, Vec::new());
        for (reference, size) in references.iter().zip(self.sizes(call, references, rest.len())?) {
            let (own, others) = rest.split_at_mut(size);
            rest = others;
            match *reference {
                TIME => own.fill(self.time),
                ELEMENTS.. => {
                    let (variable, index) = self.value(*reference)?;
                    if last.0 != variable.value_reference {
                        let mut all = vec![0.0; self.variable(variable.value_reference)?.1];
                        self.get_one(variable, &mut all)?;
                        last = (variable.value_reference, all);
                    }
                    own[0] = last.1[index];
                }
                reference => self.get_one(self.variable(reference)?.0, own)?,
            }
        }
        Ok(())
    }
    fn get_one(&mut self, variable: &'static Variable, values: &mut [f64]) -> Result<(), ExportError> {
        let reference = variable.value_reference;
        match (variable.causality, &self.made, self.inputs.get(&reference)) {
            (Causality::Parameter, ..) => {
                let numbers = U::numbers(&mut self.parameters, variable);
                values.iter_mut().zip(numbers).for_each(|(value, number)| *value = *number);
                Ok(())
            }
            (Causality::Input, None, Some(set)) => {
                values.copy_from_slice(set);
                Ok(())
            }
            _ => {
                let (mode, time) = (self.mode, self.time);
                let made = self.made()?;
                match made.unit.get(reference, values) {
                    // Values that depend on the inputs exist only after the unit has been initialised.
                    Err(_) if mode == Mode::Initialization && made.before_outputs.is_none() => {
                        made.initialise(time)?;
                        made.unit.get(reference, values).map_err(failed)
                    }
                    result => result.map_err(failed),
                }
            }
        }
    }
}
