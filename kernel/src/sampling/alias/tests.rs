//! Tables hold the weights that they were built from, and are drawn from in proportion.

use super::*;
use crate::checksums::Checksum;
use crate::sampling::tests::statistics::chi_squared;
use crate::sampling::{ONE_MINUS_EPSILON, Stream, unit_double};
use crate::simd::isas;

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

#[test]
fn batches_equal_samples_bit_for_bit() {
    for weights in cases() {
        let table = table(&weights);
        let numbers = |i| unit_double(Stream::new(9, i, 0).uniform2(0));
        // More than a chunk, and the ends of the range.
        let u: Vec<f64> = (0..150).map(numbers).chain([0.0, 1.0 - f64::EPSILON / 2.0]).collect();
        for isa in isas() {
            let (mut indices, mut rests) = (vec![7; u.len() + 1], vec![7.0; u.len() + 1]);
            table.sample_many(isa, &u, &mut indices, &mut rests);
            for ((&u, &index), &found) in u.iter().zip(&indices).zip(&rests) {
                let (expected, _, rest) = table.sample(u);
                assert_eq!((index as usize, found), (expected, rest), "{u} of {} on {isa:?}", weights.len());
            }
            assert_eq!((indices[u.len()], rests[u.len()]), (7, 7.0), "there is no number for it");
        }
    }
}
