//! Spheres and quads, lengths, and the path to a hit.

use super::*;

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
