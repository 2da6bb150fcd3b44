//! Caches in files: their bits, damage, and merging.

use super::*;

#[test]
fn files_keep_every_bit() {
    let cache = cache(0..300);
    assert!(cache.records.iter().zip(&cache.original_radii).any(|(record, radii)| record.radii != *radii));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cache");
    cache.write(&path).unwrap();
    let read = Cache::read(&path, Some((&options(), SCENE))).unwrap();
    assert_eq!(read.records(), cache.records());
    assert_eq!(read.encode(), cache.encode());
    let empty = Cache::new(options(), 7);
    assert!(Cache::decode(&empty.encode()).unwrap().records().is_empty());
}

#[test]
fn damaged_and_foreign_files_are_refused() {
    let bytes = cache(0..5).encode();
    let problem = |bytes: &[u8]| Cache::decode(bytes).unwrap_err().to_string();
    for length in 0..bytes.len() {
        let text = problem(&bytes[..length]);
        assert!(text.contains(if length < 8 { "is no irradiance cache" } else { "is cut off" }), "{length}: {text}");
    }
    for i in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[i] ^= 0x10;
        assert!(Cache::decode(&damaged).is_err(), "a change of byte {i} was not noticed");
    }
    assert!(problem(&[&bytes[..], b"x"].concat()).contains("has bytes after its end"));
    let with = |range: std::ops::Range<usize>, new: &[u8]| {
        let mut changed = bytes.clone();
        changed[range].copy_from_slice(new);
        problem(&changed)
    };
    assert!(with(8..12, &1u32.to_le_bytes()).contains("has version 1 of the format; this program reads version 5"));
    assert!(with(12..16, &0x0102_0304u32.to_be_bytes()).contains("order of bytes of another machine"));
    assert!(with(100..101, &[bytes[100] ^ 1]).contains("its checksum is wrong"));
    // With a right checksum, numbers that are none are still found.
    let mut nan = cache(0..5);
    nan.records[3].irradiance.x = f32::NAN;
    assert!(problem(&nan.encode()).contains("is not finite"));
    // Nor what lengths and units cannot be: the weights of such a record would be none.
    let spoil: [fn(&mut Record); 7] = [
        |record| record.mean_distance = f32::INFINITY,
        |record| record.mean_distance = -1.0,
        |record| record.min_distance = f32::NAN,
        |record| record.normal = Vec3::ZERO,
        |record| record.axis = 2.0 * Vec3::X,
        |record| record.occluders[3] = f32::NAN,
        |record| record.occluders[3] = -0.5,
    ];
    for (number, spoil) in spoil.into_iter().enumerate() {
        let mut spoilt = cache(0..5);
        spoil(&mut spoilt.records[3]);
        assert!(problem(&spoilt.encode()).contains("out of range"), "{number}");
    }
}

#[test]
fn caches_of_something_else_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cache");
    cache(0..5).write(&path).unwrap();
    let problem = |options, scene| Cache::read(&path, Some((&options, scene))).unwrap_err().to_string();
    let other = problem(options(), 1);
    assert!(other.contains("a.cache: the cache is of another scene (hash 123456789abcdef0"), "{other}");
    let error = problem(CachedOptions { error: 0.5, ..options() }, SCENE);
    assert!(error.contains(&format!("was built with --cache-error {}, not 0.5", options().error)), "{error}");
    let bounces = problem(CachedOptions { bounces: Some(2), ..options() }, SCENE);
    assert!(bounces.contains("was built with --cache-bounces unlimited, not 2"), "{bounces}");
    assert!(Cache::read(&path, None).is_ok());
    assert!(Cache::read(&folder.path().join("b.cache"), None).unwrap_err().to_string().contains("cannot be read"));
}

#[test]
fn merging_does_not_depend_on_the_order_and_keeps_common_records_once() {
    let parts = [cache(0..60), cache(40..100), cache(90..120)];
    let merge = |order: [usize; 3]| {
        let [a, b, c] = order.map(|i| parts[i].clone());
        a.merge(b).unwrap().merge(c).unwrap()
    };
    let all = merge([0, 1, 2]);
    assert_eq!(all.records(), cache(0..120).records());
    for order in [[2, 1, 0], [1, 2, 0], [0, 2, 1]] {
        assert_eq!(merge(order).encode(), all.encode());
    }
    let foreign = Cache::new(options(), 1);
    assert!(all.merge(foreign).unwrap_err().to_string().contains("another scene"));
}

#[test]
fn an_accuracy_that_was_not_reached_is_told_with_both_numbers() {
    let told = missed_accuracy(0.03, 0.0412, MORE_RECORDS).unwrap();
    assert!(told.contains("4.12% of the mean light") && told.contains("3% was requested"), "{told}");
    assert!(missed_accuracy(0.001, 0.0011, MORE_PATHS).unwrap().contains("0.1% was requested"));
    for reached in [0.0, 0.0299, 0.03, 0.030_04] {
        assert_eq!(missed_accuracy(0.03, reached, MORE_PATHS), None, "{reached}");
    }
}
