//! Times scenes that change: all of 10,000 instances moved and committed, and frames of an engine, in which 100 objects
//! move and 10,000 rays are traced, commit included.
//!
//! `cargo bench -p halfdome-benches --bench scenes -- [--rounds N]`. With `--test`, or without the `--bench` that
//! `cargo bench` passes, everything runs once, untimed.

use clap::Parser;
use halfdome_benches::instances;
use halfdome_benches::rays::RayCounts;
use halfdome_benches::rounds::{Rounds, nanoseconds};
use halfdome_benches::scenes;
use halfdome_kernel::scene::{Handle, SceneHit, SceneRay};
use halfdome_kernel::{BuildOptions, Bvh, Error, Quality, Scene};

/// Times scenes that change.
#[derive(Parser)]
struct Options {
    #[command(flatten)]
    rounds: Rounds,
}

/// Rays of a frame.
const RAYS: usize = 10_000;

fn main() -> Result<(), Error> {
    let rounds = Options::parse().rounds.timed();
    let triangles = scenes::blob(if rounds == 0 { 10 } else { 112 });
    let (mesh, _) = Bvh::build(&triangles, &BuildOptions::default())?;
    println!("instances of {} triangles", triangles.len());
    for quality in Quality::ALL {
        let count = if rounds == 0 { 100 } else { 10_000 };
        let places: Vec<_> = (0..8).map(|frame| instances::places(count, frame)).collect();
        let mut scene = instances::scene(&mesh, &places[0], quality)?;
        let handles: Vec<_> = scene.handles().collect();
        let (mut frame, mut rebuilt) = (0, 0);
        let mut moved = || {
            frame += 1;
            let places = &places[frame % places.len()];
            rebuilt += u32::from(advance(&mut scene, &handles, places).expect("all transforms are good"));
        };
        if rounds == 0 {
            moved();
        }
        let time = nanoseconds(rounds, count as usize, moved);
        println!("{count} moved and committed, {quality} tree: {time} ns each, {rebuilt} times built anew");
    }
    let (count, rays) = (100, RAYS);
    let places: Vec<_> = (0..8).map(|frame| instances::places(count, frame)).collect();
    let mut scene = instances::scene(&mesh, &places[0], Quality::Fast)?;
    let handles: Vec<_> = scene.handles().collect();
    let sets = instances::rays(&scene.view(), &triangles, RayCounts { side: 128, gathers: 4 });
    for set in sets {
        let rays: Vec<SceneRay> = set.rays.iter().cycle().take(rays).map(|&ray| ray.into()).collect();
        let (mut hits, mut occluded) = (vec![SceneHit::MISS; rays.len()], vec![false; rays.len()]);
        let mut engine = || {
            for places in &places {
                advance(&mut scene, &handles, places).expect("all transforms are good");
                if set.kind.any_hit() {
                    scene.view().occluded_many(&rays, &mut occluded);
                } else {
                    scene.view().intersect_many(&rays, &mut hits);
                }
            }
        };
        if rounds == 0 {
            engine();
        }
        let time = nanoseconds(rounds, places.len(), engine);
        let frames = time.parse().map_or_else(|_| "-".into(), |time: f64| format!("{:.0}", 1e9 / time));
        println!("{count} moved, {} {} rays: {frames} frames a second", rays.len(), set.kind.name());
    }
    Ok(())
}

/// Moves all items and commits; returns whether the scene's tree was rebuilt.
fn advance(scene: &mut Scene, handles: &[Handle], places: &[glam::Affine3A]) -> Result<bool, Error> {
    for (&handle, place) in handles.iter().zip(places) {
        scene.set_transform(handle, place)?;
    }
    Ok(scene.commit()?.is_rebuilt)
}
