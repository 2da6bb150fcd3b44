//! Irradiance to an accuracy, by whatever takes fewer rays: a cache or paths at each sensor.
//!
//! A few paths at all sensors tell the mean, and how many would reach the accuracy: in proportion to the mean of their
//! variances, over the square of the allowed error. Whether a cache takes fewer rays is not known beforehand, as that
//! depends on how far its records reach. So it is tried, and abandoned once it has traced as many rays as the paths would:
//! both take at most twice as many as the better one.
//!
//! With a cache, direct light is sampled at each sensor in rounds until its error is small enough.

use super::{Component, Effort, Irradiance, Part, Request, Sensor, look_up, own};
use crate::cache::Cache;
use crate::integrator::{FillTarget, HeldOut, MANY_SITES, MeanLight, SAMPLED_SHARE, fill_for_surfaces, max_depth};
use crate::settings::{CachedOptions, Shard};
use crate::watch::{RayLimit, Watch};
use crate::world::{Surface, World};

/// The first paths at each sensor, ...
const FIRST_PATHS: u32 = 64;
/// ... so many times as many where the accuracy takes far more, ...
const MORE_PATHS: u32 = 4;
/// ... and the most.
const MOST_PATHS: u32 = 1 << 16;
/// A cache for [`MANY_SITES`] takes at least about so many rays: 9 to 12 million in four rooms (docs/experiments/cache.md).
const LEAST_OF_A_CACHE: u64 = 10_000_000;
/// More paths than their variance asks for: a few have most of it, and the first may have missed these.
const SPARE: f64 = 1.2;

/// Irradiance at those of the sensors that are in a shard. What is chosen depends on all of them, and not on the shard.
pub(super) fn shard(
    world: &World,
    (sensors, shard): (&[Sensor], Shard),
    cache: Cache,
    request: &Request,
    watch: &dyn Watch,
) -> Irradiance {
    choose(world, (sensors, shard), cache, request, LEAST_OF_A_CACHE, watch)
}

/// The same, where a cache is tried if paths take more rays than `least`.
fn choose(
    world: &World,
    (sensors, shard): (&[Sensor], Shard),
    cache: Cache,
    request: &Request,
    least: u64,
    watch: &dyn Watch,
) -> Irradiance {
    let own = own(sensors, shard);
    let stopped = || Irradiance { finished: false, ..Irradiance::black(sensors) };
    if !cache.records().is_empty() {
        let limit = RayLimit::new(watch, u64::MAX);
        return by_cache(world, (sensors, &own), cache, request, &limit).unwrap_or_else(stopped);
    }
    let Some(paths) = Paths::new(world, sensors, cache.options(), request, watch) else { return stopped() };
    let (mut traced, most) = (paths.first.rays, paths.rays);
    // Records of fewer sensors would be gathered by paths too.
    if sensors.len() >= MANY_SITES && most > least {
        let limit = RayLimit::new(watch, most);
        if let Some(found) = by_cache(world, (sensors, &own), cache, request, &limit) {
            return Irradiance { rays: traced + found.rays, ..found };
        }
        // Threads may have traced a few more before they stopped.
        traced += most;
    }
    paths.finish(world, (sensors, &own), request, traced, watch)
}

/// Irradiance at some of the sensors with the indirect part from a cache that is filled for all; `None` if that is stopped.
fn by_cache(
    world: &World,
    (sensors, own): (&[Sensor], &[usize]),
    cache: Cache,
    request: &Request,
    limit: &RayLimit,
) -> Option<Irradiance> {
    let surfaces: Vec<Surface> = sensors.iter().map(|sensor| sensor.surface(world)).collect();
    let light = if request.part == Part::Total { MeanLight::Total } else { MeanLight::Indirect };
    let points = (surfaces.len(), |i: usize| surfaces[i]);
    let held_out = HeldOut::new(world, cache.options(), points, light, request.seed, limit)?;
    let aim = FillTarget::Accuracy(&held_out);
    let (frozen, filled) = fill_for_surfaces(world, request.seed, cache, &surfaces, aim, limit);
    if limit.stop() {
        return None;
    }
    let effort = Effort::Noise(SAMPLED_SHARE.sqrt() * held_out.allowed_error());
    // Not limited: how many rays follow depends on the shard.
    let (mut found, variance) = look_up(world, (sensors, own), &frozen, (request, effort), limit.watch());
    found.rays += held_out.traced + filled;
    found.error = frozen.cache.estimate().map(|estimate| estimate.with(variance));
    found.set_cache(frozen);
    Some(found)
}

/// Paths at each sensor.
struct Paths {
    component: Component,
    /// Some paths at all sensors: ...
    first: Irradiance,
    /// ... as many at each, ...
    done: u32,
    /// ... with this root mean square error, in W/m².
    error: f64,
    /// As many at each as the accuracy takes, ...
    count: u32,
    /// ... which trace about so many rays at all sensors.
    rays: u64,
    /// The mean over all sensors and channels, in W/m².
    light: f64,
}

impl Paths {
    /// The first of them; `None` if the watcher stops.
    fn new(
        world: &World,
        sensors: &[Sensor],
        options: &CachedOptions,
        request: &Request,
        watch: &dyn Watch,
    ) -> Option<Self> {
        let component = match request.part {
            Part::Total => Component::All(max_depth(options)),
            Part::Indirect => Component::Indirect(max_depth(options)),
        };
        let accuracy = f64::from(options.accuracy.unwrap_or(CachedOptions::MAX_ACCURACY));
        let all: Vec<usize> = (0..sensors.len()).collect();
        let (mut traced, mut done) = (0, FIRST_PATHS);
        loop {
            let mut first = Irradiance::black(sensors);
            let number = sensors.len().max(1) as f64;
            let variance =
                first.add(world, sensors, &all, (component, Effort::Halves(done)), request.seed, watch) / number;
            let light = first.values.iter().map(|value| f64::from(value.element_sum())).sum::<f64>() / (3.0 * number);
            let needed = SPARE * f64::from(done) * variance / (accuracy * light).powi(2);
            // Where there is no light both are 0.
            let count = if needed.is_nan() { done } else { needed.ceil() as u32 }.clamp(done, MOST_PATHS);
            if !first.finished {
                return None;
            }
            let rays = (first.rays as f64 * f64::from(count) / f64::from(done)) as u64;
            first.rays += traced;
            if count < MORE_PATHS * MORE_PATHS * done || done > FIRST_PATHS {
                return Some(Self { component, first, done, error: variance.sqrt(), count, rays, light });
            }
            (traced, done) = (first.rays, MORE_PATHS * done);
        }
    }

    /// The irradiance of as many as it takes at some of the sensors, after `traced` rays.
    fn finish(
        self,
        world: &World,
        (sensors, own): (&[Sensor], &[usize]),
        request: &Request,
        traced: u64,
        watch: &dyn Watch,
    ) -> Irradiance {
        let Self { component, first, done, count, light, mut error, .. } = self;
        let mut found = first;
        if count > done {
            found = Irradiance::black(sensors);
            let effort = Effort::Halves(count);
            let variance = found.add(world, sensors, own, (component, effort), request.seed, watch);
            error = (variance / own.len().max(1) as f64).sqrt();
            found.rays += traced;
        }
        found.error = Some(if light > 0.0 { (error / light) as f32 } else { 0.0 });
        found
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec3, vec3};
    use halfdome_kernel::sampling::Stream;
    use halfdome_kernel::sampling::warp::{UniformSphere, Warp};

    use super::super::shard_by_cache;
    use super::*;
    use crate::scene::cornell_box;
    use crate::watch::NeverStops;

    /// Sensors in the air of the Cornell box, in all directions: each needs a record of its own.
    fn in_the_air() -> Vec<Sensor> {
        let sensor = |i| {
            let random = Stream::new(1, i, 0);
            let (xz, y) = (random.uniform2(0), random.uniform2(1).x);
            let normal = UniformSphere.map(random.uniform2(2));
            Sensor { position: vec3(0.02 + 0.51 * xz.x, 0.4 + 0.13 * y, 0.02 + 0.51 * xz.y), normal }
        };
        (0..1200).map(sensor).collect()
    }

    fn cache(world: &World, accuracy: f32) -> Cache {
        let options = CachedOptions { accuracy: Some(accuracy), ..CachedOptions::default() };
        Cache::new(options, world.surroundings_hash())
    }

    const REQUEST: Request = Request { spp: 1, seed: 2, part: Part::Total };

    /// The values are those of paths, and all numbers are the same for any number of threads.
    #[test]
    fn a_cache_that_takes_more_rays_than_paths_is_abandoned() {
        let world = World::new(cornell_box()).unwrap();
        let sensors = in_the_air();
        let with = |least, threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| choose(&world, (&sensors, Shard::ALL), cache(&world, 0.03), &REQUEST, least, &NeverStops))
        };
        let [paths, tried, on_three] = [(u64::MAX, 2), (0, 2), (0, 3)].map(|(least, threads)| with(least, threads));
        assert!(paths.cache.is_none() && tried.cache.is_none());
        assert_eq!(paths.values, tried.values);
        assert_eq!((&tried.values, tried.error, tried.rays), (&on_three.values, on_three.error, on_three.rays));
        let ratio = tried.rays as f64 / paths.rays as f64;
        assert!((1.5..2.0).contains(&ratio), "{ratio}");
        assert!((0.01..0.036).contains(&tried.error.unwrap()), "{:?}", tried.error);
    }

    /// Whether a cache is used or not.
    #[test]
    fn shards_choose_as_the_whole_does() {
        let world = World::new(cornell_box()).unwrap();
        let sensors = in_the_air();
        for (accuracy, has_cache) in [(0.03, false), (0.006, true)] {
            let of = |shard| shard_by_cache(&world, &sensors, shard, cache(&world, accuracy), &REQUEST, &NeverStops);
            let whole = of(Shard::ALL);
            assert_eq!(whole.cache.is_some(), has_cache, "{accuracy}");
            let shard = Shard::new(1, 7).unwrap();
            let part = of(shard);
            let own = |values: &[Vec3]| values.iter().skip(1).step_by(7).copied().collect::<Vec<_>>();
            assert_eq!(own(&part.values), own(&whole.values), "{accuracy}");
            assert!(part.rays < whole.rays, "{} of {}", part.rays, whole.rays);
        }
    }

    /// A cache with records is read, however few the sensors are.
    #[test]
    fn a_given_cache_is_used() {
        let world = World::new(cornell_box()).unwrap();
        let sensors = in_the_air();
        let filled = choose(&world, (&sensors, Shard::ALL), cache(&world, 0.006), &REQUEST, 0, &NeverStops).cache;
        let (filled, _) = filled.unwrap();
        let records = filled.records().len();
        let again = shard_by_cache(&world, &sensors[..20], Shard::ALL, filled, &REQUEST, &NeverStops);
        assert_eq!(again.cache.unwrap().0.records().len(), records);
    }

    #[test]
    fn darkness_has_no_error() {
        let mut scene = cornell_box();
        scene.materials.iter_mut().for_each(|material| material.emission = Vec3::ZERO);
        let world = World::new(scene).unwrap();
        let found = choose(&world, (&in_the_air(), Shard::ALL), cache(&world, 0.01), &REQUEST, 0, &NeverStops);
        assert!(found.finished && found.values.iter().all(|value| *value == Vec3::ZERO));
        assert_eq!(found.error, Some(0.0));
    }
}
