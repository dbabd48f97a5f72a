//! The samples that follow from a plan.

use super::{Intensity, Perturbation, Plan, Variation};
use crate::statistics::latin_hypercube;
use cofferdam_motion::{GroundMotion, Units};
use std::path::Path;
use toml::Value;

/// One sample: a run of the scene.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Number of its record in the plan.
    pub record: usize,
    /// Direction of the record, 1 or −1.
    pub polarity: i64,
    /// Factor on the record.
    pub scale: f64,
    /// Intensity measure, g.
    pub intensity: f64,
    /// Number of its level or scale.
    pub level: usize,
    /// Number of the noise that is added to it, counted from 0.
    pub perturbation: Option<usize>,
    /// Number of its realisation: equal for samples that differ only in level or in listed values.
    pub draw: usize,
    /// The keys that vary, in the order of [`Plan::variations`], with their values.
    pub values: Vec<String>,
}

impl Plan {
    /// Number of samples, unless it is beyond all bounds.
    pub(super) fn count(&self) -> Option<usize> {
        let Intensity { levels, scales, .. } = &self.intensity;
        let levels = levels.len().max(scales.len()).max(1);
        let factors = [self.records.len(), self.polarities.len(), levels, self.samples, self.perturbations()];
        let lists = self.lists().map(|(_, values)| values.len());
        factors.into_iter().chain(lists).try_fold(1usize, usize::checked_mul)
    }

    /// Motions of a record.
    fn perturbations(&self) -> usize {
        self.perturbation.map_or(1, |perturbation| perturbation.count)
    }

    /// The keys that vary, those of the method last, with their variations.
    pub fn variations(&self) -> impl Iterator<Item = (&String, &Variation)> {
        self.parameters.iter().chain(&self.numerics)
    }

    pub(super) fn lists(&self) -> impl Iterator<Item = (usize, &Vec<Value>)> {
        self.variations().enumerate().filter_map(|(index, (_, variation))| match variation {
            Variation::Values(values) => Some((index, values)),
            _ => None,
        })
    }

    pub(super) fn distributed(&self) -> impl Iterator<Item = (usize, &Variation)> {
        let all = self.variations().enumerate().map(|(index, (_, variation))| (index, variation));
        all.filter(|(_, variation)| !matches!(variation, Variation::Values(_)))
    }

    /// Cluster of each record: those of one pair have the same number.
    pub fn clusters(&self) -> Vec<usize> {
        let of_pair = |index: usize| {
            let pair = &self.records[index].pair;
            self.records.iter().position(|other| !pair.is_empty() && other.pair == *pair).unwrap_or(index)
        };
        (0..self.records.len()).map(of_pair).collect()
    }

    /// All samples: for each record, polarity, point of the hypercube and combination of listed values every level.
    /// `measures` holds the intensity measure of each record as it is, g.
    pub fn samples(&self, measures: &[f64]) -> Vec<Sample> {
        let of_record = self.polarities.len() * self.samples * self.perturbations();
        let distributed: Vec<(usize, &Variation)> = self.distributed().collect();
        let points = latin_hypercube(self.records.len() * of_record, distributed.len(), self.seed);
        let lists: Vec<(usize, &Vec<Value>)> = self.lists().collect();
        let combinations: usize = lists.iter().map(|(_, values)| values.len()).product();
        let Intensity { levels, scales, .. } = &self.intensity;
        let mut samples = Vec::new();
        for (draw, point) in points.iter().enumerate() {
            let record = draw / of_record;
            let polarity = self.polarities[draw % of_record / (self.samples * self.perturbations())];
            let perturbation = self.perturbation.map(|perturbation| draw % perturbation.count);
            let measure = measures[record];
            let factor = self.records[record].factor;
            let scaled: Vec<f64> = match (&levels[..], &scales[..]) {
                ([], []) => vec![factor],
                ([], scales) => scales.iter().map(|scale| factor * scale).collect(),
                (levels, _) => levels.iter().map(|level| level / measure).collect(),
            };
            for mut combination in 0..combinations {
                let mut values = vec![String::new(); self.parameters.len() + self.numerics.len()];
                for ((index, variation), share) in distributed.iter().zip(point) {
                    values[*index] = variation.at(*share).map_or_else(String::new, |value| value.to_string());
                }
                for (index, list) in lists.iter().rev() {
                    values[*index] = list[combination % list.len()].to_string();
                    combination /= list.len();
                }
                samples.extend(scaled.iter().enumerate().map(|(level, &scale)| Sample {
                    record,
                    polarity,
                    scale,
                    intensity: levels.get(level).copied().unwrap_or(scale * measure),
                    level,
                    perturbation,
                    draw,
                    values: values.clone(),
                }));
            }
        }
        samples
    }

    /// The motion of a sample, of the `record` of its scene.
    pub fn motion(&self, sample: &Sample, record: GroundMotion) -> GroundMotion {
        match self.perturbation.zip(sample.perturbation) {
            None => record,
            Some((Perturbation { noise, .. }, number)) => {
                record.with_noise(noise, self.noise_seed(sample, number))
            }
        }
    }

    /// The noise of a record and direction is the same at every level and for every dam and method.
    fn noise_seed(&self, sample: &Sample, number: usize) -> u64 {
        let motion = 2 * sample.record + usize::from(sample.polarity < 0);
        (self.seed << 40) ^ ((motion as u64) << 20) ^ number as u64
    }

    /// Changes of the scene by `sample`. `folder` is that of the file.
    pub fn sets(&self, sample: &Sample, folder: &Path) -> Vec<String> {
        let record = &self.records[sample.record];
        let found = |file: &Path| {
            let file = folder.join(file);
            let file = file.canonicalize().unwrap_or(file);
            format!("file={}", Value::from(&*file.to_string_lossy()))
        };
        let in_units = |units: Option<Units>| match units.map(Value::try_from) {
            Some(Ok(units)) => Some(format!("units={units}")),
            _ => None,
        };
        let mut keys = vec![
            found(&record.file),
            format!("scale={}", sample.scale),
            format!("polarity={}", sample.polarity),
        ];
        keys.extend(in_units(record.units));
        keys.extend(record.column().map(|column| format!("column={column}")));
        for (key, value) in [("start", record.start), ("end", record.end)] {
            keys.extend(value.map(|value| format!("{key}={value}")));
        }
        let mut sets = self.set.clone();
        // The whole table: the settings of the scene's own record apply to no other.
        sets.push(format!("ground_motion.record={{{}}}", keys.join(", ")));
        if let Some(vertical) = &record.vertical {
            let mut keys =
                vec![format!("scale={}", vertical.scale), format!("polarity={}", vertical.polarity)];
            keys.extend(vertical.file.as_deref().map(found));
            keys.extend(in_units(vertical.units));
            keys.extend(vertical.column.map(|column| format!("column={column}")));
            sets.push(format!("ground_motion.vertical={{{}}}", keys.join(", ")));
        }
        sets.extend(self.variations().zip(&sample.values).map(|((key, _), value)| format!("{key}={value}")));
        sets
    }
}
