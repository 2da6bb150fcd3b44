//! Ten thousand instances of a ball of a million triangles, which share its memory:
//! `cargo run --release -p halfdome-kernel --example instances -- full`. Without `full`, a hundredth of both.

use std::f32::consts::{PI, TAU};
use std::time::Instant;

use glam::{Affine3A, Quat, Vec3, vec3};
use halfdome_kernel::scene::{Item, Scene, SceneHit, SceneRay};
use halfdome_kernel::{Bvh, Error, Quality, Ray, Triangle};

/// A bumpy ball of about `2 * rings * rings` triangles.
fn ball(rings: usize) -> Vec<Triangle> {
    let point = |i: usize, j: usize| {
        let (latitude, longitude) = (i as f32 / rings as f32 * PI, j as f32 / rings as f32 * TAU);
        let (ring, height) = latitude.sin_cos();
        vec3(ring * longitude.cos(), ring * longitude.sin(), height) * (1.0 + 0.03 * (9.0 * longitude).sin() * ring)
    };
    let quad =
        |i: usize, j: usize| [point(i, j), point(i + 1, j), point(i + 1, (j + 1) % rings), point(i, (j + 1) % rings)];
    let quads = (0..rings).flat_map(|i| (0..rings).map(move |j| (i, j)));
    quads.map(|(i, j)| quad(i, j)).flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
}

fn main() -> Result<(), Error> {
    let full = std::env::args().any(|argument| argument == "full");
    let (rings, side, pixels) = if full { (708, 100, 512) } else { (71, 10, 128) };

    let start = Instant::now();
    let triangles = ball(rings);
    let (mesh, _) = Bvh::build(&triangles, &Quality::High.into())?;
    let mesh_time = start.elapsed();

    let start = Instant::now();
    let places = (0..side * side).map(|i| {
        let position = vec3((i % side) as f32, (i / side) as f32, 0.0) * 2.2;
        let turn = Quat::from_axis_angle(vec3(1.0, i as f32, 3.0).normalize(), i as f32);
        Affine3A::from_scale_rotation_translation(Vec3::splat(0.6 + 0.4 * (i % 7) as f32 / 6.0), turn, position)
    });
    let items: Vec<Item> = places.map(|place| Item::new(mesh.view()).placed(&place)).collect::<Result<_, Error>>()?;
    let (scene, report) = Scene::build(items, &Quality::High.into())?;
    let scene_time = start.elapsed();

    // A camera above a corner.
    let size = side as f32 * 2.2;
    let (eye, middle) = (vec3(-0.1, -0.2, 0.3) * size, vec3(0.5, 0.5, 0.0) * size);
    let forward = (middle - eye).normalize();
    let right = forward.cross(Vec3::Z).normalize();
    let up = right.cross(forward);
    let rays: Vec<SceneRay> = (0..pixels * pixels)
        .map(|i| {
            let at = |i: usize| (i as f32 + 0.5) / pixels as f32 * 1.4 - 0.7;
            Ray::new(eye, forward + right * at(i % pixels) - up * at(i / pixels)).into()
        })
        .collect();
    let mut hits = vec![SceneHit::MISS; rays.len()];
    let start = Instant::now();
    scene.view().intersect_many(&rays, &mut hits);
    let trace_time = start.elapsed();

    println!("{} instances of {} triangles: {} in all", report.kept, triangles.len(), report.kept * triangles.len());
    println!("{} bytes for the triangles, {} for the scene", mesh.statistics().bytes, scene.bytes());
    let checksum = hits.iter().filter(|hit| hit.is_hit()).fold(0u32, |sum, hit| {
        sum.rotate_left(5) ^ hit.hit.t.to_bits() ^ hit.hit.prim_id.rotate_left(16) ^ hit.geometry_id
    });
    println!("{} of {} rays hit, checksum {checksum:08x}", hits.iter().filter(|hit| hit.is_hit()).count(), hits.len());
    eprintln!("built in {mesh_time:.2?} and {scene_time:.2?}, traced in {trace_time:.2?}");
    Ok(())
}
