use crate::Packable;
use crate::export::{ContentsError, ExportError};
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// What was prepared for the parameters that were packed.
pub(super) struct Prepared<P> {
    pub(super) path: PathBuf,
    pub(super) parameters: P,
}

pub(super) struct Made<U: Packable> {
    pub(super) unit: U,
    /// The state of the unit when it was made.
    pub(super) new: U::State,
    /// The state before the unit was initialised because outputs were read in Initialization Mode.
    pub(super) before_outputs: Option<U::State>,
}

/// An error of the unit.
pub(super) fn failed<E: std::error::Error + Send + Sync + 'static>(error: E) -> ExportError {
    ExportError::Unit(Box::new(error))
}

impl<P> Prepared<P> {
    /// The bytes of the file, if there is one.
    fn read(&self) -> Result<Option<Vec<u8>>, ContentsError> {
        match std::fs::read(&self.path) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(cause) => Err(ContentsError::Unreadable { path: self.path.clone(), cause }),
        }
    }
}

impl<U: Packable> Made<U> {
    /// Makes the unit and sets its `inputs`.
    pub(super) fn new(
        parameters: U::Parameters,
        prepared: &Prepared<U::Parameters>,
        inputs: &BTreeMap<u32, Vec<f64>>,
    ) -> Result<Self, ExportError> {
        let threads = std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
        let fits = U::can_reuse_prepared(&prepared.parameters, &parameters);
        let mut unit = match if fits { prepared.read()? } else { None } {
            // An error of the parameters is not reported as one of the file.
            Some(bytes) => match U::from_prepared(parameters.clone(), &bytes, threads) {
                Ok(unit) => unit,
                Err(cause) => {
                    U::from_parameters(parameters, threads).map_err(failed)?;
                    let path = prepared.path.clone();
                    return Err(ContentsError::Prepared { path, cause: Box::new(cause) }.into());
                }
            },
            None => U::from_parameters(parameters, threads).map_err(failed)?,
        };
        let new = unit.save_state();
        for (reference, values) in inputs {
            unit.set(*reference, values).map_err(failed)?;
        }
        Ok(Self { unit, new, before_outputs: None })
    }

    /// Initialises the unit and keeps its state before that.
    pub(super) fn initialise(&mut self, start_time: f64) -> Result<(), ExportError> {
        let before = self.unit.save_state();
        self.unit.initialise(start_time).map_err(failed)?;
        self.before_outputs = Some(before);
        Ok(())
    }
}
