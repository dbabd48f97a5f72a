use crate::{Capabilities, CoSimulation, Fingerprint, Variable};
use serde::{Serialize, de::DeserializeOwned};
use std::num::NonZeroUsize;

/// A unit that can be packed as an FMU: its parameters can be serialised.
///
/// An FMU holds the parameters as text, and beside them what is prepared from them. An importer may change the numbers of variables of
/// causality [`Parameter`](crate::Causality::Parameter) before initialisation. No such change alters
/// the number of values of a variable.
pub trait Packable: CoSimulation + Sized + 'static {
    /// Everything from which the unit is made.
    type Parameters: Clone + Send + Serialize + DeserializeOwned + 'static;

    /// Name of the kind of unit, that of its library; mostly also its [`CoSimulation::name`].
    const NAME: &'static str;

    /// What the unit is, in one line.
    const DESCRIPTION: &'static str;

    /// The unit's variables, equal to [`CoSimulation::variables`].
    const VARIABLES: &'static [Variable];

    /// Makes the unit, with at most `threads` threads; results do not depend on their number, bit for bit.
    ///
    /// **Errors**: parameters from which the unit cannot be made.
    fn from_parameters(parameters: Self::Parameters, threads: NonZeroUsize) -> Result<Self, Self::Error>;

    /// What costs most of the work of making the unit, as bytes with a digest, so that an FMU can hold it; none if the unit is
    /// made quickly.
    ///
    /// **Errors**: parameters from which the unit cannot be made.
    fn prepare(parameters: &Self::Parameters, threads: NonZeroUsize) -> Result<Option<Vec<u8>>, Self::Error> {
        let _ = (parameters, threads);
        Ok(None)
    }

    /// Makes the unit from what [`prepare`](Self::prepare) gave for the same parameters: the same unit, bit for bit.
    ///
    /// **Errors**: bytes that are damaged or of other parameters.
    fn from_prepared(
        parameters: Self::Parameters,
        prepared: &[u8],
        threads: NonZeroUsize,
    ) -> Result<Self, Self::Error> {
        let _ = prepared;
        Self::from_parameters(parameters, threads)
    }

    /// Whether what was prepared for the parameters `packed` can be used for these, as if it were prepared for them: by default only for
    /// equal ones.
    fn can_reuse_prepared(packed: &Self::Parameters, parameters: &Self::Parameters) -> bool {
        let hash = |parameters: &Self::Parameters| Fingerprint::of(Self::NAME, parameters).ok();
        let packed = hash(packed);
        packed.is_some() && packed == hash(parameters)
    }

    /// Number of values of `variable`, equal to [`CoSimulation::size`].
    fn size_for(parameters: &Self::Parameters, variable: &Variable) -> usize;

    /// What a unit with these parameters can do, equal to [`CoSimulation::capabilities`].
    fn capabilities_for(parameters: &Self::Parameters) -> Capabilities;

    /// The numbers in `parameters` that belong to a variable of causality `Parameter`, in the order of its
    /// values; empty if these parameters have no such numbers, or if they cannot be changed.
    fn numbers<'a>(parameters: &'a mut Self::Parameters, variable: &Variable) -> Vec<&'a mut f64>;
}
