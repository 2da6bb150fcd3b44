//! Motion, at keys and between them.

use super::*;

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
