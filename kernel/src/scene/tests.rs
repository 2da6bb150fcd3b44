//! Scenes of all kinds against the loops of [`reference`], and that against answers found otherwise.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use glam::{Affine3A, DVec3, Mat3, Quat, Vec3, vec3};

use super::*;
use crate::bvh::{MovingBvh, Node};
use crate::traverse::reference as trees;
use crate::traverse::tests::{Random, isas, rays_at, soup};
use crate::{BuildOptions, Bvh, Error, Hit, InvalidScene, InvalidTree, Quality, Ray, Triangle};

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

/// Bits of a hit, so that NaN and zeros of different signs tell.
fn bits(hit: Option<SceneHit>) -> Option<[u32; 13]> {
    hit.map(bytemuck::cast)
}

/// A verdict that looks arbitrary, and depends on the hit alone.
fn verdict(hit: &SceneHit) -> Verdict {
    let sum = hit.hit.prim_id ^ hit.hit.t.to_bits() >> 9 ^ hit.geometry_id;
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
        let (mut hits, mut occluded) = (vec![SceneHit::MISS; rays.len()], vec![false; rays.len()]);
        scene.intersect_many(rays, &mut hits);
        scene.occluded_many(rays, &mut occluded);
        for ((hit, occluded), &expected) in hits.into_iter().zip(occluded).zip(&expected) {
            assert_eq!(bits(Some(hit)), bits(Some(expected.unwrap_or(SceneHit::MISS))), "{level}, many");
            assert_eq!(occluded, expected.is_some(), "{level}, many");
        }
    }
    expected.iter().flatten().count()
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

/// What random scenes are made of.
struct Stock {
    meshes: Vec<Bvh>,
    moving: Vec<MovingBvh>,
    spheres: Vec<Sphere>,
    quads: Vec<[Vec3; 4]>,
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
        Self { meshes: meshes.into(), moving: moving.into(), spheres, quads, keys }
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
                let item = match random.bits() % if inner.is_empty() { 6 } else { 8 } {
                    0 | 1 => Item::new(self.meshes[pick % self.meshes.len()].view()),
                    2 | 3 => Item::new(self.moving[pick % self.moving.len()].view()),
                    4 => Item::new(shapes.0),
                    5 => Item::new(shapes.1),
                    _ => Item::new(inner[pick % inner.len()]),
                };
                let item = item.with_mask([u32::MAX, 1, 2, 6][random.bits() as usize % 4]);
                match random.bits() % 4 {
                    0 => item,
                    1 => item.moving(&self.keys[pick % self.keys.len()]).unwrap_or(item),
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
        let rays = rays(&mut random, &outer.view(), 500);
        let hits = check(&outer.view(), &rays);
        assert!(hits > rays.len() / 40, "{count} items: {hits} hits");
    }
}

#[test]
fn distorted_and_distant_instances_lose_no_hits() {
    let mut random = Random(32);
    let triangles = soup(&mut random, 60, 0.5);
    let mesh = bvh(&triangles);
    for (stretch, shift) in
        [(vec3(1.0, 1e-3, 1.0), 0.0), (vec3(30.0, 1.0, 2e-3), 1e4), (Vec3::splat(1e-6), 1.0), (Vec3::splat(1e6), 1e8)]
    {
        let place = |random: &mut Random| {
            let turn = Quat::from_axis_angle(random.vector().normalize(), 2.0);
            Affine3A::from_scale_rotation_translation(stretch, turn, random.vector() * (shift + stretch.max_element()))
        };
        let places: Vec<_> = (0..30).map(|_| place(&mut random)).collect();
        let inner = scene(places[..15].iter().map(|place| Item::new(mesh.view()).placed(place).unwrap()).collect());
        let (inner, turned) = (inner.view(), Affine3A::from_rotation_y(1.0));
        let mut items: Vec<_> =
            places[15..].iter().map(|place| Item::new(mesh.view()).placed(place).unwrap()).collect();
        items.push(Item::new(&inner).placed(&turned).unwrap());
        let scene = scene(items);
        // At corners and middles of triangles where they are in the scene: what rounding may lose.
        let mut rays = Vec::new();
        for i in 0..2000 {
            let place = match random.bits() as usize % 30 {
                i @ ..15 => turned * places[i],
                i => places[i],
            };
            let triangle = triangles[random.bits() as usize % 60].map(|p| place.transform_point3(p));
            let target = if i % 2 == 0 { triangle[i % 3] } else { (triangle[0] + triangle[1] + triangle[2]) / 3.0 };
            let size = (scene.view().bounds().max - scene.view().bounds().min).max_element();
            let origin = target + random.vector() * size * [1e-3, 1.0, 1e3][i % 3];
            rays.push(SceneRay::new(Ray { t_max: 3.0, ..Ray::between(origin, target) }));
        }
        let hits = check(&scene.view(), &rays);
        assert!(hits > 800, "{stretch} {shift}: {hits}");
    }
}

/// A point on a grid, whose sums and differences are exact.
fn on_grid(random: &mut Random) -> Vec3 {
    (random.vector() * 64.0).round() / 32.0
}

#[test]
fn exact_transforms_give_what_transformed_triangles_do() {
    let mut random = Random(33);
    let triangles: Vec<Triangle> = (0..80).map(|_| [(); 3].map(|()| on_grid(&mut random))).collect();
    let mesh = bvh(&triangles);
    // Whole shifts, powers of two, mirrors and exchanges of axes are exact.
    let exchange = Affine3A::from_mat3(Mat3::from_cols(Vec3::Z, -Vec3::X, Vec3::Y));
    let places: Vec<_> = [1.0, 0.25, 8.0]
        .into_iter()
        .flat_map(|scale| [Affine3A::IDENTITY, exchange].map(|turn| (scale, turn)))
        .map(|(scale, turn)| {
            let shift = (random.vector() * 8.0).round();
            Affine3A::from_translation(shift) * turn * Affine3A::from_scale(Vec3::splat(scale))
        })
        .collect();
    let inner = scene(places.iter().map(|place| Item::new(mesh.view()).placed(place).unwrap()).collect());
    let inner = inner.view();
    let outer = scene(places.iter().map(|place| Item::new(&inner).placed(place).unwrap()).collect());
    let mut flat = Vec::new();
    for outer in &places {
        for inner in &places {
            flat.extend(triangles.iter().map(|triangle| triangle.map(|p| (*outer * *inner).transform_point3(p))));
        }
    }
    let mut hits = 0;
    for i in 0..3000 {
        let origin = on_grid(&mut random) * 8.0;
        let target = flat[random.bits() as usize % flat.len()][i % 3];
        let ray = Ray { t_max: 4.0, ..Ray::between(origin, target) };
        let expected = trees::intersect_all(&flat, &ray);
        let found = outer.view().intersect(&SceneRay::new(ray));
        // The main axis may be another one where axes are exchanged and two components are equal: the same to rounding.
        let tie = ray.direction.abs().to_array();
        if tie[0] == tie[1] || tie[1] == tie[2] || tie[2] == tie[0] {
            continue;
        }
        assert_eq!(found.is_some(), expected.is_some(), "{ray:?}");
        let (Some(found), Some(expected)) = (found, expected) else { continue };
        hits += 1;
        let flat_id = (found.instances[0] * places.len() as u32 + found.geometry_id) * 80 + found.hit.prim_id;
        let again = crate::geometry::intersect_triangle(&ray, &flat[flat_id as usize]).unwrap();
        assert!((found.hit.t - expected.t).abs() <= 4.0 * f32::EPSILON * expected.t.abs(), "{ray:?}");
        if places[found.instances[0] as usize].matrix3.x_axis.x != 0.0
            && places[found.geometry_id as usize].matrix3.x_axis.x != 0.0
        {
            // No axes exchanged: equal bit for bit.
            let bits = |hit: Hit| [hit.t, hit.u, hit.v].map(f32::to_bits);
            assert_eq!(bits(found.hit), bits(again), "{ray:?}");
        }
    }
    assert!(hits > 1000, "{hits}");
}

/// Weights of less than this may be rounded to zero or beyond.
const DOUBT: f64 = 1e-2;

/// Möller and Trumbore's test in `f64`: `t` and the least barycentric weight.
fn intersect_f64(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<(f64, f64)> {
    let (e1, e2) = (b - a, c - a);
    let p = direction.cross(e2);
    let determinant = e1.dot(p);
    let s = origin - a;
    let (u, q) = (s.dot(p) / determinant, s.cross(e1));
    let (v, t) = (direction.dot(q) / determinant, e2.dot(q) / determinant);
    let least = u.min(v).min(1.0 - u - v);
    (least > -DOUBT).then_some((t, least))
}

#[test]
fn instances_are_where_f64_says() {
    let mut random = Random(34);
    let triangles = soup(&mut random, 25, 0.6);
    let mesh = bvh(&triangles);
    let places: Vec<_> = (0..12).map(|_| transform(&mut random)).collect();
    let scene = scene(places.iter().map(|place| Item::new(mesh.view()).placed(place).unwrap()).collect());
    let exact = |place: &Affine3A, p: Vec3| {
        let column = |v: glam::Vec3A| Vec3::from(v).as_dvec3();
        column(place.translation)
            + column(place.matrix3.x_axis) * f64::from(p.x)
            + column(place.matrix3.y_axis) * f64::from(p.y)
            + column(place.matrix3.z_axis) * f64::from(p.z)
    };
    let flat: Vec<[DVec3; 3]> =
        places.iter().flat_map(|place| triangles.iter().map(|t| t.map(|p| exact(place, p)))).collect();
    let (mut hits, mut doubtful) = (0, 0);
    for mut ray in rays(&mut random, &scene.view(), 4000) {
        ray.mask = 1;
        if ray.ray.origin.length() > 1e3 {
            continue;
        }
        let (origin, direction) = (ray.ray.origin.as_dvec3(), ray.ray.direction.as_dvec3());
        let found = scene.view().intersect(&ray);
        let in_interval = |t: f64| f64::from(ray.ray.t_min) <= t && t <= f64::from(ray.ray.t_max);
        let candidates: Vec<_> =
            flat.iter().filter_map(|&triangle| intersect_f64(origin, direction, triangle)).collect();
        // Near an edge, or the end of the interval, either may be right.
        let limit = f64::from(ray.ray.origin.length()) / direction.length() * 1e-5;
        let near_end = |t: f64| [ray.ray.t_min, ray.ray.t_max].iter().any(|&end| (t - f64::from(end)).abs() < limit);
        if candidates.iter().any(|&(t, least)| least < DOUBT || near_end(t)) {
            doubtful += 1;
            continue;
        }
        let nearest = candidates.iter().map(|c| c.0).filter(|&t| in_interval(t)).min_by(f64::total_cmp);
        assert_eq!(found.is_some(), nearest.is_some(), "{ray:?}");
        if let (Some(found), Some(nearest)) = (found, nearest) {
            hits += 1;
            assert!((f64::from(found.hit.t) - nearest).abs() <= limit, "{ray:?} {found:?} {nearest}");
            // The hit's own point is where its item is.
            let [a, b, c] = flat[found.geometry_id as usize * 25 + found.hit.prim_id as usize];
            let (u, v) = (f64::from(found.hit.u), f64::from(found.hit.v));
            let (point, along) = (a + (b - a) * u + (c - a) * v, origin + direction * f64::from(found.hit.t));
            assert!((point - along).length() < limit * direction.length() * 10.0, "{ray:?} {point} {along}");
        }
    }
    assert!(hits > 400 && doubtful < 1500, "{hits} {doubtful}");
}

#[test]
fn a_mesh_in_a_scene_is_the_mesh() {
    let mut random = Random(35);
    let triangles = soup(&mut random, 200, 0.5);
    let mesh = bvh(&triangles);
    let same = Affine3A::IDENTITY;
    let still = [same, same, same];
    let inner = scene(vec![Item::new(mesh.view())]);
    let inner = inner.view();
    let scenes = [
        scene(vec![Item::new(mesh.view())]),
        scene(vec![Item::new(mesh.view()).placed(&same).unwrap()]),
        scene(vec![Item::new(mesh.view()).moving(&still).unwrap()]),
        scene(vec![Item::new(&inner)]),
    ];
    for (i, ray) in rays_at(&triangles, &mut random, 100).into_iter().enumerate() {
        let expected = mesh.view().intersect(&ray);
        for scene in &scenes {
            let found = scene.view().intersect(&SceneRay::new(ray).at_time((i % 7) as f32 / 6.0));
            assert_eq!(found.map(|found| found.hit), expected, "{ray:?}");
        }
    }
}

#[test]
fn at_keys_what_moves_stands_still() {
    let mut random = Random(36);
    let keys: Vec<_> = (0..5).map(|_| soup(&mut random, 40, 0.5)).collect();
    let meshes: Vec<_> = keys.iter().map(|key| bvh(key)).collect();
    let moving = moving(&keys);
    let first = transform(&mut random);
    let places: Vec<_> = (0..5).map(|_| shaken(&mut random, &first, 0.5)).collect();
    let still_mesh = &meshes[0];
    // Some move, others stand; in a scene that moves as a whole too.
    let inner = scene(vec![
        Item::new(moving.view()),
        Item::new(still_mesh.view()).moving(&places).unwrap(),
        Item::new(still_mesh.view()).placed(&first).unwrap(),
    ]);
    let inner = inner.view();
    let outer =
        scene(vec![Item::new(&inner).moving(&places).unwrap(), Item::new(moving.view()).placed(&first).unwrap()]);
    for key in 0..5 {
        let place = &places[key];
        let inner = scene(vec![
            Item::new(meshes[key].view()),
            Item::new(still_mesh.view()).placed(place).unwrap(),
            Item::new(still_mesh.view()).placed(&first).unwrap(),
        ]);
        let inner = inner.view();
        let still = scene(vec![
            Item::new(&inner).placed(place).unwrap(),
            Item::new(meshes[key].view()).placed(&first).unwrap(),
        ]);
        let mut hits = 0;
        for ray in rays(&mut random, &still.view(), 1000) {
            let ray = ray.at_time(key as f32 / 4.0);
            let expected = still.view().intersect(&ray);
            assert_eq!(bits(outer.view().intersect(&ray)), bits(expected), "key {key}, {ray:?}");
            hits += usize::from(expected.is_some());
            // Beyond the ends is at the ends.
            let beyond = [-3.0, 0.25, 0.5, 0.75, f32::INFINITY][key];
            assert_eq!(bits(outer.view().intersect(&ray.at_time(beyond))), bits(expected));
            assert_eq!(outer.view().intersect(&ray.at_time(f32::NAN)), None);
            assert_eq!(reference::intersect(&outer.view(), &ray.at_time(f32::NAN)), None);
        }
        assert!(hits > 100, "{hits}");
    }
}

#[test]
fn between_keys_triangles_are_interpolated() {
    let mut random = Random(37);
    for keys in 2..5 {
        let keys: Vec<_> = (0..keys).map(|_| soup(&mut random, 60, 0.5)).collect();
        let moving = moving(&keys);
        let scene = scene(vec![Item::new(moving.view())]);
        for i in 0..40 {
            let time = if i == 0 { 1e-30 } else { random.unit() };
            let place = f64::from(time) * (keys.len() - 1) as f64;
            let (key, fraction) = (place as usize, place.fract() as f32);
            let at = |a: &Triangle, b: &Triangle| [0, 1, 2].map(|i| a[i] * (1.0 - fraction) + b[i] * fraction);
            let now: Vec<_> = keys[key].iter().zip(&keys[key + 1]).map(|(a, b)| at(a, b)).collect();
            for ray in rays_at(&now, &mut random, 10) {
                let found = scene.view().intersect(&SceneRay::new(ray).at_time(time));
                assert_eq!(found.map(|found| found.hit), trees::intersect_all(&now, &ray), "{time} {ray:?}");
            }
        }
    }
}

#[test]
fn between_keys_transforms_are_interpolated() {
    let mut random = Random(38);
    let mesh = bvh(&soup(&mut random, 60, 0.6));
    // Elements whose means are exact.
    let keys = [1.0, 3.0, 2.0].map(|stretch| {
        Affine3A::from_scale_rotation_translation(Vec3::splat(stretch), Quat::IDENTITY, on_grid(&mut random))
    });
    let moving = scene(vec![Item::new(mesh.view()).moving(&keys).unwrap()]);
    for (key, fraction) in [(0, 0.5f32), (1, 0.25), (0, 0.125)] {
        let mix = |a: glam::Vec3A, b: glam::Vec3A| a * (1.0 - fraction) + b * fraction;
        let (from, to) = (keys[key], keys[key + 1]);
        let mut now = from;
        now.matrix3.x_axis = mix(from.matrix3.x_axis, to.matrix3.x_axis);
        now.matrix3.y_axis = mix(from.matrix3.y_axis, to.matrix3.y_axis);
        now.matrix3.z_axis = mix(from.matrix3.z_axis, to.matrix3.z_axis);
        now.translation = mix(from.translation, to.translation);
        let still = scene(vec![Item::new(mesh.view()).placed(&now).unwrap()]);
        assert_eq!(moving.view().items()[0].to_scene((key as f32 + fraction) * 0.5), Some(now));
        let mut hits = 0;
        for ray in rays(&mut random, &still.view(), 1000) {
            let expected = still.view().intersect(&ray);
            let found = moving.view().intersect(&ray.at_time((key as f32 + fraction) * 0.5));
            assert_eq!(bits(found), bits(expected), "{ray:?}");
            hits += usize::from(expected.is_some());
        }
        assert!(hits > 100, "{hits}");
    }
}

#[test]
fn keys_of_different_numbers_meet() {
    let mut random = Random(39);
    let mesh = bvh(&soup(&mut random, 20, 0.6));
    let first = transform(&mut random);
    let keys: Vec<Vec<_>> = [2, 3, 4, 5, 7].map(|n| (0..n).map(|_| shaken(&mut random, &first, 0.8)).collect()).into();
    // Of seven, those of two, three and four are among the keys, and those of five are not.
    let scene = scene(keys.iter().map(|keys| Item::new(mesh.view()).moving(keys).unwrap()).collect());
    assert_eq!(scene.view().tree().keys(), 7);
    let rays = rays(&mut random, &scene.view(), 3000);
    assert!(check(&scene.view(), &rays) > 150);
}

#[test]
fn masks_hide_at_every_level() {
    let triangle = bvh(&[[vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(0.0, 1.0, 0.0)]]);
    let at = |z: f32| Affine3A::from_translation(vec3(0.0, 0.0, z));
    let inner =
        scene((0..4).map(|i| Item::new(triangle.view()).placed(&at(-(i as f32))).unwrap().with_mask(1 << i)).collect());
    let inner = inner.view();
    let outer = scene(vec![
        Item::new(&inner).with_mask(0b0110),
        Item::new(&inner).placed(&at(-10.0)).unwrap().with_mask(0b1001),
        Item::new(triangle.view()).placed(&at(-20.0)).unwrap().with_mask(0),
        Item::new(triangle.view()).placed(&at(-30.0)).unwrap(),
    ]);
    for mask in 0..16u32 {
        let ray = SceneRay::new(Ray::new(vec3(0.0, 0.0, 1.0), Vec3::NEG_Z)).with_mask(mask);
        // The first item of the first scene, if the ray sees that scene at all; then of the second.
        let first = (mask & 0b0110 != 0).then(|| mask.trailing_zeros() as f32 + 1.0);
        let second = (mask & 0b1001 != 0).then(|| mask.trailing_zeros() as f32 + 11.0);
        let last = (mask != 0).then_some(31.0);
        let found = outer.view().intersect(&ray);
        assert_eq!(found.map(|found| found.hit.t), first.or(second).or(last), "{mask:04b}");
        check(&outer.view(), &[ray]);
        if first.is_some() {
            let found = found.unwrap();
            assert_eq!((found.geometry_id, found.instances[0]), (mask.trailing_zeros(), 0));
            assert_eq!(found.instances[1], SceneHit::NO_INSTANCE);
        }
    }
}

/// A shape of planes `z = 0`, of which all say the same.
struct Planes(u32);

impl Shape for Planes {
    fn count(&self) -> u32 {
        self.0
    }
    fn bounds(&self, _: u32) -> crate::Aabb {
        crate::Aabb { min: vec3(-1.0, -1.0, 0.0), max: vec3(1.0, 1.0, 0.0) }
    }
    fn intersect(&self, prim_id: u32, ray: &Ray, time: f32) -> Option<Hit> {
        Some(Hit { t: -ray.origin.z / ray.direction.z, u: prim_id as f32, v: time, prim_id: 77 })
    }
}

#[test]
fn of_equally_near_hits_the_lowest_ids_count() {
    let corners = [vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(1.0, 1.0, 0.0), vec3(-1.0, 1.0, 0.0)];
    let triangle = [corners[0], corners[1], corners[2]];
    let (mesh, quad_list) = (bvh(&[triangle; 9]), [corners; 3]);
    let (quads, planes) = (Quads(&quad_list), Planes(5));
    let inner = scene(vec![Item::new(&planes), Item::new(mesh.view())]);
    let inner = inner.view();
    let ray = SceneRay::new(Ray::new(vec3(0.25, -0.25, 2.0), Vec3::NEG_Z)).at_time(0.75);
    let objects = [Item::new(mesh.view()), Item::new(&quads), Item::new(&planes), Item::new(&inner)];
    for order in 0..24 {
        // All permutations.
        let mut left: Vec<_> = (0..4).collect();
        let order: Vec<usize> = [6, 2, 1, 1]
            .iter()
            .scan(order, |rest, &n| {
                let i = *rest / n;
                *rest %= n;
                Some(left.remove(i))
            })
            .collect();
        let scene = scene(order.iter().map(|&i| objects[i]).collect());
        let found = scene.view().intersect(&ray).unwrap();
        // All have a part 0 and t = 2. In the inner scene geometry 0 is the planes.
        assert_eq!((found.hit.t, found.hit.prim_id, found.geometry_id), (2.0, 0, 0), "{order:?}");
        let place_of_scene = order.iter().position(|&i| i == 3).unwrap() as u32;
        // Without instances come those behind all with: NO_INSTANCE is the highest.
        assert_eq!(found.instances[0], place_of_scene, "{order:?}");
        assert_eq!((found.hit.u, found.hit.v), (0.0, 0.75));
        check(&scene.view(), &[ray]);
        // Rejecting them one after the other gives all in order, each once.
        let mut seen: Vec<SceneHit> = Vec::new();
        while let Some(next) = scene
            .view()
            .intersect_filtered(&ray, |hit| if seen.contains(hit) { Verdict::Reject } else { Verdict::Accept })
        {
            seen.push(next);
        }
        assert_eq!(seen.len(), 9 + 3 + 5 + 5 + 9, "{order:?}");
        assert!(seen.windows(2).all(|pair| pair[0].precedes(&pair[1])));
    }
}

#[test]
fn filters_see_each_hit_once_and_in_one_order() {
    let mut random = Random(40);
    let stock = Stock::new(&mut random);
    let (spheres, quads) = (Spheres(&stock.spheres), Quads(&stock.quads));
    let inner = scene(stock.items(&mut random, 6, (&spheres, &quads), &[]));
    let inner = inner.view();
    let scene = scene(stock.items(&mut random, 20, (&spheres, &quads), &[&inner]));
    let mut total = 0;
    for ray in rays(&mut random, &scene.view(), 500).iter().map(|ray| ray.with_mask(u32::MAX)) {
        let mut first: Option<Vec<SceneHit>> = None;
        for isa in isas() {
            let scene = scene.view().with_isa(isa);
            let mut seen = Vec::new();
            assert!(!scene.occluded_filtered(&ray, |hit| {
                seen.push(*hit);
                Verdict::Reject
            }));
            // The third one ends the search, if there are three.
            let mut count = 0;
            let stopped = scene.intersect_filtered(&ray, |_| {
                count += 1;
                if count == 3 { Verdict::Stop } else { Verdict::Reject }
            });
            assert_eq!(stopped.as_ref(), seen.get(2));
            if isa == crate::Isa::SCALAR {
                // Its order is that of the list.
                continue;
            }
            total += seen.len();
            assert_eq!(*first.get_or_insert_with(|| seen.clone()), seen);
            seen.sort_unstable_by_key(|hit| (hit.geometry_id, hit.hit.prim_id, hit.instances));
            assert!(seen.windows(2).all(|pair| bits(Some(pair[0])) != bits(Some(pair[1]))));
        }
    }
    assert!(total > 150, "{total}");
}

#[test]
fn empty_scenes_are_missed() {
    let (none, degenerate) = (bvh(&[]), bvh(&[[Vec3::ONE; 3]]));
    let spheres = [
        Sphere { center: Vec3::ZERO, radius: 0.0 },
        Sphere { center: Vec3::ZERO, radius: -1.0 },
        Sphere { center: Vec3::ZERO, radius: f32::NAN },
        Sphere { center: vec3(0.0, f32::NAN, 0.0), radius: 1.0 },
        Sphere { center: vec3(0.0, 1e13, 0.0), radius: 1.0 },
        Sphere { center: Vec3::ZERO, radius: f32::INFINITY },
    ];
    let quads = [[Vec3::ZERO, Vec3::X, Vec3::NAN, Vec3::Y], [Vec3::ZERO, Vec3::X, vec3(1.0, 1e20, 0.0), Vec3::Y]];
    let (spheres, quads, nothing) = (Spheres(&spheres), Quads(&quads), Spheres(&[]));
    let empty = scene(vec![]);
    let empty = empty.view();
    assert!(empty.bounds().is_empty());
    let place = Affine3A::from_rotation_x(1.0);
    let keys = [place, Affine3A::IDENTITY];
    let ray = SceneRay::new(Ray::new(Vec3::splat(0.1), Vec3::X));
    let items = vec![
        Item::new(none.view()),
        Item::new(degenerate.view()).placed(&place).unwrap(),
        Item::new(&spheres).moving(&keys).unwrap(),
        Item::new(&quads),
        Item::new(&nothing),
        Item::new(&empty).placed(&place).unwrap(),
    ];
    let (all, report) = Scene::build(items, &BuildOptions::default()).unwrap();
    assert_eq!((report.kept, report.degenerate, report.out_of_range), (0, 9, 2));
    for scene in [empty, all.view()] {
        assert_eq!(check(&scene, &[ray, ray.at_time(0.3), ray.with_mask(0)]), 0);
    }
}

#[test]
fn rays_beyond_the_limits_hit_nothing() {
    let sphere = [Sphere { center: Vec3::ZERO, radius: 1.0 }];
    let (spheres, mesh) = (Spheres(&sphere), bvh(&[[Vec3::NEG_ONE, Vec3::X, Vec3::Y]]));
    let shrink = Affine3A::from_scale(Vec3::splat(1e-3));
    let items = vec![
        Item::new(&spheres),
        Item::new(mesh.view()).placed(&shrink).unwrap(),
        Item::new(&spheres).placed(&shrink).unwrap(),
    ];
    let scene = scene(items);
    let good = Ray::new(Vec3::splat(3.0), Vec3::NEG_ONE);
    assert_eq!(check(&scene.view(), &[SceneRay::new(good)]), 1);
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let bad = [
        Ray { direction: Vec3::ZERO, ..good },
        Ray { direction: Vec3::splat(1e-40), ..good },
        Ray { direction: Vec3::splat(-1e30), ..good },
        Ray { direction: vec3(-1.0, nan, -1.0), ..good },
        Ray { direction: vec3(-1.0, -inf, -1.0), ..good },
        Ray { origin: vec3(nan, 0.0, 0.0), ..good },
        Ray { origin: Vec3::splat(5e12), ..good },
        Ray { t_min: 5.0, t_max: 1.0, ..good },
        Ray { t_min: nan, ..good },
        Ray { t_max: nan, ..good },
    ];
    let bad: Vec<_> = bad.map(SceneRay::new).into();
    assert_eq!(check(&scene.view(), &bad), 0);
    // Within the limits in the scene, but not in the small items.
    let far = Ray::between(Vec3::splat(1e11), Vec3::ZERO);
    let fast = Ray { direction: Vec3::splat(-5e14), ..good };
    for ray in [far, fast] {
        let found = scene.view().intersect(&Ray { t_max: inf, ..ray }.into());
        assert!(found.is_none_or(|found| found.geometry_id == 0), "{ray:?}");
        check(&scene.view(), &[ray.into()]);
    }
    let mut random = Random(41);
    let raw: Vec<_> = (0..20_000)
        .map(|i| {
            let mut raw = || f32::from_bits(random.bits() as u32);
            let origin = vec3(raw(), raw(), raw());
            let ray = Ray { origin, t_min: raw(), direction: vec3(raw(), raw(), raw()), t_max: raw() };
            let aimed = Ray { t_min: -inf, t_max: inf, direction: -origin, ..ray };
            let ray = if i % 2 == 0 { ray } else { aimed };
            SceneRay { ray, time: raw(), mask: u32::MAX }
        })
        .collect();
    assert!(check(&scene.view(), &raw) > 100);
}

#[test]
fn t_counts_in_lengths_of_the_direction() {
    let mut random = Random(42);
    let stock = Stock::new(&mut random);
    let (spheres, quads) = (Spheres(&stock.spheres), Quads(&stock.quads));
    let scene = scene(stock.items(&mut random, 12, (&spheres, &quads), &[]));
    let mut hits = 0;
    for ray in rays(&mut random, &scene.view(), 1000) {
        let Some(expected) = scene.view().intersect(&ray) else { continue };
        hits += 1;
        for scale in [0.125, 64.0, 1024.0] {
            let mut scaled = ray;
            scaled.ray.direction *= scale;
            scaled.ray.t_min /= scale;
            scaled.ray.t_max /= scale;
            let found = scene.view().intersect(&scaled).unwrap();
            let back = SceneHit { hit: Hit { t: found.hit.t * scale, ..found.hit }, ..found };
            assert_eq!(bits(Some(back)), bits(Some(expected)), "{ray:?}");
        }
    }
    assert!(hits > 80, "{hits}");
}

#[test]
fn scenes_nest_as_deep_as_hits_can_say() {
    let triangle = bvh(&[[vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(0.0, 1.0, 0.0)]]);
    let step = Affine3A::from_translation(vec3(0.0, 0.0, -1.0));
    let mut deepest: &SceneView =
        Box::leak(Box::new(Box::leak(Box::new(scene(vec![Item::new(triangle.view())]))).view()));
    let ray = SceneRay::new(Ray::new(vec3(0.0, 0.0, 2.0), Vec3::NEG_Z));
    for level in 1..=MAX_LEVELS {
        let items =
            vec![Item::new(deepest).placed(&step).unwrap().with_mask(2), Item::new(deepest).placed(&step).unwrap()];
        let view = Box::leak(Box::new(scene(items))).view();
        assert_eq!(view.levels(), level);
        let found = view.intersect(&ray.with_mask(1)).unwrap();
        assert_eq!((found.hit.t, found.geometry_id), (2.0 + level as f32, 0));
        let path: Vec<_> = (0..MAX_LEVELS).map(|i| if i < level { 1 } else { SceneHit::NO_INSTANCE }).collect();
        assert_eq!(found.instances[..], path);
        assert_eq!(view.to_scene(&found, 0.0), Some(Affine3A::from_translation(vec3(0.0, 0.0, -(level as f32)))));
        check(&view, &[ray, ray.with_mask(1), ray.with_mask(2)]);
        deepest = Box::leak(Box::new(view));
    }
    let error = Scene::build(vec![Item::new(deepest)], &BuildOptions::default()).err();
    let expected = InvalidScene::TooNested { item: 0, levels: MAX_LEVELS + 1, allowed: MAX_LEVELS };
    assert_eq!(error, Some(Error::InvalidScene(expected)));
}

#[test]
fn distortions_that_add_up_are_refused() {
    let sphere = [Sphere { center: Vec3::ZERO, radius: 1.0 }];
    let spheres = Spheres(&sphere);
    let flat = Affine3A::from_scale(vec3(1.0, 1e-4, 1.0));
    let inner = scene(vec![Item::new(&spheres).placed(&flat).unwrap()]);
    let inner = inner.view();
    let twice = Item::new(&inner).placed(&Affine3A::from_scale(vec3(1.0, 1.0, 1e-4))).unwrap();
    let error = Scene::build(vec![Item::new(&spheres), twice], &BuildOptions::default()).err();
    assert_eq!(error, Some(Error::InvalidScene(InvalidScene::Imprecise { item: 1 })));
}

#[test]
fn spheres_are_where_they_are() {
    let mut random = Random(43);
    let spheres: Vec<_> =
        (0..60).map(|_| Sphere { center: random.vector() * 4.0, radius: random.unit() + 0.01 }).collect();
    let shape = Spheres(&spheres);
    let scene = scene(vec![Item::new(&shape)]);
    let rays: Vec<_> = rays(&mut random, &scene.view(), 2000).iter().map(|ray| ray.with_mask(1)).collect();
    assert!(check(&scene.view(), &rays) > 500);
    for ray in rays {
        let Some(found) = scene.view().intersect(&ray) else { continue };
        let sphere = spheres[found.hit.prim_id as usize];
        let point = ray.ray.origin.as_dvec3() + ray.ray.direction.as_dvec3() * f64::from(found.hit.t);
        let off = (point - sphere.center.as_dvec3()).length() - f64::from(sphere.radius);
        let reach = f64::from((ray.ray.origin - sphere.center).length() + sphere.radius);
        assert!(off.abs() < 1e-6 * reach, "{ray:?} {off}");
        // None is nearer: no sphere's surface is crossed before.
        let before = SceneRay { ray: Ray { t_max: found.hit.t - found.hit.t.abs() * 1e-4, ..ray.ray }, ..ray };
        assert!(before.ray.t_max < ray.ray.t_min || !scene.view().occluded(&before));
    }
    // From inside, and beyond the first crossing.
    let one = Ray::new(vec3(0.0, 0.0, -3.0), Vec3::Z);
    let unit = [Sphere { center: Vec3::ZERO, radius: 1.0 }];
    let shape = Spheres(&unit);
    let scene = self::scene(vec![Item::new(&shape)]);
    let t = |ray: Ray| scene.view().intersect(&ray.into()).map(|found| found.hit.t);
    assert_eq!((t(one), t(Ray { t_min: 2.5, ..one }), t(Ray { t_min: 4.5, ..one })), (Some(2.0), Some(4.0), None));
    assert_eq!((t(Ray { t_max: 2.0, ..one }), t(Ray { t_max: 1.9, ..one })), (Some(2.0), None));
    assert_eq!(t(Ray::new(Vec3::ZERO, Vec3::X * 0.5)), Some(2.0));
}

#[test]
fn quads_are_their_two_triangles_without_a_seam() {
    let mut random = Random(44);
    let corners = [vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.5), vec3(1.0, 1.0, 0.0), vec3(-1.0, 1.0, -0.5)];
    let quads = [corners];
    let shape = Quads(&quads);
    let scene = scene(vec![Item::new(&shape)]);
    for i in 0..20_000 {
        // Along the diagonal, and anywhere.
        let (s, r) = (random.unit(), random.unit());
        let target = if i % 2 == 0 {
            corners[1].lerp(corners[3], s)
        } else {
            corners[0] + (corners[1] - corners[0]) * s + (corners[3] - corners[0]) * r
        };
        let origin = target + vec3(random.unit() - 0.5, random.unit() - 0.5, 2.0);
        let found = scene.view().intersect(&Ray::between(origin, target + (target - origin)).into());
        let inside = i % 2 == 0 || (s > 1e-3 && r > 1e-3 && s < 0.999 && r < 0.999);
        if inside {
            let found = found.unwrap_or_else(|| panic!("{target} is missed"));
            let at = corners[0] + (corners[1] - corners[0]) * found.hit.u + (corners[3] - corners[0]) * found.hit.v;
            // A parallelogram: the weights are those of the point.
            assert!((at - (origin + (target - origin) * 2.0 * found.hit.t)).length() < 1e-5);
        }
    }
}

#[test]
fn hits_are_found_from_the_way_to_them() {
    let mut random = Random(45);
    let stock = Stock::new(&mut random);
    let place = transform(&mut random);
    let inner = scene(vec![Item::new(stock.meshes[1].view()).moving(&stock.keys[1]).unwrap()]);
    let inner = inner.view();
    let outer = scene(vec![Item::new(&inner).placed(&place).unwrap()]);
    let mut hits = 0;
    for ray in rays(&mut random, &outer.view(), 500) {
        let Some(found) = outer.view().intersect(&ray) else { continue };
        hits += 1;
        let to_scene = outer.view().to_scene(&found, ray.time).unwrap();
        let triangle = stock.meshes[1]
            .view()
            .blocks()
            .iter()
            .flat_map(|block| (0..8).map(move |lane| (block.prim_id[lane], block.triangle(lane))))
            .find(|&(prim_id, _)| prim_id == found.hit.prim_id)
            .unwrap()
            .1
            .map(|p| to_scene.transform_point3(p));
        let (u, v) = (found.hit.u, found.hit.v);
        let point = triangle[0] * (1.0 - u - v) + triangle[1] * u + triangle[2] * v;
        let off = (point - ray.ray.at(found.hit.t)).length();
        assert!(off < 1e-5 * (ray.ray.origin.length() + 1.0), "{off}");
    }
    assert!(hits > 10, "{hits}");
    assert_eq!(outer.view().to_scene(&SceneHit::MISS, 0.0), None);
}

#[test]
fn scenes_from_memory_are_checked() {
    let mut random = Random(46);
    let stock = Stock::new(&mut random);
    let (spheres, quads) = (Spheres(&stock.spheres), Quads(&stock.quads));
    let built = scene(stock.items(&mut random, 12, (&spheres, &quads), &[]));
    let view = built.view();
    let tree = view.tree();
    let nodes: Vec<Node> = (0..tree.keys()).flat_map(|key| tree.nodes(key).to_vec()).collect();
    let (items, parts, numbers) = (view.items(), view.parts(), tree.items());
    let again = SceneView::new(items, parts, &nodes, numbers).unwrap();
    let rays = rays(&mut random, &view, 300);
    assert!(check(&again, &rays) > 10);
    let invalid = |nodes: &[Node], parts: &[Part], numbers: &[u32]| {
        matches!(SceneView::new(items, parts, nodes, numbers).err(), Some(Error::InvalidTree(_)))
    };
    let mut other = parts.to_vec();
    other[numbers[3] as usize].item = 12;
    assert!(invalid(&nodes, &other, numbers));
    let mut other = parts.to_vec();
    other[numbers[3] as usize].prim_id = 1 << 20;
    assert!(invalid(&nodes, &other, numbers));
    assert!(invalid(&nodes, &parts[..parts.len() / 2], numbers));
    assert!(invalid(&nodes, parts, &numbers[1..]));
    assert!(invalid(&nodes[..tree.nodes(0).len()], parts, numbers) == (tree.keys() > 1));
    let mut other = nodes.clone();
    other[0].planes[1][0][0] += 0.5;
    assert!(invalid(&other, parts, numbers));
}

#[test]
fn moving_trees_from_memory_are_checked() {
    let mut random = Random(47);
    let keys = [soup(&mut random, 50, 0.3), soup(&mut random, 50, 0.3)];
    let tree = moving(&keys);
    let view = tree.view();
    let nodes: Vec<_> = (0..2).flat_map(|key| view.nodes(key).to_vec()).collect();
    let blocks: Vec<_> = (0..2).flat_map(|key| view.blocks(key).to_vec()).collect();
    let check = |nodes: &[_], blocks: &[_], keys| crate::bvh::MovingView::new(nodes, blocks, keys).err();
    assert_eq!(check(&nodes, &blocks, 2), None);
    let bad_keys = |keys| Some(Error::InvalidTree(InvalidTree::BadKeys { keys }));
    assert_eq!((check(&nodes, &blocks, 0), check(&[], &[], 1)), (bad_keys(0), bad_keys(1)));
    assert_eq!(check(&nodes[1..], &blocks, 2), bad_keys(2));
    let mut other = blocks.clone();
    other[0].prim_id.swap(0, 1);
    assert_eq!(check(&nodes, &other, 2), bad_keys(2));
    let mut other = blocks.clone();
    other.last_mut().unwrap().corners[0][0][0] = 99.0;
    assert!(check(&nodes, &other, 2).is_some());
    // Keys of one length, one at least; degenerate at one key is not degenerate.
    let build = |keys: &[&[Triangle]]| MovingBvh::build(keys, &Quality::Fast.into());
    assert_eq!(build(&[]).err(), bad_keys(0));
    assert_eq!(build(&[&keys[0], &keys[1][1..]]).err(), bad_keys(2));
    let (mut from, mut to) = (keys[0].clone(), keys[1].clone());
    from[3] = [Vec3::ONE; 3];
    (from[4], to[4]) = ([Vec3::ONE, Vec3::ONE, Vec3::X], [Vec3::Y, Vec3::Y, Vec3::Z]);
    to[5][1].y = f32::NAN;
    let (_, report) = build(&[&from, &to]).unwrap();
    assert_eq!((report.kept, report.degenerate, report.out_of_range), (48, 1, 1));
}
