//! Outlier records, which are gathered again with more rays: records dominated by a few bright rays, and records whose
//! rays have missed that light.
//!
//! A record is an outlier if its standard error is large relative to the surrounding light, `σ_i > ε Ē`, as when a
//! single ray found most of the light. After these have been gathered again, neighbours that disagree with one by more
//! than both standard errors allow are outliers too: `|E_i - E_j| > 3 √(σ_i² + σ_j²)`. The standard error of a record
//! that has missed the light does not show it.

use std::collections::HashSet;

use super::Cache;
use super::record::Record;

/// ε.
const LARGE: f32 = 0.25;
/// The surrounding light counts as at least this part of the mean of all records, as errors in the dark are not
/// visible.
const DARK: f32 = 0.1;
/// The number of standard errors by which records may differ.
const DEVIATIONS: f32 = 3.0;
/// The additional part of irradiance by which they may differ, as gradients do not explain all differences.
const TOLERANCE: f32 = 0.1;

impl Cache {
    /// The keys of the records that are doubtful, in the order of the records. `again` are those that were gathered
    /// again.
    pub(crate) fn doubtful(&self, again: &HashSet<u64>) -> Vec<u64> {
        let brightness = |record: &Record| record.irradiance.max_element();
        let sum: f64 = self.records.iter().map(|record| f64::from(brightness(record))).sum();
        let dark = DARK * (sum / self.records.len().max(1) as f64) as f32;
        let weighting = self.weighting(self.stretch());
        let doubts = |&(number, record): &(usize, &Record)| {
            let (mut light, mut weights, mut disagrees) = (0.0, 0.0, false);
            self.tree.query(record.position, |i| {
                let other = &self.records[i];
                let weight = weighting.weight(other, &record.point());
                if i == number || weight <= 0.0 {
                    return;
                }
                let said = other.extrapolate(record.position, record.normal, true, true);
                light += weight * brightness(other);
                weights += weight;
                let noise = DEVIATIONS * record.standard_error.hypot(other.standard_error);
                let allowed = noise + TOLERANCE * brightness(other).max(brightness(record)).max(dark);
                let difference = (said - record.irradiance).abs().max_element();
                disagrees |= difference > allowed && again.contains(&other.key);
            });
            let light = if weights > 0.0 { light / weights } else { brightness(record) };
            disagrees || record.standard_error > LARGE * light.max(dark)
        };
        let open = self.records.iter().enumerate().filter(|(_, record)| !again.contains(&record.key));
        open.filter(doubts).map(|(_, record)| record.key).collect()
    }

    /// Takes these records in place of those that have their keys.
    pub(crate) fn replace(&mut self, records: Vec<Record>) {
        let keys: HashSet<u64> = records.iter().map(|record| record.key).collect();
        let kept: Vec<Record> = self.take_original().filter(|record| !keys.contains(&record.key)).collect();
        self.commit(kept.into_iter().chain(records).collect());
    }
}
