//! Custom spheres among triangles, drawn as a PGM picture: `cargo run --release -p halfdome-kernel --example spheres >
//! spheres.pgm`.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec3, vec3};
use halfdome_kernel::scene::{Item, Scene, SceneHit, SceneRay, Shape, Spheres};
use halfdome_kernel::{Aabb, Bvh, Error, Hit, Quality, Ray, Sphere, triangle_normal};

/// Spheres with a hole from top to bottom: any rule of the caller's makes a shape.
struct Beads<'a>(Spheres<'a>);

impl Shape for Beads<'_> {
    fn count(&self) -> u32 {
        self.0.count()
    }

    fn bounds(&self, prim_id: u32) -> Aabb {
        self.0.bounds(prim_id)
    }

    fn intersect(&self, prim_id: u32, ray: &Ray, time: f32) -> Option<Hit> {
        let sphere = self.0.0[prim_id as usize];
        let is_whole = |hit: &Hit| (ray.at(hit.t) - sphere.center).truncate().length() > 0.35 * sphere.radius;
        let first = self.0.intersect(prim_id, ray, time)?;
        // Through the hole, on the inside.
        let behind = Ray { t_min: first.t.next_up(), ..*ray };
        Some(first).filter(is_whole).or_else(|| self.0.intersect(prim_id, &behind, time).filter(is_whole))
    }
}

fn main() -> Result<(), Error> {
    let ring = |count: usize, distance: f32, radius: f32| {
        (0..count).map(move |i| {
            let (sin, cos) = (i as f32 / count as f32 * TAU).sin_cos();
            Sphere { center: vec3(cos, sin, 0.0) * distance, radius }
        })
    };
    let beads: Vec<Sphere> = ring(7, 2.2, 0.8).collect();
    let balls: Vec<Sphere> = ring(16, 3.9, 0.5).chain([Sphere { center: Vec3::ZERO, radius: 1.0 }]).collect();
    let (beads, balls) = (Beads(Spheres(&beads)), Spheres(&balls));
    let corner = |x: f32, y: f32| vec3(x, y, -1.0) * vec3(6.0, 6.0, 1.0);
    let floor = [
        [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)],
        [corner(-1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
    ];
    let (mesh, _) = Bvh::build(&floor, &Quality::High.into())?;
    let lower = Affine3A::from_translation(vec3(0.0, 0.0, -0.5));
    let items = vec![Item::new(mesh.view()), Item::new(&beads), Item::new(&balls).placed(&lower)?];
    let (scene, _) = Scene::build(items, &Quality::High.into())?;
    let scene = scene.view();

    let (width, height) = (320, 200);
    let rays: Vec<SceneRay> = (0..width * height)
        .map(|i| {
            let (x, y) = ((i % width) as f32 / width as f32 - 0.5, 0.5 - (i / width) as f32 / height as f32);
            Ray::new(vec3(0.0, -10.0, 8.5), vec3(x * 1.1, 1.0, -0.9) + vec3(0.0, 0.67, 0.74) * y * 0.7).into()
        })
        .collect();
    let mut hits = vec![SceneHit::MISS; rays.len()];
    scene.intersect_many(&rays, &mut hits);

    println!("P2 {width} {height} 255");
    let light = vec3(-0.5, -0.4, 0.77);
    for (ray, found) in rays.iter().zip(&hits) {
        let point = ray.ray.at(found.hit.t);
        let prim = found.hit.prim_id as usize;
        let normal = match found.item {
            0 => triangle_normal(&floor[prim]),
            1 => (point - beads.0.0[prim].center).normalize(),
            2 => (point - balls.0[prim].center - vec3(0.0, 0.0, -0.5)).normalize(),
            _ => Vec3::ZERO,
        };
        let normal = if normal.dot(ray.ray.direction) > 0.0 { -normal } else { normal };
        let is_lit = found.is_hit() && !scene.occluded(&Ray::new(point + normal * 1e-3, light).into());
        let shade = if is_lit { 0.15 + 0.85 * normal.dot(light).max(0.0) } else { 0.15 * f32::from(found.is_hit()) };
        println!("{}", (shade * 255.0) as u8);
    }
    Ok(())
}
