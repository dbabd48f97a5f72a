//! Getters and setters of both versions of FMI, by the type of variables. In FMI 2.0 all references are of single values, so that
//! there are as many values.
#![allow(unsafe_code)] // C calls it

use super::instances::Instances;
use super::pointers::{slice, slice_mut};
use super::types::{Boolean, Handle, Status};
use crate::{DataType, Packable};
use std::convert::identity;

/// A getter and a setter: the type of variables and of values in C, and the conversions to and from C.
macro_rules! access {
    ($($get:ident, $set:ident: $data_type:ident as $c:ty, $to_c:expr, $from_c:expr;)*) => {$(
        /// Gets variables of one type.
        ///
        /// # Safety
        /// As FMI demands of importers.
        pub unsafe fn $get<U: Packable>(
            instances: &Instances<U>,
            call: &'static str,
            instance: Handle,
            (references, count): (*const u32, usize),
            (values, length): (*mut $c, usize),
        ) -> Status {
            instances.call(call, instance.addr(), |i, _| {
                // SAFETY: by the caller.
                let references = unsafe { slice(call, "valueReferences", references, count) }?;
                // SAFETY: by the caller.
                let values = unsafe { slice_mut(call, "values", values, length) }?;
                let mut found = vec![0.0; values.len()];
                i.get(call, DataType::$data_type, references, &mut found)?;
                values.iter_mut().zip(found).for_each(|(value, found)| *value = $to_c(found));
                Ok(())
            })
        }

        /// Sets variables of one type.
        ///
        /// # Safety
        /// As FMI demands of importers.
        pub unsafe fn $set<U: Packable>(
            instances: &Instances<U>,
            call: &'static str,
            instance: Handle,
            (references, count): (*const u32, usize),
            (values, length): (*const $c, usize),
        ) -> Status {
            instances.call(call, instance.addr(), |i, _| {
                // SAFETY: by the caller.
                let references = unsafe { slice(call, "valueReferences", references, count) }?;
                // SAFETY: by the caller.
                let values = unsafe { slice(call, "values", values, length) }?;
                let given: Vec<f64> = values.iter().copied().map($from_c).collect();
                i.set(call, DataType::$data_type, references, &given)
            })
        }
    )*};
}

access! {
    get_float64, set_float64: Real as f64, identity, identity;
    get_int32, set_int32: Integer as i32, |value: f64| value as i32, f64::from;
    get_boolean, set_boolean: Boolean as Boolean, |value: f64| Boolean::from(value != 0.0), |value| number(value != 0);
    get_flag, set_flag: Boolean as i32, |value: f64| i32::from(value != 0.0), |value| number(value != 0);
}

fn number(flag: bool) -> f64 {
    f64::from(u8::from(flag))
}
