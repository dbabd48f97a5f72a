//! A factor and its settings.

use cofferdam_report::RangeFactor;
use cofferdam_unit::number::plain;

/// A factor of a scene.
pub struct Factor {
    /// What it is.
    pub about: RangeFactor,
    /// Its settings.
    pub values: Values,
}

/// The settings of a factor.
pub enum Values {
    /// A number.
    Between(Between),
    /// One of several settings, each as likely as any other; that with the number `base` is the scene's.
    Choices {
        /// The settings.
        choices: Vec<Choice>,
        /// Number of the scene's.
        base: usize,
    },
    /// Noise on the ground motion: this number of replicates, and noise in every run of the joint sample.
    Noise(usize),
}

/// A number between two limits.
pub struct Between {
    /// The lower limit.
    pub low: f64,
    /// The upper limit.
    pub high: f64,
    /// The number of the scene.
    pub base: f64,
    /// Whether its logarithm, not the number, is equally distributed.
    pub logarithmic: bool,
    /// The changes of the scene for a number.
    pub sets: Box<dyn Fn(f64) -> Vec<String> + Send + Sync>,
    /// What is said before a number, such as ×.
    pub before: &'static str,
    /// What is said after it: its unit.
    pub after: &'static str,
}

impl Between {
    /// The number below which a share of all lies.
    pub fn at(&self, share: f64) -> f64 {
        match self.logarithmic {
            true => self.low * (self.high / self.low).powf(share),
            false => self.low + share * (self.high - self.low),
        }
    }

    /// A number as text.
    pub fn shown(&self, value: f64) -> String {
        let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
        format!("{}{}{}", self.before, plain(rounded), self.after)
    }
}

/// A setting.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Its name.
    pub name: String,
    /// The changes of the scene.
    pub sets: Vec<String>,
}
