//! The echo of a clap in a room: rays from the source, reflected by the walls in batches, recorded by a spherical
//! listener. `cargo run --release -p halfdome-kernel --example audio`

use glam::{Vec3, Vec3Swizzles, vec3};
use halfdome_kernel::sampling::Stream;
use halfdome_kernel::sampling::warp::{UniformSphere, Warp};
use halfdome_kernel::{BuildOptions, Bvh, Error, Hit, Ray, Triangle, offset_origin, triangle_normal};

const RAYS: u32 = 50_000;
const REFLECTIONS: usize = 60;
/// The part of the energy that each reflection keeps.
const REFLECTED: f32 = 0.85;
/// In metres a second.
const SPEED_OF_SOUND: f32 = 343.0;
/// The width of a bar of the histogram, in seconds.
const BAR: f32 = 0.01;

/// The inside of a box with a corner at zero.
fn room(size: Vec3) -> Vec<Triangle> {
    let corner = |i: usize| size * vec3((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32);
    let walls = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let quads = walls.map(|wall| wall.map(corner));
    quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect()
}

fn main() -> Result<(), Error> {
    let size = vec3(12.0, 8.0, 3.5);
    let walls = room(size);
    let normals: Vec<Vec3> = walls.iter().map(triangle_normal).collect();
    let (bvh, _) = Bvh::build(&walls, &BuildOptions::default())?;
    let (source, listener, radius) = (vec3(2.0, 2.0, 1.5), vec3(9.0, 5.5, 1.7), 0.5);

    let from_source = |i: u32| Ray::new(source, UniformSphere.map(Stream::new(0, 0, i).uniform2(0)));
    let mut rays: Vec<Ray> = (0..RAYS).map(from_source).collect();
    let mut travelled = vec![0.0f32; rays.len()];
    let mut hits = vec![Hit::MISS; rays.len()];
    let mut response = [0.0f32; 40];
    let mut energy = 1.0 / RAYS as f32;
    for _ in 0..REFLECTIONS {
        bvh.view().intersect_many(&rays, &mut hits);
        for ((ray, hit), travelled) in rays.iter_mut().zip(&hits).zip(&mut travelled) {
            // Heard on the way, if it passes through the ball.
            let along = (listener - ray.origin).dot(ray.direction);
            if along > 0.0 && along < hit.t && ray.at(along).distance(listener) < radius {
                let bar = ((*travelled + along) / (SPEED_OF_SOUND * BAR)) as usize;
                if let Some(bar) = response.get_mut(bar) {
                    *bar += energy;
                }
            }
            // Reflected as by a mirror.
            let wall = hit.prim_id as usize;
            let direction = ray.direction.reflect(normals[wall]);
            *travelled += hit.t;
            *ray = Ray::new(offset_origin(&walls[wall], normals[wall], hit.u, hit.v, direction), direction);
        }
        energy *= REFLECTED;
    }

    println!("  ms      dB");
    let loudest = response.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
    for (i, heard) in response.into_iter().enumerate() {
        let decibels = 10.0 * (heard / loudest).log10();
        println!("{:4.0} {decibels:7.1} {}", 1e3 * BAR * i as f32, "#".repeat((decibels + 45.0).max(0.0) as usize));
    }
    let (volume, area) = (size.element_product(), 2.0 * size.dot(size.zxy()));
    let time = 24.0 * 10.0f32.ln() * volume / (SPEED_OF_SOUND * -REFLECTED.ln() * area);
    println!("by Eyring's formula the sound is 60 dB lower after {:.0} ms", 1e3 * time);
    Ok(())
}
