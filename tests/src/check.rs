//! All ways to trace, on every instruction set that the machine has, compared bit for bit.

use glam::Vec3;
use halfdome_kernel::bvh::RoundBuild;
use halfdome_kernel::geometry::intersect_round;
use halfdome_kernel::traverse::{PacketWidth, Width, reference};
use halfdome_kernel::{
    Bvh, BvhView, Hit, Isa, Item, Level, Quality, Ray, RoundBvh, Scene, SceneHit, SceneRay, Triangle, Verdict,
};

use crate::scenes::{scene_rays, with_scene};
use crate::ways::{Ways, same};

/// Rays that are enough for a batch to be traced as one.
const BATCH: usize = 70;
/// Rays that get others beside them.
const BUNDLES: usize = 3;

/// What this machine can trace with, the scalar reference first.
pub fn isas() -> impl Iterator<Item = Isa> {
    Level::ALL.into_iter().filter_map(Isa::new)
}

/// The triangles that a tree holds, at their own indices; those that it left out hit nothing.
fn kept(tree: &BvhView, count: usize) -> Vec<Triangle> {
    let mut triangles = vec![[Vec3::NAN; 3]; count];
    for block in tree.blocks() {
        for (lane, &id) in block.prim_id.iter().enumerate().filter(|&(_, &id)| id != Hit::NO_PRIM) {
            assert!(triangles[id as usize][0].is_nan(), "triangle {id} is there twice");
            triangles[id as usize] = block.triangle(lane);
        }
    }
    triangles
}

/// What every ray hits, by the loop; all ways to trace agree with it, in trees of all qualities, in their blobs, and in
/// a scene of instances of one of the trees.
pub fn check(triangles: &[Triangle], rays: &[Ray]) -> Vec<Option<Hit>> {
    let mut expected = Vec::new();
    for quality in Quality::ALL {
        let (bvh, report) = Bvh::build(triangles, &quality.into()).expect("there are few");
        let blob = bvh.to_bytes();
        let tree = BvhView::from_bytes(&blob).expect("what is built is valid");
        let kept = kept(&tree, triangles.len());
        let left_out = kept.iter().filter(|triangle| triangle[0].is_nan()).count();
        assert_eq!((report.kept, report.dropped()), (kept.len() - left_out, left_out));
        for (triangle, kept) in triangles.iter().zip(&kept) {
            assert!(triangle == kept || kept[0].is_nan() && !is_plain(triangle), "{triangle:?} is missing");
        }
        expected = rays.iter().map(|ray| reference::intersect_all(&kept, ray)).collect();
        check_tree(&tree, rays, &expected);
        if quality == Quality::High {
            check_scenes(&tree, triangles.len(), rays);
        }
    }
    expected
}

/// Whether the triangle has an area beyond doubt and moderate coordinates: such must be in a tree.
fn is_plain(triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.map(Vec3::as_dvec3);
    let edges = (b - a).length() * (c - a).length();
    triangle.iter().all(|p| p.abs().max_element() < 1e12) && (b - a).cross(c - a).length() > 1e-6 * edges
}

/// All ways to trace `rays` give what is `expected`.
pub fn check_tree(tree: &BvhView, rays: &[Ray], expected: &[Option<Hit>]) {
    for (ray, &hit) in rays.iter().zip(expected) {
        let found = reference::intersect(tree, ray);
        assert!(same(found, hit), "reference, {found:?}, not {hit:?}, {ray:?}");
        if let Some(hit) = hit {
            assert!(ray.t_min <= hit.t && hit.t <= ray.t_max, "{hit:?}");
            assert!(hit.u >= 0.0 && hit.v >= 0.0 && hit.u + hit.v <= 1.000_001, "{hit:?}");
        }
    }
    isas().for_each(|isa| check_ways(&tree.with_isa(isa), rays, expected));
    isas().for_each(|isa| check_filtered(&tree.with_isa(isa), rays));
}

/// Streams of rays, of which each passes through some triangles, find what single rays find.
fn check_filtered(tree: &BvhView, rays: &[Ray]) {
    let batch = rays.len().max(if rays.is_empty() { 0 } else { BATCH });
    let batch: Vec<Ray> = rays.iter().copied().cycle().take(batch).collect();
    let accepts = |ray: usize, hit: &Hit| !(ray as u32 ^ hit.prim_id ^ hit.u.to_bits() >> 9).is_multiple_of(3);
    let (mut hits, mut occluded) = (vec![Hit::MISS; batch.len()], vec![false; batch.len()]);
    tree.intersect_many_filtered(&batch, &mut hits, accepts);
    tree.occluded_many_filtered(&batch, &mut occluded, accepts);
    for (i, ray) in batch.iter().enumerate() {
        let verdict = |hit: &Hit| if accepts(i, hit) { Verdict::Accept } else { Verdict::Reject };
        let alone = tree.intersect_filtered(ray, verdict);
        let (level, found) = (tree.isa().level(), hits[i]);
        assert!(same(Some(found), Some(alone.unwrap_or(Hit::MISS))), "{level}, {found:?}, not {alone:?}, {ray:?}");
        assert_eq!(occluded[i], alone.is_some(), "{level}, any, filtered, {ray:?}");
    }
}

/// All ways to trace rays through a scene of a tree, of one kind, give what the loop over all triangles of all items
/// gives. The rays are these, and bundles around some.
pub fn check_scenes(tree: &BvhView, kind: usize, rays: &[Ray]) {
    // A gather through motion has packets if all times are one.
    let times = if rays.len().is_multiple_of(2) { [0.3; 2] } else { [0.3, 0.8] };
    let rays = scene_rays(rays, BUNDLES, times);
    with_scene(tree, kind, |scene| {
        let loops = scene.with_isa(Isa::SCALAR);
        let expected: Vec<Option<SceneHit>> = rays.iter().map(|ray| loops.intersect(ray)).collect();
        // By loops all ways are the same.
        isas().skip(1).for_each(|isa| check_ways(&scene.with_isa(isa), &rays, &expected));
    });
}

/// All ways to trace `rays` with one instruction set.
fn check_ways<T: Ways>(target: &T, rays: &[T::Ray], expected: &[Option<T::Hit>]) {
    let level = target.isa().level();
    for (ray, &hit) in rays.iter().zip(expected) {
        let found = target.one(ray);
        assert!(same(found, hit), "{level}, single, {found:?}, not {hit:?}, {ray:?}");
        assert_eq!(target.one_occluded(ray), hit.is_some(), "{level}, any, {ray:?}");
    }
    let batch = rays.len().max(if rays.is_empty() { 0 } else { BATCH });
    let batch: Vec<T::Ray> = rays.iter().copied().cycle().take(batch).collect();
    for way in ["many", "gather"] {
        let (mut hits, mut occluded) = (vec![T::UNTOUCHED; batch.len()], vec![false; batch.len()]);
        match way {
            "many" => target.many(&batch, &mut hits, &mut occluded),
            _ => target.gather(&batch, &mut hits, &mut occluded),
        }
        for (i, (ray, expected)) in batch.iter().zip(expected.iter().cycle()).enumerate() {
            let (found, right) = (hits[i], expected.unwrap_or(T::MISS));
            assert!(same(Some(found), Some(right)), "{level}, {way}, {found:?}, not {right:?}, {ray:?}");
            assert_eq!(occluded[i], expected.is_some(), "{level}, {way}, any, {ray:?}");
        }
    }
    check_packets::<4, _>(target, rays, expected);
    check_packets::<8, _>(target, rays, expected);
    check_packets::<16, _>(target, rays, expected);
    check_packets::<32, _>(target, rays, expected);
}

/// Packets with the rays in order, in reverse and rotated, with all and with some lanes active.
fn check_packets<const N: usize, T: Ways>(target: &T, rays: &[T::Ray], expected: &[Option<T::Hit>])
where
    Width<N>: PacketWidth<N>,
{
    let level = target.isa().level();
    for (rays, expected) in rays.chunks(N).zip(expected.chunks(N)) {
        let count = rays.len();
        let orders: [Vec<usize>; 3] =
            [(0..count).collect(), (0..count).rev().collect(), (0..count).map(|i| (i + count / 2) % count).collect()];
        for (order, mask) in orders.into_iter().zip([u32::MAX, 0b1110_1001_1011_0110, 0b0011_0100_0101_1001]) {
            let ordered: Vec<T::Ray> = order.iter().map(|&i| rays[i]).collect();
            let mut hits = [T::UNTOUCHED; N];
            let occluded = target.packet(&ordered, mask, &mut hits);
            for (lane, &found) in hits.iter().enumerate() {
                let expected = order.get(lane).filter(|_| mask >> lane & 1 == 1).map(|&i| expected[i]);
                let right = expected.map_or(T::UNTOUCHED, |hit| hit.unwrap_or(T::MISS));
                let which = || format!("{level}, lane {lane} of {N}, mask {mask:b}, {ordered:?}");
                assert!(same(Some(found), Some(right)), "{found:?}, not {right:?}, {}", which());
                assert_eq!(occluded >> lane & 1 == 1, expected.flatten().is_some(), "any, {}", which());
            }
        }
    }
}

/// What every ray hits of points or curves, by the loop; trees of all qualities agree with it on every instruction set,
/// by themselves, and in a scene by all ways to trace.
pub fn check_round<P: RoundBuild>(primitives: &[P], rays: &[Ray]) -> Vec<Option<Hit>> {
    let nearest = |ray: &Ray| {
        let hit = |(prim_id, primitive)| intersect_round(ray, primitive).map(|hit| Hit { prim_id, ..hit });
        (0..).zip(primitives).filter_map(hit).min_by(|a: &Hit, b| a.t.total_cmp(&b.t).then(a.prim_id.cmp(&b.prim_id)))
    };
    let expected: Vec<Option<Hit>> = rays.iter().map(nearest).collect();
    let in_scene: Vec<SceneRay> = rays.iter().copied().map(SceneRay::new).collect();
    let of_item = |hit: &Option<Hit>| hit.map(|hit| SceneHit { hit, item: 0, depth: 0, path: 0 });
    let expected_in_scene: Vec<Option<SceneHit>> = expected.iter().map(of_item).collect();
    for quality in Quality::ALL {
        let (tree, report) = RoundBvh::build(primitives, &quality.into()).expect("there are few");
        assert_eq!(report.kept + report.dropped(), primitives.len());
        let (scene, _) = Scene::build(vec![Item::new(tree.view())], &quality.into()).expect("one item is a scene");
        for isa in isas() {
            let (tree, level) = (tree.view().with_isa(isa), isa.level());
            for (ray, &expected) in rays.iter().zip(&expected) {
                let found = tree.intersect(ray);
                assert!(same(found, expected), "{level}, {found:?}, not {expected:?}, {ray:?}");
                assert_eq!(tree.occluded(ray), expected.is_some(), "{level}, any, {ray:?}");
            }
            check_ways(&scene.view().with_isa(isa), &in_scene, &expected_in_scene);
        }
    }
    expected
}
