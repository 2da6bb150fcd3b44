//! Every call fits into 32 KiB of stack: job fibres and small threads have no more.

use std::sync::Arc;
use std::thread;

use glam::{Vec3, vec3};
use halfdome_kernel::traverse::{PacketWidth, Width};
use halfdome_kernel::{
    BuildOptions, Bvh, BvhView, Facing, Hit, HitPacket, Item, Ray, RayPacket, Scene, SceneHit, SceneHitPacket,
    SceneRay, SceneRayPacket, SceneView, Triangle, Verdict,
};
use halfdome_tests::check::isas;

/// What the documentation promises.
const STACK: usize = 32 << 10;
/// What the thread takes for itself: its descriptor, thread-local memory, and the frames of this file (6.5 KiB by
/// glibc).
const THREAD: usize = 8 << 10;

/// A grid of `side` × `side` squares.
fn squares(side: u32) -> Vec<Triangle> {
    let square = |i: u32| {
        let p = |x: u32, y: u32| vec3((i % side + x) as f32, (i / side + y) as f32, 0.0);
        [[p(0, 0), p(1, 0), p(1, 1)], [p(0, 0), p(1, 1), p(0, 1)]]
    };
    (0..side * side).flat_map(square).collect()
}

/// Rays from above the squares to all of them.
fn rays(side: u32) -> Vec<Ray> {
    let target = |i: u32| vec3((i % side) as f32 + 0.3, (i / side) as f32 + 0.6, 0.0);
    let origin = vec3(1.0, 2.0, 9.0);
    (0..200).map(|i| Ray::new(origin, target(i * 7 % (side * side)) - origin)).collect()
}

/// Asks everything, and gives how many hits the batch found.
fn ask(tree: &BvhView, rays: &[Ray], hits: &mut [Hit], occluded: &mut [bool]) -> usize {
    for ray in &rays[..4] {
        assert_eq!(tree.intersect(ray).is_some(), tree.occluded(ray));
        assert!(tree.intersect_filtered(ray, |_| Verdict::Reject).is_none());
        let _ = tree.intersect_facing(ray, Facing::Front);
        assert!(tree.count_hits(ray) >= tree.hits(ray).take(1).count());
    }
    let _ = tree.closest_point(Vec3::ZERO, f32::INFINITY);
    packet::<4>(tree, rays);
    packet::<8>(tree, rays);
    packet::<16>(tree, rays);
    packet::<32>(tree, rays);
    tree.intersect_gather(rays, hits);
    tree.occluded_gather(rays, occluded);
    tree.occluded_many(rays, occluded);
    tree.intersect_many(rays, hits);
    hits.iter().filter(|hit| hit.is_hit()).count()
}

fn packet<const N: usize>(tree: &BvhView, rays: &[Ray])
where
    Width<N>: PacketWidth<N>,
{
    let packet = RayPacket::<N>::from_rays(rays);
    tree.intersect_packet(&packet, &mut { HitPacket::MISS });
    let _ = tree.occluded_packet(&packet);
}

/// Asks a scene everything, and gives how many hits the batch found.
fn ask_scene(scene: &SceneView, rays: &[SceneRay], hits: &mut [SceneHit], occluded: &mut [bool]) -> usize {
    for ray in &rays[..4] {
        assert_eq!(scene.intersect(ray).is_some(), scene.occluded(ray));
        assert!(scene.intersect_filtered(ray, |_| Verdict::Reject).is_none());
        assert!(!scene.occluded_filtered(ray, |_| Verdict::Reject));
        let mut nearest = [SceneHit::MISS; 4];
        assert!(scene.count_hits(ray) >= scene.nearest_hits(ray, &mut nearest));
    }
    scene_packet::<4>(scene, rays);
    scene_packet::<8>(scene, rays);
    scene_packet::<16>(scene, rays);
    scene_packet::<32>(scene, rays);
    scene.intersect_gather(rays, hits);
    scene.occluded_gather(rays, occluded);
    scene.occluded_many(rays, occluded);
    scene.intersect_many(rays, hits);
    hits.iter().filter(|hit| hit.is_hit()).count()
}

/// Not inlined, so that its packets are on the stack only while they are traced.
#[inline(never)]
fn scene_packet<const N: usize>(scene: &SceneView, rays: &[SceneRay])
where
    Width<N>: PacketWidth<N>,
{
    let packet = SceneRayPacket::<N>::from_rays(rays);
    scene.intersect_packet(&packet, &mut { SceneHitPacket::MISS });
    let _ = scene.occluded_packet(&packet);
}

/// Runs `call` on a thread that has no more stack than that.
fn on_small_stack<R: Send>(call: impl FnOnce() -> R + Send) -> R {
    thread::scope(|scope| {
        let thread = thread::Builder::new().stack_size(STACK + THREAD);
        // A call that needs more does not return: it ends the process.
        thread.spawn_scoped(scope, call).expect("a thread can be had").join().expect("nothing panics")
    })
}

#[test]
fn scenes_three_levels_deep_fit_into_32_kib_of_stack() {
    let options = BuildOptions::default();
    let (bvh, _) = Bvh::build(&squares(40), &options).unwrap();
    let scene = |item: Item<'static>| Arc::new(Scene::build(vec![item], &options).unwrap().0);
    let one: Arc<Scene<'static>> = scene(Item::new(Arc::new(bvh)));
    let two = scene(Item::new(one));
    let three = scene(Item::new(two));
    assert_eq!(three.view().levels(), 2);
    let rays: Vec<SceneRay> = rays(40).into_iter().map(SceneRay::new).collect();
    for isa in isas() {
        let view = three.view().with_isa(isa);
        let (mut hits, mut occluded) = (vec![SceneHit::MISS; rays.len()], vec![false; rays.len()]);
        let found = on_small_stack(|| ask_scene(&view, &rays, &mut hits, &mut occluded));
        assert_eq!(found, rays.len(), "{}", isa.level());
    }
}

#[test]
fn every_call_fits_into_32_kib_of_stack() {
    // A tree of one node, and a tree of many.
    for side in [4, 40] {
        let (bvh, _) = Bvh::build(&squares(side), &BuildOptions::default()).unwrap();
        assert_eq!(bvh.view().nodes().len() == 1, side == 4);
        let rays = rays(side);
        for isa in isas() {
            let tree = bvh.view().with_isa(isa);
            let (mut hits, mut occluded) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
            let found = on_small_stack(|| ask(&tree, &rays, &mut hits, &mut occluded));
            assert_eq!(found, rays.len(), "{}", isa.level());
        }
    }
}
