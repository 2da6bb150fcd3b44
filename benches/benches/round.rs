//! Times points and curves: trees of spheres in blocks of eight beside the same spheres one by one as a custom shape,
//! discs, and linear and cubic hairs.
//!
//! `cargo bench -p halfdome-benches --bench round -- [--rounds N]`. With `--test`, or without the `--bench` that
//! `cargo bench` passes, everything runs once, untimed.

use clap::Parser;
use glam::{Vec3, vec3};
use halfdome_benches::rounds::{Rounds, nanoseconds};
use halfdome_kernel::bvh::RoundBuild;
use halfdome_kernel::sampling::Stream;
use halfdome_kernel::scene::{SceneHit, SceneRay, Spheres};
use halfdome_kernel::{BuildOptions, CubicCurve, Disc, Error, Item, LinearCurve, Ray, RoundBvh, Scene, Sphere};

/// Times points and curves.
#[derive(Parser)]
struct Options {
    #[command(flatten)]
    rounds: Rounds,
}

/// A random point of the cube from -1 to 1.
fn point(number: u32, set: u32) -> Vec3 {
    let [x, y, z, _] = Stream::new(7, number, 0).bits4(set).map(|bits| (bits >> 8) as f32 / (1 << 24) as f32);
    vec3(x, y, z) * 2.0 - 1.0
}

fn main() -> Result<(), Error> {
    let rounds = Options::parse().rounds.timed();
    let (count, rays) = if rounds == 0 { (500, 200) } else { (100_000, 20_000) };
    let radius = 0.5 / (count as f32).cbrt();
    let spheres: Vec<Sphere> = (0..count).map(|i| Sphere::new(point(i, 0), radius)).collect();
    let discs: Vec<Disc> = (0..count).map(|i| Disc { center: point(i, 0), radius, normal: point(i, 1) }).collect();
    let strand = |i: u32, k: f32| {
        let (root, along, bend) = (point(i, 0), point(i, 1), point(i, 2));
        Sphere::new(root + (along * k + bend * (0.2 * k * k)) * (2.0 * radius), radius * 0.05 * (1.0 - 0.3 * k))
    };
    let cubic = |i: u32| CubicCurve { controls: [0.0, 1.0, 2.0, 3.0].map(|k| strand(i, k)) };
    let cubics: Vec<CubicCurve> = (0..count).map(cubic).collect();
    let linear = |i: u32| LinearCurve { ends: [0.0, 3.0].map(|k| strand(i, k)) };
    let linears: Vec<LinearCurve> = (0..count).map(linear).collect();
    let ray = |i: u32| Ray::new(point(i, 3) * 3.0, point(i, 4) - point(i, 3) * 3.0).into();
    let rays: Vec<SceneRay> = (0..rays).map(ray).collect();

    println!(
        "{count} of each, {} rays; ns a ray: the nearest hit, any hit; bytes each, without the scene's tree",
        rays.len()
    );
    let shape = Spheres(&spheres);
    let bytes = size_of::<Sphere>();
    let one_by_one = time("spheres one by one", Item::new(&shape), bytes as f64, &rays, rounds)?;
    assert_eq!(trace("spheres", &spheres, &rays, rounds)?, one_by_one, "as many hits");
    trace("discs", &discs, &rays, rounds)?;
    trace("linear curves", &linears, &rays, rounds)?;
    trace("cubic curves", &cubics, &rays, rounds)?;
    Ok(())
}

/// Times rays through a tree of primitives, and prints a line; gives how many hit.
fn trace<P: RoundBuild>(name: &str, primitives: &[P], rays: &[SceneRay], rounds: u16) -> Result<usize, Error> {
    let (tree, _) = RoundBvh::build(primitives, &BuildOptions::default())?;
    let bytes = tree.memory_bytes() as f64 / primitives.len() as f64;
    time(name, Item::new(tree.view()), bytes, rays, rounds)
}

fn time(name: &str, item: Item, bytes: f64, rays: &[SceneRay], rounds: u16) -> Result<usize, Error> {
    let (scene, _) = Scene::build(vec![item], &BuildOptions::default())?;
    let (mut hits, mut occluded) = (vec![SceneHit::MISS; rays.len()], vec![false; rays.len()]);
    scene.view().intersect_many(rays, &mut hits);
    scene.view().occluded_many(rays, &mut occluded);
    let count = hits.iter().filter(|hit| hit.is_hit()).count();
    assert_eq!(count, occluded.iter().filter(|occluded| **occluded).count());
    let nearest = nanoseconds(rounds, rays.len(), || scene.view().intersect_many(rays, &mut hits));
    let any = nanoseconds(rounds, rays.len(), || scene.view().occluded_many(rays, &mut occluded));
    println!("{name:20}{nearest:>10}{any:>10}{bytes:10.0}  {count} hits");
    Ok(count)
}
