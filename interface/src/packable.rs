use crate::{Capabilities, CoSimulation, Variable};
use serde::{Serialize, de::DeserializeOwned};
use std::num::NonZeroUsize;

/// A unit that can be packed as an FMU: everything it is made from can be written down.
///
/// An FMU holds the parameters as text. An importer may change the numbers behind variables of
/// causality [`Parameter`](crate::Causality::Parameter) before initialisation; nothing that it can
/// change changes the number of values of any variable.
pub trait Packable: CoSimulation + Sized + 'static {
    /// Everything that the unit is made from.
    type Parameters: Clone + Send + Serialize + DeserializeOwned + 'static;

    /// Name of the unit; that of [`CoSimulation::name`].
    const NAME: &'static str;

    /// What the unit is, in one line.
    const DESCRIPTION: &'static str;

    /// The unit's variables; those of [`CoSimulation::variables`].
    const VARIABLES: &'static [Variable];

    /// Makes the unit, with at most `threads` threads; their number changes no bit of any result.
    ///
    /// **Errors**: whatever is wrong with the parameters.
    fn from_parameters(parameters: Self::Parameters, threads: NonZeroUsize) -> Result<Self, Self::Error>;

    /// Number of values of `variable`; that of [`CoSimulation::size`].
    fn size_for(parameters: &Self::Parameters, variable: &Variable) -> usize;

    /// What the unit will be able to do; that of [`CoSimulation::capabilities`].
    fn capabilities_for(parameters: &Self::Parameters) -> Capabilities;

    /// The numbers behind a variable of causality `Parameter`, in its order; empty if these
    /// parameters have no such number, or it cannot be changed.
    fn numbers<'a>(parameters: &'a mut Self::Parameters, variable: &Variable) -> Vec<&'a mut f64>;
}
