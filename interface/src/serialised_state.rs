use serde::{Deserialize, Serialize, de::DeserializeOwned};
use sha2::{Digest, Sha256};

/// First bytes of every serialised state.
const MAGIC: &[u8; 8] = b"cofferst";
/// Version of the layout below: magic, version, fingerprint, digest of the payload, payload.
const VERSION: u32 = 7;
const HEADER: usize = 8 + 4 + 32 + 32;

/// Hash of everything from which a unit was made; only units with the same hash exchange states.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fingerprint([u8; 32]);

impl Fingerprint {
    /// SHA-256 of the unit's name and its configuration as JSON. JSON names every field, so that a form that leaves out
    /// defaults still tells all configurations apart; its numbers have all digits, and those that are not finite count
    /// as none.
    ///
    /// **Errors**: [`StateError::Configuration`].
    pub fn of<T: Serialize>(unit: &str, configuration: &T) -> Result<Self, StateError> {
        let bytes = serde_json::to_vec(configuration)
            .map_err(|cause| StateError::Configuration { cause: cause.to_string() })?;
        Ok(Self(Sha256::new().chain_update(unit).chain_update([0]).chain_update(bytes).finalize().into()))
    }
}

impl std::fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|b| write!(f, "{b:02x}"))
    }
}

impl std::fmt::Debug for Fingerprint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Fingerprint({self})")
    }
}

/// A serialised state that cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StateError {
    /// Too short, or without the first bytes of a state.
    #[error("these {length} bytes are not a serialised state")]
    NotAState {
        /// Number of bytes.
        length: usize,
    },
    /// Written by another version.
    #[error(
        "the state has format version {found}, but this build reads version {expected}; write the state again with this build"
    )]
    Version {
        /// Version in the bytes.
        found: u32,
        /// Version of this build.
        expected: u32,
    },
    /// Written by a unit of another scene or mesh.
    #[error(
        "the state belongs to another unit or scene (fingerprint {found}, here {expected}); restore it in a unit made \
         from the same scene"
    )]
    Fingerprint {
        /// Fingerprint in the bytes.
        found: Fingerprint,
        /// Fingerprint of this unit.
        expected: Fingerprint,
    },
    /// The payload differs from the one that was written.
    #[error(
        "the state is damaged: its {length} bytes are not those that were written; write or copy it again"
    )]
    Damaged {
        /// Number of bytes.
        length: usize,
    },
    /// The configuration has no form as JSON.
    #[error("the configuration of the unit cannot be hashed: {cause}; give its maps keys of text or numbers")]
    Configuration {
        /// What JSON cannot express.
        cause: String,
    },
    /// The payload cannot be written, or is not a state of this unit.
    #[error("the state cannot be encoded or decoded: {0}")]
    Encoding(postcard::Error),
}

/// Writes `state` as bytes, after a header of version, `fingerprint` and digest.
pub fn seal<T: Serialize>(fingerprint: Fingerprint, state: &T) -> Result<Vec<u8>, StateError> {
    let mut bytes = Vec::with_capacity(HEADER);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&fingerprint.0);
    bytes.resize(HEADER, 0);
    let mut bytes = postcard::to_extend(state, bytes).map_err(StateError::Encoding)?;
    let digest = Sha256::digest(&bytes[HEADER..]);
    bytes[HEADER - digest.len()..HEADER].copy_from_slice(&digest);
    Ok(bytes)
}

/// Reads bytes written by [`seal`].
///
/// **Errors**: [`StateError`], among them another version or another fingerprint.
pub fn open<T: DeserializeOwned>(fingerprint: Fingerprint, bytes: &[u8]) -> Result<T, StateError> {
    let not_a_state = StateError::NotAState { length: bytes.len() };
    let Some((header, payload)) = bytes.split_at_checked(HEADER) else {
        return Err(not_a_state);
    };
    let (magic, header) = header.split_at(8);
    if magic != MAGIC {
        return Err(not_a_state);
    }
    let (version, hash) = header.split_at(4);
    let found = u32::from_le_bytes(version.try_into().map_err(|_| not_a_state.clone())?);
    if found != VERSION {
        return Err(StateError::Version { found, expected: VERSION });
    }
    let (hash, digest) = hash.split_at(32);
    let found = Fingerprint(hash.try_into().map_err(|_| not_a_state)?);
    if found != fingerprint {
        return Err(StateError::Fingerprint { found, expected: fingerprint });
    }
    if *digest != *Sha256::digest(payload) {
        return Err(StateError::Damaged { length: bytes.len() });
    }
    match postcard::take_from_bytes(payload).map_err(StateError::Encoding)? {
        (state, []) => Ok(state),
        (_, _rest) => Err(StateError::NotAState { length: bytes.len() }),
    }
}

/// The state that [`seal`] wrote, for units with another `fingerprint`, wherever the first stands in it: for those alone whose
/// states have the same shape.
///
/// **Errors**: [`StateError::NotAState`].
pub fn relabel(bytes: &[u8], fingerprint: Fingerprint) -> Result<Vec<u8>, StateError> {
    const LABEL: std::ops::Range<usize> = 12..44;
    let mut bytes = bytes.to_vec();
    let length = bytes.len();
    if length < HEADER {
        return Err(StateError::NotAState { length });
    }
    let old = bytes[LABEL].to_vec();
    let found = bytes.windows(old.len()).enumerate().filter(|(_, window)| *window == old);
    let places: Vec<usize> = found.map(|(place, _)| place).collect();
    for place in places {
        bytes[place..place + old.len()].copy_from_slice(&fingerprint.0);
    }
    let digest = Sha256::digest(&bytes[HEADER..]);
    bytes[LABEL.end..HEADER].copy_from_slice(&digest);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize)]
    struct Bond {
        #[serde(skip_serializing_if = "Option::is_none")]
        cohesion: Option<f64>,
        #[serde(skip_serializing_if = "Option::is_none")]
        tension: Option<f64>,
    }

    #[test]
    fn a_state_with_another_label_is_another_units() -> Result<(), StateError> {
        let [a, b] = [1.0, 2.0].map(|x: f64| Fingerprint::of("dam", &x));
        let (a, b) = (a?, b?);
        // The unit's own state names it too.
        let state = (a, vec![1.5, -2.5]);
        let bytes = relabel(&seal(a, &state)?, b)?;
        assert!(matches!(open::<(Fingerprint, Vec<f64>)>(a, &bytes), Err(StateError::Fingerprint { .. })));
        assert_eq!(open::<(Fingerprint, Vec<f64>)>(b, &bytes)?, (b, state.1));
        assert!(relabel(&bytes[..40], a).is_err());
        Ok(())
    }

    #[test]
    fn values_left_out_do_not_make_two_configurations_one() -> Result<(), StateError> {
        let of = |cohesion, tension| Fingerprint::of("dam", &Bond { cohesion, tension });
        assert_ne!(of(Some(3e5), None)?, of(None, Some(3e5))?);
        assert_eq!(of(Some(3e5), None)?, of(Some(3e5), None)?);
        assert_ne!(of(Some(3e5), None)?, of(Some(f64::from_bits(3e5f64.to_bits() + 1)), None)?);
        let keys = std::collections::BTreeMap::from([([1, 2], 3)]);
        assert!(matches!(Fingerprint::of("dam", &keys), Err(StateError::Configuration { .. })));
        Ok(())
    }

    #[test]
    fn a_state_is_read_back_and_refused_elsewhere() -> Result<(), StateError> {
        let here = Fingerprint::of("dam", &[1.0, 2.0])?;
        let elsewhere = Fingerprint::of("dam", &[1.0, 2.5])?;
        let bytes = seal(here, &vec![0.1, -3.0])?;
        assert_eq!(open::<Vec<f64>>(here, &bytes)?, vec![0.1, -3.0]);
        assert_eq!(
            open::<Vec<f64>>(elsewhere, &bytes),
            Err(StateError::Fingerprint { found: here, expected: elsewhere })
        );
        assert_eq!(open::<Vec<f64>>(here, &bytes[..20]), Err(StateError::NotAState { length: 20 }));
        let (shorter, longer) = (&bytes[..HEADER + 2], [&bytes[..], &[0]].concat());
        for damaged in [shorter, &longer] {
            let length = damaged.len();
            assert_eq!(open::<Vec<f64>>(here, damaged), Err(StateError::Damaged { length }));
        }
        // An undamaged state of another type.
        assert_eq!(open::<[f64; 1]>(here, &bytes), Err(StateError::NotAState { length: bytes.len() }));
        assert!(matches!(open::<[Vec<f64>; 3]>(here, &bytes), Err(StateError::Encoding(_))));
        let mut newer = bytes.clone();
        newer[8] = 9;
        assert_eq!(open::<Vec<f64>>(here, &newer), Err(StateError::Version { found: 9, expected: VERSION }));
        Ok(())
    }
}
