//! Blobs of any bytes, and blobs that were right before bytes of theirs were changed, with the right checksum
//! nevertheless: refused, or traced to the hits of the triangles that they hold. Blobs of scenes likewise, against the
//! loops.
#![no_main]

use std::sync::{Arc, LazyLock};

use glam::{Affine3A, Vec3};
use halfdome_fuzz::Bytes;
use halfdome_fuzz::check::isas;
use halfdome_kernel::bvh::{BLOB_ALIGNMENT, Blob, WIDTH};
use halfdome_kernel::geometry::intersect_triangle;
use halfdome_kernel::scene::SceneBlob;
use halfdome_kernel::traverse::reference;
use halfdome_kernel::{
    Bvh, BvhView, Error, Hit, HitPacket, Item, Ray, RayPacket, Scene, SceneRay, SceneView, Triangle,
};
use libfuzzer_sys::fuzz_target;

/// What the changed blobs were: of no, one and many triangles.
static ORIGINALS: LazyLock<[Blob; 3]> = LazyLock::new(|| {
    [0, 1, 150].map(|count| {
        let triangle = |i: u32| {
            let at = Vec3::new((i * 37 % 101) as f32, (i * 53 % 89) as f32, (i * 71 % 97) as f32) * 0.1;
            [at, at + Vec3::X, at + Vec3::new(0.3, 0.4, 0.5)]
        };
        let triangles: Vec<Triangle> = (0..count).map(triangle).collect();
        Bvh::build(&triangles, &Default::default()).expect("there are few").0.to_bytes()
    })
});

/// A scene of a mesh twice, once moving, in a scene, twice.
static SCENE: LazyLock<Blob> = LazyLock::new(|| {
    let triangles = [[Vec3::ZERO, Vec3::X, Vec3::Y], [Vec3::Z, Vec3::X, Vec3::Y]];
    let mesh = Arc::new(Bvh::build(&triangles, &Default::default()).expect("there are few").0);
    let at = |x: f32| Affine3A::from_translation(Vec3::X * x);
    let moving = Item::new(mesh.clone()).moving_shared([at(1.0), at(2.0)].into()).expect("it has an inverse");
    let inner = Arc::new(Scene::build(vec![Item::new(mesh), moving], &Default::default()).expect("there are few").0);
    let placed = Item::new(inner.clone()).placed(&at(5.0)).expect("it has an inverse");
    let outer = Scene::build(vec![Item::new(inner), Item::nothing(), placed], &Default::default());
    outer.expect("there are few").0.to_bytes().expect("it has no shapes")
});

fuzz_target!(|data: &[u8]| {
    let mut bytes = Bytes(data);
    match bytes.below(6) {
        4 => {
            let mut memory = vec![0; bytes.0.len() + 2 * BLOB_ALIGNMENT];
            let start = memory.as_ptr().align_offset(BLOB_ALIGNMENT);
            let place = &mut memory[start..][..bytes.0.len()];
            place.copy_from_slice(bytes.0);
            trace_scene(place, &mut Bytes(data));
        }
        5 => {
            let mut blob = SCENE.clone();
            change(&mut blob, &mut bytes);
            trace_scene(&blob, &mut bytes);
        }
        0 => {
            // At an address that suits it, and beside.
            let mut memory = vec![0; bytes.0.len() + 2 * BLOB_ALIGNMENT];
            let start = memory.as_ptr().align_offset(BLOB_ALIGNMENT);
            for offset in [0, 4] {
                let place = &mut memory[start + offset..][..bytes.0.len()];
                place.copy_from_slice(bytes.0);
                if let Ok(tree) = BvhView::from_bytes(place) {
                    trace(&tree, &mut Bytes(data));
                }
            }
        }
        kind => {
            let mut blob = ORIGINALS[kind - 1].clone();
            change(&mut blob, &mut bytes);
            let (borrowed, owned) = (BvhView::from_bytes(&blob), Bvh::from_bytes(&blob));
            assert_eq!(borrowed.is_ok(), owned.is_ok());
            match (borrowed, owned) {
                (Ok(tree), Ok(owned)) => {
                    assert!(owned.to_bytes() == blob);
                    owned.statistics();
                    trace(&tree, &mut bytes);
                }
                (Err(error), _) => assert!(!error.to_string().is_empty()),
                _ => {}
            }
        }
    }
});

/// Changes words of a blob, as most changes of one byte are uninteresting, and updates the checksum.
fn change(blob: &mut Blob, bytes: &mut Bytes) {
    for _ in 0..1 + bytes.below(8) {
        let offset = bytes.below(blob.len() / 4) * 4;
        let word = if bytes.byte() & 1 == 0 { bytes.word() } else { u32::from(bytes.byte()) };
        blob[offset..][..4].copy_from_slice(&word.to_ne_bytes());
    }
    let mut crc = crc32fast::Hasher::new();
    crc.update(&blob[..60]);
    crc.update(&blob[64..]);
    blob[60..64].copy_from_slice(&crc.finalize().to_ne_bytes());
}

/// Opens a scene in place and loads it: both, or neither; and traces both.
fn trace_scene(blob: &[u8], bytes: &mut Bytes) {
    // Two triangles may have one index by now, so that weights may be of either.
    let first = |scene: &SceneView, ray: &SceneRay| {
        scene.intersect(ray).map(|hit| (hit.hit.t, hit.hit.prim_id, hit.item, hit.path))
    };
    let loaded = Scene::from_bytes(blob);
    let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let rays: Vec<SceneRay> = bytes.rays(&[triangle], 8).into_iter().map(SceneRay::new).collect();
    let opened = in_place(blob, |scene| {
        let expected = scene.with_isa(halfdome_kernel::Isa::SCALAR);
        rays.iter().map(|ray| (first(scene, ray), first(&expected, ray))).collect::<Vec<_>>()
    });
    match (opened, loaded) {
        (Some(Ok(hits)), Ok(loaded)) => {
            for (ray, (found, expected)) in rays.iter().zip(hits) {
                assert_eq!(found, expected, "{ray:?}");
                assert_eq!(found, first(&loaded.view(), ray), "{ray:?}");
            }
        }
        (Some(Err(error)), Err(other)) => assert_eq!(error, other),
        // More scenes than are opened here.
        (None, _) => {}
        (Some(opened), loaded) => panic!("{:?}, {:?}", opened.err(), loaded.err()),
    }
}

/// What `look` says of the scene in a blob of one or two scenes; `None` of one of more.
fn in_place<T>(bytes: &[u8], look: impl FnOnce(&SceneView) -> T) -> Option<Result<T, Error>> {
    let blob = match SceneBlob::open(bytes) {
        Ok(blob) => blob,
        Err(error) => return Some(Err(error)),
    };
    let room = |scene: usize| vec![Item::nothing(); blob.item_count(scene).unwrap_or_default()];
    let mut items = room(0);
    let first = match blob.view(0, &mut items, &[]) {
        Ok(first) => first,
        Err(error) => return Some(Err(error)),
    };
    match blob.scene_count() {
        1 => Some(Ok(look(&first))),
        2 => {
            let inner = [first];
            let mut items = room(1);
            Some(blob.view(1, &mut items, &inner).map(|scene| look(&scene)))
        }
        _ => None,
    }
}

/// Two triangles may have one index by now, so that weights may be of either.
fn trace(tree: &BvhView, bytes: &mut Bytes) {
    let lanes =
        tree.blocks().iter().flat_map(|block| (0..WIDTH).map(move |lane| (block.triangle(lane), block.prim_id[lane])));
    let triangles: Vec<(Triangle, u32)> = lanes.filter(|&(_, id)| id != Hit::NO_PRIM).collect();
    let targets: Vec<Triangle> = triangles.iter().map(|&(triangle, _)| triangle).collect();
    let rays = bytes.rays(&targets, 8);
    let first = |ray: &Ray| {
        let hits =
            triangles.iter().filter_map(|(triangle, id)| intersect_triangle(ray, triangle).map(|hit| (hit.t, *id)));
        hits.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    };
    let expected: Vec<Option<(f32, u32)>> = rays.iter().map(first).collect();
    let found = |hit: Option<Hit>| hit.filter(Hit::is_hit).map(|hit| (hit.t, hit.prim_id));
    let batch: Vec<Ray> = rays.iter().copied().cycle().take(70).collect();
    for isa in isas() {
        let tree = tree.with_isa(isa);
        let mut hits = vec![Hit::MISS; batch.len()];
        tree.intersect_many(&batch, &mut hits);
        assert!(hits.iter().zip(expected.iter().cycle()).all(|(&hit, &expected)| found(Some(hit)) == expected));
        let packet = RayPacket::<16>::from_rays(&rays);
        let mut hits = HitPacket::MISS;
        tree.intersect_packet(&packet, &mut hits);
        for (lane, (ray, &expected)) in rays.iter().zip(&expected).enumerate() {
            assert_eq!(found(tree.intersect(ray)), expected, "{ray:?}");
            assert_eq!(found(reference::intersect(&tree, ray)), expected, "{ray:?}");
            assert_eq!(found(Some(hits.hit(lane))), expected, "{ray:?}");
            assert_eq!(tree.occluded(ray), expected.is_some(), "{ray:?}");
        }
    }
}
