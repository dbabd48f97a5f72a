//! The requested accuracy.

use super::{CREST, HISTORY, SLIDING};
use cofferdam_scene::AccuracyScene;
use std::collections::BTreeMap;
use std::str::FromStr;

/// The requested accuracy: the largest error of each quantity, as a share.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Asked(pub BTreeMap<String, f64>);

impl FromStr for Asked {
    type Err = String;

    /// Reads `5%`, `0.05` or `crest=2%,sliding=20%`; a share without a name applies to all quantities that are not named.
    fn from_str(text: &str) -> Result<Self, String> {
        let share = |text: &str| {
            let (number, unit) =
                text.trim().strip_suffix('%').map_or((text.trim(), 1.0), |number| (number.trim(), 0.01));
            let value =
                number.parse::<f64>().map_err(|_| format!("`{text}` is no number; write 5% or 0.05"))? * unit;
            let sound = (1e-4..=1.0).contains(&value);
            sound.then_some(value).ok_or_else(|| {
                format!("`{text}` must be between 0.01 % and 100 %; 5 means 500 %, so write 5%")
            })
        };
        let (mut found, mut unnamed) = (BTreeMap::new(), None);
        for part in text.split(',') {
            match part.split_once('=') {
                Some((name, value)) => {
                    let name = name.trim();
                    if ![CREST, HISTORY, SLIDING].contains(&name) {
                        return Err(format!(
                            "there is no quantity `{name}`; {CREST}, {HISTORY} and {SLIDING} are known"
                        ));
                    }
                    found.insert(name.to_owned(), share(value)?);
                }
                None => unnamed = Some(share(part)?),
            }
        }
        if let Some(value) = unnamed {
            // The history of a sliding block has no default limit; it is requested by name.
            if !found.contains_key(HISTORY) {
                found.insert(UNNAMED.to_owned(), value);
            }
            for name in [CREST, HISTORY, SLIDING] {
                found.entry(name.to_owned()).or_insert(value);
            }
        }
        Ok(Self(found))
    }
}

impl From<AccuracyScene> for Asked {
    fn from(scene: AccuracyScene) -> Self {
        let AccuracyScene { crest, history, sliding } = scene;
        let each = [(CREST, crest), (HISTORY, history), (SLIDING, sliding)];
        Self(each.into_iter().filter_map(|(name, share)| Some((name.to_owned(), share?))).collect())
    }
}

/// Mark that quantities were not named one by one.
pub(super) const UNNAMED: &str = "all";

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Asked, String> {
        text.parse()
    }

    #[test]
    fn an_accuracy_is_a_share_or_one_for_each_quantity() {
        let all = read("5%").expect("a share").0;
        assert_eq!((all[CREST], all[SLIDING]), (0.05, 0.05));
        let named = read("crest=2%, sliding=0.2").expect("shares").0;
        assert_eq!(
            named.into_iter().collect::<Vec<_>>(),
            [(CREST.to_owned(), 0.02), (SLIDING.to_owned(), 0.2)]
        );
        // Named quantities keep their shares; the unnamed share applies to all others.
        for text in ["crest=2%, 5%", "5%, crest=2%"] {
            let mixed = read(text).expect("shares").0;
            assert_eq!([CREST, HISTORY, SLIDING, UNNAMED].map(|name| mixed[name]), [0.02, 0.05, 0.05, 0.05]);
        }
        let with_history = read("5%, history=10%").expect("shares").0;
        assert!(with_history[HISTORY] == 0.1 && !with_history.contains_key(UNNAMED), "{with_history:?}");
        assert!(read("5").is_err_and(|why| why.contains("write 5%")));
        assert!(read("drift=5%").is_err_and(|why| why.contains("no quantity `drift`")));
    }
}
