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

use crate::simd::{Isa, Simd, Work, dispatch};

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
    /// See [`AliasError`]; the contents of `entries` are then unspecified.
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
    /// A finished table, for example in read-only memory.
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

    /// For `u` in [0, 1): an index, its probability, and the remainder of `u`, rescaled to be uniform in [0, 1). An
    /// index of mass 0 is never drawn.
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
        (index, entries[index].mass, rest.clamp(0.0, ONE_MINUS_EPSILON_F64))
    }

    /// Writes the index and the rest that [`sample`](Self::sample) gives for each `u`, with the instructions of `isa`:
    /// faster, and equal bit for bit. Elements beyond the end of the shorter slice are left unchanged.
    pub fn sample_many(&self, isa: Isa, u: &[f64], indices: &mut [u32], rests: &mut [f64]) {
        let count = u.len().min(indices.len()).min(rests.len());
        let (indices, rests) = (&mut indices[..count], &mut rests[..count]);
        dispatch(isa, SampleMany { entries: self.entries(), u, indices, rests });
    }
}

/// The largest `f64` below 1.
const ONE_MINUS_EPSILON_F64: f64 = 1.0 - f64::EPSILON / 2.0;

/// Samples of a table, as many as there are places for, whose entries alone are looked up one by one.
struct SampleMany<'a> {
    entries: &'a [AliasEntry],
    u: &'a [f64],
    indices: &'a mut [u32],
    rests: &'a mut [f64],
}

impl Work for SampleMany<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        const LANES: usize = 64;
        let (count, last) = (self.entries.len() as f64, (self.entries.len() - 1) as f64);
        // All as doubles, for lanes of one width.
        let (mut fractions, mut kept) = ([0.0; LANES], [0.0; LANES]);
        let (mut places, mut aliases) = ([0.0; LANES], [0.0; LANES]);
        let mut numbers = [0; LANES];
        let outputs = self.indices.chunks_mut(LANES).zip(self.rests.chunks_mut(LANES));
        for (u, (indices, rests)) in self.u.chunks(LANES).zip(outputs) {
            // Loops of a known length become lanes, those behind the last number for nothing.
            fractions[..u.len()].copy_from_slice(u);
            for i in 0..LANES {
                let position = fractions[i] * count;
                places[i] = floor(position).min(last);
                fractions[i] = position - places[i];
                numbers[i] = integer(places[i]);
            }
            for i in 0..u.len() {
                let entry = self.entries[numbers[i] as usize];
                (kept[i], aliases[i]) = (f64::from(entry.probability), f64::from(entry.alias));
            }
            for i in 0..LANES {
                let stays = fractions[i] < kept[i];
                let below = if stays { 0.0 } else { kept[i] };
                let width = if stays { kept[i] } else { 1.0 - kept[i] };
                fractions[i] = ((fractions[i] - below) / width).clamp(0.0, ONE_MINUS_EPSILON_F64);
                numbers[i] = integer(if stays { places[i] } else { aliases[i] });
            }
            indices.copy_from_slice(&numbers[..u.len()]);
            rests.copy_from_slice(&fractions[..u.len()]);
        }
    }
}

/// The number from which on doubles are integers.
const INTEGERS: f64 = (1u64 << 52) as f64;

/// The integer part of a number in [0, 2³²); in lanes as well, which have no conversion of their own.
#[inline(always)]
fn floor(x: f64) -> f64 {
    let nearest = (x + INTEGERS) - INTEGERS;
    if nearest > x { nearest - 1.0 } else { nearest }
}

/// An integer in [0, 2³²), likewise.
#[inline(always)]
fn integer(x: f64) -> u32 {
    (x + INTEGERS).to_bits() as u32
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
mod tests;
