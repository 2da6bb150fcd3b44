//! Empty scenes, scenes beyond the limits, and scenes from arbitrary memory.

use alloc::sync::Arc;

use super::*;

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
        assert!(found.is_none_or(|found| found.item == 0), "{ray:?}");
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

/// A scene with two items: `inner` moved down by one, in two copies of which the first is seen through mask 2 alone.
fn pair_of(inner: &'static SceneView<'static>) -> &'static SceneView<'static> {
    let item = Item::new(inner).placed(&Affine3A::from_translation(Vec3::NEG_Z)).unwrap();
    Box::leak(Box::new(Box::leak(Box::new(scene(vec![item.clone().with_mask(2), item]))).view()))
}

#[test]
fn scenes_nest_until_paths_have_no_numbers() {
    let triangle: &Bvh = Box::leak(Box::new(bvh(&[[Vec3::NEG_ONE, vec3(1.0, -1.0, -1.0), vec3(0.0, 1.0, -1.0)]])));
    let mut deepest: &SceneView =
        Box::leak(Box::new(Box::leak(Box::new(scene(vec![Item::new(triangle.view())]))).view()));
    let ray = SceneRay::new(Ray::new(vec3(0.0, 0.0, 1.0), Vec3::NEG_Z));
    // Each level doubles the paths and adds its own: 2^(level + 1) - 1 of them.
    for level in 1..=63 {
        deepest = pair_of(deepest);
        assert_eq!(deepest.levels(), level);
        let found = deepest.intersect(&ray.with_mask(1)).unwrap();
        assert_eq!((found.hit.t, found.item, found.depth), (2.0 + level as f32, 0, level as u32));
        assert_eq!(instances(deepest, &found), vec![1; level]);
        let moved = Affine3A::from_translation(vec3(0.0, 0.0, -(level as f32)));
        assert_eq!(deepest.to_scene(&found, 0.0), Some(moved));
        if level < 9 {
            check(deepest, &[ray, ray.with_mask(1), ray.with_mask(2)]);
        }
    }
    for nowhere in [SceneHit::MISS, SceneHit { path: u64::MAX, ..deepest.intersect(&ray.with_mask(1)).unwrap() }] {
        assert_eq!((instances(deepest, &nowhere), deepest.to_scene(&nowhere, 0.0)), (vec![], None));
    }
    let error = Scene::build(vec![Item::new(deepest), Item::new(deepest)], &BuildOptions::default()).err();
    assert_eq!(error, Some(Error::InvalidScene(InvalidScene::TooManyPaths { item: 0 })));
}

#[test]
fn scenes_nest_no_deeper_than_the_stack() {
    let mut deepest = Arc::new(Scene::build(Vec::new(), &BuildOptions::default()).unwrap().0);
    for level in 1..=MAX_LEVELS {
        deepest = Arc::new(Scene::build(vec![Item::new(deepest)], &BuildOptions::default()).unwrap().0);
        assert_eq!(deepest.view().levels(), level);
    }
    let bytes = deepest.to_bytes().unwrap();
    assert_eq!(Scene::from_bytes(&bytes).unwrap().view().levels(), MAX_LEVELS);
    let error = Scene::build(vec![Item::new(deepest)], &BuildOptions::default()).err();
    assert_eq!(error, Some(Error::InvalidScene(InvalidScene::TooDeep { item: 0 })));
}

#[test]
fn paths_are_told_apart_among_items_of_all_kinds() {
    let triangle = bvh(&[[Vec3::NEG_ONE, vec3(1.0, -1.0, -1.0), vec3(0.0, 1.0, -1.0)]]);
    fn at<'a>(x: f32, item: &Item<'a>) -> Item<'a> {
        item.clone().placed(&Affine3A::from_translation(Vec3::X * x)).unwrap()
    }
    let mesh = Item::new(triangle.view());
    let (leaf, empty) = (scene(vec![mesh.clone(), at(4.0, &mesh)]), scene(vec![]));
    let (leaf, empty) = (leaf.view(), empty.view());
    let (leaf, empty) = (Item::new(&leaf), Item::new(&empty));
    let branch = scene(vec![empty.clone(), at(8.0, &mesh), at(12.0, &leaf), empty.clone()]);
    let branch = branch.view();
    let root = scene(vec![leaf, at(40.0, &mesh), empty, Item::new(&branch), at(44.0, &mesh)]);
    let root = root.view();
    let paths: [(f32, &[u32]); 7] =
        [(0.0, &[0]), (4.0, &[0]), (40.0, &[]), (8.0, &[3]), (12.0, &[3, 2]), (16.0, &[3, 2]), (44.0, &[])];
    for (x, path) in paths {
        let found = root.intersect(&SceneRay::new(Ray::new(vec3(x, 0.0, 1.0), Vec3::NEG_Z))).unwrap();
        assert_eq!((&instances(&root, &found)[..], found.depth as usize), (path, path.len()), "{x}");
    }
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
fn scenes_from_memory_are_checked() {
    let mut random = Random(46);
    let stock = Stock::new(&mut random);
    let (spheres, quads) = (Spheres(&stock.spheres), Quads(&stock.quads));
    let built = scene(stock.items(&mut random, 12, (&spheres, &quads), &[]));
    let view = built.view();
    let tree = view.tree();
    let nodes: Vec<Node> = (0..tree.keys()).flat_map(|key| tree.nodes(key).to_vec()).collect();
    let (parts, numbers) = (view.parts(), tree.items());
    let mut items = view.items().to_vec();
    let again = SceneView::new(&mut items, parts, &nodes, numbers).unwrap();
    let rays = rays(&mut random, &view, 300);
    assert!(check(&again, &rays) > 10);
    let invalid = |nodes: &[Node], parts: &[Part], numbers: &[u32]| {
        let mut items = view.items().to_vec();
        matches!(SceneView::new(&mut items, parts, nodes, numbers).err(), Some(Error::InvalidTree(_)))
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
    let check = |nodes: &[_], blocks: &[_], keys| crate::bvh::MovingBvhView::new(nodes, blocks, keys).err();
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
