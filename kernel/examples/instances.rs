//! An engine's loop: ten thousand instances of a ball of a million triangles, a thousand of which move each frame, some
//! come and some go; then the camera's rays are traced. `cargo run --release -p halfdome-kernel --example instances --
//! full`. Without `full`, a hundredth of both.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;
use std::time::Instant;

use glam::{Affine3A, Quat, Vec3, vec3};
use halfdome_kernel::scene::{Handle, Item, Scene, SceneHit, SceneRay};
use halfdome_kernel::{Bvh, Error, Quality, Ray, Triangle};

/// What an engine keeps: it borrows nothing, and may be a resource of any thread.
struct World {
    scene: Scene<'static>,
    /// The handles of what is in the scene, and the index of each.
    objects: Vec<(Handle, usize)>,
    ball: Arc<Bvh>,
    side: usize,
}

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

/// Where an object is in a frame.
fn place(object: usize, frame: usize, side: usize) -> Affine3A {
    let jump = (0.3 * (frame + object) as f32).sin().abs();
    let position = vec3((object % side) as f32, (object / side) as f32, 0.5 * jump) * 2.2;
    let turn = Quat::from_axis_angle(vec3(1.0, object as f32, 3.0).normalize(), (object + frame) as f32);
    Affine3A::from_scale_rotation_translation(Vec3::splat(0.6 + 0.4 * (object % 7) as f32 / 6.0), turn, position)
}

impl World {
    fn new(rings: usize, side: usize) -> Result<Self, Error> {
        let (ball, _) = Bvh::build(&ball(rings), &Quality::High.into())?;
        let mut world =
            Self { scene: Scene::new(Quality::Fast.into()), objects: Vec::new(), ball: Arc::new(ball), side };
        for object in 0..side * side {
            world.insert(object, 0)?;
        }
        world.scene.commit()?;
        Ok(world)
    }

    fn insert(&mut self, object: usize, frame: usize) -> Result<(), Error> {
        let item = Item::new(self.ball.clone()).placed(&place(object, frame, self.side))?;
        self.objects.push((self.scene.insert(item)?, object));
        Ok(())
    }

    /// One frame of the game.
    fn advance(&mut self, frame: usize) -> Result<(), Error> {
        for &(handle, object) in self.objects.iter().skip(frame % 10).step_by(10) {
            self.scene.set_transform(handle, &place(object, frame, self.side))?;
        }
        // Every fifth frame one leaves and comes back elsewhere.
        if frame.is_multiple_of(5) {
            let (handle, object) = self.objects.swap_remove(frame * 31 % self.objects.len());
            self.scene.remove(handle)?;
            self.insert(object, frame)?;
        }
        let commit = self.scene.commit()?;
        assert!(commit.seen == self.side * self.side && self.scene.is_committed());
        Ok(())
    }
}

fn main() -> Result<(), Error> {
    let full = std::env::args().any(|argument| argument == "full");
    let (rings, side, pixels, frames) = if full { (708, 100, 512, 60) } else { (71, 10, 128, 10) };
    let start = Instant::now();
    let mut world = World::new(rings, side)?;
    let build_time = start.elapsed();

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
    let (mut advancing, mut tracing, mut checksum) = (0.0, 0.0, 0u32);
    for frame in 1..=frames {
        let start = Instant::now();
        world.advance(frame)?;
        advancing += start.elapsed().as_secs_f64();
        let start = Instant::now();
        world.scene.view().intersect_many(&rays, &mut hits);
        tracing += start.elapsed().as_secs_f64();
        checksum = hits.iter().filter(|hit| hit.is_hit()).fold(checksum, |sum, hit| {
            sum.rotate_left(5) ^ hit.hit.t.to_bits() ^ hit.hit.prim_id.rotate_left(16) ^ hit.item
        });
    }
    let triangles = 2 * rings * rings;
    println!("{} instances of {triangles} triangles: {} in all", side * side, side * side * triangles);
    println!(
        "{} bytes for the triangles, {} for the scene",
        world.ball.statistics().memory_bytes,
        world.scene.memory_bytes()
    );
    let found = hits.iter().filter(|hit| hit.is_hit()).count();
    println!("{found} of {} rays hit in the last of {frames} frames, checksum {checksum:08x}", hits.len());
    let each = |time: f64| 1e3 * time / frames as f64;
    eprintln!(
        "built in {build_time:.2?}; a frame: {:.2} ms to advance, {:.2} ms to trace",
        each(advancing),
        each(tracing)
    );
    Ok(())
}
