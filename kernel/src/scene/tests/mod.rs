//! Scenes of all kinds against the loops of [`reference`], and the loops against independent answers.

mod deform;
mod limits;
mod motion;
mod near;
mod order;
mod packets;
mod round;
mod shapes;
mod streams;
mod transforms;
mod updates;
mod widening;

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use glam::{Affine3A, DVec3, Mat3, Quat, Vec3, vec3};

use super::*;
use crate::bvh::{MovingBvh, Node};
use crate::simd::isas;
use crate::traverse::reference as trees;
use crate::traverse::tests::{Random, fewer, rays_at, soup};
use crate::{BuildOptions, Bvh, Error, Hit, InvalidScene, InvalidTree, Quality, Ray, RoundBvh, Sphere, Triangle};

fn bvh(triangles: &[Triangle]) -> Bvh {
    Bvh::build(triangles, &BuildOptions::default()).unwrap().0
}

fn moving(keys: &[Vec<Triangle>]) -> MovingBvh {
    let keys: Vec<&[Triangle]> = keys.iter().map(|key| &key[..]).collect();
    MovingBvh::build(&keys, &BuildOptions::default()).unwrap().0
}

fn scene(items: Vec<Item>) -> Scene {
    Scene::build(items, &BuildOptions::default()).unwrap().0
}

/// Bits of a hit, so that NaN and zeros of different signs are compared.
fn bits(hit: Option<SceneHit>) -> Option<[u32; 8]> {
    hit.map(bytemuck::cast)
}

/// The indices of the items on the path to a hit.
fn instances(scene: &SceneView, hit: &SceneHit) -> Vec<u32> {
    scene.instances(hit).map(|(index, _)| index).collect()
}

/// A verdict that looks arbitrary, and depends on the hit alone.
fn verdict(hit: &SceneHit) -> Verdict {
    let sum = hit.hit.prim_id ^ hit.hit.t.to_bits() >> 9 ^ hit.item;
    if sum.is_multiple_of(3) { Verdict::Accept } else { Verdict::Reject }
}

/// Traces `rays` in all ways and compares with the loops. Gives the number of hits.
fn check(scene: &SceneView, rays: &[SceneRay]) -> usize {
    let expected: Vec<_> = rays.iter().map(|ray| reference::intersect(scene, ray)).collect();
    let filtered: Vec<_> = rays.iter().map(|ray| reference::intersect_filtered(scene, ray, verdict)).collect();
    for isa in isas() {
        let scene = scene.with_isa(isa);
        let level = isa.level();
        for ((ray, &hit), &filtered) in rays.iter().zip(&expected).zip(&filtered) {
            assert_eq!(bits(scene.intersect(ray)), bits(hit), "{level}, {ray:?}");
            assert_eq!(scene.occluded(ray), hit.is_some(), "{level}, any hit, {ray:?}");
            assert_eq!(bits(scene.intersect_filtered(ray, verdict)), bits(filtered), "{level}, filtered, {ray:?}");
            assert_eq!(scene.occluded_filtered(ray, verdict), filtered.is_some(), "{level}, any filtered, {ray:?}");
        }
        // Enough for a stream, and a few more than one holds.
        let batch: Vec<_> = rays.iter().copied().cycle().take(rays.len().max(70)).collect();
        let (mut hits, mut occluded) = (vec![SceneHit::MISS; batch.len()], vec![false; batch.len()]);
        scene.intersect_many(&batch, &mut hits);
        scene.occluded_many(&batch, &mut occluded);
        for (ray, expected) in rays.iter().zip(&expected).take(60) {
            check_all_hits(&scene, ray, *expected);
        }
        let found = batch.iter().zip(hits.into_iter().zip(occluded));
        for ((ray, (hit, occluded)), &expected) in found.zip(expected.iter().cycle()) {
            assert_eq!(bits(Some(hit)), bits(Some(expected.unwrap_or(SceneHit::MISS))), "{level}, many, {ray:?}");
            assert_eq!(occluded, expected.is_some(), "{level}, many, any hit, {ray:?}");
        }
        // The loops are slow, and packets of them are what they are.
        let count = if isa == crate::Isa::SCALAR { rays.len().min(32) } else { rays.len() };
        packets::check_packets(&scene, &rays[..count], &expected);
        packets::check_gathers(&scene, &rays[..count], &expected);
    }
    expected.iter().flatten().count()
}

/// All hits of a ray against those of the loops, and the nearest of them.
fn check_all_hits(scene: &SceneView, ray: &SceneRay, nearest: Option<SceneHit>) {
    let mut expected = Vec::new();
    reference::for_each_hit(scene, ray, &mut |hit| expected.push(hit));
    expected.sort_by(|a, b| if a.precedes(b) { core::cmp::Ordering::Less } else { core::cmp::Ordering::Greater });
    assert_eq!(bits(expected.first().copied()), bits(nearest));
    let mut all = Vec::new();
    let flow = scene.for_each_hit(ray, |hit| {
        all.push(*hit);
        ControlFlow::Continue(())
    });
    assert!(flow.is_continue());
    all.sort_by(|a, b| if a.precedes(b) { core::cmp::Ordering::Less } else { core::cmp::Ordering::Greater });
    assert_eq!(all, expected);
    assert_eq!(scene.count_hits(ray), expected.len());
    for room in [0, 1, 3, 1000] {
        let mut few = vec![SceneHit::MISS; room];
        let count = scene.nearest_hits(ray, &mut few);
        assert_eq!(few[..count], expected[..room.min(expected.len())]);
    }
    let mut left = 2_usize;
    let flow = scene.for_each_hit(ray, |_| {
        left -= 1;
        if left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert_eq!((flow.is_break(), left), (expected.len() >= 2, 2_usize.saturating_sub(expected.len())));
}

/// A transform of about unit size: turned, stretched, perhaps mirrored, moved.
fn transform(random: &mut Random) -> Affine3A {
    let axis = random.vector().normalize_or(Vec3::X);
    let turn = Quat::from_axis_angle(axis, random.unit() * 6.0);
    let stretch = (random.vector() * 1.5).map(f32::exp2) * if random.bits().is_multiple_of(4) { -1.0 } else { 1.0 };
    Affine3A::from_scale_rotation_translation(stretch, turn, random.vector() * 3.0)
}

/// A transform like another.
fn shaken(random: &mut Random, transform: &Affine3A, by: f32) -> Affine3A {
    let shake = |random: &mut Random| random.vector() * by;
    let turn =
        Mat3::from_cols(Vec3::X + shake(random) * 0.3, Vec3::Y + shake(random) * 0.3, Vec3::Z + shake(random) * 0.3);
    Affine3A::from_mat3_translation(turn, shake(random)) * *transform
}

/// A point on a grid, whose sums and differences are exact.
fn on_grid(random: &mut Random) -> Vec3 {
    (random.vector() * 64.0).round() / 32.0
}

/// What random scenes are made of.
struct Stock {
    meshes: Vec<Bvh>,
    moving: Vec<MovingBvh>,
    spheres: Vec<Sphere>,
    quads: Vec<[Vec3; 4]>,
    rounds: Vec<RoundBvh>,
    keys: Vec<Vec<Affine3A>>,
}

impl Stock {
    fn new(random: &mut Random) -> Self {
        let meshes = [1, 12, 90].map(|count| bvh(&soup(random, count, 0.5)));
        let moving = [(2, 20), (3, 40), (4, 9)].map(|(keys, count)| {
            let mut key = soup(random, count, 0.4);
            let keys: Vec<_> = (0..keys)
                .map(|_| {
                    key.iter_mut().flatten().for_each(|p| *p += random.vector() * 0.3);
                    key.clone()
                })
                .collect();
            self::moving(&keys)
        });
        let spheres = (0..20).map(|_| Sphere { center: random.vector(), radius: 0.3 * random.unit() }).collect();
        let quad = |random: &mut Random| {
            let (p, a, b) = (random.vector(), random.vector() * 0.4, random.vector() * 0.4);
            [p, p + a, p + a + b + random.vector() * 0.1, p + b]
        };
        let quads = (0..15).map(|_| quad(random)).collect();
        let keys = (0..6)
            .map(|i| {
                let first = transform(random);
                (0..2 + i % 4).map(|_| shaken(random, &first, 0.8)).collect()
            })
            .collect();
        let rounds = round::trees(random, [20, 30, 40, 12]);
        Self { meshes: meshes.into(), moving: moving.into(), spheres, quads, rounds, keys }
    }

    /// Items of all kinds in all kinds of places.
    fn items<'a>(
        &'a self,
        random: &mut Random,
        count: usize,
        shapes: (&'a Spheres<'a>, &'a Quads<'a>),
        inner: &[&'a SceneView<'a>],
    ) -> Vec<Item<'a>> {
        (0..count)
            .map(|_| {
                let pick = random.bits() as usize / 16;
                let item = match random.bits() % if inner.is_empty() { 8 } else { 10 } {
                    0 | 1 => Item::new(self.meshes[pick % self.meshes.len()].view()),
                    2 | 3 => Item::new(self.moving[pick % self.moving.len()].view()),
                    4 => Item::new(shapes.0),
                    5 => Item::new(shapes.1),
                    6 | 7 => Item::new(self.rounds[pick % self.rounds.len()].view()),
                    _ => Item::new(inner[pick % inner.len()]),
                };
                let item = item.with_mask([u32::MAX, 1, 2, 6][random.bits() as usize % 4]);
                match random.bits() % 4 {
                    0 => item,
                    1 => item.clone().moving(&self.keys[pick % self.keys.len()]).unwrap_or(item),
                    _ => item.placed(&transform(random)).unwrap(),
                }
            })
            .collect()
    }
}

/// Rays about a scene, of all times and masks, from near and far.
fn rays(random: &mut Random, scene: &SceneView, count: usize) -> Vec<SceneRay> {
    let bounds = scene.bounds();
    let (center, size) = (bounds.center(), (bounds.max - bounds.min).max_element());
    (0..count)
        .map(|i| {
            let target = center + random.vector() * size * 0.4;
            let origin = center + random.vector() * size * [0.5, 0.7, 20.0, 3000.0][i % 4];
            let mut ray = Ray::new(origin, (target - origin) * [1.0, 1e-5, 2e4][i % 3]);
            if i % 11 == 0 {
                ray.direction.x = 0.0;
                ray.t_min = f32::NEG_INFINITY;
            }
            if i % 5 == 0 {
                ray = Ray { t_min: random.unit(), t_max: 1.0 + random.unit(), ..Ray::between(origin, target) };
            }
            let time = [0.0, random.unit(), 0.5, random.unit(), 1.0, 1.0 / 3.0][i % 6];
            SceneRay::new(ray).at_time(time).with_mask([u32::MAX, u32::MAX, 1, 4][random.bits() as usize % 4])
        })
        .collect()
}

#[test]
fn random_scenes() {
    let mut random = Random(31);
    for count in [1, 2, 5, 9, 40, 150] {
        let stock = Stock::new(&mut random);
        let (spheres, quads) = (Spheres(&stock.spheres), Quads(&stock.quads));
        let shapes = (&spheres, &quads);
        let innermost = scene(stock.items(&mut random, 4, shapes, &[]));
        let innermost = innermost.view();
        let inner = [scene(stock.items(&mut random, 5, shapes, &[&innermost])), scene(vec![])];
        let inner = inner.each_ref().map(Scene::view);
        let outer = scene(stock.items(&mut random, count, shapes, &[&inner[0], &inner[1], &innermost]));
        let rays = rays(&mut random, &outer.view(), fewer(500));
        let hits = check(&outer.view(), &rays);
        assert!(hits > rays.len() / 40, "{count} items: {hits} hits");
    }
}
