//! A tree and a scene as bytes, traced in place: `cargo run -p halfdome-kernel --example blob`.

use std::sync::Arc;

use glam::{Affine3A, Vec3, vec3};
use halfdome_kernel::{BuildOptions, Bvh, BvhView, Error, Item, Ray, Scene, SceneView};

/// What another program wrote, at an address that suits it; on a microcontroller this stays in flash.
static TRIANGLE: &[u8] = halfdome_kernel::include_blob!("../src/bvh/blob/triangle.bvh");

fn main() -> Result<(), Error> {
    // In a file it would be read through a memory map, which begins at a page.
    let triangles = [[vec3(-1.0, -1.0, 0.0), vec3(1.0, -1.0, 0.0), vec3(0.0, 1.0, 0.0)]];
    let (bvh, _) = Bvh::build(&triangles, &BuildOptions::default())?;
    let blob = bvh.to_bytes();
    println!("the tree takes {} bytes", blob.len());

    let ray = Ray::new(vec3(0.0, 0.0, 3.0), Vec3::NEG_Z);
    for bytes in [&blob[..], TRIANGLE] {
        let tree = BvhView::from_bytes(bytes)?;
        println!("{:?}", tree.intersect(&ray));
    }

    let truncated = BvhView::from_bytes(&blob[..100]).expect_err("most of it is missing");
    println!("{truncated}");

    // A scene of the triangle twice, which is in the blob once. Items need memory, which the program gives.
    let triangle = Arc::new(bvh);
    let behind = Affine3A::from_scale_rotation_translation(Vec3::splat(4.0), Default::default(), Vec3::NEG_Z);
    let items = vec![Item::new(triangle.clone()), Item::new(triangle).placed(&behind)?];
    let (scene, _) = Scene::build(items, &BuildOptions::default())?;
    let blob = scene.to_bytes()?;
    println!("the scene takes {} bytes", blob.len());
    let mut items = [const { Item::nothing() }; 2];
    let scene = SceneView::from_bytes(&blob, &mut items)?;
    for x in [0.0, 2.0] {
        println!("{:?}", scene.intersect(&Ray::new(vec3(x, 0.0, 3.0), Vec3::NEG_Z).into()));
    }
    Ok(())
}
