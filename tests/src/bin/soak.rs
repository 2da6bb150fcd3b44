//! Random rays through small trees and scenes of their instances, by all ways to trace in turn, against the scalar loop
//! over all triangles:
//!
//!     cargo run --release -p halfdome-tests --bin soak -- RAYS [THREADS]
//!
//! The rays depend on their index alone. Progress goes to stderr, differences to stdout; the exit code is 5 if there is
//! one, and 1 for arguments that make no sense.
#![forbid(unsafe_code)]

use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

use glam::{DVec3, Vec3};
use halfdome_kernel::traverse::{PacketWidth, Width, reference};
use halfdome_kernel::{Bvh, Hit, Isa, Quality, Ray, Triangle};
use halfdome_tests::check::isas;
use halfdome_tests::random::Pcg;
use halfdome_tests::scenes::{KINDS, scene_rays, with_scene};
use halfdome_tests::ways::{Ways, same};

/// Rays that are traced together.
const BATCH: usize = 128;
/// Batches in a scene.
const BATCHES: usize = 32;
/// Rays in a scene.
const RAYS: u64 = (BATCH * BATCHES) as u64;
/// Every so many batches go through a scene of instances too: its loops are slow.
const SCENE_EVERY: usize = 4;
/// Rays in a scene that get others beside them.
const BUNDLES: usize = 4;
/// Differences that are printed.
const SHOWN: u64 = 20;

fn main() -> ExitCode {
    let arguments: Option<Vec<u64>> = std::env::args().skip(1).map(|argument| argument.parse().ok()).collect();
    let (rays, threads) = match arguments.as_deref() {
        Some([rays]) => (*rays, thread::available_parallelism().map_or(1, |threads| threads.get() as u64)),
        Some([rays, threads @ 1..=1024]) => (*rays, *threads),
        _ => {
            eprintln!("error: give a number of rays, and if you like of threads\n  help: soak 1000000000 2");
            return ExitCode::from(1);
        }
    };
    let scenes = rays.div_ceil(RAYS);
    let isas: Vec<Isa> = isas().collect();
    let start = Instant::now();
    let (next, done, hits, differences) = (AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0), AtomicU64::new(0));
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= scenes {
                        break;
                    }
                    let found = soak(seed, &isas, &differences);
                    hits.fetch_add(found, Ordering::Relaxed);
                    let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                    if done * 100 / scenes != (done - 1) * 100 / scenes {
                        eprintln!(
                            "{:3} %, {} rays, {} hits, {} differences, {:.0} s",
                            done * 100 / scenes,
                            done * RAYS,
                            hits.load(Ordering::Relaxed),
                            differences.load(Ordering::Relaxed),
                            start.elapsed().as_secs_f64()
                        );
                    }
                }
            });
        }
    });
    let differences = differences.into_inner();
    println!("{} rays, {} hits, {differences} differences", scenes * RAYS, hits.into_inner());
    ExitCode::from(if differences == 0 { 0 } else { 5 })
}

/// Traces the rays of one scene; gives how many of them hit something.
fn soak(seed: u64, isas: &[Isa], differences: &AtomicU64) -> u64 {
    let mut random = Pcg::new(seed);
    let triangles = scene(&mut random);
    let quality = Quality::ALL[seed as usize % 3];
    let (bvh, _) = Bvh::build(&triangles, &quality.into()).expect("there are few");
    let mut found = 0;
    for batch in 0..BATCHES {
        let rays: Vec<Ray> = (0..BATCH).map(|_| ray(&mut random, &triangles)).collect();
        let expected: Vec<Option<Hit>> = rays.iter().map(|ray| reference::intersect_all(&triangles, ray)).collect();
        found += expected.iter().flatten().count() as u64;
        // Every method on every instruction set comes round; the scalar reference, which is slow, once.
        let (scalar, others) = isas.split_first().expect("scalar code runs everywhere");
        let isa = if batch == 0 { *scalar } else { others[batch % others.len()] };
        let method = batch / others.len() + seed as usize;
        let mut tell = |what: &str| {
            if differences.fetch_add(1, Ordering::Relaxed) < SHOWN {
                println!("scene {seed}, batch {batch}, {}: {what}", isa.level());
            }
        };
        compare(&bvh.view().with_isa(isa), &rays, &expected, method, &mut tell);
        if batch % SCENE_EVERY == 1 {
            with_scene(&bvh.view(), random.below(KINDS), |scene| {
                let rays = scene_rays(&rays[..BATCH / 2], BUNDLES, [0.3, [0.3, 0.8][random.below(2)]]);
                let loops = scene.with_isa(*scalar);
                let expected: Vec<_> = rays.iter().map(|ray| loops.intersect(ray)).collect();
                compare(&scene.with_isa(isa), &rays, &expected, method, &mut |what| {
                    tell(&format!("in a scene, {what}"))
                });
            });
        }
    }
    found
}

/// Tells of rays for which one of the methods does not give what is expected.
fn compare<T: Ways>(
    target: &T,
    rays: &[T::Ray],
    expected: &[Option<T::Hit>],
    method: usize,
    tell: &mut dyn FnMut(&str),
) {
    let (hits, occluded) = trace(target, rays, method);
    for (i, &expected) in expected.iter().enumerate() {
        if !same(Some(hits[i]), Some(expected.unwrap_or(T::MISS))) || occluded[i] != expected.is_some() {
            tell(&format!("ray {i}: {:?} {:?} instead of {expected:?}", hits[i], occluded[i]));
        }
    }
}

/// The hits of rays, and whether they hit anything, by one of the methods.
fn trace<T: Ways>(target: &T, rays: &[T::Ray], method: usize) -> (Vec<T::Hit>, Vec<bool>) {
    let (mut hits, mut occluded) = (vec![T::UNTOUCHED; rays.len()], vec![false; rays.len()]);
    match method % 7 {
        0 => target.many(rays, &mut hits, &mut occluded),
        1 => return packets::<4, _>(target, rays),
        2 => return packets::<8, _>(target, rays),
        3 => return packets::<16, _>(target, rays),
        4 => return packets::<32, _>(target, rays),
        5 => target.gather(rays, &mut hits, &mut occluded),
        _ => {
            let one = |ray| (target.one(ray).unwrap_or(T::MISS), target.one_occluded(ray));
            return rays.iter().map(one).unzip();
        }
    }
    (hits, occluded)
}

fn packets<const N: usize, T: Ways>(target: &T, rays: &[T::Ray]) -> (Vec<T::Hit>, Vec<bool>)
where
    Width<N>: PacketWidth<N>,
{
    let mut all = (Vec::new(), Vec::new());
    for rays in rays.chunks(N) {
        let mut hits = [T::UNTOUCHED; N];
        let occluded = target.packet(rays, u32::MAX, &mut hits);
        all.0.extend(&hits[..rays.len()]);
        all.1.extend((0..rays.len()).map(|lane| occluded >> lane & 1 == 1));
    }
    all
}

/// A few triangles: anywhere, thin, on a grid, or over shared corners, of all sizes and at all distances.
fn scene(random: &mut Pcg) -> Vec<Triangle> {
    let count = 1 + random.below(24);
    let scale = [1.0, 1.0, 1e-6, 1e4, 1e9][random.below(5)];
    let shift = [0.0, 0.0, 1.0, 1e3, 1e5][random.below(5)] * scale * random.in_cube();
    let kind = random.below(4);
    let pool: Vec<DVec3> = (0..4 + random.below(8)).map(|_| random.in_cube()).collect();
    let triangle = |random: &mut Pcg| match kind {
        0 => {
            let center = random.in_cube();
            [(); 3].map(|()| center + 0.5 * random.in_cube())
        }
        1 => {
            let (a, b) = (random.in_cube(), random.in_cube());
            [a, b, a.lerp(b, random.unit()) + 1e-5 * random.in_cube()]
        }
        2 => [(); 3].map(|()| (random.in_cube() * 2.5).round()),
        _ => [(); 3].map(|()| pool[random.below(pool.len())]),
    };
    (0..count).map(|_| triangle(random).map(|p| (p * scale + shift).as_vec3())).filter(has_corners).collect()
}

/// Others are left out of trees, but not of the loop; no ray hits them either way.
fn has_corners([a, b, c]: &Triangle) -> bool {
    a != b && b != c && c != a
}

/// A ray to a corner, an edge, a face or past it, from afar, from nearby or from another triangle's corner, aslant,
/// along an axis or a diagonal.
fn ray(random: &mut Pcg, triangles: &[Triangle]) -> Ray {
    let Some(triangle) = triangles.get(random.below(triangles.len().max(1))) else {
        return Ray::new(random.in_cube().as_vec3(), random.on_sphere().as_vec3());
    };
    let [a, b, c] = triangle.map(Vec3::as_dvec3);
    let size = (b - a).length().max((c - a).length());
    let target = match random.below(5) {
        0 => a,
        1 => b.lerp(c, random.unit()),
        2 => 0.5 * (a + b),
        _ => {
            let (u, v) = (random.unit(), random.unit());
            a + u * (b - a) + v * (c - a)
        }
    };
    let steps = [-1.0, 0.0, 1.0, -0.0];
    let direction = match random.below(4) {
        0 => DVec3::from([0; 3].map(|_| steps[random.below(4)])),
        1 => triangles[random.below(triangles.len())][random.below(3)].as_dvec3() - target,
        _ => random.in_cube() * size,
    };
    let origin = (target - direction * [1.0, 1.0, 10.0, 1e4][random.below(4)]).as_vec3();
    let direction = if random.below(2) == 0 { direction.as_vec3() } else { target.as_vec3() - origin };
    let (t_min, t_max) = match random.below(8) {
        0 => (0.0, 1.0),
        1 => (f32::NEG_INFINITY, f32::INFINITY),
        2 => (random.unit() as f32, 1.0 + random.unit() as f32),
        _ => (0.0, f32::INFINITY),
    };
    Ray { origin, t_min, direction: direction * [1.0, 1e-3, 1e6][random.below(3)], t_max }
}
