//! Scenes that change, against scenes that are built anew.

use alloc::sync::Arc;

use super::*;
use crate::{Executor, Isa, Serial};

/// Two threads at every turn.
struct Threads;

impl Executor for Threads {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        std::thread::scope(|scope| {
            let b = scope.spawn(b);
            (a(), b.join().unwrap())
        })
    }
}

fn assert_engine_can_hold<T: Send + Sync + 'static>(_: &T) {}

fn ball(random: &mut Random, count: usize) -> Arc<Bvh> {
    Arc::new(bvh(&soup(random, count, 0.5)))
}

/// What the scene should be: the same items at the same indices, built at once.
fn rebuilt<'s>(changed: &'s Scene) -> Scene<'s> {
    let items = changed.view().items().to_vec();
    Scene::build(items, &BuildOptions::default()).unwrap().0
}

/// Panics unless a changed scene has the hits of one built anew, to the bit and on every instruction set.
fn assert_same_hits(changed: &SceneView, fresh: &SceneView, rays: &[SceneRay]) {
    let bits = |scene: SceneView| bytemuck::cast_slice::<_, u32>(&hits(&scene, rays)).to_vec();
    for isa in isas() {
        assert!(bits(changed.with_isa(isa)) == bits(fresh.with_isa(Isa::SCALAR)), "{}", isa.level());
    }
}

fn hits(scene: &SceneView, rays: &[SceneRay]) -> Vec<SceneHit> {
    let mut hits = vec![SceneHit::MISS; rays.len()];
    scene.intersect_many(rays, &mut hits);
    hits
}

#[test]
fn changed_scenes_equal_scenes_built_anew() {
    let mut random = Random(51);
    let meshes = [ball(&mut random, 1), ball(&mut random, 12), ball(&mut random, 60)];
    let first = transform(&mut random);
    let keys: Arc<[Affine3A]> = [first, shaken(&mut random, &first, 0.5)].into();
    let inner = Arc::new(
        Scene::build(vec![Item::new(meshes[1].clone()), Item::new(meshes[2].clone())], &BuildOptions::default())
            .unwrap()
            .0,
    );
    let spheres: &'static [Sphere] =
        vec![Sphere { center: Vec3::ZERO, radius: 0.7 }, Sphere { center: Vec3::X, radius: 0.4 }].leak();
    let shape: Arc<dyn Shape + Send> = Arc::new(Spheres(spheres));
    let mut scene: Scene<'static> = Scene::default();
    assert_engine_can_hold(&scene);
    let mut removed = Vec::new();
    let (mut fits, mut builds, mut found) = (0, 0, 0);
    for round in 0..60 {
        let handles: Vec<_> = scene.handles().collect();
        for change in 0..1 + random.bits() as usize % 12 {
            let pick = random.bits() as usize;
            let mesh = meshes[pick % 3].clone();
            // Rounds in which nothing is inserted are many.
            let Some(&handle) = handles.get(pick / 3 % (handles.len() + 1)).filter(|_| round % 4 != 0) else {
                if round % 4 == 0 || handles.is_empty() {
                    let item = match (pick / 8 % 5, change) {
                        (0, 0) => Item::new(inner.clone()),
                        (1, 0) => Item::new(shape.clone()),
                        _ => Item::new(mesh),
                    };
                    let moving = item.clone().moving_shared(keys.clone());
                    let still = item.placed(&transform(&mut random)).unwrap();
                    let is_moving = round > 30 && (pick / 64).is_multiple_of(4);
                    scene.insert(if is_moving { moving.unwrap() } else { still }).unwrap();
                }
                continue;
            };
            let result = match pick / 64 % 8 {
                0 => scene.remove(handle),
                1 => scene.set_mask(handle, [0, 1, 2, u32::MAX][pick / 512 % 4]),
                2 => scene.set_object(handle, mesh),
                3 => scene.set_transform(handle, &Affine3A::from_scale(Vec3::ZERO)),
                4 => scene.set_item(handle, Item::new(inner.clone()).placed(&transform(&mut random)).unwrap()),
                _ => scene.set_transform(handle, &transform(&mut random)),
            };
            if removed.contains(&handle) {
                assert!(matches!(result, Err(Error::InvalidScene(InvalidScene::NoSuchItem { .. }))));
            } else {
                assert_eq!(result, Ok(()));
                if (pick / 64).is_multiple_of(8) {
                    removed.push(handle);
                }
            }
        }
        let commit = if round % 2 == 0 { scene.commit_on(&Threads) } else { scene.commit() }.unwrap();
        assert!(scene.is_committed());
        if commit.is_rebuilt {
            builds += 1
        } else {
            fits += 1
        }
        let fresh = rebuilt(&scene);
        let rays = rays(&mut random, &fresh.view(), fewer(120));
        found += check(&scene.view(), &rays);
        assert_same_hits(&scene.view(), &fresh.view(), &rays);
        assert_eq!(scene.view().bounds(), fresh.view().bounds());
        for hit in hits(&scene.view(), &rays).iter().filter(|hit| hit.is_hit() && hit.depth == 0) {
            let handle = scene.handle(hit.item).unwrap();
            assert!(handle.index() == hit.item && scene.get(handle).is_some() && !removed.contains(&handle));
        }
    }
    assert!(fits > 15 && builds > 10 && found > fewer(500), "{fits} {builds} {found}");
}

#[test]
fn a_forgotten_commit_leaves_the_scene_as_it_was() {
    let mut random = Random(52);
    let mesh = ball(&mut random, 40);
    let mut scene = Scene::default();
    let mut placed = || Item::new(mesh.clone()).placed(&transform(&mut random)).unwrap();
    let handles: Vec<_> = (0..20).map(|_| scene.insert(placed()).unwrap()).collect();
    let rays = {
        let fresh =
            Scene::build(handles.iter().map(|&h| scene.get(h).unwrap().clone()).collect(), &BuildOptions::default())
                .unwrap()
                .0;
        rays(&mut random, &fresh.view(), 300)
    };
    assert!(hits(&scene.view(), &rays).iter().all(|hit| !hit.is_hit()) && !scene.is_committed());
    scene.commit().unwrap();
    let before = hits(&scene.view(), &rays);
    assert!(before.iter().filter(|hit| hit.is_hit()).count() > 20);
    for (i, &handle) in handles.iter().enumerate() {
        match i % 4 {
            0 => scene.remove(handle).unwrap(),
            1 => scene.set_mask(handle, 0).unwrap(),
            2 => scene.set_transform(handle, &Affine3A::from_translation(Vec3::splat(1e4))).unwrap(),
            _ => scene.set_object(handle, ball(&mut random, 3)).unwrap(),
        }
    }
    let new = scene.insert(Item::new(mesh.clone())).unwrap();
    // What leaves is still seen, so its place is not yet free.
    assert_eq!(new.index(), 20);
    assert_eq!((hits(&scene.view(), &rays), scene.is_committed()), (before.clone(), false));
    assert_eq!(scene.handle(0), None);
    let commit = scene.commit().unwrap();
    assert_eq!((commit.changed, commit.seen), (21, 16));
    assert_ne!(hits(&scene.view(), &rays), before);
    assert_same_hits(&scene.view(), &rebuilt(&scene).view(), &rays);
    // Nothing to do: nothing is done.
    assert_eq!(scene.commit().unwrap(), Commit { changed: 0, is_rebuilt: false, ..commit });
}

#[test]
fn what_cannot_be_is_refused_and_nothing_is_lost() {
    let mut random = Random(53);
    let mesh = ball(&mut random, 40);
    let mut scene = Scene::default();
    let first = scene.insert(Item::new(mesh.clone())).unwrap();
    let second = scene.insert(Item::new(mesh.clone())).unwrap();
    scene.commit().unwrap();
    let rays = rays(&mut random, &scene.view(), 200);
    let before = hits(&scene.view(), &rays);
    let nan = Affine3A::from_translation(vec3(f32::NAN, 0.0, 0.0));
    let thin = Affine3A::from_scale(vec3(1.0, 1e-5, 1.0));
    assert_eq!(scene.set_transform(first, &nan), Err(InvalidScene::NotFinite { key: 0 }.into()));
    assert_eq!(scene.set_transform(first, &thin), Err(InvalidScene::Singular { key: 0 }.into()));
    assert!(scene.is_committed());
    scene.remove(second).unwrap();
    let gone = Err(InvalidScene::NoSuchItem { index: 1, generation: 0 }.into());
    for result in [
        scene.remove(second),
        scene.set_mask(second, 1),
        scene.set_transform(second, &Affine3A::IDENTITY),
        scene.set_object(second, mesh.clone()),
        scene.set_item(second, Item::nothing()),
    ] {
        assert_eq!(result, gone);
    }
    assert!(scene.get(second).is_none());
    scene.commit().unwrap();
    // Its place is used again, by another name.
    let third = scene.insert(Item::new(mesh.clone())).unwrap();
    assert_eq!((third.index(), third.generation()), (1, 1));
    assert_eq!(scene.set_mask(second, 1), gone);
    scene.commit().unwrap();
    assert_eq!(hits(&scene.view(), &rays), before);
    // Distorted a little at each of many levels: too much in all.
    let stretch = Affine3A::from_scale(vec3(1.0, 1.0, 2e-3));
    let nest = |inner: Arc<Scene<'static>>| {
        let item = Item::new(inner).placed(&stretch).unwrap();
        Scene::build(vec![item], &BuildOptions::default()).map(|(scene, _)| Arc::new(scene))
    };
    let mut deep = Arc::new(Scene::build(vec![Item::new(mesh.clone())], &BuildOptions::default()).unwrap().0);
    while let Ok(deeper) = nest(deep.clone()) {
        deep = deeper;
    }
    scene.set_item(third, Item::new(deep).placed(&stretch).unwrap()).unwrap();
    scene.set_mask(first, 6).unwrap();
    let staged = scene.get(third).unwrap().mask();
    assert_eq!(scene.commit(), Err(InvalidScene::Imprecise { item: 1 }.into()));
    assert!(!scene.is_committed() && scene.get(third).unwrap().mask() == staged);
    assert_eq!(hits(&scene.view(), &rays), before);
    scene.set_item(third, Item::new(mesh.clone())).unwrap();
    scene.commit().unwrap();
    let seeing: Vec<_> = rays.iter().map(|ray| ray.with_mask(2)).collect();
    assert_eq!(check(&scene.view(), &seeing), before.iter().filter(|hit| hit.is_hit()).count());
}

#[test]
fn what_is_flat_or_far_is_hidden_until_it_comes_back() {
    let mut random = Random(54);
    let mesh = ball(&mut random, 40);
    let mut scene = Scene::default();
    let handle = scene.insert(Item::new(mesh.clone())).unwrap();
    let other =
        scene.insert(Item::new(mesh.clone()).placed(&Affine3A::from_translation(Vec3::splat(9.0))).unwrap()).unwrap();
    scene.commit().unwrap();
    let rays = rays(&mut random, &Scene::build(vec![Item::new(mesh)], &BuildOptions::default()).unwrap().0.view(), 300);
    let before = hits(&scene.view(), &rays);
    let of_first = |hits: &[SceneHit]| hits.iter().filter(|hit| hit.item == 0).count();
    assert!(of_first(&before) > 20);
    for hidden in [Affine3A::from_scale(Vec3::ZERO), Affine3A::from_translation(Vec3::X * 1e13)] {
        scene.set_transform(handle, &hidden).unwrap();
        assert_eq!(scene.commit().unwrap().seen, 1);
        assert_eq!(of_first(&hits(&scene.view(), &rays)), 0);
        check(&scene.view(), &rays);
        scene.set_transform(handle, &Affine3A::IDENTITY).unwrap();
        assert_eq!(scene.commit().unwrap().seen, 2);
        assert_eq!(hits(&scene.view(), &rays), before);
    }
    // Hidden when it is built, and so not in the tree.
    scene.set_transform(handle, &Affine3A::from_scale(Vec3::ZERO)).unwrap();
    scene.insert(Item::nothing()).unwrap();
    scene.commit().unwrap();
    let mut again = scene.clone();
    again.set_transform(handle, &Affine3A::IDENTITY).unwrap();
    assert_eq!(again.commit().unwrap().seen, 2);
    assert_eq!(hits(&again.view(), &rays), before);
    // The copy's changes are its own.
    assert_eq!(of_first(&hits(&scene.view(), &rays)), 0);
    scene.remove(other).unwrap();
    assert!(scene.commit().unwrap().seen == 0 && scene.view().bounds().is_empty());
}

#[test]
fn threads_do_not_change_the_tree() {
    let mut random = Random(55);
    let mesh = ball(&mut random, 3);
    let (mut one, mut two) = (Scene::default(), Scene::default());
    let handles: Vec<_> = (0..9000)
        .map(|_| {
            let place = Affine3A::from_translation(random.vector() * 300.0);
            let item = Item::new(mesh.clone()).placed(&place).unwrap();
            two.insert(item.clone()).unwrap();
            one.insert(item).unwrap()
        })
        .collect();
    let bits = |scene: &Scene| bytemuck::cast_slice::<_, u32>(scene.view().tree().nodes(0)).to_vec();
    assert_eq!(one.commit_on(&Serial), two.commit_on(&Threads));
    assert!(bits(&one) == bits(&two));
    for handle in handles {
        let moved = Affine3A::from_translation(Vec3::from(scene_translation(&one, handle)) + random.vector());
        one.set_transform(handle, &moved).unwrap();
        two.set_transform(handle, &moved).unwrap();
    }
    let commits = (one.commit_on(&Serial).unwrap(), two.commit_on(&Threads).unwrap());
    assert!(commits.0 == commits.1 && !commits.0.is_rebuilt);
    assert!(bits(&one) == bits(&two) && bits(&one).len() > 64 * 2100);
    let rays = rays(&mut random, &one.view(), fewer(20));
    check(&one.view(), &rays);
}

fn scene_translation(scene: &Scene, handle: Handle) -> glam::Vec3A {
    scene.get(handle).unwrap().to_scene(0.0).unwrap().translation
}
