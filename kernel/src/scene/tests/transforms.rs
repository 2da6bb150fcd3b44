//! Instances against triangles that were transformed beforehand, and against `f64`.

use super::*;

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
        for i in 0..fewer(2000) {
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
        assert!(hits > fewer(800), "{stretch} {shift}: {hits}");
    }
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
    for i in 0..fewer(3000) {
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
        let instance = instances(&outer.view(), &found)[0];
        let flat_id = (instance * places.len() as u32 + found.item) * 80 + found.hit.prim_id;
        let again = crate::geometry::intersect_triangle(&ray, &flat[flat_id as usize]).unwrap();
        assert!((found.hit.t - expected.t).abs() <= 4.0 * f32::EPSILON * expected.t.abs(), "{ray:?}");
        if places[instance as usize].matrix3.x_axis.x != 0.0 && places[found.item as usize].matrix3.x_axis.x != 0.0 {
            // No axes exchanged: equal bit for bit.
            let bits = |hit: Hit| [hit.t, hit.u, hit.v].map(f32::to_bits);
            assert_eq!(bits(found.hit), bits(again), "{ray:?}");
        }
    }
    assert!(hits > fewer(1000), "{hits}");
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
            let [a, b, c] = flat[found.item as usize * 25 + found.hit.prim_id as usize];
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
