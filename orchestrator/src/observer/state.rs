use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// What an observer needs to go on with a run, under the observer's name; empty where that is nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ObserverState {
    observer: String,
    bytes: Vec<u8>,
}

/// A state of an observer that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum ObserverStateError {
    /// That of another observer.
    #[error(
        "a state of the {observer} was asked for, that of `{found}` is there; continue a run with the observers that it had, in \
         their order"
    )]
    Other {
        /// Who asks.
        observer: &'static str,
        /// Whose state it is; nothing for an observer that keeps none.
        found: String,
    },
    /// It has no form in bytes, or these are not its.
    #[error(
        "the state of the {observer} cannot be encoded or decoded: {cause}; continue with the build that saved it"
    )]
    Encoding {
        /// The observer.
        observer: &'static str,
        /// The error.
        cause: postcard::Error,
    },
}

impl ObserverState {
    /// `state`, of `observer`.
    pub fn of<T: Serialize>(observer: &'static str, state: &T) -> Result<Self, ObserverStateError> {
        let bytes =
            postcard::to_stdvec(state).map_err(|cause| ObserverStateError::Encoding { observer, cause })?;
        Ok(Self { observer: observer.to_owned(), bytes })
    }

    /// The state, if it is `observer`'s.
    pub fn read<T: DeserializeOwned>(&self, observer: &'static str) -> Result<T, ObserverStateError> {
        if self.observer != observer {
            return Err(ObserverStateError::Other { observer, found: self.observer.clone() });
        }
        postcard::from_bytes(&self.bytes).map_err(|cause| ObserverStateError::Encoding { observer, cause })
    }
}
