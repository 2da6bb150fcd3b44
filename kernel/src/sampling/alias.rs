//! Choosing an index in proportion to its weight, in constant time: Walker's alias method (1977).
//!
//! Entry i keeps its own index with probability q_i and gives the rest to one alias, such that the sum of all that
//! index i receives is n w_i / W. The table is built in linear time, as Vose's (1991) is, but by Hübschle-Schneider and
//! Sanders's sweep ("Parallel weighted random sampling", 2019): two cursors, one over the light and one over the heavy
//! entries, replace his two work lists, so it needs no memory but the table itself, and the one running remainder is
//! kept in double precision.
//!
//! A weight so small that its share of the total is below the normal floats, 2⁻¹²⁶, counts as 0: so an index is drawn
//! only if its probability is known to full precision, and no estimate is divided by 0.

use core::fmt;

use bytemuck::{Pod, Zeroable};

/// One entry of an [`AliasTable`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct AliasEntry {
    /// The probability that the entry keeps its own index, in [0, 1].
    pub probability: f32,
    /// The index that it yields otherwise.
    pub alias: u32,
    /// The probability of this index in the whole table, w_i / W: 0 or a normal number.
    pub mass: f32,
}

/// A table from which indices are drawn with given probabilities. `S` is the caller's memory: a slice, an array, or
/// any other owner of entries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AliasTable<S> {
    entries: S,
}

impl<S: AsRef<[AliasEntry]> + AsMut<[AliasEntry]>> AliasTable<S> {
    /// The table for `weights`, built in `entries`, whose contents are overwritten. Equal weights give equal tables.
    ///
    /// # Errors
    ///
    /// See [`AliasError`]; the contents of `entries` are then of no use.
    pub fn build(weights: &[f32], mut entries: S) -> Result<Self, AliasError> {
        let table = entries.as_mut();
        check_length(weights.len())?;
        if table.len() != weights.len() {
            return Err(AliasError::Length { weights: weights.len(), entries: table.len() });
        }
        if let Some((index, &weight)) = weights.iter().enumerate().find(|(_, w)| !(w.is_finite() && **w >= 0.0)) {
            return Err(AliasError::Weight { index, weight });
        }
        let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        if total == 0.0 {
            return Err(AliasError::Zero);
        }
        sweep(weights, total, table);
        Ok(Self { entries })
    }
}

/// Fills the table: each light entry is topped up by the current heavy one, and when that has itself become light the
/// next heavy entry tops it up.
fn sweep(weights: &[f32], total: f64, table: &mut [AliasEntry]) {
    let share = |i: usize| f64::from(weights[i]) / total;
    let counts = |i: usize| share(i) >= f64::from(f32::MIN_POSITIVE);
    let scaled = |i: usize| if counts(i) { share(i) * weights.len() as f64 } else { 0.0 };
    for (i, entry) in table.iter_mut().enumerate() {
        let mass = if counts(i) { share(i) as f32 } else { 0.0 };
        *entry = AliasEntry { probability: 1.0, alias: i as u32, mass };
    }

    let mut heavies = (0..weights.len()).filter(|&i| scaled(i) > 1.0);
    // Without a heavy entry all weigh the same.
    let Some(mut heavy) = heavies.next() else { return };
    let mut remainder = scaled(heavy);
    for light in (0..weights.len()).filter(|&i| scaled(i) <= 1.0) {
        while remainder <= 1.0 {
            // Rounding may leave the last heavy entry short; it tops up the last lights all the same.
            let Some(next) = heavies.next() else { break };
            table[heavy].probability = remainder as f32;
            table[heavy].alias = next as u32;
            heavy = next;
            remainder += scaled(next) - 1.0;
        }
        table[light].probability = scaled(light) as f32;
        table[light].alias = heavy as u32;
        remainder += scaled(light) - 1.0;
    }
    // Heavy entries that are left when the lights are used up top up each other.
    for next in heavies {
        if remainder < 1.0 {
            table[heavy].probability = remainder.max(0.0) as f32;
            table[heavy].alias = next as u32;
        }
        remainder = scaled(next) + (remainder - 1.0).min(0.0);
        heavy = next;
    }
}

impl<S: AsRef<[AliasEntry]>> AliasTable<S> {
    /// A table built before, as one in read-only memory.
    ///
    /// # Errors
    ///
    /// [`AliasError::Empty`], [`AliasError::TooMany`], or [`AliasError::Entry`] for an alias or a probability out of
    /// range. Whether the masses fit the probabilities is not checked.
    pub fn from_entries(entries: S) -> Result<Self, AliasError> {
        let table = entries.as_ref();
        check_length(table.len())?;
        let valid = |e: &AliasEntry| {
            (e.alias as usize) < table.len() && [e.probability, e.mass].iter().all(|p| (0.0..=1.0).contains(p))
        };
        match table.iter().position(|e| !valid(e)) {
            Some(index) => Err(AliasError::Entry { index }),
            None => Ok(Self { entries }),
        }
    }

    /// The entries.
    pub fn entries(&self) -> &[AliasEntry] {
        self.entries.as_ref()
    }

    /// The probability of `index`: its weight over the sum of all weights. 0 for an index out of range.
    #[inline]
    pub fn mass(&self, index: usize) -> f32 {
        self.entries().get(index).map_or(0.0, |e| e.mass)
    }

    /// For `u` in [0, 1): an index, its probability, and what is left of `u`, uniform in [0, 1) again. An index of
    /// mass 0 is never drawn.
    ///
    /// All bits of `u` count. With b of them (53 at most) the probabilities are met to n 2⁻ᵇ of 1/n and what is left
    /// has about b - log₂ n bits: a single precision number of 24 is too coarse for more than some thousand entries,
    /// [`unit_double`](super::unit_double) makes one of 48, enough for any table.
    #[inline]
    pub fn sample(&self, u: f64) -> (usize, f32, f64) {
        let entries = self.entries();
        let position = u * entries.len() as f64;
        // There are fewer than 2³² entries, and this conversion is quick.
        let index = (position as u32 as usize).min(entries.len() - 1);
        let fraction = position - index as f64;
        let entry = entries[index];
        let kept = f64::from(entry.probability);
        let (index, rest) = if fraction < kept {
            (index, fraction / kept)
        } else {
            (entry.alias as usize, (fraction - kept) / (1.0 - kept))
        };
        (index, entries[index].mass, rest.clamp(0.0, 1.0 - f64::EPSILON / 2.0))
    }
}

fn check_length(length: usize) -> Result<(), AliasError> {
    match u32::try_from(length) {
        Ok(0) => Err(AliasError::Empty),
        Ok(_) => Ok(()),
        Err(_) => Err(AliasError::TooMany { length }),
    }
}

/// Why a table could not be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AliasError {
    /// There are no weights, or no entries.
    Empty,
    /// An index must fit in 32 bits.
    TooMany {
        /// The number of weights or entries.
        length: usize,
    },
    /// The memory has not one entry for each weight.
    Length {
        /// The number of weights.
        weights: usize,
        /// The number of entries.
        entries: usize,
    },
    /// A weight is negative, infinite or not a number.
    Weight {
        /// Its index.
        index: usize,
        /// The weight.
        weight: f32,
    },
    /// All weights are 0.
    Zero,
    /// An entry has an alias or a probability out of range.
    Entry {
        /// Its index.
        index: usize,
    },
}

impl fmt::Display for AliasError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "an alias table needs at least one weight"),
            Self::TooMany { length } => write!(f, "{length} weights are too many for indices of 32 bits"),
            Self::Length { weights, entries } => write!(f, "{weights} weights need as many entries, not {entries}"),
            Self::Weight { index, weight } => write!(f, "weight {index} is {weight}: it must be finite and at least 0"),
            Self::Zero => write!(f, "all weights are 0: at least one must be positive"),
            Self::Entry { index } => {
                write!(f, "entry {index}: its alias must be an index of the table, its probabilities from 0 to 1")
            }
        }
    }
}

impl core::error::Error for AliasError {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::statistics::{Checksum, chi_squared};
    use crate::sampling::{ONE_MINUS_EPSILON, Stream, unit_double};

    fn table(weights: &[f32]) -> AliasTable<Vec<AliasEntry>> {
        AliasTable::build(weights, vec![AliasEntry::default(); weights.len()]).unwrap()
    }

    /// What the entries give to each index in all.
    fn reconstruct(table: &AliasTable<Vec<AliasEntry>>) -> Vec<f64> {
        let entries = table.entries();
        let mut mass = vec![0.0; entries.len()];
        for (i, e) in entries.iter().enumerate() {
            mass[i] += f64::from(e.probability) / entries.len() as f64;
            mass[e.alias as usize] += (1.0 - f64::from(e.probability)) / entries.len() as f64;
        }
        mass
    }

    fn random_weights(seed: u64, count: u32) -> Vec<f32> {
        // Over nine decades, with zeros between.
        let weight = |[u, v, ..]: [f32; 4]| if v < 0.2 { 0.0 } else { libm::exp10f(9.0 * u - 6.0) };
        (0..count).map(|i| weight(Stream::new(seed, i, 0).uniform4(0))).collect()
    }

    fn cases() -> Vec<Vec<f32>> {
        let mut cases = vec![
            vec![3.0],
            vec![0.1; 3],
            vec![1.0 / 3.0; 1000],
            vec![0.0, 0.0, 5.0, 0.0],
            vec![1.0, 2.0, 3.0, 4.0],
            vec![4.0, 3.0, 2.0, 1.0],
            vec![f32::MAX; 5],
            vec![f32::MAX, 1.0, f32::MIN_POSITIVE],
            // Shares just above and below 2⁻¹²⁶, which in the table of three would both round to something.
            vec![1.0, f32::MIN_POSITIVE, f32::MIN_POSITIVE * 0.75],
            (0..1000).map(|i| if i < 500 { 1.0 } else { 1.001 }).collect(),
            (0..1000).map(|i| if i < 999 { 1.0 } else { 0.0 }).collect(),
        ];
        cases.extend((1..60).map(|seed| random_weights(seed, 7 * seed as u32)));
        cases.retain(|weights| weights.iter().any(|&w| w > 0.0));
        cases
    }

    #[test]
    fn entries_add_up_to_the_weights() {
        for weights in cases() {
            let table = table(&weights);
            let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
            for (i, mass) in reconstruct(&table).into_iter().enumerate() {
                let expected = f64::from(weights[i]) / total;
                assert!((mass - expected).abs() < 1e-7, "{i} of {}: {mass}, not {expected}", weights.len());
                // Masses below the range of normal floats are 0.
                let expected = if expected < f64::from(f32::MIN_POSITIVE) { 0.0 } else { expected };
                assert!((f64::from(table.mass(i)) - expected).abs() <= 1e-7 * expected);
                assert_eq!(mass > 0.0, table.mass(i) > 0.0, "{i} is drawn by {mass}, not {}", table.mass(i));
            }
            assert_eq!(AliasTable::from_entries(table.entries()).unwrap().entries(), table.entries());
        }
    }

    #[test]
    fn draws_follow_the_weights() {
        for seed in 1..8 {
            let weights = random_weights(seed, 40);
            let table = table(&weights);
            let mut counts = vec![0.0; 40];
            for i in 0..50_000 {
                let (index, mass, _) = table.sample(Stream::new(seed, i, 1).uniform4(0)[0].into());
                assert_eq!(mass, table.mass(index));
                counts[index] += 1.0;
            }
            let expected: Vec<_> = (0..40).map(|i| 50_000.0 * f64::from(table.mass(i))).collect();
            // The heaviest weights first: cells too light for the test are pooled with their neighbours.
            let mut order: Vec<_> = (0..40).filter(|&i| weights[i] > 0.0).collect();
            order.sort_by(|&a, &b| weights[a].total_cmp(&weights[b]));
            let pick = |values: &[f64]| order.iter().map(|&i| values[i]).collect::<Vec<_>>();
            let z = chi_squared(&pick(&counts), &pick(&expected));
            assert!(z.abs() < 4.0, "seed {seed}: {z}");
        }
    }

    #[test]
    fn remainder_of_u_is_uniform() {
        let table = table(&[1.0, 2.0, 3.0, 4.0, 0.5]);
        let mut counts = [0.0; 5 * 16];
        for i in 0..40_000 {
            let (index, _, rest) = table.sample(Stream::new(2, i, 0).uniform4(0)[0].into());
            assert!((0.0..1.0).contains(&rest));
            counts[index * 16 + (rest * 16.0) as usize] += 1.0;
        }
        let expected: Vec<_> = (0..80).map(|i| 2500.0 * f64::from(table.mass(i / 16))).collect();
        let z = chi_squared(&counts, &expected);
        assert!(z.abs() < 4.0, "{z}");
    }

    #[test]
    fn ends_of_the_interval_are_safe() {
        for weights in cases() {
            let table = table(&weights);
            for u in [0.0, f64::MIN_POSITIVE, 0.5, ONE_MINUS_EPSILON.into(), 1.0 - f64::EPSILON / 2.0] {
                let (index, mass, rest) = table.sample(u);
                assert!(weights[index] > 0.0 && mass == table.mass(index) && (0.0..1.0).contains(&rest));
            }
        }
        assert_eq!(table(&[3.0]).sample(0.25), (0, 1.0, 0.25));
    }

    /// Where an entry hands over to its alias in a table of a million, to a millionth of the entry's width.
    #[test]
    fn large_tables_are_met_to_a_millionth() {
        let table = table(&random_weights(5, 1_000_000));
        let (mut tried, count) = (0, table.entries().len() as f64);
        for (i, entry) in table.entries().iter().enumerate().step_by(1013) {
            let kept = f64::from(entry.probability);
            if !(1e-3..0.999).contains(&kept) {
                continue;
            }
            // On the grid of numbers of 48 bits.
            let at = |part: f64| ((i as f64 + part) / count * 2f64.powi(48)).round() * 2f64.powi(-48);
            assert_eq!(table.sample(at(kept - 1e-6)).0, i);
            assert_eq!(table.sample(at(kept + 1e-6)).0, entry.alias as usize);
            tried += 1;
        }
        assert!(tried > 100, "{tried}");
    }

    #[test]
    fn bad_weights_are_refused() {
        let build = |weights: &[f32]| AliasTable::build(weights, vec![AliasEntry::default(); 3]).unwrap_err();
        assert_eq!(AliasTable::build(&[], []), Err(AliasError::Empty));
        assert_eq!(build(&[1.0; 4]), AliasError::Length { weights: 4, entries: 3 });
        assert_eq!(build(&[0.0, -0.0, 0.0]), AliasError::Zero);
        assert_eq!(build(&[1.0, -1.0, 0.0]), AliasError::Weight { index: 1, weight: -1.0 });
        assert!(matches!(build(&[1.0, 1.0, f32::NAN]), AliasError::Weight { index: 2, .. }));
        assert!(matches!(build(&[f32::INFINITY, 1.0, 1.0]), AliasError::Weight { index: 0, .. }));
        assert_eq!(build(&[1.0, -1.0, 0.0]).to_string(), "weight 1 is -1: it must be finite and at least 0");
        let entry = AliasEntry { probability: 1.0, alias: 0, mass: 0.5 };
        for bad in [AliasEntry { alias: 2, ..entry }, AliasEntry { probability: f32::NAN, ..entry }] {
            assert_eq!(AliasTable::from_entries([entry, bad]), Err(AliasError::Entry { index: 1 }));
        }
    }

    #[test]
    fn golden() {
        let table = table(&random_weights(1, 300));
        let mut sum = Checksum::new();
        for i in 0..10_000 {
            let (index, mass, rest) = table.sample(unit_double(Stream::new(3, i, 0).uniform2(0)));
            sum.add([index as f32, mass, rest as f32]);
        }
        assert_eq!(sum.value(), 0xECDD_82EA_2CFA_45DD, "{:#018X}", sum.value());
    }
}
