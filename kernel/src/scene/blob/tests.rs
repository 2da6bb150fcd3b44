//! Scenes are read back from their blobs unchanged; invalid blobs give their errors.

mod damaged;

use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;
use core::mem::discriminant;

use glam::{Quat, Vec3, vec3};

use super::*;
use crate::bvh::blob_header::checksum;
use crate::bvh::{Blob, Child, MovingBvh};
use crate::error::InvalidTree;
use crate::scene::object::Target;
use crate::scene::{Scene, Spheres};
use crate::traverse::tests::{Random, soup};
use crate::{
    BuildOptions, Bvh, CubicCurve, Disc, LinearCurve, Quality, Ray, RoundBvh, SceneHit, SceneRay, Sphere, Triangle,
};

fn bvh(count: usize, seed: u64) -> Arc<Bvh> {
    Arc::new(Bvh::build(&soup(&mut Random(seed), count, 0.5), &BuildOptions::default()).unwrap().0)
}

fn build(items: Vec<Item>) -> Scene {
    Scene::build(items, &BuildOptions::default()).unwrap().0
}

/// A place on a grid.
fn at(i: usize) -> Affine3A {
    Affine3A::from_translation(vec3((i % 5) as f32, (i / 5) as f32, 0.0) * 3.0)
}

/// One mesh three times: as it is, turned and larger, and moving.
fn inner() -> Scene<'static> {
    let mesh = bvh(12, 1);
    let turned = Affine3A::from_scale_rotation_translation(Vec3::splat(1.5), Quat::from_rotation_x(1.0), Vec3::Y);
    let keys: Arc<[Affine3A]> = [at(1), at(2), at(7)].into();
    let items = vec![
        Item::new(mesh.clone()),
        Item::new(mesh.clone()).placed(&turned).unwrap().with_mask(2),
        Item::new(mesh).moving_shared(keys).unwrap(),
    ];
    Scene::build(items, &Quality::Fast.into()).unwrap().0
}

/// Everything that can be saved: meshes, one that deforms, nothing, what is flat, a scene three times, points and
/// curves.
fn town() -> Scene<'static> {
    let mut random = Random(3);
    let from = soup(&mut random, 9, 0.5);
    let to: Vec<Triangle> = from.iter().map(|corners| corners.map(|corner| corner * 1.5 + Vec3::Z)).collect();
    let deforms = Arc::new(MovingBvh::build(&[&from, &to], &BuildOptions::default()).unwrap().0);
    let inner = Arc::new(inner());
    let mut sphere = || Sphere::new(random.vector(), 0.3);
    let spheres: Vec<Sphere> = (0..20).map(|_| sphere()).collect();
    let curves: Vec<CubicCurve> = (0..3).map(|_| CubicCurve { controls: [(); 4].map(|()| sphere()) }).collect();
    let spheres = Arc::new(RoundBvh::build(&spheres, &BuildOptions::default()).unwrap().0);
    let curves = Arc::new(RoundBvh::build(&curves, &BuildOptions::default()).unwrap().0);
    let items = vec![
        Item::new(inner.clone()).placed(&at(10)).unwrap(),
        Item::nothing(),
        Item::new(bvh(20, 2)).with_mask(6),
        Item::new(inner.clone()),
        Item::new(deforms).placed(&at(3)).unwrap(),
        Item::new(inner).placed(&Affine3A::from_scale(vec3(1.0, 0.0, 1.0))).unwrap(),
        Item::new(spheres).placed(&at(12)).unwrap(),
        Item::new(curves).placed(&at(13)).unwrap(),
    ];
    Scene::build(items, &Quality::Medium.into()).unwrap().0
}

fn rays(count: usize) -> Vec<SceneRay> {
    let mut random = Random(5);
    let count = if cfg!(miri) { 20 } else { count };
    let ray = |i: usize| {
        let cell = Vec3::from(at(random.bits() as usize % 15).translation);
        let target = cell + random.vector() * 0.6;
        let origin = target + random.vector() * 5.0 + Vec3::Z * 6.0;
        let ray = SceneRay::new(Ray::new(origin, target - origin)).at_time(random.unit());
        if i.is_multiple_of(3) { ray.with_mask(1 << (i % 4)) } else { ray }
    };
    (0..count).map(ray).collect()
}

fn bits(hit: Option<SceneHit>) -> Option<[u32; 8]> {
    hit.map(bytemuck::cast)
}

/// What `look` says of the scene in a blob of one or two scenes, traced in place.
fn in_place<T>(bytes: &[u8], look: impl FnOnce(&SceneView) -> T) -> Result<T, Error> {
    let blob = SceneBlob::open(bytes)?;
    let mut items = vec![Item::nothing(); blob.item_count(0).unwrap()];
    let first = blob.view(0, &mut items, &[])?;
    if blob.scene_count() == 1 {
        return Ok(look(&first));
    }
    let inner = [first];
    let mut items = vec![Item::nothing(); blob.item_count(1).unwrap()];
    Ok(look(&blob.view(1, &mut items, &inner)?))
}

#[test]
fn scenes_come_back_as_they_were() {
    let rays = rays(800);
    for scene in [inner(), town(), Scene::default()] {
        let blob = scene.to_bytes().unwrap();
        let loaded = Scene::from_bytes(&blob).unwrap();
        assert_eq!(loaded.to_bytes().unwrap(), blob);
        let over = Scene::over_bytes(&blob).unwrap();
        assert_eq!(over.to_bytes().unwrap(), blob);
        let mut found = 0;
        let check = |other: &SceneView| {
            assert_eq!((other.bounds(), other.levels()), (scene.view().bounds(), scene.view().levels()));
            assert_eq!(other.to_bytes(&scene.options()).unwrap(), blob);
            for ray in &rays {
                let hit = scene.view().intersect(ray);
                assert_eq!(bits(other.intersect(ray)), bits(hit));
                assert_eq!(other.occluded(ray), hit.is_some());
                if let Some(hit) = hit {
                    found += 1;
                    let [ours, theirs] = [&scene.view(), other].map(|view| view.to_scene(&hit, ray.time));
                    assert_eq!(ours, theirs);
                }
            }
        };
        in_place(&blob, check).unwrap();
        assert!(found > 20 || scene.handles().next().is_none() || cfg!(miri), "{found}");
        for ray in &rays {
            assert_eq!(bits(loaded.view().intersect(ray)), bits(scene.view().intersect(ray)));
            assert_eq!(bits(over.view().intersect(ray)), bits(scene.view().intersect(ray)));
        }
    }
}

/// Meshes, points and curves are of the kind that they were, in the blob once, and not copied out of it.
#[test]
fn what_items_have_stays_where_the_blob_is() {
    let center = Sphere::new(Vec3::ZERO, 1.0);
    let round = [
        RoundBvh::build(&[center], &BuildOptions::default()),
        RoundBvh::build(&[Disc { center: Vec3::ZERO, radius: 1.0, normal: Vec3::Z }], &BuildOptions::default()),
        RoundBvh::build(&[LinearCurve { ends: [center; 2] }], &BuildOptions::default()),
        RoundBvh::build(&[CubicCurve { controls: [center; 4] }], &BuildOptions::default()),
    ]
    .map(|built| built.unwrap().0);
    let mut items = vec![Item::new(bvh(20, 2))];
    items
        .extend(round.iter().flat_map(|tree| [Item::new(tree.view()), Item::new(tree.view()).placed(&at(4)).unwrap()]));
    let blob = build(items).to_bytes().unwrap();
    let header: Header = bytemuck::pod_read_unaligned(&blob[..HEADER]);
    assert_eq!((header.meshes, header.block_parts), (5, 5 + 8 + 9 + 17));
    let over = Scene::over_bytes(&blob).unwrap();
    for (index, item) in over.view().items().iter().enumerate() {
        let nodes = match item.object.target() {
            Target::Mesh(tree) if index == 0 => tree.nodes(),
            Target::Round(tree) => {
                let blocks = round[(index - 1) / 2].view().blocks();
                assert_eq!(discriminant(&tree.blocks()), discriminant(&blocks), "item {index}");
                tree.nodes()
            }
            _ => panic!("item {index} has become another"),
        };
        assert!(blob.as_ptr_range().contains(&nodes.as_ptr().cast()));
    }
}

#[test]
fn a_loaded_scene_goes_on() {
    let mut scene = Scene::from_bytes(&inner().to_bytes().unwrap()).unwrap();
    assert_eq!(scene.options().quality, Quality::Fast);
    let handles: Vec<_> = scene.handles().collect();
    assert_eq!(handles.len(), 3);
    scene.remove(handles[1]).unwrap();
    scene.set_transform(handles[0], &at(20)).unwrap();
    scene.commit().unwrap();
    assert!(scene.view().bounds().max.y > 11.0);
}

/// Bytes depend on what a scene is, not on how it came to be.
#[test]
fn the_way_there_does_not_matter() {
    let mesh = bvh(12, 1);
    let item = |i: usize| Item::new(mesh.clone()).placed(&at(i)).unwrap();
    let options = BuildOptions::default();
    let mut items: Vec<Item> = (0..20).map(item).collect();
    let mut scene = Scene::build((0..20).map(|i| item(19 - i)).collect(), &options).unwrap().0;
    let handles: Vec<_> = scene.handles().collect();
    for (i, &handle) in handles.iter().enumerate() {
        scene.set_transform(handle, &at(i)).unwrap();
    }
    scene.commit().unwrap();
    scene.remove(handles[7]).unwrap();
    scene.commit().unwrap();
    items[7] = Item::nothing();
    let built = Scene::build(items, &options).unwrap().0.to_bytes().unwrap();
    let changed = scene.to_bytes().unwrap();
    assert_eq!(changed, built);
    // What was not committed is not there.
    scene.set_mask(handles[0], 0).unwrap();
    assert_eq!(scene.to_bytes().unwrap(), built);
    // One mesh, however many items: of each of them a transform, a record and a part.
    let mesh_bytes = mesh.statistics().memory_bytes;
    assert!(built.len() < mesh_bytes + 20 * 120 + 5000, "{} of {mesh_bytes}", built.len());
}

#[test]
fn shapes_of_the_callers_are_named() {
    let shapes = Spheres(&[]);
    let mesh = bvh(2, 1);
    let inside = build(vec![Item::new(mesh.clone()), Item::new(mesh.clone()), Item::new(&shapes)]);
    assert_eq!(inside.to_bytes().err(), Some(InvalidScene::NotSerializable { item: 2, depth: 0 }.into()));
    let view = inside.view();
    let outside = build(vec![Item::new(mesh), Item::new(&view)]);
    let error = outside.to_bytes().unwrap_err();
    assert_eq!(error, InvalidScene::NotSerializable { item: 2, depth: 1 }.into());
    let said = alloc::format!("{error}");
    assert_eq!(
        said,
        "item 2 is a custom shape, which cannot be written as bytes; it is in a scene nested in the scene"
    );
}

#[test]
fn too_little_memory_is_told() {
    let blob = inner().to_bytes().unwrap();
    let mut items = vec![Item::nothing(); 2];
    let error = SceneView::from_bytes(&blob, &mut items).err();
    assert_eq!(error, Some(InvalidScene::BufferTooSmall { what: "items", needed: 3, given: 2 }.into()));
    // More than needed is as good.
    let mut items = vec![Item::nothing(); 9];
    assert_eq!(SceneView::from_bytes(&blob, &mut items).unwrap().items().len(), 3);
    let blob = town().to_bytes().unwrap();
    let mut items = vec![Item::nothing(); 9];
    let error = SceneView::from_bytes(&blob, &mut items).err();
    assert_eq!(error, Some(InvalidScene::BufferTooSmall { what: "scenes", needed: 1, given: 0 }.into()));
    let blob = SceneBlob::open(&blob).unwrap();
    let error = blob.view(2, &mut items, &[]).err();
    assert_eq!(error, Some(InvalidScene::BufferTooSmall { what: "scenes", needed: 3, given: 2 }.into()));
    assert_eq!((blob.item_count(1), blob.item_count(2)), (Some(8), None));
}

#[test]
fn where_it_cannot_be_traced_it_can_be_loaded() {
    let blob = town().to_bytes().unwrap();
    let mut bytes = vec![0; blob.len() + 2 * BLOB_ALIGNMENT];
    let start = bytes.as_ptr().align_offset(BLOB_ALIGNMENT);
    for offset in [0, 1, 2, 4, 8, 16, 32, 63] {
        let bytes = &mut bytes[start + offset..][..blob.len()];
        bytes.copy_from_slice(&blob);
        let error = (offset != 0).then_some(Error::Misaligned { alignment: 64 });
        assert_eq!(SceneBlob::open(bytes).err(), error);
        assert_eq!(Scene::over_bytes(bytes).err(), error);
        assert_eq!(Scene::from_bytes(bytes).unwrap().to_bytes().unwrap(), blob);
    }
}
