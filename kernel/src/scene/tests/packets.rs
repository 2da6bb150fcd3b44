//! Packets and gathers: of all rays of other tests, and of rays that are coherent.

use super::*;
use crate::traverse::{PacketWidth, Width};

/// What inactive lanes hold before and after.
const UNTOUCHED: SceneHit =
    SceneHit { hit: Hit { t: -7.25, u: 3.0, v: -1.0, prim_id: 4321 }, item: 17, depth: 3, path: 1 << 40 };

/// Packets of all widths.
pub(super) fn check_packets(scene: &SceneView, rays: &[SceneRay], expected: &[Option<SceneHit>]) {
    check_width::<4>(scene, rays, expected);
    check_width::<8>(scene, rays, expected);
    check_width::<16>(scene, rays, expected);
    check_width::<32>(scene, rays, expected);
}

/// Packets with all and with some lanes active.
fn check_width<const N: usize>(scene: &SceneView, rays: &[SceneRay], expected: &[Option<SceneHit>])
where
    Width<N>: PacketWidth<N>,
{
    let level = scene.isa().level();
    for (rays, expected) in rays.chunks(N).zip(expected.chunks(N)) {
        for mask in [u32::MAX, 0b1110_1001_1011_0110_1111_1111_0000_1110] {
            let mut packet = SceneRayPacket::<N>::from_rays(rays);
            packet.rays.active &= mask;
            let mut hits = SceneHitPacket::MISS;
            (0..N).for_each(|lane| hits.set(lane, UNTOUCHED));
            scene.intersect_packet(&packet, &mut hits);
            let occluded = scene.occluded_packet(&packet);
            let expected = expected.iter().copied().chain(core::iter::repeat(None));
            for (lane, expected) in expected.enumerate().take(N) {
                let active = packet.rays.active >> lane & 1 != 0;
                let right = if active { expected.unwrap_or(SceneHit::MISS) } else { UNTOUCHED };
                let found = hits.hit(lane);
                assert_eq!(bits(Some(found)), bits(Some(right)), "{level}, lane {lane} of {N}, {:?}", packet.ray(lane));
                let right = active && right.is_hit();
                assert_eq!(occluded >> lane & 1 != 0, right, "{level}, lane {lane} of {N}, {:?}", packet.ray(lane));
            }
            assert_eq!(occluded.checked_shr(N as u32).unwrap_or(0), 0);
        }
    }
}

/// Gathers of all rays at once.
pub(super) fn check_gathers(scene: &SceneView, rays: &[SceneRay], expected: &[Option<SceneHit>]) {
    let level = scene.isa().level();
    let (mut hits, mut occluded) = (vec![UNTOUCHED; rays.len() + 1], vec![true; rays.len() + 1]);
    scene.intersect_gather(rays, &mut hits);
    scene.occluded_gather(rays, &mut occluded);
    for (i, (ray, expected)) in rays.iter().zip(expected).enumerate() {
        assert_eq!(bits(Some(hits[i])), bits(Some(expected.unwrap_or(SceneHit::MISS))), "{level}, gather, {ray:?}");
        assert_eq!(occluded[i], expected.is_some(), "{level}, gather, any hit, {ray:?}");
    }
    assert_eq!((hits[rays.len()], occluded[rays.len()]), (UNTOUCHED, true));
    if let [_, rest @ ..] = &mut hits[..] {
        rest.fill(UNTOUCHED);
        let count = rest.len() / 2;
        scene.intersect_gather(rays, &mut rest[..count]);
        assert!(rest[count..].iter().all(|hit| *hit == UNTOUCHED));
    }
}

/// Bundles of sixteen rays about a scene, from one point or nearly, in directions that differ by up to `spread` of
/// their length; with one time and mask each, or with several, and some rays that hit nothing.
fn bundles(random: &mut Random, scene: &SceneView, count: usize, spread: f32) -> Vec<SceneRay> {
    let bounds = scene.bounds();
    let (center, size) = (bounds.center(), (bounds.max - bounds.min).max_element());
    let mut rays = Vec::new();
    for i in 0..count {
        let target = center + random.vector() * size * 0.4;
        let origin = center + random.vector() * size * [0.4, 0.7, 3.0, 500.0][i % 4];
        let (time, mask) = ([0.0, random.unit(), 0.5, 1.0][i / 2 % 4], [u32::MAX, 1, 6][i % 3]);
        let aside = if i % 3 == 0 { 0.01 * size } else { 0.0 };
        for lane in 0..16 {
            let origin = origin + random.vector() * aside;
            let direction = (target - origin) + random.vector() * (target - origin).length() * spread;
            let mut ray = Ray::new(origin, direction * [1.0, 1e-4, 3e3][i % 3]);
            if i % 7 == 0 {
                (ray.t_min, ray.t_max) = (random.unit() - 0.3, 1.0 + random.unit());
            }
            match random.bits() % 64 {
                0 => ray.direction.y = f32::NAN,
                1 => ray.origin.x = f32::NAN,
                2 => ray.t_max = f32::NAN,
                3 => ray.t_max = -1.0,
                4 => ray.direction *= -1.0,
                _ => {}
            }
            let time = if random.bits().is_multiple_of(40) { f32::NAN } else { time };
            let (time, mask) = if i % 5 == 4 { (random.unit(), [1, 2, 7][lane % 3]) } else { (time, mask) };
            rays.push(SceneRay { ray, time, mask });
        }
    }
    rays
}

#[test]
fn bundles_through_random_scenes() {
    let mut random = Random(73);
    let (mut hits, mut total) = (0, 0);
    for (count, spread) in [(3, 0.3), (6, 0.02), (40, 0.05), (100, 0.02), (100, 0.5)] {
        let stock = Stock::new(&mut random);
        let (spheres, quads) = (Spheres(&stock.spheres), Quads(&stock.quads));
        let shapes = (&spheres, &quads);
        // Four scenes deep: more than a packet of sixteen goes.
        let third = scene(stock.items(&mut random, 3, shapes, &[]));
        let third = third.view();
        let second = scene(stock.items(&mut random, 4, shapes, &[&third]));
        let second = second.view();
        let first = scene(stock.items(&mut random, 5, shapes, &[&second]));
        let first = first.view();
        let outer = scene(stock.items(&mut random, count, shapes, &[&first, &second, &third]));
        let rays = bundles(&mut random, &outer.view(), fewer(40).max(6), spread);
        hits += check(&outer.view(), &rays);
        total += rays.len();
    }
    // Of all scenes together: few rays may miss a scene of few items.
    assert!(hits > total / 40, "{hits} hits of {total}");
}

/// Of these packets go through the trees: meshes alone, still and turned.
#[test]
fn bundles_through_fields_of_instances() {
    let mut random = Random(74);
    let meshes = [12, 90, 200].map(|count| bvh(&soup(&mut random, count, 0.6)));
    let mut still = Vec::new();
    for i in 0..60 {
        let mask = [u32::MAX, 1, 2][i % 3];
        still.push(Item::new(meshes[i % 3].view()).placed(&transform(&mut random)).unwrap().with_mask(mask));
    }
    let inner = scene(still[..15].to_vec());
    let inner = inner.view();
    let nested = (0..12).map(|_| Item::new(&inner).placed(&transform(&mut random)).unwrap());
    let nested: Vec<_> = nested.chain(still[..10].iter().cloned()).collect();
    for items in [still, nested] {
        let scene = scene(items);
        for spread in [0.005, 0.05] {
            let rays = bundles(&mut random, &scene.view(), fewer(30).max(3), spread);
            assert!(check(&scene.view(), &rays) > rays.len() / 10);
        }
    }
}

/// The same mesh in several places at once, with what is hit decided by the item, the triangle and the path.
#[test]
fn ties_of_a_packet_are_those_of_single_rays() {
    let mut random = Random(75);
    let mesh = bvh(&soup(&mut random, 60, 0.8));
    let inner = scene(vec![Item::new(mesh.view()), Item::new(mesh.view())]);
    let inner = inner.view();
    let items = (0..12).map(|i| if i % 2 == 0 { Item::new(&inner) } else { Item::new(mesh.view()) }).collect();
    let scene = scene(items);
    let rays = bundles(&mut random, &scene.view(), fewer(40), 0.02);
    assert!(check(&scene.view(), &rays) > rays.len() / 10);
}

/// Boxes of a strongly distorted item are widened for rays from afar.
#[test]
fn bundles_meet_distorted_items() {
    let mut random = Random(76);
    let mesh = bvh(&soup(&mut random, 80, 0.6));
    let flat = Affine3A::from_scale(vec3(300.0, 0.02, 300.0)) * Affine3A::from_rotation_z(0.3);
    let mut items: Vec<_> = (0..20).map(|_| Item::new(mesh.view()).placed(&transform(&mut random)).unwrap()).collect();
    items.push(Item::new(mesh.view()).placed(&flat).unwrap());
    let scene = scene(items);
    for spread in [0.0005, 0.02] {
        let rays = bundles(&mut random, &scene.view(), fewer(40).max(4), spread);
        assert!(check(&scene.view(), &rays) > rays.len() / 40);
    }
}

#[test]
fn packets_of_plain_rays_see_all_items_at_time_zero() {
    let mesh = bvh(&[[Vec3::NEG_ONE, vec3(1.0, -1.0, -1.0), vec3(0.0, 1.0, -1.0)]]);
    let scene = scene(vec![Item::new(mesh.view()).with_mask(4)]);
    let rays: Vec<Ray> = (0..7).map(|i| Ray::new(vec3(0.01 * i as f32, 0.0, 1.0), Vec3::NEG_Z)).collect();
    let packet = SceneRayPacket::<8>::from(crate::RayPacket::from_rays(&rays));
    let rays: Vec<SceneRay> = rays.into_iter().map(SceneRay::new).collect();
    assert_eq!((packet.rays, packet.ray(6)), (SceneRayPacket::from_rays(&rays).rays, rays[6]));
    assert_eq!(scene.view().occluded_packet(&packet), 0b111_1111);
}
