//! All ways to trace, on every instruction set that the machine has, compared bit for bit.

use glam::Vec3;
use halfdome_kernel::bvh::RoundBuild;
use halfdome_kernel::geometry::intersect_round;
use halfdome_kernel::traverse::{PacketWidth, Width, reference};
use halfdome_kernel::{
    Bvh, BvhView, Hit, HitPacket, Isa, Item, Level, Quality, Ray, RayPacket, RoundBvh, Scene, Triangle,
};

/// Rays that are enough for a batch to be traced as one.
const BATCH: usize = 70;

/// What this machine can trace with, the scalar reference first.
pub fn isas() -> impl Iterator<Item = Isa> {
    Level::ALL.into_iter().filter_map(Isa::new)
}

/// Bits of a hit, so that zeros of different signs differ.
pub fn bits(hit: Option<Hit>) -> Option<[u32; 4]> {
    hit.map(|hit| [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.prim_id])
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

/// What every ray hits, by the loop; all ways to trace agree with it, in trees of all qualities and in their blobs.
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
        assert_eq!(bits(reference::intersect(tree, ray)), bits(hit), "reference, {ray:?}");
        if let Some(hit) = hit {
            assert!(ray.t_min <= hit.t && hit.t <= ray.t_max, "{hit:?}");
            assert!(hit.u >= 0.0 && hit.v >= 0.0 && hit.u + hit.v <= 1.000_001, "{hit:?}");
        }
    }
    let batch = rays.len().max(if rays.is_empty() { 0 } else { BATCH });
    let batch: Vec<Ray> = rays.iter().copied().cycle().take(batch).collect();
    isas().for_each(|isa| check_isa(&tree.with_isa(isa), rays, &batch, expected));
}

/// `batch` is the rays over and over.
fn check_isa(tree: &BvhView, rays: &[Ray], batch: &[Ray], expected: &[Option<Hit>]) {
    let level = tree.isa().level();
    for (ray, &hit) in rays.iter().zip(expected) {
        assert_eq!(bits(tree.intersect(ray)), bits(hit), "{level}, single, {ray:?}");
        assert_eq!(tree.occluded(ray), hit.is_some(), "{level}, any, {ray:?}");
    }
    let mut hits = vec![Hit::MISS; batch.len()];
    let mut occluded = vec![false; batch.len()];
    for way in ["many", "gather"] {
        if way == "many" {
            tree.intersect_many(batch, &mut hits);
            tree.occluded_many(batch, &mut occluded);
        } else {
            tree.intersect_gather(batch, &mut hits);
            tree.occluded_gather(batch, &mut occluded);
        }
        for (i, (ray, &expected)) in batch.iter().zip(expected.iter().cycle()).enumerate() {
            assert_eq!(bits(Some(hits[i])), bits(Some(expected.unwrap_or(Hit::MISS))), "{level}, {way}, {ray:?}");
            assert_eq!(occluded[i], expected.is_some(), "{level}, {way}, any, {ray:?}");
        }
        hits.fill(Hit::MISS);
        occluded.fill(false);
    }
    check_packets::<4>(tree, rays, expected);
    check_packets::<8>(tree, rays, expected);
    check_packets::<16>(tree, rays, expected);
    check_packets::<32>(tree, rays, expected);
}

/// Packets with the rays in order, in reverse and rotated, with all and with some lanes active.
fn check_packets<const N: usize>(tree: &BvhView, rays: &[Ray], expected: &[Option<Hit>])
where
    Width<N>: PacketWidth<N>,
{
    let level = tree.isa().level();
    let untouched = Hit { t: -7.25, u: 3.0, v: -1.0, prim_id: 4321 };
    for (rays, expected) in rays.chunks(N).zip(expected.chunks(N)) {
        let count = rays.len();
        let orders: [Vec<usize>; 3] =
            [(0..count).collect(), (0..count).rev().collect(), (0..count).map(|i| (i + count / 2) % count).collect()];
        for (order, mask) in orders.into_iter().zip([u32::MAX, 0b1110_1001_1011_0110, 0b0011_0100_0101_1001]) {
            let ordered: Vec<Ray> = order.iter().map(|&i| rays[i]).collect();
            let mut packet = RayPacket::<N>::from_rays(&ordered);
            packet.active &= mask;
            let mut hits = HitPacket::MISS;
            (0..N).for_each(|lane| hits.set(lane, untouched));
            tree.intersect_packet(&packet, &mut hits);
            let occluded = tree.occluded_packet(&packet);
            for lane in 0..N {
                let active = packet.active >> lane & 1 == 1;
                let right = if active { expected[order[lane]].unwrap_or(Hit::MISS) } else { untouched };
                assert_eq!(bits(Some(hits.hit(lane))), bits(Some(right)), "{level}, lane {lane} of {N}, {packet:?}");
                assert_eq!(occluded >> lane & 1 == 1, active && right.is_hit(), "{level}, lane {lane} of {N}");
            }
        }
    }
}

/// What every ray hits of points or curves, by the loop; trees of all qualities agree with it on every instruction set,
/// by themselves and in a scene.
pub fn check_round<P: RoundBuild>(primitives: &[P], rays: &[Ray]) -> Vec<Option<Hit>> {
    let nearest = |ray: &Ray| {
        let hit = |(prim_id, primitive)| intersect_round(ray, primitive).map(|hit| Hit { prim_id, ..hit });
        (0..).zip(primitives).filter_map(hit).min_by(|a: &Hit, b| a.t.total_cmp(&b.t).then(a.prim_id.cmp(&b.prim_id)))
    };
    let expected: Vec<Option<Hit>> = rays.iter().map(nearest).collect();
    for quality in Quality::ALL {
        let (tree, report) = RoundBvh::build(primitives, &quality.into()).expect("there are few");
        assert_eq!(report.kept + report.dropped(), primitives.len());
        let (scene, _) = Scene::build(vec![Item::new(tree.view())], &quality.into()).expect("one item is a scene");
        for isa in isas() {
            let (tree, scene) = (tree.view().with_isa(isa), scene.view().with_isa(isa));
            for (ray, &expected) in rays.iter().zip(&expected) {
                let level = isa.level();
                assert_eq!(bits(tree.intersect(ray)), bits(expected), "{level}, {ray:?}");
                assert_eq!(tree.occluded(ray), expected.is_some(), "{level}, any, {ray:?}");
                let found = scene.intersect(&(*ray).into()).map(|found| found.hit);
                assert_eq!(bits(found), bits(expected), "{level}, scene, {ray:?}");
                assert_eq!(scene.occluded(&(*ray).into()), expected.is_some(), "{level}, scene, any, {ray:?}");
            }
        }
    }
    expected
}
