//! Every way to trace against the scalar loop over all triangles: equal bit for bit.

mod limits;

use alloc::vec::Vec;

use glam::{Vec3, vec3};

use super::reference;
use crate::simd::isas;
use crate::{BuildOptions, Bvh, BvhView, Hit, HitPacket, Quality, Ray, RayPacket, Triangle};

/// SplitMix64 (Steele, Lea and Flood 2014).
pub(crate) struct Random(pub u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }
    pub(crate) fn vector(&mut self) -> Vec3 {
        vec3(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
    /// A float of any sign and exponent, NaN and infinity included.
    fn raw(&mut self) -> f32 {
        f32::from_bits(self.bits() as u32)
    }
}

/// Bits of a hit, so that NaN and zeros of different signs are compared.
fn bits(hit: Option<Hit>) -> [u32; 4] {
    hit.map_or([0; 4], |hit| [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.prim_id])
}

/// Traces `rays` in all ways through trees of `triangles` and compares.
fn check(triangles: &[Triangle], rays: &[Ray]) -> usize {
    let mut found = 0;
    for quality in Quality::ALL {
        let (bvh, report) = Bvh::build(triangles, &quality.into()).unwrap();
        assert_eq!(bvh.statistics().triangles, report.kept);
        let expected: Vec<_> = rays.iter().map(|ray| reference::intersect_all(triangles, ray)).collect();
        found += expected.iter().flatten().count();
        isas().for_each(|isa| check_isa(&bvh.view().with_isa(isa), rays, &expected));
    }
    found
}

fn check_isa(tree: &BvhView, rays: &[Ray], expected: &[Option<Hit>]) {
    let level = tree.isa().level();
    for (ray, &hit) in rays.iter().zip(expected) {
        assert_eq!(bits(tree.intersect(ray)), bits(hit), "{level}, {ray:?}");
        assert_eq!(tree.occluded(ray), hit.is_some(), "{level}, any hit, {ray:?}");
    }
    check_packets::<4>(tree, rays, expected);
    check_packets::<8>(tree, rays, expected);
    check_packets::<16>(tree, rays, expected);
    check_packets::<32>(tree, rays, expected);
    let mut hits: Vec<_> = rays.iter().map(|_| Hit::MISS).collect();
    let mut occluded: Vec<_> = rays.iter().map(|_| false).collect();
    tree.intersect_many(rays, &mut hits);
    tree.occluded_many(rays, &mut occluded);
    for ((hit, occluded), expected) in hits.iter().zip(occluded).zip(expected) {
        assert_eq!((bits(hit.found()), occluded), (bits(*expected), expected.is_some()), "{level}, many");
    }
    let mut hits: Vec<_> = rays.iter().map(|_| Hit::MISS).collect();
    let mut occluded: Vec<_> = rays.iter().map(|_| false).collect();
    tree.intersect_gather(rays, &mut hits);
    tree.occluded_gather(rays, &mut occluded);
    for ((hit, occluded), expected) in hits.iter().zip(occluded).zip(expected) {
        assert_eq!((bits(hit.found()), occluded), (bits(*expected), expected.is_some()), "{level}, gather");
    }
}

fn check_packets<const N: usize>(tree: &BvhView, rays: &[Ray], expected: &[Option<Hit>])
where
    super::Width<N>: super::PacketWidth<N>,
{
    let untouched = Hit { t: 12.5, u: -3.0, v: 8.0, prim_id: 77 };
    for (start, chunk) in rays.chunks(N).enumerate() {
        for active in [u32::MAX, 0b0110_0111_0101_1010, 0b1000_0001] {
            let mut packet = RayPacket::<N>::from_rays(chunk);
            packet.active &= active;
            let mut hits = HitPacket::MISS;
            (0..N).for_each(|lane| hits.set(lane, untouched));
            tree.intersect_packet(&packet, &mut hits);
            let occluded = tree.occluded_packet(&packet);
            for lane in 0..N {
                if packet.active >> lane & 1 == 1 {
                    let expected = expected[start * N + lane];
                    assert_eq!(bits(hits.hit(lane).found()), bits(expected), "lane {lane} of {N}, {:?}", chunk[lane]);
                    assert_eq!(occluded >> lane & 1 == 1, expected.is_some());
                } else {
                    assert_eq!(bits(Some(hits.hit(lane))), bits(Some(untouched)));
                    assert_eq!(occluded >> lane & 1, 0);
                }
            }
        }
    }
}

/// A twentieth of `count` where each instruction is emulated, as `tests/targets.sh` says.
pub(crate) fn fewer(count: usize) -> usize {
    if option_env!("HALFDOME_EMULATED").is_some() { count / 20 } else { count }
}

/// Rays of all kinds towards triangles: random, along axes and diagonals, through corners and edges, side by side.
pub(crate) fn rays_at(triangles: &[Triangle], random: &mut Random, count: usize) -> Vec<Ray> {
    let bounds = triangles
        .iter()
        .flatten()
        .filter(|p| p.is_finite())
        .fold(crate::Aabb::EMPTY, |sum, &p| sum.union(&crate::Aabb { min: p, max: p }));
    let (center, size) = (bounds.center(), (bounds.max - bounds.min).max_element().max(1e-3));
    let mut rays = Vec::new();
    // Under Miri just enough for a batch.
    for i in 0..if cfg!(miri) { 7 } else { count } {
        let triangle = triangles[random.bits() as usize % triangles.len()];
        let target = match i % 5 {
            0 => triangle[0],
            1 => (triangle[1] + triangle[2]) * 0.5,
            2 => triangle[0] * 0.25 + triangle[1] * 0.5 + triangle[2] * 0.25,
            _ => center + random.vector() * size * 0.5,
        };
        let origin = match i % 4 {
            0 => center + random.vector() * size,
            1 => center + random.vector() * size * 50.0,
            2 => triangle[random.bits() as usize % 3],
            _ => {
                let steps = [-1.0f32, 0.0, 1.0, -0.0];
                let axis = Vec3::from_array([0; 3].map(|_| steps[random.bits() as usize % 4]));
                rays.push(Ray::new(target, axis));
                target - axis * size
            }
        };
        let direction = (target - origin) * [1.0, 1e-6, 3e7][i % 3];
        rays.push(Ray::new(origin, direction));
        rays.push(Ray { t_min: random.unit(), t_max: 1.0 + random.unit(), ..Ray::between(origin, target) });
        // A bundle that a packet can trace together.
        for _ in 0..8 {
            rays.push(Ray::new(origin, direction.normalize_or(Vec3::Z) + random.vector() * 0.05));
        }
    }
    rays
}

pub(crate) fn soup(random: &mut Random, count: usize, size: f32) -> Vec<Triangle> {
    (0..if cfg!(miri) { count.min(40) } else { count })
        .map(|_| {
            let center = random.vector();
            [(); 3].map(|()| center + random.vector() * size)
        })
        .collect()
}

/// A closed sphere: an octahedron whose faces are quartered `levels` times.
pub(crate) fn sphere(levels: u32, place: impl Fn(Vec3) -> Vec3) -> Vec<Triangle> {
    let mut faces = Vec::new();
    for sign in 0..8 {
        let s = |bit: u32| if sign >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let (x, y, z) = (vec3(s(0), 0.0, 0.0), vec3(0.0, s(1), 0.0), vec3(0.0, 0.0, s(2)));
        faces.push(if s(0) * s(1) * s(2) > 0.0 { [x, y, z] } else { [x, z, y] });
    }
    for _ in 0..levels {
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    faces.iter().map(|face| face.map(&place)).collect()
}

#[test]
fn random_triangles() {
    let mut random = Random(1);
    for (count, size) in [(1, 1.0), (2, 0.5), (3, 1.0), (7, 0.5), (8, 0.5), (9, 0.5), (60, 0.4), (400, 0.1), (700, 1.0)]
    {
        let triangles = soup(&mut random, count, size);
        let rays = rays_at(&triangles, &mut random, fewer(60));
        assert!(check(&triangles, &rays) > rays.len() / 20);
    }
}

/// As many rays as wait in queues, and as a stream has active at a time, and one more or less.
#[test]
fn batches_of_any_length() {
    let mut random = Random(8);
    for (count, size) in [(30, 0.6), (200, 0.3)] {
        let triangles = soup(&mut random, count, size);
        let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
        assert_eq!(bvh.view().nodes().len() == 1, count == 30);
        let rays = rays_at(&triangles, &mut random, 30);
        let expected: Vec<_> = rays.iter().map(|ray| reference::intersect_all(&triangles, ray)).collect();
        for len in (63..=76).chain(125..=138) {
            for isa in isas() {
                let mut hits = [Hit::MISS; 140];
                bvh.view().with_isa(isa).intersect_many(&rays[..len], &mut hits);
                for (hit, expected) in hits.iter().zip(&expected[..len]) {
                    assert_eq!(bits(hit.found()), bits(*expected), "{len}");
                }
                assert!(hits[len..].iter().all(|hit| *hit == Hit::MISS));
            }
        }
    }
}

#[test]
fn a_grid_of_axis_aligned_quads() {
    let mut random = Random(3);
    let mut triangles = Vec::new();
    for i in 0..10 {
        for j in 0..10 {
            let p = |x: i32, y: i32| vec3(x as f32, y as f32, ((i + j) % 3) as f32);
            triangles.push([p(i, j), p(i + 1, j), p(i + 1, j + 1)]);
            triangles.push([p(i, j), p(i + 1, j + 1), p(i, j + 1)]);
        }
    }
    let mut rays = rays_at(&triangles, &mut random, 60);
    // Along grid lines and through grid points, from inside flat boxes and on split planes.
    for i in 0..=20 {
        let at = i as f32 * 0.5;
        for direction in [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::Z, vec3(1.0, 1.0, 0.0), vec3(0.0, -0.0, 1.0)] {
            rays.push(Ray::new(vec3(at, 5.0, 0.0), direction));
            rays.push(Ray::new(vec3(at, at, -1.0), direction));
        }
    }
    assert!(check(&triangles, &rays) > 400);
}

#[test]
fn no_ray_escapes_from_a_sphere_or_enters_it_unseen() {
    let mut random = Random(4);
    for center in [Vec3::ZERO, Vec3::splat(1e3), Vec3::splat(1e5), vec3(148_376.0, 1234.0, -223_423.0)] {
        let triangles = sphere(3, |p| p * 3.0 + center);
        let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default()).unwrap();
        for i in 0..20_000 {
            let triangle = triangles[random.bits() as usize % triangles.len()];
            let (a, b) = (triangle[i % 3], triangle[(i + 1) % 3]);
            // At corners, along edges, anywhere.
            let target = match i % 3 {
                0 => a,
                1 => a.lerp(b, random.unit()),
                _ => center + random.vector(),
            };
            let inside = center + random.vector() * 0.8;
            let leak = Ray::new(inside, target - inside);
            assert!(bvh.view().intersect(&leak).is_some(), "{leak:?} escapes");
            let outside = center + random.vector().normalize() * 9.0;
            let far_wall = Ray { t_max: 2.0, ..Ray::between(outside, inside) };
            assert!(bvh.view().occluded(&far_wall), "{far_wall:?} passes");
        }
    }
}

#[test]
fn copies_of_one_triangle_give_the_first() {
    let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let triangles: Vec<_> = core::iter::repeat_n(triangle, fewer(100_000)).collect();
    for quality in Quality::ALL {
        let (bvh, _) = Bvh::build(&triangles, &quality.into()).unwrap();
        let hit = bvh.view().intersect(&Ray::new(vec3(0.25, 0.25, -2.0), Vec3::Z)).unwrap();
        assert_eq!(hit, Hit { t: 2.0, u: 0.25, v: 0.25, prim_id: 0 });
    }
}

#[test]
fn an_empty_tree_is_missed() {
    check(&[], &[Ray::new(Vec3::ZERO, Vec3::X)]);
    check(&[[Vec3::ZERO; 3]], &[Ray::new(Vec3::ZERO, Vec3::X)]);
}
