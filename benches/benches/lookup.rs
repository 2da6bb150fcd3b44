//! Times a lookup in irradiance caches of random records on the walls of a room, on one thread: at random points, and
//! at points side by side, as those of a picture are.
//!
//! `cargo bench -p halfdome-benches --bench lookup [-- --rounds N]`. With `--test`, or without the `--bench` that
//! `cargo bench` passes, everything runs once, untimed.

use std::hint::black_box;

use clap::Parser;
use glam::{Vec3, Vec3Swizzles as _};
use halfdome::cache::{Cache, Record, SECTORS};
use halfdome::settings::{CachedOptions, Metric};
use halfdome_benches::rounds::{Rounds, nanoseconds};
use halfdome_kernel::sampling::Stream;

/// Times lookups in irradiance caches.
#[derive(Parser)]
struct Options {
    #[command(flatten)]
    rounds: Rounds,
}

/// Lookups in a round.
const LOOKUPS: u32 = 1 << 16;

fn main() {
    let rounds = Options::parse().rounds.timed();
    println!("{:>10}{:>14}{:>12}{:>14}", "records", "metric", "random ns", "in order ns");
    for count in [1000, 10_000, 100_000] {
        for metric in Metric::ALL {
            let options = CachedOptions { metric, ..CachedOptions::default() };
            let cache = Cache::of(options, 0, records(count));
            let random = time(rounds, || sum(&cache, |i| wall(Stream::new(2, i, 0).uniform4(0))));
            let in_order = time(rounds, || {
                sum(&cache, |i| {
                    let [x, y] = [i % 256, i / 256].map(|pixel| (pixel as f32 + 0.5) / 1024.0 + 0.3);
                    wall([0.0, x, y, 0.0])
                })
            });
            println!("{count:>10}{:>14}{random:>12}{in_order:>14}", metric.name());
        }
    }
}

/// A point of one of the six walls of a room with sides of 1, and the normal there.
fn wall([which, x, y, _]: [f32; 4]) -> (Vec3, Vec3) {
    let wall = (which * 6.0) as u32;
    let (side, inwards) = if wall < 3 { (0.0, Vec3::X) } else { (1.0, Vec3::NEG_X) };
    let turn = |v: Vec3| [v, v.yzx(), v.zxy()][wall as usize % 3];
    (turn(Vec3::new(side, x, y)), turn(inwards))
}

/// Records that reach about as far as the next but one.
fn records(count: u32) -> Vec<Record> {
    let reach = (6.0 / count as f32).sqrt();
    let record = |i: u32| {
        let [which, x, y, r] = Stream::new(1, i, 0).uniform4(0);
        let (position, normal) = wall([which, x, y, r]);
        Record {
            key: i.into(),
            position,
            normal,
            irradiance: Vec3::ONE,
            standard_error: 0.0,
            rotational: [Vec3::ZERO; 3],
            translational: [Vec3::ZERO; 3],
            mean_distance: reach,
            min_distance: 0.5 * reach,
            radii: [reach * (0.5 + 0.5 * r), reach],
            axis: normal.any_orthonormal_vector(),
            occluders: [f32::INFINITY; SECTORS],
            clearance: f32::INFINITY,
        }
    };
    (0..count).map(record).collect()
}

/// The sum of all lookups.
fn sum(cache: &Cache, point: impl Fn(u32) -> (Vec3, Vec3)) -> Vec3 {
    let lookup = |i| {
        let (position, normal) = point(i);
        cache.interpolate(position, normal).map_or(Vec3::ZERO, |found| found.irradiance)
    };
    (0..LOOKUPS).map(lookup).sum()
}

/// The median time a lookup, in nanoseconds; a dash without rounds. All of it is the same answer.
fn time(rounds: u16, lookups: impl Fn() -> Vec3) -> String {
    let found = lookups();
    assert!(found.x > 0.9 * LOOKUPS as f32 && found.x <= 1.001 * LOOKUPS as f32, "{found}");
    nanoseconds(rounds, LOOKUPS as usize, || assert_eq!(black_box(lookups()), found))
}
