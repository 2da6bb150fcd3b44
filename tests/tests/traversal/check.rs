//! All ways to trace, compared bit for bit.

use glam::Vec3;
use halfdome_kernel::traverse::{PacketWidth, Width, reference};
use halfdome_kernel::{Bvh, BvhView, Hit, HitPacket, Quality, Ray, RayPacket, Triangle};

/// Bits of a hit, so that zeros of different signs tell.
pub(crate) fn bits(hit: Option<Hit>) -> Option<[u32; 4]> {
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

/// What every ray hits, by the loop; all ways to trace agree with it.
pub(crate) fn check(triangles: &[Triangle], rays: &[Ray]) -> Vec<Option<Hit>> {
    let mut expected = Vec::new();
    for quality in Quality::ALL {
        let (bvh, report) = Bvh::build(triangles, &quality.into()).unwrap();
        let tree = bvh.view();
        assert_eq!(BvhView::new(tree.nodes(), tree.blocks()).err(), None);
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

pub(crate) fn check_tree(tree: &BvhView, rays: &[Ray], expected: &[Option<Hit>]) {
    let mut hits = vec![Hit::MISS; rays.len()];
    let mut occluded = vec![false; rays.len()];
    tree.intersect_many(rays, &mut hits);
    tree.occluded_many(rays, &mut occluded);
    for (i, (ray, &expected)) in rays.iter().zip(expected).enumerate() {
        assert_eq!(bits(reference::intersect(tree, ray)), bits(expected), "reference, {ray:?}");
        assert_eq!(bits(tree.intersect(ray)), bits(expected), "single, {ray:?}");
        assert_eq!(bits(Some(hits[i])), bits(Some(expected.unwrap_or(Hit::MISS))), "many, {ray:?}");
        assert_eq!([tree.occluded(ray), occluded[i]], [expected.is_some(); 2], "occluded, {ray:?}");
        if let Some(hit) = expected {
            assert!(ray.t_min <= hit.t && hit.t <= ray.t_max, "{hit:?}");
            assert!(hit.u >= 0.0 && hit.v >= 0.0 && hit.u + hit.v <= 1.000_001, "{hit:?}");
        }
    }
    check_packets::<4>(tree, rays, expected);
    check_packets::<8>(tree, rays, expected);
}

/// Packets with the rays in order, in reverse and rotated, with all and with some lanes active.
fn check_packets<const N: usize>(tree: &BvhView, rays: &[Ray], expected: &[Option<Hit>])
where
    Width<N>: PacketWidth<N>,
{
    let untouched = Hit { t: -7.25, u: 3.0, v: -1.0, prim_id: 4321 };
    for (rays, expected) in rays.chunks(N).zip(expected.chunks(N)) {
        let count = rays.len();
        let orders: [Vec<usize>; 3] =
            [(0..count).collect(), (0..count).rev().collect(), (0..count).map(|i| (i + count / 2) % count).collect()];
        for (order, mask) in orders.into_iter().zip([u32::MAX, 0b1011_0110, 0b0101_1001]) {
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
                assert_eq!(bits(Some(hits.hit(lane))), bits(Some(right)), "lane {lane} of {N}, {packet:?}");
                assert_eq!(occluded >> lane & 1 == 1, active && right.is_hit());
            }
        }
    }
}
