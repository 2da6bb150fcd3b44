//! Counts the instructions of the kernel's hot paths in Valgrind, and fails where they exceed a limit: a slowdown that no
//! busy machine hides. Run by `benches/instructions.sh`, which installs what it needs.
//!
//! Valgrind knows AVX2 and no AVX-512. Compilers differ by less than the 5% that are allowed. Who makes a path quicker lowers
//! its count; the rays are a thousand.

#![allow(missing_docs, unreachable_pub, reason = "the macros of gungraun make items without documentation")]

use std::hint::black_box;

use glam::Vec3;
use gungraun::prelude::*;
use gungraun::{Callgrind, EventKind};
use halfdome_benches::rays::{self, RayCounts, RayKind};
use halfdome_benches::scenes;
use halfdome_benches::tracer::Entry;
use halfdome_kernel::irradiance::{Layout, Stratified};
use halfdome_kernel::sampling::{Strata, Stream};
use halfdome_kernel::{BuildOptions, Bvh, Hit, Ray, Triangle};

/// Fails above the number of instructions that was counted, and 5%.
fn counted(instructions: u64) -> LibraryBenchmarkConfig {
    let mut config = LibraryBenchmarkConfig::default();
    config.tool(Callgrind::default().hard_limits([(EventKind::Ir, instructions + instructions / 20)]));
    config
}

/// A thousand rays of one kind, and room for what they find.
struct Rays {
    bvh: Bvh,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    occluded: Vec<bool>,
}

impl Rays {
    fn new(scene: &str, kind: RayKind) -> Self {
        let scene = scenes::by_name(scene).expect("a scene that is made");
        let (bvh, _) = Bvh::build(&scene.triangles, &BuildOptions::default()).expect("a scene that can be built");
        let mut sets = rays::generate(&scene, &bvh.view(), RayCounts::TINY).into_iter();
        let rays = sets.find(|set| set.kind == kind).expect("rays of all kinds").rays;
        let (hits, occluded) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
        Self { bvh, rays, hits, occluded }
    }
}

#[library_benchmark]
#[bench::room_single(args = (Entry::Single, Rays::new("cornell", RayKind::Diffuse)), config = counted(1_034_639))]
#[bench::room_batch(args = (Entry::Batch, Rays::new("cornell", RayKind::Diffuse)), config = counted(518_052))]
#[bench::room_gather(args = (Entry::Gather, Rays::new("cornell", RayKind::Gather)), config = counted(538_036))]
#[bench::hills_packets(args = (Entry::Packet16, Rays::new("terrain:80", RayKind::Primary)), config = counted(1_482_693))]
#[bench::hills_single(args = (Entry::Single, Rays::new("terrain:80", RayKind::Diffuse)), config = counted(926_544))]
#[bench::hills_batch(args = (Entry::Batch, Rays::new("terrain:80", RayKind::Diffuse)), config = counted(1_015_966))]
#[bench::hills_gather(args = (Entry::Gather, Rays::new("terrain:80", RayKind::Gather)), config = counted(1_201_645))]
fn nearest(entry: Entry, mut rays: Rays) -> Rays {
    entry.tracer(rays.bvh.view()).intersect(black_box(&rays.rays), &mut rays.hits);
    black_box(rays)
}

#[library_benchmark]
#[bench::room_batch(args = (Entry::Batch, Rays::new("cornell", RayKind::Shadow)), config = counted(350_037))]
#[bench::hills_packets(args = (Entry::Packet16, Rays::new("terrain:80", RayKind::Shadow)), config = counted(989_770))]
#[bench::hills_batch(args = (Entry::Batch, Rays::new("terrain:80", RayKind::Shadow)), config = counted(749_578))]
fn any(entry: Entry, mut rays: Rays) -> Rays {
    entry.tracer(rays.bvh.view()).occluded(black_box(&rays.rays), &mut rays.occluded);
    black_box(rays)
}

#[library_benchmark]
#[bench::hills(args = (triangles("terrain:80")), config = counted(147_795_076))]
fn building(triangles: Vec<Triangle>) -> Bvh {
    Bvh::build(black_box(&triangles), &BuildOptions::default()).expect("a scene that can be built").0
}

/// The triangles of a scene.
fn triangles(scene: &str) -> Vec<Triangle> {
    scenes::by_name(scene).expect("a scene that is made").triangles
}

/// What the rays of a gather found.
struct Found {
    layout: Stratified<Vec<f32>>,
    directions: Vec<Vec3>,
    radiance: Vec<Vec3>,
    distance: Vec<f32>,
}

impl Found {
    fn new(rings: u32, sectors: u32) -> Self {
        let strata = Strata::new(rings, sectors).expect("rings and sectors");
        let layout = Stratified::new(strata, vec![0.0; Stratified::table_len(&strata)]).expect("its own table");
        let random = |cell: usize, set: u32| Stream::new(1, cell as u32, set).uniform2(0);
        let mut directions = vec![Vec3::ZERO; layout.cells()];
        layout.directions(&mut |cell| random(cell, 0), &mut directions).expect("a direction for each cell");
        let radiance = (0..layout.cells()).map(|cell| random(cell, 1).extend(0.5)).collect();
        let distance = (0..layout.cells()).map(|cell| 0.1 + random(cell, 2).x).collect();
        Self { layout, directions, radiance, distance }
    }
}

#[library_benchmark]
#[bench::strata(args = (Found::new(18, 57)), config = counted(30_463))]
fn gradients(found: Found) -> Found {
    let _ = black_box(found.layout.accumulate(black_box(&found.radiance), &found.distance));
    found
}

#[library_benchmark]
#[bench::strata(args = (Found::new(18, 57)), config = counted(80_854))]
fn hessian(found: Found) -> Found {
    let _ = black_box(found.layout.hessian(&found.directions, black_box(&found.radiance), &found.distance));
    found
}

library_benchmark_group!(name = tracing, benchmarks = [nearest, any]);
library_benchmark_group!(name = trees, benchmarks = [building]);
library_benchmark_group!(name = gathers, benchmarks = [gradients, hessian]);
main!(library_benchmark_groups = [tracing, trees, gathers]);
