//! A tree as bytes, traced where they lie: `cargo run -p halfdome-kernel --example blob`.

use glam::{Vec3, vec3};
use halfdome_kernel::{BuildOptions, Bvh, BvhView, Error, Ray};

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
    Ok(())
}
