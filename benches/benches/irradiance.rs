//! Times the sums of a gather with gradients, and its Hessian, in nanoseconds a ray, on one thread with each
//! instruction set; for comparison the tracing of such rays in the Cornell box, where it is cheapest.
//!
//! `cargo bench -p halfdome-benches --bench irradiance [-- --rounds N]`. With `--test`, or without the `--bench` that
//! `cargo bench` passes, everything runs once, untimed.

use std::hint::black_box;

use clap::Parser;
use glam::{Vec2, Vec3};
use halfdome_benches::rays::{RayCounts, generate};
use halfdome_benches::rounds::{Rounds, nanoseconds};
use halfdome_benches::scenes;
use halfdome_kernel::irradiance::{Hemicube, Layout, Stratified};
use halfdome_kernel::sampling::{Strata, Stream};
use halfdome_kernel::{BuildOptions, Bvh, Hit, Isa, Level};

/// Times the accumulation of gathers.
#[derive(Parser)]
struct Options {
    #[command(flatten)]
    rounds: Rounds,
}

/// Rays in a round.
const RAYS: usize = 1 << 20;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rounds = Options::parse().rounds.timed();
    println!("{:14}{:>8}{:>10}{:>14}{:>14}{:>14}", "ns/ray", "rays", "level", "gradients", "Hessian", "tracing");
    let scene = scenes::by_name("cornell")?;
    let (tree, _) = Bvh::build(&scene.triangles, &BuildOptions::default())?;
    let counts = if rounds == 0 { RayCounts::TINY } else { RayCounts::QUICK };
    let [_, _, gathers, _] = generate(&scene, &tree.view(), counts);
    let mut hits = vec![Hit::MISS; gathers.rays.len()];
    for isa in Level::ALL.into_iter().skip(1).filter_map(Isa::new) {
        let view = tree.view().with_isa(isa);
        let tracing = nanoseconds(rounds, gathers.rays.len(), || view.intersect_many(&gathers.rays, &mut hits));
        println!("{:14}{:8}{:>10}{:>42}", "Cornell box", 256, isa.level().name(), tracing);
        for (rings, sectors) in [(10, 31), (36, 114)] {
            let strata = Strata::new(rings, sectors)?;
            let layout = Stratified::new(strata, vec![0.0; Stratified::table_len(&strata)])?.with_isa(isa);
            bench(&format!("{rings} x {sectors}"), isa, &layout, rounds)?;
        }
        let layout = Hemicube::new(32, vec![0.0; Hemicube::table_len(32)])?.with_isa(isa);
        bench("hemicube 32", isa, &layout, rounds)?;
    }
    Ok(())
}

/// Prints a line for a layout.
fn bench(name: &str, isa: Isa, layout: &dyn Layout, rounds: u16) -> Result<(), Box<dyn std::error::Error>> {
    let cells = layout.cells();
    let random = |cell: usize, set: u32| Stream::new(1, cell as u32, set).uniform2(0);
    let mut directions = vec![Vec3::ZERO; cells];
    layout.directions(&mut |cell| random(cell, 0), &mut directions)?;
    let radiance: Vec<Vec3> = (0..cells).map(|cell| Vec2::extend(random(cell, 1), 0.5)).collect();
    let distance: Vec<f32> = (0..cells).map(|cell| 0.1 + random(cell, 2).x).collect();
    layout.accumulate(&radiance, &distance)?;
    layout.hessian(&directions, &radiance, &distance)?;
    let gradients = time(rounds, cells, || black_box(layout.accumulate(black_box(&radiance), &distance)).is_ok());
    let hessian =
        time(rounds, cells, || black_box(layout.hessian(black_box(&directions), &radiance, &distance)).is_ok());
    println!("{name:14}{cells:8}{:>10}{gradients:>14}{hessian:>14}", isa.level().name());
    Ok(())
}

/// The median time a ray, in nanoseconds; a dash without rounds.
fn time(rounds: u16, cells: usize, gather: impl Fn() -> bool) -> String {
    let repeats = RAYS.div_ceil(cells);
    nanoseconds(rounds, repeats * cells, || assert!((0..repeats).all(|_| gather())))
}
